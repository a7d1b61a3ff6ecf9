//! A guard at the start of the output: the control stops if its zero offset or tool is another than that of the correction.
//!
//! The interpreter plays the control: with a machine file of other values the corrected program must end before it moves.

use crate::support::Shop;

/// A machine of three axes with a pitch error of 50 µm/m.
fn machine(control: &str, zero_x_mm: f64, length_mm: f64) -> String {
    let mut text = format!("[machine]\nname = \"guarded\"\ntopology = \"wFXYZSt\"\ncontroller = \"{control}\"\n\n");
    for axis in ["X", "Y", "Z"] {
        let direction = ["X", "Y", "Z"].map(|other| i32::from(other == axis));
        text.push_str(&format!("[axis.{axis}]\ndirection = {direction:?}\ntravel_mm = [0, 1500]\n\n"));
    }
    text.push_str("[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n\n");
    text.push_str("[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 5.0e-5]\n\n");
    for (name, x_mm) in [("G54", zero_x_mm), ("G55", 300.0)] {
        text.push_str(&format!(
            "[zero_offset.{name}]\nX_mm = {x_mm}\nY_mm = 30.25\nZ_mm = 100\nset = \"absolute\"\n\n"
        ));
    }
    for (number, length_mm) in [(2, length_mm), (3, 91.5)] {
        text.push_str(&format!("[[tool]]\nnumber = {number}\nlength_mm = {length_mm}\nradius_mm = 4.0\n\n"));
    }
    text
}

const SINUMERIK: &str =
    "; part\nN10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3\nN40 G0 X10 Y20 Z20\nN50 G1 X110 F500\nN60 M30\n";
const FANUC: &str = "%\nO0007 (PART)\nN10 G21 G17 G90 G40 G49 G80 G94 G54\nN20 T2 M6\nN30 G0 X10. Y20. S2000 M3\nN40 G43 H2 Z20.\nN50 G1 X110. F500.\nN60 M30\n%\n";
const RS274: &str = "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X10 Y20 S2000 M3\nG43 H2 Z20\nG1 X110 F500\nM2\n";

/// The flat stream of a program on a machine: its lines, and its diagnostics.
fn executed(shop: &Shop, program: &str, machine: &str) -> (String, String) {
    let run = shop.run(["snc", program, "--machine", machine]);
    (run.stdout, run.stderr)
}

fn moves(stream: &str) -> usize {
    stream.lines().filter(|line| line.starts_with("G0 ") || line.starts_with("G1 ")).count()
}

#[test]
fn another_zero_or_tool_stops_the_program_before_it_moves() {
    // The same programs in inches: a Fanuc then shows its offsets in inches, the others in the unit of the machine.
    let inch = |program: &str, from: &str, to: &str| program.replace(from, to).replace("F500", "F20");
    for (control, name, program, checks_tools) in [
        ("sinumerik", "part.mpf", SINUMERIK.to_owned(), true),
        ("fanuc", "part.nc", FANUC.to_owned(), true),
        ("haas", "part_haas.nc", FANUC.to_owned(), true),
        ("rs274", "part.ngc", RS274.to_owned(), false),
        ("sinumerik", "inch.mpf", inch(SINUMERIK, "G71", "G70").replace("X110", "X11"), true),
        ("fanuc", "inch.nc", inch(FANUC, "G21", "G20").replace("X110.", "X11."), true),
        ("rs274", "inch.ngc", inch(RS274, "G21", "G20").replace("X110", "X11"), false),
    ] {
        let shop = Shop::new()
            .file(name, &program)
            .file("m.toml", machine(control, 40.125, 80.0))
            .file("zero.toml", machine(control, 40.126, 80.0))
            .file("tool.toml", machine(control, 40.125, 80.001));
        let out = format!("out_{name}");
        let run = shop.run(["fix", name, "-o", &out, "--machine", "m.toml", "--guard", "--json"]).exits(0);
        let guard = &run.json()["guard"];
        let names: Vec<&str> = guard["checked"].as_array().unwrap().iter().filter_map(|name| name.as_str()).collect();
        // G55 and tool 3 are in the machine file, but not in the program.
        let is_iso = ["fanuc", "haas"].contains(&control);
        let tool = if is_iso { "H2" } else { "T2 D1" };
        assert_eq!(names, if checks_tools { vec!["G54", tool] } else { vec!["G54"] }, "{control}");
        assert_eq!(guard["left"].as_array().unwrap().len(), usize::from(!checks_tools), "{control}");
        // Variables of the length and its wear: Fanuc, tool memory C; Haas, Mill operator's manual; Siemens, System variables. LinuxCNC has none: the zero.
        let read = match control {
            "fanuc" => "[#11002+#10002-",
            "haas" => "[#2002+#2202-",
            "sinumerik" => "$TC_DP3[2,1]+$TC_DP12[2,1]+$TC_DP21[2,1]",
            _ => "ABS[#5221 - ",
        };
        assert!(shop.text(&out).contains(read), "{control}: {}", shop.text(&out));
        let verified = shop.run(["verify", name, &out, "--machine", "m.toml"]).exits(0);
        // The guard compares values of the control, and none of them becomes a number.
        assert!(!verified.stderr.contains("W0243"), "{control}: {}", verified.stderr);
        let (plain, _) = executed(&shop, name, "m.toml");
        let (guarded, errors) = executed(&shop, &out, "m.toml");
        assert!(moves(&guarded) >= moves(&plain), "{control}: {guarded}\n{errors}");
        for (other, stops) in [("zero.toml", true), ("tool.toml", checks_tools)] {
            let (stream, errors) = executed(&shop, &out, other);
            assert_eq!(moves(&stream) == 0, stops, "{control} {other}: {stream}\n{errors}\n{}", shop.text(&out));
            if stops {
                let said = if is_iso { "CHANGED SINCE CORRECTION" } else { "a guard (--guard) ends it" };
                shop.run(["verify", name, &out, "--machine", other]).exits(4).says(said);
            }
        }
    }
}

