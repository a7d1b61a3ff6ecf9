//! `ncfix machine check` and `ncfix machine show`.

use crate::support::{Shop, machine};

#[test]
fn sample_machines_have_no_errors() {
    for name in ["demo", "esmaeili_xyz5", "esmaeili_huron"] {
        let run = Shop::new().run(["machine", "check", &machine(name)]).exits(0);
        assert!(!run.stderr.contains("error"), "{}", run.stderr);
    }
}

#[test]
fn a_machine_is_shown() {
    let run = Shop::new().run(["machine", "show", &machine("esmaeili_xyz5")]).exits(0);
    for text in ["wCBXFZYSt", "zero offset", "errors"] {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
}

#[test]
fn faults_of_a_machine_file_have_their_place() {
    let shop = Shop::new().file(
        "m.toml",
        "[machine]\nname = \"m\"\ntopology = \"wFXt\"\ncolour = 3\n\n[axis.X]\ndirection = [1, 0, 0]\n",
    );
    let run = shop.run(["machine", "check", "m.toml"]).exits(4);
    run.says("error[E0402]").says("m.toml:4:1");
}

#[test]
fn a_controller_must_be_a_dialect() {
    let text = "[machine]\nname = \"m\"\ntopology = \"wFXt\"\ncontroller = \"latin\"\n\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 1]\n";
    Shop::new().file("m.toml", text).run(["machine", "check", "m.toml"]).exits(4).says("'latin'");
}

#[test]
fn a_set_up_file_brings_offsets_and_tools() {
    let setup = "[zero_offset.G54]\nX_mm = 123.5\nY_mm = 1\nZ_mm = 2\n";
    let shop = Shop::new().file("s.toml", setup);
    let run = shop.run(["machine", "show", &machine("demo"), "--setup", "s.toml"]).exits(0);
    assert!(run.stdout.contains("G54   X123.5 Y1 Z2"), "{}", run.stdout);
}
