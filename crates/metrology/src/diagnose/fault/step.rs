//! A step: from one row on all readings keep a shift, as after a crash or a knock at the instrument.
//!
//! Warming, cooling and switching are not steps: they do not begin within one reading, do not last, or coincide with a driver.

use super::cells::TableClock;
use super::sharp::{CHANCE, EACH, END, sharpness, usual};
use super::trail::{ReadingTrail, Trail};
use super::{DataDefect, DefectCheck, DefectKind, Then, View, drifting, switched};
use crate::measure::data::DataSet;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "step in time",
    made_by: "a crash, a new reference point, an instrument that was knocked",
    shown_by: "all readings from one row on are shifted relative to earlier visits of the same positions, and constant before and after it",
    source: "change point with a penalty for the autocorrelation of the noise",
    look,
};

/// Numbers of readings of a channel on each side, in descending order.
const SIDES: [usize; 4] = [60, 40, 25, 12];
/// Maximum number of readings of a channel on each side in the test for flatness.
const LONG: usize = 180;
/// Smallest share of the jump at the end in the whole shift.
const SHARP: f64 = 0.5;
/// Largest difference between the halves of a side, as a share of the step.
const FLAT: f64 = 0.35;
/// Smallest step, in units of the noise.
const SIZE: f64 = 1.8;

/// Largest distance in rows between a change and its sharpest row.
const NEAR: usize = 2;

/// Smallest decrease of the sum of squares, in squares of the noise.
const LEAST: f64 = 60.0;
/// Minimum number of readings of all channels on each side.
const READINGS: f64 = 25.0;
/// Maximum number of changes that are tested.
const TRIED: usize = 16;
/// Largest distance in rows between a candidate and the actual change.
const WITHIN: usize = 20;

/// Number of rows around a pause in which a step is not reported: the machine may be in another state.
const PAUSE: usize = 12;
/// Smallest advantage of a step that ends with its run.
const SHORTER: f64 = 1.25;

/// Smallest jump, in squares of the usual difference between readings.
const AT_ONCE: f64 = 18.0;

/// A change point.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChangePoint {
    /// The first row after it.
    pub(super) row: usize,
    /// Its block.
    pub(super) block: [usize; 2],
    /// The last shifted row.
    pub(super) until: usize,
    /// Decrease of the sum of squares, in squares of the noise.
    pub(super) gain: f64,
    /// RMS of the shift, in units of the noise.
    pub(super) size: f64,
    /// Number of readings of a channel on each side that show it.
    pub(super) side: usize,
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let Some(trail) = view.trails.get(set).filter(|trail| trail.is_repeated) else { continue };
        let sensors = view.sensors.get(set).map(Vec::as_slice).unwrap_or_default();
        let Some(change) = change(trail, data).or_else(|| drifting::change(trail, data, sensors)) else { continue };
        if super::first_cycle::is_early(trail, &change) {
            continue;
        }
        out.push(DataDefect {
            kind: DefectKind::Step,
            set,
            name: data.name.clone(),
            what: "step".into(),
            rows: [change.row, change.until],
            evidence: evidence(&change),
            then: Then::OwnZero,
        });
    }
}

/// The evidence as text.
pub(super) fn evidence(change: &ChangePoint) -> String {
    format!(
        "readings shift permanently by {:.1} times their noise from one reading to the next; relative to earlier visits of the same positions, they are constant over {} readings on both sides",
        change.size, change.side
    )
}

