//! Where the design of a measurement leaves the cause open, a diagnosis says so: place, direction, speed and time that predict the same readings share the
//! probability, and nothing is written. The readings are made by formulas of their own.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use serde_json::Value;

use crate::cli_calibrate::bare;
use crate::diagnose::{findings, name, number, report, run};
use crate::plant::Random;
use crate::support::Shop;

const LINE: &str = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.3\n";
const CIRCLE: &str = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\nsigma_um = 0.5\n\
                      [setup.A]\ncentre_mm = [350, 250, 100]\nlength_mm = 150\n";
/// Two equal rivals have a half each but for the noise of the readings, and neither may come near the 95 % of a certain cause.
const SHARED: f64 = 0.85;

/// The report of a diagnosis that may write, and whether it did.
fn diagnosed(table: &str, description: &str) -> (Value, bool) {
    let shop = Shop::new().file("m.toml", bare("demo")).file("d.csv", table).file("d.toml", description);
    let report = report(&run(&shop, &["d.csv".to_owned()], "m.toml", &["-o", "out.toml"]));
    (report, shop.path("out.toml").exists())
}

/// Nothing is written, nothing counts as certain, and the text agrees; the named rivals are those expected.
fn is_open(table: &str, description: &str, rivals: &[&str]) {
    let (report, is_written) = diagnosed(table, description);
    let all = findings(&report);
    assert!(!all.is_empty() && !is_written, "{report:#}");
    for one in &all {
        assert!(number(one, "probability") <= SHARED, "{one:#}");
        assert!(one["certain"] == false && one["correctable"] == "no" && one["extends"] == false, "{one:#}");
        let named: Vec<&str> =
            one["rivals"].as_array().unwrap().iter().map(|one| one["cause"].as_str().unwrap()).collect();
        let own = name(one);
        for rival in rivals {
            assert!(own == *rival || named.contains(rival), "{rival}: {one:#}");
        }
        assert!(one["separate_by"].as_str().is_some_and(|how| how.len() > 20), "{one:#}");
    }
    // The explanations share alike.
    let explanations = report["explanations"].as_array().unwrap();
    assert!(explanations.iter().all(|one| number(one, "probability") <= SHARED), "{report:#}");
}

/// A line of X at 30, 60 … mm over some ways, 1 upwards and −1 downwards: readings by position, way and number of the row, µm, with columns by the number.
fn line(
    seed: u64,
    (count, ways): (u32, &[f64]),
    head: &str,
    cells: impl Fn(u32) -> String,
    um: impl Fn(f64, f64, f64) -> f64,
) -> String {
    let mut random = Random::new(seed, "line");
    let mut table = format!("run,setup,component,X,Y,Z,X_dir,Y_dir,Z_dir{head},value_um\n");
    let mut row = 0;
    for (run, way) in ways.iter().enumerate() {
        for k in 0..count {
            let at = if *way > 0.0 { k } else { count - 1 - k };
            let x = 30.0 + 600.0 * f64::from(at) / f64::from(count - 1);
            let value = um(x, *way, f64::from(row)) + 0.3 * random.normal();
            let _ = writeln!(table, "{},A,EXX,{x},250,200,{way},0,0{},{value:.4}", run / 2 + 1, cells(row));
            row += 1;
        }
    }
    table
}

#[test]
fn a_temperature_that_rises_with_the_position_leaves_scale_and_drift_open() {
    let cells = |row: u32| format!(",{},{}", 30 * row, 20.0 + 0.05 * f64::from(row));
    for seed in 1..=8 {
        // 21 targets in one way: 10.6 µm/K of drift, or 17.7 µm/m of scale, which is the same 10.6 µm at the end.
        let drift = line(seed, (21, &[1.0]), ",t_s,T_head_C", cells, |_, _, row| 10.6 * 0.05 * row);
        let scale = line(seed, (21, &[1.0]), ",t_s,T_head_C", cells, |x, _, _| 10.6 * (x - 30.0) / 600.0);
        for table in [drift, scale] {
            is_open(&table, LINE, &["motion EXX"]);
        }
    }
}

