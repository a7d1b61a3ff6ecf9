//! Data that a control computes from its position: `G10 L20`, and `G10 L10` and `L11` of RS274/NGC.
//!
//! The output stands beside the place of the program, by its correction. It must state the value that this place has, and must never state a value
//! from the zero offset of the machine file: on a router that was not homed, this offset is an estimate.

use crate::support::Shop;

/// A gantry whose bridge along X rises by 0.3 mm in one meter, with the tool on it: at machine X 200 the tip is 0.06 mm too high.
fn router(zero_z_mm: f64, set: &str) -> String {
    let mut text = "[machine]\nname = \"router\"\ntopology = \"wFYXZSt\"\ncontroller = \"rs274\"\n".to_owned();
    for (axis, travel) in [("X", "[0, 600]"), ("Y", "[0, 900]"), ("Z", "[-200, 200]")] {
        let direction = ["X", "Y", "Z"].map(|other| i32::from(other == axis));
        text.push_str(&format!("[axis.{axis}]\ndirection = {direction:?}\ntravel_mm = {travel}\n"));
    }
    text.push_str("[control]\nincrement_mm = 0.001\n");
    text.push_str("[[motion]]\ncomponent = \"EZX\"\nkind = \"polynomial\"\ncoefficients = [0, 3e-4]\n");
    text.push_str(&format!("[zero_offset.G54]\nX_mm = 100\nY_mm = 100\nZ_mm = {zero_z_mm}\nset = \"{set}\"\n"));
    text.push_str("[[tool]]\nnumber = 1\nlength_mm = 50\n");
    text
}

const PART: &str = "G21 G90 G17 G54\nS12000 M3\nG0 Z10\nG0 X0 Y0\nG1 Z-1 F300\nX100 F900\nG10 L20 P1 Z0\nG0 Z10\nG0 X20 Y20\nG1 Z-2 F300\nX80\nG0 Z10 M5\nM30\n";

/// The corrected lines of a program, without comments. The output must agree with the program.
#[track_caller]
fn corrected(machine: &str, program: &str) -> Vec<String> {
    let shop = Shop::new().file("part.ngc", program).file("m.toml", machine);
    shop.run(["fix", "part.ngc", "-o", "out.ngc", "--machine", "m.toml"]).exits(0);
    shop.run(["verify", "part.ngc", "out.ngc", "--machine", "m.toml"]).exits(0);
    let text = shop.text("out.ngc");
    let words = |line: &str| line.split(';').next().unwrap_or_default().trim().to_owned();
    text.lines().map(words).filter(|line| !line.is_empty() && !line.starts_with('(')).collect()
}

fn line_with<'a>(lines: &'a [String], word: &str) -> &'a str {
    lines.iter().find(|line| line.contains(word)).unwrap_or_else(|| panic!("{word}: {lines:?}"))
}

/// The height at the end of the program, where X is 80.
fn last_cut(lines: &[String]) -> f64 {
    let line = lines.iter().rev().find(|line| line.contains('Z') && line.contains("X80")).expect("a cut to X80");
    line.split(' ').find_map(|word| word.strip_prefix('Z')).unwrap().parse().unwrap()
}

/// The program stands at Z-1, the output at X 200 of the machine: at Z-1.06, so that the same zero is there Z-0.06.
#[test]
fn the_value_of_the_corrected_place_is_written_and_no_zero_of_the_machine_file() {
    let lines = corrected(&router(-60.0, "absolute"), PART);
    assert_eq!(line_with(&lines, "G10"), "G10 L20 P1 Z-0.06");
    // Machine X 180: 0.054 mm too high.
    assert!((last_cut(&lines) + 2.054).abs() < 0.0006, "{lines:?}");
    // The ruler at the zero has no influence on any line.
    for zero_z_mm in [-100.0, -20.0] {
        assert_eq!(corrected(&router(zero_z_mm, "absolute"), PART), lines, "{zero_z_mm}");
    }
}

/// The touch at machine X 100 contains 0.03 mm of the error: at X 200 the rest is 0.03, at X 180 it is 0.024. Nothing was touched at X 200: a block to
/// Z0 there must move to where the control has computed its zero.
#[test]
fn a_zero_that_is_computed_is_not_touched() {
    let part = PART.replace("G0 Z10\nG0 X20 Y20", "G1 Z0\nG0 Z10\nG0 X20 Y20");
    let lines = corrected(&router(-60.0, "touched"), &part);
    let computed = lines.iter().position(|line| line.contains("G10")).unwrap();
    assert_eq!(lines[computed], "G10 L20 P1 Z-0.03");
    assert!(lines[computed + 1].ends_with("Z-0.03"), "{lines:?}");
    assert!((last_cut(&lines) + 2.024).abs() < 0.0006, "{lines:?}");
}

/// G92 is in the coordinates of the output: Z5 of the program is then Z-1 of G54, and its value 0 is 0 - 6 there, at the corrected place -6.06.
#[test]
fn g92_is_a_part_of_the_written_value() {
    let part = PART.replace("G10 L20", "G92 Z5\nG10 L20").replace("G1 Z-2", "G92.1\nG1 Z-2");
    assert_eq!(line_with(&corrected(&router(-60.0, "absolute"), &part), "G10"), "G10 L20 P1 Z-6.06");
}

