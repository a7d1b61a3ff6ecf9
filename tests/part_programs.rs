//! Real part programs: data that a program changes by a step, tape marks within a program, tilted planes of error-free machines, and what `verify` says of
//! them. Expected values are worked out by hand.

use crate::support::Shop;

/// Three linear axes on the tool side; X is 0.1 mm per meter too long. The zero of G54 is at its true place.
fn mill(controller: &str, zero_mm: f64) -> String {
    format!(
        "[machine]\nname = \"m\"\ntopology = \"wFXYZt\"\ncontroller = \"{controller}\"\n\
         [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-900, 900]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-900, 900]\n\
         [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-900, 900]\n\
         [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0.0, 1e-4]\n\
         [zero_offset.G54]\nX_mm = {zero_mm}\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n\
         [[tool]]\nnumber = 1\nlength_mm = 100\nradius_mm = 4\n"
    )
}

/// A program with a block that changes data of the control.
fn program(controller: &str, block: &str) -> String {
    match controller {
        "sinumerik" => {
            format!("G17 G90 G71 G94 G54\nT1 M6\nD1\nG0 X0 Y0 Z50\nR1=0.5\n{block}\nG54\nG1 Z-1 F100\nX20\nM30\n")
        }
        _ => format!(
            "G21 G90 G17 G54 G40 G49 G80\nT1 M6\nG43 H1 G0 Z50.\nX0. Y0.\n#1=2.\n{block}\nG90 G1 Z-1. F100.\nX20.\nM30\n"
        ),
    }
}

fn ending(controller: &str) -> &'static str {
    match controller {
        "sinumerik" => "mpf",
        "fanuc" => "nc",
        _ => "ngc",
    }
}

/// The control adds the step to its own value. The value of the machine file may be another, so it must not be written.
#[test]
fn a_step_of_data_of_the_control_stays_a_step() {
    for (controller, block, wanted) in [
        ("fanuc", "G91 G10 L2 P1 X5.", "G91 G10 L2 P1 X5."),
        ("fanuc", "G91 G10 L11 P1 R0.2", "G91 G10 L11 P1 R0.2"),
        ("fanuc", "#5221=#5221+5.", "#5221=#5221+5"),
        ("fanuc", "#5221=#5221-#1-1.", "#5221=#5221-3"),
        ("fanuc", "#2001=0.5+#2001", "#2001=#2001+0.5"),
        ("rs274", "#5221=[#5221+5]", "#5221=[#5221+5]"),
        // G10 with the old value in its word, also through a variable.
        ("fanuc", "G10 L2 P1 X[#5221+5.]", "G10 L2 P1 X[#5221+5]"),
        ("fanuc", "#100=#5221\n#101=#100+#1\nG10 L2 P1 X#101", "G10 L2 P1 X[#5221+2]"),
        ("fanuc", "#100=#5221\n#5221=3.+#100", "#5221=#5221+3"),
        ("fanuc", "G10 L11 P1 R[#2001-0.2]", "G10 L11 P1 R[#2001-0.2]"),
        ("rs274", "G10 L2 P1 X[#5221+5]", "G10 L2 P1 X[#5221+5]"),
        ("rs274", "#<old>=#5221\n#100=[#<old>-2]\nG10 L2 P1 X#100 Y1", "G10 L2 P1 X[#5221-2] Y1"),
        ("sinumerik", "$P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+5", "$P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+5"),
        ("sinumerik", "$P_UIFR[1]=$P_UIFR[1]:CTRANS(X,5)", "$P_UIFR[1]=$P_UIFR[1]:CTRANS(X,5)"),
        ("sinumerik", "$TC_DP3[1,1]=$TC_DP3[1,1]-R1", "$TC_DP3[1,1]=$TC_DP3[1,1]-0.5"),
    ] {
        let ending = ending(controller);
        let (source, out) = (format!("in.{ending}"), format!("out.{ending}"));
        // A value of G54 that is 200 mm off gives the same words for the control.
        for zero_mm in [100.0, 300.0] {
            let shop = Shop::new().file("m.toml", mill(controller, zero_mm)).file(&source, program(controller, block));
            shop.run(["fix", &source, "-o", &out, "--machine", "m.toml"]).exits(0);
            let text = shop.text(&out);
            let is_there = text.lines().any(|line| line == wanted);
            assert!(is_there, "{controller}: {block} at {zero_mm}\n{text}");
            // The output is in G90: only the block itself may be in G91.
            assert!(!text.contains("G91 G10") || text.lines().any(|line| line.starts_with("G90")), "{text}");
            shop.run(["verify", &source, &out, "--machine", "m.toml"]).exits(0);
        }
    }
}

