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
        // A rigid tap stays a cycle: its call has the first place, and each further line one more.
        let (_, taps) = text.split_once(" G84 ").unwrap();
        let places = taps.split("G80").next().unwrap().lines().filter(|line| line.contains('X') && line.contains('Y'));
        assert_eq!(places.count(), 4, "{text}");
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
    let shop =
        Shop::new().file("m.toml", machine).file("edge.mpf", program.as_str()).file("same.mpf", program.as_str());
    shop.run(["check", "edge.mpf", "--machine", "m.toml"]).says("E0307");
    shop.run(["verify", "edge.mpf", "same.mpf", "--machine", "m.toml"]).exits(4).says("E0307");
}

/// The hundreds 1 of `_GMODE` machine, as 0 does; 2 only computes, and no strokes are known for it.
#[test]
fn slots_that_machine_are_accepted_and_those_that_compute_are_not() {
    let machine = machine("sinumerik");
    let program =
        |call: &str| format!("G17 G90 G94 G710 G40 G54\nT1 M6\nD1\nS3000 M3 F500\nG0 X0 Y0 Z20\n{call}\nG0 Z50\nM30\n");
    let long = |mode: &str| format!("LONGHOLE(20,0,2,-3,,2,40,50,40,15,0,90,200,300,3,0,0,{mode},0,0)");
    let slot1 =
        |mode: &str| format!("SLOT1(20,0,2,-3,,2,40,12,50,40,15,0,90,200,300,3,2,0,0,0,0,0,0,0,0,0,0,0,{mode},0,0)");
    let slot2 =
        |mode: &str| format!("SLOT2(20,0,2,-3,,2,40,12,50,40,30,0,90,200,300,3,2,0,0,0,0,0,0,0,0,0,{mode},0,0)");
    let pocket3 =
        |mode: &str| format!("POCKET3(20,0,2,-3,60,40,8,50,40,0,3,0,0,300,200,0,11,5,0,0,0,0,0,0,0,0,{mode},0,0)");
    let pocket4 = |mode: &str| format!("POCKET4(20,0,2,-3,20,50,40,3,0,0,300,200,0,11,5,0,0,0,0,0,0,0,{mode},0,0)");
    let shop = |call: &str| Shop::new().file("m.toml", machine.as_str()).file("slot.mpf", program(call));
    for (plain, machines, computes) in [
        (long("0"), long("100"), long("200")),
        (slot1("0"), slot1("100"), slot1("200")),
        (slot2("0"), slot2("100"), slot2("200")),
        (pocket3("0"), pocket3("11100"), pocket3("11200")),
        (pocket4("0"), pocket4("100"), pocket4("200")),
    ] {
        let moves = |call: &str| shop(call).run(["snc", "slot.mpf", "--machine", "m.toml"]).exits(0).stdout;
        assert_eq!(moves(&plain), moves(&machines), "{machines}");
        shop(&machines).run(["check", "slot.mpf", "--machine", "m.toml"]).exits(0);
        shop(&computes).run(["check", "slot.mpf", "--machine", "m.toml"]).says("E0201").says("_GMODE");
    }
}

/// The hundreds of `_AMODE` of a slot belong to the depth of a chamfer; 1 of its units makes the depth relative to the reference plane 0.
#[test]
fn the_chamfer_of_a_slot_has_its_own_depth() {
    let machine = machine("sinumerik");
    let program =
        |call: &str| format!("G17 G90 G94 G710 G40 G54\nT1 M6\nD1\nS3000 M3 F500\nG0 X0 Y0 Z20\n{call}\nG0 Z50\nM30\n");
    let shop = |call: &str| Shop::new().file("m.toml", machine.as_str()).file("slot.mpf", program(call));
    let moves = |call: &str| shop(call).run(["snc", "slot.mpf", "--machine", "m.toml"]).exits(0).stdout;
    let slot1 =
        |mode: &str| format!("SLOT1(20,0,2,-3,,2,40,12,50,40,15,0,90,200,300,3,2,0,0,0,0,0,0,0,0,0,0,0,100,0,{mode})");
    let slot2 =
        |mode: &str| format!("SLOT2(20,0,2,-3,,2,40,12,50,40,30,0,90,200,300,3,2,0,0,0,0,0,0,0,0,0,100,0,{mode})");
    for slot in [&slot1 as &dyn Fn(&str) -> String, &slot2] {
        let plain = moves(&slot("0"));
        assert!(plain.contains("Z-3"), "{plain}");
        for mode in ["1", "100", "101"] {
            assert_eq!(plain, moves(&slot(mode)), "{mode}");
        }
        for mode in ["10", "201"] {
            shop(&slot(mode)).run(["check", "slot.mpf", "--machine", "m.toml"]).says("E0201").says("_AMODE");
        }
    }
}

