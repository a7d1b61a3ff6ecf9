//! An error that no reading shows: the calibration says so, and no correction that needs it is green. What nobody states about a touch widens the interval.

use std::fmt::Write as _;

use crate::support::{Run, Shop};

/// Three axes at the tool. The angle of X and Y belongs to Y, which is further from F.
const MILL: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\n[control]\ninitial_zero_offset = \"G500\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n";
const CUT_ALONG_X_AND_Y: &str = "G90 G71 G17\nG0 X100 Y50 Z100\nG1 X400 F500\nG1 Y300\nM30\n";
const CUT_ALONG_X: &str = "G90 G71 G17\nG0 X100 Y50 Z100\nG1 X400 F500\nM30\n";

/// Bow of X along Y, 4 µm over 500 mm.
fn bow_um(x: f64) -> f64 {
    let share = x / 500.0;
    16.0 * share * (share - 1.0)
}

/// Readings of this straightness, with a slope of 30 µrad: that of the reference, or of the axis.
fn straightness_um(x: f64) -> f64 {
    bow_um(x) + 0.03 * x
}

/// Lasers along X and Y: scales of 60 and −40 µm/m. A straightness of X along Y.
fn lines() -> String {
    let mut rows = String::from("setup,component,X,Y,Z,value_um\n");
    for x in (0..=500).step_by(50).map(f64::from) {
        writeln!(rows, "1,EXX,{x},200,100,{:.4}", 0.06 * x).unwrap();
        writeln!(rows, "2,EYX,{x},200,100,{:.4}", straightness_um(x)).unwrap();
    }
    for y in (0..=400).step_by(50).map(f64::from) {
        writeln!(rows, "3,EYY,250,{y},100,{:.4}", -0.04 * y).unwrap();
    }
    rows
}

/// A circle of 150 mm in XY on a machine with the scales and the bow above and `EC0Y` = 50 µrad: Y turned about +Z by 50 µrad moves the tool by −50e-6·y along X.
fn circle() -> String {
    let mut rows = String::from("run,setup,X,Y,Z,dr_um\n");
    for k in 0..72 {
        let angle = f64::from(5 * k).to_radians();
        let (x, y) = (250.0 + 150.0 * angle.cos(), 200.0 + 150.0 * angle.sin());
        // The bow has no slope of its own: a displacement of the ball takes up its value at the center.
        let [dx, dy] = [0.06 * x - 0.05 * y, bow_um(x) - 0.04 * y];
        let [at_ball_x, at_ball_y] = [0.06 * 250.0 - 0.05 * 200.0, bow_um(250.0) - 0.04 * 200.0];
        let dr = (dx - at_ball_x) * angle.cos() + (dy - at_ball_y) * angle.sin();
        writeln!(rows, "ccw,A,{x:.6},{y:.6},100,{dr:.5}").unwrap();
    }
    rows
}

fn shop() -> Shop {
    Shop::new()
        .file("start.toml", MILL)
        .file("lines.csv", lines())
        .file(
            "lines.toml",
            "[measurement]\nkind = \"direct\"\nsigma_um = 0.2\nfree = [\"offset\", \"slope\"]\n",
        )
        .file("circle.csv", circle())
        .file(
            "circle.toml",
            "[measurement]\nkind = \"ballbar\"\nsigma_um = 0.2\nfree = [\"centre\"]\n[setup.A]\ncentre_mm = [250, 200, 100]\nlength_mm = 150\n",
        )
        .file("both.mpf", CUT_ALONG_X_AND_Y)
        .file("one.mpf", CUT_ALONG_X)
}

fn calibrate(shop: &Shop, data: &str, start: &str, model: &str, out: &str) -> String {
    let words = format!("calibrate {data} --machine {start} --model {model} -o {out}");
    shop.run(words.split_whitespace()).exits(0);
    shop.text(out)
}

fn fix(shop: &Shop, program: &str, machine: &str) -> Run {
    let words = format!("fix {program} -o out.mpf --machine {machine} --review page.html --json");
    let run = shop.run(words.split_whitespace());
    // 1: the review says that it should not run.
    if run.code == 1 { run.exits(1) } else { run.exits(0) }
}

