//! Figures of the acceptance tests from whole measurements: positioning, circles, spheres.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use ncfix_base::geometry::Vector;
use ncfix_metrology::measure::iso230::sphere;
use serde_json::Value;

use crate::support::Shop;

const MACHINE: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\n[axis.Y]\n\
    direction = [0, 1, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n";

/// The groups of figures of one measurement.
fn figures(csv: String, toml: &str) -> Vec<Value> {
    let shop = Shop::new().file("m.toml", MACHINE).file("a.csv", csv).file("a.toml", toml);
    let report = shop.run(["iso230", "a.csv", "--machine", "m.toml", "--json"]).exits(0).json();
    let text = shop.run(["iso230", "a.csv", "--machine", "m.toml"]).exits(0);
    drop(text);
    report["measurements"][0]["figures"].as_array().unwrap().clone()
}

fn value(group: &Value, name: &str) -> f64 {
    let all = group["values"].as_array().unwrap();
    all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name}: {group}"))["value"].as_f64().unwrap()
}

fn near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within, "{found} is not {expected}");
}

#[test]
fn positioning_of_a_file_by_hand() {
    // Two targets, two runs. Means ↑ 1, 4 and ↓ -1, 1 µm; all scatter ±1 (s = √2).
    let mut csv = "run,X,Y,Z,X_dir,component,value_um\n".to_owned();
    for (run, off) in [(1, 1.0), (2, -1.0)] {
        for (x, sense, mean) in [(0, 1, 1.0), (100, 1, 4.0), (100, -1, 1.0), (0, -1, -1.0)] {
            writeln!(csv, "{run},{x},0,0,{sense},EXX,{}", mean + off).unwrap();
        }
    }
    let found = figures(csv.clone(), "[measurement]\nkind = \"direct\"\n");
    let s = 2.0_f64.sqrt();
    let group = &found[0];
    assert_eq!((group["of"].as_str(), group["standard"].as_str()), (Some("EXX"), Some("ISO 230-2")));
    for (name, expected) in [
        ("E+", 3.0),
        ("E-", 2.0),
        ("E", 5.0),
        ("M", 2.5 - 0.0),
        ("B", 3.0),
        ("B mean", 2.5),
        ("R+", 4.0 * s),
        ("R", 4.0 * s + 3.0),
        ("A+", 3.0 + 4.0 * s),
        ("A", 5.0 + 4.0 * s),
    ] {
        near(value(group, name), expected, 1e-9);
    }
    assert_eq!(group["conditions"][1], "2 runs, the standard requires 5 runs");
    // One run says why not.
    let once: String = csv.lines().filter(|line| !line.starts_with('2')).map(|line| format!("{line}\n")).collect();
    let found = figures(once, "[measurement]\nkind = \"direct\"\n");
    assert!(found[0]["reason"].as_str().unwrap().contains("only once"), "{found:?}");
}

#[test]
fn a_reading_of_unknown_direction_is_left_out_and_counted() {
    // Three runs up and down without a column of directions: the axis reaches the first row from nowhere, and turns between the readings of an end.
    let mut csv = "X,Y,Z,component,value_um\n100,0,0,EXX,4\n".to_owned();
    for off in [1.0, 0.0, -1.0] {
        for (x, mean) in [(0, 1.0), (100, 4.0), (200, 6.0), (200, 6.5), (100, 5.0), (0, 1.5)] {
            writeln!(csv, "{x},0,0,EXX,{}", mean + off).unwrap();
        }
    }
    let group = &figures(csv, "[measurement]\nkind = \"direct\"\n")[0];
    assert_eq!(group["reason"], Value::Null, "{group}");
    let conditions = group["conditions"].as_array().unwrap();
    assert!(conditions.iter().any(|one| one == "1 left out, direction unknown"), "{conditions:?}");
    // Where no direction is known at a target, there are no figures, and the reason names it.
    let lone = "X,Y,Z,component,value_um\n7,0,0,EXX,1\n0,0,0,EXX,2\n100,0,0,EXX,3\n0,0,0,EXX,4\n100,0,0,EXX,5\n";
    let found = figures(lone.to_owned(), "[measurement]\nkind = \"direct\"\n");
    assert!(found[0]["reason"].as_str().unwrap().contains("X 7 mm was approached is not known"), "{found:?}");
}

