//! `ncfix simulate` and `ncfix calibrate`: from a plan to readings to the machine file, and what is refused.

use std::fmt::Write as _;

use serde_json::Value;

use crate::import::{Noise, calibrated};
use crate::support::{Shop, repository};

/// Errors of the demo machine for the tests: in the file, and as the report shows them.
const ERRORS: &str = "\n[location]\nEC0X = 16.0\nEB0Z = -12.0\nEA0Z = 9.0\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 3.2e-5, -4.0e-8]\n\
    [[motion]]\ncomponent = \"EYY\"\nkind = \"polynomial\"\ncoefficients = [0, -2.1e-5]\n\
    [[motion]]\ncomponent = \"EZZ\"\nkind = \"polynomial\"\ncoefficients = [0, 1.1e-5]\n\
    [[motion]]\ncomponent = \"EAX\"\nkind = \"polynomial\"\ncoefficients = [0, 2.5e-8]\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 6.0\n";
const SHOWN: &[(&str, f64)] = &[
    ("EC0X", 16.0),
    ("EB0Z", -12.0),
    ("EA0Z", 9.0),
    ("EXX1", 32.0),
    ("EXX2", -40.0),
    ("EYY1", -21.0),
    ("EZZ1", 11.0),
    ("EAX1", 25.0),
    // Half of the reversal.
    ("EXXb", 3.0),
];

/// A sample machine without its errors.
pub(crate) fn bare(name: &str) -> String {
    let text = std::fs::read_to_string(repository(&format!("samples/machines/{name}.toml"))).unwrap();
    let mut is_kept = true;
    let mut out = String::new();
    for line in text.lines() {
        if line.starts_with('[') {
            is_kept = ["[machine]", "[axis.", "[spindle]", "[control]", "[zero_offset", "[[tool]]"]
                .iter()
                .any(|known| line.starts_with(known));
        }
        if is_kept {
            let _ = writeln!(out, "{line}");
        }
    }
    out
}

/// `start.toml` is the demo machine without errors, `true.toml` with those of the tests.
fn three_axes() -> Shop {
    let start = bare("demo");
    Shop::new().file("true.toml", format!("{start}{ERRORS}")).file("start.toml", start)
}

pub(crate) fn simulate(shop: &Shop, plan: &str, output: &str, noise: &str, seed: &str) {
    let arguments = ["simulate", plan, "-o", output, "--machine", "true.toml", "--noise", noise, "--seed", seed];
    shop.run(arguments).exits(0);
}

/// Calibrates, and gives the report.
fn calibrate(shop: &Shop, data: &[&str], model: &str, more: &[&str]) -> Value {
    let mut arguments = vec!["calibrate"];
    arguments.extend(data);
    arguments.extend(["--machine", "start.toml", "--model", model, "-o", "machine.toml", "--json"]);
    arguments.extend(more);
    shop.run(arguments).exits(0).json()
}

/// Esmaeili 2021, 4.7 and 5.9.1: five runs in both directions to eleven targets are 22 poses with five readings each. Their scatter is that of the noise,
/// 2 µm, known to 8 % from 88 repetitions, whatever the model leaves.
#[test]
fn the_scatter_of_repeated_readings_is_pooled() {
    let shop = three_axes().file("scale.txt", "EXX1\n");
    shop.run(["plan", "laser", "--machine", "true.toml", "--axis", "X", "-o", "plan.csv"]).exits(0);
    simulate(&shop, "plan.csv", "laser.csv", "2um", "3");
    let report = calibrate(&shop, &["laser.csv"], "scale.txt", &[]);
    let part = &report["data"][0]["repeated"][0];
    assert_eq!(part["repetitions"], 88, "{report}");
    let sigma = part["sigma"].as_f64().unwrap();
    assert!((sigma - 2.0).abs() < 4.0 * 0.08 * 2.0, "{sigma}");
    // The model of a scale leaves the bow and the backlash of 6 µm too.
    assert!(report["data"][0]["left_rms"].as_f64().unwrap() > 1.2 * sigma, "{report}");
}