/// G54 is at 100 and moves to 105. The tool must be at 125: c + c/10⁴ = 125 gives 124.98750, which is 19.98750 in G54.
#[test]
fn moves_after_a_step_count_from_the_new_zero() {
    for (controller, block) in [
        ("fanuc", "G91 G10 L2 P1 X5."),
        ("fanuc", "#5221=#5221+5."),
        ("rs274", "#5221=[#5221+5]"),
        ("sinumerik", "$P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+5"),
    ] {
        let ending = ending(controller);
        let (source, out) = (format!("in.{ending}"), format!("out.{ending}"));
        let shop = Shop::new().file("m.toml", mill(controller, 100.0)).file(&source, program(controller, block));
        shop.run(["fix", &source, "-o", &out, "--machine", "m.toml"]).exits(0);
        let text = shop.text(&out);
        let last = text.split_whitespace().filter_map(|word| word.strip_prefix('X')?.parse::<f64>().ok()).next_back();
        assert!((last.unwrap() - 19.9875).abs() < 6e-4, "{controller} {block}: {last:?}\n{text}");
    }
}

/// A product of the old value, a difference of two values, an argument and a rounded value: the control would compute another number than the machine file
/// gives, and the output cannot keep the computation.
#[test]
fn a_value_that_cannot_be_kept_as_a_sum_is_refused() {
    for (controller, block) in [
        ("fanuc", "#5221=#5221*2"),
        ("fanuc", "#5221=#5221+#5241"),
        ("fanuc", "#100=FIX[#5221]\nG10 L2 P1 X#100"),
        ("fanuc", "G91 G10 L2 P1 X[#5221/2]"),
        ("rs274", "G10 L2 P1 X[#5221*2]"),
        ("rs274", "#<half>=[#5221/2]\n#5221=#<half>"),
    ] {
        let ending = ending(controller);
        let (source, out) = (format!("in.{ending}"), format!("out.{ending}"));
        let machine = mill(controller, 100.0) + "[zero_offset.G55]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n";
        let shop = Shop::new().file("m.toml", machine).file(&source, program(controller, block));
        shop.run(["fix", &source, "-o", &out, "--machine", "m.toml"]).exits(4).says("error[E0219]").says("zero offset");
    }
}

/// The program sets the value itself, to a number. What it computes from it is then a number, too.
#[test]
fn a_value_that_the_program_has_set_is_a_number() {
    let block = "G10 L2 P1 X40.\n#5221=#5221*2";
    let shop = Shop::new().file("m.toml", mill("fanuc", 100.0)).file("in.nc", program("fanuc", block));
    shop.run(["fix", "in.nc", "-o", "out.nc", "--machine", "m.toml"]).exits(0);
    let text = shop.text("out.nc");
    assert!(text.lines().any(|line| line == "#5221=80"), "{text}");
}

/// Renishaw, Inspection Plus: S is the zero offset to set, T the tool offset; without them the macro only stores what it measured. O9832 switches the
/// probe on. The measuring cycles of a Sinumerik correct what their arguments name.
#[test]
fn a_measuring_program_that_sets_an_offset_is_named() {
    for (controller, block, is_named) in [
        ("fanuc", "G65 P9811 Z0. S1.", true),
        ("fanuc", "G65 P9814 D50. T12.", true),
        ("fanuc", "G65 P9851 T1.", true),
        ("fanuc", "G65 P9811 Z0.", false),
        ("fanuc", "G65 P9832", false),
        ("sinumerik", "CYCLE978(100,,1,0,,,,,)", true),
        ("sinumerik", "CYCLE976(0,,1)", false),
    ] {
        let ending = ending(controller);
        let source = format!("in.{ending}");
        let machine = mill(controller, 100.0) + "[control]\nopaque = [\"O98*\", \"CYCLE97*\"]\n";
        let text = program(controller, block).replace("Z-1", "X0. Y0. Z-1");
        let shop = Shop::new().file("m.toml", machine).file(&source, text);
        let run = shop.run(["check", &source, "--machine", "m.toml"]);
        assert_eq!(run.stderr.contains("warning[W0242]"), is_named, "{controller} {block}: {}", run.stderr);
    }
}