#[test]
fn a_scale_is_certain_where_the_line_was_measured_back_and_forth() {
    let cells = |row: u32| format!(",{},{}", 30 * row, 20.0 + 0.05 * f64::from(row));
    for seed in 1..=4 {
        let table = line(seed, (11, &[1.0, -1.0, 1.0, -1.0]), ",t_s,T_head_C", cells, |x, _, _| 0.0177 * x);
        let (report, is_written) = diagnosed(&table, LINE);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]) == "motion EXX" && is_written, "{report:#}");
        assert!(all[0]["certain"] == true && all[0]["rivals"] == serde_json::json!([]), "{report:#}");
        assert!((number(&all[0], "value") - 17.7).abs() < 2.0 * number(&all[0], "u95"), "{report:#}");
    }
}

#[test]
fn a_drift_along_the_rows_is_no_backlash_to_correct() {
    for seed in 1..=8 {
        // 0.5 µm per row, forward and backward: the gap between the ways shrinks to nothing at the turn.
        let table = line(seed, (21, &[1.0, -1.0]), "", |_| String::new(), |_, _, row| 0.5 * row);
        let (report, is_written) = diagnosed(&table, LINE);
        let all = findings(&report);
        assert!(all.len() == 1 && !is_written, "seed {seed}: {report:#}");
        // A backlash that grows along the axis has the same gap; it needs one number more, so it is rarely named before the drift.
        if name(&all[0]) == "drift X" {
            assert!((number(&all[0], "value").abs() - 0.5 * 41.0).abs() < 2.0 * number(&all[0], "u95"), "{report:#}");
        } else {
            assert!(all[0]["rivals"][0]["cause"] == "drift X" && all[0]["certain"] == false, "{report:#}");
        }
        // A constant gap of 6 µm over the same rows is a backlash.
        let table = line(seed, (21, &[1.0, -1.0]), "", |_| String::new(), |_, way, _| 3.0 * way);
        let (report, is_written) = diagnosed(&table, LINE);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]) == "backlash EXX" && is_written, "seed {seed}: {report:#}");
    }
}

/// Circles of 150 mm in XY, each in a sense, with a feed or without one: readings by the unit vector along the bar and the unit velocity, µm.
fn circles(seed: u64, senses: &[f64], has_feed: bool, um: impl Fn([f64; 2], [f64; 2]) -> [f64; 2]) -> String {
    let mut random = Random::new(seed, "open circle");
    let feed = if has_feed { ",feed_mm_min" } else { "" };
    let mut table = format!("run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm{feed},dr_um\n");
    for (run, sense) in senses.iter().enumerate() {
        for k in 0..120 {
            // From between two quadrants, so that no reading is at a reversal.
            let angle: f64 = sense * TAU * (f64::from(k) + 0.5) / 120.0;
            let (along, velocity) = ([angle.cos(), angle.sin()], [-sense * angle.sin(), sense * angle.cos()]);
            let [dx, dy] = um(along, velocity);
            let dr = dx * along[0] + dy * along[1] + 0.5 * random.normal();
            let [x, y] = [350.0 + 150.0 * along[0], 250.0 + 150.0 * along[1]];
            let [a, b] = velocity.map(f64::signum);
            let cell = if has_feed { ",1000" } else { "" };
            let _ = writeln!(table, "{run},A,{x:.6},{y:.6},220,{a},{b},0,-120{cell},{dr:.4}");
        }
    }
    table
}

