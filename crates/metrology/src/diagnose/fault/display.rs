//! Equal numbers of a display with few digits: evidence that a sensor is stuck although its neighbors are often equal.
//!
//! Two observations need no jump at the end of the range. A display with noise flickers between two steps, wherever its temperature is. If it flickers in
//! every other part of the log, a range without a single flicker has a probability that its usual rate gives. The second one is a regression on the other
//! sensors and drivers, with lags. The regression predicts each other part of the log from the rest, so its usual error is known. Within the range the error
//! is compared with these.

use super::cells::{Sensor, TableClock};
use super::regression::{ColumnProducts, residuals};
use crate::measure::data::DataSet;

/// −ln of the probability of a range without flicker: 6 · 10⁻⁶, for about 10⁴ rows of a log at which one may begin.
const CHANCE: f64 = 12.0;
/// Rows within which a display that flickers returns. A regulated temperature takes longer.
const RETURN_ROWS: usize = 3;
/// Minimum number of rows of a part in which flicker is counted: as few rows show its rate only roughly.
const FEWEST_ROWS: usize = 24;
/// Minimum number of parts that flicker, and of parts that are predicted.
const PARTS: [usize; 2] = [4, 3];
/// Smallest share of the usual flicker of another sensor within the range: noise that has ended for all is no evidence.
const STILL_FLICKERS: f64 = 0.5;
/// Smallest ratio of the error of the regression within the range to its largest error elsewhere.
const ERROR: f64 = 3.0;
/// Part of a range over which errors are averaged: noise and display steps nearly vanish in it, motions of a body do not.
const AVERAGED: usize = 8;
/// Time constants of the regression, s: bodies of a machine tool from a spindle nose to a column.
const LAGS_S: [f64; 3] = [300.0, 1800.0, 7200.0];
/// Maximum number of sensors and drivers in the regression.
const OTHERS: usize = 8;
/// Smallest share of rows in which another sensor has a reading.
const KNOWN: f64 = 0.9;

/// True if a display does not flicker in a range of rows, although it does in all others, and other sensors flicker in the range too.
pub(super) fn stops_flickering(sensor: &Sensor, sensors: &[Sensor], [first, last]: [usize; 2]) -> bool {
    let count = last + 1 - first;
    let own = flickers(&sensor.values);
    let share = |rows: &[bool]| rows.iter().filter(|&&is| is).count() as f64 / rows.len().max(1) as f64;
    let size = (count / 2).max(FEWEST_ROWS);
    let sides = [own.get(..first), own.get(last + 1..)].into_iter().flatten();
    let rates: Vec<f64> = sides.flat_map(|side| side.chunks_exact(size)).map(share).collect();
    let Some(least) = rates.iter().copied().reduce(f64::min).filter(|_| rates.len() >= PARTS[0]) else { return false };
    // Noise that ends with the machine ends for all displays.
    let still_flickers = |other: &Sensor| {
        let rows = flickers(&other.values);
        let usual = share(&rows);
        usual > 0.0 && rows.get(first..=last).is_some_and(|inside| share(inside) > STILL_FLICKERS * usual)
    };
    (count - 1) as f64 * -(1.0 - least).ln() > CHANCE
        && sensors.iter().any(|other| other.name != sensor.name && still_flickers(other))
}

/// True in each row in which a reading returns from a short excursion.
fn flickers(values: &[f64]) -> Vec<bool> {
    let mut out = vec![false; values.len()];
    let mut before: Option<(usize, f64)> = None;
    for (row, two) in values.windows(2).enumerate() {
        let change = two[1] - two[0];
        if change.is_nan() {
            before = None;
        } else if change != 0.0 {
            out[row + 1] = before.is_some_and(|(at, other)| change * other < 0.0 && row - at <= RETURN_ROWS);
            before = Some((row, change));
        }
    }
    out
}

