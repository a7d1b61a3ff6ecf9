//! The figures of `fix`, `verify` and `diff` about one correction agree: they evaluate both programs at equal places.

use std::fmt::Write as _;

use serde_json::Value;

use crate::support::{Shop, machine};

/// Three axes with errors and, in X and Y, lost motion. The zero is not touched, so that the errors are those of the machine.
const LOOSE: &str = "[machine]\nname = \"loose\"\ntopology = \"wFXYZt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-10, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-10, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 200]\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 5e-5, 3e-7]\n\
    [[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0, 0, 2e-7]\n\
    [[motion]]\ncomponent = \"EZY\"\nkind = \"polynomial\"\ncoefficients = [0, 0, 1e-7]\n";
const BACKLASH: &str = "[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 20\n\
    [[motion]]\ncomponent = \"EYY\"\nkind = \"backlash\"\nvalue_um = 9\n";
const UNCERTAIN: &str = "[uncertainty]\nunexplained_um = 0.5\n";

/// Lines, arcs and reversals of all lengths.
fn contour() -> String {
    let mut out = "N10 G17 G90 G71 G94\nN20 G0 X20 Y20 Z50\nN30 G1 Z-5 F500\n".to_owned();
    out += "G1 X300\nY220\nX20\nY20\nG2 X120 Y20 I50 J0\nG3 X20 Y20 I-50 J0\nG1 X60 Y60\n";
    for k in 0..60 {
        let along = f64::from(k);
        let _ = writeln!(
            out,
            "X{:.3} Y{:.3} Z{:.3}",
            60.0 + 1.7 * along,
            60.0 + 9.0 * (0.3 * along).sin(),
            -5.0 - 0.05 * along
        );
    }
    for k in 0..200 {
        let along = f64::from(k);
        let _ = writeln!(out, "X{:.3} Y{:.3}", 160.0 - 0.12 * along, 70.0 + 0.4 * (0.2 * along).cos());
    }
    out += "G0 Z50\nG0 X300 Y300\nG1 Z-2\nX100 Y480\nG0 Z100\nM30\n";
    out
}

/// The results of `fix`, `verify` and `diff` in this order.
fn results(shop: &Shop, name: &str, more: &[&str]) -> [Value; 3] {
    let fix = [&[name, "-o", "out.mpf", "--json", "--max-correction", "1mm"], more].concat();
    let fixed = shop.run(fix).exits(0).json();
    let verified = shop.run([&["verify", name, "out.mpf", "--json"], more].concat()).json();
    let different = shop.run([&["diff", name, "out.mpf", "--json"], more].concat()).json();
    [fixed, verified, different]
}

/// Checks that the three agree within 0.01 µm, and gives the largest error before and after.
#[track_caller]
fn agree(all: &[Value; 3]) -> [f64; 2] {
    let [fixed, others @ ..] = all;
    for other in others {
        for side in ["before", "before_form", "after"] {
            for figure in ["mean_um", "rms_um", "max_um"] {
                let [one, two] = [fixed, other].map(|json| json[side][figure].as_f64().unwrap());
                assert!((one - two).abs() < 0.01, "{side} {figure}: {one} {two}");
            }
        }
        for side in ["before", "after"] {
            for figure in ["mean_um", "rms_um", "max_um"] {
                let of = |json: &Value, end: usize| json["prediction"][side][figure][end].as_f64();
                for end in [0, 1] {
                    let (one, two) = (of(fixed, end), of(other, end));
                    let is_same =
                        one.zip(two).map_or(one.is_none() && two.is_none(), |(one, two)| (one - two).abs() < 0.01);
                    assert!(is_same, "interval {side} {figure} {end}: {one:?} {two:?}");
                }
            }
        }
        assert_eq!(fixed["zeros"], other["zeros"]);
        assert_eq!(fixed["coverage"], other["coverage"]);
    }
    ["before", "after"].map(|side| fixed[side]["max_um"].as_f64().unwrap())
}