#[test]
fn a_language_without_such_words_refuses_the_guard() {
    let program = "%PM1\nN1 G17 G71 G90\nN2 G54\nN3 T2 M6\nN4 G0 X20 Y20 Z100 S1100 M3\nN5 G1 X40 F200\nN6 M30\n";
    let shop = Shop::new().file("part.pm", program).file("m.toml", machine("grundig", 40.125, 80.0));
    let run = shop.run(["fix", "part.pm", "-o", "out.pm", "--machine", "m.toml", "--guard"]).exits(2);
    assert!(run.stderr.contains("--guard"), "{}", run.stderr);
    assert!(!shop.names().contains(&"out.pm".to_owned()));
}

/// Grbl, interface: it supports no O words, and answers such a line with an error.
#[test]
fn a_control_without_conditions_refuses_the_guard() {
    for name in ["grbl", "grblHAL", "FluidNC"] {
        let shop = Shop::new().file("part.ngc", RS274).file("m.toml", machine(name, 40.125, 80.0));
        let fix = ["fix", "part.ngc", "-o", "out.ngc", "--machine", "m.toml"];
        shop.run(fix.iter().chain(&["--guard"])).exits(2).says("do not use --guard");
        assert!(!shop.names().contains(&"out.ngc".to_owned()), "{name}");
        shop.run(fix).exits(0);
    }
}

/// A box between computer and control may remove comments, and the stamp with them.
#[test]
fn a_program_without_its_comments_is_known_by_its_guard() {
    for (control, name, program) in
        [("sinumerik", "part.mpf", SINUMERIK), ("fanuc", "part.nc", FANUC), ("rs274", "part.ngc", RS274)]
    {
        let shop = Shop::new().file(name, program).file("m.toml", machine(control, 40.125, 80.0));
        let out = format!("out_{name}");
        shop.run(["fix", name, "-o", &out, "--machine", "m.toml", "--guard"]).exits(0);
        let without =
            |line: &str| match line.find([';', '(']).filter(|_| !line.contains("IF") && !line.contains("SETAL")) {
                Some(at) => line[..at].to_owned(),
                None => line.replace("(G54 X CHANGED SINCE CORRECTION)", ""),
            };
        let bare: Vec<String> = shop.text(&out).lines().map(without).collect();
        let bare_name = format!("bare_{name}");
        let shop = shop.file(&bare_name, bare.join("\n") + "\n");
        let run = shop.run(["fix", &bare_name, "-o", "again.nc", "--machine", "m.toml", "--dialect", control]).exits(4);
        run.says("E0301").says("it has the check of --guard");
    }
}

/// A length offset with another number than its tool is compared, too.
#[test]
fn the_offset_of_another_number_is_compared() {
    for (control, read) in [("fanuc", "[#11003+#10003-[91.5]]"), ("haas", "[#2003+#2203-[91.5]]")] {
        let shop =
            Shop::new().file("part.nc", FANUC.replace("H2", "H3")).file("m.toml", machine(control, 40.125, 80.0));
        shop.run(["fix", "part.nc", "-o", "out.nc", "--machine", "m.toml", "--guard"]).exits(0);
        let text = shop.text("out.nc");
        assert!(text.contains(read) && !text.contains("#11002") && !text.contains("#2002"), "{control}: {text}");
    }
}

/// A program with a guard that also computes with a value of the control: this place is named, not that of the guard.
#[test]
fn a_value_beside_a_guard_is_named() {
    let program = FANUC.replace("N60", "N55 G1 X[#5221]\nN60");
    let shop = Shop::new().file("part.nc", program).file("m.toml", machine("fanuc", 40.125, 80.0));
    let run = shop.run(["fix", "part.nc", "-o", "out.nc", "--machine", "m.toml", "--guard"]).exits(0);
    assert_eq!(run.stderr.matches("warning[W0243]").count(), 1, "{}", run.stderr);
    run.says("part.nc:8");
}