/// True if the other sensors and the drivers predict another course of a sensor in a range of rows, by more than a step of its display.
pub(super) fn leaves_the_others(
    data: &DataSet,
    sensor: &Sensor,
    sensors: &[Sensor],
    [first, last]: [usize; 2],
    step_k: f64,
) -> bool {
    let count = last + 1 - first;
    let rows = sensor.values.len();
    let columns = columns(data, sensor, sensors);
    if columns.len() < 2 || count < FEWEST_ROWS {
        return false;
    }
    let all = ColumnProducts::new(&columns, &sensor.values, (0..rows).filter(|row| !(first..=last).contains(row)));
    let parts =
        |from: usize, to: usize| (0..(to - from) / count).map(move |k| [from + k * count, from + (k + 1) * count - 1]);
    let mut usual = Vec::new();
    for [from, to] in parts(0, first).chain(parts(last + 1, rows)) {
        let own = ColumnProducts::new(&columns, &sensor.values, from..=to);
        usual.extend(error(&all.without(&own), &columns, &sensor.values, [from, to]));
    }
    let own = error(&all, &columns, &sensor.values, [first, last]);
    let most = usual.iter().copied().fold(0.0, f64::max);
    usual.len() >= PARTS[1] && own.is_some_and(|own| own > step_k && own > ERROR * most)
}

/// The columns of a regression: a constant, other sensors and drivers, each without and with lags. Their means are removed.
fn columns(data: &DataSet, sensor: &Sensor, sensors: &[Sensor]) -> Vec<Vec<f64>> {
    let rows = sensor.values.len();
    let is_known = |values: &&[f64]| {
        values.len() == rows && values.iter().filter(|value| value.is_finite()).count() as f64 >= KNOWN * rows as f64
    };
    let others = sensors.iter().filter(|other| other.name != sensor.name).map(|other| other.values.as_slice());
    let drivers = data.drivers.iter().filter(|driver| !driver.name.starts_with("T_"));
    let others: Vec<&[f64]> = others.chain(drivers.map(|driver| driver.values.as_slice())).filter(is_known).collect();
    let clock = TableClock::new(data);
    let has_times = data.observations.iter().all(|one| one.t_s.is_some());
    let lags = LAGS_S.iter().copied().filter(|_| has_times);
    let mut out = vec![vec![1.0; rows]];
    for values in others.into_iter().take(OTHERS) {
        for lag_s in std::iter::once(0.0).chain(lags.clone()) {
            let mut column = followed(values, lag_s, &clock);
            let mean = column.iter().sum::<f64>() / rows.max(1) as f64;
            column.iter_mut().for_each(|value| *value -= mean);
            if column.iter().any(|value| *value != 0.0) {
                out.push(column);
            }
        }
    }
    out
}

/// Values followed with a time constant, s; a gap keeps the previous value.
fn followed(values: &[f64], lag_s: f64, clock: &TableClock) -> Vec<f64> {
    let mut known = values.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
    let mut at = known;
    let follow = |(row, value): (usize, &f64)| {
        known = if value.is_finite() { *value } else { known };
        let step_s = row.checked_sub(1).map_or(0.0, |last| clock.between(last, row).max(0.0));
        at = if lag_s > 0.0 { at + (known - at) * (1.0 - (-step_s / lag_s).exp()) } else { known };
        at
    };
    values.iter().enumerate().map(follow).collect()
}

/// Largest averaged error of a prediction in a range of rows; `None` without a prediction or without readings.
fn error(from: &ColumnProducts, columns: &[Vec<f64>], values: &[f64], [first, last]: [usize; 2]) -> Option<f64> {
    let left = residuals(columns, values, &from.amounts()?, first..last + 1);
    let size = (left.len() / AVERAGED).max(1);
    left.windows(size).map(|few| few.iter().sum::<f64>().abs() / size as f64).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_excursion_of_three_rows_is_a_flicker_and_a_longer_one_is_not() {
        // Up at row 1 and back at row 2; up at 4 and back at 7; up at 9 and back at 13.
        let values = [0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0];
        let rows: Vec<usize> =
            flickers(&values).iter().enumerate().filter(|(_, is)| **is).map(|(row, _)| row).collect();
        assert_eq!(rows, [2, 4, 7, 9]);
    }
}