/// B-62764EN: F of G93 is 0.001 to 9999.999 1/min on a Fanuc. LinuxCNC reads any number.
#[test]
fn a_reciprocal_time_that_a_fanuc_does_not_read_is_refused() {
    for (controller, feed, code) in [("fanuc", "9999.999", 0), ("fanuc", "90000.", 4), ("rs274", "90000.", 0)] {
        let ending = ending(controller);
        let (source, out) = (format!("in.{ending}"), format!("out.{ending}"));
        let text = format!(
            "G21 G90 G17 G54 G40 G49\nT1 M6\nG43 H1 G0 Z50.\nX0. Y0.\nG93\nG1 X0.01 F{feed}\nG94\nG0 Z50.\nM30\n"
        );
        let shop = Shop::new().file("m.toml", mill(controller, 100.0)).file(&source, text);
        let run = shop.run(["fix", &source, "-o", &out, "--machine", "m.toml"]).exits(code);
        if code == 4 {
            run.says("error[E0210]").says("at most F9999.999");
        }
    }
}

/// A `%` after a block number ends the tape. Blocks that follow it were executed.
#[test]
fn a_percent_sign_after_a_block_number_ends_the_program() {
    let run = |controller: &str, text: &str| {
        let shop = Shop::new().file("m.toml", mill(controller, 100.0)).file("in.nc", text);
        shop.run(["check", "in.nc", "--machine", "m.toml"])
    };
    let program = |end: &str| format!("%\nG21 G90 G17 G54 G40 G49\nG0 X0. Y0. Z50.\nG1 Z-1. F100.\nN9 X20.\n{end}");
    for controller in ["fanuc", "rs274"] {
        for end in ["N10 %\nX50.\nM30\n%\n", "N10 % X40.\n", "n10%\nN20 X50.\n"] {
            run(controller, &program(end)).exits(4).says("error[E0229]: the % after the block number in line 6");
        }
        run(controller, &program("M30\nN10 %\n")).exits(0);
        run(controller, &program("M30\nN10 %\n\n(END)\n%\n")).exits(0);
        // Words in the line of the mark that ends the tape.
        run(controller, &program("M30\n% X40.\n")).exits(0).says("warning[W0203]").says("in.nc:7:3");
    }
    // A percent sign in a comment is text.
    run("fanuc", &program("N10 (50 %) X50.\nM30\n%\n")).exits(0);
}

/// Five axes: C and B in the head, B about an axis at 45° between Y and Z. No errors.
fn nutating(controller: &str, rest: &str) -> String {
    format!(
        "[machine]\nname = \"m\"\ntopology = \"wFXYZCBSt\"\ncontroller = \"{controller}\"\n\
         [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 3000]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 2000]\n\
         [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-1000, 500]\n\
         [axis.C]\ndirection = [0, 0, 1]\npoint_mm = [0, 0, 150]\ntravel_deg = [-720, 720]\n\
         [axis.B]\ndirection = [0, 1, 1]\npoint_mm = [0, 0, 150]\ntravel_deg = [-180, 180]\n\
         [control]\nincrement_system = \"IS-C\"\nincrement_mm = 0.0001\nincrement_deg = 0.0001\n\
         [zero_offset.G54]\nX_mm = 900\nY_mm = 700\nZ_mm = -600\nset = \"absolute\"\n\
         [[tool]]\nnumber = 1\nlength_mm = 120\nradius_mm = 5\n{rest}"
    )
}

