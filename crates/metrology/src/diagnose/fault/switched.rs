//! Drivers that are switched: a shift that follows a driver is an effect of the machine, not a fault of the data.

use super::step::ChangePoint;
use super::trail::{ReadingTrail, Trail};
use crate::measure::data::{DataColumn, DataSet};

/// Largest distance in rows between a change and that of a driver.
const NEAR: usize = 2;
/// Smallest change of a switched driver, as a share of its range,
const SWITCH: f64 = 0.1;
/// unless it is constant for this number of rows on each side: then any change is a switch.
const AROUND: usize = 8;
/// Smallest share of the jump at other switches of the driver; also the largest remaining share between rows with equal values of the driver.
const WITH: f64 = 0.5;

/// All drivers except temperatures.
fn switches(data: &DataSet) -> impl Iterator<Item = &DataColumn> {
    data.drivers.iter().filter(|driver| !driver.name.starts_with("T_"))
}

fn value(driver: &DataColumn, row: usize) -> f64 {
    driver.values.get(row).copied().unwrap_or(f64::NAN)
}

/// True if a driver has one value in exactly these rows, and another before and after them.
pub(super) fn is_on_in(data: &DataSet, [first, last]: [usize; 2]) -> bool {
    switches(data).any(|driver| {
        let middle = value(driver, usize::midpoint(first, last));
        let is_same = |row: usize| value(driver, row) == middle;
        let before = first.checked_sub(NEAR).is_some_and(|row| value(driver, row).is_finite() && !is_same(row));
        let behind = value(driver, last + NEAR).is_finite() && !is_same(last + NEAR);
        before && behind && (first + NEAR..=last.saturating_sub(NEAR)).all(is_same)
    })
}

/// True if a driver changes at a step as well and the readings follow it elsewhere too.
pub(super) fn is_driven(trail: &Trail, change: &ChangePoint, data: &DataSet) -> bool {
    switches(data).any(|driver| goes_with(trail, change, driver))
}

fn goes_with(trail: &Trail, change: &ChangePoint, driver: &DataColumn) -> bool {
    let value = |row: usize| value(driver, row);
    let [before, behind] = [value(change.row.saturating_sub(NEAR)), value(change.row + NEAR)];
    if !(before != behind && before.is_finite() && behind.is_finite()) {
        return false;
    }
    // A driver that hardly changes causes no step, unless it is switched in exactly this row.
    let said = || driver.values.iter().copied().filter(|value| value.is_finite());
    let range = said().fold(f64::MIN, f64::max) - said().fold(f64::MAX, f64::min);
    let [from, until] = [change.row.saturating_sub(AROUND).max(change.block[0]), change.row + AROUND];
    let is_at_rest = (from..change.row).all(|row| value(row) == before)
        && (change.row..=until.min(change.block[1])).all(|row| value(row) == behind);
    let is_small = (behind - before).abs() < SWITCH * range;
    if is_small && !is_at_rest {
        return false;
    }
    let alike = if is_small { (behind - before).abs() / 2.0 } else { SWITCH * range };
    let is_like = |row: usize, of: f64| (value(row) - of).abs() < alike;
    // Elsewhere, beyond the sides of the change, the same switch causes a similar jump.
    let (mut own, mut other) = (0.0, 0.0);
    for channel in &trail.channels {
        let at = channel.range(change.row, change.row).start;
        let near = at.saturating_sub(change.side)..at + change.side;
        // Before and after separately, so that the shift after the change does not count for the driver.
        let piece = channel.range(change.block[0], change.block[1]);
        let mean = |side: std::ops::Range<usize>, of: f64| {
            let far = side.filter(|k| !near.contains(k) && channel.left[*k].is_finite());
            let all: Vec<f64> = far.filter(|&k| is_like(channel.at[k].0, of)).map(|k| channel.left[k]).collect();
            (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
        };
        let makes = |side: std::ops::Range<usize>| Some(mean(side.clone(), behind)? - mean(side, before)?);
        let sides: Vec<f64> = [piece.start..at, at..piece.end].into_iter().filter_map(makes).collect();
        let jump = jump(channel, change);
        own += jump * jump;
        // If the driver changes only here, it may be the cause; a small change hardly causes as much.
        let unknown = if is_small { 0.0 } else { jump };
        let usual = sides.iter().sum::<f64>() / sides.len().max(1) as f64;
        other += jump * if sides.is_empty() { unknown } else { usual };
    }
    other > WITH * own || is_at_rest && is_gone_at_levels(trail, change, driver, SWITCH * range)
}

/// Mean after a change minus the mean before it.
fn jump(channel: &ReadingTrail, change: &ChangePoint) -> f64 {
    let at = channel.range(change.row, change.row).start;
    let mean = |from: usize, to: usize| channel.mean(from, to).map_or(0.0, |one| one.0);
    mean(at, at + change.side) - mean(at.saturating_sub(change.side), at)
}

/// True if little remains of a step between rows after and before it with equal values of the driver; the median over the levels after the step
/// counts.
fn is_gone_at_levels(trail: &Trail, change: &ChangePoint, driver: &DataColumn, alike: f64) -> bool {
    let levels = |rows: std::ops::Range<usize>| {
        let mut levels: Vec<f64> = rows.map(|row| value(driver, row)).filter(|level| level.is_finite()).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        levels
    };
    let (earlier, levels) = (levels(change.block[0]..change.row), levels(change.row..change.block[1] + 1));
    // A driver that keeps changing has no levels.
    if levels.len() * AROUND > change.block[1] - change.row {
        return false;
    }
    let left = levels.into_iter().filter_map(|level| {
        let (mut own, mut with) = (0.0, 0.0);
        // Compared with the nearest level before it.
        let nearest = earlier.iter().map(|other| (other - level).abs()).fold(alike, f64::min);
        for channel in &trail.channels {
            let piece = channel.range(change.block[0], change.block[1]);
            let at = channel.range(change.row, change.row).start;
            let mean = |side: std::ops::Range<usize>, within: f64| {
                let is_like = |k: &usize| (value(driver, channel.at[*k].0) - level).abs() <= within;
                let all: Vec<f64> =
                    side.filter(is_like).map(|k| channel.left[k]).filter(|left| left.is_finite()).collect();
                (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
            };
            let (before, behind) = (mean(piece.start..at, nearest), mean(at..piece.end, 0.0));
            let (Some(before), Some(behind)) = (before, behind) else { continue };
            let jump = jump(channel, change);
            own += jump * jump;
            with += jump * (behind - before);
        }
        (own > 0.0).then_some(with / own)
    });
    let left: Vec<f64> = left.collect();
    !left.is_empty() && super::median(left) < WITH
}
