//! Waves that the positions tell or not, lobes of circles, and many errors at once: readings made here by arithmetic of their own.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use serde_json::Value;

use crate::diagnose::{findings, name, number, report, run};
use crate::plant::Random;
use crate::support::Shop;

pub(crate) const MACHINE: &str = r#"
[machine]
name = "bare"
topology = "wFXYZSt"
controller = "sinumerik"

[axis.X]
direction = [1, 0, 0]
travel_mm = [0, 700]

[axis.Y]
direction = [0, 1, 0]
travel_mm = [0, 500]

[axis.Z]
direction = [0, 0, 1]
travel_mm = [0, 500]

[spindle]
origin_mm = [0, 0, 0]
axis = [0, 0, 1]
"#;

/// What is found in a table.
pub(crate) fn found(table: &str, description: &str, more: &[&str]) -> (Shop, Value) {
    let shop = Shop::new().file("m.toml", MACHINE).file("d.csv", table).file("d.toml", description);
    let run = run(&shop, &["d.csv".to_owned()], "m.toml", more);
    (shop, report(&run))
}

/// A laser along X, forth and back, three times: errors by position, µm.
fn laser(places: &[f64], seed: u64, error: impl Fn(f64) -> f64) -> String {
    let mut random = Random::new(seed, "laser");
    let mut table = "run,setup,component,X,Y,Z,X_dir,value_um\n".to_owned();
    for run in 0..3 {
        for sense in [1, -1] {
            let mut order = places.to_vec();
            if sense < 0 {
                order.reverse();
            }
            for x in order {
                let value = error(x) + 0.4 * random.normal();
                let _ = writeln!(table, "{run}{sense},A,EXX,{x},250,200,{sense},{value:.4}");
            }
        }
    }
    table
}

const LASER: &str = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.4\n";

fn is_within(one: &Value, truth: f64) -> bool {
    (number(one, "value").abs() - truth).abs() <= number(one, "u95")
}

#[test]
fn uneven_targets_tell_a_pitch_below_two_steps() {
    for seed in 1..4 {
        let mut random = Random::new(seed, "targets");
        // Steps of 34 mm, each target off by up to a third of one (ISO 230-2).
        let places: Vec<f64> =
            (0..21).map(|k| ((10.0 + 34.0 * f64::from(k) + random.between(-11.0, 11.0)) * 1e3).round() / 1e3).collect();
        let table = laser(&places, seed, |x| 5.0 * (TAU * x / 10.0 + 0.7).sin());
        let (_, report) = found(&table, LASER, &[]);
        let all = findings(&report);
        assert_eq!(all.iter().map(name).collect::<Vec<_>>(), ["periodic EXX"], "{report}");
        assert!((number(&all[0], "period") - 10.0).abs() < 0.03, "{}", all[0]);
        assert!((number(&all[0], "value") - 5.0).abs() < 1.5 * number(&all[0], "u95"), "{}", all[0]);
        assert_eq!(all[0]["correctable"], "program");
        assert!(number(&report["after"], "rms_um") < 0.5, "{}", report["after"]);
    }
}

/// Targets about 24 mm apart: a wave of 340 mm has aliases of 22, 26 and 11 mm that explain nearly as much. Between the targets they are wrong by its amplitude.
#[test]
fn a_slow_wave_between_nearly_even_targets_is_a_curve() {
    let truth = |x: f64| 0.022 * x + 3.0 * (TAU * x / 340.0).sin();
    for seed in 1..4 {
        let mut random = Random::new(seed, "nearly even");
        let places: Vec<f64> =
            (0..29).map(|k| ((10.0 + 24.0 * f64::from(k) + random.between(-2.0, 2.0)) * 1e3).round() / 1e3).collect();
        let (shop, report) = found(&laser(&places, seed, truth), LASER, &["-o", "out.toml"]);
        assert_eq!(findings(&report).iter().map(name).collect::<Vec<_>>(), ["motion EXX"], "{report}");
        let dense: Vec<f64> = (0..130).map(|k| 15.0 + 5.0 * f64::from(k)).collect();
        let rows: String = dense.iter().map(|x| format!("1,A,EXX,{x},250,200,1,0\n")).collect();
        let shop = shop
            .file("dense.csv", format!("run,setup,component,X,Y,Z,X_dir,value_um\n{rows}"))
            .file("dense.toml", LASER);
        shop.run(["simulate", "dense.csv", "--machine", "out.toml", "-o", "model.csv"]).exits(0);
        let model = shop.text("model.csv");
        let values = model.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse::<f64>().unwrap());
        let off: Vec<f64> = values.zip(&dense).map(|(value, x)| value - truth(*x)).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let rms = (off.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / off.len() as f64).sqrt();
        // A knotted parabola with pieces of a twelfth of the range follows two cycles within 5 %, and the noise of a mean of six readings is 0.16 um.
        assert!(rms < 0.3, "{seed}: {rms}");
    }
}