/// Without errors the moves in the plane are those of the program: the rotary axes stand where their increments permit, and the plane is theirs.
#[test]
fn a_tilted_plane_of_a_machine_without_errors_stays() {
    for plane in ["G68.2 P1 Q123 X10. Y15. Z5. I25. J15. K20.", "G68.2 X10. Y15. Z5. I49.032 J28.9046 K-32.3756"] {
        let text = format!(
            "%\nO1000\nN10 G21 G90 G17 G40 G80 G49 G94\nN20 T1 M6\nN30 G54\nN40 G0 B0. C0.\nN50 G43 H1 G0 X0. Y0. Z150.\n\
             N60 {plane}\nN70 G53.1 P1\nN80 G0 X-30. Y-20.\nN90 G0 Z50.\nN100 G1 Z-3. F5000.\nN110 G1 X30.\n\
             N120 G3 X40. Y-10. I0. J10.\nN130 G1 Y20.\nN140 G0 Z100.\nN150 G69\nN160 M30\n%\n"
        );
        let shop = Shop::new().file("m.toml", nutating("fanuc", "")).file("in.nc", &text);
        shop.run(["fix", "in.nc", "-o", "out.nc", "--machine", "m.toml"]).exits(0);
        let out = shop.text("out.nc");
        for line in text.lines().skip_while(|line| !line.starts_with("N80")).take(7) {
            assert!(out.lines().any(|own| own == line), "{line} of {plane}\n{out}");
        }
        let json = shop.run(["verify", "in.nc", "out.nc", "--machine", "m.toml", "--json"]).exits(0).json();
        let after_um = json["after"]["max_um"].as_f64().unwrap();
        assert!(after_um < 0.05, "{json}");
    }
}

