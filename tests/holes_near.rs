//! Holes whose cycles a correction keeps or expands: `verify` follows them also where holes are near each other, or R rises from hole to hole.

use crate::support::{Run, Shop};

/// A machine whose Z leans towards X by 40 µrad, and whose X is 50 µm/m too long.
fn leaning(controller: &str) -> String {
    let mut text = format!(
        "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"{controller}\"\n[control]\nincrement_mm = 0.001\n"
    );
    for (axis, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
        text += &format!("[axis.{axis}]\ndirection = {direction}\ntravel_mm = [-900, 900]\n");
    }
    text + "[[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n\
            [zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n\
            [location]\nEC0Y = 50.0\nEB0Z = 40.0\n\
            [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 5e-5]\n"
}

/// The lines of a program around its holes.
fn program(controller: &str, holes: &str) -> String {
    let begin = match controller {
        "fanuc" => "%\nO1\nG21 G17 G90 G40 G49 G80 G94\nT1 M6\nG54 G0 X10. Y10. S1000 M3\nG43 Z50. H1\n",
        _ => "G21 G90 G17 G94 G54\nT1 M6\nG43 H1\nG0 Z50 S1000 M3\nG0 X10 Y10\n",
    };
    let end = if controller == "fanuc" { "M30\n%\n" } else { "M2\n" };
    format!("{begin}{holes}G80\nG0 Z50.\n{end}")
}

/// Corrects and verifies; returns the output, and the run of the comparison.
fn follow(controller: &str, holes: &str, options: &[&str]) -> (String, Run) {
    let shop = Shop::new().file("m.toml", leaning(controller)).file("in.nc", program(controller, holes));
    let fix = ["fix", "in.nc", "-o", "out.nc", "--machine", "m.toml"];
    shop.run(fix.iter().chain(options)).exits(0);
    (shop.text("out.nc"), shop.run(["verify", "in.nc", "out.nc", "--machine", "m.toml"]))
}

/// Holes 0.8 mm and 0.5 mm apart: such a move is longer than any correction, but not by much.
#[test]
fn a_short_way_to_the_next_hole_is_a_move_of_both_programs() {
    for controller in ["rs274", "fanuc"] {
        let holes = "G99 G81 X20. Y20. Z-10. R2. F200.\nX20.8\nX21.1 Y20.4\n";
        for options in [&[][..], &["--expand-cycles"], &["--hole-tolerance", "50um"]] {
            let (text, verified) = follow(controller, holes, options);
            let is_kept = text.contains("G81");
            assert_eq!(is_kept, options != ["--expand-cycles"], "{text}");
            assert!(!verified.exits(0).stderr.contains("E03"), "{controller} {options:?}");
        }
    }
}

/// A hole that is not drilled is found, even if it is near another one.
#[test]
fn a_missing_hole_near_another_one_is_found() {
    let shop = Shop::new().file("m.toml", leaning("rs274"));
    let all = "G99 G81 X20. Y20. Z-10. R2. F200.\nX20.8\nX40.\n";
    let shop = shop.file("in.nc", program("rs274", all));
    shop.run(["fix", "in.nc", "-o", "out.nc", "--machine", "m.toml", "--expand-cycles"]).exits(0);
    let text = shop.text("out.nc");
    let lines: Vec<&str> = text.lines().collect();
    let at = lines.iter().position(|line| line.contains("X20.8")).unwrap();
    let without: Vec<&str> = lines[..at].iter().chain(&lines[at + 3..]).copied().collect();
    let shop = shop.file("cut.nc", without.join("\n") + "\n");
    shop.run(["verify", "in.nc", "cut.nc", "--machine", "m.toml"]).exits(4).says("E0311");
}

/// R rises to 5 mm after a deep hole that becomes moves. LinuxCNC goes up on its way to the hole; in the first hole of its cycles it goes up before.
#[test]
fn a_rise_on_the_way_to_a_hole_stays_on_the_way() {
    let holes = "G99 G81 X20 Y20 Z-80 R2 F200\nX30 Y20 Z-80\nX40 Z-10 R5\nX50\n";
    for tolerance in ["0.5um", "1um", "1.5um", "2um"] {
        let (text, verified) = follow("rs274", holes, &["--hole-tolerance", tolerance]);
        assert!(text.contains("Z-80"), "{text}");
        assert!(!verified.exits(0).stderr.contains("E03"), "{tolerance}: {text}");
    }
    // Nothing is expanded: the rise stays one of the cycle.
    let (text, verified) = follow("rs274", holes, &["--hole-tolerance", "50um"]);
    assert!(text.contains("R5") && !text.contains("G61"), "{text}");
    verified.exits(0);
}
