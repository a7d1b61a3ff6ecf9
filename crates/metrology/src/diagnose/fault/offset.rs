//! A temperature sensor whose reading is shifted by some kelvin from one row on: it came off and was fixed elsewhere, or its amplifier changed.
//!
//! A heater, spindle, coolant or door that is switched looks the same in a log with one row per minute. Three observations separate them: a thermal
//! change continues after the first row with its time constant; a switched device is switched back; and rows with long intervals hide any time
//! constant. A sensor is given up only for a jump that no thermal change causes. In doubt it stays in use, because held-out readings test the causes
//! that follow it.

use super::cells::{Sensor, TableClock};
use super::{DataDefect, DefectCheck, DefectKind, Then, View, median, spread};
use crate::measure::data::DataSet;
use ncfix_base::numeric::Series;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "offset of a sensor",
    made_by: "a sensor that came off, an amplifier or plug that was exchanged",
    shown_by: "a jump from one row to the next that is complete and permanent, while other sensors do not jump and nothing is switched",
    source: "cross-sensor regression; first-order response of a body to a heater",
    look,
};

/// Smallest jump, K.
const LEAST_K: f64 = 1.0;
/// Smallest ratio of the jump to the usual jumps.
const TIMES: f64 = 12.0;
/// Smallest ratio of the jump to the next largest one.
const LARGEST: f64 = 2.5;

/// Sensors on metal have time constants of 20 s or more (a Pt100 on a casting). After this interval, s, three such time constants have passed, and
/// the rest of a thermal change is not visible.
const MOST_S: f64 = 65.0;
/// Rows and seconds after a jump in which a thermal change continues: five minutes include the end of a time constant of one or two minutes.
const AFTER_ROWS: usize = 8;
const AFTER_S: f64 = 300.0;
/// Minimum number of rows on each side.
const FEWEST_ROWS: usize = 5;
/// Smallest share of its jump by which a thermal change continues. After an interval of 60 s a time constant of 20 s leaves exp(−3) = 5 %.
const GOES_ON: f64 = 0.05;
/// Share above which it certainly continues, so that there is no fault.
const GOES_ON_SURELY: f64 = 0.12;
/// Share of the continued change in the first half of the time; a straight line has one half.
const FIRST_HALF: f64 = 0.6;
/// Smallest continued change, in units of the noise of the sensor.
const NOISE: f64 = 4.0;
/// Largest difference of the level relative to the other sensors from the jump, as a share of it, early and late.
const STAYS: f64 = 0.4;
/// A driver is switched if it changes by this share of its range,
const SWITCHED: f64 = 0.1;
/// within this many rows.
const NEAR: usize = 1;

/// Origin of a jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum JumpOrigin {
    /// No thermal change explains it.
    Broken,
    /// A thermal change.
    Thermal,
    /// Undecided, for this reason.
    Unsure(&'static str),
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        let Some(data) = view.scene.sets.get(set) else { continue };
        let clock = TableClock::new(data);
        let jumps: Vec<Vec<f64>> = sensors
            .iter()
            .map(|sensor| {
                let values = &sensor.values;
                (0..values.len()).map(|row| clock.jump(values, values, row).unwrap_or(0.0)).collect()
            })
            .collect();
        for (number, (sensor, own)) in sensors.iter().zip(&jumps).enumerate() {
            let Some((row, jump)) = largest(own) else { continue };
            // At the beginning of a run the machine may be in another state, unless another sensor shows otherwise.
            let is_begin = row > 0 && run_of(data, row) != run_of(data, row - 1);
            if is_begin && sensors.len() == 1 {
                continue;
            }
            let usual = spread(own.iter().copied());
            let next = own
                .iter()
                .enumerate()
                .filter(|(other, _)| other.abs_diff(row) > 2)
                .fold(0.0_f64, |most, (_, jump)| most.max(jump.abs()));
            let together = jumps.iter().enumerate().filter(|(other, _)| *other != number);
            let with = together
                .flat_map(|(_, other)| other.get(row.saturating_sub(1)..(row + 2).min(other.len())).unwrap_or_default())
                .fold(0.0_f64, |most, jump| most.max(jump.abs()));
            if jump.abs() < LEAST_K || jump.abs() < TIMES * usual || jump.abs() < LARGEST * next.max(with) {
                continue;
            }
            let origin = origin(data, &clock, sensors, number, (row, jump));
            let evidence = format!(
                "it jumps permanently by {jump:+.1} K between two rows; its next largest jump is {next:.1} K, and no other sensor jumps by more than {with:.1} K there"
            );
            let (evidence, then) = match origin {
                JumpOrigin::Thermal => continue,
                JumpOrigin::Broken => (evidence, Then::WithoutSensors(vec![sensor.name.clone()])),
                JumpOrigin::Unsure(why) => (format!("{evidence}; {why}: it remains in use"), Then::Nothing),
            };
            out.push(DataDefect {
                kind: DefectKind::Sensor,
                set,
                name: sensor.name.clone(),
                what: "offset".into(),
                rows: [row, sensor.values.len().saturating_sub(1)],
                evidence,
                then,
            });
        }
    }
}