#[test]
fn a_squareness_that_no_reading_shows_is_named() {
    let shop = shop();
    let text = calibrate(&shop, "lines.csv", "start.toml", "EXX1,EYY1,EYX2", "lines_only.toml");
    assert!(text.contains("not_shown = [\"EC0Y\", \"EZX\", \"EXY\", \"EZY\", \"EAX\", \"ECX\"]"), "{text}");
    let shown = shop.run(["machine", "show", "lines_only.toml"]).exits(0);
    assert!(shown.stdout.contains("not shown   EC0Y"), "{}", shown.stdout);
    // X and Y move, and their angle is unknown.
    let run = fix(&shop, "both.mpf", "lines_only.toml");
    assert_eq!(run.codes(), ["W0330", "W0332"]);
    let json = run.json();
    let gap = &json["coverage"]["gaps"][0];
    assert_eq!((&gap["kind"], &gap["squareness"]), (&"squareness".into(), &"EC0Y".into()), "{json}");
    assert!(gap["size_um"].is_null());
    assert_eq!((&json["verdict"]["grade"], &json["coverage"]["is_complete"]), (&"warn".into(), &false.into()));
    // Along X alone it has no effect on the form. The straightness in Z, which was not measured either, has one.
    let run = fix(&shop, "one.mpf", "lines_only.toml");
    assert_eq!(run.codes(), ["W0332"]);
    // A release gate refuses it.
    let words = "fix both.mpf -o out.mpf --machine lines_only.toml --require-coverage";
    shop.run(words.split_whitespace()).exits(4).says("error[E0322]: X and Y move").says("squareness EC0Y");
}

#[test]
fn a_squareness_that_is_known_is_not_named() {
    let shop = shop();
    calibrate(&shop, "lines.csv", "start.toml", "EXX1,EYY1,EYX2", "lines_only.toml");
    // A ball-bar shows it, even if the model does not have it: then it is not significant, and not unknown.
    let text = calibrate(&shop, "circle.csv", "lines_only.toml", "EC0Y", "circle_too.toml");
    // A yaw of X bends the circle as the bow of X does, which these readings do not contain.
    assert!(text.contains("not_shown = [\"EZX\", \"EZY\", \"EAX\", \"ECX\"]") && text.contains("EC0Y ="), "{text}");
    assert_eq!(fix(&shop, "both.mpf", "circle_too.toml").codes(), ["W0332"]);
    // Both together.
    let text = calibrate(&shop, "lines.csv circle.csv", "start.toml", "EXX1,EYY1,EYX2,EC0Y", "together.toml");
    assert!(text.contains("not_shown = [\"EZX\", \"EZY\", \"EAX\"]"), "{text}");
    // Stated by hand before or after the calibration.
    let stated = shop.file("stated.toml", format!("{MILL}[location]\nEC0Y = 12.0\n"));
    let text = calibrate(&stated, "lines.csv", "stated.toml", "EXX1,EYY1,EYX2", "by_hand.toml");
    assert!(text.contains("not_shown = [\"EZX\", \"EXY\", \"EZY\", \"EAX\", \"ECX\"]"), "{text}");
    let by_hand = stated.text("lines_only.toml") + "[location]\nEC0Y = 12.0\n";
    let later = stated.file("later.toml", by_hand);
    assert_eq!(fix(&later, "both.mpf", "later.toml").codes(), ["W0332"]);
}

#[test]
fn a_squareness_that_the_readings_show_and_the_model_lacks_is_named() {
    // The circle has EC0Y = 50 µrad, and the model has no term for it. Its bow EYX2 = 64 µm/m² has a slope of 2 · 64 · 0.25 = 32 µrad at the center X 250, where
    // that of the machine has none: the angle beside it is 82 µrad.
    let shop = shop();
    let words = "calibrate lines.csv circle.csv --machine start.toml --model EXX1,EYY1,EYX2 -o lacking.toml";
    let run = shop.run(words.split_whitespace()).exits(0).says("warning[W0620]").says("EC0Y = 82.0 ± ");
    assert!(!run.stderr.contains("EA0Z") && !run.stderr.contains("EB0Z"), "{}", run.stderr);
    assert!(shop.text("lacking.toml").contains("not_shown = [\"EC0Y\", \"EZX\", \"EZY\", \"EAX\"]"));
    assert_eq!(fix(&shop, "both.mpf", "lacking.toml").codes(), ["W0330", "W0332"]);
    // With it, and where no reading shows it, there is nothing to add.
    for (data, model) in [("lines.csv circle.csv", "EXX1,EYY1,EYX2,EC0Y"), ("lines.csv", "EXX1,EYY1,EYX2")] {
        let words = format!("calibrate {data} --machine start.toml --model {model} -o out.toml");
        let run = shop.run(words.split_whitespace()).exits(0);
        assert!(!run.stderr.contains("W0620"), "{}", run.stderr);
    }
}

