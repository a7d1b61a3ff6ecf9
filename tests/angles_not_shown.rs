//! Angles of linear axes that no reading shows: the calibration names them, and no correction over their arms is green.

use std::fmt::Write as _;

use crate::support::{Run, Shop};

/// Three axes at the tool: F carries X, X carries Y, Y carries Z.
const MILL: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\n[control]\ninitial_zero_offset = \"G500\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n";
/// Within the measured ranges, at one height.
const PART: &str = "G90 G71 G17\nG0 X100 Y50 Z100\nG1 X400 F500\nG1 Y300\nM30\n";
const HEAD: &str = "setup,component,X,Y,Z,tool_z_mm,value_um,value_urad\n";
const SQUARE: &str = "[measurement]\nkind = \"direct\"\nsigma_um = 0.1\nsigma_urad = 0.1\nfree = [\"offset\"]\n";
const STRAIGHTEDGE: &str =
    "[measurement]\nkind = \"direct\"\nsigma_um = 0.1\nsigma_urad = 0.1\nfree = [\"offset\", \"slope\"]\n";
/// Lines through this place.
const CENTER: [f64; 3] = [250.0, 200.0, 100.0];
/// Errors that three lines do not show.
const ALL_ANGLES: &str = "EAX, EBX, ECX, EAY, EBY";

/// Readings of components along one axis of a machine without errors, through a place: noise of ± 0.1 µm or µrad in turn.
fn along(axis: usize, components: &str, through: [f64; 3], tool_z_mm: f64) -> String {
    let mut rows = String::new();
    let travel_mm = [500.0, 400.0, 300.0][axis];
    let [x, y, z] = through;
    let setup = format!("{axis} {x} {y} {z} {tool_z_mm}");
    for component in components.split(' ') {
        for k in 0..=8 {
            let mut place = through;
            place[axis] = travel_mm * f64::from(k) / 8.0;
            let noise = if k % 3 == 0 { "0.1" } else { "-0.1" };
            let cells = if "ABC".contains(&component[1..2]) { format!(",{noise}") } else { format!("{noise},") };
            let [x, y, z] = place;
            writeln!(rows, "{setup},{component},{x},{y},{z},{tool_z_mm},{cells}").unwrap();
        }
    }
    rows
}

/// Positioning and straightness along one line of each axis.
fn three_lines() -> String {
    along(0, "EXX EYX EZX", CENTER, 0.0) + &along(1, "EXY EYY EZY", CENTER, 0.0) + &along(2, "EXZ EYZ EZZ", CENTER, 0.0)
}

/// Calibrates a machine with these rows of components.
fn calibrated(start: &str, rows: &str, description: &str) -> Shop {
    calibrated_with("EXX1", start, rows, description)
}

fn calibrated_with(model: &str, start: &str, rows: &str, description: &str) -> Shop {
    let shop = Shop::new()
        .file("start.toml", start)
        .file("readings.csv", format!("{HEAD}{rows}"))
        .file("readings.toml", description)
        .file("part.mpf", PART);
    let words = format!("calibrate readings.csv --machine start.toml --model {model} -o out.toml");
    shop.run(words.split(' ')).exits(0);
    shop
}

/// The list in a machine file; empty without one.
fn list(shop: &Shop) -> String {
    let text = shop.text("out.toml");
    let found = text.lines().find_map(|line| line.strip_prefix("not_shown = "));
    found.unwrap_or_default().replace(['"', '[', ']'], "")
}

fn fix(shop: &Shop, machine: &str) -> Run {
    let words = format!("fix part.mpf -o cut.mpf --machine {machine} --review page.html --json");
    shop.run(words.split(' ')).exits(0)
}

