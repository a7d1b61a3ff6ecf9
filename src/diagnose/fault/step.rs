//! A step: from one row on all readings are shifted and stay so, as after a crash or when an instrument was knocked.
//!
//! What warms up, cools down or is switched on and off is none: it does not begin within a reading, does not stay, or comes with a driver.

use super::trail::Trail;
use super::{Check, Fault, Then, View, spread};
use crate::measure::data::DataSet;

pub(super) const CHECK: Check = Check {
    name: "step in time",
    made_by: "a crash, a new reference point, an instrument that was knocked",
    shown_by: "all readings from a row on shifted, against earlier visits of the same places, and flat before and behind",
    source: "change point with a penalty by the memory of the noise",
    look,
};

/// Readings of a channel on each side, from the most.
const SIDES: [usize; 4] = [60, 40, 25, 12];
/// Readings of a channel on each side over which it is flat, at most.
const LONG: usize = 180;
/// Readings that show how sharp it is.
const END: usize = 3;
/// The end is so much of the whole.
const SHARP: f64 = 0.6;
/// Halves of a side differ by less than this of the step.
const FLAT: f64 = 0.35;
/// In units of the noise at least.
const SIZE: f64 = 1.5;

/// Rows from a change within which a driver goes with it.
const NEAR: usize = 6;

/// A change point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    /// The first row behind it.
    pub(super) row: usize,
    /// Its block.
    pub(super) block: [usize; 2],
    score: f64,
    /// In units of the noise.
    pub(super) size: f64,
    /// Readings of a channel on each side that show it.
    pub(super) side: usize,
}

fn look(view: &View<'_, '_>, out: &mut Vec<Fault>) {
    for (set, data) in view.sets() {
        let Some(trail) = view.trails.get(set).filter(|trail| trail.is_repeated) else { continue };
        let Some(change) = change(trail, data) else { continue };
        if super::first_cycle::is_early(trail, &change) {
            continue;
        }
        out.push(Fault {
            kind: "step",
            set,
            name: data.name.clone(),
            what: "step".into(),
            rows: [change.row, trail.rows.saturating_sub(1)],
            evidence: evidence(&change),
            then: Then::OwnZero,
        });
    }
}

/// In words.
pub(super) fn evidence(change: &Change) -> String {
    format!(
        "readings shift by {:.1} times their noise within a reading and stay: flat over {} readings on both sides, against earlier visits of the same places",
        change.size, change.side
    )
}

/// The change that stands out most, if it is a step.
pub(super) fn change(trail: &Trail, data: &DataSet) -> Option<Change> {
    // Where every visit comes from another side, a new side looks like a step.
    if !trail.has_sense {
        return None;
    }
    let mut changes: Vec<Change> = Vec::new();
    for side in SIDES {
        // As neighbouring pieces differ where nothing is.
        let usual: Vec<f64> = trail
            .channels
            .iter()
            .map(|channel| {
                let at = (side..channel.at.len().saturating_sub(side)).step_by((side / 8).max(1));
                let jump = |k: usize| Some(channel.mean(k, k + side)?.0 - channel.mean(k - side, k)?.0);
                spread(at.filter_map(jump)).max(0.8 * channel.noise * (2.0 / side as f64).sqrt())
            })
            .collect();
        for block in &trail.blocks {
            for row in block[0] + 1..=block[1] {
                let (mut score, mut size, mut count) = (0.0, 0.0, 0.0_f64);
                for (channel, usual) in trail.channels.iter().zip(&usual) {
                    let range = channel.range(block[0], block[1]);
                    let at = channel.range(row, row).start;
                    if at < range.start + side || at + side > range.end {
                        continue;
                    }
                    let (Some((behind, _)), Some((before, _))) =
                        (channel.mean(at, at + side), channel.mean(at - side, at))
                    else {
                        continue;
                    };
                    score += ((behind - before) / usual).powi(2) - 4.0;
                    size += ((behind - before) / channel.noise).powi(2);
                    count += 1.0;
                }
                if count > 0.0 && score > 24.0 {
                    changes.push(Change { row, block: *block, score, size: (size / count).sqrt(), side });
                }
            }
        }
    }
    changes.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.row.cmp(&b.row)));
    changes.truncate(200);
    changes.into_iter().find(|change| change.size > SIZE && is_step(trail, change) && !is_driven(trail, change, data))
}

fn is_step(trail: &Trail, change: &Change) -> bool {
    let (mut whole, mut end, mut slopes) = (0.0, 0.0, [0.0; 2]);
    for channel in &trail.channels {
        let at = channel.range(change.row, change.row).start;
        let range = channel.range(change.block[0], change.block[1]);
        if at < range.start + change.side || at + change.side > range.end {
            continue;
        }
        // As far as the piece goes: what decays or is switched off again is no step.
        let [before, behind] = [at - range.start, range.end - at].map(|side| side.min(LONG));
        let mean = |from: usize, to: usize| channel.mean(from, to).map_or(0.0, |(mean, _)| mean);
        let jump = mean(at, at + behind) - mean(at - before, at);
        let near = mean(at, at + change.side) - mean(at - change.side, at);
        let unit = |value: f64| near * value / (channel.noise * channel.noise);
        whole += unit(jump).min(unit(near));
        end += unit(mean(at, at + END) - mean(at - END, at));
        let [half, rest] = [before / 2, behind / 2];
        slopes[0] += unit(mean(at - half, at) - mean(at - before, at - half));
        slopes[1] += unit(mean(at + rest, at + behind) - mean(at, at + rest));
    }
    whole > 0.0 && end > SHARP * whole && slopes.iter().all(|slope| slope.abs() < FLAT * whole)
}

/// Whether a driver changes there as well and the readings follow it elsewhere too.
fn is_driven(trail: &Trail, change: &Change, data: &DataSet) -> bool {
    data.drivers.iter().filter(|driver| !driver.name.starts_with("T_")).any(|driver| {
        let value = |row: usize| driver.values.get(row).copied().unwrap_or(f64::NAN);
        let [before, behind] = [value(change.row.saturating_sub(NEAR)), value(change.row + NEAR)];
        if !(before != behind && before.is_finite() && behind.is_finite()) {
            return false;
        }
        let limit = (before + behind) / 2.0;
        // Elsewhere, beyond the sides of the change, the same switch makes as much.
        let (mut own, mut other) = (0.0, 0.0);
        for channel in &trail.channels {
            let at = channel.range(change.row, change.row).start;
            let near = at.saturating_sub(change.side)..at + change.side;
            let mean = |above: bool| {
                let values = channel.at.iter().zip(&channel.left).enumerate();
                let far = values
                    .filter(|(k, (at, left))| !near.contains(k) && left.is_finite() && (value(at.0) > limit) == above);
                let all: Vec<f64> = far.map(|(_, (_, left))| *left).collect();
                all.iter().sum::<f64>() / all.len().max(1) as f64
            };
            let jump = channel.mean(at, at + change.side).map_or(0.0, |one| one.0)
                - channel.mean(at.saturating_sub(change.side), at).map_or(0.0, |one| one.0);
            own += jump * jump;
            other += jump * (mean(behind > limit) - mean(before > limit));
        }
        other > 0.5 * own
    })
}