#[test]
fn a_straightness_that_no_reading_shows_is_named() {
    // Lasers along X and Y, and the bow of X along Y: the other bows were never measured.
    let shop = shop();
    let text = calibrate(&shop, "lines.csv", "start.toml", "EXX1,EYY1,EYX2", "lines_only.toml");
    assert!(text.contains("not_shown = [\"EC0Y\", \"EZX\", \"EXY\", \"EZY\", \"EAX\", \"ECX\"]"), "{text}");
    let run = fix(&shop, "one.mpf", "lines_only.toml");
    assert_eq!(run.codes(), ["W0332"]);
    assert!(run.stdout.contains("EZX (straightness of X in Z)"), "{}", run.stdout);
    let json = run.json();
    assert_eq!(json["coverage"]["gaps"][0]["components"], serde_json::json!(["EZX"]));
    assert_eq!(json["verdict"]["grade"], "warn");
    // A ball-bar in XY shows the bow of Y along X, beside the bow of X also its yaw, and no motion along Z.
    let text = calibrate(&shop, "lines.csv circle.csv", "start.toml", "EXX1,EYY1,EYX2,EC0Y", "together.toml");
    assert!(text.contains("not_shown = [\"EZX\", \"EZY\", \"EAX\"]"), "{text}");
    // An error that the file states is known, and what is removed by hand too.
    let one = |name: &str, coefficients: &str| {
        format!("[[motion]]\ncomponent = \"{name}\"\nkind = \"polynomial\"\ncoefficients = {coefficients}\n")
    };
    let stated = one("EZX", "[0, 0, 1e-9]") + &one("EAX", "[0, 1e-9]");
    let removed = text.replace("\"EZX\", ", "").replace(", \"EAX\"", "");
    let shop = shop.file("removed.toml", removed).file("stated.toml", format!("{text}\n{stated}"));
    for known in ["removed.toml", "stated.toml"] {
        assert!(fix(&shop, "one.mpf", known).codes().is_empty(), "{known}");
    }
}

#[test]
fn a_slope_that_a_square_gives_shows_the_squareness() {
    // Without a free slope, the straightness of X along Y refers to a square.
    let square = "[measurement]\nkind = \"direct\"\nsigma_um = 0.2\nfree = [\"offset\"]\n";
    let shop = shop().file("lines.toml", square);
    let text = calibrate(&shop, "lines.csv", "start.toml", "EXX1,EYY1,EYX1,EYX2", "square.toml");
    assert!(text.contains("not_shown = [\"EZX\", \"EXY\", \"EZY\", \"EAX\", \"ECX\"]"), "{text}");
}

#[test]
fn a_tool_of_another_length_is_named_after_a_measurement_with_one() {
    let measured = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 2e-5]\n\
        [measured]\nX_mm = [0, 500]\nY_mm = [0, 400]\nZ_mm = [0, 300]\n";
    let tool = "[[tool]]\nnumber = 5\nlength_mm = 180.0\n";
    let cut = "G90 G71 G17\nT5 M6\nG0 X100 Y50 Z100 D1\nG1 X400 F500\nM30\n";
    let with = |lengths: &str| {
        let file = format!("{MILL}{measured}tool_length_mm = {lengths}\n{tool}");
        fix(&Shop::new().file("m.toml", file).file("cut.mpf", cut), "cut.mpf", "m.toml")
    };
    let run = with("[120, 120]");
    assert_eq!(run.codes(), ["W0318"]);
    // Nothing bounds the angles.
    assert!(run.json()["coverage"]["gaps"][0]["size_um"].is_null());
    // Two lengths have shown the angles; and the measured length is no gap.
    assert!(with("[60, 120]").codes().is_empty());
    assert!(with("[180, 180]").codes().is_empty());
}