/// Determines the origin of a jump of a sensor at a row, K.
fn origin(
    data: &DataSet,
    clock: &TableClock,
    sensors: &[Sensor],
    number: usize,
    (row, jump): (usize, f64),
) -> JumpOrigin {
    let Some(sensor) = sensors.get(number) else { return JumpOrigin::Unsure("it is the only sensor") };
    let goes_on = goes_on(clock, sensor, row).map(|by| by.map(|by| by / jump));
    // A time constant acts mostly at first, while a drift that begins by chance continues evenly.
    if goes_on.is_some_and(|[half, whole]| whole > GOES_ON_SURELY && half > FIRST_HALF * whole) {
        return JumpOrigin::Thermal;
    }
    if data.observations.get(row).and_then(|one| one.t_s).is_none() {
        return JumpOrigin::Unsure("without t_s, a fast heater has the same effect");
    }
    if row.checked_sub(1).and_then(|last| clock.step(last, row)).is_none_or(|step_s| step_s > MOST_S) {
        return JumpOrigin::Unsure(
            "the rows are so far apart in time that a switched heat source would have the same effect",
        );
    }
    if goes_on.is_none_or(|[_, whole]| whole.abs() > GOES_ON) {
        return JumpOrigin::Unsure("its rates before and after the jump differ, as for a heated body");
    }
    if is_switched(data, row) {
        return JumpOrigin::Unsure("a driver is switched in that row");
    }
    let [early, late] = levels(sensors, number, row).map(|level| level / jump);
    if (early - 1.0).abs() > STAYS || (late - 1.0).abs() > STAYS {
        return JumpOrigin::Unsure("relative to the other sensors, it does not stay at its new level");
    }
    JumpOrigin::Broken
}

/// Continued change of a sensor after a jump at a row, K, beyond its change before it in an equal time: until half of the time, and in total. 0
/// within its noise; `None` if there are too few rows.
fn goes_on(clock: &TableClock, sensor: &Sensor, row: usize) -> Option<[f64; 2]> {
    let is_near = |from: usize, to: usize| {
        clock.goes_on(from, to) && clock.between(from, to) <= AFTER_S
            || to - from <= AFTER_ROWS && clock.goes_on(from, to)
    };
    let end = sensor.values.len();
    let after: Vec<usize> = (row..end).take_while(|&other| is_near(row, other)).collect();
    let before: Vec<usize> = (0..row).rev().take_while(|&other| is_near(other, row - 1)).collect();
    let known =
        |rows: &[usize]| -> Vec<usize> { rows.iter().copied().filter(|&k| sensor.values[k].is_finite()).collect() };
    let (after, before) = (known(&after), known(&before));
    if after.len() < FEWEST_ROWS || before.len() < FEWEST_ROWS {
        return None;
    }
    let value = |rows: &[usize]| median(rows.iter().map(|&k| sensor.values[k]).collect());
    let time = |rows: &[usize]| rows.iter().map(|&k| clock.between(0, k)).sum::<f64>() / rows.len() as f64;
    // A few rows at both ends of each side, but only one after the jump, where a thermal change is fastest.
    let few = (before.len() / 3).max(1);
    let (near, far) = before.split_at(few);
    let far = far.get(far.len().saturating_sub(few)..)?;
    let rate = (value(near) - value(far)) / (time(near) - time(far)).max(f64::MIN_POSITIVE);
    let first = after.get(..1)?;
    let by = |rows: &[usize]| value(rows) - value(first) - rate * (time(rows) - time(first));
    let middle = after.len() / 2;
    let half = by(after.get(middle.saturating_sub(few / 2)..(middle + few.div_ceil(2)).min(after.len()))?);
    let whole = by(after.get(after.len().saturating_sub(few)..)?);
    let noise = spread(sensor.values.windows(3).map(|three| (three[2] - 2.0 * three[1] + three[0]) / 6.0_f64.sqrt()));
    Some(if whole.abs() > NOISE * noise { [half, whole] } else { [0.0; 2] })
}

/// True if any driver except temperatures changes at a row.
fn is_switched(data: &DataSet, row: usize) -> bool {
    data.drivers.iter().filter(|driver| !driver.name.starts_with("T_")).any(|driver| {
        let known = || driver.values.iter().copied().filter(|value| value.is_finite());
        let range = known().fold(f64::MIN, f64::max) - known().fold(f64::MAX, f64::min);
        let near = driver.values.get(row.saturating_sub(NEAR + 1)..(row + NEAR + 1).min(driver.values.len()));
        near.unwrap_or_default().windows(2).any(|two| (two[1] - two[0]).abs() > SWITCHED * range)
    })
}

/// Levels of a sensor relative to the others after a row, K: in the first and in the second half of the following rows.
fn levels(sensors: &[Sensor], number: usize, row: usize) -> [f64; 2] {
    let Some(own) = sensors.get(number) else { return [0.0; 2] };
    let others = || sensors.iter().enumerate().filter(|(other, _)| *other != number).map(|(_, sensor)| sensor);
    let count = own.values.len();
    let is_known = |k: &usize| own.values[*k].is_finite() && others().all(|other| other.values[*k].is_finite());
    let rows: Vec<usize> = (0..count).filter(is_known).collect();
    let middle = usize::midpoint(row, count);
    let mut series = Series::new(&vec![0; rows.len()], &vec![1.0; rows.len()], 0.0);
    series.take(&vec![1.0; rows.len()]);
    for other in others() {
        series.take(&rows.iter().map(|&k| other.values[k]).collect::<Vec<f64>>());
    }
    series.set_values(&rows.iter().map(|&k| own.values[k]).collect::<Vec<f64>>());
    let column = |from: usize, to: usize| -> Vec<f64> {
        rows.iter().map(|k| f64::from(u8::from((from..to).contains(k)))).collect()
    };
    let (amounts, _) = series.amounts(&[column(row, middle), column(middle, count)]);
    [0, 1].map(|k| amounts.get(k).copied().unwrap_or(0.0))
}

fn run_of(data: &DataSet, row: usize) -> Option<usize> {
    data.observations.get(row).map(|one| one.run)
}

fn largest(jumps: &[f64]) -> Option<(usize, f64)> {
    jumps.iter().copied().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}
