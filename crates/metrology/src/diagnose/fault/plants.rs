//! Tests with logs of a machine that warms up, into which typical faults are written: the sensors that stay in use, and in which rows.
//!
//! Bodies follow a spindle with first-order lags, solved exactly from row to row. The logs are written without code of the checks.

use super::{DataDefect, DefectKind, MissingTemperatures, Then, find, mend_sensors};
use crate::diagnose::bench;
use crate::measure::data::DataSet;

/// Uniform numbers from −1 to 1 (xorshift).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Columns of temperatures, °C; `None` for an empty cell.
type Columns = Vec<(&'static str, Vec<Option<f64>>)>;

/// A body that follows a drive with a time constant, K.
fn follower(rows: usize, interval_s: f64, tau_s: f64, drive: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut at = 0.0;
    let share = 1.0 - (-interval_s / tau_s).exp();
    let step = |row: usize| {
        at += (drive(row) - at) * share;
        at
    };
    (0..rows).map(step).collect()
}

/// True while the spindle runs: during two periods of four, of 50 min each.
fn runs(row: usize, interval_s: f64) -> bool {
    let piece = (row as f64 * interval_s / 3000.0) as usize;
    [1, 2].contains(&(piece % 4))
}

/// Nose, head, column and bed of a machine in a shop at 20 °C. Noise is uniform within ±0.05 K.
fn shop(rows: usize, interval_s: f64) -> Columns {
    let mut noise = Uniform(0x2545_f491_4f6c_dd1d);
    let bodies =
        [("T_nose_C", 300.0, 8.0), ("T_head_C", 2700.0, 5.0), ("T_column_C", 7200.0, 3.0), ("T_bed_C", 15000.0, 1.5)];
    let column = |(name, tau_s, rise_k): (&'static str, f64, f64)| {
        let own = follower(rows, interval_s, tau_s, |row| if runs(row, interval_s) { rise_k } else { 0.0 });
        (name, own.into_iter().map(|rise| Some(20.0 + rise + 0.05 * noise.next())).collect())
    };
    bodies.map(column).into()
}

fn column<'a>(columns: &'a mut Columns, name: &str) -> &'a mut Vec<Option<f64>> {
    &mut columns.iter_mut().find(|(own, _)| *own == name).unwrap().1
}

/// Sets a constant value from one row to another.
fn hold(column: &mut [Option<f64>], [first, last]: [usize; 2], value: Option<f64>) {
    column[first..=last].fill(value);
}

/// A table of readings at one pose with noise of 1 µm, temperatures with four digits, and a driver.
fn table(columns: &Columns, interval_s: f64, driver: Option<&dyn Fn(usize) -> f64>) -> DataSet {
    let mut noise = Uniform(0x9e37_79b9_7f4a_7c15);
    let mut text = "t_s,X,Y,Z,dx_um".to_owned();
    columns.iter().for_each(|(name, _)| text += &format!(",{name}"));
    text += if driver.is_some() { ",spindle_rpm\n" } else { "\n" };
    for row in 0..columns[0].1.len() {
        text += &format!("{:.3},100,0,0,{:.4}", interval_s * row as f64, 1.7 * noise.next());
        for (_, values) in columns {
            text += &values[row].map_or(",".to_owned(), |value| format!(",{value:.4}"));
        }
        driver.iter().for_each(|driver| text += &format!(",{}", driver(row)));
        text += "\n";
    }
    bench::table(
        &bench::machine(),
        &text,
        "[measurement]\nkind = \"displacement\"\nsigma_um = 1\nfree = [\"offset\"]\n",
    )
}

/// Faults of sensors.
fn faults(set: DataSet) -> Vec<DataDefect> {
    let machine = bench::machine();
    let sets = [set];
    let scene = bench::scene(&machine, &sets);
    find(&scene).into_iter().filter(|one| one.kind == DefectKind::Sensor).collect()
}

fn faults_of(columns: &Columns, interval_s: f64) -> Vec<DataDefect> {
    faults(table(columns, interval_s, None))
}