#[test]
fn a_touch_from_an_unknown_side_widens_the_interval() {
    // X loses 8 µm. A side that was touched in the positive direction lags by 4 µm, in the negative one by −4 µm.
    let file = |set_at: &str| {
        format!(
            "{MILL}[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = -8.0\n\
             [measured]\nX_mm = [0, 500]\nY_mm = [0, 400]\nZ_mm = [0, 300]\n[uncertainty]\nEXXb = 0.2\n\
             [zero_offset.G54]\nX_mm = 100.0\nY_mm = 50.0\nZ_mm = 100.0\nset = \"touched\"\n{set_at}"
        )
    };
    let cut = "G90 G71 G17 G54\nG0 X-50 Y0 Z20\nX0\nG1 X200 F500\nX10\nX150\nM30\n";
    let along_x = |set_at: &str| -> [f64; 2] {
        let shop = Shop::new().file("m.toml", file(set_at)).file("cut.mpf", cut);
        let json = fix(&shop, "cut.mpf", "m.toml").json();
        let ends = &json["prediction"]["after"]["axes_um"]["X"];
        [0, 1].map(|end| ends[end].as_f64().unwrap())
    };
    let [_, high] = along_x("");
    // 2.24 · 0.6 · 4 µm with the rounding of the program: the magnitude of a normal amount is below 2.24 in 97.5 of 100 cases.
    assert!(high > 4.0 && high < 6.5, "{high}");
    let [_, high] = along_x("[zero_offset.G54.set_at]\nX_dir = 1\n");
    assert!(high < 1.5, "{high}");
}

#[test]
fn a_touch_with_a_tool_of_unknown_length_widens_the_interval() {
    // The spindle is tilted by 100 µrad: the tip of a tool of 100 mm is 10 µm beside that of a touch without a tool.
    let file = |set_at: &str| {
        format!(
            "{MILL}[[motion]]\ncomponent = \"EBZ\"\nkind = \"polynomial\"\ncoefficients = [1e-4]\n[[tool]]\nnumber = 1\nlength_mm = 100.0\n\
             [measured]\nX_mm = [0, 500]\nY_mm = [0, 400]\nZ_mm = [0, 300]\ntool_length_mm = [0, 200]\n[uncertainty]\nEBZ0 = 1e-7\n\
             [zero_offset.G54]\nX_mm = 100.0\nY_mm = 50.0\nZ_mm = 100.0\nset = \"touched\"\n{set_at}"
        )
    };
    let cut = "G90 G71 G17 G54\nT1 M6\nD1\nG0 X-50 Y0 Z20\nX0\nG1 X200 F500\nX10\nM30\n";
    let along_x = |set_at: &str| -> [f64; 2] {
        let shop = Shop::new().file("m.toml", file(set_at)).file("cut.mpf", cut);
        let json = fix(&shop, "cut.mpf", "m.toml").json();
        let ends = &json["prediction"]["after"]["axes_um"]["X"];
        [0, 1].map(|end| ends[end].as_f64().unwrap())
    };
    let [low, high] = along_x("");
    // The tool of the program has touched, or none: 0 or 10 µm. A rounded position is wrong by up to 0.5 µm.
    assert!(low < 1.0 && high > 9.4 && high < 11.5, "{low} {high}");
    let [_, high] = along_x("[zero_offset.G54.set_at]\ntool_length_mm = 100.0\n");
    assert!(high < 1.0, "{high}");
    // A longer tool of the file may have touched: 250 mm are 15 µm from the tool of the program.
    let longer = "[[tool]]\nnumber = 7\nlength_mm = 250.0\n";
    let [low, high] = along_x(longer);
    assert!(low < 1.0 && high > 14.4 && high < 16.5, "{low} {high}");
    // X loses 8 µm, and nothing states its side at the touch: 4 µm more.
    let lost = "[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = -8.0\n";
    let [low, high] = along_x(&format!("{longer}{lost}"));
    assert!(low < 1.5 && high > 18.4 && high < 21.0, "{low} {high}");
}