/// Every parameter of the list is found within four of its standard uncertainties, which are below a limit.
fn demand(report: &Value, expected: &[(&str, f64)], most: f64) {
    let parameters = report["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), expected.len(), "{report}");
    for (name, value) in expected {
        let one = parameters.iter().find(|one| one["name"] == *name).unwrap_or_else(|| panic!("{name}: {report}"));
        let (found, sigma) = (one["value"].as_f64().unwrap(), one["sigma"].as_f64().unwrap());
        assert!((found - value).abs() < 4.0 * sigma && sigma < most, "{name} {value}: {one}");
    }
}

fn names(expected: &[(&str, f64)]) -> String {
    expected.iter().fold("# as in the test\n".to_owned(), |text, (name, _)| format!("{text}{name} # why\n"))
}

const GRID_TOML: &str = "[measurement] # a grid\nkind = \"displacement\"\n";

fn grid_csv() -> String {
    let mut text = "run;X;Y;Z;X_dir;tool_y_mm;tool_z_mm;remark\n".to_owned();
    for (tool, sense) in [("0;-80", 1), ("60;-180", -1)] {
        for x in [20, 180, 340, 500, 680] {
            for y in [30, 170, 320, 480] {
                for z in [0, 180, 400] {
                    let _ = writeln!(text, "{sense};{x};{y};{z};{sense};{tool};\"a; b\"");
                }
            }
        }
    }
    text
}

#[test]
fn displacements_give_the_machine_that_corrects_programs() {
    let shop = three_axes()
        .file("plan.csv", grid_csv())
        .file("plan.toml", GRID_TOML)
        .file("model.txt", names(SHOWN))
        .copy("samples/programs/sinumerik/bolt_circle.mpf");
    simulate(&shop, "plan.csv", "grid.csv", "0.2um", "1");
    simulate(&shop, "plan.csv", "held.csv", "0.2um", "2");
    assert!(shop.text("grid.toml").contains("sigma_um = 0.2"), "{}", shop.text("grid.toml"));
    let (plan, grid) = (shop.text("plan.csv"), shop.text("grid.csv"));
    // The rest of the table passes through, and the same seed gives the same noise.
    assert!(plan.lines().zip(grid.lines()).all(|(plan, grid)| grid.starts_with(&format!("{plan};"))), "{grid}");
    assert!(grid.lines().next().unwrap().ends_with(";remark;dx_um;dy_um;dz_um"), "{grid}");
    simulate(&shop, "plan.csv", "again.csv", "0.2um", "1");
    assert_eq!(shop.text("again.csv"), grid);
    assert_ne!(shop.text("held.csv"), grid);

    let report = calibrate(&shop, &["grid.csv"], "model.txt", &["--hold-out", "held.csv"]);
    demand(&report, SHOWN, 2.0);
    for (k, name) in ["grid", "held"].iter().enumerate() {
        let data = &report["data"][k];
        assert_eq!((data["name"].as_str().unwrap(), data["is_held_out"] == (k == 1)), (*name, true));
        assert_eq!(data["readings"], 360);
        let left = data["left_rms"].as_f64().unwrap();
        // 360 readings of 0.2 µm noise: five standard deviations of their mean square.
        assert!((left / 0.2 - 1.0).abs() < 0.19 && data["efficiency"].as_f64().unwrap() > 0.9, "{data}");
    }
    let written = shop.text("machine.toml");
    assert!(written.contains("# calibrated: displacement grid.csv ("), "{written}");
    let start = shop.text("start.toml");
    assert!(start.lines().all(|line| written.contains(line)), "{written}");

    let program = "bolt_circle.mpf";
    shop.run([program, "-o", "out.mpf", "--machine", "machine.toml"]).exits(0);
    let json = shop.run(["verify", program, "out.mpf", "--machine", "true.toml", "--json"]).json();
    let [before, after] = ["before", "after"].map(|side| json[side]["mean_um"].as_f64().unwrap());
    assert!(before > 4.0 && after < 0.8, "{json}");

    // A second calibration keeps one head, the comments and the place of every value.
    let more = ["calibrate", "held.csv", "--machine", "machine.toml", "--model", "model.txt", "-o", "second.toml"];
    shop.run(more).exits(0).says("held");
    let second = shop.text("second.toml");
    assert_eq!(second.lines().count(), written.lines().count());
    assert_eq!(second.matches("# calibrated: model").count(), 1);
}

fn circles_csv() -> String {
    let mut text = "setup,X,Y,Z,tool_z_mm\n".to_owned();
    // Set-up A stands at 350, 250, 60 with the tool; every plane through it.
    for plane in 0..3 {
        for step in 0..36 {
            let (sin, cos) = f64::from(step * 10).to_radians().sin_cos();
            let (a, b) = (150.0 * cos, 150.0 * sin);
            let off = [[a, b, 0.0], [a, 0.0, b], [0.0, a, b]][plane];
            let _ = writeln!(text, "A,{:.4},{:.4},{:.4},-100", 350.0 + off[0], 250.0 + off[1], 260.0 + off[2]);
        }
    }
    text
}

const CIRCLES_TOML: &str = "[measurement]\nkind = \"ballbar\"\nsigma_um = 0.3\nfree = [\"centre\"]\n\
    [setup.A]\ncentre_mm = [350, 250, 160]\nlength_mm = 150\n";
const SIX: &[(&str, f64)] =
    &[("EC0X", 16.0), ("EB0Z", -12.0), ("EA0Z", 9.0), ("EXX1", 32.0), ("EYY1", -21.0), ("EZZ1", 11.0)];

/// The errors that six parameters can say.
pub(crate) fn circles() -> Shop {
    let errors: String = ERRORS.split("[[motion]]").take(4).collect::<Vec<_>>().join("[[motion]]");
    let errors = errors.replace(", -4.0e-8", "");
    Shop::new()
        .file("true.toml", format!("{}{errors}", bare("demo")))
        .file("start.toml", bare("demo"))
        .file("plan.csv", circles_csv())
        .file("plan.toml", CIRCLES_TOML)
        .file("model.txt", names(SIX))
}

#[test]
fn circles_give_squareness_and_scales() {
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let report = calibrate(&shop, &["circles.csv"], "model.txt", &[]);
    demand(&report, SIX, 1.5);
    let options = ["--monte-carlo", "40", "--seed", "7"];
    let repeated = calibrate(&shop, &["circles.csv"], "model.txt", &options);
    for one in ["parameters", "unknowns"].iter().flat_map(|list| repeated[list].as_array().unwrap()) {
        let [spread, sigma] = ["sigma_monte_carlo", "sigma"].map(|key| one[key].as_f64().unwrap());
        // Of 40 repetitions the scatter is known to 11 %.
        assert!((spread / sigma - 1.0).abs() < 0.5, "{one}");
    }
    assert!(report["parameters"][0]["sigma_monte_carlo"].is_null());
    let unknowns = report["unknowns"].as_array().unwrap();
    assert_eq!(unknowns[0]["name"], "X of the table ball of set-up A");
    assert_eq!(unknowns.len(), 3);
}

#[test]
fn what_the_data_cannot_tell_is_named() {
    let free = CIRCLES_TOML.replace("[\"centre\"]", "[\"centre\", \"length\"]");
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let shop = shop.file("circles.toml", free);
    // A bar that is longer looks like three scales that are larger.
    let arguments = ["calibrate", "circles.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "m.toml"];
    let run = shop.run(arguments).exits(4).says("E0606").says("length of the ball-bar").says("nothing was written");
    assert!(!run.stderr.contains("E0607"), "{}", run.stderr);
    assert!(!shop.path("m.toml").exists());
    let few: String = shop.text("circles.csv").lines().take(4).map(|line| format!("{line}\n")).collect();
    let shop = shop.file("circles.csv", few).file("circles.toml", CIRCLES_TOML);
    shop.run(arguments).exits(4).says("E0606").says("3 readings cannot determine 9 unknowns");
}

#[test]
fn a_model_is_reduced_to_what_the_data_tell() {
    let free = CIRCLES_TOML.replace("[\"centre\"]", "[\"centre\", \"length\"]");
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let shop = shop.file("circles.toml", free).file("model.txt", format!("EYX0\nEYX2@400\nEYX2@800\n{}", names(SIX)));
    refused(&shop, "model.txt", &["E0606", "circles.toml:1:1", "EYX2@800", "without these 3 parameters", "--reduce"]);
    let report = calibrate(&shop, &["circles.csv"], "model.txt", &["--reduce"]);
    // What the length takes of the gains is that of Z; X and Y carry the workpiece, where a gain moves the other way.
    let expected = [
        ("EYX2@400", 0.0),
        ("EC0X", 16.0),
        ("EB0Z", -12.0),
        ("EA0Z", 9.0),
        ("EXX1", 32.0 + 11.0),
        ("EYY1", -21.0 + 11.0),
        // No circle shows the direction of X: its slope follows from the knot.
        ("EYX1", 0.0),
    ];
    demand(&report, &expected, 60.0);
    let mut left_out: Vec<&str> = report["left_out"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|one| one["parameters"].as_array().unwrap())
        .map(|name| name.as_str().unwrap())
        .collect();
    left_out.sort_unstable();
    assert_eq!(left_out, ["EYX0", "EYX2@800", "EZZ1"]);
    let found = report["diagnostics"].as_array().unwrap();
    assert_eq!(found.iter().filter(|one| one["code"] == "W0605" && one["line"] == 1).count(), 3, "{report}");
}

#[test]
fn lasers_and_levels_give_single_components() {
    let expected: &[(&str, f64)] = &[("EXX1", 32.0), ("EXX2", -40.0), ("EAX1", 25.0)];
    let rows = |component: &str| {
        (0..36).fold("component,X,Y,Z\n".to_owned(), |text, k| format!("{text}{component},{},0,0\n", 20 * k))
    };
    let errors = ERRORS.replace("value_um = 6.0", "value_um = 0.0");
    let direct = |free: &str| format!("[measurement]\nkind = \"direct\"\nfree = [{free}]\n");
    let shop = three_axes()
        .file("true.toml", format!("{}{errors}", bare("demo")))
        .file("laser_plan.csv", rows("EXX"))
        .file("laser_plan.toml", direct("\"offset\""))
        .file("level_plan.csv", rows("EAX"))
        .file("level_plan.toml", direct("\"offset\""))
        .file("model.txt", names(expected));
    simulate(&shop, "laser_plan.csv", "laser.csv", "0.1um", "3");
    simulate(&shop, "level_plan.csv", "level.csv", "0.1um", "4");
    assert!(shop.text("laser.csv").starts_with("component,X,Y,Z,value_um\n"));
    assert!(shop.text("level.csv").starts_with("component,X,Y,Z,value_urad\n"));
    let report = calibrate(&shop, &["laser.csv", "level.csv"], "model.txt", &[]);
    demand(&report, expected, 3.0);
    assert_eq!((&report["data"][0]["unit"], &report["data"][1]["unit"]), (&"µm".into(), &"µrad".into()));
}

/// With X and Y on the two sides of F (wYFXZSt), EC0X and EC0Y are the same angle with opposite signs. Readings of 16 and 20 µrad, each ± 4, have the mean 18 ± 4/√2.
#[test]
fn a_squareness_is_read_as_a_number_with_its_uncertainty() {
    let direct =
        "[measurement]\nkind = \"direct\"\nsigma_urad = 4\nsigma_um = 0.5\n[position]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n";
    let table = "component,value_urad\nEC0X,16\nEC0Y,-20\nEA0Z,9\n";
    let apart = bare("demo").replace("wXYFZSt", "wYFXZSt").replace("direction = [-1, 0, 0]", "direction = [1, 0, 0]");
    let shop = three_axes()
        .file("start.toml", &apart)
        .file("square.csv", table)
        .file("square.toml", direct)
        .file("model.txt", "EC0X\nEA0Z\n");
    let report = calibrate(&shop, &["square.csv"], "model.txt", &[]);
    for (number, (value, sigma)) in [(18.0, 4.0 / 2_f64.sqrt()), (9.0, 4.0)].into_iter().enumerate() {
        let one = &report["parameters"][number];
        let [found, by] = ["value", "sigma"].map(|key| one[key].as_f64().unwrap());
        assert!((found - value).abs() < 1e-3 && (by - sigma).abs() < 0.1, "{one}");
    }
    let refused = |machine: &str, table: &str, description: &str, says: &str| {
        let shop = Shop::new().file("m.toml", machine).file("s.csv", table).file("s.toml", description);
        let words = ["calibrate", "s.csv", "--machine", "m.toml", "--model", "EC0X", "-o", "new.toml"];
        let run = shop.run(words).exits(4).says("E0603");
        assert!(run.stderr.contains(says), "{says}: {}", run.stderr);
    };
    let one = "component,value_urad\nEC0Y,20\n";
    let bare_text = direct.replace("sigma_urad = 4\nsigma_um = 0.5\n", "");
    refused(&apart, one, &bare_text, "a reading of EC0Y itself needs its uncertainty");
    refused(&bare("demo"), "component,value_urad\nEC0X,90000\n", direct, "is no error of a machine");
    refused(&bare("demo"), "component,value_urad\nEC0Q,9\n", direct, "'EC0Q' is not an error component");
}

const BALLS_TOML: &str = "[measurement]\nkind = \"probe\"\n[ball.b1]\nplace_mm = [70, 0, 150]\n\
    [ball.b2]\nplace_mm = [-40, 60, 120]\n[ball.b3]\nplace_mm = [-30, -65, 190]\n";

/// As Table 4-3 of Esmaeili 2021 has them, in µm, µrad, µm/m.
const MAYER: &[(&str, f64)] = &[
    ("EA0B", -40.0),
    ("EC0B", -1.0),
    ("EX0C", -95.6),
    ("EA0C", -12.0),
    ("EB0C", 11.0),
    ("EB0Z", -10.0),
    ("EA0Y", -38.0),
    ("EC0Y", 15.0),
    ("EY0S", 29.3),
    ("EX0S", -100.0),
    ("EXX1", 17.0),
    ("EYY1", -23.0),
    ("EZZ1", -32.0),
];

fn five_axes() -> Shop {
    let mut plan = "target,X,Y,Z,B,C,tool_z_mm\n".to_owned();
    for ball in ["b1", "b2", "b3"] {
        for b in [-60, -30, 0, 30, 60] {
            for c in [0, 60, 120, 180, 240, 300] {
                let _ = writeln!(plan, "{ball},0,100,300,{b},{c},-100");
            }
        }
    }
    // A scale bar: without it nothing tells the common size of the scales.
    let length = (110.0_f64.powi(2) + 60.0_f64.powi(2) + 30.0_f64.powi(2)).sqrt();
    let length = format!("[[length]]\nfrom = \"b1\"\nto = \"b2\"\nvalue_mm = {length}\n");
    Shop::new()
        .copy("samples/machines/esmaeili_xyz5.toml")
        .file("start.toml", bare("esmaeili_xyz5"))
        .file("true.toml", std::fs::read(repository("samples/machines/esmaeili_xyz5.toml")).unwrap())
        .file("plan.csv", plan)
        .file("plan.toml", format!("{BALLS_TOML}{length}"))
}

#[test]
fn probed_balls_give_the_thirteen_parameters_of_five_axes() {
    let shop = five_axes().copy("samples/programs/sinumerik/three_plus_two.mpf");
    simulate(&shop, "plan.csv", "balls.csv", "0.2um", "1");
    simulate(&shop, "plan.csv", "held.csv", "0.2um", "2");
    let report = calibrate(&shop, &["balls.csv"], "mayer-13", &["--hold-out", "held.csv"]);
    demand(&report, MAYER, 2.0);
    assert!(report["data"][1]["left_rms"].as_f64().unwrap() < 0.25, "{report}");
    let program = "three_plus_two.mpf";
    shop.run([program, "-o", "out.mpf", "--machine", "machine.toml"]).exits(0);
    let json = shop.run(["verify", program, "out.mpf", "--machine", "true.toml", "--json"]).json();
    let [before, after] = ["before", "after"].map(|side| json[side]["mean_um"].as_f64().unwrap());
    assert!(before > 20.0 && after < 1.2, "{json}");
}

/// Without the scale bar, only the places of the rotary axes in the machine file tell how long the scales are.
#[test]
fn scales_without_a_known_distance_rest_on_the_pivots() {
    let shop = five_axes();
    simulate(&shop, "plan.csv", "balls.csv", "0.2um", "1");
    let arguments = ["calibrate", "balls.csv", "--machine", "start.toml", "--model", "mayer-13", "-o", "machine.toml"];
    let run = shop.run(arguments).exits(0);
    assert!(!run.stderr.contains("W0613"), "{}", run.stderr);
    let free = shop.text("balls.toml");
    let shop = shop.file("balls.toml", free.split("[[length]]").next().unwrap());
    shop.run(arguments).exits(0).says("warning[W0613]").says("EXX1 and EYY1 and EZZ1 from EZ0B");
}

#[test]
fn a_gross_outlier_is_listed_and_does_no_harm() {
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let mut lines: Vec<String> = shop.text("circles.csv").lines().map(str::to_owned).collect();
    let (head, _) = lines[20].rsplit_once(',').unwrap();
    lines[20] = format!("{head},60");
    let shop = shop.file("circles.csv", lines.join("\n"));
    let report = calibrate(&shop, &["circles.csv"], "model.txt", &[]);
    demand(&report, SIX, 1.5);
    let down = report["weighted_down"].as_array().unwrap();
    assert!(down.iter().any(|row| row["line"] == 21 && row["weight"] == 0.0), "{report}");
    let found = report["diagnostics"].as_array().unwrap();
    assert!(found.iter().any(|one| one["code"] == "W0603" && one["line"] == 21), "{report}");
    let report = calibrate(&shop, &["circles.csv"], "model.txt", &["--no-robust"]);
    let squareness = report["parameters"][0]["value"].as_f64().unwrap();
    assert!((squareness - 16.0).abs() > 3.0, "{report}");
}

#[test]
fn a_poor_model_is_pointed_out() {
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let shop = shop.file("model.txt", "EC0X\n");
    let report = calibrate(&shop, &["circles.csv"], "model.txt", &["--no-robust"]);
    assert!(report["diagnostics"].as_array().unwrap().iter().any(|one| one["code"] == "W0604"), "{report}");
    // Not the correction of a part comes next, but the search for what is missing.
    let words = "calibrate circles.csv --machine start.toml --model model.txt -o poor.toml --no-robust";
    let run = shop.run(words.split_whitespace()).exits(0);
    run.says("ncfix diagnose circles.csv --machine poor.toml -o poor_extended.toml");
}

/// Runs a calibration of the circles that must be refused, with what is said and without output.
#[track_caller]
fn refused(shop: &Shop, model: &str, expected: &[&str]) {
    let arguments = ["calibrate", "circles.csv", "--machine", "start.toml", "--model", model, "-o", "m.toml"];
    let run = shop.run(arguments).exits(4);
    for text in expected {
        assert!(run.stderr.contains(text), "'{text}' is not in\n{}", run.stderr);
    }
    assert!(!shop.path("m.toml").exists());
}

#[test]
fn readings_of_another_unit_are_refused() {
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let scaled = |factor: f64| {
        let text = shop.text("circles.csv");
        let mut lines = text.lines();
        let mut out = format!("{}\n", lines.next().unwrap());
        for line in lines {
            let (head, value) = line.rsplit_once(',').unwrap();
            let _ = writeln!(out, "{head},{}", value.parse::<f64>().unwrap() * factor);
        }
        out
    };
    let (large, small) = (scaled(1000.0), scaled(0.001));
    let shop = shop.file("circles.csv", large);
    refused(&shop, "model.txt", &["E0608", "circles.csv:2:", "beyond 1000 µm"]);
    let shop = shop.file("circles.csv", small);
    refused(&shop, "model.txt", &["E0608", "circles.csv:2:", "the RMS of all lengths is far less than sigma_um"]);
    // Positions in another unit leave the travel.
    let text = circles_csv().replace("setup,X,Y,Z,tool_z_mm", "setup,X,Y,Z,dr_um").replace(",-100\n", ",1\n");
    let meters = text.replacen("A,500.0000", "A,500000.0", 1);
    refused(&shop.file("circles.csv", meters), "model.txt", &["E0302", "circles.csv:2:3"]);
}

#[test]
fn wrong_input_is_found_at_its_place() {
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let good = shop.text("circles.csv");
    let with = |line: usize, last: &str| {
        let mut lines: Vec<String> = good.lines().map(str::to_owned).collect();
        let (head, _) = lines[line - 1].rsplit_once(',').unwrap();
        lines[line - 1] = format!("{head},{last}");
        lines.join("\n")
    };
    let place = |line: usize| {
        let text = good.lines().nth(line - 1).unwrap();
        format!("circles.csv:{line}:{}", text.rfind(',').unwrap() + 2)
    };
    let shop = shop.file("circles.csv", with(7, "three"));
    refused(&shop, "model.txt", &["E0603", &place(7), "'three'"]);
    let shop = shop.file("circles.csv", with(8, "NaN"));
    refused(&shop, "model.txt", &["E0603", &place(8)]);
    let shop = shop.file("circles.csv", with(1, "dr_mm"));
    refused(&shop, "model.txt", &["E0602", "circles.csv:1:1", "no column dr_um"]);
    let line = good.lines().nth(4).unwrap();
    let shop = shop.file("circles.csv", good.replacen(line, &format!("{line}\n{line}"), 1));
    refused(&shop, "model.txt", &["E0605", "circles.csv:6:1", "line 5"]);
    let shop = shop.file("circles.csv", good.replace("\nA,", "\nB,"));
    refused(&shop, "model.txt", &["E0603", "circles.csv:2:1", "set-up 'B'"]);
    let shop = shop.file("circles.csv", &good).file("circles.toml", CIRCLES_TOML.replace("ballbar", "bar"));
    refused(&shop, "model.txt", &["E0404", "circles.toml:2:8"]);
    let shop = shop.file("circles.toml", CIRCLES_TOML.replace("sigma_um", "sigma"));
    refused(&shop, "model.txt", &["E0402", "circles.toml:3:1"]);
    std::fs::remove_file(shop.path("circles.toml")).unwrap();
    let arguments = ["calibrate", "circles.csv", "--machine", "start.toml", "--model", "10", "-o", "m.toml"];
    shop.run(arguments).exits(2);
}

#[test]
fn a_ball_that_was_probed_once_is_found() {
    let shop = five_axes();
    simulate(&shop, "plan.csv", "balls.csv", "0.2um", "1");
    let text = shop.text("balls.csv").replacen("b1,", "b9,", 1);
    let shop = shop.file("balls.csv", text);
    let arguments = ["calibrate", "balls.csv", "--machine", "start.toml", "--model", "mayer-13", "-o", "m.toml"];
    shop.run(arguments).exits(4).says("E0603").says("balls.csv:2:1").says("b9 was probed once");
    // A row with the wrong ball is far from the others of that ball.
    let text = shop.text("balls.csv").replacen("b9,", "b2,", 1);
    shop.file("balls.csv", text).run(arguments).exits(4).says("E0608").says("balls.csv:2:1");
}

#[test]
fn parameters_must_be_those_of_the_machine() {
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let shop = shop.file("model.txt", "EXX1 # scale\n  EXQ1\nEBB1\nEXX1\n");
    refused(&shop, "model.txt", &["E0609", "model.txt:2:3", "model.txt:3:1", "no axis B", "model.txt:4:1", "twice"]);
    refused(&shop.file("model.txt", "# none\n"), "model.txt", &["E0609", "names no parameter"]);
    let shop = circles();
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    let arguments = ["calibrate", "circles.csv", "--machine", "start.toml", "--model", "mayer", "-o", "m.toml"];
    shop.run(arguments).exits(2).says("the presets are");
    let arguments = ["calibrate", "circles.csv", "--machine", "start.toml", "--model", "mayer-13", "-o", "m.toml"];
    shop.run(arguments).exits(2).says("is not applicable");
}

#[test]
fn inputs_are_never_overwritten() {
    let shop = circles();
    let arguments = ["simulate", "plan.csv", "-o", "plan.csv", "--machine", "true.toml"];
    shop.run(arguments).exits(4).says("E0310");
    simulate(&shop, "plan.csv", "circles.csv", "0.3um", "5");
    for output in ["start.toml", "circles.csv", "circles.toml"] {
        let model = ["calibrate", "circles.csv", "--machine", "start.toml", "--model", "model.txt", "-o", output];
        shop.run(model).exits(4).says("E0310");
    }
    let arguments = ["simulate", "plan.csv", "-o", "-", "--machine", "true.toml"];
    shop.run(arguments).exits(2);
}

/// Circles of 100 mm radius around many centers, all unknown, on a machine with a scale error of 40 µm/m in X and −15 µm/m in Y. 90 unknowns are solved
/// together, 120 set-up by set-up: the results agree with the truth, and the uncertainty falls with the root of the number of circles.
#[test]
fn many_set_ups_give_the_truth_with_the_uncertainty_of_their_number() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 800]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 800]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 500]\n[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
    let found = [30, 40].map(|count: u32| {
        let mut noise = Noise(17);
        let mut rows = "run,setup,X,Y,Z,tool_z_mm,dr_um\n".to_owned();
        let mut described = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\nsigma_um = 0.5\n".to_owned();
        for k in 0..count {
            let centre = [250.0 + f64::from(7 * k % 300), 250.0 + f64::from(11 * k % 300)];
            let eccentric = [noise.next(5.0), noise.next(5.0)];
            for j in 0..24 {
                let (y, x) = (std::f64::consts::TAU * (f64::from(j) + 0.3) / 24.0).sin_cos();
                let at = [centre[0] + 100.0 * x, centre[1] + 100.0 * y];
                let error_um = [0.040 * at[0] + eccentric[0], -0.015 * at[1] + eccentric[1]];
                let dr_um = error_um[0] * x + error_um[1] * y + noise.next(0.5);
                rows.push_str(&format!("{k},S{k},{:.6},{:.6},220,-120,{dr_um:.5}\n", at[0], at[1]));
            }
            described
                .push_str(&format!("[setup.S{k}]\ncentre_mm = [{}, {}, 100]\nlength_mm = 100\n", centre[0], centre[1]));
        }
        let shop = Shop::new().file("m.toml", machine).file("out.csv", rows).file("out.toml", described);
        let all = calibrated(&shop, "m.toml", "EXX1,EYY1");
        for (name, true_um_per_m) in [("EXX1", 40.0), ("EYY1", -15.0)] {
            let (_, value, sigma) = all.iter().find(|(own, ..)| own == name).unwrap();
            assert!((value - true_um_per_m).abs() < 3.0 * sigma, "{count} {name}: {value} ± {sigma}");
        }
        all
    });
    for ((name, _, of_30), (_, _, of_40)) in found[0].iter().zip(&found[1]) {
        let ratio = of_40 / of_30 / (30.0_f64 / 40.0).sqrt();
        // The scatter itself is estimated from 24 readings of each circle.
        assert!((ratio - 1.0).abs() < 0.1, "{name}: {of_30} {of_40}");
    }
}

