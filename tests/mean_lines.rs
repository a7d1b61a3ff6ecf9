//! The frame of a calibration with a ball-bar: bows refer to the mean lines of their axes (ISO 230-1), not to the tangents at the zeros of the axes.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::State;
use ncfix_model::Model;

use crate::import::Noise;
use crate::machine_file::load;
use crate::support::Shop;

type Point = [f64; 3];
/// Bows along X, Y and Z, of which each belongs to the other two directions in turn: a parabola and an S.
const BOWS: [[[f64; 2]; 2]; 3] =
    [[[16.0, 5.0], [-12.0, 4.0]], [[-18.0, -6.0], [11.0, -3.0]], [[14.0, 3.0], [-17.0, 6.0]]];
/// Angles between the mean lines: Y to X, Z to Y, Z to X, µrad.
const ANGLES: [f64; 3] = [30.0, 30.0, 30.0];
const SCALES: [f64; 3] = [20.0, -15.0, 10.0];
const LENGTH: f64 = 500.0;

/// A bow over the travel, µm: p (1 − t²) + s (t³ − 3/5 t) with t from −1 to 1. The least-squares line of either part is level: the integral of t times it is 0.
fn bow(at: f64, [parabola, cubic]: [f64; 2]) -> f64 {
    let t = 2.0 * at / LENGTH - 1.0;
    parabola * (1.0 - t * t) + cubic * (t.powi(3) - 0.6 * t)
}

/// Error of the tool of a machine on which F carries X, X carries Y, and Y carries Z, µm. Each axis has two bows, in the order of the directions.
fn error_um(at: Point) -> Point {
    let mut error = [0.0; 3];
    for axis in 0..3 {
        let [low, high] = match axis {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        };
        error[low] += bow(at[axis], BOWS[axis][0]);
        error[high] += bow(at[axis], BOWS[axis][1]);
        error[axis] += 1e-3 * SCALES[axis] * at[axis];
    }
    // A turn of Y about Z moves its tool to X−, one of Z about X to Y−, one of Z about Y to X+.
    let [c, a, b] = ANGLES.map(|angle| 1e-3 * angle);
    [error[0] - c * at[1] + b * at[2], error[1] - a * at[2], error[2]]
}

fn machine(topology: &str, directions: [&str; 3], travel: [f64; 2]) -> String {
    let mut text = format!("[machine]\nname = \"m\"\ntopology = \"{topology}\"\n");
    for (letter, direction) in ["X", "Y", "Z"].into_iter().zip(directions) {
        let [low, high] = travel;
        let _ = write!(text, "[axis.{letter}]\ndirection = {direction}\ntravel_mm = [{low}, {high}]\n");
    }
    text
}

const TOOL_SIDE: [&str; 3] = ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"];

/// Circles of 100 mm in three planes about eight places with these coordinates, with shifted balls and a longer bar; table and description.
fn circles(places: [f64; 2], noise: &mut Noise, sigma: f64) -> [String; 2] {
    let mut rows = "run,setup,X,Y,Z,dr_um\n".to_owned();
    let mut description =
        "[measurement]\nkind = \"ballbar\"\nsigma_um = 0.2\nfree = [\"centre\", \"length\"]\n".to_owned();
    for number in 0..24_usize {
        let [first, second] = [[0, 1], [1, 2], [2, 0]][number / 8];
        let center: Point = [4, 2, 1].map(|bit| places[usize::from((number % 8) & bit > 0)]);
        // The ball is a few µm beside its place.
        let ball = [0, 1, 2].map(|k| center[k] + 1e-3 * (error_um(center)[k] + noise.next(5.0)));
        let longer = noise.next(2.0);
        for k in 0..48 {
            let angle = TAU * f64::from(k) / 48.0;
            let mut at = center;
            at[first] += 100.0 * angle.cos();
            at[second] += 100.0 * angle.sin();
            let error = error_um(at);
            let far = (0..3).map(|k| (at[k] + 1e-3 * error[k] - ball[k]).powi(2)).sum::<f64>().sqrt();
            let read = 1e3 * (far - 100.0) + longer + noise.next(sigma);
            let _ = writeln!(rows, "1,S{number},{:.9},{:.9},{:.9},{read:.5}", at[0], at[1], at[2]);
        }
        let [x, y, z] = center;
        let _ = write!(description, "[setup.S{number}]\ncentre_mm = [{x}, {y}, {z}]\nlength_mm = 100\n");
    }
    [rows, description]
}

/// Lasers along all axes; table and description. A reading is the error of the moving body: that of the tool has the opposite sign (`signs`) for a table.
fn lasers(signs: Point, noise: &mut Noise, sigma: f64) -> [String; 2] {
    let mut rows = "run,setup,component,X,Y,Z,value_um\n".to_owned();
    for axis in 0..3 {
        for k in 0..=20 {
            let mut at = [250.0; 3];
            at[axis] = 25.0 * f64::from(k);
            let [x, y, z] = at;
            let component = ["EXX", "EYY", "EZZ"][axis];
            let read = signs[axis] * error_um(at)[axis] + noise.next(sigma);
            let _ = writeln!(rows, "1,{axis},{component},{x},{y},{z},{read:.5}");
        }
    }
    [rows, "[measurement]\nkind = \"direct\"\nsigma_um = 0.2\nfree = [\"offset\"]\n".to_owned()]
}