#[test]
fn nothing_is_written_that_is_told_with_less_than_95_percent() {
    let (mut held, mut open) = (0, 0);
    let [there, twice, up] = [&[1.0, -1.0][..], &[1.0, -1.0, 1.0, -1.0], &[1.0, 1.0, 1.0]];
    for seed in 1..=3 {
        for (count, ways) in [(5, there), (7, there), (11, there), (5, twice), (7, up)] {
            // Reversal values at the two ends of the line, µm; a scale, µm at its end; a drift, µm per row.
            for (gap, far, scale, drift) in [
                (1.0, 2.0, 0.0, 0.0),
                (0.0, 2.0, 0.0, 0.0),
                (2.0, -2.0, 0.0, 0.0),
                (6.0, 0.0, 0.0, 0.0),
                (2.0, 10.0, 0.0, 0.0),
                (0.5, 0.5, 1.0, 0.0),
                (0.0, 0.0, 3.0, 0.1),
                (0.0, 0.0, 0.0, 0.0),
            ] {
                let table = line(
                    seed,
                    (count, ways),
                    "",
                    |_| String::new(),
                    |x, way, row| {
                        let share = (x - 30.0) / 600.0;
                        0.5 * way * (gap + (far - gap) * share) + scale * share + drift * row
                    },
                );
                let (report, is_written) = diagnosed(&table, LINE);
                let all = findings(&report);
                let (holds, others): (Vec<&Value>, Vec<&Value>) = all.iter().partition(|one| one["extends"] == true);
                for one in &holds {
                    assert!(number(one, "probability") >= 0.95 && one["certain"] == true, "seed {seed}: {report:#}");
                }
                assert_eq!(is_written, !holds.is_empty(), "seed {seed}: {report:#}");
                (held, open) = (held + holds.len(), open + others.len());
            }
        }
    }
    // Both happen, so the rule was tested.
    assert!(held > 30 && open > 3, "{held} {open}");
}

#[test]
fn five_targets_in_one_direction_name_the_next_measurement_and_no_sure_explanation() {
    for seed in 1..=4 {
        let table = line(seed, (5, &[1.0]), "", |_| String::new(), |x, _, _| 0.0177 * x);
        let (report, is_written) = diagnosed(&table, LINE);
        assert!(!is_written && findings(&report).iter().all(|one| one["certain"] == false), "{report:#}");
        let explanations = report["explanations"].as_array().unwrap();
        assert!(!explanations.is_empty() && report["no_cause_probability"].as_f64().is_some(), "{report:#}");
        assert!(explanations.iter().all(|one| number(one, "probability") <= SHARED), "{report:#}");
        let shop = Shop::new().file("m.toml", bare("demo")).file("d.csv", table).file("d.toml", LINE);
        let text = shop.run(["diagnose", "d.csv", "--machine", "m.toml"]).stdout;
        assert!(
            text.lines().next().is_some_and(|first| first.contains("directions") || first.contains("backward")),
            "{text}"
        );
    }
}

#[test]
fn a_wave_of_the_screw_at_even_targets_is_no_table_to_correct() {
    for seed in 1..=3 {
        // A pitch of 40 mm at steps of 100 mm: the values alternate, and between the targets nobody knows them.
        let wave = |x: f64, _: f64, _: f64| 4.0 * (TAU * x / 40.0).sin();
        let table = line(seed, (7, &[1.0, -1.0, 1.0, -1.0]), "", |_| String::new(), wave);
        let (report, is_written) = diagnosed(&table, LINE);
        assert!(!is_written, "seed {seed}: {report:#}");
        for one in findings(&report).iter().filter(|one| name(one) == "motion EXX") {
            assert!(one["certain"] == false && number(one, "probability") < 0.95, "{one:#}");
            assert!(
                one["rivals"][0]["cause"].as_str().is_some_and(|rival| rival.starts_with("periodic EXX")),
                "{one:#}"
            );
        }
    }
}

/// The demo machine with another chain; axes that carry the workpiece move it against their command.
fn with_chain(topology: &str) -> String {
    let (workpiece, _) = topology.split_once('F').unwrap();
    let text = bare("demo").replace("wXYFZSt", topology);
    let mut axis = None;
    let mut out = String::new();
    for line in text.lines() {
        if line.starts_with('[') {
            axis = line.strip_prefix("[axis.").and_then(|rest| rest.chars().next());
        }
        match axis.filter(|_| line.starts_with("direction")) {
            Some(letter) => {
                let sign = if workpiece.contains(letter) { -1.0 } else { 1.0 };
                let parts = ['X', 'Y', 'Z'].map(|own| if own == letter { sign } else { 0.0 });
                let _ = writeln!(out, "direction = {parts:?}");
            }
            None => out += &format!("{line}\n"),
        }
    }
    out
}