/// The most significant change that is a step.
pub(super) fn change(trail: &Trail, data: &DataSet) -> Option<ChangePoint> {
    // If every visit comes from another side, a new side looks like a step.
    if !trail.has_sense {
        return None;
    }
    let mut changes: Vec<(f64, usize, [usize; 2])> = Vec::new();
    for side in SIDES {
        // Usual difference of neighboring parts without a step.
        let usual: Vec<f64> = trail.channels.iter().map(|channel| usual(channel, side)).collect();
        for block in &trail.blocks {
            for row in block[0] + 1..=block[1] {
                let mut score = 0.0;
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
                    score += ((behind - before) / usual).powi(2) - EACH;
                }
                if score > CHANCE {
                    changes.push((score, row, *block));
                }
            }
        }
    }
    changes.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut rows: Vec<([usize; 2], usize)> = Vec::new();
    for &(_, changed, block) in &changes {
        if rows.len() >= TRIED {
            break;
        }
        if rows.iter().all(|(_, row)| row.abs_diff(changed) > WITHIN) {
            rows.push((block, changed));
        }
    }
    // If the medians of the visits are shifted themselves, neighboring parts may show nothing.
    let mut all: Vec<(f64, [usize; 2], Vec<f64>)> = trail
        .blocks
        .iter()
        .map(|block| {
            let gains = trail.step_gains(*block);
            (gains.iter().copied().fold(0.0, f64::max), *block, gains)
        })
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    all.truncate(TRIED);
    let mut found: Option<ChangePoint> = None;
    for (_, block, gains) in all {
        let most = |from: usize, until: usize| {
            (from.max(block[0] + 1)..=until.min(block[1]))
                .max_by(|a, b| gains[a - block[0]].total_cmp(&gains[b - block[0]]))
        };
        let near = rows.iter().filter(|(own, _)| *own == block);
        let near = near.filter_map(|(_, row)| most(row.saturating_sub(WITHIN), row + WITHIN));
        let mut tried: Vec<usize> = near.chain(most(block[0], block[1])).collect();
        tried.sort_unstable();
        tried.dedup();
        for row in tried {
            let gain = gains[row - block[0]];
            if gain < LEAST || found.as_ref().is_some_and(|best| best.gain >= gain) {
                continue;
            }
            if let Some((change, _)) = judged(trail, data, block, (row, gain), (AT_ONCE, usize::MAX, SHARP)) {
                found = Some(change);
            }
        }
    }
    found
}

/// A change at a row if it is a step: large, sudden, flat on both sides, not after a pause and not together with a driver. Also returns the readings
/// relative to the visits without the shift. The jump must exceed `at_once` squares of the usual difference, over at most `most` readings, and the
/// share `sharp` of the whole.
pub(super) fn judged(
    trail: &Trail,
    data: &DataSet,
    block: [usize; 2],
    (row, gain): (usize, f64),
    (at_once, most, sharp): (f64, usize, f64),
) -> Option<(ChangePoint, Trail)> {
    let clock = TableClock::new(data);
    let goes_on = clock.goes_on(row.saturating_sub(PAUSE), (row + PAUSE).min(block[1]));
    if gain < LEAST || !goes_on || follows_a_gap(trail, &clock, row) {
        return None;
    }
    // If the instrument is set to zero for every run, a step ends with its run.
    let mut ends = vec![block[1]];
    let run = |row: usize| data.observations.get(row).map(|one| one.run);
    ends.extend((row..block[1]).take_while(|&next| run(next + 1) == run(row)).last().map(|last| last + 1));
    ends.dedup();
    let all = ends.into_iter().map(|end| {
        let around = trail.around([row, end]);
        (explained(&around, [row, end]), end, around)
    });
    let (_, end, around) = all.reduce(|best, other| if other.0 > SHORTER * best.0 { other } else { best })?;
    let change = beside(&around, [block[0], end], row, gain)?;
    let change = ChangePoint { row: sharpest(&around, &change), ..change };
    let row = change.row;
    if follows_a_gap(trail, &clock, row) {
        return None;
    }
    let is_sharp = || sharpness(&around, row, most).is_some_and(|sharpness| sharpness > at_once);
    let is_one = change.size > SIZE
        && is_sharp()
        && is_step(&around, &change, sharp)
        && !switched::is_driven(&around, &change, data);
    let until = if end < block[1] { end } else { trail.rows.saturating_sub(1) };
    is_one.then_some((ChangePoint { until, ..change }, around))
}

/// True if the readings before a row are excluded for longer than a pause: a drift during the gap looks like a step.
fn follows_a_gap(trail: &Trail, clock: &TableClock, row: usize) -> bool {
    let is_known = |row: &usize| {
        trail.channels.iter().any(|channel| channel.range(*row, *row).any(|k| channel.left[k].is_finite()))
    };
    let before = (0..row).rev().find(is_known);
    before.is_some_and(|before| clock.step(before, row).is_none())
}

/// Squares explained by a shift of some rows, in squares of the noise; the readings are relative to the visits without the shift.
fn explained(around: &Trail, rows: [usize; 2]) -> f64 {
    let of = |channel: &ReadingTrail| {
        let range = channel.range(rows[0], rows[1]);
        let known = channel.left.iter().filter(|left| left.is_finite()).count() as f64;
        let (amount, inside) = channel.mean(range.start, range.end)?;
        let inside = inside as f64;
        Some((amount / channel.noise).powi(2) * inside * (1.0 - inside / known))
    };
    around.channels.iter().filter_map(of).sum()
}

