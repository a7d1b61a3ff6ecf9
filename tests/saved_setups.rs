//! `--setup` with files that controls save: LinuxCNC, Grbl, Fanuc, Heidenhain, Haas.

use crate::support::Shop;

fn machine(controller: &str, control: &str) -> String {
    let mut text = format!(
        "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"{controller}\"\n\n[control]\n{control}\n"
    );
    for (letter, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
        text += &format!("\n[axis.{letter}]\ndirection = {direction}\ntravel_mm = [-1000, 1000]\n");
    }
    text
}

fn shown(controller: &str, control: &str, name: &str, saved: &str) -> crate::support::Run {
    let shop = Shop::new().file("m.toml", machine(controller, control)).file(name, saved);
    shop.run(["machine", "show", "m.toml", "--setup", name])
}

/// A variable file in the layout of the LinuxCNC manual, with own numbers.
const VARIABLES: &str = "5161\t0.000000\n5210\t0.000000\n5211\t0.000000\n5220\t1.000000\n5221\t100.000000\n5222\t50.000000\n\
                         5223\t-20.000000\n5230\t0.500000\n5241\t1.000000\n";

#[test]
fn variables_of_linuxcnc() {
    let run = shown("rs274", "saved_unit = \"mm\"", "mill.var", VARIABLES).exits(0);
    assert!(run.stdout.contains("G54   X100 Y50 Z-20 rotated 0 0 0.5 deg"), "{}", run.stdout);
    assert!(run.stdout.contains("G55   X1 Y0 Z0"), "{}", run.stdout);
    // 100 inches are 2540 mm.
    let run = shown("rs274", "saved_unit = \"inch\"", "mill.var", VARIABLES).exits(0);
    assert!(run.stdout.contains("G54   X2540 Y1270 Z-508"), "{}", run.stdout);
    shown("rs274", "", "mill.var", VARIABLES).exits(4).says("LinuxCNC variable file").says("saved_unit");
    let shifted = VARIABLES.replace("5210\t0.0", "5210\t1.0").replace("5211\t0.0", "5211\t7.0");
    shown("rs274", "saved_unit = \"mm\"", "mill.var", &shifted).exits(4).says("G92.1");
    shown("sinumerik", "", "mill.var", VARIABLES).exits(4).says("controller = \"rs274\"");
    // The lines of one system, copied by hand.
    for part in ["5221\t100.000000\n5222\t50.000000\n5223\t-20.000000\n", "; G54\n5221 100\n5222 50\n5223 -20\n"] {
        let run = shown("rs274", "saved_unit = \"mm\"", "g54.var", part).exits(0);
        assert!(run.stdout.contains("G54   X100 Y50 Z-20"), "{}", run.stdout);
    }
    // Other numbers are no variables.
    shown("rs274", "saved_unit = \"mm\"", "list.var", "1 100\n2 50\n3 -20\n").exits(4);
    // A system without one variable is not stated; one with some of its axes may be cut off.
    let run = shown("rs274", "saved_unit = \"mm\"", "mill.var", &VARIABLES.replace("5223\t-20.000000\n", "")).exits(0);
    let run = run.says("warning[W0404]").says("G54 gives X and Y but not Z, which counts as 0").says("add 5223");
    assert!(!run.stdout.contains("G56"), "{}", run.stdout);
}

#[test]
fn a_zero_table_of_a_grundig_that_lacks_an_axis_is_reported() {
    let run = shown("grundig", "", "zero.zo", "%ZO\nG54 X1 Y2 Z3\nG55 X1 Z3\n").exits(0);
    let run = run.says("warning[W0404]").says("G55 gives X and Z but not Y, which counts as 0").says("zero.zo:3");
    assert!(!run.stderr.contains("G54"), "{}", run.stderr);
}