#[test]
fn the_three_agree_with_and_without_backlash() {
    // A Sinumerik with MD10200 = 1000 rounds what it reads to one micrometer: the output has no more digits.
    let increments = ["increment_mm = 0.001", "increment_mm = 0.0001", "increments_per_mm = 1000"];
    for (backlash, increment) in [("", 0), ("", 1), ("", 2), (BACKLASH, 0), (BACKLASH, 1), (BACKLASH, 2)] {
        let control = format!("[control]\n{}\n", increments[increment]);
        let machine = format!("{LOOSE}{backlash}{control}{UNCERTAIN}");
        let shop = Shop::new().file("m.toml", machine).file("in.mpf", contour());
        let [before, after] = agree(&results(&shop, "in.mpf", &["--machine", "m.toml"]));
        assert!(before > 40.0 && after < 25.0, "{before} {after}");
    }
}

#[test]
fn the_three_agree_on_the_samples() {
    for (name, at) in [
        ("sinumerik/bolt_circle.mpf", "demo"),
        ("sinumerik/seal_groove.mpf", "demo"),
        ("sinumerik/slots.mpf", "demo"),
        ("sinumerik/saddle.mpf", "demo"),
        ("fanuc/fine_bores.nc", "vmc"),
        // Five axes: the tool turns on its way, and stands in a swiveled plane.
        ("sinumerik/swarf.mpf", "esmaeili_huron"),
        ("sinumerik/three_plus_two.mpf", "esmaeili_xyz5"),
    ] {
        let shop = Shop::new().copy(&format!("samples/programs/{name}"));
        let own = name.rsplit('/').next().unwrap();
        agree(&results(&shop, own, &["--machine", &machine(at)]));
    }
}

/// Rapid moves count in a program without a cut.
#[test]
fn the_three_agree_on_rapid_moves() {
    let text = "N10 G17 G90 G71 G94\nN20 G0 X20 Y20 Z50\nN30 G0 X300\nN40 G0 Y300 Z20\nN50 G0 X50\nN60 M30\n";
    for backlash in ["", BACKLASH] {
        let shop = Shop::new().file("m.toml", format!("{LOOSE}{backlash}")).file("in.mpf", text);
        agree(&results(&shop, "in.mpf", &["--machine", "m.toml"]));
    }
}

/// A correction is evaluated on its own machine, or not at all.
#[test]
fn a_corrected_program_finds_its_own_machine() {
    let text = "N10 G17 G90 G71 G94\nN20 G0 X20 Y20 Z50\nN30 G1 X300 F500\nN40 M30\n";
    let shop =
        Shop::new().file("m.toml", LOOSE).file("other.toml", LOOSE.replace("loose", "tight")).file("in.mpf", text);
    shop.run(["in.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let named = shop.run(["verify", "in.mpf", "out.mpf", "--machine", "m.toml", "--json"]).exits(0).json();
    let found = shop.run(["verify", "in.mpf", "out.mpf", "--json"]).exits(0).json();
    assert_eq!(named, found);
    let flat = shop.run(["snc", "out.mpf"]).exits(0);
    assert!(flat.stdout.starts_with("; snc 1 machine=loose "), "{}", flat.stdout);
    let shop = shop.file("flat.snc", &flat.stdout);
    let again = shop.run(["snc", "flat.snc"]).exits(0);
    assert_eq!(again.stdout, flat.stdout);
    // The file has changed since: its checksum is another one, the name is not.
    let shop = shop.file("m.toml", LOOSE.replace("5e-5", "6e-5"));
    for words in [&["verify", "in.mpf", "out.mpf"][..], &["diff", "in.mpf", "out.mpf"], &["snc", "out.mpf"]] {
        shop.run(words).exits(4).says("error[E0323]").says("out.mpf was made for the machine file with the checksum");
    }
    shop.run(["snc", "flat.snc"]).exits(0);
    let shop = shop.file("m.toml", LOOSE.replace("loose", "tight"));
    shop.run(["snc", "flat.snc"]).exits(4).says("E0323").says("the machine loose");
    let nearest = shop.file("ncfix.toml", LOOSE);
    nearest.run(["verify", "in.mpf", "out.mpf"]).exits(0);
    nearest.run(["snc", "flat.snc"]).exits(0);
}