const CURVES: &str = "EYX2,EYX3,EZX2,EZX3,EXY2,EXY3,EZY2,EZY3,EXZ2,EXZ3,EYZ2,EYZ3";

fn shop(start: &str, [bar, laser]: [[String; 2]; 2]) -> Shop {
    let ([bar, bar_text], [laser, laser_text]) = (bar, laser);
    let shop = Shop::new().file("start.toml", start).file("bar.csv", bar).file("bar.toml", bar_text);
    shop.file("laser.csv", laser).file("laser.toml", laser_text)
}

/// Largest difference of the errors of a machine file from the truth, µm, after a shift as a whole. The truth is turned about Z, µm/mm; the fit is not.
fn largest_um(text: &str, turn: f64) -> f64 {
    let (machine, errors) = load(text).0.unwrap();
    let model = Model::new(&machine, &errors);
    let places = [0.0, 125.0, 250.0, 375.0, 500.0];
    let mut left: Vec<Point> = Vec::new();
    for x in places {
        for y in places {
            for z in places {
                let mut command = AxisVector::ZERO;
                command.set_xyz(Vector::new(x, y, z));
                let [actual, nominal] = [
                    model.actual(&command, &Vector::zeros(), &State::default()).translation,
                    model.nominal(&command, &Vector::zeros()).translation,
                ];
                let ([dx, dy, dz], found) = (error_um([x, y, z]), (actual - nominal) * 1e3);
                left.push([found[0] - dx + turn * y, found[1] - dy - turn * x, found[2] - dz]);
            }
        }
    }
    let mean = [0, 1, 2].map(|k| left.iter().map(|one| one[k]).sum::<f64>() / left.len() as f64);
    left.iter().flat_map(|one| (0..3).map(|k| (one[k] - mean[k]).abs())).fold(0.0, f64::max)
}

/// Value and standard uncertainty of a parameter of a report.
fn parameter(report: &serde_json::Value, name: &str) -> [f64; 2] {
    let all = report["parameters"].as_array().unwrap();
    let own = all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name}: {report:#}"));
    ["value", "sigma"].map(|key| own[key].as_f64().unwrap())
}

#[test]
fn six_bows_do_not_turn_the_frame() {
    let mut noise = Noise(21);
    let data = [circles([100.0, 400.0], &mut noise, 0.2), lasers([1.0; 3], &mut noise, 0.2)];
    let shop = shop(&machine("wFXYZSt", TOOL_SIDE, [0.0, 500.0]), data);
    let words = format!(
        "calibrate bar.csv laser.csv --machine start.toml --model EC0Y,EA0Z,EB0Z,EXX1,EYY1,EZZ1,{CURVES} -o out.toml --monte-carlo 40 --json"
    );
    let run = shop.run(words.split_whitespace()).exits(0);
    // The scatter of repetitions is that of the parameters about the mean lines.
    assert!(!run.stdout.contains("W0606"), "{}", run.stdout);
    let report = run.json();
    // The readings are fitted as before: the residual is the noise.
    let left = report["data"][0]["left_rms"].as_f64().unwrap();
    assert!((0.15..0.25).contains(&left), "{left}");
    for name in ["EC0Y", "EA0Z", "EB0Z"] {
        let [value, sigma] = parameter(&report, name);
        assert!((value - 30.0).abs() < 3.0 * sigma && sigma < 1.0, "{name} {value} {sigma}");
    }
    // The tangent of a bow at 0: p (1 − t²) has the slope 4 p/L, and s (t³ − 3/5 t) has 2 s/L (3 − 3/5). For EYX these are 128 + 48 µrad.
    let [value, sigma] = parameter(&report, "EYX1");
    assert!((value - 176.0).abs() < 3.0 * sigma && sigma < 3.0, "{value} {sigma}");
    assert_eq!(report["mean_lines"].as_array().unwrap().len(), 6, "{}", report["mean_lines"]);
    let text = shop.text("out.toml");
    let found = largest_um(&text, 0.0);
    assert!(found < 1.2, "{found} µm");
    let uncertainty = text.split("[uncertainty]").nth(1).unwrap();
    assert!(uncertainty.contains("EYX1 = [") && uncertainty.contains("EC0Y = ["), "{uncertainty}");
    // A second fit begins with these slopes, and finds the same.
    let words = format!(
        "calibrate bar.csv laser.csv --machine out.toml --model EC0Y,EA0Z,EB0Z,EXX1,EYY1,EZZ1,{CURVES} -o again.toml --json"
    );
    let again = shop.run(words.split_whitespace()).exits(0).json();
    for name in ["EC0Y", "EYX1"] {
        let [[value, sigma], [before, sigma_before]] = [parameter(&again, name), parameter(&report, name)];
        assert!((value - before).abs() < 0.02 && (sigma / sigma_before - 1.0).abs() < 0.02, "{name} {value} {before}");
    }
}

