//! Backlash of an axis that came to its place from nobody knows where.

use crate::support::Shop;

const MACHINE: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[axis.X]\ndirection = [1, 0, 0]\n\
    travel_mm = [-700, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-500, 500]\n[axis.Z]\ndirection = [0, 0, 1]\n\
    travel_mm = [-500, 500]\n[control]\nincrement_mm = 0.0001\n[[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = -6\n";

#[track_caller]
fn corrected(program: &str, more: &[&str]) -> (String, Vec<String>) {
    let shop = Shop::new().file("m.toml", MACHINE).file("p.mpf", program);
    let base = ["p.mpf", "-o", "out.mpf", "--machine", "m.toml", "--json"];
    let run = shop.run(base.iter().chain(more)).exits(0);
    (shop.text("out.mpf"), run.codes())
}

#[test]
fn the_first_cut_has_the_mean_of_both_sides_and_a_warning() {
    let program = "G0 X100 Y0 Z10\nG1 Z0 F500\nY50\nX150\nX100\nM30\n";
    // X comes from anywhere: no correction until it moves again, then half of 6 µm against the sense.
    let (text, codes) = corrected(program, &[]);
    assert!(text.contains("G0 X100 Y0 Z10"), "{text}");
    assert!(text.contains("X150.003") && text.contains("X99.997"), "{text}");
    assert_eq!(codes, ["W0308"]);
    // From where it came is given.
    for (start, first) in [("X0,Y0,Z50", "X100.003"), ("X600,Y0,Z50", "X99.997")] {
        let (text, codes) = corrected(program, &["--start", start]);
        assert!(text.contains(first), "{start}\n{text}");
        assert!(codes.is_empty(), "{codes:?}");
    }
    // Or the program decides it.
    let (text, codes) = corrected("G0 X90 Y0 Z10\nX100\nG1 Z0 F500\nY50\nM30\n", &[]);
    assert!(text.contains("X100.003"), "{text}");
    assert!(codes.is_empty(), "{codes:?}");
}

#[test]
fn a_tool_change_makes_the_side_unknown_again() {
    let program = "G0 X90 Y0 Z100\nX100\nT1 M6\nD1\nG0 X100 Y0 Z100\nG1 Z10 F500\nY50\nM30\n";
    let (_, codes) = corrected(program, &[]);
    assert_eq!(codes, ["W0308"]);
}

#[test]
fn verify_sees_it_the_same_way() {
    let shop = Shop::new().file("m.toml", MACHINE).file("p.mpf", "G0 X100 Y0 Z10\nG1 Z0 F500\nY50\nX150\nX100\nM30\n");
    shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let json = shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml", "--json"]).exits(0).json();
    assert!(json["after"]["max_um"].as_f64().unwrap() < 0.2, "{json}");
}