#[test]
fn even_targets_leave_a_class_of_periods_and_nothing_to_write() {
    // Every 25 mm a pitch of 16 mm is the same as 1/(1/16 − 1/25) = 44.44 mm and as 1/(2/25 − 1/16) = 57.14 mm, one of 20 mm as 100 mm and 33.33 mm.
    let places: Vec<f64> = (0..28).map(|k| 10.0 + 25.0 * f64::from(k)).collect();
    for (period, aliases) in [(16.0, [44.44, 57.14]), (20.0, [33.33, 100.0])] {
        let table = laser(&places, 1, |x| 5.0 * (TAU * x / period + 0.7).sin());
        let (shop, report) = found(&table, LASER, &["-o", "out.toml"]);
        let all = findings(&report);
        assert_eq!(all.iter().map(name).collect::<Vec<_>>(), ["periodic EXX"], "{report}");
        let one = &all[0];
        let class: Vec<f64> =
            one["class"].as_array().unwrap().iter().filter_map(Value::as_str).filter_map(every).collect();
        let has = |wanted: f64| {
            let known = class.iter().chain([&number(one, "period")]).copied().collect::<Vec<_>>();
            known.iter().any(|period| (period / wanted - 1.0).abs() < 0.01)
        };
        assert!(has(period) && aliases.into_iter().all(has), "{one}");
        // A usual pitch of screws is named first.
        assert!((number(one, "period") / period - 1.0).abs() < 0.01, "{one}");
        assert!((number(one, "value") - 5.0).abs() < 1.5 * number(one, "u95"), "{one}");
        assert!(one["separate_by"].as_str().unwrap().contains("uneven spacing"), "{one}");
        assert_eq!(one["correctable"], "no");
        assert_eq!(one["extends"], false);
        assert!(one["extends_why"].as_str().unwrap().contains("periods"), "{one}");
        assert!(!shop.path("out.toml").exists());
    }
}

/// The period of `periodic EXX every 16.67 mm`.
fn every(entry: &str) -> Option<f64> {
    entry.split_once(" every ")?.1.strip_suffix(" mm")?.parse().ok()
}

#[test]
fn what_every_target_has_of_its_own_is_no_wave() {
    for seed in 1..5 {
        let mut random = Random::new(seed, "own");
        let places: Vec<f64> = (0..21).map(|k| 10.0 + 34.0 * f64::from(k) + random.between(-9.0, 9.0)).collect();
        let own: Vec<f64> = places.iter().map(|_| 6.0 * random.normal()).collect();
        let at = |x: f64| places.iter().position(|place| *place == x).map_or(0.0, |k| own[k]);
        let (_, report) = found(&laser(&places, seed, at), LASER, &[]);
        let before = number(&report["before"], "rms_um");
        for one in findings(&report) {
            assert_ne!(one["effect"], "periodic", "{one}");
            // Terms that nearly cancel each other are far larger than all there is.
            assert!(number(&one, "rms_um") < 3.0 * before, "{before}: {one}");
        }
    }
}