#[test]
fn a_length_that_nothing_states_at_all_widens_the_interval() {
    // As above, and nothing states the method either: the zero counts as touched without a tool.
    let file = |lines: &str| {
        format!(
            "{MILL}[[motion]]\ncomponent = \"EBZ\"\nkind = \"polynomial\"\ncoefficients = [1e-4]\n[[tool]]\nnumber = 1\nlength_mm = 100.0\n\
             [measured]\nX_mm = [0, 500]\nY_mm = [0, 400]\nZ_mm = [0, 300]\ntool_length_mm = [0, 200]\n[uncertainty]\nEBZ0 = 1e-7\n\
             [zero_offset.G54]\nX_mm = 100.0\nY_mm = 50.0\nZ_mm = 100.0\n{lines}"
        )
    };
    let cut = "G90 G71 G17 G54\nT1 M6\nD1\nG0 X-50 Y0 Z20\nX0\nG1 X200 F500\nX10\nM30\n";
    let along_x = |lines: &str| -> [f64; 2] {
        let shop = Shop::new().file("m.toml", file(lines)).file("cut.mpf", cut);
        let json = fix(&shop, "cut.mpf", "m.toml").json();
        let ends = &json["prediction"]["after"]["axes_um"]["X"];
        [0, 1].map(|end| ends[end].as_f64().unwrap())
    };
    let [low, high] = along_x("");
    assert!(low < 1.0 && high > 9.4 && high < 11.5, "{low} {high}");
    let [low, high] = along_x("set = \"absolute\"\n");
    assert!(low < 1.0 && high < 1.5, "{low} {high}");
}

#[test]
fn a_side_that_no_motion_states_is_between_the_ends_of_the_interval() {
    // X loses 8 µm and never moves with feed: its body is up to 4 µm beside the command, on a side that depends on the moves before the program.
    let file = format!(
        "{MILL}[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = -8.0\n\
         [measured]\nX_mm = [0, 500]\nY_mm = [0, 400]\nZ_mm = [0, 300]\n[uncertainty]\nEXXb = 0.2\n"
    );
    let cut = "G90 G71 G17\nG0 X100 Y50 Z100\nG1 Z50 F500\nM30\n";
    let shop = Shop::new().file("m.toml", file).file("cut.mpf", cut);
    let before = &fix(&shop, "cut.mpf", "m.toml").json()["prediction"]["before"];
    for figure in ["mean_um", "rms_um", "max_um"] {
        let [low, high] = [0, 1].map(|end| before[figure][end].as_f64().unwrap());
        assert!(low < 0.5 && high > 3.9 && high < 4.5, "{figure}: {low} {high}");
    }
}

/// A mill with a rotary table C that turns about −Z.
fn with_table() -> String {
    MILL.replace("wFXYZSt", "wCFXYZSt").replace("[0, 500]", "[-250, 250]").replace("[0, 400]", "[-200, 200]")
        + "[axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-180, 180]\n"
}

/// The list in a machine file.
fn list(text: &str) -> &str {
    text.lines().find(|line| line.starts_with("not_shown")).unwrap_or_default()
}

