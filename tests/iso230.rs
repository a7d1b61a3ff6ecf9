//! Figures of ISO 230-2 and 230-4 against arithmetic of their own.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use ncfix_base::source::{FileId, Source};
use ncfix_metrology::measure::data::DataSet;
use ncfix_metrology::measure::iso230::circle::{self, CirclePoint};
use ncfix_metrology::measure::iso230::drift::without_drift;
use ncfix_metrology::measure::iso230::minimum_zone;
use ncfix_metrology::measure::iso230::positioning::{ApproachReading, FiguresError, approaches, figures};
use ncfix_model::file;

use crate::bench_machine::Random;
use crate::support::Shop;
use crate::thermal_plant::gauss;

/// Deviations, µm: by target, by run, positive and negative sense.
const UP: [[f64; 5]; 4] =
    [[2.0, 3.0, 1.0, 2.5, 1.5], [0.0, 1.0, -1.0, 0.5, -0.5], [-4.0, -2.0, -3.0, -3.5, -2.5], [1.0, 1.0, 2.0, 0.0, 1.0]];
const DOWN: [[f64; 5]; 4] =
    [[5.0, 6.0, 4.0, 5.5, 4.5], [2.0, 4.0, 3.0, 3.0, 3.0], [-1.0, 1.0, 0.0, -0.5, 0.5], [6.0, 4.0, 5.0, 7.0, 3.0]];

fn table() -> Vec<ApproachReading> {
    let mut out = Vec::new();
    for cycle in 0..5 {
        for (is_up, rows) in [(true, UP), (false, DOWN)] {
            for (k, row) in rows.iter().enumerate() {
                let target = 100.0 * k as f64;
                out.push(ApproachReading { target, deviation: row[cycle], is_up, cycle, time: out.len() as f64 });
            }
        }
    }
    out
}

fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-9, "{value} is not {expected}");
}

#[test]
fn positioning_by_hand() {
    // Means ↑ 2, 0, −3, 1 and ↓ 5, 3, 0, 5; squares about the mean ↑ 2.5, 2.5, 2.5, 2 and ↓ 2.5, 2, 2.5, 10, so that s² is a quarter of that.
    let [s, t, w] = [0.625_f64, 0.5, 2.5].map(f64::sqrt);
    let found = figures(&table()).unwrap();
    let (up, down, both) = (found.up.unwrap(), found.down.unwrap(), found.both.unwrap());
    assert_eq!((found.runs, found.targets.len()), (5, 4));
    near(up.repeatability, 4.0 * s);
    near(down.repeatability, 4.0 * w);
    near(up.systematic, 5.0);
    near(down.systematic, 5.0);
    near(up.accuracy, 5.0 + 4.0 * s);
    near(down.accuracy, (5.0 + 2.0 * w) - (0.0 - 2.0 * s));
    // B of the targets: −3, −3, −3, −4.
    near(both.reversal, 4.0);
    near(both.mean_reversal, -3.25);
    near(both.repeatability, 2.0 * t + 2.0 * w + 4.0);
    near(both.systematic, 8.0);
    near(both.mean_systematic, 3.5 + 1.5);
    near(both.accuracy, (5.0 + 2.0 * w) - (-3.0 - 2.0 * s));
    // E of both senses is never smaller than that of one.
    assert!(both.systematic >= up.systematic && both.accuracy >= up.accuracy);
}

#[test]
fn one_sense_or_one_run() {
    let mut readings = table();
    readings.retain(|reading| reading.is_up);
    let found = figures(&readings).unwrap();
    assert!(found.up.is_some() && found.down.is_none() && found.both.is_none());
    readings.retain(|reading| reading.cycle == 0);
    assert_eq!(figures(&readings), Err(FiguresError::Once(0.0)));
    assert_eq!(figures(&[]), Err(FiguresError::Nothing));
    assert!(FiguresError::Once(0.0).to_string().contains("two runs"));
}

/// A parabola along the axis, a drift of its own in every cycle, a reversal, noise.
fn drifting(reversal: f64, noise: f64) -> Vec<ApproachReading> {
    let mut random = Random(7);
    let mut out: Vec<ApproachReading> = Vec::new();
    for (cycle, slope) in [0.02, 0.05, -0.01, 0.03].into_iter().enumerate() {
        for step in 0..22 {
            let (k, is_up) = if step < 11 { (step, true) } else { (21 - step, false) };
            let x = 50.0 * f64::from(k);
            let sense = if is_up { 0.5 } else { -0.5 };
            let own = 1e-5 * x * x + slope * f64::from(step) + 2.0 * cycle as f64 + sense * reversal;
            out.push(ApproachReading {
                target: x,
                deviation: own + gauss(&mut random, noise),
                is_up,
                cycle,
                time: f64::from(step),
            });
        }
    }
    out
}