/// The surface of a hole without Z may be that of the hole before or the height of the tool, 0 + 2 + 8 = 10: refused after a hole, certain before one.
#[test]
fn a_hole_without_its_surface_is_refused_after_another_hole() {
    let machine = machine("grundig");
    let program = |second: &str| {
        format!(
            "%PM9001\nN9001\nN1 G17 G71 G90 G54\nN2 T1 M6\nN3 S1000 M3\nN4 G0 X0 Y0 Z50\nN5 G81 Z-15 Y2 B8 F100\nN6 G79 X10 Y10 Z0\nN7 {second}\nN8 G0 Z50\nN9 M30\n"
        )
    };
    let check = |second: &str| {
        let shop = Shop::new().file("m.toml", machine.as_str()).file("hole.pm", program(second));
        shop.run(["check", "hole.pm", "--machine", "m.toml"])
    };
    for second in ["G79 X30 Y10", "G77 X30 Y10 R20 I0 J3"] {
        let run = check(second);
        assert!(run.code != 0 && run.stderr.contains("E0228"), "{run:?}");
        assert!(run.stderr.contains("Z0") && run.stderr.contains("Z10"), "{run:?}");
    }
    check("G79 X30 Y10 Z0").exits(0);
    // The tool is at the surface of the hole before, or elsewhere by a move of the program.
    check("G0 Z20\nN71 G79 X30 Y10").exits(0);
    // All holes of a block have one surface.
    check("G0 Z20\nN71 G77 X30 Y10 R20 I0 J3").exits(0);
    let text = corrected(&machine, "hole.pm", &program("G0 Z20\nN71 G79 X30 Y10"), &[]);
    assert!(text.contains("G79 X30 Y10 Z20"), "{text}");
}

/// `I1=1` couples spindle and axis: G84 stays the cycle of the control, with its pitch and its surface.
#[test]
fn rigid_tapping_of_a_millplus_stays_a_cycle() {
    let machine = machine("grundig");
    let program = "%PM9001\nN9001\nN1 G17 G71 G90 G54\nN2 T1 M6\nN3 S500 M3\nN4 G0 X0 Y0 Z50\nN5 G84 Z-12 Y3 J1.25 I1=1\nN6 G79 X10 Y10 Z0\nN7 G79 X30 Y10 Z-2\nN8 G0 Z50\nN9 M30\n";
    let text = corrected(&machine, "tap.pm", program, &[]);
    let line = text.lines().find(|line| line.contains("G84")).unwrap_or_default();
    assert!(["Y3", "Z-12", "J1.25", "I1=1"].iter().all(|word| line.contains(word)) && !line.contains('F'), "{text}");
    assert!(text.contains("G79 X10 Y10 Z0") && text.contains("G79 X30 Y10 Z-2"), "{text}");
    assert!(!text.contains("M4") && !text.contains("G1 "), "{text}");
    // Moves cannot couple spindle and axis.
    let shop = Shop::new().file("m.toml", machine).file("tap.pm", program);
    shop.run(["fix", "tap.pm", "-o", "out.pm", "--machine", "m.toml", "--expand-cycles"]).says("E0201").says("I1=1");
}

/// A floating holder needs no coupling of spindle and axis: the cycle stays too, and moves can replace it.
#[test]
fn tapping_with_a_floating_holder_of_a_millplus_stays_a_cycle() {
    let machine = machine("grundig");
    let program = "%PM9001\nN9001\nN1 G17 G71 G90 G54\nN2 T1 M6\nN3 S500 M3\nN4 G0 X0 Y0 Z50\nN5 G84 X0.5 Z-12 Y3 J1.25\nN6 G79 X10 Y10 Z0\nN7 G79 X30 Y10 Z-2\nN8 G0 Z50\nN9 M30\n";
    let shop = Shop::new().file("m.toml", machine.as_str()).file("tap.pm", program);
    let run = shop.run(["fix", "tap.pm", "-o", "out.pm", "--machine", "m.toml"]).exits(0);
    assert!(!run.stderr.contains("W0207"), "{}", run.stderr);
    let text = shop.text("out.pm");
    let line = text.lines().find(|line| line.contains("G84")).unwrap_or_default();
    assert!(["X0.5", "Y3", "Z-12", "J1.25"].iter().all(|word| line.contains(word)) && !line.contains('F'), "{text}");
    assert!(text.contains("G79 X10 Y10 Z0") && text.contains("G79 X30 Y10 Z-2") && !text.contains("M4"), "{text}");
    shop.run(["verify", "tap.pm", "out.pm", "--machine", "m.toml"]).exits(0);
    shop.run(["fix", "tap.pm", "-o", "moves.pm", "--machine", "m.toml", "--expand-cycles"]).exits(0).says("W0207");
    assert!(shop.text("moves.pm").contains("M4"));
}