#[test]
fn one_squareness_has_one_name_on_every_chain() {
    // X leans by 9 µm over 150 mm of Y: 60 µrad. A positive turn of Y about Z leans it towards −X.
    let table = circles(3, &[1.0, -1.0], true, |along, _| [9.0 * along[1], 0.0]);
    for topology in [
        "wFXYZSt", "wXFYZSt", "wXYFZSt", "wXYZFSt", "wXFZYSt", "wXZFYSt", "wXZYFSt", "wFYXZSt", "wYFXZSt", "wYXFZSt",
        "wYXZFSt", "wYFZXSt", "wYZFXSt", "wFZXYSt", "wZFXYSt", "wZXFYSt", "wZXYFSt", "wZFYXSt", "wZYFXSt", "wZYXFSt",
    ] {
        let shop = Shop::new().file("m.toml", with_chain(topology)).file("d.csv", table.clone()).file("d.toml", CIRCLE);
        let report = report(&run(&shop, &["d.csv".to_owned()], "m.toml", &["-o", "out.toml"]));
        let all = findings(&report);
        assert!(all.len() == 1 && shop.path("out.toml").exists(), "{topology}: {report:#}");
        // An axis that carries the other one turns both: no squareness.
        let place = |letter: char| topology.find(letter).unwrap() as f64 - topology.find('F').unwrap() as f64;
        let [x, y] = [place('X'), place('Y')];
        let [is_x_carried, is_y_carried] = [x * y > 0.0 && x.abs() > y.abs(), x * y > 0.0 && y.abs() > x.abs()];
        let (expected, value) = if is_x_carried { ("location EC0X", 60.0) } else { ("location EC0Y", -60.0) };
        assert_eq!(name(&all[0]), expected, "{topology}");
        assert!((number(&all[0], "value") - value).abs() < 2.0 * number(&all[0], "u95"), "{topology}: {report:#}");
        assert!(report["explanations"][0]["terms"].as_array().unwrap().contains(&expected.into()), "{report:#}");
        // Seen from the other axis, the angle has the opposite sign.
        let same = all[0]["same_as"].as_array().unwrap().iter().find(|one| one["name"] == "EC0X");
        assert_eq!(same.is_some(), !is_x_carried && !is_y_carried, "{topology}: {report:#}");
        if let Some(same) = same {
            assert!((number(same, "value") + number(&all[0], "value")).abs() < 0.01, "{topology}: {report:#}");
        }
    }
}

/// The place of a ball for axis A of a tilting table whose bearing lies along X: the commands at which a probe whose length is `long` µm too short by its
/// description reads it.
fn probed(seed: u64, long: f64) -> (String, String) {
    let balls = [[80.0, 0.0, 60.0], [0.0, 90.0, 75.0], [-85.0, 10.0, 90.0], [5.0, -80.0, 50.0]];
    let mut random = Random::new(seed, "probe");
    let mut table = "X,Y,Z,A,C,target,tool_z_mm\n".to_owned();
    for a in [-90.0_f64, -45.0, 0.0, 45.0, 90.0] {
        for c in [0.0_f64, 120.0, 240.0] {
            for (number, [x, y, z]) in balls.iter().enumerate() {
                // Axes of the table turn the workpiece against their command.
                let (sine, cosine) = (-c).to_radians().sin_cos();
                let [u, v] = [x * cosine - y * sine, x * sine + y * cosine];
                let (sine, cosine) = (-a).to_radians().sin_cos();
                let at = [u, v * cosine - z * sine, v * sine + z * cosine + 200.0 + 1e-3 * long];
                let [x, y, z] = at.map(|own| own + 0.5e-3 * random.normal());
                let _ = writeln!(table, "{x:.6},{y:.6},{z:.6},{a},{c},{},-200", number + 1);
            }
        }
    }
    let apart = |k: usize, l: usize| (0..3).map(|i| (balls[k][i] - balls[l][i]).powi(2)).sum::<f64>().sqrt();
    let mut description = "[measurement]\nkind = \"probe\"\nsigma_um = 0.5\nfree = []\n".to_owned();
    for (k, l) in [(0, 2), (1, 3)] {
        let _ = writeln!(
            description,
            "[[length]]\nfrom = \"{}\"\nto = \"{}\"\nvalue_mm = {:.6}",
            k + 1,
            l + 1,
            apart(k, l)
        );
    }
    (table, description)
}

