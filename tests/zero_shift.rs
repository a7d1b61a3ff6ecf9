//! `ncfix fix --zero-shift`: drift that is the same over the part becomes a shift of the zero offset.

use crate::support::Shop;

/// A machine whose spindle nose rises by 3 µm/K and moves by −2 µm/K along X.
fn machine(controller: &str, more: &str) -> String {
    let number = if controller == "sinumerik" { "G54" } else { "G55" };
    format!(
        "[machine]\nname = \"mill\"\ntopology = \"wXYFZSt\"\ncontroller = \"{controller}\"\n\
         [control]\nincrement_mm = 0.001\nsaved_unit = \"mm\"\n\
         [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [-400, 400]\n\
         [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-400, 400]\n\
         [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-400, 400]\n\
         [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n\
         [zero_offset.{number}]\nX_mm = 100\nY_mm = 50\nZ_mm = -20.5\n\
         [[tool]]\nnumber = 1\nlength_mm = 100\n\
         [[drift]]\ndirection = \"Z\"\nsensors = [{{ name = \"T_head\", um_per_K = 3.0 }}]\n\
         [[drift]]\ndirection = \"X\"\nsensors = [{{ name = \"T_head\", um_per_K = -2.0 }}]\n{more}"
    )
}

const MPF: &str = "T1 M6\nD1\nG54 G90 G0 X0 Y0 Z50\nG1 Z0 F500\nG1 X60 Y10\nG3 X80 Y30 CR=20\nG0 Z50\nM30\n";
const FANUC: &str = "%\nO1\nT1 M6\nG90 G55 G0 X0. Y0.\nG43 H1 Z50.\nG1 Z0. F500\nG1 X60. Y10.\nG0 Z50.\nM30\n%\n";

fn shop(controller: &str, program: &str, more: &str) -> Shop {
    Shop::new()
        .file("m.toml", machine(controller, more))
        .file("part.mpf", program)
        .file("warm.toml", "[temperature_C]\nT_head = 30\n")
}

fn shift<'a>(output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let first = ["fix", "part.mpf", "--machine", "m.toml", "--state", "warm.toml", "--zero-shift", output];
    first.into_iter().chain(more.iter().copied()).collect()
}

/// 10 K: the tool is 30 µm too high and 20 µm too far to −X, seen from the workpiece. So Z must go 30 µm down. The table carries the workpiece to −X when the
/// X command grows: the tool then is farther to +X on the workpiece, so X grows by 20 µm. 100 + 0.020 and −20.5 − 0.030.
#[test]
fn a_drift_that_is_the_same_everywhere_is_a_new_zero() {
    let shop = shop("sinumerik", MPF, "");
    shop.run(shift("NEW.INI", &[])).exits(0).says("X+0.0200 Y+0.0000 Z-0.0300 mm, added to G54");
    let text = shop.text("NEW.INI");
    for line in ["$P_UIFR[1,X,TR]=100.02", "$P_UIFR[1,Y,TR]=50.0", "$P_UIFR[1,Z,TR]=-20.53"] {
        assert!(text.lines().any(|one| one == line), "{line}: {text}");
    }
    // The control with these offsets is where it must be: ncfix reads its own file as the data of the control.
    let shown = shop.run(["machine", "show", "m.toml", "--setup", "NEW.INI"]).exits(0).stdout;
    assert!(shown.contains("X100.02 Y50 Z-20.53"), "{shown}");
    // The corrected program of the warm machine and the shifted original are at the same axis positions.
    shop.run(["fix", "part.mpf", "--machine", "m.toml", "--state", "warm.toml", "-o", "warm.mpf"]).exits(0);
    let moves = |program: &str, setup: &[&str]| {
        let run = ["snc", program, "--machine", "m.toml"].into_iter().chain(setup.iter().copied());
        let text = shop.run(run.collect::<Vec<_>>()).exits(0).stdout;
        text.lines().filter(|line| line.starts_with("G1 ") || line.starts_with("G3 ")).map(position).collect::<Vec<_>>()
    };
    let [warm, shifted] = [moves("warm.mpf", &[]), moves("part.mpf", &["--setup", "NEW.INI"])];
    assert_eq!(warm.len(), shifted.len());
    for (one, other) in warm.iter().zip(&shifted) {
        assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1.5e-3), "{one:?} {other:?}");
    }
}

