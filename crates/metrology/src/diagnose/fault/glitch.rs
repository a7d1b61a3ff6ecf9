//! False temperatures: a few readings of a sensor far from those before and after, which agree with each other.
//!
//! No body of a machine warms up and cools down by many kelvin from one reading to the next. A sensor that restarts, or a bad contact, shows such readings; a
//! DS18B20 reads 85 °C after each start (its data sheet). A straight line bridges them, as a short gap.

use super::cells::Sensor;
use super::missing::{self, Extent};
use super::{DataDefect, DefectCheck, DefectKind, Then, View};
use crate::measure::data::DataSet;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "false temperatures",
    made_by: "a sensor that restarts (a DS18B20 then reads 85 °C), a bad contact, a disturbed line",
    shown_by: "a few readings of one sensor jump by many kelvin and come back",
    source: "data sheet of the DS18B20: 85 °C after each start",
    look,
};

/// Largest number of consecutive false readings.
const MOST: usize = 3;
/// Smallest number of readings of a sensor.
const FEWEST: usize = 20;
/// Largest share of false readings: more of them are a quantity that really jumps.
const SHARE: f64 = 0.05;
/// Smallest jump, K.
const JUMP_K: f64 = 5.0;
/// Smallest jump, in units of a large usual change from one reading to the next:
const TIMES: f64 = 8.0;
/// the change that this share of the others do not exceed.
const USUAL: f64 = 0.9;
/// Largest difference of the readings before and after, as a share of the jump.
const BACK: f64 = 0.2;

/// A reading of a sensor in consecutive rows with the same time.
struct Sample {
    rows: [usize; 2],
    value: f64,
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        let Some(data) = view.scene.sets.get(set) else { continue };
        for sensor in sensors {
            let found = false_readings(&samples(data, sensor));
            let (Some(first), Some(last)) = (found.first(), found.last()) else { continue };
            let count: usize = found.iter().map(|(piece, _)| piece[1] - piece[0] + 1).sum();
            let highest = found.iter().map(|(_, value)| *value).fold(f64::NEG_INFINITY, f64::max);
            let lowest = found.iter().map(|(_, value)| *value).fold(f64::INFINITY, f64::min);
            let values =
                if lowest < highest { format!("{lowest:.1} to {highest:.1} °C") } else { format!("{lowest:.1} °C") };
            let rows = [first.0[0], last.0[1]];
            let pieces: Vec<[usize; 2]> = found.into_iter().map(|(piece, _)| piece).collect();
            let then = missing::consequence(view, set, vec![sensor.name.clone()], pieces, Extent::Some, out);
            let s = if count == 1 { "" } else { "s" };
            let follows = match &then {
                Then::WithoutSensors(_) => "too little would remain without these rows",
                Then::WithoutTemperatures(missing) if missing.uncounted.is_empty() => {
                    "the readings around them replace them"
                }
                _ => "these rows have no temperature and do not count; the others do",
            };
            out.push(DataDefect {
                kind: DefectKind::Sensor,
                set,
                name: sensor.name.clone(),
                what: "false readings".into(),
                rows,
                evidence: format!(
                    "{count} reading{s} of {values} between readings that agree with each other; {follows}"
                ),
                then,
            });
        }
    }
}

fn samples(data: &DataSet, sensor: &Sensor) -> Vec<Sample> {
    let mut out: Vec<Sample> = Vec::new();
    let time = |row: usize| data.observations.get(row).and_then(|one| one.t_s);
    for (row, &value) in sensor.values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        let is_same = |last: &&mut Sample| {
            last.rows[1] + 1 == row && last.value == value && time(row).is_some() && time(row) == time(last.rows[1])
        };
        match out.last_mut().filter(is_same) {
            Some(last) => last.rows[1] = row,
            None => out.push(Sample { rows: [row, row], value }),
        }
    }
    out
}

/// Rows of false readings, with the reading that is farthest out.
fn false_readings(samples: &[Sample]) -> Vec<([usize; 2], f64)> {
    if samples.len() < FEWEST {
        return Vec::new();
    }
    let mut changes: Vec<f64> = samples.windows(2).map(|pair| (pair[1].value - pair[0].value).abs()).collect();
    changes.sort_by(f64::total_cmp);
    let usual = changes.get((USUAL * changes.len() as f64) as usize).copied().unwrap_or(0.0);
    let jump = JUMP_K.max(TIMES * usual);
    let mut found = Vec::new();
    let mut at = 0;
    let mut count = 0;
    while at < samples.len() {
        let lengths = 1..=MOST.min(samples.len() - at);
        let Some(length) = lengths.into_iter().find(|&length| is_false(samples, at, length, jump)) else {
            at += 1;
            continue;
        };
        let own = &samples[at..at + length];
        let before =
            at.checked_sub(1).or(Some(at + length)).and_then(|near| samples.get(near)).map_or(0.0, |near| near.value);
        let far = own.iter().map(|one| one.value).max_by(|a, b| (a - before).abs().total_cmp(&(b - before).abs()));
        found.push(([own[0].rows[0], own[length - 1].rows[1]], far.unwrap_or(before)));
        count += length;
        at += length;
    }
    if count as f64 <= SHARE * samples.len() as f64 { found } else { Vec::new() }
}

/// True if all of some samples are far from those before and after on one side, and these agree. At an end of the log one side suffices for one sample.
fn is_false(samples: &[Sample], at: usize, length: usize, jump: f64) -> bool {
    let before = at.checked_sub(1).and_then(|near| samples.get(near)).map(|one| one.value);
    let after = samples.get(at + length).map(|one| one.value);
    let own = || samples[at..at + length].iter().map(|one| one.value);
    let distances = |near: f64| own().map(|value| value - near).collect::<Vec<f64>>();
    let is_far =
        |distances: &[f64]| distances.iter().all(|own| *own > jump) || distances.iter().all(|own| *own < -jump);
    match (before, after) {
        (Some(before), Some(after)) => {
            let least = distances(before).iter().map(|own| own.abs()).fold(f64::INFINITY, f64::min);
            is_far(&distances(before)) && is_far(&distances(after)) && (after - before).abs() <= BACK * least
        }
        (Some(near), None) | (None, Some(near)) => length == 1 && is_far(&distances(near)),
        (None, None) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64]) -> Vec<([usize; 2], f64)> {
        let samples: Vec<Sample> =
            values.iter().enumerate().map(|(row, &value)| Sample { rows: [row, row], value }).collect();
        false_readings(&samples)
    }

    /// A slow warm-up by 6 K in 60 readings.
    fn warm_up() -> Vec<f64> {
        (0..60).map(|k| 21.0 + 0.1 * f64::from(k)).collect()
    }

    #[test]
    fn a_restart_of_a_sensor_is_false_and_a_heater_is_not() {
        let mut log = warm_up();
        assert_eq!(of(&log), []);
        log[0] = 85.0;
        log[30] = 85.0;
        log[31] = 85.0;
        assert_eq!(of(&log), [([0, 0], 85.0), ([30, 31], 85.0)]);
        // A heater that is switched on stays on.
        let mut heater = warm_up();
        heater[20..].iter_mut().for_each(|value| *value += 40.0);
        assert_eq!(of(&heater), []);
        // One that is regulated goes up and down again and again.
        let regulated: Vec<f64> = (0..60).map(|k| if k % 6 < 2 { 45.0 } else { 30.0 }).collect();
        assert_eq!(of(&regulated), []);
        // Four readings may be a short use of the coolant.
        let mut coolant = warm_up();
        coolant[30..34].fill(60.0);
        assert_eq!(of(&coolant), []);
    }
}
