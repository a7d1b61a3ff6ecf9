//! `ncfix import`: files with wrong or missing data, and options that contradict the file, end in a question, a refusal or a warning.

use std::fmt::Write as _;

use crate::import::{Noise, import, shop};

/// A circle of the ball-bar, one reading per degree: angle, and 0.1 µm more for each ten degrees.
fn circle(head: &str, degrees: impl Iterator<Item = u32>) -> String {
    let mut text = format!("{head}Angle (deg);Run 1 CCW (µm)\n");
    for deg in degrees {
        let _ = writeln!(text, "{deg};{:.2}", f64::from(deg) / 100.0);
    }
    text
}

/// Options for a circle at a place of the machine.
const CENTER: &[&str] = &["--at", "X300,Y250,Z100", "--tool", "0"];

#[test]
fn an_option_that_contradicts_the_file_is_refused() {
    let head = "Test plane;XY\nTest radius (mm);150.0000\nFeedrate (mm/min);1000.0\n";
    let shop = shop().file("bar.csv", circle(head, 0..=360));
    // The words before the facts are understood.
    let run = import(&shop, "bar.csv", "tool.toml", CENTER).exits(0);
    assert!(run.stderr.contains("(line 2: Test radius (mm);150.0000)"), "{}", run.stderr);
    assert!(shop.text("out.toml").contains("length_mm = 150"), "{}", shop.text("out.toml"));
    import(&shop, "bar.csv", "tool.toml", &[CENTER, &["--radius", "150", "--feed", "1000"]].concat()).exits(0);
    for [option, value] in
        [["--radius", "100"], ["--feed", "2000"], ["--plane", "YZ"], ["--sign", "-"], ["--unit", "mm"]]
    {
        let run = import(&shop, "bar.csv", "tool.toml", &[CENTER, &[option, value]].concat());
        run.exits(4).says("E0618").says(&format!("{option}{}", if option == "--plane" { "" } else { " " }));
    }
    let center = format!("{head}Center X;300\n");
    let shop = shop.file("center.csv", circle(&center, 0..=360));
    import(&shop, "center.csv", "tool.toml", CENTER).exits(0);
    import(&shop, "center.csv", "tool.toml", &["--at", "X310,Y250,Z100", "--tool", "0"])
        .exits(4)
        .says("--at X310 contradicts the file");
    // Two lines that differ.
    let shop = shop.file("two.csv", circle(&format!("{head}Radius;100\n"), 0..=360));
    import(&shop, "two.csv", "tool.toml", CENTER).exits(4).says("lines 2 and 4");
}

/// The nominal length has many names, and the center may be one value with all axes.
#[test]
fn length_and_center_of_a_ball_bar_have_many_names() {
    let shop = shop();
    let file = |line: &str| {
        let text = circle(&format!("Test plane;XY\n{line}\n"), 0..=360);
        std::fs::write(shop.path("bar.csv"), text).unwrap();
    };
    for key in [
        "Ballbar length",
        "Ball bar length (mm)",
        "Nominal length",
        "Length",
        "Nennlänge",
        "Longueur nominale",
        "Longueur de la barre",
    ] {
        file(&format!("{key};200 mm"));
        import(&shop, "bar.csv", "tool.toml", &[CENTER, &["--radius", "150"]].concat()).exits(4).says("E0618");
        import(&shop, "bar.csv", "tool.toml", CENTER).exits(0);
        assert!(shop.text("out.toml").contains("length_mm = 200"), "{key}: {}", shop.text("out.toml"));
    }
    // Other lengths are not that of the bar.
    for key in ["Measuring length", "Path length (mm)", "Length of run"] {
        file(&format!("{key};200 mm"));
        import(&shop, "bar.csv", "tool.toml", CENTER).exits(4).says("--radius");
    }
    for center in ["Test centre:;X200 Y250 Z100", "Center;x=200; y=250; z=100"] {
        file(&format!("Radius;150\n{center}"));
        import(&shop, "bar.csv", "tool.toml", CENTER).exits(4).says("--at X300 contradicts the file");
        import(&shop, "bar.csv", "tool.toml", &["--at", "X200,Y250,Z100", "--tool", "0"]).exits(0);
    }
}

/// The line of the axis has several names, and contradicts another axis of the option.
#[test]
fn a_line_with_another_axis_is_refused_whatever_its_name() {
    for key in ["Axis", "Linear axis", "Linearachse", "Measured axis", "Achse"] {
        let text = format!("{key};Y\nTarget [mm];1+ [um]\n0;0.1\n100;2.1\n200;3.3\n");
        let shop = shop().file("axis.csv", text);
        import(&shop, "axis.csv", "tool.toml", &["--axis", "X"]).exits(4).says("--axis X contradicts the file");
    }
}

/// The length of a ball-bar is an unknown, unless the file or the option says that it is calibrated.
#[test]
fn a_calibrated_ball_bar_has_no_unknown_length() {
    let head = "Test plane,XY\nTest radius (mm),150.0000\nBallbar S/N,0P4711\n";
    let text = |line: &str| circle(&format!("{head}{line}"), 0..=360).replace(';', ",").replace("µm", "um");
    let shop = shop()
        .file("open.csv", text(""))
        .file("yes.csv", text("Calibrated length used,Yes\n"))
        .file("no.csv", text("Calibrated length used,No\n"));
    let free = |file: &str, more: &[&str]| {
        import(&shop, file, "tool.toml", &[CENTER, more].concat()).exits(0);
        let toml = shop.text("out.toml");
        toml.lines().find(|line| line.starts_with("free")).unwrap_or_default().to_owned()
    };
    let [known, unknown] = ["free = [\"centre\"]", "free = [\"centre\", \"length\"]"];
    assert_eq!(free("open.csv", &[]), unknown);
    assert_eq!(free("no.csv", &[]), unknown);
    // A calibrated length counts only with the temperature of the bar.
    for more in [&["--length", "calibrated"][..], &["--length", "calibrated", "--radius", "150"][..]] {
        import(&shop, "open.csv", "tool.toml", &[CENTER, more].concat()).exits(4).says("E0616").says("give --material");
    }
    assert_eq!(free("yes.csv", &["--material", "20C"]), known);
    assert!(!shop.text("out.toml").contains("rod_"), "{}", shop.text("out.toml"));
    assert_eq!(free("open.csv", &["--length", "calibrated", "--material", "11.5@22"]), known);
    for key in ["rod_expansion_per_K = 1.15e-5", "rod_temperature_C = 22"] {
        assert!(shop.text("out.toml").contains(key), "{key}: {}", shop.text("out.toml"));
    }
    // Whoever does not trust the calibration may leave the length open.
    assert_eq!(free("yes.csv", &["--length", "unknown"]), unknown);
    import(&shop, "no.csv", "tool.toml", &[CENTER, &["--length", "calibrated"]].concat())
        .exits(4)
        .says("E0618")
        .says("--length calibrated contradicts the file");
}