/// `G7 L1=1` ends the plane. At zero the axes cannot turn; elsewhere they may turn or not, so that X, Y and Z wait for their positions.
#[test]
fn the_end_of_a_tilted_plane_may_name_its_turn_at_zero() {
    let machine = machine("five_grundig");
    let program = |end: &str| {
        format!(
            "%PM9001\nN9001\nN1 G17 G71 G90 G54\nN2 T1 M6\nN3 S1000 M3\nN4 G0 B0 C0\nN5 G0 X0 Y0 Z300\nN6 G7 B5=30 L1=1\nN7 G0 X40 Y30 Z200\n\
             N8 G1 Z190 F500\nN9 G0 Z200\n{end}N20 G0 X5 Y6 Z200\nN21 G1 Z150 F1000\nN22 G0 Z300\nN23 M30\n"
        )
    };
    let text = corrected(&machine, "plane.pm", &program("N10 G7\nN11 G0 B0 C0\nN12 G7 L1=1\n"), &[]);
    assert!(!text.contains("L1=1"), "{text}");
    for then in ["", "N11 G7 B5=20 L1=1\n", "N11 G0 B0\n", "N11 G1 B0 C0 X5 F500\n"] {
        let shop = Shop::new();
        let shop = shop.file("m.toml", machine.as_str()).file("plane.pm", program(&format!("N10 G7 L1=1\n{then}")));
        shop.run(["check", "plane.pm", "--machine", "m.toml"]).says("E0210").says("A5=0 B5=0 C5=0");
    }
}

