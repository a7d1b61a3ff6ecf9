//! Tells the compiler where the language tables are: `grammars/` at the top of the project. A package contains nothing above its folder, except the copy that
//! `cargo package` makes of the link `grammars` beside this file. A system without such links needs the folder at the top.

use std::path::Path;

fn main() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let top = own.join("../../grammars");
    let folder = if top.is_dir() { top } else { own.join("grammars") };
    println!("cargo::rustc-env=NCFIX_GRAMMARS={}", folder.display());
    println!("cargo::rerun-if-changed=build.rs");
}