#[test]
fn a_pretravel_of_the_probe_stands_beside_an_offset_of_the_table() {
    let machine = "[machine]\nname = \"trunnion\"\ntopology = \"wCAYXFZSt\"\ncontroller = \"sinumerik\"\n\
                   [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [-400, 400]\nmax_feed_mm_min = 12000\n\
                   [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-400, 400]\nmax_feed_mm_min = 12000\n\
                   [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-100, 600]\nmax_feed_mm_min = 12000\n\
                   [axis.A]\ndirection = [-1, 0, 0]\ntravel_deg = [-110, 110]\nmax_feed_deg_min = 12000\n\
                   [axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-720, 720]\nmax_feed_deg_min = 12000\n\
                   [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
    for seed in 1..=3 {
        let (table, description) = probed(seed, 20.0);
        let shop = Shop::new().file("m.toml", machine).file("d.csv", table).file("d.toml", description);
        let report = report(&run(&shop, &["d.csv".to_owned()], "m.toml", &["-o", "out.toml"]));
        let all = findings(&report);
        assert!(!all.is_empty() && !shop.path("out.toml").exists(), "seed {seed}: {report:#}");
        let one = &all[0];
        assert!((number(one, "value").abs() - 20.0).abs() < 1.0 && number(one, "probability") <= SHARED, "{one:#}");
        let is_beside = one["rivals"].as_array().unwrap().iter().any(|one| one["cause"] == "setup tool_z");
        assert!(is_beside || name(one) == "setup tool_z", "{one:#}");
        assert!(one["separate_by"].as_str().is_some_and(|how| how.contains("calibrated sphere or ring")), "{one:#}");
    }
}

#[test]
fn circles_in_one_direction_leave_squareness_and_mismatch_open() {
    for seed in 1..=4 {
        for sense in [1.0, -1.0] {
            for has_feed in [true, false] {
                // Lags that differ by 0.8 ms at 16.7 mm/s; X 60 µrad off square to Y.
                let lag = 0.8e-3 * 1000.0 / 60.0 * 1e3 / 2.0;
                let mismatch = circles(seed, &[sense, sense], has_feed, |_, v| [-lag * v[0], lag * v[1]]);
                let square = circles(seed, &[sense, sense], has_feed, |along, _| [9.0 * along[1], 0.0]);
                for table in [mismatch, square] {
                    is_open(&table, CIRCLE, &["servo-mismatch XY"]);
                }
            }
        }
    }
}

#[test]
fn circles_in_both_directions_tell_squareness_from_mismatch() {
    for seed in 1..=4 {
        let lag = 0.8e-3 * 1000.0 / 60.0 * 1e3 / 2.0;
        let senses = [1.0, -1.0];
        let (report, is_written) = diagnosed(&circles(seed, &senses, true, |_, v| [-lag * v[0], lag * v[1]]), CIRCLE);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]) == "servo-mismatch XY" && !is_written, "{report:#}");
        let (report, is_written) = diagnosed(&circles(seed, &senses, true, |along, _| [9.0 * along[1], 0.0]), CIRCLE);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]).starts_with("location EC0") && is_written, "{report:#}");
    }
}

