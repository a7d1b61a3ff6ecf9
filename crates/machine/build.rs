//! Tells the compiler where the demo machine is: among the samples of the project. A package contains nothing above its folder, except the copy that `cargo
//! package` makes of the link `demo.toml` beside this file. A system without such links needs the sample.

use std::path::Path;

fn main() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sample = own.join("../../samples/machines/demo.toml");
    let file = if sample.is_file() { sample } else { own.join("demo.toml") };
    println!("cargo::rustc-env=NCFIX_DEMO={}", file.display());
    println!("cargo::rerun-if-changed=build.rs");
}