#[test]
fn lobes_on_a_coarse_circle_are_no_chords() {
    let mut random = Random::new(1, "lobes");
    let mut table = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_x_mm,tool_y_mm,tool_z_mm,dr_um\n".to_owned();
    for plane in [[0, 1], [1, 2], [2, 0]] {
        for sense in [1.0, -1.0] {
            for k in 0..=90 {
                // Every 4°.
                let angle: f64 = sense * TAU * f64::from(k) / 90.0;
                let mut at = [350.0, 250.0, 250.0];
                at[plane[0]] += 100.0 * angle.cos();
                at[plane[1]] += 100.0 * angle.sin();
                let mut senses = [0.0; 3];
                senses[plane[0]] = if sense * angle.sin() > 0.0 { -1.0 } else { 1.0 };
                senses[plane[1]] = if sense * angle.cos() < 0.0 { -1.0 } else { 1.0 };
                let lobes = if plane == [0, 1] { 2.5 * (7.0 * angle).cos() } else { 0.0 };
                let reading = lobes + 0.6 * random.normal();
                let ([x, y, z], [a, b, c]) = (at, senses);
                let _ = writeln!(
                    table,
                    "{}{sense},A,{x:.6},{y:.6},{z:.6},{a},{b},{c},0,0,-100,{reading:.4}",
                    ["XY", "YZ", "ZX"][plane[0]]
                );
            }
        }
    }
    let description = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\", \"length\"]\nsigma_um = 0.6\n\
                       [setup.A]\ncentre_mm = [350, 250, 150]\nlength_mm = 100\n";
    let (_, report) = found(&table, description, &[]);
    let all = findings(&report);
    assert_eq!(all.iter().map(name).collect::<Vec<_>>(), ["unknown XY"], "{report}");
    assert!(is_within(&all[0], 2.5), "{}", all[0]);
    assert_eq!(all[0]["drivers"], serde_json::json!(["X", "Y"]));
    assert!(all[0]["what"].as_str().unwrap().contains("7 lobes"), "{}", all[0]);
    assert!(number(&report["after"], "rms_um") < 0.66, "{}", report["after"]);
}

#[test]
fn many_errors_at_once_are_named_one_by_one() {
    // One carries the next: X, Y, Z. Bows have no slope over the range, so that a squareness is a slope.
    let bow = |q: f64, middle: f64, half: f64, size: f64| size * ((q - middle) / half).powi(2);
    let truth = [
        ("location EC0Y", 16.0),
        ("location EB0Z", 12.0),
        ("location EA0Z", 9.0),
        ("motion EXX", 20.0),
        ("motion EYY", 15.0),
        ("motion EZZ", 25.0),
        ("motion EYX", 8.0),
        ("motion EZX", 6.0),
        ("motion EXY", 7.0),
        ("motion EZY", 9.0),
        ("motion EXZ", 5.0),
        ("motion EYZ", 6.0),
    ];
    for seed in 1..4 {
        let mut random = Random::new(seed, "many");
        let mut table = "run,X,Y,Z,dx_um,dy_um,dz_um\n".to_owned();
        for run in 1..=2 {
            for (i, j, k) in (0..125).map(|n| (n / 25, n / 5 % 5, n % 5)) {
                let [x, y, z] = [50.0 + 150.0 * f64::from(i), 50.0 + 100.0 * f64::from(j), 50.0 + 100.0 * f64::from(k)];
                let noise = [0; 3].map(|_| 0.6 * random.normal());
                // µrad · mm / 1000 = µm; Y turned about Z moves to −X, Z about Y to X, Z about X to −Y.
                let dx = 0.020 * x - 0.016 * y - 0.012 * z + bow(y, 250.0, 200.0, 7.0) - bow(z, 250.0, 200.0, 5.0);
                let dy = -0.015 * y - 0.009 * z + bow(x, 350.0, 300.0, 8.0) + bow(z, 250.0, 200.0, 6.0);
                let dz = 0.025 * z + bow(x, 350.0, 300.0, 6.0) - bow(y, 250.0, 200.0, 9.0);
                let [dx, dy, dz] = [dx + noise[0], dy + noise[1], dz + noise[2]];
                let _ = writeln!(table, "{run},{x},{y},{z},{dx:.4},{dy:.4},{dz:.4}");
            }
        }
        let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.6\n";
        let (_, report) = found(&table, description, &[]);
        let all = findings(&report);
        let names: Vec<String> = all.iter().map(name).collect();
        let one = |wanted: &str| all.iter().find(|one| name(one) == *wanted);
        let missing: Vec<&str> = truth.iter().map(|(name, _)| *name).filter(|name| one(name).is_none()).collect();
        assert!(missing.is_empty() && names.len() == truth.len(), "{missing:?} of {names:?}");
        let right = truth.iter().filter(|(name, size)| one(name).is_some_and(|one| is_within(one, *size))).count();
        assert!(right + 2 >= truth.len(), "{all:#?}");
        assert!(number(&report["after"], "rms_um") < 0.63, "{}", report["after"]);
    }
}