/// A head with C and A, and X with a lost motion of 6 µm. In the plane of CYCLE800 all axes move together, and the side of X after the rapid move is
/// unknown: the step that leads it to a side is no deviation.
#[test]
fn a_step_on_the_spot_of_an_unknown_side_is_no_deviation() {
    let machine = nutating("sinumerik", "[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = -6.0\n")
        .replace("wFXYZCBSt", "wFXYZCASt")
        .replace("[axis.B]\ndirection = [0, 1, 1]", "[axis.A]\ndirection = [1, 0, 0]")
        .replace("increment_system = \"IS-C\"\n", "")
        .replace("travel_deg = [-180, 180]", "travel_deg = [-110, 110]")
        + "[location]\nEB0Z = -30.0\nEA0Z = 30.0\nEX0C = 20.0\nEB0C = -30.0\n";
    let text = "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1\nN40 G0 A0 C0\nN50 CYCLE800(0,\"TC1\",0,57,10,15,5,25,15,20,0,0,0,1)\n\
        N60 G0 X-30 Y-20\nN70 G0 Z50\nN80 G1 Z-3 F5000\nN90 G1 X30\nN100 G0 Z100\nN110 CYCLE800()\nN120 M30\n";
    let shop = Shop::new().file("m.toml", machine).file("in.mpf", text);
    shop.run(["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let out = shop.text("out.mpf");
    assert!(out.contains(";~"), "a step on the spot is written: {out}");
    shop.run(["verify", "in.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
    // A step that is 20 µm off is one: the words of its line are changed.
    let line = out.lines().find(|line| line.contains(";~")).unwrap();
    let word = line.split(' ').find_map(|word| word.strip_prefix('Y')).unwrap();
    let moved = format!("Y{:.4}", word.parse::<f64>().unwrap() + 0.02);
    let wrong = out.replace(line, &line.replace(&format!("Y{word}"), &moved));
    let shop = shop.file("wrong.mpf", wrong);
    shop.run(["verify", "in.mpf", "wrong.mpf", "--machine", "m.toml"]).exits(4);
}

/// A Fanuc reads F0.001 to F9999.999 under G93 (B-62764EN, inverse time). A step on the spot takes no time of the move, so it has the largest one.
#[test]
fn a_step_under_inverse_time_has_a_feed_that_the_control_reads() {
    let axis = |letter: &str, unit: &str, size: u32| {
        format!("[[motion]]\ncomponent = \"E{letter}{letter}\"\nkind = \"backlash\"\nvalue_{unit} = {size}\n")
    };
    let rest = axis("X", "um", 6) + &axis("Y", "um", 4) + &axis("B", "urad", 40) + &axis("C", "urad", 40);
    let machine = nutating("fanuc", &rest).replace("direction = [0, 1, 1]", "direction = [0, 1, 0]");
    let text = "%\nO1000\nN10 G21 G90 G17 G40 G80 G49 G94\nN20 T1 M6\nN30 G54\nN40 G0 B0. C0.\nN50 G43.4 H1\nN60 G0 X-40. Y-30. Z60. B20. C10.\n\
        N70 G1 Z20. F5000.\nN80 G1 B50. C60.\nN90 G1 B20. C10.\nN100 G49\nN110 M30\n%\n";
    let shop = Shop::new().file("m.toml", machine).file("in.nc", text);
    shop.run(["fix", "in.nc", "-o", "out.nc", "--machine", "m.toml"]).exits(0);
    let out = shop.text("out.nc");
    let by_time = out.lines().skip_while(|line| !line.contains("G93")).take_while(|line| !line.starts_with("G94"));
    let feeds: Vec<f64> = by_time
        .flat_map(|line| line.split('(').next().unwrap_or_default().split_whitespace())
        .filter_map(|word| word.strip_prefix('F')?.parse().ok())
        .collect();
    assert!(feeds.len() > 2 && feeds.contains(&9999.999), "{out}");
    assert!(feeds.iter().all(|feed| (0.001..=9999.999).contains(feed)), "{out}");
    shop.run(["verify", "in.nc", "out.nc", "--machine", "m.toml"]).exits(0);
}

/// Table C and head B. On the great circle of the last cut, C turns fast where the tool is upright: equal times are unequal angles. A control divides the time of
/// the move evenly along the circle, so the times that `fix` writes are right.
#[test]
fn times_on_a_great_circle_are_even() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wCYFXZBSt\"\ncontroller = \"sinumerik\"\n\
        [axis.C]\ndirection = [0, 0, -1]\npoint_mm = [300, -198, -440]\ntravel_deg = [-720, 720]\n\
        [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-900, 500]\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-600, 1200]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-1000, 300]\n\
        [axis.B]\ndirection = [0, 1, 0]\npoint_mm = [0, 0, 150]\ntravel_deg = [-110, 110]\n\
        [zero_offset.G54]\nX_mm = 300\nY_mm = -198\nZ_mm = -440\nset = \"absolute\"\n\
        [[tool]]\nnumber = 1\nlength_mm = 120\nradius_mm = 5\n\
        [location]\nEC0X = -30.0\nEB0Z = -30.0\nEA0Z = 30.0\nEX0C = 20.0\nEY0C = 20.0\nEA0C = -30.0\nEB0C = -30.0\nEX0B = -20.0\n\
        EZ0B = 20.0\nEA0B = 30.0\nEC0B = 30.0\n\
        [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0.0, 2e-05]\n\
        [[motion]]\ncomponent = \"EYY\"\nkind = \"polynomial\"\ncoefficients = [0.0, -2e-05]\n\
        [[motion]]\ncomponent = \"EZZ\"\nkind = \"polynomial\"\ncoefficients = [0.0, 2e-05]\n";
    let text = "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1\nN35 G0 B0 C0\nN40 TRAORI\nN45 ORIWKS\nN47 ORIVECT\n\
        N50 G0 X-40 Y-30 Z60 A3=0 B3=0 C3=1\nN60 G1 Z20 F2000\nN75 G1 X30 Y20 A3=0.1 B3=0.4 C3=1 F3000\n\
        N77 G1 A3=0.5 B3=0.1 C3=1 F2000\nN80 G0 Z100\nN85 TRAFOOF\nN90 M30\n";
    let shop = Shop::new().file("m.toml", machine).file("in.mpf", text);
    shop.run(["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let out = shop.text("out.mpf");
    assert!(out.contains("N77 G93"), "a turn about a resting tip states its time: {out}");
    shop.run(["verify", "in.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
    // A time that is a fifth too long is no correction.
    let line = out.lines().skip_while(|line| !line.contains("G93")).find(|line| line.contains(" C")).unwrap();
    let word = line.split(' ').find_map(|word| word.strip_prefix('F')).unwrap();
    let slow = line.replace(&format!("F{word}"), &format!("F{:.3}", word.parse::<f64>().unwrap() / 1.2));
    let shop = shop.file("slow.mpf", out.replace(line, &slow));
    shop.run(["verify", "in.mpf", "slow.mpf", "--machine", "m.toml"]).exits(4).says("E0321");
}