/// A squareness γ changes the length L of a bar at the angle θ by L γ sin θ cos θ: not at all along the axes, and by 100 mm · 100 µrad · 0.6 · 0.8 = 4.8 µm
/// where the bar is 60 mm along one axis and 80 mm along the other.
#[test]
fn a_bar_along_the_axes_cannot_determine_a_squareness() {
    let header = "setup,X,Y,Z,tool_x_mm,tool_y_mm,tool_z_mm,dr_um\n";
    let row = |x: i32, y: i32, um: f64| format!("A,{},{},200,0,0,0,{um}\n", 350 + x, 250 + y);
    let along: String = [(100, 0), (0, 100), (-100, 0), (0, -100)].map(|(x, y)| row(x, y, 1.0)).concat();
    let between: String =
        [(60, 80, 5.8), (-60, 80, -3.8), (-60, -80, 5.8), (60, -80, -3.8)].map(|(x, y, um)| row(x, y, um)).concat();
    let description = |free: &str| {
        format!(
            "[measurement]\nkind = \"ballbar\"\nfree = [{free}]\nsigma_um = 0.3\n\
             [setup.A]\nlength_mm = 100\ncentre_mm = [350, 250, 200]\n"
        )
    };
    for model in ["EC0X\n", "EYX1\n"] {
        let shop = three_axes()
            .file("circles.csv", format!("{header}{along}"))
            .file("circles.toml", description("\"centre\""))
            .file("model.txt", model);
        let says = [
            "E0606",
            "no reading of the ball-bar lies near 45° or 135° between X and Y",
            "read the bar also near 45° and 135° between X and Y",
        ];
        refused(&shop, "model.txt", &says);
    }
    // With readings between the axes the squareness is determined; 1 µm of the length of the bar is in all readings.
    let shop = three_axes()
        .file("circles.csv", format!("{header}{along}{between}"))
        .file("circles.toml", description("\"centre\", \"length\""))
        .file("model.txt", "EC0X\n");
    let report = calibrate(&shop, &["circles.csv"], "model.txt", &[]);
    let found = report["parameters"][0]["value"].as_f64().unwrap();
    assert!((found.abs() - 100.0).abs() < 0.1, "{found}");
}