/// A circle of 1° steps in XY about (200, 100, 50), from the exact distance of an error (x, y).
fn circle(out: &mut String, run: &str, radius: f64, sense: f64, error: impl Fn(f64) -> [f64; 2]) {
    for k in 0..=360 {
        let t = (f64::from(k) * sense).to_radians();
        let [ex, ey] = error(t);
        let (x, y) = (radius * t.cos(), radius * t.sin());
        let dr_um = 1000.0 * ((x + ex).hypot(y + ey) - radius);
        // 1° of 100 mm in 0.1 s is 1047.2 mm/min.
        let time = f64::from(k) * 0.1;
        writeln!(out, "{run},{},{},50,{time},{dr_um:.9}", 200.0 + x, 100.0 + y).unwrap();
    }
}

const BAR: &str = "[measurement]\nkind = \"ballbar\"\n[setup.A]\ncentre_mm = [200, 100, 50]\nlength_mm = 100\n";
const BAR_COLUMNS: &str = "run,X,Y,Z,t_s,dr_um\n";

#[test]
fn circles_have_the_closed_forms_of_their_sources() {
    // Squareness of 40 µm/m on a radius of 100 mm: G = 4 µm both ways, no hysteresis; the eccentricity of (0.03, -0.02) mm is taken out.
    let skew = |t: f64| [-40e-6 * 100.0 * t.sin() + 0.03, -0.02];
    let mut csv = BAR_COLUMNS.to_owned();
    circle(&mut csv, "ccw", 100.0, 1.0, skew);
    circle(&mut csv, "cw", 100.0, -1.0, skew);
    let found = figures(csv, BAR);
    assert_eq!(found.len(), 1, "{found:?}");
    let group = &found[0];
    assert_eq!((group["of"].as_str(), group["setup"].as_str()), (Some("XY"), Some("A")));
    for name in ["G(ccw)", "G(cw)", "G(b)"] {
        near(value(group, name), 4.0, 0.03);
    }
    near(value(group, "H"), 0.0, 1e-3);
    near(value(group, "F(ccw) max"), 2.0, 0.03);
    near(value(group, "F(ccw) min"), -2.0, 0.03);
    near(value(group, "eccentricity 1"), 30.0, 0.01);
    near(value(group, "eccentricity 2"), -20.0, 0.01);
    let conditions = group["conditions"].as_array().unwrap();
    assert_eq!(conditions[0], "R 100.000 mm");
    assert_eq!(conditions[1], "ccw 360° from 0.0° F 1047 mm/min, 361 readings");
    // Scales that differ by 30 µm/m: G = R · 30 µm/m = 3 µm.
    let mut csv = BAR_COLUMNS.to_owned();
    circle(&mut csv, "1", 100.0, 1.0, |t| [30e-6 * 100.0 * t.cos(), 0.0]);
    near(value(&figures(csv, BAR)[0], "G(ccw)"), 3.0, 0.02);
    // A delay of 0.3 ms of X against Y at 1000 mm/min: G = F dτ = 5 µm, with opposite signs both ways, so that H is as large as G.
    let lag = |sense: f64| move |t: f64| [0.3e-3 * 1000.0 / 60.0 * t.sin() * sense, 0.0];
    let mut csv = BAR_COLUMNS.to_owned();
    circle(&mut csv, "1", 100.0, 1.0, lag(1.0));
    circle(&mut csv, "2", 100.0, -1.0, lag(-1.0));
    let found = figures(csv, BAR);
    for (name, expected) in [("G(ccw)", 5.0), ("G(cw)", 5.0), ("H", 5.0), ("D(b)", 0.0)] {
        near(value(&found[0], name), expected, 0.05);
    }
}