#[test]
fn a_place_of_a_rotary_axis_that_no_reading_shows_is_named() {
    // An autocollimator: C turns 20 µrad per rad too far. Nothing shows where its axis stands.
    let mut angles = String::from("setup,component,X,Y,Z,C,value_urad\n");
    let mut balls = String::from("setup,X,Y,Z,C,tool_z_mm,dx_um,dy_um,dz_um\n");
    for degrees in (-180..=180).step_by(20).map(f64::from) {
        let angle = degrees.to_radians();
        writeln!(angles, "1,ECC,0,0,100,{degrees},{:.4}", 20.0 * angle).unwrap();
        // A ball at 90 mm on the table, followed by X and Y. The table stands 15 µm too far in X: the tool is at −15 µm, and the ball, which was set to
        // zero at C 0, is 15 µm aside in the direction of X that turns with the table about −Z. The error of the angle moves the ball about +Z.
        let (x, y) = (90.0 * angle.cos(), -90.0 * angle.sin());
        let [dx, dy] = [15.0 * (angle.cos() - 1.0) + 0.02 * angle * y, -15.0 * angle.sin() - 0.02 * angle * x];
        writeln!(balls, "1,{x:.6},{y:.6},200,{degrees},-100,{dx:.5},{dy:.5},0").unwrap();
    }
    let shop = Shop::new()
        .file("start.toml", with_table())
        .file("angles.csv", angles)
        .file("angles.toml", "[measurement]\nkind = \"direct\"\nsigma_urad = 0.5\nfree = [\"offset\"]\n")
        .file("balls.csv", balls)
        .file("balls.toml", "[measurement]\nkind = \"displacement\"\nsigma_um = 0.2\nfree = [\"offset\"]\n")
        .file("turn.mpf", "G90 G71 G17\nG0 X100 Y50 Z100 C0\nG1 C30 F500\nM30\n")
        .file("zero.mpf", "G90 G71 G17\nG0 X100 Y50 Z100 C0\nG1 X120 F500\nM30\n");
    let text = calibrate(&shop, "angles.csv", "start.toml", "ECC1", "angle.toml");
    // EC0C is the alignment of the workpiece on the table, and EZ0C its height.
    assert_eq!(list(&text), "not_shown = [\"EX0C\", \"EY0C\", \"EA0C\", \"EB0C\"]");
    let run = fix(&shop, "turn.mpf", "angle.toml");
    assert_eq!(run.codes(), ["W0332"]);
    let json = run.json();
    assert_eq!(json["coverage"]["gaps"][0]["components"], serde_json::json!(["EX0C", "EY0C", "EA0C", "EB0C"]));
    assert_eq!((&json["verdict"]["grade"], &json["coverage"]["gaps"][0]["axis"]), (&"warn".into(), &"C".into()));
    // In its zero position the table is where X was measured.
    assert!(!fix(&shop, "zero.mpf", "angle.toml").codes().contains(&"W0332".to_owned()));
    for command in ["check turn.mpf --machine angle.toml", "verify turn.mpf out.mpf --machine angle.toml"] {
        shop.run("fix turn.mpf -o out.mpf --machine angle.toml".split_whitespace()).exits(0);
        shop.run(command.split_whitespace()).exits(0).says("W0332").says("EX0C (offset of C in X)");
    }
    // Probed balls show all four, with one parameter or with all.
    let text = calibrate(&shop, "balls.csv", "angle.toml", "EX0C", "both.toml");
    assert!(["EX0C", "EY0C", "EA0C", "EB0C"].iter().all(|name| !list(&text).contains(name)), "{text}");
    let mut values = text.lines().filter_map(|line| line.strip_prefix("EX0C = ")?.split_whitespace().next());
    let place: f64 = values.find_map(|value| value.parse().ok()).unwrap();
    assert!((place - 15.0).abs() < 0.1, "{place}");
}

#[test]
fn a_place_of_the_spindle_belongs_to_the_axis_that_turns_it() {
    let file = MILL.replace("wFXYZSt", "wFXYZASt")
        + "[axis.A]\ndirection = [1, 0, 0]\npoint_mm = [0, 0, 150]\ntravel_deg = [-60, 60]\n\
           [[motion]]\ncomponent = \"EAA\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-5]\n\
           [measured]\nX_mm = [0, 500]\nY_mm = [0, 400]\nZ_mm = [0, 300]\nA_deg = [-60, 60]\n";
    let cut = |turn: &str| format!("G90 G71 G17\nG0 X100 Y50 Z100 A0\nG1 X400 {turn} F500\nM30\n");
    let codes = |names: &str, turn: &str| {
        let shop = Shop::new().file("m.toml", format!("{file}not_shown = {names}\n")).file("cut.mpf", cut(turn));
        fix(&shop, "cut.mpf", "m.toml").codes()
    };
    assert_eq!(codes("[\"EY0S\"]", "A20"), ["W0332"]);
    assert!(codes("[\"EY0S\"]", "A0").is_empty());
    assert!(codes("[]", "A20").is_empty());
    // An error that the file states is known, and a linear axis has a squareness, and no place.
    let shop = Shop::new().file("m.toml", format!("{file}not_shown = [\"EX0X\", \"EC0S\", \"EX0B\"]\n"));
    shop.run(["machine", "check", "m.toml"]).exits(4).says("EX0X").says("EX0B");
    let stated = format!("{file}not_shown = [\"EY0S\"]\n[location]\nEY0S = 3.0\n");
    let shop = Shop::new().file("m.toml", stated).file("cut.mpf", cut("A20"));
    assert!(fix(&shop, "cut.mpf", "m.toml").codes().is_empty());
}

/// A table C on Y, which turns about (400, 300) against +Z for C+.
const TURNING: &str = "[machine]\nname = \"m\"\ntopology = \"wCYFXZSt\"\n[control]\ninitial_zero_offset = \"G500\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 800]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 600]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 500]\n\
    [axis.C]\ndirection = [0, 0, -1]\npoint_mm = [400, 300, 0]\ntravel_deg = [-360, 360]\n";