/// Name, description and rows of each fault.
fn words(found: &[DataDefect]) -> Vec<(&str, &str, [usize; 2])> {
    found.iter().map(|one| (one.name.as_str(), one.what.as_str(), one.rows)).collect()
}

fn missing(one: &DataDefect) -> &MissingTemperatures {
    match &one.then {
        Then::WithoutTemperatures(missing) => missing,
        then => panic!("{then:?}: {}", one.evidence),
    }
}

/// Columns that are given up or converted.
fn given_up(found: &[DataDefect]) -> Vec<String> {
    let of = |one: &DataDefect| match &one.then {
        Then::WithoutSensors(names) => names.clone(),
        Then::InFahrenheit(name) => vec![name.clone()],
        _ => Vec::new(),
    };
    found.iter().flat_map(of).collect()
}

#[test]
fn a_machine_that_warms_up_has_no_fault_at_any_interval() {
    for (rows, interval_s) in [(3000, 0.1), (1500, 10.0), (800, 60.0), (200, 300.0)] {
        let found = faults_of(&shop(rows, interval_s), interval_s);
        assert!(found.is_empty(), "{interval_s}: {:?}", words(&found));
    }
}

#[test]
fn a_log_that_ends_before_the_readings_is_one_defect_of_these_rows() {
    for (rows, interval_s, held) in [(800, 60.0, [760, 799]), (6000, 0.1, [3500, 5999])] {
        let mut columns = shop(rows, interval_s);
        for (_, values) in &mut columns {
            let last = values[held[0]];
            hold(values, held, last);
        }
        let found = faults_of(&columns, interval_s);
        assert_eq!(words(&found), [("temperatures", "log ends", held)]);
        assert_eq!((missing(&found[0]).sensors.len(), &missing(&found[0]).uncounted), (4, &vec![held]));
        assert!(found[0].evidence.starts_with(&format!("temperatures end at t = {} s", interval_s * held[0] as f64)));
    }
}

#[test]
fn the_readings_of_a_log_that_ended_are_taken_out() {
    let mut columns = shop(800, 60.0);
    columns.iter_mut().for_each(|(_, values)| hold(values, [760, 799], Some(25.0)));
    let mut sets = [table(&columns, 60.0, None)];
    let found = faults(sets[0].clone());
    mend_sensors(&mut sets, &found);
    let nose = &sets[0].drivers[0];
    assert_eq!(nose.values.iter().filter(|value| value.is_nan()).count(), 40);
    let last = sets[0].conditions.last().unwrap();
    let points = last.trace("T_nose").unwrap().points();
    assert_eq!((points.len(), points[759].0), (760, 45_540.0));
}

#[test]
fn loggers_that_pause_or_begin_late_or_are_two_are_one_defect_each() {
    let mut columns = shop(800, 60.0);
    for (_, values) in &mut columns {
        let [begin, pause] = [values[30], values[400]];
        hold(values, [0, 30], begin);
        hold(values, [400, 459], pause);
    }
    // The second logger has two of the sensors and ends earlier.
    for name in ["T_column_C", "T_bed_C"] {
        let values = column(&mut columns, name);
        let last = values[700];
        hold(values, [700, 799], last);
    }
    let found = faults_of(&columns, 60.0);
    let mut all = words(&found);
    all.sort_by_key(|one| one.2);
    let expected = [
        ("temperatures", "log begins late", [0, 30]),
        ("temperatures", "log pauses", [400, 459]),
        ("T_bed_C T_column_C", "log ends", [700, 799]),
    ];
    let sorted = |name: &str| {
        let mut names: Vec<&str> = name.split(' ').collect();
        names.sort_unstable();
        names.join(" ")
    };
    let all: Vec<(String, &str, [usize; 2])> =
        all.into_iter().map(|(name, what, rows)| (sorted(name), what, rows)).collect();
    assert_eq!(all, expected.map(|(name, what, rows)| (name.to_owned(), what, rows)));
    found.iter().for_each(|one| assert!(!missing(one).uncounted.is_empty()));
}

