//! Logs of temperatures with another clock, and sensors that are stuck although their display often repeats a number. The machine and its logs are arithmetic
//! of this file: bodies of the first order that follow a spindle, in steps of ten seconds.

use std::fmt::Write as _;

use ncfix_base::source::{FileId, Source};
use ncfix_metrology::diagnose::Scene;
use ncfix_metrology::diagnose::fault::{self, DataDefect, Then};
use ncfix_metrology::measure::data;
use serde_json::Value;

use crate::plant::Random;
use crate::support::Shop;

const MACHINE: &str = "[machine]\nname = \"gantry\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-350, 60]\n";
const DESCRIPTION: &str = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.4\nfree = [\"offset\"]\n";

/// Name, time constant (s) and rise (K) of the bodies that have sensors.
const BODIES: [(&str, f64, f64); 4] =
    [("T_nose_C", 400.0, 8.0), ("T_head_C", 2700.0, 5.0), ("T_column_C", 7200.0, 3.0), ("T_bed_C", 15000.0, 1.5)];
/// Step of the arithmetic, s.
const STEP_S: f64 = 10.0;
/// Time before and after the readings, s.
const MARGIN_S: f64 = 9000.0;

/// A day of a machine and the log of it.
#[derive(Clone, Debug)]
struct Day {
    rows: usize,
    /// The body that the readings follow, µm/K, and with which time constants in series, s.
    body: usize,
    um_per_k: f64,
    lags_s: [f64; 2],
    /// Also this share of the column.
    column: f64,
    /// The clock of the log is ahead by this, s.
    ahead_s: f64,
    /// Noise of the readings, µm, their random walk from row to row, µm, and the noise of the sensors, K.
    noise_um: f64,
    walk_um: f64,
    noise_k: f64,
    /// Step of the displays, K.
    display_k: f64,
}

impl Default for Day {
    fn default() -> Day {
        Day {
            rows: 480,
            body: 1,
            um_per_k: 5.0,
            lags_s: [0.0; 2],
            column: 0.0,
            ahead_s: 0.0,
            noise_um: 0.4,
            walk_um: 0.0,
            noise_k: 0.02,
            display_k: 0.01,
        }
    }
}

/// Rows of the log: the readings, and the temperatures as displayed.
struct DayLog {
    readings_um: Vec<[f64; 3]>,
    sensors: [Vec<f64>; 4],
}

impl Day {
    fn log(&self, seed: u64) -> DayLog {
        let mut random = Random::new(seed, "log");
        let steps = ((60.0 * self.rows as f64 + 2.0 * MARGIN_S) / STEP_S) as usize;
        let rest = (MARGIN_S / STEP_S) as usize + random.below(100);
        let mut drive = vec![0.0; rest];
        while drive.len() < steps {
            let speed = random.pick(&[0.0, 0.3, 0.6, 1.0]);
            let minutes = 25 + random.below(65);
            drive.extend(std::iter::repeat_n(speed, minutes * 6));
        }
        let follow = |of: &[f64], lag_s: f64, from: f64| -> Vec<f64> {
            let (mut at, share) = (from, 1.0 - (-STEP_S / lag_s).exp());
            of.iter()
                .map(|drive| {
                    at += (drive - at) * share;
                    at
                })
                .collect()
        };
        let hall = random.between(0.0, 6.0);
        let bodies = BODIES.map(|(_, tau_s, rise_k)| {
            let of = |(step, drive): (usize, &f64)| {
                rise_k * drive + 0.3 * (step as f64 * STEP_S * std::f64::consts::TAU / 86_400.0 + hall).sin()
            };
            follow(&drive.iter().enumerate().map(of).collect::<Vec<f64>>(), tau_s, 0.0)
        });
        let mut drift: Vec<f64> =
            bodies[self.body].iter().zip(&bodies[2]).map(|(own, column)| own + self.column * column).collect();
        for lag_s in self.lags_s.into_iter().filter(|lag_s| *lag_s > 0.0) {
            drift = follow(&drift, lag_s, drift[0]);
        }
        let at = |of: &[f64], time_s: f64| of[((time_s + MARGIN_S) / STEP_S) as usize];
        let mut walk = 0.0;
        let mut log = DayLog { readings_um: Vec::new(), sensors: Default::default() };
        for row in 0..self.rows {
            let time_s = 60.0 * row as f64;
            walk += self.walk_um * random.normal();
            let z = self.um_per_k * (at(&drift, time_s) - at(&drift, 0.0)) + walk;
            log.readings_um.push([0.0, 0.0, z].map(|um| um + self.noise_um * random.normal()));
            for (sensor, body) in log.sensors.iter_mut().zip(&bodies) {
                // A clock that is ahead states a later time for the temperature of an earlier one.
                let true_c = 20.3 + at(body, time_s - self.ahead_s) + self.noise_k * random.normal();
                sensor.push((true_c / self.display_k).round() * self.display_k);
            }
        }
        log
    }
}

impl DayLog {
    fn table(&self) -> String {
        let names: Vec<&str> = BODIES.iter().map(|(name, ..)| *name).collect();
        let mut table = format!("t_s,X,Y,Z,tool_z_mm,dx_um,dy_um,dz_um,{}\n", names.join(","));
        for (row, [dx, dy, dz]) in self.readings_um.iter().enumerate() {
            let _ = write!(table, "{},300,200,-100,-120,{dx:.3},{dy:.3},{dz:.3}", 60 * row);
            self.sensors.iter().for_each(|sensor| {
                let _ = write!(table, ",{:.2}", sensor[row]);
            });
            table.push('\n');
        }
        table
    }

    /// A sensor repeats one value in some rows.
    fn hold(mut self, sensor: usize, [first, last]: [usize; 2]) -> DayLog {
        let value = self.sensors[sensor][first];
        self.sensors[sensor][first..=last].fill(value);
        self
    }

    /// Faults of sensors and clocks, and steps.
    fn faults(&self) -> Vec<DataDefect> {
        let source = |id, name: &str, text: &str| Source::new(FileId(id), name, text.as_bytes().to_vec()).unwrap();
        let (machine, errors) = ncfix_model::file::load(&source(0, "m.toml", MACHINE)).0.unwrap();
        let (table, description) = (source(1, "t.csv", &self.table()), source(2, "t.toml", DESCRIPTION));
        let sets = [data::load_with_dead("t", &table, &description, &machine).0.unwrap()];
        let found = fault::find(&Scene::new(&machine, &errors, &sets).unwrap());
        found.into_iter().filter(|one| ["sensor", "clock", "step"].contains(&one.kind.word())).collect()
    }
}

fn said(found: &[DataDefect]) -> Vec<String> {
    found.iter().map(|one| format!("{} {} {:?}: {}", one.name, one.what, one.rows, one.evidence)).collect()
}

#[test]
fn a_log_with_another_clock_is_named_with_its_offset_and_shifted() {
    let (mut shifted, mut all) = (0, 0);
    for seed in 1..=8 {
        for ahead_s in [900.0, -900.0, 3600.0] {
            let day = Day { ahead_s, body: seed as usize % 2, ..Day::default() };
            let found = day.log(seed).faults();
            let clock: Vec<&DataDefect> = found.iter().filter(|one| one.kind.word() == "clock").collect();
            all += 1;
            // An early log and a body with a time constant may be alike; then both are stated.
            match clock.first().map(|one| &one.then) {
                Some(Then::ShiftLog(log)) => {
                    shifted += 1;
                    assert!((log.by_s - ahead_s).abs() < 120.0, "{seed} {ahead_s}: {:?}", said(&found));
                    assert_eq!((log.columns.len(), clock[0].name.as_str()), (4, "temperatures"));
                    let side = if ahead_s > 0.0 { "ahead" } else { "behind" };
                    assert!(clock[0].evidence.contains(side), "{}", clock[0].evidence);
                }
                _ => assert!(ahead_s < 0.0, "{seed} {ahead_s}: {:?}", said(&found)),
            }
        }
    }
    assert!(shifted + 4 >= all, "{shifted} of {all}");
}

#[test]
fn a_body_that_follows_late_or_noise_that_wanders_is_no_other_clock() {
    let none = Day::default();
    let kinds = [
        none.clone(),
        Day { lags_s: [300.0, 0.0], ..none.clone() },
        Day { lags_s: [2700.0, 0.0], body: 0, ..none.clone() },
        Day { lags_s: [600.0, 600.0], ..none.clone() },
        Day { column: 0.8, lags_s: [600.0, 0.0], body: 0, ..none.clone() },
        Day { um_per_k: 0.0, walk_um: 0.5, ..none.clone() },
        Day { um_per_k: 1.0, noise_um: 3.0, lags_s: [300.0, 0.0], ..none },
    ];
    for (number, day) in kinds.iter().enumerate() {
        for seed in 1..=8 {
            let found = day.log(100 * number as u64 + seed).faults();
            assert!(found.iter().all(|one| one.kind.word() != "clock"), "{number} {seed}: {:?}", said(&found));
        }
    }
}

#[test]
fn the_drift_has_its_size_once_the_log_is_shifted() {
    let day = Day { ahead_s: 1800.0, ..Day::default() };
    let shop = Shop::new().file("m.toml", MACHINE).file("t.csv", day.log(3).table()).file("t.toml", DESCRIPTION);
    let found: Value = shop.run(["diagnose", "t.csv", "--machine", "m.toml", "--json"]).exits(0).json();
    let fault = found["data_faults"].as_array().unwrap().iter().find(|one| one["kind"] == "clock").unwrap();
    assert_eq!([&fault["what"], &fault["excluded"]], ["clock offset", "the rows outside the shifted log"]);
    let first = &found["findings"][0];
    let number = |key: &str| first[key].as_f64().unwrap();
    assert_eq!([&first["effect"], &first["sensor"]], ["thermal-drift", "T_head_C"], "{first:#}");
    assert!((number("value") - 5.0).abs() < number("u95").max(0.1), "{first:#}");
}

#[test]
fn a_sensor_that_holds_a_value_is_named_beside_a_display_that_flickers() {
    // 180 of 1000 rows; displays of 0.1 K with noise of 0.3 to 0.5 of a step, so that neighbors are equal more often than not.
    let mut wrong = Vec::new();
    for seed in 1..=12_u64 {
        let day = Day { rows: 1000, display_k: 0.1, noise_k: [0.05, 0.03][seed as usize % 2], ..Day::default() };
        let sensor = seed as usize % 4;
        let found = day.log(seed).hold(sensor, [400, 579]).faults();
        let own: Vec<&DataDefect> = found.iter().filter(|one| one.what == "stuck").collect();
        let is_named = own.len() == 1
            && own[0].name == BODIES[sensor].0
            && own[0].rows[0].abs_diff(400) <= 30
            && own[0].rows[1].abs_diff(579) <= 30;
        // Nothing else: rows that are left out leave a gap, and a drift goes on over it.
        if !is_named || found.len() > 1 {
            wrong.push(format!("{seed} {sensor}: {:?}", said(&found)));
        }
    }
    assert!(wrong.len() <= 1, "{wrong:#?}");
}

#[test]
fn coarse_displays_on_slow_days_are_not_stuck() {
    for seed in 1..=8 {
        for (display_k, noise_k) in [(0.1, 0.01), (0.1, 0.03), (0.1, 0.05), (0.5, 0.01), (0.5, 0.05), (0.5, 0.15)] {
            let day = Day { rows: 1000, display_k, noise_k, um_per_k: 0.4, ..Day::default() };
            let mut log = day.log(200 + seed);
            if seed % 2 == 0 {
                // A sixth of the rise: most displays show two or three values in the whole day.
                let slow = |value: &mut f64| *value = ((20.3 + (*value - 20.3) / 6.0) / display_k).round() * display_k;
                log.sensors.iter_mut().flatten().for_each(slow);
            }
            let found = log.faults();
            assert!(found.is_empty(), "{seed} {display_k} {noise_k}: {:?}", said(&found));
        }
    }
}

#[test]
fn an_angle_seen_by_lines_at_two_heights_is_named_as_one() {
    // Pitch of X about Y, 30 µrad over the travel as a parabola without a mean; a line at each height, with a zero of its own.
    let mut random = Random::new(5, "heights");
    let mut table = |run_seed: u64| {
        let mut table = "setup,run,component,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,value_um\n".to_owned();
        for run in 0..3 {
            for (setup, z) in [("low", -300.0), ("high", 0.0)] {
                for k in 0..24 {
                    let x = 25.0 * f64::from(k) + f64::from(7 * k % 5);
                    let pitch = 30e-6 * ((x / 300.0 - 1.0).powi(2) - 1.0 / 3.0);
                    // The tip is 120 mm below the spindle: its height is the arm.
                    let um = 1e3 * pitch * (z - 120.0) + 0.3 * random.normal();
                    let _ = writeln!(table, "{setup},r{run_seed}{run},EXX,{x},200,{z},1,1,1,-120,{um:.4}");
                }
            }
        }
        table
    };
    let description = "[measurement]\nkind = \"direct\"\nsigma_um = 0.3\nfree = [\"offset\"]\n";
    let shop = Shop::new().file("m.toml", MACHINE).file("t.csv", table(1)).file("t.toml", description);
    let shop = shop.file("h.csv", table(2)).file("h.toml", description);
    let call = ["diagnose", "t.csv", "--machine", "m.toml", "--holdout", "h.csv", "--json"];
    let found: Value = shop.run(call).exits(0).json();
    let named: Vec<[&Value; 2]> =
        found["findings"].as_array().unwrap().iter().map(|one| [&one["effect"], &one["parameter"]]).collect();
    assert_eq!(named, [["motion", "EBX"]], "{:#}", found["findings"]);
    let (value, u95) = (&found["findings"][0]["value"], &found["findings"][0]["u95"]);
    // From 2/3 at the ends to −1/3 in the middle.
    assert!((value.as_f64().unwrap() - 30.0).abs() < u95.as_f64().unwrap().max(1.0), "{value} ± {u95}");
}