#[test]
fn tools_of_linuxcnc_have_diameters() {
    let table = "; my tools\nT1 P1 Z+50.25 D6.5 ;end mill\nT12 P3 X1 Y2 Z30 D3\n";
    let run = shown("rs274", "saved_unit = \"mm\"", "tool.tbl", table).exits(0);
    let row =
        |number: &str| run.stdout.lines().find(|line| line.starts_with(&format!("{number} "))).unwrap().to_owned();
    assert_eq!(row("1").split_whitespace().collect::<Vec<_>>(), ["1", "1", "50.25", "3.25"]);
    assert_eq!(row("12").split_whitespace().collect::<Vec<_>>(), ["12", "1", "30", "1.5"]);
}

#[test]
fn offsets_of_grbl() {
    let report = "[G54:-250.000,-120.500,0.000]\n[G55:1.000,2.000,3.000]\n[G28:0.000,0.000,0.000]\n[G92:0.000,0.000,0.000]\n[TLO:0.000]\n\
                  [PRB:0.000,0.000,0.000:0]\nok\n";
    let run = shown("grbl", "", "offsets.txt", report).exits(0);
    assert!(run.stdout.contains("G54   X-250 Y-120.5 Z0") && run.stdout.contains("G55   X1 Y2 Z3"), "{}", run.stdout);
    let run = shown("grbl", "", "offsets.txt", &format!("$13=1\n{}", report.replace("-250.000", "-10.000"))).exits(0);
    assert!(run.stdout.contains("G54   X-254 "), "{}", run.stdout);
    shown("grbl", "", "o.txt", &report.replace("TLO:0.000", "TLO:5.000"))
        .exits(4)
        .says("Grbl offsets ($#)")
        .says("TLO");
    let tool = format!("[T:3|0.000,0.000,42.000|1.500|6,0,0|mill|0]\n{report}");
    assert!(shown("grbl", "", "o.txt", &tool).exits(0).stdout.contains("42           1.5"));
    let run = shown("grbl", "", "o.txt", &report.replace("-120.500,0.000]", "-120.500]")).exits(0);
    run.says("warning[W0404]").says("G54 gives X and Y but not Z, which counts as 0").says("cut off");
}

/// G28 and G30 go to positions that the control keeps (Grbl: `$#`; LinuxCNC: parameters 5161 and 5181 on). Without its file, the machine zero is assumed and said.
#[test]
fn positions_of_g28_and_g30_come_from_the_control() {
    let program = "G21 G90 G17 G54\nG0 X0 Y0 Z0\nG1 X10 F500\nG30\nM2\n";
    let zero = "[zero_offset.G54]\nX_mm = 10\nY_mm = 10\nZ_mm = -20\nset = \"absolute\"\n";
    let [mill, linuxcnc] =
        [("grbl", ""), ("linuxcnc", "saved_unit = \"mm\"")].map(|(name, control)| machine(name, control) + zero);
    let report = "[G54:10.000,10.000,-20.000]\n[G28:1.000,2.000,0.000]\n[G30:30.500,25.000,-10.000]\n[G92:0.000,0.000,0.000]\nok\n";
    let table = "5181 30.5\n5182 25\n5183 -10\n5220 1\n5221 10\n5222 10\n5223 -20\n";
    let shop = Shop::new().file("m.toml", &mill).file("p.ngc", program).file("o.txt", report).file("l.var", table);
    let shop = shop.file("l.toml", linuxcnc);
    for (file, setup) in [("m.toml", "o.txt"), ("l.toml", "l.var")] {
        let run = shop.run(["fix", "p.ngc", "-o", "out.ngc", "--machine", file, "--setup", setup]).exits(0);
        assert!(!run.stderr.contains("position of G30"), "{}", run.stderr);
        let text = shop.text("out.ngc");
        let home = text.lines().find(|line| line.contains("G53")).unwrap_or_else(|| panic!("{text}"));
        assert!(home.contains("X30.5") && home.contains("Y25") && home.contains("Z-10"), "{home}");
    }
    let run = shop.run(["fix", "p.ngc", "-o", "none.ngc", "--machine", "m.toml"]).exits(0);
    run.says("warning[W0240]").says("no file states the position of G30").says("p.ngc:4");
    // X of the position is stated, Z is not: it counts for a block that moves Z alone.
    let stated = format!("{mill}\n[system]\n\"#5181\" = 30.5\n\"#5182\" = 25.0\n");
    for (block, axes) in [("G30 Z0", "G30 in Z:"), ("G91 G30 X0 Y0\nG90", ""), ("G30", "G30 in Z:")] {
        let shop = Shop::new().file("m.toml", &stated).file("p.ngc", program.replace("G30", block));
        let run = shop.run(["fix", "p.ngc", "-o", "none.ngc", "--machine", "m.toml"]).exits(0);
        assert_eq!(run.stderr.contains("position of G30"), !axes.is_empty(), "{block}: {}", run.stderr);
        assert!(run.stderr.contains(axes), "{block}: {}", run.stderr);
    }
}