#[test]
fn drift_of_every_cycle_is_taken_out() {
    let exact = without_drift(&drifting(0.0, 0.0)).unwrap();
    let both = figures(&exact).unwrap().both.unwrap();
    near(both.reversal, 0.0);
    near(both.repeatability, 0.0);
    near(both.systematic, 1e-5 * 500.0 * 500.0);
    let noisy = figures(&without_drift(&drifting(0.0, 0.05)).unwrap()).unwrap().both.unwrap();
    let as_read = figures(&drifting(0.0, 0.05)).unwrap().both.unwrap();
    assert!(noisy.repeatability < 0.6 && as_read.repeatability > 5.0, "{noisy:?} {as_read:?}");
}

/// Readings of components with senses.
fn data(rows: &str) -> DataSet {
    let text = "[machine]\nname = \"m\"\ntopology = \"wXYFZSt\"\n[axis.X]\ndirection = [-1, 0, 0]\n\
        [axis.Y]\ndirection = [0, -1, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n";
    let source = |name: &str, text: &str| Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap();
    let machine = file::load(&source("m.toml", text)).0.unwrap().0;
    let table = source("laser.csv", &format!("X,Y,Z,X_dir,component,value_um\n{rows}"));
    let description = source("laser.toml", "[measurement]\nkind = \"direct\"\n");
    let (data, findings) = ncfix_metrology::measure::data::load("laser", &table, &description, &machine);
    data.unwrap_or_else(|| panic!("{findings:?}"))
}

#[test]
fn readings_of_a_measurement_have_sense_and_cycle() {
    let name = "EXX".parse().unwrap();
    let mut rows = String::new();
    for cycle in 0..2 {
        for (x, sense) in [(0, 1), (100, 1), (200, 1), (200, -1), (100, -1), (0, -1)] {
            writeln!(rows, "{x},0,0,{sense},EXX,{}", 10 * cycle + x / 100 - 2 * sense).unwrap();
        }
    }
    let (found, left_out) = approaches(&data(&rows), name, None).unwrap();
    assert_eq!((found.len(), left_out), (12, 0));
    assert_eq!((found[3].is_up, found[3].cycle, found[6].cycle, found[11].cycle), (false, 0, 1, 1));
    // B = (x/100 − 2) − (x/100 + 2) µm.
    let both = figures(&found).unwrap().both.unwrap();
    near(both.mean_reversal, -4e-3);
    near(both.systematic, 6e-3);
    assert_eq!(approaches(&data(&rows), "EYX".parse().unwrap(), None), Err(FiguresError::Nothing));
    assert_eq!(approaches(&data("5,0,0,0,EXX,1\n6,0,0,1,EXX,1\n"), name, None), Err(FiguresError::NoSense(5.0)));
}

#[test]
fn a_backlash_is_no_drift() {
    let Err(FiguresError::Backlash(value, sigma)) = without_drift(&drifting(-0.8, 0.05)) else { panic!("accepted") };
    assert!((value + 0.8).abs() < 3.0 * sigma && sigma < 0.05, "{value} {sigma}");
    let few: Vec<ApproachReading> = drifting(0.0, 0.0).into_iter().filter(|reading| reading.target < 60.0).collect();
    assert_eq!(without_drift(&few), Err(FiguresError::TooFew));
}

fn path(count: usize, deviation_mm: impl Fn(f64) -> f64) -> Vec<CirclePoint> {
    let at = |k: usize| TAU * k as f64 / count as f64;
    (0..count).map(|k| CirclePoint { angle: at(k), deviation_mm: deviation_mm(at(k)) }).collect()
}

/// Deviation of the point at a nominal angle, with its own angle, for an error (x, y) of the path.
fn traced(radius: f64, error: impl Fn(f64) -> [f64; 2]) -> Vec<CirclePoint> {
    path(3600, |_| 0.0)
        .into_iter()
        .map(|point| {
            let [ex, ey] = error(point.angle);
            let (x, y) = (radius * point.angle.cos() + ex, radius * point.angle.sin() + ey);
            CirclePoint { angle: y.atan2(x), deviation_mm: x.hypot(y) - radius }
        })
        .collect()
}