#[test]
fn one_sensor_that_holds_or_says_nothing_is_missing_only_there() {
    let mut columns = shop(800, 60.0);
    let head = column(&mut columns, "T_head_C");
    let stays = head[300];
    hold(head, [300, 419], stays);
    hold(column(&mut columns, "T_bed_C"), [0, 79], None);
    hold(column(&mut columns, "T_column_C"), [100, 101], None);
    let found = faults_of(&columns, 60.0);
    assert_eq!(words(&found), [("T_bed_C", "no readings", [0, 79]), ("T_head_C", "stuck", [300, 419])]);
    assert_eq!(missing(&found[1]).sensors, ["T_head_C"]);
    // A cell in every tenth row is a table with occasional temperatures.
    let mut columns = shop(800, 60.0);
    (0..800).filter(|row| row % 10 > 0).for_each(|row| column(&mut columns, "T_bed_C")[row] = None);
    assert_eq!(words(&faults_of(&columns, 60.0)), []);
}

#[test]
fn a_dead_sensor_that_recovers_is_missing_where_it_is_dead() {
    let mut columns = shop(800, 60.0);
    hold(column(&mut columns, "T_head_C"), [200, 349], Some(0.0));
    // Two rows are bridged by their neighbors.
    for rows in [[500, 501], [520, 521]] {
        hold(column(&mut columns, "T_nose_C"), rows, Some(0.0));
    }
    let found = faults_of(&columns, 60.0);
    let dead: Vec<_> = words(&found).into_iter().filter(|one| one.1 == "dead").collect();
    assert_eq!(
        dead,
        [("T_nose_C", "dead", [500, 501]), ("T_nose_C", "dead", [520, 521]), ("T_head_C", "dead", [200, 349])]
    );
    assert_eq!(found.len(), dead.len(), "{:?}", words(&found));
    let uncounted: Vec<_> = found.iter().map(|one| missing(one).uncounted.clone()).collect();
    assert_eq!(uncounted, [vec![], vec![], vec![[200, 349]]]);
    // A loose contact is one fault.
    let mut columns = shop(800, 60.0);
    (0..20).for_each(|k| hold(column(&mut columns, "T_nose_C"), [100 + 20 * k, 101 + 20 * k], Some(0.0)));
    let found = faults_of(&columns, 60.0);
    assert_eq!(words(&found), [("T_nose_C", "dead", [100, 481])]);
    assert_eq!(missing(&found[0]).pieces.len(), 20);
    // A sensor that is dead in most rows is given up.
    hold(column(&mut columns, "T_nose_C"), [300, 799], Some(0.0));
    assert_eq!(given_up(&faults_of(&columns, 60.0)), ["T_nose_C"]);
}

#[test]
fn a_display_at_night_and_a_chiller_are_not_stuck() {
    // Three hours of work, and a night of eight hours in which the temperatures of bed and column hardly change.
    let night = |rows: usize| {
        let mut noise = Uniform(77);
        let bodies = [("T_nose_C", 300.0, 8.0), ("T_column_C", 5400.0, 3.0), ("T_bed_C", 12000.0, 1.5)];
        let column = |(name, tau_s, rise_k): (&'static str, f64, f64)| {
            let own = follower(rows, 60.0, tau_s, |row| if row < 180 { rise_k } else { 0.0 });
            let shown = |value: f64| (10.0 * value).round() / 10.0;
            (name, own.into_iter().map(|rise| Some(shown(20.0 + rise + 0.02 * noise.next()))).collect())
        };
        Columns::from(bodies.map(column))
    };
    let mut columns = night(660);
    columns.push(("T_chiller_C", vec![Some(20.0); 660]));
    // A room whose display alternates between two steps.
    columns.push(("T_room_C", (0..660).map(|row| Some(if row % 170 < 50 { 20.1 } else { 20.0 })).collect()));
    let found = faults_of(&columns, 60.0);
    assert!(found.is_empty(), "{:?}", found.iter().map(|one| &one.evidence).collect::<Vec<_>>());
}

