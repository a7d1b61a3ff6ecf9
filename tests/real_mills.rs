//! Programs as posts and machinists write them for mills: corrected, verified, and read again.

use crate::support::Shop;
use std::fs;

/// A machine of the cases, in machine coordinates that can be added up by hand.
fn machine(name: &str) -> String {
    let path = format!("{}/tests/cases/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    fs::read_to_string(path).unwrap()
}

/// Corrects a program and verifies the result; returns its text.
fn corrected(machine_name: &str, file: &str, program: &str) -> String {
    corrected_on(machine(machine_name), file, program)
}

/// The same on the text of a machine file.
fn corrected_on(machine: String, file: &str, program: &str) -> String {
    let out = format!("out_{file}");
    let shop = Shop::new().file("m.toml", machine).file(file, program);
    shop.run(["fix", file, "-o", out.as_str(), "--machine", "m.toml"]).exits(0);
    shop.run(["verify", file, out.as_str(), "--machine", "m.toml"]).exits(0);
    shop.text(&out)
}

/// M29 and the cycle are in force for both holes up to G80, and the comparison sees the same tapping in both programs.
#[test]
fn rigid_tapping_is_the_same_tapping_after_a_correction() {
    let program = "O1\nG21 G90 G54 G17\nT1 M6\nG43 H1 Z50.\nS500 M3\nG0 X10. Y10.\nM29 S500\nG99 G84 Z-15. R5. F500.\nX30.\nG80\n\
                   G0 Z50.\nM30\n";
    let text = corrected("fanuc", "tap.nc", program);
    assert!(text.contains("M29 S500\nG99 G84 X10. Y10. Z-15. R5. F500.\nX30.\nG80\n"), "{text}");
}

/// No moves can tap rigidly: the cycle stays one with its corrected words, also with the other holes as moves. Without M29, the comparison finds a difference.
#[test]
fn rigid_tapping_is_the_same_tapping_with_expanded_cycles() {
    let program = "O1\nG21 G90 G54 G17\nT1 M6\nG43 H1 Z50.\nS500 M3\nG0 X10. Y10.\nM29 S500\nG98 G84 X20. Y20. Z-15. R5. F500.\nX30.\nG80\n\
                   G0 Z50.\nM30\n";
    let machine = machine("fanuc");
    let shop = Shop::new().file("m.toml", machine).file("tap.nc", program);
    shop.run(["fix", "tap.nc", "-o", "out.nc", "--machine", "m.toml", "--expand-cycles"]).exits(0);
    let text = shop.text("out.nc");
    assert!(text.contains("M29 S500\nG98 G84 X20. Y20. Z-15. R5. F500.\nX30.\nG80\n"), "{text}");
    shop.run(["verify", "tap.nc", "out.nc", "--machine", "m.toml"]).exits(0);
    let shop = shop.file("other.nc", text.replacen("M29 S500\n", "", 1));
    let run = shop.run(["verify", "tap.nc", "other.nc", "--machine", "m.toml"]);
    assert!(run.code == 4 && run.stderr.contains("E0319") && run.stderr.contains("M29"), "{run:?}");
}

/// From (0, 0) about (10, 0) to (10, 10.008): the middle of the spiral is at 45 degrees, with radius 10.004.
#[test]
fn an_arc_with_two_radii_verifies_on_both_controls() {
    corrected("fanuc", "arc.nc", "O1\nG21 G90 G54 G17\nG0 X0. Y0. Z5.\nG2 X10. Y10.008 I10. J0. F500.\nM30\n");
    corrected("sinumerik", "arc.mpf", "G17 G90 G710 G54\nG0 X0 Y0 Z5\nG2 X10 Y10.008 I10 J0 F500\nM30\n");
}

/// The order of a post: tool change, edge, plane, first position in the plane without Z.
#[test]
fn a_plane_after_a_tool_change_is_corrected_and_verifies() {
    let program = "G17 G90 G94 G710 G40 G500\nT1 M6\nD1\nS3000 M3\nCYCLE800(0,\"TC1\",0,57,0,0,0,30,0,0,0,0,0,1,0,1)\nG0 X10 Y5\nZ15\n\
                   G1 Z-2 F1000\nX40\nG0 Z15\nM30\n";
    let text = corrected("five_sinumerik", "plane.mpf", program);
    assert!(text.contains("SUPA G0 A30 C0"), "{text}");
}

/// Pecks, a pattern, a pocket and an additional work offset of a Haas come out as moves that mean the same.
#[test]
fn a_program_of_a_haas_verifies() {
    let program = "O1\nG21 G90 G17 G40 G49 G80\nG28\nG154 P1\nT1 M6\nG43 H1 Z50.\nS500 M3\nG0 X50. Y40.\nG98 G83 Z-20. R2. I8. J2. K3. F150. L0\n\
                   G70 I20. J15. L4\nG80\nG0 X0. Y0. Z2.\nG13 Z-5. I8. K12. Q4. D1 F300.\nG0 Z50.\nG53 G49 Z0.\nM30\n";
    let text = corrected("haas", "haas.nc", program);
    assert!(text.contains("G154 P1"), "{text}");
    assert!(!text.contains("G70") && !text.contains("G13"), "{text}");
}

/// Beside an inner arc of 10 mm, a tool of 3 mm moves on 7 mm: a Haas reduces F600 to 420, at least to the share of its setting 44. An outer arc keeps F, and a
/// Fanuc keeps it in both. Chapter on cutter compensation of the Mill Operator's Manual.
#[test]
fn a_haas_reduces_the_feed_in_inner_arcs_only() {
    let program = |start: &str, arc: &str| {
        format!(
            "O1\nG21 G90 G17 G40 G49 G80\nT1 M6\nG54 G0 {start}\nG43 H1 Z5.\nS1000 M3\nG1 Z-1. F300.\nG41 D1 {arc}\nG40 G1 {start}\nG0 Z5.\nM30\n"
        )
    };
    let inner = program("X0. Y0.", "X10. Y-5. F600.\nY0.\nG3 X10. Y0. I-10. J0.");
    let outer = program("X25. Y5.", "X10. Y5. F600.\nY0.\nG2 X10. Y0. I-10. J0.");
    let haas = machine("haas");
    assert!(haas.contains("radius_mm = 3.0"), "{haas}");
    let limited = haas.replacen("[control]", "[control]\nleast_arc_feed_percent = 80", 1);
    for (machine, program, has, has_not) in [
        (&haas, &inner, "F420.", "F780."),
        (&limited, &inner, "F480.", "F420."),
        (&haas, &outer, "F600.", "F780."),
        (&machine("fanuc"), &inner, "F600.", "F420."),
    ] {
        let text = corrected_on(machine.clone(), "arc.nc", program);
        assert!(text.contains(has) && !text.contains(has_not), "{has}: {text}");
    }
}

/// A Fanuc and a Haas keep the unit of an earlier program, so `Z1.` could be an inch: the correction in millimeters names that.
#[test]
fn a_unit_that_the_control_keeps_is_named() {
    let program = "O1\nT1 M6\nG90 G54 G0 X0. Y0.\nG43 H1 Z1.\nG1 Z-0.1 F20.\nX4.\nG0 Z1.\nM30\n";
    for name in ["haas", "fanuc"] {
        let startup = machine(name).replacen("[control]", "[control]\nstartup_code = \"G21\"", 1);
        let shop = Shop::new().file("m.toml", machine(name)).file("s.toml", startup);
        let shop = shop.file("p.nc", program).file("u.nc", program.replace("T1 M6", "G20 T1 M6"));
        let fix = |file: &str, machine: &str| shop.run(["fix", file, "-o", "out.nc", "--machine", machine]).exits(0);
        fix("p.nc", "m.toml").says("warning[W0240]").says("p.nc:3").says("startup_code");
        for (file, machine) in [("u.nc", "m.toml"), ("p.nc", "s.toml")] {
            assert!(!fix(file, machine).stderr.contains("W0240"), "{file} {machine}");
        }
    }
}

/// A Haas names its additional work offsets G154, and so do the report, the stamp, the guard and the messages.
#[test]
fn a_haas_reads_its_own_names_of_work_offsets() {
    let program =
        "O1\nG21 G90 G17 G40 G49 G80\nT1 M6\nG154 P1 G0 X0. Y0.\nG43 H1 Z50.\nG1 Z-1. F300.\nX50. Y40.\nG0 Z50.\nM30\n";
    let haas = machine("haas").replace("EC0X = 0.0", "EC0X = 500.0");
    let shop = Shop::new().file("m.toml", haas).file("part.nc", program);
    let fix = ["fix", "part.nc", "-o", "out.nc", "--machine", "m.toml", "--guard"];
    let run = shop.run(fix).exits(0);
    // X of the offset is 100 mm, its Y 50 mm: 500 µrad over 50 mm are 25 µm, more than the tolerance.
    run.says("nothing states how G154 P1 was set")
        .says("[zero_offset.\"G154 P1\"]")
        .says("--zero \"G154 P1=touched\"")
        .says("zero         G154 P1 touched")
        .says("the control checks G154 P1, H1");
    let text = shop.text("out.nc");
    assert!(text.contains("(G154 P1 X CHANGED SINCE CORRECTION)") && !text.contains("G54.1"), "{text}");
    // The option takes this name; the stamp states it.
    let stated = fix.iter().chain(&["--zero", "G154 P1=touched"]);
    let run = shop.run(stated).exits(0);
    assert!(!run.stderr.contains("W0321"), "{}", run.stderr);
    assert!(shop.text("out.nc").contains("ZERO=G154_P1-TOUCHED"), "{}", shop.text("out.nc"));
    let unknown = fix.iter().chain(&["--zero", "G154 P9=touched"]);
    shop.run(unknown).exits(2).says("--zero G154 P9: this zero offset has no value");
}

/// The order of a post for a Haas: the table turns, then G234. At C90 the point (10, 20) of the workpiece is at (20, -10) of the machine.
#[test]
fn a_haas_turns_its_table_before_g234() {
    let program = "O1\nG21 G90 G17 G40 G49 G80\nT1 M6\nG54\nG0 A0 C90.\nG234 H1 X10. Y20. Z30.\nG1 X12. Z25. F500.\nY25. C80.\nG0 Z100.\n\
                   G49\nG53 G0 Z400.\nM30\n";
    let fanuc = machine("five_fanuc");
    let haas = fanuc
        .replace("controller = \"fanuc\"", "controller = \"haas\"")
        .replace("decimal_point = \"calculator\"\n", "");
    let text = corrected_on(haas.clone(), "tip.nc", program);
    assert!(text.contains("G234"), "{text}");
    let shop = Shop::new().file("m.toml", haas).file("tip.nc", program);
    let moves = shop.run(["snc", "tip.nc", "--machine", "m.toml"]).exits(0).stdout;
    assert!(moves.contains("X20 Y-10 Z30") && moves.contains("X20 Y-12 Z25"), "{moves}");
    // A Fanuc fixes the coordinates to the table as it stands, unless the machine file states otherwise.
    let fanuc_program = program.replace("G234", "G43.4");
    let shop = Shop::new().file("m.toml", fanuc.as_str()).file("tip.nc", fanuc_program.as_str());
    shop.run(["check", "tip.nc", "--machine", "m.toml"]).exits(3).says("E0201").says("control.tip_coordinates");
    let stated = fanuc.replace("[control]\n", "[control]\ntip_coordinates = \"table_at_zero\"\n");
    corrected_on(stated, "tip.nc", &fanuc_program);
}

/// G61.1 is the geometry compensation of a Mazak: it stays, and the moves after it are corrected.
#[test]
fn geometry_compensation_of_a_mazak_stays() {
    let program =
        "O1\nG21 G90 G54 G17\nT1 M6\nG43 H1 Z50.\nG61.1\nG0 X10. Y10.\nG1 Z-1. F300.\nX30.\nG64\nG0 Z50.\nM30\n";
    let text = corrected("fanuc", "mazak.nc", program);
    assert_eq!((text.matches("G61.1").count(), text.matches("G64").count()), (1, 1), "{text}");
}

/// Holes of a cycle that is still in force after a tool change are refused, because Z is unknown there. So the next move of X reports no large correction.
#[test]
fn a_block_that_was_not_executed_makes_no_large_correction() {
    let program = "O1\nG21 G90 G17 G94\nT1 M6\nG90 G54 G0 X5. Y5.\nG43 Z20. H1\nG98 G73 Z-5. R2. Q2. F100.\nX40. Y-30.\nG91 G28 Z0.\n\
                   T1 M6\nG90 G54 X12. Y-14.\nG43 Z20. H1\nX20. Y-5.\nG91 G28 Z0.\nM30\n";
    let shop = Shop::new().file("m.toml", machine("fanuc")).file("p.nc", program);
    let run = shop.run(["fix", "p.nc", "-o", "out.nc", "--machine", "m.toml"]);
    assert!(run.code == 4 && run.stderr.contains("E0304") && !run.stderr.contains("E0303"), "{run:?}");
}

/// Programs of hobby controls leave the first motion code or the first feed to the control: the refusal names the key, and with it they run.
#[test]
fn what_the_control_starts_with_is_a_setting() {
    let rs274 = machine("rs274");
    for (program, code, stated) in [
        ("G21 G90 G17 G54\nX0 Y0 Z5\nG1 X10 F100\nM2\n", "E0210", "G0"),
        ("G21 G90 G17 G54\nG0 X0 Y0 Z5\nG1 X10\nM2\n", "E0215", "F300"),
    ] {
        let shop = Shop::new().file("m.toml", rs274.as_str()).file("p.ngc", program);
        let run = shop.run(["check", "p.ngc", "--machine", "m.toml"]);
        assert!(run.code != 0 && run.stderr.contains(code) && run.stderr.contains("control.startup_code"), "{run:?}");
        let file = rs274.replacen("[control]\n", &format!("[control]\nstartup_code = \"{stated}\"\n"), 1);
        assert_ne!(file, rs274);
        corrected_on(file, "p.ngc", program);
    }
}

/// A plane of G7 with a contour and holes, its end, and a path of the tip on which head and table turn: the output has positions of axes, on a machine
/// with a squareness of 40 µrad.
#[test]
fn a_five_axis_program_of_a_millplus_verifies() {
    let machine = machine("five_grundig").replace("EC0X = 0.0", "EC0X = 40.0\nEA0Z = 25.0");
    let program = "%PM9001\nN9001\nN1 G17 G71 G90 G54\nN2 T1 M6\nN3 S1000 M3\nN4 G0 B0 C0\nN5 G0 X0 Y0 Z300\nN6 G93 X10 Y20 Z5\n\
                   N7 G7 A5=30 L1=1\nN8 G0 X40 Y30 Z20\nN9 G1 Z2 F1000\nN10 X60\nN11 G2 X80 Y30 I70 J30\nN12 G81 Y2 Z-10 B5 F100\n\
                   N13 G79 X10 Y10 Z0\nN14 G0 Z100\nN15 G7\nN16 G74 Z-1 L1\nN17 G7 A5=0 B5=0 C5=0 L1=1\nN18 G174\nN19 G54\n\
                   N20 G0 B-20 C0\nN21 X0 Y0 Z300\nN22 G141 L2=0 F2=15000\nN23 G0 X10 Y20 Z30\nN24 G1 X40 Y60 B-40 F800\n\
                   N25 G2 X60 Y60 I50 J60\nN26 G1 X80 C30\nN27 G40\nN28 G0 Z400\nN29 M30\n";
    let text = corrected_on(machine, "five.pm", program);
    assert!(!text.contains("G7 ") && !text.contains("G141"), "{text}");
    assert!(text.contains("G174") && text.contains("G74 Z-1 L1"), "{text}");
}