#[test]
fn less_than_half_a_circle_has_no_figures() {
    let mut csv = BAR_COLUMNS.to_owned();
    circle(&mut csv, "1", 100.0, 1.0, |_| [0.0; 2]);
    let quarter: String = csv.lines().take(92).map(|line| format!("{line}\n")).collect();
    assert!(figures(quarter, BAR)[0]["reason"].as_str().unwrap().contains("90° of the circle"));
}

#[test]
fn a_hemisphere_has_size_and_form() {
    // Radius 19.3 µm larger, the set-up (40, -25, 10) µm off, ±2 µm in turn.
    let mut csv = BAR_COLUMNS.to_owned();
    let mut points = Vec::new();
    for ring in 0..=9 {
        for step in 0..36 {
            let (theta, phi) = (f64::from(ring) * 0.17, TAU * f64::from(step) / 36.0 + 0.01);
            let along = Vector::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            let alternating = if step % 2 == 0 { 2.0 } else { -2.0 };
            let dr = 19.3 + along.dot(&Vector::new(40.0, -25.0, 10.0)) + alternating;
            let at = along * 100.0;
            writeln!(csv, "{ring},{},{},{},{step},{dr:.6}", 200.0 + at.x, 100.0 + at.y, 50.0 + at.z).unwrap();
            points.push(along * (100.0 + dr / 1000.0));
        }
    }
    let found = figures(csv, BAR);
    let group = found.iter().find(|group| group["of"] == "sphere").unwrap_or_else(|| panic!("{found:?}"));
    near(value(group, "size"), 19.3, 0.05);
    near(value(group, "form"), 4.0, 0.05);
    // n - 1 of 360 readings of ±2.
    near(value(group, "s"), 2.0 * (360.0_f64 / 359.0).sqrt(), 0.02);
    near(value(group, "center X"), 40.0, 0.05);
    near(value(group, "center Y"), -25.0, 0.05);
    near(value(group, "center Z"), 10.0, 0.1);
    let flat: Vec<Vector> = points.iter().map(|point| Vector::new(point.x, point.y, 0.0)).collect();
    assert_eq!(sphere::fit(&flat), None);
    assert_eq!(sphere::fit(&points[..4]), None);
    assert_eq!(sphere::fit(&[Vector::zeros(); 9]), None);
}

#[test]
fn kinds_without_figures_say_so_and_calibrations_have_them_beside() {
    let shop = Shop::new()
        .file("m.toml", MACHINE)
        .file("a.csv", "X,Y,Z,dx_um\n0,0,0,1\n1,0,0,1\n")
        .file("a.toml", "[measurement]\nkind = \"displacement\"\n");
    shop.run(["iso230", "a.csv", "--machine", "m.toml"]).exits(4).says("no figures of ISO 230");
    let mut csv = BAR_COLUMNS.to_owned();
    circle(&mut csv, "1", 100.0, 1.0, |t| [-4e-3 * t.sin(), 0.0]);
    circle(&mut csv, "2", 100.0, -1.0, |t| [-4e-3 * t.sin(), 0.0]);
    let toml = BAR.replace("\n[setup", "\nfree = [\"centre\", \"length\"]\n[setup");
    let shop = shop.file("b.csv", csv).file("b.toml", toml).file("model.txt", "EC0Y\n");
    // Beside others it is named, and they are printed.
    let beside = shop.run(["iso230", "a.csv", "b.csv", "--machine", "m.toml"]).exits(0);
    assert!(
        beside.stdout.contains("G(")
            && beside.stdout.contains("no figures   a: ncfix calculates none for its kind, displacement"),
        "{}",
        beside.stdout
    );
    let run = ["calibrate", "b.csv", "--machine", "m.toml", "--model", "model.txt", "-o", "out.toml", "--json"];
    let report = shop.run(run).exits(0).json();
    near(value(&report["figures"][0]["figures"][0], "G(b)"), 4.0, 0.03);
}