#[test]
fn a_random_walk_around_a_circle_is_no_certain_scale() {
    for seed in 1..=16 {
        // Steps of 0.3 µm beside 0.1 µm of white noise.
        let mut random = Random::new(seed, "walk");
        let mut table = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,dr_um\n".to_owned();
        let mut walk = 0.0;
        for k in 0..360 {
            let angle: f64 = TAU * (f64::from(k) + 0.5) / 360.0;
            walk += 0.3 * random.normal();
            let [x, y] = [350.0 + 150.0 * angle.cos(), 250.0 + 150.0 * angle.sin()];
            let [a, b] = [-angle.sin().signum(), angle.cos().signum()];
            let _ = writeln!(table, "1,A,{x:.6},{y:.6},220,{a},{b},0,-120,{:.4}", walk + 0.1 * random.normal());
        }
        // One circle cannot tell a walk from a bow; neither may count as certain.
        let (report, is_written) = diagnosed(&table, CIRCLE);
        assert!(findings(&report).iter().all(|one| one["certain"] == false), "seed {seed}: {report:#}");
        assert!(!is_written, "seed {seed}: {report:#}");
    }
}

#[test]
fn the_largest_of_fifteen_good_readings_stays() {
    for seed in 1..=16 {
        // Normal readings below 2.5 σ, and one at 3.3 σ.
        let mut random = Random::new(seed, "fifteen");
        let mut table = "run,setup,component,X,Y,Z,value_um\n".to_owned();
        let far = seed % 15;
        for k in 0..15 {
            let mut own = random.normal();
            while own.abs() > 2.5 {
                own = random.normal();
            }
            let value = if k == far { 3.3 } else { own };
            let _ = writeln!(table, "1,A,EXX,{},250,200,{value:.4}", 30 + 40 * k);
        }
        let (report, _) = diagnosed(&table, &LINE.replace("0.3", "1"));
        let faults = report["data_faults"].as_array().unwrap();
        assert!(faults.iter().all(|one| one["kind"] != "outlier"), "seed {seed}: {report:#}");
    }
}

/// A line of X whose readings have a sign, µm: 40 µm/m.
fn signed_line(seed: u64, name: &str, z: f64, sign: f64) -> String {
    let mut random = Random::new(seed, name);
    let mut table = "run,setup,component,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,value_um\n".to_owned();
    for run in 0..6 {
        let way = if run % 2 == 0 { 1 } else { -1 };
        for k in 0..13 {
            let x = 50.0 * f64::from(if way > 0 { k } else { 12 - k }) + 30.0;
            let value = sign * 0.04 * x + 0.3 * random.normal();
            let _ = writeln!(table, "{run},A,EXX,{x},250,{z},{way},0,0,-60,{value:.4}");
        }
    }
    table
}

/// Circles of a bar of unknown length in three planes: the distance grows with X by 40 µm/m, as the tool moves towards +X.
fn signed_circles(seed: u64) -> String {
    let mut random = Random::new(seed, "circles");
    let mut table = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,dr_um\n".to_owned();
    for (setup, [u, v]) in [("XY", [0, 1]), ("YZ", [1, 2]), ("ZX", [2, 0])] {
        for way in [1.0, -1.0] {
            for k in 0..72 {
                let angle = way * TAU * (f64::from(k) + 0.5) / 72.0;
                let (mut at, mut turn) = ([350.0, 250.0, 220.0], [0.0; 3]);
                (at[u], at[v]) = (at[u] + 150.0 * angle.cos(), at[v] + 150.0 * angle.sin());
                (turn[u], turn[v]) = (-way * angle.sin().signum(), way * angle.cos().signum());
                let along = if u == 0 {
                    angle.cos()
                } else if v == 0 {
                    angle.sin()
                } else {
                    0.0
                };
                let value = 0.04 * 150.0 * along * along + 0.4 * random.normal();
                let [[x, y, z], [a, b, c]] = [at, turn];
                let _ = writeln!(table, "{setup}{way},{setup},{x:.6},{y:.6},{z:.6},{a},{b},{c},-120,{value:.4}");
            }
        }
    }
    table
}

