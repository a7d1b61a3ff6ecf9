//! A step: from one row on all readings are shifted and stay so, as after a crash or when an instrument was knocked.
//!
//! What warms up, cools down or is switched on and off is none: it does not begin within a reading, does not stay, or comes with a driver.

use super::cells::TableClock;
use super::sharp::{CHANCE, EACH, END, sharpness, usual};
use super::trail::{ReadingTrail, Trail};
use super::{DataDefect, DefectCheck, DefectKind, Then, View, drifting, switched};
use crate::measure::data::DataSet;

pub(super) const CHECK: DefectCheck = DefectCheck {
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
/// The end is so much of the whole.
const SHARP: f64 = 0.5;
/// Halves of a side differ by less than this of the step.
const FLAT: f64 = 0.35;
/// In units of the noise at least.
const SIZE: f64 = 1.8;

/// Rows from a change within which it may begin.
const NEAR: usize = 2;

/// By how much the squares fall at least, in squares of the noise.
const LEAST: f64 = 60.0;
/// Readings of all channels on each side at least.
const READINGS: f64 = 25.0;
/// Changes that are looked at closely.
const TRIED: usize = 16;
/// Rows from a change within which it may really be.
const WITHIN: usize = 20;

/// Within so many rows of a pause a machine may have become another one.
const PAUSE: usize = 12;
/// A step that ends with its run explains so much more.
const SHORTER: f64 = 1.25;

/// The jump in squares of what is usual from one reading to the next.
const AT_ONCE: f64 = 18.0;

/// A change point.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChangePoint {
    /// The first row behind it.
    pub(super) row: usize,
    /// Its block.
    pub(super) block: [usize; 2],
    /// The last row that is shifted.
    pub(super) until: usize,
    /// By how much the squares fall, in squares of the noise.
    pub(super) gain: f64,
    /// In units of the noise.
    pub(super) size: f64,
    /// Readings of a channel on each side that show it.
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

/// In words.
pub(super) fn evidence(change: &ChangePoint) -> String {
    format!(
        "readings shift by {:.1} times their noise within a reading and stay: flat over {} readings on both sides, against earlier visits of the same places",
        change.size, change.side
    )
}

/// The change that stands out most, if it is a step.
pub(super) fn change(trail: &Trail, data: &DataSet) -> Option<ChangePoint> {
    // Where every visit comes from another side, a new side looks like a step.
    if !trail.has_sense {
        return None;
    }
    let mut changes: Vec<(f64, usize, [usize; 2])> = Vec::new();
    for side in SIDES {
        // As neighbouring pieces differ where nothing is.
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
    // Where the middles of visits are themselves shifted, nearby pieces may show nothing.
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

/// A change at a row if it is a step: large, at once, flat on both sides, not behind a pause and not with a driver; and readings beside those visits
/// that do not have it. `at_once` squares of what is usual jump over as many readings at most, and the end is this share of the whole.
pub(super) fn judged(
    trail: &Trail,
    data: &DataSet,
    block: [usize; 2],
    (row, gain): (usize, f64),
    (at_once, most, sharp): (f64, usize, f64),
) -> Option<(ChangePoint, Trail)> {
    let goes_on = TableClock::new(data).goes_on(row.saturating_sub(PAUSE), (row + PAUSE).min(block[1]));
    if gain < LEAST || !goes_on {
        return None;
    }
    // An instrument that is set to zero for every run has it only up to the end of one.
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
    let is_sharp = || sharpness(&around, row, most).is_some_and(|sharpness| sharpness > at_once);
    let is_one = change.size > SIZE
        && is_sharp()
        && is_step(&around, &change, sharp)
        && !switched::is_driven(&around, &change, data);
    let until = if end < block[1] { end } else { trail.rows.saturating_sub(1) };
    is_one.then_some((ChangePoint { until, ..change }, around))
}

/// The squares that a shift of some rows explains, in squares of the noise: readings are beside the visits that do not have it.
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

/// The row near a step before and behind which readings differ most.
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

/// A change at a row, over the longest sides that its piece has.
fn beside(trail: &Trail, block: [usize; 2], row: usize, gain: f64) -> Option<ChangePoint> {
    for side in SIDES {
        let (mut size, mut count) = (0.0, 0.0_f64);
        for channel in &trail.channels {
            let (range, at) = (channel.range(block[0], block[1]), channel.range(row, row).start);
            // Some rows may have no visit to be held against.
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
        // As far as the piece goes: what decays or is switched off again is no step.
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