/// Readings of a nest 160 mm beside C, with the tool in it, at these heights, on a machine without errors: noise of ± 0.1 µm in turn.
fn nest(heights_mm: &[f64]) -> String {
    let mut rows = String::from("setup,X,Y,Z,C,C_dir,tool_z_mm,dx_um,dy_um,dz_um\n");
    for z in heights_mm {
        for k in 0..12 {
            let c = f64::from(30 * k).to_radians();
            let sign = if k % 3 == 0 { 0.1 } else { -0.1 };
            let [x, y] = [400.0 + 160.0 * c.cos(), 300.0 - 160.0 * c.sin()];
            writeln!(rows, "{z},{x:.6},{y:.6},{z},{},1,-180,{sign},{},{sign}", 30 * k, -sign).unwrap();
        }
    }
    rows
}

/// The tilt of Z moves all readings at one height alike, as an offset of C does: a second height separates them.
#[test]
fn a_squareness_that_a_nest_at_one_height_does_not_separate_is_named() {
    let mut lasers = String::from("component,X,Y,Z,C,value_um\n");
    for k in 0..=10 {
        let (k, sign) = (f64::from(k), if k % 3 == 0 { 0.1 } else { -0.1 });
        writeln!(lasers, "EXX,{},300,200,0,{sign}", 80.0 * k).unwrap();
        writeln!(lasers, "EYY,400,{},200,0,{sign}", 60.0 * k).unwrap();
        writeln!(lasers, "EZZ,400,300,{},0,{sign}", 50.0 * k).unwrap();
    }
    let free = |kind: &str| format!("[measurement]\nkind = \"{kind}\"\nsigma_um = 0.1\nfree = [\"offset\"]\n");
    let shop = Shop::new()
        .file("start.toml", TURNING)
        .file("lasers.csv", lasers)
        .file("lasers.toml", free("direct"))
        .file("one.csv", nest(&[330.0]))
        .file("one.toml", free("displacement"))
        .file("two.csv", nest(&[330.0, 430.0]))
        .file("two.toml", free("displacement"))
        .file("part.mpf", "G90 G71 G17\nG0 X300 Y200 Z300\nG1 X500 Z350 F500\nG1 Y400\nM30\n");
    let calibrate = |data: &str| {
        shop.run(format!("calibrate lasers.csv {data} --machine start.toml -o {data}.toml").split_whitespace()).exits(0)
    };
    let not_shown = |data: &str| {
        let text = shop.text(&format!("{data}.toml"));
        text.lines().find(|line| line.starts_with("not_shown")).unwrap_or_default().to_owned()
    };
    let run = calibrate("one.csv").says("W0605").says("at a second position of Z");
    assert!(!run.stderr.contains("three more angles"), "{}", run.stderr);
    let listed = not_shown("one.csv");
    assert!(listed.contains("\"EB0Z\"") && listed.contains("\"EA0Z\""), "{listed}");
    // Z stands in the nest, so its straightness is not shown either.
    assert!(listed.contains("\"EXZ\"") && listed.contains("\"EYZ\"") && !listed.contains("\"EZZ\""), "{listed}");
    let run = fix(&shop, "part.mpf", "one.csv.toml");
    assert!(run.codes().contains(&"W0330".to_owned()), "{:?}", run.codes());
    assert_eq!(run.json()["verdict"]["grade"], "warn");
    calibrate("two.csv");
    let listed = not_shown("two.csv");
    assert!(!listed.contains("EB0Z") && !listed.contains("EA0Z"), "{listed}");
}