#[test]
fn an_eccentric_circle_is_round() {
    let (radius, [a, b]) = (100.0, [0.7, -0.3]);
    let points = traced(radius, |_| [a, b]);
    let found = circle::figures(radius, &points, &points).unwrap();
    near(found.g_counter.unwrap(), 0.0);
    near(found.centre_mm[0], a);
    near(found.centre_mm[1], b);
    assert!(found.f_clock.unwrap().iter().all(|end| end.abs() < 1e-9));
    assert!(found.h.unwrap() < 1e-9 && found.d.unwrap().abs() < 1e-9);
}

#[test]
fn squareness_makes_an_ellipse() {
    // x = R cos t − β R sin t, y = R sin t: the singular values of [1 −β; 0 1] are the half axes.
    let (radius, beta) = (150.0, 40e-6);
    let points = traced(radius, |t| [-beta * radius * t.sin(), 0.0]);
    let half = (1.0_f64 + beta * beta / 4.0).sqrt();
    let width = radius * ((half + beta / 2.0) - (half - beta / 2.0));
    let found = circle::figures(radius, &points, &[]).unwrap();
    // 3600 readings do not all hit the ends of the axes: R β (1 − cos 0.1°).
    assert!((found.g_counter.unwrap() - width).abs() < 1e-8, "{found:?}");
    assert!((found.f_counter.unwrap()[0] - 0.5 * width).abs() < 1e-6);
    assert_eq!((found.g_both, found.h, found.f_clock), (None, None, None));
}

#[test]
fn backlash_parts_the_two_ways() {
    // X lags by ±B/2 behind its sense: −sin t against the clock.
    let (radius, backlash) = (100.0, 0.010);
    let way = |sense: f64| traced(radius, move |t| [0.5 * backlash * sense * t.sin().signum(), 0.0]);
    let (counter, clock) = (way(1.0), way(-1.0));
    let found = circle::figures(radius, &counter, &clock).unwrap();
    // The paths are B |cos t| apart, most where X turns.
    assert!((found.h.unwrap() - backlash).abs() < 2e-4, "{found:?}");
    // Against the clock the radius is + B/2 cos t above and − B/2 cos t below: the left half sinks, the right rises, both by B/2.
    for g in [found.g_counter, found.g_clock] {
        assert!((g.unwrap() - backlash).abs() < 2e-4, "{found:?}");
    }
    assert!(found.g_both.unwrap() > 0.99 * backlash && found.d.unwrap().abs() < 1e-5);
}

#[test]
fn larger_than_nominal_is_d_and_not_g() {
    let found = circle::figures(100.0, &path(720, |_| 0.012), &path(720, |_| 0.008)).unwrap();
    near(found.d.unwrap(), 0.010);
    near(found.h.unwrap(), 0.004);
    near(found.g_counter.unwrap(), 0.0);
    near(found.g_both.unwrap(), 0.004);
    let [high, low] = found.f_counter.unwrap();
    near(high, 0.012);
    near(low, 0.012);
}

#[test]
fn the_minimum_zone_is_not_the_least_squares_circle() {
    // Three lobes at even weight and a single peak: no centre on a fine grid about the found one is better.
    let mut random = Random(3);
    for trial in 0..20 {
        let [lobes, peak, x, y] = [0.005, 0.02, 0.3, -0.2].map(|size| size * random.between(0.5, 1.5));
        let points: Vec<[f64; 2]> = path(360, |t| lobes * (3.0 * t).cos() + if t < 0.3 { peak } else { 0.0 })
            .iter()
            .map(|point| {
                let radius = 50.0 + point.deviation_mm + gauss(&mut random, 0.001);
                [x + radius * point.angle.cos(), y + radius * point.angle.sin()]
            })
            .collect();
        let zone = minimum_zone(&points).unwrap();
        let width = |centre: [f64; 2]| {
            let radii = points.iter().map(|point| (point[0] - centre[0]).hypot(point[1] - centre[1]));
            let [low, high] = radii.fold([f64::MAX, 0.0], |[low, high], r: f64| [low.min(r), high.max(r)]);
            high - low
        };
        assert!((width(zone.centre) - zone.width()).abs() < 1e-12);
        for step_mm in [1e-2, 1e-3, 1e-5, 1e-7] {
            for k in 0..72 {
                let (sin, cos) = (TAU * f64::from(k) / 72.0).sin_cos();
                let other = width([zone.centre[0] + step_mm * cos, zone.centre[1] + step_mm * sin]);
                assert!(other >= zone.width() - 1e-12, "trial {trial}: {other} at {step_mm}");
            }
        }
    }
}

