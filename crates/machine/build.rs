//! Says where the demo machine stands: among the samples of the project. A package has nothing of what stands above its folder, but a copy that `cargo package`
//! makes of the link `demo.toml` beside this file. A system without such links needs the sample.

use std::path::Path;

fn main() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sample = own.join("../../samples/machines/demo.toml");
    let file = if sample.is_file() { sample } else { own.join("demo.toml") };
    println!("cargo::rustc-env=NCFIX_DEMO={}", file.display());
    println!("cargo::rerun-if-changed=build.rs");
}