#[test]
fn three_lasers_and_straightnesses_show_no_angle() {
    let shop = calibrated(MILL, &three_lines(), SQUARE);
    // Y turns about itself and Z about all three without an effect: the tip is on the axis of the spindle, and it has one length. So do angles of Y about Z.
    assert_eq!(list(&shop), ALL_ANGLES);
    let run = fix(&shop, "out.toml");
    assert_eq!(run.codes(), ["W0332"]);
    let json = run.json();
    let gaps = json["coverage"]["gaps"].as_array().unwrap();
    let of = |k: usize| (gaps[k]["kind"].as_str().unwrap(), gaps[k]["axis"].as_str().unwrap(), &gaps[k]["components"]);
    assert_eq!(of(0), ("angle", "X", &serde_json::json!(["EAX", "EBX", "ECX"])));
    assert_eq!(of(1), ("angle", "Y", &serde_json::json!(["EAY", "EBY"])));
    assert_eq!((gaps.len(), &json["verdict"]["grade"]), (2, &"warn".into()));
    // The program is at Y 50 to 300 and Z 100, the measurement at Y 0 to 400 and Z 0 to 300. The roll of X has the longest arm: 350 mm along Y and 200 mm along Z.
    let arm = |k: usize| gaps[k]["um_per_urad"].as_f64().unwrap();
    assert!((arm(0) - 0.350_f64.hypot(0.200)).abs() < 1e-9 && (arm(1) - 0.200).abs() < 1e-9, "{gaps:#?}");
    let text = shop.run("fix part.mpf -o cut.mpf --machine out.toml".split(' ')).exits(0).says("EAX (roll of X), EBX");
    text.says("a change of one of them by 10 µrad shifts the tool by up to 4.03 µm").says("a level");
    for command in ["check part.mpf --machine out.toml", "verify part.mpf cut.mpf --machine out.toml"] {
        shop.run(command.split(' ')).exits(0).says("W0332").says("EBY (roll of Y)");
    }
    let words = "fix part.mpf -o cut.mpf --machine out.toml --require-coverage";
    shop.run(words.split(' ')).exits(4).says("error[E0322]: X and Y move").says("roll of X");
}

#[test]
fn each_angle_disappears_with_the_reading_that_shows_it() {
    // Y 0 and Z 300 are beside the lines through the center: EBX changes the scale with the height, ECX with Y.
    let further = [
        (along(0, "EXX", [250.0, 200.0, 300.0], 0.0), "EAX, ECX, EAY, EBY"),
        (along(0, "EXX", [250.0, 0.0, 100.0], 0.0), "EAX, EBX, EAY, EBY"),
        (along(1, "EYY", [250.0, 200.0, 300.0], 0.0), "EAX, EBX, ECX, EBY"),
        // Between both lines lies a combination of pitch and yaw: neither is shown.
        (along(0, "EXX", [250.0, 0.0, 300.0], 0.0), ALL_ANGLES),
        // A level shows a roll.
        (along(0, "EAX", CENTER, 0.0), "EBX, ECX, EAY, EBY"),
        (along(1, "EBY", CENTER, 0.0), "EAX, EBX, ECX, EAY"),
        // A straightness at another height and in the same direction shows that X rolls.
        (along(0, "EYX", [250.0, 200.0, 300.0], 0.0), "EBX, ECX, EAY, EBY"),
    ];
    for (rows, left) in &further {
        let shop = calibrated(MILL, &(three_lines() + rows), SQUARE);
        assert_eq!(list(&shop), *left, "{rows}");
    }
    // An alignment of its own takes up the roll.
    let aligned = calibrated(MILL, &(three_lines() + &further[6].0), STRAIGHTEDGE);
    assert!(list(&aligned).contains("EAX"), "{}", list(&aligned));
    // All together.
    let all: String = [0, 1, 2, 4, 5].map(|k| further[k].0.as_str()).concat();
    let shop = calibrated(MILL, &(three_lines() + &all), SQUARE);
    assert_eq!(list(&shop), "");
    assert!(fix(&shop, "out.toml").codes().is_empty());
}

#[test]
fn a_second_tool_length_gives_the_angles_of_the_last_axis_an_effect() {
    // The tools of 0 and 100 mm lie along Z: pitch and yaw of Z displace their tips, and its roll does not.
    let longer = along(0, "EXX", [250.0, 200.0, 200.0], -100.0);
    let shop = calibrated(MILL, &(three_lines() + &longer), SQUARE);
    assert_eq!(list(&shop), "EA0S, EB0S, EAX, EBX, ECX, EAY, EBY, EAZ, EBZ");
    // The straightness of Z at both lengths shows them, with the same direction of the reference.
    let lines = along(2, "EXZ EYZ", CENTER, -100.0);
    let shop = calibrated(MILL, &(three_lines() + &longer + &lines), SQUARE);
    assert!(!list(&shop).contains("EAZ") && !list(&shop).contains("EBZ"), "{}", list(&shop));
    let shop = calibrated(MILL, &(three_lines() + &longer + &lines), STRAIGHTEDGE);
    assert!(list(&shop).contains("EAZ, EBZ"), "{}", list(&shop));
}