#[test]
fn what_is_no_circle_has_no_figures() {
    assert!(circle::figures(100.0, &[], &[]).is_none());
    assert!(minimum_zone(&[[0.0, 0.0]; 3]).is_none());
    assert!(minimum_zone(&[[1.0, 1.0]; 9]).is_none());
    assert!(minimum_zone(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]).is_none());
    assert!(minimum_zone(&[[f64::NAN, 0.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]).is_none());
}

/// A table B below X and Y: a turn of B by 0.02° is one of 349.066 µrad. B stands on X, and the level reads the body that X moves relative to the tool,
/// which is the turn of the table itself. No axis turns about X.
#[test]
fn the_sign_of_an_angle_is_tested_by_a_rotary_axis_or_by_hand() {
    let text = "[machine]\nname = \"four\"\ntopology = \"wBXFYZSt\"\ncontroller = \"sinumerik\"\n[axis.X]\ndirection = [-1, 0, 0]\n\
        travel_mm = [0, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\n\
        travel_mm = [0, 600]\n[axis.B]\ndirection = [0, 1, 0]\npoint_mm = [350, 0, 250]\ntravel_deg = [-180, 180]\n\
        [control]\nincrement_mm = 0.001\nincrement_deg = 0.001\n";
    let shop = Shop::new().file("m.toml", text);
    let words =
        ["plan", "laser", "--axis", "X", "--variant", "signs", "--machine", "m.toml", "--runs", "2", "-o", "p.csv"];
    let run = shop.run(words.iter().chain(&["--component", "EBX", "--component", "EAX"])).exits(0);
    assert!(
        run.stderr.contains("no axis turns about EAX alone") || run.stdout.contains("no axis turns about EAX alone")
    );
    let csv = shop.text("p.csv");
    let head: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let place = |name: &str| head.iter().position(|one| *one == name).unwrap_or_else(|| panic!("{name}"));
    let moves: Vec<f64> =
        csv.lines().skip(1).filter_map(|line| line.split(',').nth(place("moved_urad"))?.parse().ok()).collect();
    assert!(moves.len() == 2 && moves[0] == 0.0 && (moves[1] - 349.066).abs() < 0.01, "{moves:?}");
    assert!(!head.contains(&"moved_um"), "{head:?}");
    // EBX of 10 µrad per 100 mm, and EAX of −5, which a foil of 20 µm below one side of a level of 100 mm tests: 200 µrad.
    let filled = |factors: [f64; 2]| {
        let mut out = head.join(",") + "\n";
        let foil = |urad: f64, share: f64| {
            let mut cells = vec![String::new(); head.len()];
            let own =
                [("run", "foil"), ("setup", "A"), ("component", "EAX"), ("X", "0"), ("Y", "0"), ("Z", "0"), ("B", "0")];
            let zero =
                ["X_dir", "Y_dir", "Z_dir", "B_dir", "tool_x_mm", "tool_y_mm", "tool_z_mm"].map(|name| (name, "0"));
            own.iter().chain(&zero).for_each(|(name, text)| cells[place(name)] = (*text).to_owned());
            cells[place("feed_mm_min")] = "1000".to_owned();
            cells[place("moved_urad")] = urad.to_string();
            cells[place("value_urad")] = format!("{:.3}", share * urad + 0.7);
            cells.join(",") + "\n"
        };
        out += &(foil(0.0, factors[1]) + &foil(200.0, factors[1]));
        for (number, line) in csv.lines().skip(1).enumerate() {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            let x: f64 = cells[place("X")].parse().unwrap();
            let moved: f64 = cells[place("moved_urad")].parse().unwrap_or(0.0);
            let noise = if number % 3 == 0 { 0.05 } else { -0.02 };
            let value = if cells[place("component")] == "EBX" { factors[0] * (moved + 0.1 * x) } else { -0.05 * x };
            cells[place("value_urad")] = format!("{:.4}", value + noise);
            out += &(cells.join(",") + "\n");
        }
        out
    };
    let description = shop.text("p.toml");
    let figures = |table: String| {
        let shop = Shop::new().file("m.toml", text).file("level.toml", &description).file("level.csv", table);
        shop.run(["iso230", "level.csv", "--machine", "m.toml"])
    };
    figures(filled([1.0, 1.0])).exits(0);
    figures(filled([-1.0, 1.0])).exits(4).says("E0619").says("the readings of EBX have the opposite sign");
    figures(filled([1.0, -1.0])).exits(4).says("the readings of EAX have the opposite sign");
    figures(filled([1.0, 0.01])).exits(4).says("the readings of EAX do not follow a known move");
    // An angle has no move along a length.
    figures(filled([1.0, 1.0]).replace("moved_urad", "moved_um")).exits(4).says("E0603").says("EAX has no moved_um");
}

