//! A squareness that no reading shows: the calibration says so, and no correction that needs it is green.

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
    shop.run(words.split_whitespace()).exits(0)
}

#[test]
fn a_squareness_that_no_reading_shows_is_named() {
    let shop = shop();
    let text = calibrate(&shop, "lines.csv", "start.toml", "EXX1,EYY1,EYX2", "lines_only.toml");
    assert!(text.contains("not_shown = [\"EC0Y\", \"EZX\", \"EXY\", \"EZY\"]"), "{text}");
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
    assert!(text.contains("not_shown = [\"EZX\", \"EZY\"]") && text.contains("EC0Y"), "{text}");
    assert_eq!(fix(&shop, "both.mpf", "circle_too.toml").codes(), ["W0332"]);
    // Both together.
    let text = calibrate(&shop, "lines.csv circle.csv", "start.toml", "EXX1,EYY1,EYX2,EC0Y", "together.toml");
    assert!(text.contains("not_shown = [\"EZX\", \"EZY\"]"), "{text}");
    // Stated by hand before or after the calibration.
    let stated = shop.file("stated.toml", format!("{MILL}[location]\nEC0Y = 12.0\n"));
    let text = calibrate(&stated, "lines.csv", "stated.toml", "EXX1,EYY1,EYX2", "by_hand.toml");
    assert!(text.contains("not_shown = [\"EZX\", \"EXY\", \"EZY\"]"), "{text}");
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
    assert!(shop.text("lacking.toml").contains("not_shown = [\"EC0Y\", \"EZX\", \"EZY\"]"));
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
    assert!(text.contains("not_shown = [\"EC0Y\", \"EZX\", \"EXY\", \"EZY\"]"), "{text}");
    let run = fix(&shop, "one.mpf", "lines_only.toml");
    assert_eq!(run.codes(), ["W0332"]);
    assert!(run.stdout.contains("EZX (straightness of X in Z)"), "{}", run.stdout);
    let json = run.json();
    assert_eq!(json["coverage"]["gaps"][0]["components"], serde_json::json!(["EZX"]));
    assert_eq!(json["verdict"]["grade"], "warn");
    // A ball-bar in XY shows the bow of Y along X, and no motion along Z.
    let text = calibrate(&shop, "lines.csv circle.csv", "start.toml", "EXX1,EYY1,EYX2,EC0Y", "together.toml");
    assert!(text.contains("not_shown = [\"EZX\", \"EZY\"]"), "{text}");
    // What the file states is known, and what is removed by hand too.
    let stated = "[[motion]]\ncomponent = \"EZX\"\nkind = \"polynomial\"\ncoefficients = [0, 0, 1e-9]\n";
    let shop =
        shop.file("removed.toml", text.replace("\"EZX\", ", "")).file("stated.toml", format!("{text}\n{stated}"));
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
    assert!(text.contains("not_shown = [\"EZX\", \"EXY\", \"EZY\"]"), "{text}");
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
    // 2.24 · 0.6 · 10 µm: of the magnitudes of a normal amount, 97.5 % are below 2.24.
    assert!(low < 1.0 && high > 10.0 && high < 15.0, "{low} {high}");
    let [_, high] = along_x("[zero_offset.G54.set_at]\ntool_length_mm = 100.0\n");
    assert!(high < 1.0, "{high}");
}