#[test]
fn offsets_of_a_fanuc() {
    let punched = "%\nG21\nG10 L2 P0 X0. Y0. Z-1.\nG10L2P1X-250.Y-120.5Z0.\nG10 L20 P3 X5. Y6. Z7.\nG10 L10 P1 R120.5\nG10 L11 P1 R-0.5\n\
                   G10 L12 P1 R5.\nG10 L13 P1 R0.02\n#500=12.5\n#501=\nG10 L50\nN1240 P1 R5\nG11\nM30\n%\n";
    let run = shown("fanuc", "", "offsets.txt", punched).exits(0);
    for text in ["EXT      X0 Y0 Z-1", "G54      X-250 Y-120.5 Z0", "G54.1 P3 X5 Y6 Z7"] {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
    // 120.5 − 0.5 and 5 + 0.02.
    assert!(run.stdout.contains("1     1     120          5.02"), "{}", run.stdout);
    shown("fanuc", "", "o.txt", &punched.replace("G21\n", "")).exits(4).says("saved_unit");
    shown("fanuc", "", "o.txt", &punched.replace("X-250.", "X-250000")).exits(4).says("no decimal point");
    // G10 leaves an axis that it does not name: without a value in the machine file, nothing is known of it.
    let without = punched.replace("Y-120.5Z0.", "Y-120.5");
    shown("fanuc", "", "o.txt", &without).exits(0).says("W0404").says("G54 gives X and Y but not Z");
    let stated = "[zero_offset.G54]\nX_mm = 1\nY_mm = 2\nZ_mm = -300\n";
    let run = shown("fanuc", stated, "o.txt", &without).exits(0);
    assert!(run.stdout.contains("G54      X-250 Y-120.5 Z-300"), "{}", run.stdout);
    // It may be the value of another job.
    run.says("warning[W0404]").says("G54 gives X and Y but not Z, which keeps its value of an earlier file");
    // An offset of no linear axis is not known.
    let with_table = machine("fanuc", "").replace("wFXYZSt", "wAFXYZSt")
        + "\n[axis.A]\ndirection = [1, 0, 0]\npoint_mm = [0, 0, 0]\nmodulo = true\n";
    let shop = Shop::new()
        .file("m.toml", with_table)
        .file("a.txt", "%\nG21\nG10 L2 P1 A90.\n%\n")
        .file("b.txt", "%\nG21\nG10 L2 P1 X1. Y2. Z3.\n%\n");
    let run = shop.run(["machine", "show", "m.toml", "--setup", "a.txt"]).exits(0);
    assert!(!run.stdout.contains("G54   "), "{}", run.stdout);
    // A later file with the linear axes keeps it.
    let run = shop.run(["machine", "show", "m.toml", "--setup", "a.txt", "--setup", "b.txt"]).exits(0);
    assert!(run.stdout.contains("G54   X1 Y2 Z3 A90"), "{}", run.stdout);
    // A program that moves is still a program.
    shown("fanuc", "", "o.nc", "%\nO1\nG10 L2 P1 X1. Y2. Z3.\nG0 X0.\nM30\n%\n").exits(3);
}

#[test]
fn an_offset_of_an_axis_that_the_machine_lacks_is_refused() {
    let variables = VARIABLES.replace("5223\t", "5225\t30.0\n5223\t");
    let grbl = "[G54:1.000,2.000,3.000,0.000,30.000]\n[G55:1.000,2.000,3.000]\n[TLO:0.000]\nok\n";
    let unit = "saved_unit = \"mm\"";
    for (controller, control, saved) in [
        ("fanuc", "", "%\nG21\nG10 L2 P1 X1. Y2. Z3. B30.\n%\n"),
        ("fanuc", "", "%\nG21\nG10 L2 P1 B30.\n%\n"),
        ("haas", "", "%\nG21\nG10 L20 P1 X1. Y2. Z3. B30.\n%\n"),
        ("rs274", unit, &variables),
        ("grbl", "", grbl),
        ("grundig", "", "%ZO\nG54 X1 Y2 Z3 B30\n"),
        ("sinumerik", "", "%_N_A_UFR\n$P_UIFR[1,B,TR]=30\nM17\n"),
    ] {
        let name = if controller == "sinumerik" { "saved.ini" } else { "saved.txt" };
        shown(controller, control, name, saved).exits(4).says("E0309").says("has no axis B");
        // An axis at 0 shifts nothing: controls save all axes that they know.
        shown(controller, control, name, &saved.replace("30", "0")).exits(0);
        if controller == "fanuc" {
            let passed = "passed_on_axes = [\"B\"]";
            shown(controller, passed, name, saved).exits(0);
        }
    }
}

#[test]
fn tools_of_a_heidenhain_are_read_by_their_columns() {
    let table = "BEGIN TOOL.T MM\nT     NAME             L          R        DL       DR\n0\n5     MILL 10          +120.5     +5       -0.5     +0.01\n\
                 7     DRILL            +80        +3\n[END]\n";
    let run = shown("sinumerik", "", "TOOL.T", table).exits(0);
    // 120.5 − 0.5 and 5 + 0.01; the name has a blank.
    assert!(run.stdout.contains("5     1     120          5.01     MILL 10"), "{}", run.stdout);
    assert!(run.stdout.contains("7     1     80           3        DRILL"), "{}", run.stdout);
    let presets = "BEGIN PRESET.PR MM\nNO   DOC   X   Y   Z\n1          +10 +20 +30\n[END]\n";
    shown("sinumerik", "", "PRESET.PR", presets).exits(4).says("Heidenhain table").says("presets");
}

/// A file that was cut off, or in which one value stands twice, has a value that the control does not have.
#[test]
fn a_cut_or_contradictory_file_is_refused() {
    let cut = "BEGIN TOOL.T MM\nT     NAME             L          R        DL       DR\n5     MILL             +10";
    shown("sinumerik", "", "TOOL.T", cut).exits(4).says("[END]");
    let unit = "saved_unit = \"mm\"";
    let table = |second: &str| format!("T1 P1 Z80.25 D6 ;mill\nT1 P2 Z{second} D6\n");
    shown("rs274", unit, "tool.tbl", &table("10")).exits(4).says("two different values of tool 1");
    shown("rs274", unit, "tool.tbl", &table("80.25")).exits(0);
    let variables = |second: &str| VARIABLES.to_owned() + &format!("5221\t{second}\n");
    shown("rs274", unit, "mill.var", &variables("-7.5")).exits(4).says("second, different value of 5221");
    let grbl = "[G54:-10.000,-5.000,-1.000]\n[G54:-20.000,-5.000,-1.000]\n";
    shown("rs274", unit, "grbl.txt", grbl).exits(4).says("two different values of G54");
}

#[test]
fn numbered_blocks_of_a_haas_are_named() {
    shown("haas", "", "off.txt", "%\nN0 V123456\nN1 V1000\nN2 V2000\n%\n")
        .exits(4)
        .says("Haas settings")
        .says("G10 L2");
}