/// The program moves the tool by 100 µm along each component before the runs, and the readings must follow (Spaan 1995, ch. 9). The machine is 20 µm/m too long
/// along X and bent by 30 µm/m² along Y.
#[test]
fn a_laser_with_the_wrong_sign_is_refused_by_its_test() {
    let text = "[machine]\nname = \"three\"\ntopology = \"wXFYZSt\"\n[axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 700]\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 600]\n";
    let shop = Shop::new().file("m.toml", text).file("model.txt", "EXX1\nEYX2\n");
    let plan = [
        "plan",
        "laser",
        "--axis",
        "X",
        "--component",
        "EXX",
        "--component",
        "EYX",
        "--variant",
        "signs",
        "--machine",
        "m.toml",
        "--runs",
        "2",
        "-o",
        "plan.csv",
        "--program",
        "PLAN.MPF",
    ];
    shop.run(plan).exits(0);
    let csv = shop.text("plan.csv");
    let head: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let place = |name: &str| head.iter().position(|one| *one == name).unwrap_or_else(|| panic!("{name}"));
    // Two rows for each component, and 2 · 2 · 11 readings of each.
    assert_eq!(csv.lines().count(), 1 + 4 + 88);
    let moves: Vec<&str> =
        csv.lines().skip(1).map(|line| line.split(',').nth(place("moved_um")).unwrap()).take(5).collect();
    // X is on the workpiece side: readings are those of the table relative to the tool.
    assert_eq!(moves, ["0", "-100", "0", "-100", ""]);
    let filled = |factors: [f64; 2]| {
        let mut out = head.join(",") + "\n";
        for (number, line) in csv.lines().skip(1).enumerate() {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            let x: f64 = cells[place("X")].parse().unwrap();
            let moved: f64 = cells[place("moved_um")].parse().unwrap_or(0.0);
            let noise = if number % 3 == 0 { 0.05 } else { -0.02 };
            let (error, factor) =
                if cells[place("component")] == "EXX" { (0.02 * x, factors[0]) } else { (3e-5 * x * x, factors[1]) };
            cells[place("value_um")] = format!("{:.4}", factor * (moved + error + noise));
            out += &(cells.join(",") + "\n");
        }
        out
    };
    let description = shop.text("plan.toml");
    let shop = shop.file("laser.toml", &description).file("laser.csv", filled([1.0, 1.0]));
    shop.run(["iso230", "laser.csv", "--machine", "m.toml"]).exits(0);
    let words = ["calibrate", "laser.csv", "--machine", "m.toml", "--model", "model.txt", "-o", "out.toml", "--json"];
    let json = shop.run(words).exits(0).json();
    let value = json["parameters"][0]["value"].as_f64().unwrap();
    assert!((value - 20.0).abs() < 0.5, "{json}");
    let shop = shop.file("laser.csv", filled([-1.0, 1.0]));
    let run = shop.run(words);
    assert!(run.code == 4, "{}", run.stderr);
    let run = shop.run(["iso230", "laser.csv", "--machine", "m.toml"]).exits(4).says("E0619");
    assert!(
        run.stderr.contains("the readings of EXX have the opposite sign") && !run.stderr.contains("of EYX"),
        "{}",
        run.stderr
    );
    let shop = shop.file("laser.csv", filled([1.0, 0.5]));
    shop.run(["iso230", "laser.csv", "--machine", "m.toml"])
        .exits(4)
        .says("of EYX follow a known move by a factor of 0.5");
    let shop = shop.file("laser.csv", filled([1.0, 0.01]));
    shop.run(["iso230", "laser.csv", "--machine", "m.toml"]).exits(4).says("of EYX do not follow a known move");
    // What is simulated follows.
    shop.run(["simulate", "plan.csv", "--machine", "m.toml", "-o", "made.csv", "--noise", "0.1um"]).exits(0);
    shop.run(["iso230", "made.csv", "--machine", "m.toml"]).exits(0);
}