/// X, Y and Z of a line of the flat stream.
fn position(line: &str) -> [f64; 3] {
    ["X", "Y", "Z"].map(|letter| {
        let word = line.split_whitespace().find_map(|word| word.strip_prefix(letter));
        word.unwrap_or_else(|| panic!("{letter}: {line}")).parse().unwrap()
    })
}

#[test]
fn the_zero_of_other_controls() {
    let fanuc = shop("fanuc", FANUC, "");
    fanuc.run(shift("NEW.NC", &[])).exits(0);
    assert!(fanuc.text("NEW.NC").contains("G10 L2 P2 X100.02 Y50.0 Z-20.53"), "{}", fanuc.text("NEW.NC"));
    let linuxcnc = shop("rs274", &FANUC.replace("O1\n", ""), "");
    linuxcnc.run(shift("new.ngc", &[])).exits(0);
    assert!(linuxcnc.text("new.ngc").contains("G10 L2 P2 X100.02 Y50.0 Z-20.53"), "{}", linuxcnc.text("new.ngc"));
    // The variable file keeps everything else, byte by byte; 5241 to 5243 are G55.
    let variables = "5161\t1.500000\n5220\t2.000000\n5221\t7.000000\n5222\t8.000000\n5223\t9.000000\n5230\t0.000000\n\
                     5241\t100.000000\n5242\t50.000000\n5243\t-20.500000\n5250\t0.000000\n";
    let linuxcnc = linuxcnc.file("mill.var", variables);
    linuxcnc.run(shift("new.var", &["--setup", "mill.var"])).exits(0);
    let expected = variables.replace("100.000000", "100.020000").replace("-20.500000", "-20.530000");
    assert_eq!(linuxcnc.text("new.var"), expected);
}

/// A drift that grows along X by 0.4 µm/K from X −400 to 400 differs by 0.4 · 10 · 80/800 = 0.4 µm over the part (axis X 100 to 180), so by ± 0.2 µm; one
/// of 40 µm/K by ± 20 µm.
#[test]
fn a_drift_that_varies_over_the_part_is_refused() {
    let along = |um: f64| {
        let row = |at: i32, um: f64| {
            format!(
                "[[drift]]\ndirection = \"Y\"\nover = \"X\"\nat_mm = {at}\nsensors = [{{ name = \"T_head\", um_per_K = {um} }}]\n"
            )
        };
        row(-400, 0.0) + &row(400, um)
    };
    let shop_of = |um: f64| shop("sinumerik", MPF, &along(um));
    shop_of(0.4).run(shift("NEW.INI", &[])).exits(0).says("± 0.2");
    let shop = shop_of(40.0);
    let run = shop.run(shift("NEW.INI", &[])).exits(4);
    run.says("E0325").says("± 20").says("most along Y");
    assert!(!shop.names().contains(&"NEW.INI".to_owned()));
    shop.run(shift("NEW.INI", &["--tolerance", "25um"])).exits(0);
}

#[test]
fn what_no_shift_can_cancel_is_refused() {
    let shop = shop("sinumerik", MPF, "");
    shop.run(["fix", "part.mpf", "--machine", "m.toml", "--zero-shift", "N.INI"]).exits(2).says("--state");
    let shop = shop.file("machine.mpf", MPF.replace("G1 X60", "G53 G1 X60"));
    let of = |program: &'static str| {
        ["fix", program, "--machine", "m.toml", "--state", "warm.toml", "--zero-shift", "N.INI"]
    };
    shop.run(of("machine.mpf")).exits(2).says("machine coordinates");
    let shop = shop.file("own.mpf", MPF.replace("G54 G90", "$P_UIFR[1,X,TR]=5\nG54 G90"));
    shop.run(of("own.mpf")).exits(2).says("sets its zero offset itself");
    // A program that was corrected for the warm machine has the drift already.
    shop.run(["fix", "part.mpf", "--machine", "m.toml", "--state", "warm.toml", "-o", "warm.mpf"]).exits(0);
    shop.run(of("warm.mpf")).exits(2).says("contains a drift already");
    // One that was corrected without a state keeps its correction and gets the shift.
    let error = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n";
    let shop = shop.file("m.toml", machine("sinumerik", error));
    shop.run(["fix", "part.mpf", "--machine", "m.toml", "-o", "cold.mpf"]).exits(0);
    shop.run(of("cold.mpf")).exits(0).says("X+0.0200 Y+0.0000 Z-0.0300 mm");
    assert_eq!(shop.names().iter().filter(|name| *name == "N.INI").count(), 1);
}
