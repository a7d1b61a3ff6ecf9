//! A sensor in degrees Fahrenheit in a column of degrees Celsius.

use super::cells::Sensor;
use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "degrees Fahrenheit",
    made_by: "a logger that is set to another unit",
    shown_by: "a sensor far above all others in all rows, and in their range after conversion to °C",
    source: "cross-sensor regression",
    look,
};

/// Converts °F to °C.
pub(super) fn celsius(fahrenheit: f64) -> f64 {
    (fahrenheit - 32.0) / 1.8
}

/// Smallest excess over every other sensor, at their median and at the coldest, K.
const ABOVE_K: f64 = 25.0;
/// Largest distance from the others after the conversion, K.
const NEAR_K: f64 = 8.0;
/// Converted readings begin within the range of the others, extended by this, K: a cold machine has the temperature of the shop.
const BEGIN_K: f64 = 4.0;
/// The first rows of a log are one part in this number of all rows,
const FIRST: usize = 30;
/// and at least this many.
const FIRST_ROWS: usize = 3;
/// Smallest correlation of converted readings with another sensor.
const TOGETHER: f64 = 0.7;
/// Number of rows from which a drift is not a coincidence.
const DRIFT_ROWS: usize = 8;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        let suspects: Vec<&Sensor> = sensors.iter().filter(|one| is_above(one, sensors)).collect();
        for sensor in suspects {
            let Some([low, high]) = sensor.range() else { continue };
            let others = || sensors.iter().filter(|one| one.name != sensor.name);
            let rest = super::median(others().filter_map(Sensor::range).map(|[low, _]| low).collect());
            let [from, to] = [low, high].map(celsius);
            let is_common = begins_with(sensor, sensors);
            let together = others().map(|other| correlation(sensor, other)).fold(0.0, f64::max);
            let is_sure = is_common && together > TOGETHER;
            let (what, evidence) = if is_sure {
                (
                    "degrees Fahrenheit",
                    format!(
                        "{low:.1} to {high:.1} cannot be °C: the coldest of the others is {rest:.1} °C; as °F they are {from:.1} to {to:.1} °C, begin as the others do and drift with them (correlation {together:.2})"
                    ),
                )
            } else {
                let why =
                    if is_common { "they do not drift with the others" } else { "they do not begin as the others do" };
                (
                    "hot, or degrees Fahrenheit",
                    format!(
                        "{low:.1} to {high:.1} °C is hot where the coldest of the others is {rest:.1} °C; as °F they would be {from:.1} to {to:.1} °C, but {why}: taken as °C"
                    ),
                )
            };
            out.push(DataDefect {
                kind: DefectKind::Sensor,
                set,
                name: sensor.name.clone(),
                what: what.into(),
                rows: [0, sensor.values.len().saturating_sub(1)],
                evidence,
                then: if is_sure { Then::InFahrenheit(sensor.name.clone()) } else { Then::Nothing },
            });
        }
    }
}

/// True if converted readings begin where the others begin.
fn begins_with(sensor: &Sensor, sensors: &[Sensor]) -> bool {
    let first = |sensor: &Sensor| {
        let count = (sensor.said().count() / FIRST).max(FIRST_ROWS);
        super::median(sensor.said().take(count).collect())
    };
    let others = || sensors.iter().filter(|one| one.name != sensor.name && one.range().is_some()).map(first);
    // A log of an already warm machine begins at several temperatures.
    let range = others().fold(f64::MAX, f64::min) - BEGIN_K..=others().fold(f64::MIN, f64::max) + BEGIN_K;
    range.contains(&celsius(first(sensor)))
}

/// Correlation of two sensors; 0 for few rows, or if one is constant.
fn correlation(one: &Sensor, other: &Sensor) -> f64 {
    let both = one.values.iter().zip(&other.values).map(|(a, b)| [*a, *b]);
    let both: Vec<[f64; 2]> = both.filter(|[a, b]| a.is_finite() && b.is_finite()).collect();
    if both.len() < DRIFT_ROWS {
        return 0.0;
    }
    let mean = [0, 1].map(|k| both.iter().map(|pair| pair[k]).sum::<f64>() / both.len() as f64);
    let sum = |i: usize, j: usize| both.iter().map(|pair| (pair[i] - mean[i]) * (pair[j] - mean[j])).sum::<f64>();
    let squares = sum(0, 0) * sum(1, 1);
    if squares > 0.0 { sum(0, 1) / squares.sqrt() } else { 0.0 }
}

fn is_above(sensor: &Sensor, sensors: &[Sensor]) -> bool {
    let Some([low, _]) = sensor.range() else { return false };
    let others = sensors.iter().filter(|one| one.name != sensor.name);
    // If most sensors are in °F, the few others are not at fault.
    let lows: Vec<f64> = others.filter_map(Sensor::range).map(|[low, _]| low).collect();
    let rest = super::median(lows.clone());
    !lows.is_empty() && low - rest > ABOVE_K && (celsius(low) - rest).abs() < NEAR_K
}