/// The row near a step with the largest difference between the readings before and after it.
fn sharpest(around: &Trail, change: &ChangePoint) -> usize {
    let differs = |row: usize| -> f64 {
        let of = |channel: &ReadingTrail| {
            let (range, at) = (channel.range(change.block[0], change.block[1]), channel.range(row, row).start);
            let [from, until] =
                [channel.before(at, change.side, range.start), channel.beyond(at, change.side, range.end)];
            Some(((channel.mean(at, until)?.0 - channel.mean(from, at)?.0) / channel.noise).powi(2))
        };
        around.channels.iter().filter_map(of).sum()
    };
    let near = change.row.saturating_sub(NEAR).max(change.block[0] + 1)..=(change.row + NEAR).min(change.block[1]);
    near.max_by(|a, b| differs(*a).total_cmp(&differs(*b))).unwrap_or(change.row)
}

/// A change at a row, over the longest sides that fit into its block.
fn beside(trail: &Trail, block: [usize; 2], row: usize, gain: f64) -> Option<ChangePoint> {
    for side in SIDES {
        let (mut size, mut count) = (0.0, 0.0_f64);
        for channel in &trail.channels {
            let (range, at) = (channel.range(block[0], block[1]), channel.range(row, row).start);
            // Some rows may have no visit for comparison.
            let [from, until] = [channel.before(at, side, range.start), channel.beyond(at, side, range.end)];
            let (Some((behind, many)), Some((before, of_before))) = (channel.mean(at, until), channel.mean(from, at))
            else {
                continue;
            };
            if many < side || of_before < side {
                continue;
            }
            size += ((behind - before) / channel.noise).powi(2);
            count += 1.0;
        }
        if count > 0.0 && side as f64 * count >= READINGS {
            return Some(ChangePoint { row, block, until: block[1], gain, size: (size / count).sqrt(), side });
        }
    }
    None
}

fn is_step(trail: &Trail, change: &ChangePoint, sharp: f64) -> bool {
    let (mut whole, mut end, mut slopes) = (0.0, 0.0, [0.0; 2]);
    for channel in &trail.channels {
        let at = channel.range(change.row, change.row).start;
        let range = channel.range(change.block[0], change.block[1]);
        if at < range.start + change.side || at + change.side > range.end {
            continue;
        }
        // Over the whole block: a decaying or reversed shift is not a step.
        let [before, behind] = [at - range.start, range.end - at].map(|side| side.min(LONG));
        let mean = |from: usize, to: usize| channel.mean(from, to).map_or(0.0, |(mean, _)| mean);
        let jump = mean(at, at + behind) - mean(at - before, at);
        let near = mean(at, at + change.side) - mean(at - change.side, at);
        let unit = |value: f64| near * value / (channel.noise * channel.noise);
        whole += unit(jump).min(unit(near));
        end += unit(mean(at, channel.beyond(at, END, range.end)) - mean(channel.before(at, END, range.start), at));
        let [half, rest] = [before / 2, behind / 2];
        slopes[0] += unit(mean(at - half, at) - mean(at - before, at - half));
        slopes[1] += unit(mean(at + rest, at + behind) - mean(at, at + rest));
    }
    whole > 0.0 && end > sharp * whole && slopes.iter().all(|slope| slope.abs() < FLAT * whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_begins_where_readings_differ_most() {
        let mut channel = ReadingTrail::default();
        channel.at = (0..200).map(|row| (row, 0)).collect();
        channel.left = (0..200).map(|row| if row < 100 { -1.0 } else { 1.0 }).collect();
        (channel.noise, channel.step) = (0.1, 1);
        channel.sum_up();
        let mut trail = Trail::default();
        (trail.channels, trail.blocks, trail.rows) = (vec![channel], vec![[0, 199]], 200);
        let found = |row: usize| {
            sharpest(&trail, &ChangePoint { row, block: [0, 199], until: 199, gain: 100.0, size: 20.0, side: 12 })
        };
        assert_eq!([98, 99, 100, 101, 102].map(found), [100; 5]);
    }
}