/// An offset that is not in force gets the same values; P0 is the one in force.
#[test]
fn other_offsets_and_inches() {
    let all = PART.replace("G10 L20 P1 Z0", "G10 L20 P3 X1 Y2 Z3\nG10 L20 P0 Z0");
    let lines = corrected(&router(-60.0, "absolute"), &all);
    assert_eq!(line_with(&lines, "P3"), "G10 L20 P3 X1 Y2 Z2.94");
    assert_eq!(line_with(&lines, "P1"), "G10 L20 P1 Z-0.06");
    let inch = "G20 G90 G17 G54\nS12000 M3\nG0 Z.4\nG0 X0 Y0\nG1 Z-.1 F12\nX4 F36\nG10 L20 P1 Z0\nG0 Z.4\nG1 Z-.1 F12\nX3\nG0 Z.4 M5\nM30\n";
    // Machine X 201.6 mm: 0.06048 mm are 0.0023811 inch, in whole 0.00002 inch 0.00238.
    assert_eq!(line_with(&corrected(&router(-60.0, "absolute"), inch), "G10"), "G10 L20 P1 Z-0.00238");
}

/// The length is the height above the value: at the corrected place both are 0.06 mm lower. With L11 the zero of G59.3 counts, which only the control knows.
#[test]
fn a_tool_that_is_measured_at_its_place() {
    for word in ["L10", "L11"] {
        let part = PART.replace("G10 L20 P1 Z0", &format!("G10 {word} P1 Z5 R3"));
        let machine =
            router(-60.0, "absolute") + "[zero_offset.\"G59.3\"]\nX_mm = 0\nY_mm = 0\nZ_mm = -90\nset = \"absolute\"\n";
        assert_eq!(line_with(&corrected(&machine, &part), "G10"), format!("G10 {word} P1 Z4.94 R3"));
    }
}

/// Another zero at the control than that of the program is found by `verify`.
#[test]
fn verify_compares_the_zero_and_not_the_word() {
    let shop = Shop::new().file("part.ngc", PART).file("m.toml", router(-60.0, "absolute"));
    shop.run(["fix", "part.ngc", "-o", "out.ngc", "--machine", "m.toml"]).exits(0);
    let wrong = shop.text("out.ngc").replace("G10 L20 P1 Z-0.06", "G10 L20 P1 Z0");
    let shop = shop.file("out.ngc", wrong);
    shop.run(["verify", "part.ngc", "out.ngc", "--machine", "m.toml"]).exits(4).says("data computed from the position");
}

/// In a turned offset that is not in force, the value of Y would come from the machine file.
#[test]
fn one_axis_of_a_turned_offset_is_refused() {
    let machine =
        router(-60.0, "absolute") + "[zero_offset.G55]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nrotation_deg = [0, 0, 30]\n";
    for (word, code) in [("X0", Some("E0201")), ("Y0", Some("E0201")), ("X0 Y0", None), ("Z0", None)] {
        let part = PART.replace("G10 L20 P1 Z0", &format!("G10 L20 P2 {word}"));
        match code {
            None => assert!(line_with(&corrected(&machine, &part), "G10").starts_with("G10 L20 P2"), "{word}"),
            Some(code) => {
                let shop = Shop::new().file("part.ngc", part).file("m.toml", &machine);
                shop.run(["fix", "part.ngc", "-o", "out.ngc", "--machine", "m.toml"]).exits(3).says(code);
            }
        }
    }
}

/// A motion to a stated position would leave the place that the probe has found: the advice must not be to program one.
#[test]
fn after_a_probe_the_advice_is_to_measure_apart() {
    let probing = |controller: &str, probe: &str, block: &str, code: &str| {
        let part = format!("G21 G90 G17 G54 G94\nG0 Z10.\nG0 X0 Y0\n{probe} Z-15. F50.\n{block}\nG90 G0 Z20.\nM30\n");
        let machine = router(-60.0, "absolute").replace("rs274", controller);
        let shop = Shop::new().file("part.nc", part).file("m.toml", machine);
        let run = shop.run(["fix", "part.nc", "-o", "out.nc", "--machine", "m.toml", "--dialect", controller]);
        let run = run.exits(4).says(code).says("in a program of its own that is not corrected");
        assert!(!run.stderr.contains("program an absolute position"), "{block}: {}", run.stderr);
    };
    for block in ["G10 L20 P1 Z15.", "G92 Z15.", "G10 L10 P1 Z15.", "G91 G0 Z5."] {
        probing("rs274", "G38.2", block, "E0304");
    }
    for block in ["G92 Z15.", "G91 G0 Z5."] {
        probing("fanuc", "G31", block, "E0304");
    }
    // The result of the probing: a value in the machine file would be that of another piece.
    probing("rs274", "G38.2", "G0 Z[#5063+5]", "E0219");
    probing("fanuc", "G31", "G0 Z#5063", "E0219");
}

/// Before the first motion only the operator knows the position.
#[test]
fn a_value_for_the_position_at_the_start_is_refused() {
    let shop = Shop::new()
        .file("part.ngc", "G21 G90 G54\nG92 X0 Y0 Z0\nG0 Z10\nM30\n")
        .file("m.toml", router(-60.0, "touched"));
    let run = shop.run(["fix", "part.ngc", "-o", "out.ngc", "--machine", "m.toml"]).exits(4);
    run.says("E0304").says("in a program of its own that is not corrected");
}