/// Adds a heater at one sensor from a row on, with a time constant.
fn with_heater(columns: &mut Columns, name: &str, from: usize, by_k: f64, [interval_s, tau_s]: [f64; 2]) {
    let values = column(columns, name);
    let rise = follower(values.len(), interval_s, tau_s, |row| if row >= from { by_k } else { 0.0 });
    values.iter_mut().zip(rise).for_each(|(value, rise)| *value = value.map(|value| value + rise));
}

#[test]
fn something_that_is_switched_is_no_offset() {
    for interval_s in [10.0, 60.0, 300.0] {
        for tau_s in [20.0, 30.0, 60.0, 120.0, 600.0] {
            for by_k in [4.0, -6.0, 15.0] {
                let mut columns = shop(800, interval_s);
                with_heater(&mut columns, "T_bed_C", 333, by_k, [interval_s, tau_s]);
                let found = faults_of(&columns, interval_s);
                assert!(given_up(&found).is_empty(), "{interval_s} s, {tau_s} s, {by_k} K: {}", found[0].evidence);
            }
        }
    }
    // A sensor in a flow of coolant follows at once; the pump has a column.
    let mut columns = shop(800, 10.0);
    with_heater(&mut columns, "T_bed_C", 333, -4.0, [10.0, 1.0]);
    let pump = |row: usize| f64::from(u8::from(row >= 333));
    assert!(given_up(&faults(table(&columns, 10.0, Some(&pump)))).is_empty());
    // Without that column, the pump is switched off again.
    with_heater(&mut columns, "T_bed_C", 500, 4.0, [10.0, 1.0]);
    assert!(given_up(&faults_of(&columns, 10.0)).is_empty());
}

#[test]
fn a_sensor_that_came_off_is_given_up_where_rows_are_near_enough_in_time() {
    let at = |interval_s: f64| {
        let mut columns = shop(800, interval_s);
        column(&mut columns, "T_bed_C")[333..].iter_mut().for_each(|value| *value = value.map(|value| value + 4.0));
        faults_of(&columns, interval_s)
    };
    for interval_s in [1.0, 10.0, 60.0] {
        let found = at(interval_s);
        assert_eq!(words(&found), [("T_bed_C", "offset", [333, 799])]);
        assert_eq!(given_up(&found), ["T_bed_C"], "{interval_s}: {}", found[0].evidence);
    }
    // Within five minutes many heaters have settled.
    let found = at(300.0);
    assert_eq!((words(&found), &found[0].then), (vec![("T_bed_C", "offset", [333, 799])], &Then::Nothing));
}

#[test]
fn a_heater_is_not_in_fahrenheit() {
    // Two-point control about 68 °C; 68 °F are 20 °C.
    let mut columns = shop(800, 60.0);
    let regulated = (0..800).map(|row| Some(68.0 + 0.8 * (row as f64 / 3.0).sin())).collect();
    columns.push(("T_heater_C", regulated));
    let found = faults_of(&columns, 60.0);
    assert!(given_up(&found).is_empty(), "{:?}", words(&found));
    assert!(found.iter().all(|one| one.then == Then::Nothing));
    // A nozzle that is heated to 100 °C within minutes.
    let mut columns = shop(800, 60.0);
    let nozzle = follower(800, 60.0, 200.0, |row| if row > 40 { 45.0 } else { 0.0 });
    columns.push(("T_nozzle_C", nozzle.iter().map(|rise| Some(55.0 + rise)).collect()));
    assert!(given_up(&faults_of(&columns, 60.0)).is_empty());
    // A column in °F is converted.
    let mut columns = shop(800, 60.0);
    column(&mut columns, "T_column_C").iter_mut().for_each(|value| *value = value.map(|value| 1.8 * value + 32.0));
    let found = faults_of(&columns, 60.0);
    assert_eq!(words(&found), [("T_column_C", "degrees Fahrenheit", [0, 799])]);
    assert_eq!(given_up(&found), ["T_column_C"]);
}
