//! Temperatures that are missing in some rows: the mildest consequence that does not assume their values.
//!
//! A short gap is bridged by the readings around it. The rows of a longer one are excluded from the search: a body may have warmed up and cooled down
//! during the gap, and causes can only be compared in rows with all temperatures. A sensor is given up only if too few rows would remain without its
//! gaps.

use std::collections::HashSet;

use super::{DataDefect, MissingTemperatures, Then, View};
use crate::measure::data::{DataSet, Observation};
use ncfix_machine::machine::condition::forget_readings;

/// Longest gap bridged by a straight line, s: the time constants of machine tools are minutes.
const BRIDGED_S: f64 = 180.0;
/// Longest gap that is bridged without times, in rows.
const BRIDGED_ROWS: usize = 3;
/// Largest share of rows that may be excluded for some missing sensors, while others are known there.
const SHARE_OF_SOME: f64 = 0.5;
/// Largest share of rows that may be excluded if no sensor is known there.
const SHARE_OF_ALL: f64 = 0.8;
/// Smallest share of excluded rows whose poses are also measured in other rows,
const ELSEWHERE: f64 = 0.8;
/// unless at most this share of all rows is excluded, which affects no cause.
const SMALL: f64 = 0.1;

/// Extent of missing readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// Some sensors, while others continue.
    Some,
    /// All sensors.
    All,
}

/// The consequence of missing readings of sensors in ranges of rows of a measurement. Rows excluded by earlier checks and by this one are included.
pub(super) fn consequence(
    view: &View<'_, '_>,
    set: usize,
    sensors: Vec<String>,
    pieces: Vec<[usize; 2]>,
    extent: Extent,
    found: &[DataDefect],
) -> Then {
    let Some(data) = view.scene.sets.get(set) else { return Then::WithoutSensors(sensors) };
    let uncounted: Vec<[usize; 2]> = pieces.iter().copied().filter(|piece| !is_bridged(data, *piece)).collect();
    let of_check = found.iter().filter(|one| one.set == set).filter_map(|one| match &one.then {
        Then::WithoutTemperatures(missing) => Some(&missing.uncounted),
        _ => None,
    });
    let before = view.gone.iter().filter(|(of, _)| *of == set).map(|(_, rows)| rows);
    let gone: Vec<[usize; 2]> = before.chain(of_check.flatten()).chain(&uncounted).copied().collect();
    let share = if extent == Extent::All { SHARE_OF_ALL } else { SHARE_OF_SOME };
    if uncounted.is_empty() || can_go(data, &gone, share) {
        Then::WithoutTemperatures(MissingTemperatures { sensors, pieces, uncounted })
    } else {
        Then::WithoutSensors(sensors)
    }
}

/// True if the readings around a gap determine it well enough.
fn is_bridged(data: &DataSet, [first, last]: [usize; 2]) -> bool {
    let end = data.observations.len().saturating_sub(1);
    let [from, to] = [first.saturating_sub(1), (last + 1).min(end)];
    match times(data, [from, to]) {
        Some([from_s, to_s]) => (0.0..=BRIDGED_S).contains(&(to_s - from_s)),
        None => last - first < BRIDGED_ROWS,
    }
}

/// Times of two rows, s.
pub(super) fn times(data: &DataSet, rows: [usize; 2]) -> Option<[f64; 2]> {
    let at = |row: usize| data.observations.get(row)?.t_s;
    Some([at(rows[0])?, at(rows[1])?])
}

/// True if rows can be excluded: few enough, and their poses are also measured elsewhere.
fn can_go(data: &DataSet, gone: &[[usize; 2]], share: f64) -> bool {
    let is_gone = |row: usize| gone.iter().any(|[first, last]| (*first..=*last).contains(&row));
    let rows: Vec<(bool, Vec<u64>)> =
        data.observations.iter().enumerate().map(|(row, one)| (is_gone(row), pose(one))).collect();
    let elsewhere: HashSet<&Vec<u64>> = rows.iter().filter(|(is_gone, _)| !is_gone).map(|(_, pose)| pose).collect();
    let count = rows.iter().filter(|(is_gone, _)| *is_gone).count() as f64;
    let again = rows.iter().filter(|(is_gone, pose)| *is_gone && elsewhere.contains(pose)).count() as f64;
    let all = rows.len() as f64;
    count <= SMALL * all || count <= share * all && again >= ELSEWHERE * count
}

/// The measured pose and quantity of a row, as bits.
fn pose(one: &Observation) -> Vec<u64> {
    let position = one.reading.position.0.iter().map(|at| at.to_bits());
    let tool = one.reading.tool_mm.iter().map(|at| at.to_bits());
    position.chain(tool).chain([one.target.map_or(u64::MAX, |target| target as u64)]).collect()
}

/// Removes missing readings from the columns and the conditions of a measurement.
pub(super) fn forget(set: &mut DataSet, missing: &MissingTemperatures) {
    let rows = || missing.pieces.iter().flat_map(|&[first, last]| first..=last);
    let of_row = |row: usize| set.observations.get(row).map(|one| (one.condition, one.t_s.unwrap_or(0.0)));
    let moments: Vec<(usize, f64)> = rows().filter_map(of_row).collect();
    for driver in set.drivers.iter_mut().filter(|driver| missing.sensors.contains(&driver.name)) {
        rows().for_each(|row| driver.values.get_mut(row).into_iter().for_each(|value| *value = f64::NAN));
        let sensor = driver.name.strip_suffix("_C").unwrap_or(&driver.name);
        forget_readings(&mut set.conditions, sensor, &moments);
    }
}