/// After `G7 L1=1` the program positions the rotary axes itself, or ends: the control does with them what it does in the program.
#[test]
fn the_end_of_a_tilted_plane_keeps_its_turn() {
    let machine = machine("five_grundig");
    let program = |end: &str| {
        format!(
            "%PM9001\nN9001\nN1 G17 G71 G90 G54\nN2 T1 M6\nN3 S1000 M3\nN4 G0 B0 C0\nN5 G0 X0 Y0 Z300\nN6 G7 B5=30 L1=1\nN7 G0 X40 Y30 Z200\n\
             N8 G1 Z190 F500\nN9 G0 Z200\n{end}N23 M30\n"
        )
    };
    let cut = "N20 G0 X5 Y6 Z200\nN21 G1 Z150 F1000\nN22 G0 Z300\n";
    let moves = |end: &str| {
        let shop = Shop::new().file("m.toml", machine.as_str()).file("plane.pm", program(&format!("{end}{cut}")));
        let text = shop.run(["snc", "plane.pm", "--machine", "m.toml"]).exits(0).stdout;
        text.lines()
            .filter(|line| line.starts_with("G0 ") || line.starts_with("G1 "))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(moves("N10 G7 L1=1\nN11 G0 B0 C0\n"), moves("N10 G7\nN11 G0 B0 C0\n"));
    for end in ["N10 G7 L1=1\n".to_owned(), format!("N10 G7 L1=1\nN11 G0 B0 C0\n{cut}")] {
        let text = corrected(&machine, "plane.pm", &program(&end), &[]);
        assert!(text.contains("G7 L1=1"), "{text}");
    }
}

/// Within one turn `C3=1` changes nothing, at 90 + 360 degrees it does.
#[test]
fn the_turns_of_a_table_may_be_reset_within_one_turn() {
    let machine = machine("five_grundig").replace("travel_deg = [-360, 360]", "travel_deg = [-7200, 7200]");
    let program = |degrees: &str| {
        format!(
            "%PM9001\nN9001\nN1 G17 G71 G90 G54\nN2 T1 M6\nN3 S1000 M3\nN4 G93 C3=1\nN5 G0 B0 C{degrees}\nN6 G93 C3=1\nN7 G0 X0 Y0 Z300\nN8 G1 Z250 F1000\nN9 G0 Z300\nN10 M30\n"
        )
    };
    let text = corrected(&machine, "turns.pm", &program("90"), &[]);
    // Before the first position of C it stays; after it, it has no effect.
    assert_eq!(text.matches("G93 C3=1").count(), 1, "{text}");
    for degrees in ["450", "-90", "360"] {
        let shop = Shop::new().file("m.toml", machine.as_str()).file("turns.pm", program(degrees));
        shop.run(["check", "turns.pm", "--machine", "m.toml"]).says("E0201").says("C3=1");
    }
}

/// 0.0001 inch rounds by up to 1.27 µm in each direction, 1.8 µm in the plane: no reason against a run on a machine without errors.
#[test]
fn the_rounding_of_a_program_in_inches_is_no_reason_against_it() {
    let program = "O1\nG20 G90 G54 G17\nT1 M6\nG43 H1 Z2.\nS3000 M3\nG0 X0. Y0.\nZ0.1\nG1 Z-0.05 F20.\nG41 D1 X1.2345 Y0.3333\nX2.1111 Y1.7777\n\
                   X3.3333 Y0.4321\nG3 X4.1234 Y0.2345 R0.7777\nG1 X5. Y1.\nG40 X6. Y2.\nG0 Z2.\nM30\n";
    corrected(&machine("fanuc"), "inch.nc", program, &[]);
    // Before G20 the unit of G10 is that of the program before.
    let early = program.replacen("G20", "G10 L2 P1 X-2. Y3. Z-5.\nG20", 1);
    let shop = Shop::new().file("m.toml", machine("fanuc")).file("early.nc", early);
    shop.run(["fix", "early.nc", "-o", "out.nc", "--machine", "m.toml"]).says("E0224");
    let later = program.replacen("G17\n", "G17\nG10 L2 P1 X-2. Y3. Z-5.\n", 1);
    corrected(&machine("fanuc"), "later.nc", &later, &[]);
}

/// A Haas and a Fanuc know a program by its number, whatever the name of its file. Of two files with it, none is taken.
#[test]
fn a_program_is_found_by_its_number_in_a_file_of_another_name() {
    let main = "%\nO1001\nG21 G90 G54 G17\nT1 M6\nG43 H1 Z50.\nS500 M3\nG0 X0. Y0.\nM98 P1002\nG0 Z50.\nM30\n%\n";
    let sub = "%\nO1002 (GAUGE)\nG0 X10. Y20.\nG1 Z-1. F100.\nG0 Z50.\nM99\n%\n";
    for (name, x) in [("haas", 10), ("fanuc", 110)] {
        let shop = Shop::new()
            .file("m.toml", machine(name))
            .file("main.nc", main)
            .file("gauge_tool_o1002.cnc", sub)
            .file("notes.md", "O1002\n");
        let moves = shop.run(["snc", "main.nc", "--machine", "m.toml"]).exits(0).stdout;
        assert!(moves.lines().any(|line| line.starts_with(&format!("G1 X{x} Y20 Z-1 "))), "{moves}");
        let shop = shop.file("copy.nc", sub);
        let run = shop.run(["check", "main.nc", "--machine", "m.toml"]).says("E0212");
        assert!(run.stderr.contains("copy.nc") && run.stderr.contains("gauge_tool_o1002.cnc"), "{run:?}");
        // The name of a file goes before the numbers in others.
        let shop = shop.file("O1002.NC", sub.replace("X10.", "X30."));
        let moves = shop.run(["snc", "main.nc", "--machine", "m.toml"]).exits(0).stdout;
        assert!(moves.lines().any(|line| line.starts_with(&format!("G1 X{} Y20 Z-1 ", x + 20))), "{moves}");
    }
}

/// D beside G40 is the offset of the next G41: its radius is 5 mm, so along Y0 the tool is at Y5.
#[test]
fn an_offset_number_beside_g40_stays_in_force() {
    let program = "O1\nG21\nT1 D1 G54 G90 G40 G17 G98\nM6\nG43 H1 Z50.\nS500 M3\nG0 X-20. Y-20.\nG1 Z-1. F300.\nG41 X0. Y0.\nX40.\nG40 X60. Y-20.\n\
                   G0 Z50.\nM30\n";
    corrected(&machine("fanuc"), "d.nc", program, &[]);
    let shop = Shop::new().file("m.toml", machine("fanuc")).file("d.nc", program);
    let moves = shop.run(["snc", "d.nc", "--machine", "m.toml"]).exits(0).stdout;
    assert!(moves.lines().any(|line| line.starts_with("G1 X140 Y5 Z-1 ")), "{moves}");
}

/// `G91 G28 Z1.` goes up to the reference point at the upper end, wherever Z is; down, or with a second axis, the way depends on the start.
#[test]
fn a_way_up_to_the_reference_point_needs_no_start() {
    let machine = machine("fanuc").replacen(
        "direction = [0, 0, 1]\ntravel_mm = [-5000, 5000]",
        "direction = [0, 0, 1]\ntravel_mm = [-5000, 0]",
        1,
    );
    let program = |words: &str| {
        format!(
            "O1\nG21 G90 G17 G94 G54\nG91 G28 {words}\nG90\nT1 M6\nG43 H1 Z-300.\nS500 M3\nG0 X0. Y0.\nG1 Z-310. F100.\nG0 Z-300.\nM30\n"
        )
    };
    let text = corrected(&machine, "home.nc", &program("Z1."), &[]);
    assert!(text.contains("G53 G0 Z0."), "{text}");
    for words in ["Z-1.", "X0. Z1."] {
        let shop = Shop::new().file("m.toml", machine.as_str()).file("home.nc", program(words));
        shop.run(["check", "home.nc", "--machine", "m.toml"]).says("E0304");
    }
}