#[test]
fn readings_in_the_whole_volume_show_every_angle() {
    let mut rows = String::from("setup,X,Y,Z,tool_z_mm,dx_um,dy_um,dz_um\n");
    for k in 0..54 {
        let [x, y, z] = [k % 3, k / 3 % 3, k / 9 % 3].map(f64::from);
        let tool_mm = if k < 27 { -60 } else { -160 };
        let noise = if k % 4 == 0 { 0.1 } else { -0.1 };
        writeln!(rows, "1,{},{},{},{tool_mm},{noise},{},{noise}", 250.0 * x, 200.0 * y, 150.0 * z, -noise).unwrap();
    }
    for free in ["\"offset\"", "\"offset\", \"rotation\""] {
        let shop = Shop::new()
            .file("start.toml", MILL)
            .file("part.mpf", PART)
            .file("grid.csv", &rows)
            .file("grid.toml", format!("[measurement]\nkind = \"displacement\"\nsigma_um = 0.1\nfree = [{free}]\n"));
        shop.run("calibrate grid.csv --machine start.toml --model EXX1 -o out.toml".split(' ')).exits(0);
        let angles = ["EAX", "EBX", "ECX", "EAY", "EBY", "ECY", "EAZ", "EBZ", "ECZ"];
        assert!(angles.iter().all(|name| !list(&shop).contains(name)), "{}", list(&shop));
    }
}

#[test]
fn axes_that_are_measured_one_after_another_show_no_angle_either() {
    // X alone has no arm. With Y and Z, its angles have one.
    let lines = [along(0, "EXX", CENTER, 0.0), along(1, "EYY", CENTER, 0.0) + &along(2, "EZZ", CENTER, 0.0)];
    let shop = calibrated(MILL, &lines[0], SQUARE);
    assert_eq!(list(&shop), "EYX, EZX");
    let shop = calibrated_with("EYY1", &shop.text("out.toml"), &lines[1], SQUARE);
    assert!(list(&shop).ends_with(ALL_ANGLES), "{}", list(&shop));
    // A later measurement of one of them leaves the others.
    let shop = calibrated(&shop.text("out.toml"), &along(0, "EXX EAX", CENTER, 0.0), SQUARE);
    assert!(list(&shop).ends_with("EBX, ECX, EAY, EBY") && !list(&shop).contains("EAX"), "{}", list(&shop));
}

#[test]
fn an_angle_that_is_stated_or_has_no_arm_is_no_gap() {
    let shop = calibrated(MILL, &three_lines(), SQUARE);
    let text = shop.text("out.toml");
    let stated: String = ALL_ANGLES
        .split(", ")
        .map(|name| format!("[[motion]]\ncomponent = \"{name}\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-9]\n"))
        .collect();
    // By hand before a calibration, after it, and removed from the list.
    let before = calibrated(&format!("{MILL}{stated}"), &three_lines(), SQUARE);
    assert_eq!(list(&before), "");
    let shop = shop
        .file("stated.toml", format!("{text}\n{stated}"))
        .file("removed.toml", text.replace("\"EAX\", \"EBX\", \"ECX\", \"EAY\", \"EBY\"", ""));
    for machine in ["stated.toml", "removed.toml"] {
        assert!(fix(&shop, machine).codes().is_empty(), "{machine}");
    }
    // Z alone moves: the angles of X and Y are those of a place.
    let shop = shop.file("part.mpf", "G90 G71 G17\nG0 X100 Y50 Z100\nG1 Z50 F500\nM30\n");
    assert!(fix(&shop, "out.toml").codes().is_empty());
}

#[test]
fn the_order_of_the_axes_decides_which_angles_have_an_effect() {
    // F carries X, X the table Y: the tip is at (0, 0, z) in F. X lifts its point of the table at (−x, 0, z), Y at (−x, −y, z). A yaw of X then moves the table by
    // a function of x alone, as a straightness does. That of Y moves it by x times the yaw.
    let tables = MILL
        .replace("wFXYZSt", "wYXFZSt")
        .replace("direction = [1, 0, 0]", "direction = [-1, 0, 0]")
        .replace("direction = [0, 1, 0]", "direction = [0, -1, 0]");
    assert_eq!(list(&calibrated(&tables, &three_lines(), SQUARE)), "EAX, EBX, EAY, EBY, ECY");
    // X carries the table, and Y the spindle: the arms are those of the mill with three axes at the tool.
    let one_table = MILL.replace("wFXYZSt", "wXFYZSt").replace("direction = [1, 0, 0]", "direction = [-1, 0, 0]");
    assert_eq!(list(&calibrated(&one_table, &three_lines(), SQUARE)), ALL_ANGLES);
}