/// A diagnosis of two files that may write, the name of the second, and whether it wrote.
fn of_two([first, second]: [(&str, &str); 2]) -> (Value, bool) {
    let shop = Shop::new().file("m.toml", bare("demo"));
    let shop = shop.file("a.csv", first.0).file("a.toml", first.1).file("b.csv", second.0).file("b.toml", second.1);
    let report = report(&run(&shop, &["a.csv".to_owned(), "b.csv".to_owned()], "m.toml", &["-o", "out.toml"]));
    (report, shop.path("out.toml").exists())
}

/// Every finding has the sign of a file as a rival, and nothing is written.
fn may_have_the_wrong_sign(report: &Value, is_written: bool) {
    let all = findings(report);
    assert!(!all.is_empty() && !is_written, "{report:#}");
    for one in &all {
        let rivals = one["rivals"].as_array().unwrap();
        let is_of_sign =
            |rival: &Value| rival["cause"].as_str().is_some_and(|cause| cause.starts_with("setup sign of"));
        assert!(rivals.iter().any(is_of_sign) && one["certain"] == false, "{one:#}");
    }
}

#[test]
fn a_wrong_sign_of_one_file_is_a_rival_of_what_only_the_contradiction_shows() {
    let bar: String = ["XY", "YZ", "ZX"]
        .map(|setup| format!("[setup.{setup}]\ncentre_mm = [350, 250, 100]\nlength_mm = 150\n"))
        .concat();
    let bar = format!("[measurement]\nkind = \"ballbar\"\nfree = [\"centre\", \"length\"]\nsigma_um = 0.4\n{bar}");
    for seed in 1..=3 {
        // Two lines at two heights: with one sign an error along X, with two signs no cross-coupling that is certain.
        let lines = |sign: f64| [signed_line(seed, "low", 160.0, 1.0), signed_line(seed, "high", 400.0, sign)];
        let [low, high] = lines(1.0);
        let (report, is_written) = of_two([(&low, LINE), (&high, LINE)]);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]) == "motion EXX" && is_written, "{report:#}");
        let [low, high] = lines(-1.0);
        let (report, is_written) = of_two([(&low, LINE), (&high, LINE)]);
        may_have_the_wrong_sign(&report, is_written);
        // X of the demo machine moves the workpiece: a bar that becomes longer with X sees an error of that table towards −X.
        let circles = signed_circles(seed);
        let (report, is_written) = of_two([(&circles, &bar), (&signed_line(seed, "line", 200.0, -1.0), LINE)]);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]) == "motion EXX" && is_written, "{report:#}");
        let (report, is_written) = of_two([(&circles, &bar), (&signed_line(seed, "line", 200.0, 1.0), LINE)]);
        may_have_the_wrong_sign(&report, is_written);
    }
}

#[test]
fn the_jumps_between_the_rows_of_a_plate_are_no_other_unit() {
    // 60 µrad of squareness move X by 6 µm from point to point, ten times the noise; two runs are too few to repeat.
    for (seed, runs) in [(1, 1), (2, 2), (3, 2)] {
        let mut random = Random::new(seed, "plate");
        let mut table = "run,setup,X,Y,Z,tool_z_mm,dx_um,dy_um\n".to_owned();
        for run in 0..runs {
            for x in 0..7 {
                for y in 0..5 {
                    let [x, y] = [50.0 + 100.0 * f64::from(x), 50.0 + 100.0 * f64::from(y)];
                    let (dx, dy) = (0.08 * y + 0.6 * random.normal(), -0.02 * x + 0.6 * random.normal());
                    let _ = writeln!(table, "{run},A,{x},{y},100,-120,{dx:.4},{dy:.4}");
                }
            }
        }
        let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\", \"rotation\"]\nsigma_um = 0.6\n";
        let (report, _) = diagnosed(&table, description);
        assert!(report["data_faults"].as_array().is_some_and(Vec::is_empty), "{report:#}");
        assert!(findings(&report).iter().any(|one| name(one).starts_with("location EC0")), "{report:#}");
    }
}