/// A bar of 150 mm of steel, calibrated at 20 °C, is 11.5e-6 · 2 · 150 mm = 3.45 µm longer at 22 °C. Where it reads 0, the machine is 23 µm/m too long.
#[test]
fn a_warm_bar_shows_the_length_that_it_has() {
    let mut rows = "Angle (deg);CCW (µm);CW (µm)\n".to_owned();
    let mut noise = Noise(71);
    for deg in (0..=360).step_by(3) {
        let _ = writeln!(rows, "{deg};{:.3};{:.3}", noise.next(0.05), noise.next(0.05));
    }
    let head = "Plane;XY\nRadius (mm);150\nCalibrated length used;Yes\n";
    let shop = shop().file("bar.csv", format!("{head}{rows}"));
    for (material, scale) in [("20C", 0.0), ("11.5@22", 23.0), ("11.5@17", -34.5)] {
        import(&shop, "bar.csv", "tool.toml", &[CENTER, &["--material", material]].concat()).exits(0);
        let found = crate::import::calibrated(&shop, "tool.toml", "EXX1,EYY1");
        for (name, value, _) in &found {
            assert!((value - scale).abs() < 0.5, "{material} {name}: {value}");
        }
    }
}

/// An option that has no effect on a file would be lost without a word: the file is refused; of several files, each is named.
#[test]
fn options_without_an_effect_are_refused() {
    let bar = circle("Plane;XY\nRadius;150\n", 0..=360);
    let axis = laser("Axis;X\nUnit;um\n", "Target [mm];1+;1-");
    let shop = shop().file("bar.csv", bar).file("d/bar.csv", circle("Plane;XY\nRadius;150\n", 0..=360));
    let shop = shop.file("l.csv", axis.clone()).file("d/laser.csv", axis);
    let all = [LASER, &["--material", "20C"]].concat();
    import(&shop, "l.csv", "tool.toml", &all).exits(0);
    for more in [
        &["--radius", "150"][..],
        &["--length", "calibrated"],
        &["--feed", "1000"],
        &["--plane", "XY"],
        &["--turn", "ccw"],
        &["--start-angle", "0"],
        &["--flat-reference"],
        &["--reference", "square"],
        &["--turned", "90"],
    ] {
        import(&shop, "l.csv", "tool.toml", &[&all, more].concat()).exits(4).says("E0618").says(more[0]);
    }
    import(&shop, "bar.csv", "tool.toml", CENTER).exits(0);
    for more in [
        &["--reference", "square"][..],
        &["--component", "EYX"],
        &["--axis", "X"],
        &["--start-angle", "0"],
        &["--order", "motion"],
    ] {
        import(&shop, "bar.csv", "tool.toml", &[CENTER, more].concat()).exits(4).says("E0618").says(more[0]);
    }
    // A list of displacements has an artifact at its own temperature only in its description.
    let shop = shop.file("list.csv", "X;Y;Z;dx [µm]\n0;0;100;1.0\n100;0;100;2.5\n200;50;100;3.5\n");
    let list = ["--sign", "+", "--tool", "0", "--material", "11.5@22"];
    import(&shop, "list.csv", "tool.toml", &list).exits(4).says("E0618").says("[artefact]");
    // In a folder an answer may be for some of the files.
    let folder = |more: &[&'static str]| {
        let words =
            ["import", "d", "--machine", "tool.toml", "--force", "-o", "out_d", "--tool", "0", "--sign", "laser=+"];
        let more =
            ["--material", "20C", "--at", "bar=X300,Y250,Z100", "--at", "laser=Y250,Z100"].iter().chain(more).copied();
        shop.run(words.into_iter().chain(more))
    };
    folder(&["--radius", "150"]).exits(0).says("laser.csv: --radius has no effect");
    folder(&["--turned", "90"]).exits(4).says("E0618").says("--turned has no effect on the readings of these files");
    folder(&["--radius", "laser=150"]).exits(4).says("E0618").says("laser.csv");
}