#[test]
fn a_table_takes_the_slope_with_its_own_sign() {
    let mut noise = Noise(22);
    let data = [circles([100.0, 400.0], &mut noise, 0.05), lasers([1.0, -1.0, 1.0], &mut noise, 0.05)];
    // The table moves to Y− for Y+. The squareness of X and Y is that of X, with the opposite sign.
    let directions = ["[1, 0, 0]", "[0, -1, 0]", "[0, 0, 1]"];
    let shop = shop(&machine("wYFXZSt", directions, [0.0, 500.0]), data);
    let words = format!(
        "calibrate bar.csv laser.csv --machine start.toml --model EC0X,EA0Z,EB0Z,EXX1,EYY1,EZZ1,{CURVES} -o out.toml --json"
    );
    let report = shop.run(words.split_whitespace()).exits(0).json();
    for (name, expected) in [("EC0X", -30.0), ("EA0Z", 30.0), ("EB0Z", 30.0)] {
        let [value, sigma] = parameter(&report, name);
        assert!((value - expected).abs() < 0.6 && sigma < 1.0, "{name} {value} {sigma}");
    }
    // With EC0X, the reference is Y: where Y had 30 µrad, X now has them. The truth is turned by 30 µrad so that its Y is straight ahead.
    let found = largest_um(&shop.text("out.toml"), -0.03);
    assert!(found < 0.5, "{found} µm");
}

#[test]
fn a_travel_beyond_the_readings_makes_the_direction_uncertain() {
    let mut noise = Noise(23);
    let data = [circles([125.0, 275.0], &mut noise, 0.05), lasers([1.0; 3], &mut noise, 0.05)];
    let shop = shop(&machine("wFXYZSt", TOOL_SIDE, [0.0, 500.0]), data);
    let words = format!(
        "calibrate bar.csv laser.csv --machine start.toml --model EC0Y,EA0Z,EB0Z,EXX1,EYY1,EZZ1,{CURVES} -o out.toml --json"
    );
    let report = shop.run(words.split_whitespace()).exits(0).json();
    let of = |slope: &str| {
        let line = report["mean_lines"].as_array().unwrap().iter().find(|line| line["slope"] == slope).unwrap();
        ["from_mm", "to_mm", "turn_urad"].map(|key| line[key].as_f64().unwrap())
    };
    // The readings cover 25 … 375 mm: t from −0.9 to 0.5, with the middle −0.2 and half of the range 0.7. The least-squares line over it has, by t, the slope
    // −2 p (−0.2) + s (3 · 0.2² + 3/5 · 0.7² − 3/5) = 0.4 p − 0.186 s, and 2/L of it by x. For EYX these are 25.6 − 3.7 µrad, for EXY −28.8 + 4.5 µrad.
    for (slope, turn) in [("EYX1", 21.88), ("EXY1", 24.34)] {
        let [low, high, found] = of(slope);
        assert!((low - 25.0).abs() < 1e-6 && (high - 375.0).abs() < 1e-6, "{slope} {low} {high}");
        assert!((found - turn).abs() < 1.5, "{slope} {found}");
    }
    // The angle between the mean lines over the travel is in the interval of 95 %.
    for name in ["EC0Y", "EA0Z", "EB0Z"] {
        let [value, sigma] = parameter(&report, name);
        assert!((value - 30.0).abs() < 2.0 * sigma && (20.0..50.0).contains(&sigma), "{name} {value} {sigma}");
    }
}

#[test]
fn readings_with_a_direction_keep_it() {
    let mut noise = Noise(24);
    let mut rows = "X,Y,Z,dx_um,dy_um,dz_um\n".to_owned();
    for x in [0.0, 125.0, 250.0, 375.0, 500.0] {
        for y in [0.0, 125.0, 250.0, 375.0, 500.0] {
            for z in [0.0, 250.0, 500.0] {
                let [dx, dy, dz] = error_um([x, y, z]).map(|error| error + noise.next(0.2));
                let _ = writeln!(rows, "{x},{y},{z},{dx:.4},{dy:.4},{dz:.4}");
            }
        }
    }
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.2\nfree = [\"offset\"]\n";
    let shop = Shop::new()
        .file("start.toml", machine("wFXYZSt", TOOL_SIDE, [0.0, 500.0]))
        .file("grid.csv", rows)
        .file("grid.toml", description);
    // The grid shows the slope of X, so the fit of the parabola alone stays as it is, however wrong: the person chose it.
    let words =
        "calibrate grid.csv --machine start.toml --model EC0Y,EA0Z,EB0Z,EXX1,EYY1,EZZ1,EYX2,EXY2 -o out.toml --json";
    let report = shop.run(words.split_whitespace()).exits(0).json();
    assert!(report.get("mean_lines").is_none(), "{report:#}");
    assert!(!shop.text("out.toml").contains("EYX1"));
}