/// Two tool lengths, each with a table ball in a place of its own: a tilt of the spindle moves the whole circle, and the free centers take it up.
#[test]
fn a_tilt_that_free_centers_take_up_is_named() {
    let head = "run,setup,X,Y,Z,tool_z_mm,dr_um\n";
    let rows = |setup: &str, tool_mm: &str| -> String {
        let rows = circle();
        let rows = rows.lines().skip(1).map(|row| {
            let cells: Vec<&str> = row.split(',').collect();
            format!("{setup},{setup},{},{},{},{tool_mm},{}\n", cells[2], cells[3], cells[4], cells[5])
        });
        rows.collect()
    };
    let description =
        |places: &str| format!("[measurement]\nkind = \"ballbar\"\nsigma_um = 0.2\nfree = [\"centre\"]\n{places}");
    let place = |setup: &str, z: &str| format!("[setup.{setup}]\ncentre_mm = [250, 200, {z}]\nlength_mm = 150\n");
    let shop = shop()
        .file("two.csv", format!("{head}{}{}", rows("A", "-80"), rows("B", "-200")))
        .file("two.toml", description(&format!("{}{}", place("A", "20"), place("B", "-100"))))
        .file("single.csv", format!("{head}{}", rows("A", "-80")))
        .file("single.toml", description(&place("A", "20")))
        .file("tilted.toml", format!("{MILL}[location]\nEA0S = 10.0\nEB0S = 10.0\n"));
    let text = calibrate(&shop, "two.csv", "start.toml", "EC0Y,EXX1,EYY1", "both.toml");
    assert!(text.contains("tool_length_mm = [80.0, 200.0]"), "{text}");
    assert!(text.contains("\"EA0S\", \"EB0S\", "), "{text}");
    let run = fix(&shop, "both.mpf", "both.toml");
    assert!(run.codes().contains(&"W0332".to_owned()), "{}", run.stdout);
    assert!(run.stdout.contains("EA0S (tilt of the spindle about X)"), "{}", run.stdout);
    // With one length, W0318 names every other one. A stated tilt is known.
    for (data, start) in [("single.csv", "start.toml"), ("two.csv", "tilted.toml")] {
        let text = calibrate(&shop, data, start, "EC0Y,EXX1,EYY1", "other.toml");
        let listed = text.lines().find(|line| line.starts_with("not_shown")).unwrap_or_default();
        assert!(!listed.contains("EA0S") && !listed.contains("EB0S"), "{data}: {listed}");
    }
}

/// A ball-bar of unknown length in three planes: all axes are 20 µm/m too long, which lengthens the bar. The differences of the scales are shown, and none of
/// the scales. A backlash of Z says nothing about its scale.
#[test]
fn scales_relative_to_each_other_are_not_shown() {
    let bar = |first: usize, second: usize| {
        let center = [250.0, 200.0, 150.0];
        let mut rows = "run,setup,X,Y,Z,tool_x_mm,tool_y_mm,tool_z_mm,dr_um\n".to_owned();
        for (run, sense) in [("ccw", 1.0), ("cw", -1.0)] {
            for k in 0..=72 {
                let angle = sense * 5.0 * f64::from(k).to_radians();
                let mut at = center;
                at[first] += 100.0 * angle.cos();
                at[second] += 100.0 * angle.sin();
                // 20 µm/m of 100 mm, and readings to a tenth.
                let noise = 0.1 * f64::from((7 * k) % 5 - 2);
                writeln!(rows, "{run},A,{:.5},{:.5},{:.5},0,0,-100,{:.3}", at[0], at[1], at[2], 2.0 + noise).unwrap();
            }
        }
        rows
    };
    let description = "[measurement]\nkind = \"ballbar\"\nsigma_um = 0.2\nfree = [\"centre\", \"length\"]\n[setup.A]\n\
        centre_mm = [250, 200, 50]\nlength_mm = 100\n";
    let mut shop = Shop::new().file("m.toml", MILL);
    for (name, [first, second]) in [("xy", [0, 1]), ("yz", [1, 2]), ("zx", [2, 0])] {
        shop = shop.file(&format!("{name}.csv"), bar(first, second)).file(&format!("{name}.toml"), description);
    }
    for model in ["EC0Y,EB0Z,EA0Z,EXX1,EYY1", "EC0Y,EB0Z,EA0Z,EXX1,EYY1,EXXb,EYYb,EZZb"] {
        let arguments = format!("calibrate xy.csv yz.csv zx.csv --machine m.toml --model {model} -o fitted.toml");
        shop.run(arguments.split_whitespace()).exits(0);
        let text = shop.text("fitted.toml");
        let listed = text.lines().find(|line| line.starts_with("not_shown")).unwrap_or_default();
        for name in ["EXX", "EYY", "EZZ"] {
            assert!(listed.contains(&format!("\"{name}\"")), "{model}: {listed}");
        }
    }
}
