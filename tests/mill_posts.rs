//! Programs of posts for mills: what `fix` writes is the program, and `verify` accepts it. The machines have no errors and round zero offsets.

use std::fs;

use crate::support::Shop;

/// A machine of the cases, in machine coordinates that can be added up by hand.
fn machine(name: &str) -> String {
    let path = format!("{}/tests/cases/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    fs::read_to_string(path).unwrap()
}

/// Corrects a program with further options, verifies the result and returns its text.
fn corrected(machine: &str, file: &str, program: &str, options: &[&str]) -> String {
    let out = format!("out_{file}");
    let shop = Shop::new().file("m.toml", machine).file(file, program);
    let arguments = [&["fix", file, "-o", out.as_str(), "--machine", "m.toml"], options].concat();
    shop.run(arguments).exits(0);
    shop.run(["verify", file, out.as_str(), "--machine", "m.toml"]).exits(0);
    shop.text(&out)
}

/// The depth words of the lines with a cycle in force: one for each hole.
fn holes(text: &str, depth: &str) -> usize {
    text.lines().filter(|line| line.split_whitespace().any(|word| word.trim_end_matches('.') == depth)).count()
}

/// A tap that ends at R has no move before the next one at its place: all repeats are written. R is 20 − 18 = 2, the bottom 2 − 7 = −5.
#[test]
fn repeats_of_a_tap_at_one_place_are_all_written() {
    let drilled = |controller: &str, count: char| {
        let machine = machine("fanuc").replace("controller = \"fanuc\"", &format!("controller = \"{controller}\""));
        for code in ["G74", "G84", "G85", "G81"] {
            for level in ["G98", "G99"] {
                for (mode, place) in [("G90", "X100. Y100. Z-5. R2."), ("G91", "X0. Y0. Z-7. R-18.")] {
                    let program = format!(
                        "O1\nT1 M06\nG21 G90 G54 G00 X100. Y100.\nG43 H01 Z20.\nS500 M3\n{mode}\n{level} {code} {place} {count}3 F500.\nG80\nG90\nM30\n"
                    );
                    for options in [&[][..], &["--expand-cycles"]] {
                        let text = corrected(&machine, "repeat.nc", &program, options);
                        assert_eq!(holes(&text, "Z-5"), 3, "{program}{options:?}\n{text}");
                    }
                }
            }
        }
    };
    drilled("fanuc", 'K');
    drilled("haas", 'L');
}

/// The pattern of a Haas: four holes at different places, and each is one hole.
#[test]
fn taps_of_a_pattern_are_one_for_each_place() {
    let machine = machine("haas");
    for level in ["G98", "G99"] {
        let program = format!(
            "O1\nT1 M06\nG21 G90 G54 G00 X100. Y100.\nG43 H01 Z20.\nS500 M3\n{level} G84 Z-5. R2. F500. L0\nG70 I20. J15. L4\nG80\nM30\n"
        );
        let text = corrected(&machine, "pattern.nc", &program, &["--expand-cycles"]);
        assert_eq!(holes(&text, "Z-5"), 4, "{text}");
    }
}

/// An edge before the tool is loaded has no effect until M6: the original is executed like the program that `fix` wrote. Z is −1 + 100 of tool 1.
#[test]
fn an_edge_before_the_first_tool_change_verifies() {
    let machine = machine("sinumerik");
    let head = "G17 G90 G94 G710 G40 G54\n";
    let cut = "S3000 M3 F500\nG0 X0 Y0 Z5\nG1 Z-1\nG0 Z50\nM30\n";
    for start in ["T1 D1\nM6\n", "SUPA G0 X0 Y0 D1\nT1\nM6\nD1\n", "D1\nT1\nM6\n", "G0 X20 Y30 D1\nT1 M6\n"] {
        let program = format!("{head}{start}{cut}");
        corrected(&machine, "edge.mpf", &program, &[]);
        let shop = Shop::new().file("m.toml", machine.as_str()).file("edge.mpf", program);
        let moves = shop.run(["snc", "edge.mpf", "--machine", "m.toml"]).exits(0).stdout;
        assert!(moves.lines().any(|line| line.starts_with("G1 X100 Y0 Z-1 ")), "{moves}");
    }
    // A move along the tool before M6 needs the length, in both commands.
    let program = format!("{head}D1\nG0 Z5\nT1 M6\n{cut}");
    let shop = Shop::new().file("m.toml", machine).file("edge.mpf", program.as_str()).file("same.mpf", program.as_str());
    shop.run(["check", "edge.mpf", "--machine", "m.toml"]).says("E0307");
    shop.run(["verify", "edge.mpf", "same.mpf", "--machine", "m.toml"]).exits(4).says("E0307");
}