/// Three planes of one ball-bar in one command: each file states its plane, and all are written, or none.
#[test]
fn several_files_are_imported_together_or_not_at_all() {
    let plane = |name: &str| circle(&format!("plane;{name}\nradius_mm;150\n"), 0..=360);
    let shop = shop()
        .file("xy.csv", plane("XY"))
        .file("yz.csv", plane("YZ"))
        .file("xy.txt", plane("XY"))
        .file("open.csv", circle("radius_mm;150\n", 0..=360));
    let all = |files: &[&str], output: &str| {
        let words = [&["import"], files, &["--machine", "tool.toml", "-o", output], CENTER].concat();
        shop.run(words)
    };
    let run = all(&["xy.csv", "yz.csv"], "planes").exits(0);
    for part in ["xy.csv\n361 readings", "yz.csv\n361 readings", "wrote planes/yz.csv and planes/yz.toml"] {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
    // At 0° the bar is along X in one plane, and along Y in the other.
    let first = |file: &str| shop.text(file).lines().nth(1).unwrap().to_owned();
    assert!(first("planes/xy.csv").contains(",450,250,100,"), "{}", first("planes/xy.csv"));
    assert!(first("planes/yz.csv").contains(",300,400,100,"), "{}", first("planes/yz.csv"));
    all(&["xy.csv", "open.csv"], "other").exits(4).says("open.csv: the file does not state the plane of the circle");
    assert!(!shop.path("other").exists());
    all(&["xy.csv", "xy.txt"], "other").exits(2).says("two files have the name xy");
    // Without --force nothing is replaced, and nothing else is written.
    all(&["xy.csv", "yz.csv"], "planes").exits(2).says("exists");
}

/// A table of a laser with one run in both directions, 0 to 600 mm.
fn laser(head: &str, title: &str) -> String {
    let mut text = format!("{head}{title}\n");
    for k in 0..7 {
        let x = f64::from(100 * k);
        let _ = writeln!(text, "{x:.1};{:.2};{:.2}", 0.04 * x + 3.0, 0.04 * x - 3.1);
    }
    text
}

/// Options that answer the questions of a laser, without axis and unit.
const LASER: &[&str] = &["--at", "Y200,Z100", "--sign", "+", "--tool", "0"];

#[test]
fn the_material_and_the_component_of_a_laser_are_those_of_the_file() {
    let head = "Axis;X\nUnit;um\nMaterial temperature (°C);24.0\nExpansion coefficient (ppm/°C);11.7\n";
    let shop = shop().file("l.csv", laser(head, "Target [mm];1+;1-"));
    // The third line has the temperature, and no line says that the readings were converted with it.
    import(&shop, "l.csv", "tool.toml", LASER)
        .exits(4)
        .says("line 3 of the file states 24 °C, and not whether the readings refer to 20 °C");
    for state in ["20C", "11.7@24", "12@24.3"] {
        import(&shop, "l.csv", "tool.toml", &[LASER, &["--material", state]].concat()).exits(0);
    }
    for state in ["11.7@30", "23.8@24"] {
        import(&shop, "l.csv", "tool.toml", &[LASER, &["--material", state]].concat())
            .exits(4)
            .says("--material contradicts");
    }
    let component = |text: &str| {
        import(&shop, "l.csv", "tool.toml", &[LASER, &["--material", "20C", "--component", text]].concat())
    };
    component("EXX").exits(0);
    component("EZY").exits(4).says("E0618").says("--component EZY contradicts the file");
    let columns = ["--material", "20C", "--columns", "target [inch],1+,1-"];
    import(&shop, "l.csv", "tool.toml", &[LASER, &columns].concat())
        .exits(4)
        .says("E0618")
        .says("whose heading says mm");
    // The headings say "correction".
    let shop = shop.file("c.csv", "Axis;X\nTarget [mm];Correction [um]\n0;1.0\n100;2.0\n200;3.5\n");
    import(&shop, "c.csv", "tool.toml", &[LASER, &["--material", "20C"]].concat())
        .exits(4)
        .says("--sign + contradicts");
}

/// A plate of holes as features: nominal and actual position, mm, with a scale of 100 µm/m in X and an offset in Y.
const HOLES: [[f64; 4]; 6] = [
    [0.0, 0.0, 0.0, 0.005],
    [100.0, 0.0, 100.01, 0.005],
    [200.0, 0.0, 200.02, 0.005],
    [0.0, 50.0, 0.0, 50.005],
    [100.0, 50.0, 100.01, 50.005],
    [200.0, 50.0, 200.02, 50.005],
];

/// Options that answer the questions of features in mm.
const PLATE: &[&str] = &["--at", "X100,Y100,Z0", "--sign", "+", "--tool", "0", "--material", "20C"];

/// A table of characteristics: one row for each coordinate, with names of its own, a type and a unit.
fn characteristics(unit: &str, feature: &str) -> String {
    let mut text = format!("planid\tid\ttype\tactual\tnominal\tuppertol\tlowertol\tdeviation\tunit\t{feature}\n");
    for (hole, [x, y, to_x, to_y]) in (1..).zip(HOLES) {
        for (letter, nominal, actual) in [("X", x, to_x), ("Y", y, to_y)] {
            let (own, dev) = (letter.to_lowercase(), actual - nominal);
            let _ = writeln!(
                text,
                "P\t{letter}-Value_Hole {hole}\t{own}Value\t{actual:.4}\t{nominal:.4}\t0.05\t-0.05\t{dev:.4}\t{unit}\tHole {hole}"
            );
        }
        let _ = writeln!(text, "P\tD_Hole {hole}\tdiameter\t12.001\t12.000\t0.05\t-0.05\t0.001\t{unit}\tHole {hole}");
    }
    text
}

#[test]
fn a_table_of_characteristics_has_features_and_not_targets() {
    let shop = shop().file("chr.txt", characteristics("mm", "featureid"));
    import(&shop, "chr.txt", "tool.toml", PLATE).exits(0).says("format: nominal-actual");
    let table = shop.text("out.csv");
    // X 200, Y 50 of the plate is X 300, Y 150 of the machine; 20 µm and 5 µm.
    assert!(table.lines().count() == 7 && table.lines().any(|line| line == "A,300,150,0,0,0,20,5"), "{table}");
    // As a table of a laser it is refused.
    let laser = ["--axis", "X", "--unit", "mm", "--as", "targets"];
    import(&shop, "chr.txt", "tool.toml", &[PLATE, &laser].concat()).exits(4).says("E0618").says("'type' is not read");
    // The unit of the rows counts.
    import(&shop, "chr.txt", "tool.toml", &[PLATE, &["--unit", "inch"]].concat())
        .exits(4)
        .says("--unit inch contradicts");
    let mixed = characteristics("mm", "featureid").replacen("\tmm\t", "\tinch\t", 1);
    let shop = shop.file("mixed.txt", mixed).file("lonely.txt", characteristics("mm", "remark"));
    import(&shop, "mixed.txt", "tool.toml", PLATE).exits(4).says("E0618").says("in mm");
    import(&shop, "lonely.txt", "tool.toml", PLATE).exits(4).says("no two rows belong to one feature");
}

/// A steel plate that was drilled at 26 °C: 11.5 µm/m per K · 6 K = 69 µm/m. At 20 °C the hole at Y 200 is 5.8 µm too near, at 26 °C it was 13.8 − 5.8 µm too far.
#[test]
fn the_check_of_a_warm_plate_is_about_the_converted_reading() {
    let report = |far: f64, near: f64| {
        format!(
            "name;nominal x;nominal y;actual x;actual y\nH1;0;0;0;0\nH2;0;200;0;{far:.4}\nH3;100;0;99.9990;0\nH4;100;100;99.9990;{near:.4}\n"
        )
    };
    let shop = shop().file("drilled.csv", report(199.9942, 99.9971)).file("probed.csv", report(200.0058, 100.0029));
    let check = |file: &str, sign: &str, material: &str| {
        let words = ["--at", "X100,Y100,Z0", "--unit", "mm", "--tool", "0", "--sign", sign, "--material", material];
        import(&shop, file, "tool.toml", &words).exits(0)
    };
    check("drilled.csv", "+", "20C").says("at X 100 Y 300 Z 0 the tool is 5.8 µm too far in -Y");
    check("drilled.csv", "+", "11.5@26").says("at X 100 Y 300 Z 0 the tool is 8.0 µm too far in +Y");
    // A calibrated plate that was probed warm: 5.8 µm were read, and the place was 13.8 µm farther.
    check("probed.csv", "-", "11.5@26").says("at X 100 Y 300 Z 0 the tool is 8.0 µm too far in +Y");
}

#[test]
fn a_column_with_units_in_its_rows_is_not_passed_over() {
    let rows = "Target [mm];Deviation;Unit\n0;1.0;um\n100;2.0;um\n200;3.5;um\n";
    let shop = shop().file("l.csv", rows);
    let more = [LASER, &["--axis", "X", "--material", "20C", "--unit", "um"]].concat();
    import(&shop, "l.csv", "tool.toml", &more).exits(4).says("E0618").says("'Unit' is not read");
    import(&shop, "l.csv", "tool.toml", &[&more[..], &["--columns", "target,dev,-"]].concat()).exits(0);
}

/// Options that answer the questions of a map.
const MAP: &[&str] = &["--flat-reference", "--at", "X0,Y0,Z100", "--tool", "0"];

/// A mesh of Klipper with 3 columns and 2 rows.
fn klipper(from_x: f64, to_x: f64, count_y: u32) -> String {
    format!(
        "#*# [bed_mesh default]\n#*# version = 1\n#*# points =\n#*#   0.0, 0.04, 0.10\n#*#   -0.02, 0.02, 0.08\n\
         #*# x_count = 3\n#*# y_count = {count_y}\n#*# min_x = {from_x}\n#*# max_x = {to_x}\n#*# min_y = 30\n#*# max_y = 330\n"
    )
}

/// A map of a Duet with 3 columns and 2 rows.
fn duet(from_x: f64, to_x: f64, spacing_x: f64) -> String {
    format!(
        "RepRapFirmware height map file v2 generated at 2026-01-01 10:00\n\
         axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\n\
         X,Y,{from_x:.1},{to_x:.1},30.0,130.0,-1.0,{spacing_x:.1},100.0,3,2\n0.000,0.020,0.080\n-0.010,0.010,0.070\n"
    )
}

/// A map of bCNC with 3 columns and 2 rows.
fn bcnc(grid_x: &str, last: &str) -> String {
    format!(
        "{grid_x}\n10 60 2\n-5 5 100\n10 10 0.012\n60 10 -0.034\n110 10 0.021\n10 60 0.043\n60 60 -0.055\n{last} 60 0.012\n"
    )
}

#[test]
fn the_grid_of_a_map_agrees_with_its_points() {
    let plain = klipper(30.0, 430.0, 2).replace("#*# ", "");
    let whole =
        format!("[bed_mesh]\nmesh_min: 30, 30\nspeed: 120\n# probe\n\n[fan]\npin: PA8\n\n{}", klipper(30.0, 430.0, 2));
    let good = [
        plain,
        whole,
        klipper(30.0, 430.0, 2),
        duet(30.0, 230.0, 100.0),
        duet(30.0, 280.0, 100.0),
        bcnc("10 110 3", "110"),
    ];
    let printed = "Bilinear Leveling Grid:\n      0      1      2\n 0 +0.010 +0.020 +0.030\n 1 +0.010 +0.025 +0.030\n";
    let bad = [
        (klipper(430.0, 30.0, 2), "min_x is 430 and max_x is 30"),
        (klipper(30.0, 430.0, 3), "y_count is 3"),
        (duet(30.0, 230.0, 10.0), "do not fit X from 30 to 230"),
        (duet(230.0, 30.0, 100.0), "do not fit X from 230 to 30"),
        (bcnc("110 10 3", "110"), "may be mirrored"),
        (bcnc("10 110 4", "110"), "the map has 6 points, and its grid 8"),
        (bcnc("10 110 3", "120"), "x 120 is not in the grid"),
        (klipper(30.0, 430.0, 2) + "#*# min_x = 50\n", "min_x is stated twice"),
        (printed.replace("+0.010 +0.025", "+0.025"), "the row has 2 values, and the grid 3 columns"),
    ];
    let mut shop = shop();
    let unit = |text: &str| if text.contains("10 60 2") { vec!["--unit", "mm"] } else { Vec::new() };
    let more = |text: &str| {
        let grid = if text.contains("Bilinear") { vec!["--columns", "10,10,50,50"] } else { Vec::new() };
        [MAP.to_vec(), unit(text), grid].concat()
    };
    for text in good.into_iter().chain([printed.to_owned()]) {
        shop = shop.file("map.txt", text.clone());
        import(&shop, "map.txt", "tool.toml", &more(&text)).exits(0);
    }
    for (text, reason) in bad {
        shop = shop.file("map.txt", text.clone());
        import(&shop, "map.txt", "tool.toml", &more(&text)).exits(4).says("E0618").says(reason);
    }
}

/// A plate of holes in inches, as a table of features.
fn inches(head: &str, heading: &str) -> String {
    let mut text = format!("{head}{heading}\n");
    for (hole, own) in (1..).zip(HOLES) {
        let cells: Vec<String> = own.iter().map(|mm| format!("{:.5}", mm / 25.4)).collect();
        let _ = writeln!(text, "H{hole},{}", cells.join(","));
    }
    text
}

#[test]
fn a_line_with_the_unit_counts_in_every_layout() {
    let heading = "Feature,Nominal X,Nominal Y,Actual X,Actual Y";
    let points = "20 10 0.01\n60 10 0.03\n20 50 -0.02\n60 50 0.05\n";
    let touches = "name,dx,dy,X,Y,Z\n1,0.01,0.02,10,10,10\n2,0.03,0.01,20,10,10\n3,0.02,0.04,30,10,10\n";
    let shop = shop()
        .file("plate.csv", inches("Unit,inch\n", heading))
        .file("two.csv", inches("Unit,mm\n", &heading.replace("Actual X", "Actual X (inch)")))
        .file("odd.csv", inches("Unit,elle\n", heading))
        .file("mixed.csv", inches("", &heading.replace("al X", "al X (inch)").replace("al Y", "al Y (mm)")))
        .file("points.txt", format!("# units: mm\n{points}"))
        .file("moves.csv", format!("Unit;mm\n{touches}"))
        .file("bar.csv", circle("plane;XY\nradius_mm;150\nunits;mm\n", 0..=360));
    import(&shop, "plate.csv", "tool.toml", PLATE).exits(0).says("(line 1: Unit,inch)");
    // 200 mm, 50 mm and 20 µm again.
    let table = shop.text("out.csv");
    let row: Vec<f64> = table.lines().nth(6).unwrap().split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
    for (value, expected) in row.iter().zip([300.0, 150.0, 0.0, 0.0, 0.0, 20.0, 5.0]) {
        assert!((value - expected).abs() < 0.3, "{table}");
    }
    for (file, reason) in [("plate.csv", "--unit mm contradicts"), ("odd.csv", "'elle' is not a unit")] {
        import(&shop, file, "tool.toml", &[PLATE, &["--unit", "mm"]].concat()).exits(4).says("E0618").says(reason);
    }
    import(&shop, "mixed.csv", "tool.toml", PLATE).exits(4).says("E0618").says("inch and mm");
    // Two statements of the file are a question, and the option decides.
    import(&shop, "two.csv", "tool.toml", PLATE).exits(4).says("E0616").says("states two units");
    import(&shop, "two.csv", "tool.toml", &[PLATE, &["--unit", "inch"]].concat()).exits(0);
    import(&shop, "two.csv", "tool.toml", &[PLATE, &["--unit", "um"]].concat()).exits(4).says("E0618");
    import(&shop, "points.txt", "tool.toml", MAP).exits(0).says("(line 1: # units: mm)");
    import(&shop, "points.txt", "tool.toml", &[MAP, &["--unit", "inch"]].concat())
        .exits(4)
        .says("--unit inch contradicts");
    let moves = ["--sign", "+", "--tool", "0"];
    import(&shop, "moves.csv", "tool.toml", &moves).exits(0).says("(line 1: Unit;mm)");
    import(&shop, "moves.csv", "tool.toml", &[&moves[..], &["--unit", "um"]].concat()).exits(4).says("E0618");
    // The heading says µm and the line mm.
    import(&shop, "bar.csv", "tool.toml", CENTER).exits(4).says("E0616").says("mm in line 3");
    import(&shop, "bar.csv", "tool.toml", &[CENTER, &["--unit", "um"]].concat()).exits(0);
    let shop = shop.file("map.txt", klipper(30.0, 430.0, 2));
    import(&shop, "map.txt", "tool.toml", &[MAP, &["--unit", "inch"]].concat()).exits(4).says("always in mm");
}

#[test]
fn all_positions_are_asked_in_one_question() {
    let tilting = "[machine]\nname = \"mill\"\ntopology = \"wCAFXYZSt\"\ncontroller = \"sinumerik\"\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-100, 400]\n[axis.A]\ndirection = [1, 0, 0]\npoint_mm = [0, 0, 0]\n\
        travel_deg = [-90, 90]\n[axis.C]\ndirection = [0, 0, 1]\npoint_mm = [0, 0, 0]\nmodulo = true\n\
        [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
    let heading = "Feature,Nominal X,Nominal Y,Actual X,Actual Y";
    let shop = shop()
        .file("tilt.toml", tilting)
        .file("bar.csv", circle("plane;XY\nradius_mm;150\n", 0..=360))
        .file("plate.csv", inches("Unit,inch\n", heading))
        .file("points.txt", "20 10 0.01\n60 10 0.03\n20 50 -0.02\n60 50 0.05\n");
    for file in ["bar.csv", "plate.csv", "points.txt"] {
        let run = import(&shop, file, "tilt.toml", &[]).exits(4);
        let asked = run.stderr.lines().find(|line| line.contains("give --at")).unwrap_or_default();
        for position in ["X0", "Y0", "Z0", "A0", "C0"] {
            assert!(asked.contains(position), "{file}: {}", run.stderr);
        }
    }
}

#[test]
fn a_run_that_has_the_targets_is_refused() {
    let row = |cells: [f64; 5]| format!("{}\n", cells.map(|cell| format!("{cell:.1}")).join(";"));
    let table = |swaps: bool, factor: f64| {
        let mut text = "Target [mm];1+;1-;2+;2-\n".to_owned();
        for k in 0..13 {
            let x = 50.0 * f64::from(k);
            let dev = |offset: f64| factor * (0.04 * x + offset);
            let [target, first] = if swaps { [dev(3.2), x] } else { [x, dev(3.2)] };
            text.push_str(&row([target, first, dev(-3.1), dev(3.0), dev(-2.9)]));
        }
        text
    };
    let shop = shop().file("good.csv", table(false, 1.0)).file("swap.csv", table(true, 1.0));
    let more = [LASER, &["--axis", "X", "--material", "20C", "--unit", "um"]].concat();
    import(&shop, "good.csv", "tool.toml", &more).exits(0);
    // The readings of run 1+ are 0 to 600 µm, those of the others −3 to 27 µm.
    import(&shop, "swap.csv", "tool.toml", &more).exits(4).says("E0618").says("run 1+");
    // One run in positions beside runs of deviations.
    let mut text = "Target [mm];1+;1-;2+;2-\n".to_owned();
    for k in 0..13 {
        let x = 50.0 * f64::from(k);
        text.push_str(&row([x, 3.0 + 0.04 * x, -3.0, x + 0.1, -3.0 + 0.04 * x]));
    }
    let shop = shop.file("one.csv", text);
    import(&shop, "one.csv", "tool.toml", &more).exits(4).says("E0618").says("run 2+ follow the targets");
}

#[test]
fn readings_below_the_noise_are_refused_in_any_unit() {
    let shop = shop().file("nm.csv", laser("Axis;X\nUnit;nm\n", "Target [mm];1+;1-"));
    // 27 nm.
    let run = import(&shop, "nm.csv", "tool.toml", &[LASER, &["--material", "20C"]].concat());
    run.exits(4).says("E0608").says("0.027 µm").says("check the unit in the file");
}

/// The stage of a synchrotron deviates by some nanometers. A heading that states the unit is believed, also by `diagnose`.
#[test]
fn small_readings_whose_heading_states_the_unit_are_believed() {
    let titles: Vec<String> = (1..=5).map(|run| format!("{run}+ [nm];{run}- [nm]")).collect();
    let mut text = format!("Target [mm];{}\n", titles.join(";"));
    let mut noise = Noise(11);
    for k in 0..9 {
        let cells: Vec<String> = (0..10).map(|_| format!("{:.2}", 20.0 + f64::from(k) + noise.next(2.0))).collect();
        let _ = writeln!(text, "{}.0;{}", 10 * k, cells.join(";"));
    }
    let shop = shop().file("nm.csv", text);
    import(&shop, "nm.csv", "tool.toml", &[LASER, &["--axis", "X", "--material", "20C"]].concat()).exits(0);
    assert!(shop.text("out.toml").contains("\nunit = \"stated\""), "{}", shop.text("out.toml"));
    let run = shop.run(["diagnose", "out.csv", "--machine", "tool.toml"]);
    assert!(!run.stderr.contains("less than the errors of any machine"), "{}", run.stderr);
    // Without the statement they are doubted.
    let doubted: String = shop
        .text("out.toml")
        .lines()
        .filter(|line| !line.starts_with("unit"))
        .fold(String::new(), |all, line| all + line + "\n");
    std::fs::write(shop.path("out.toml"), doubted).unwrap();
    shop.run(["diagnose", "out.csv", "--machine", "tool.toml"])
        .exits(4)
        .says("E0614")
        .says("less than the errors of any machine");
}

/// A report in Markdown names the tables that are worth a file of their own.
#[test]
fn a_report_with_several_tables_names_those_with_targets() {
    let table = |title: &str| {
        format!("{title}\n--- | --- | ---\n1 | 0.0 | 0.010\n2 | 50.0 | 50.012\n3 | 100.0 | 100.021\n\nText\n\n")
    };
    let text = ["i | tgt_pos [mm] | ref_pos [mm]", "i | S_fwd [mm] | S_bwd [mm]"].map(table).concat();
    let shop = shop().file("report.md", text);
    import(&shop, "report.md", "tool.toml", &[]).exits(4).says("E0601").says("begin in line 1 (3 rows)");
}

#[test]
fn missing_rows_are_named() {
    let named = |run: crate::support::Run, reason: &str| {
        run.exits(0).says("warning[W0609]").says(reason);
    };
    let head = "plane;XY\nradius_mm;150\n";
    let gap = (0..=360).filter(|deg| !(100..150).contains(deg));
    let shop = shop()
        .file("whole.csv", circle(head, 0..=360))
        .file("gap.csv", circle(head, gap))
        .file("cut.csv", circle(head, 0..=299))
        .file("arc.csv", circle(head, 0..=200));
    for file in ["whole.csv", "arc.csv"] {
        assert!(!import(&shop, file, "tool.toml", CENTER).exits(0).stderr.contains("W0609"), "{file}");
    }
    named(import(&shop, "gap.csv", "tool.toml", CENTER), "between 99° and 150°");
    assert!(
        shop.text("out.toml").contains("# - run 1-ccw has no reading between 99° and 150°"),
        "{}",
        shop.text("out.toml")
    );
    named(import(&shop, "cut.csv", "tool.toml", CENTER), "between 299° and 360°");

    // 15 targets; 200 to 350 mm are missing in all runs, and one cell is empty.
    let mut text = "Target [mm];1+ [um];1- [um]\n".to_owned();
    for x in (0..15).map(|k| 50 * k).filter(|x| !(200..=350).contains(x) && *x <= 600) {
        let _ = writeln!(text, "{x};{}.5;{}", x / 20, if x == 500 { String::new() } else { format!("{}.2", x / 20) });
    }
    let more = [LASER, &["--axis", "X", "--material", "20C"]].concat();
    let shop =
        shop.file("l.csv", text.clone()).file("cells.csv", text.replace("150;7.5;7.2", "150;7.5;7.2\n200;9.5;9.2"));
    named(import(&shop, "l.csv", "tool.toml", &more), "no run has a reading at X 200, X 250, X 300, X 350");
    let shop = shop.file(
        "three.csv",
        text.replace("1- [um]\n", "1- [um];2+ [um]\n").replace(".2\n", ".2;1.1\n").replace(";\n", ";;2.2\n"),
    );
    named(import(&shop, "three.csv", "tool.toml", &more), "no reading at X 500 in run 1-");

    // A grid of holes without one line and one hole.
    let mut plate = "Feature,Nominal X,Nominal Y,Actual X,Actual Y\n".to_owned();
    for (k, [x, y]) in (0..6).flat_map(|j| (0..5).map(move |i| [80 * i, 60 * j])).enumerate() {
        if y != 120 && [x, y] != [160, 180] {
            let _ = writeln!(plate, "H{k},{x}.0,{y}.0,{x}.0{}1,{y}.0{}7", k % 7, k % 5);
        }
    }
    let shop = shop.file("plate.csv", plate);
    let unit = [PLATE, &["--unit", "mm"]].concat();
    let run = import(&shop, "plate.csv", "tool.toml", &unit).exits(0).says("warning[W0609]");
    // The zero of the plate is X 100, Y 100 of the machine.
    assert!(
        run.stderr.contains("no point at Y 220") && run.stderr.contains("no reading at X 260 Y 280"),
        "{}",
        run.stderr
    );

    // A map without one point.
    let mut map = String::new();
    for [x, y] in (0..4).flat_map(|j| (0..5).map(move |i| [80 * i, 60 * j])).filter(|at| *at != [160, 60]) {
        let _ = writeln!(map, "{x}.0 {y}.0 0.0{}", (x + y) % 7);
    }
    let shop = shop.file("map.txt", map);
    named(import(&shop, "map.txt", "tool.toml", &[MAP, &["--unit", "mm"]].concat()), "no reading at X 160 Y 60");
}

/// A report in blocks, with the bar of the tolerance at the end of each row.
fn report(bar: &str) -> String {
    let mut text = String::new();
    for (hole, [x, y, to_x, to_y]) in (1..).zip(HOLES) {
        let _ = writeln!(
            text,
            "DIM LOC{hole}= LOCATION OF CIRCLE CIR{hole}  UNITS=MM ,$\nGRAPH=OFF  TEXT=OFF\nAX NOMINAL +TOL -TOL MEAS DEV OUTTOL"
        );
        for (axis, nominal, actual) in [("X", x, to_x), ("Y", y, to_y), ("D", 12.0, 12.001)] {
            let _ = writeln!(text, "{axis} {nominal:.4} 0.05 0.05 {actual:.4} {:.4} 0.0000{bar}", actual - nominal);
        }
        let _ = writeln!(text, "END OF DIMENSION LOC{hole}\n");
    }
    text
}

#[test]
fn a_report_with_bars_is_read_and_a_cut_one_names_its_end() {
    let whole = report(" ----#----");
    let cut = whole.rfind("Y 50.0000").unwrap();
    let shop = shop()
        .file("bars.txt", whole.clone())
        .file("plain.txt", report(""))
        .file("cut.txt", &whole[..cut])
        .file("wide.txt", report(" 7.5"));
    for file in ["bars.txt", "plain.txt"] {
        assert!(!import(&shop, file, "tool.toml", PLATE).exits(0).stderr.contains("W0609"));
        assert!(shop.text("out.csv").lines().any(|line| line == "A,300,150,0,0,0,20,5"), "{}", shop.text("out.csv"));
    }
    // Without Y the position of the last hole is not known.
    import(&shop, "cut.txt", "tool.toml", PLATE).exits(0).says("W0609").says("not complete, and not read: 1");
    assert_eq!(shop.text("out.csv").lines().count(), 6);
    import(&shop, "wide.txt", "tool.toml", PLATE).exits(4).says("the row has 8 cells, and its heading names 7");
}

#[test]
fn nominal_and_actual_values_that_are_exchanged_are_refused() {
    let heading = "Feature,Nominal X,Nominal Y,Actual X,Actual Y\n";
    let rows: String = (0..5).map(|k| format!("H{k},{0}.0000,60.0000,{0}.03{k}3,59.99{k}7\n", 80 * k)).collect();
    let exchanged = heading.replace("Nominal", "Q").replace("Actual", "Nominal").replace('Q', "Actual");
    let long: String = (0..5).map(|k| format!("{0}.0;{0}.00{k}7\n", 100 * k)).collect();
    let shop = shop()
        .file("good.csv", format!("{heading}{rows}"))
        .file("bad.csv", format!("{exchanged}{rows}"))
        .file("long.csv", format!("Actual [mm];Target [mm]\n{long}"));
    let unit = [PLATE, &["--unit", "mm"]].concat();
    import(&shop, "good.csv", "tool.toml", &unit).exits(0);
    import(&shop, "bad.csv", "tool.toml", &unit).exits(4).says("E0618").says("may be exchanged");
    let columns = ["--columns", "name,actual x,actual y,nominal x,nominal y"];
    import(&shop, "bad.csv", "tool.toml", &[&unit[..], &columns].concat()).exits(0);
    let more = [LASER, &["--axis", "X", "--material", "20C"]].concat();
    import(&shop, "long.csv", "tool.toml", &more).exits(4).says("E0618").says("may be exchanged");
}

#[test]
fn a_deviation_is_reached_minus_target() {
    let table = |last: &str| {
        format!(
            "Target [mm];Reached [mm];Deviation [um]\n0.0;0.0050;5.0\n100.0;100.0100;10.0\n200.0;200.0210;21.0\n300.0;300.0300;{last}\n"
        )
    };
    let shop = shop().file("good.csv", table("30.0")).file("bad.csv", table("12.0"));
    let more = [LASER, &["--axis", "X", "--material", "20C"]].concat();
    import(&shop, "good.csv", "tool.toml", &more).exits(0);
    import(&shop, "bad.csv", "tool.toml", &more).exits(4).says("E0618").says("not the difference");
    let opposite = table("30.0").replace(";5.0", ";-5.0").replace(";10.0", ";-10.0").replace(";21.0", ";-21.0");
    let shop = shop.file("both.csv", opposite);
    import(&shop, "both.csv", "tool.toml", &more).exits(4);
}

#[test]
fn a_point_that_is_given_twice_is_refused() {
    let points = "20 10 0.01\n60 10 0.03\n20 50 -0.02\n60 50 0.05\n";
    let shop = shop()
        .file("again.txt", format!("{points}60 50 0.06\n"))
        .file("twice.txt", format!("{points}20 10 0.01\n"))
        .file("lines.txt", "M421 I0 J0 Z0.01\nM421 I1 J0 Z0.02\nM421 I0 J1 Z0.03\nM421 I1 J1 Z0.05\nM421 I0 J0 Z0.01\n")
        .file("l.csv", "Run;Dir;Target [mm];Dev [um]\n1;+;0;1.0\n1;+;100;2.0\n1;+;200;3.0\n2;+;0;1.0\n1;+;100;2.0\n");
    let unit = [MAP, &["--unit", "mm"]].concat();
    import(&shop, "again.txt", "tool.toml", &unit).exits(0);
    import(&shop, "twice.txt", "tool.toml", &unit).exits(4).says("E0605").says("line 1,");
    let grid = [MAP, &["--columns", "10,10,50,50"]].concat();
    import(&shop, "lines.txt", "tool.toml", &grid).exits(4).says("E0605");
    let more = [LASER, &["--axis", "X", "--material", "20C"]].concat();
    import(&shop, "l.csv", "tool.toml", &more).exits(4).says("E0605").says("line 3,");
}

/// Positions of a short stage: targets of −4 to 4 mm, and deviations of more than one percent of this span in the first run, while it warms up.
#[test]
fn positions_follow_their_targets_and_a_copy_of_the_targets_is_none() {
    let deviations =
        [[1.4, -102.1, -5.0], [-6.5, -119.7, 4.0], [-27.8, -130.1, -2.0], [-25.3, -52.3, 3.0], [3.2, -40.0, 1.0]];
    let table = |second: &dyn Fn(f64, f64) -> f64| {
        let mut text = "Target [mm];Run 1 + [mm];Run 1 - [mm];Run 2 + [mm]\n".to_owned();
        for (k, [up, down, again]) in (0..5).zip(deviations) {
            let x = f64::from(2 * k - 4);
            let [up, down, again] = [up, down, again].map(|um| x + um / 1000.0);
            let _ = writeln!(text, "{x:.1};{up:.4};{down:.4};{:.4}", second(x, again));
        }
        text
    };
    let shop = shop()
        .file("good.csv", table(&|_, again| again))
        .file("copy.csv", table(&|x, _| x))
        .file("far.csv", table(&|x, again| if x == 2.0 { 20.0 } else { again }))
        .file("mixed.csv", table(&|_, again| again).replace("Run 1 + [mm]", "Run 1 + [um]"));
    let more = ["--axis", "X", "--at", "X100,Y200,Z100", "--tool", "0", "--material", "20C"];
    import(&shop, "good.csv", "tool.toml", &more).exits(0).says("actual minus target positions, mm");
    // 2 mm is X 102 of the machine; −52.3 µm.
    assert!(shop.text("out.csv").lines().any(|line| line == "1,A,EXX,102,-1,0,0,0,-52.3"), "{}", shop.text("out.csv"));
    import(&shop, "copy.csv", "tool.toml", &more).exits(4).says("E0618").says("run 2+ are the targets themselves");
    import(&shop, "far.csv", "tool.toml", &more).exits(4).says("E0618").says("run 2+ has 20 at the target 2");
    import(&shop, "mixed.csv", "tool.toml", &more).exits(4).says("E0618");
}

/// A line may state whether the readings refer to 20 °C. At 24 °C a scale of 11.7 µm/m per K is 46.8 µm/m longer.
#[test]
fn a_laser_that_states_its_conversion_to_20_degrees_needs_no_material() {
    let head = |line: &str| {
        format!("Axis;X\nUnit;um\nMaterial temperature (°C);24.0\nExpansion coefficient (ppm/°C);11.7\n{line}\n")
    };
    let heading = "Target [mm];1+;1-";
    let rows_of = |shop: &crate::support::Shop| -> Vec<[f64; 2]> {
        let text = shop.text("out.csv");
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let names = lines.next().unwrap();
        let place = |name: &str| names.iter().position(|own| own == name).unwrap();
        let (x, value) = (place("X"), place("value_um"));
        lines.map(|cells| [x, value].map(|k| cells[k].parse().unwrap())).collect()
    };
    let yes = shop().file("l.csv", laser(&head("Compensated to 20 C: Yes"), heading));
    import(&yes, "l.csv", "tool.toml", LASER).exits(0);
    let converted = rows_of(&yes);
    assert!(yes.text("out.toml").contains("# - the readings refer to 20 °C (line 5"), "{}", yes.text("out.toml"));
    let twice = [LASER, &["--material", "11.7@24"]].concat();
    import(&yes, "l.csv", "tool.toml", &twice).exits(4).says("E0618").says("line 5");
    let no = shop().file("l.csv", laser(&head("Material compensation;Off"), heading));
    import(&no, "l.csv", "tool.toml", LASER).exits(0);
    assert!(no.text("out.toml").contains("11.7 µm/m per K at 24 °C"), "{}", no.text("out.toml"));
    let grown = rows_of(&no);
    assert!(grown.len() == converted.len() && grown.len() > 3);
    for ([x, raw], [_, own]) in converted.iter().zip(&grown) {
        assert!((raw - own - 11.7e-6 * 4.0 * x * 1e3).abs() < 0.01, "{x}: {raw} {own}");
    }
    let plain = [LASER, &["--material", "20C"]].concat();
    import(&no, "l.csv", "tool.toml", &plain).exits(4).says("E0618").says("do not refer to 20 °C");
    // The air of the beam is no material.
    let air = shop().file("l.csv", laser(&head("Air temperature compensation: On"), heading));
    import(&air, "l.csv", "tool.toml", LASER).exits(4).says("E0616");
}
