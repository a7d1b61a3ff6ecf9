//! A step during a drift: readings that drift slowly and far with temperatures, and jump between two readings.
//!
//! Sensors, heating drivers and time, each with several lags, are fitted together with the shift, so that the flatness is judged on the residual.
//! Candidates for such a step are rows where lines through the readings on both sides do not meet.

use super::cells::Sensor;
use super::fading;
use super::sharp::{EACH, usual_of};
use super::step::{self, ChangePoint};
use super::switched;
use super::trail::{ReadingTrail, Trail};
use crate::measure::data::DataSet;
use ncfix_base::numeric::in_parts;

/// Numbers of readings on each side for a line.
const SIDES: [usize; 3] = [8, 16, 32];
/// Smallest gap between the lines, in squares of the usual gap.
const MISS: f64 = 20.0;
/// Maximum number of rows that are tested.
const TRIED: usize = 4;
/// Largest distance in rows from a candidate to the actual step.
const WITHIN: usize = 6;
/// Smallest jump, in squares of the usual jump,
const AT_ONCE: f64 = 12.0;
/// over this number of readings on each side: warming within minutes covers most of its range over more readings.
const END: usize = 2;
/// Smallest share of the jump in the whole shift.
const SHARP: f64 = 0.7;
/// A shift that is reversed elsewhere by this share of it is switched.
const BACK: f64 = 0.5;
/// Number of readings on each side of a reversed shift.
const SIDE: usize = 8;
/// Time constants of the drift, s.
const LAGS_S: [f64; 3] = [600.0, 1800.0, 5400.0];
/// Maximum number of columns of a trend, and minimum number of readings for each.
const COLUMNS: usize = 32;
const READINGS: usize = 8;

/// The most significant step in addition to a drift.
pub(super) fn change(trail: &Trail, data: &DataSet, sensors: &[Sensor]) -> Option<ChangePoint> {
    if !trail.has_sense {
        return None;
    }
    let rows = breaks(trail);
    if rows.is_empty() {
        return None;
    }
    let trend = trend(data, sensors);
    let as_it_is = trail;
    let trail = trail.beside(&trend)?;
    let tried = in_parts(&rows, &|&row: &usize| {
        let block = trail.block_of(row)?;
        // Exact row: the one where a shift explains most.
        let near = row.saturating_sub(WITHIN).max(block[0] + 1)..=(row + WITHIN).min(block[1]);
        let gains = trail.around([row, block[1]]).step_gains(block);
        let row = near.max_by(|a, b| gains[a - block[0]].total_cmp(&gains[b - block[0]]))?;
        let gain = trail.around([row, block[1]]).window_gain([row, block[1]]);
        let (change, around) = step::judged(&trail, data, block, (row, gain), (AT_ONCE, END, SHARP))?;
        // A trend that follows a driver absorbs a part of a shift that is switched with it.
        let is_driven = || switched::is_driven(&as_it_is.around([change.row, change.until]), &change, data);
        (!goes_back(&around, row) && !fading::fades(&trail, data, &change) && !is_driven()).then_some(change)
    });
    tried.into_iter().flatten().max_by(|a, b| a.gain.total_cmp(&b.gain))
}

/// Rows with the largest gaps between lines on both sides.
fn breaks(trail: &Trail) -> Vec<usize> {
    let mut all: Vec<(f64, usize)> = Vec::new();
    for side in SIDES {
        let mut scores = vec![0.0; trail.rows];
        for channel in &trail.channels {
            let misses = misses(trail, channel, side);
            let usual =
                usual_of(misses.iter().map(|(_, miss)| *miss), 2.0 * channel.noise * (2.0 / side as f64).sqrt());
            for (row, miss) in misses {
                scores[row] += (miss / usual).powi(2) - EACH;
            }
        }
        all.extend(scores.into_iter().enumerate().filter(|(_, score)| *score > MISS).map(|(row, score)| (score, row)));
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut rows: Vec<usize> = Vec::new();
    for (_, row) in all {
        if rows.len() < TRIED && rows.iter().all(|known| known.abs_diff(row) > 2 * WITHIN) {
            rows.push(row);
        }
    }
    rows
}

/// Gap between lines through some readings on both sides, before each row.
fn misses(trail: &Trail, channel: &ReadingTrail, side: usize) -> Vec<(usize, f64)> {
    // Weights of a line through equally spaced readings, half a step beyond its end.
    let count = side as f64;
    let spread = count * (count * count - 1.0) / 12.0;
    let weights: Vec<f64> =
        (0..side).map(|k| 1.0 / count - count / 2.0 * (k as f64 + 0.5 - count / 2.0) / spread).collect();
    let mut out = Vec::new();
    for block in &trail.blocks {
        let known: Vec<usize> = channel.range(block[0], block[1]).filter(|&k| channel.left[k].is_finite()).collect();
        for at in side..(known.len() + 1).saturating_sub(side) {
            let line = |reading: &dyn Fn(usize) -> usize| -> f64 {
                weights.iter().enumerate().map(|(k, weight)| weight * channel.left[known[reading(k)]]).sum()
            };
            let miss = line(&|k| at + k) - line(&|k| at - 1 - k);
            out.push((channel.at[known[at]].0, miss));
        }
    }
    out
}

/// True if the readings jump back elsewhere.
fn goes_back(trail: &Trail, row: usize) -> bool {
    let jump = |channel: &ReadingTrail, at: usize| -> Option<f64> {
        let from = at.checked_sub(SIDE)?;
        let [(behind, _), (before, _)] = [channel.mean(at, at + SIDE)?, channel.mean(from, at)?];
        Some(behind - before)
    };
    let own: Vec<Option<f64>> =
        trail.channels.iter().map(|channel| jump(channel, channel.range(row, row).start)).collect();
    let size: f64 = trail
        .channels
        .iter()
        .zip(&own)
        .filter_map(|(channel, own)| Some((*own)? / channel.noise))
        .map(|own| own * own)
        .sum();
    let rows = (0..trail.rows).filter(|other| other.abs_diff(row) > SIDE && !trail.is_border(*other, SIDE));
    let most = rows.map(|other| {
        let of = |(channel, own): (&ReadingTrail, &Option<f64>)| {
            let there = jump(channel, channel.range(other, other).start)?;
            Some((*own)? * there / channel.noise.powi(2))
        };
        -trail.channels.iter().zip(&own).filter_map(of).sum::<f64>()
    });
    most.reduce(f64::max).is_some_and(|most| most > BACK * size)
}

/// Slow trends of the readings, by row: sensors and drivers since the beginning of their run, with lags, and time.
fn trend(data: &DataSet, sensors: &[Sensor]) -> Vec<Vec<f64>> {
    let rows = data.observations.len();
    let times: Option<Vec<f64>> = data.observations.iter().map(|one| one.t_s).collect();
    let begins = |row: usize| {
        let [one, before] = [Some(row), row.checked_sub(1)].map(|row| row.and_then(|row| data.observations.get(row)));
        let is_later = |times: &Vec<f64>| row > 0 && times[row] >= times[row - 1];
        before.is_none()
            || one.map(|one| (one.run, one.setup)) != before.map(|one| (one.run, one.setup))
            || !times.as_ref().is_none_or(is_later)
    };
    let followed = |values: &[f64], lag_s: f64, is_since: bool| -> Vec<f64> {
        let (mut at, mut zero, mut last) = (0.0, 0.0, 0.0);
        (0..rows)
            .map(|row| {
                // A gap keeps the previous value.
                let value = values.get(row).copied().filter(|value| value.is_finite()).unwrap_or(last);
                last = value;
                if begins(row) {
                    at = value;
                    zero = if is_since { value } else { 0.0 };
                } else if lag_s > 0.0 {
                    let step = times.as_ref().map_or(0.0, |times| times[row] - times[row - 1]);
                    at += (value - at) * (1.0 - (-step / lag_s).exp());
                } else {
                    at = value;
                }
                at - zero
            })
            .collect()
    };
    let lags = || LAGS_S.into_iter().filter(|_| times.is_some());
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for sensor in sensors.iter().filter(|sensor| sensor.said().next().is_some()) {
        columns.push(followed(&sensor.values, 0.0, true));
    }
    for sensor in sensors.iter().filter(|sensor| sensor.said().next().is_some()) {
        columns.extend(lags().map(|lag| followed(&sensor.values, lag, true)));
    }
    let others = data.drivers.iter().filter(|driver| !driver.name.starts_with("T_"));
    for driver in others {
        columns.extend(lags().map(|lag| followed(&driver.values, lag, true)));
    }
    columns.truncate(COLUMNS.saturating_sub(2));
    if let Some(times) = &times {
        let since = followed(times, 0.0, true);
        columns.push(since.iter().map(|time| time * time).collect());
        columns.push(since);
    }
    columns
}

impl Trail {
    /// Readings relative to their repetitions and to fitted columns by row; `None` if there are too few.
    fn beside(&self, columns: &[Vec<f64>]) -> Option<Trail> {
        let mut trail = self.clone();
        for channel in trail.channels.iter_mut().filter(|channel| !channel.at.is_empty()) {
            let known = channel.left.iter().filter(|left| left.is_finite()).count();
            if known < READINGS * columns.len() {
                return None;
            }
            let mut more = Vec::new();
            for column in columns {
                let mut own: Vec<f64> =
                    channel.at.iter().map(|(row, _)| column.get(*row).copied().unwrap_or(0.0)).collect();
                // Relative to the same repetitions.
                let mut means = vec![[0.0; 2]; channel.groups];
                let counts = |k: &usize| channel.left[*k].is_finite() && channel.group[*k] < channel.groups;
                for k in (0..own.len()).filter(counts) {
                    let mean = &mut means[channel.group[k]];
                    *mean = [mean[0] + own[k], mean[1] + 1.0];
                }
                for (own, group) in own.iter_mut().zip(&channel.group) {
                    *own -= means.get(*group).map_or(0.0, |[sum, count]| sum / f64::max(*count, 1.0));
                }
                let size = own.iter().map(|own| own.abs()).fold(0.0, f64::max);
                if size > 0.0 {
                    more.push(own.into_iter().map(|own| own / size).collect());
                }
            }
            channel.go_with(more);
            channel.left = channel.beside_visits(None);
            channel.sum_up();
        }
        Some(trail)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_rise_alike_break_where_one_jumps() {
        let trail = |jump: f64| {
            let mut channel = ReadingTrail::default();
            channel.at = (0..200).map(|row| (row, 0)).collect();
            let read = |row: i32| 0.01 * f64::from(row) + if row < 100 { 0.0 } else { jump };
            channel.left = (0..200).map(read).collect();
            (channel.noise, channel.step) = (0.1, 1);
            channel.sum_up();
            let mut trail = Trail::default();
            (trail.channels, trail.blocks, trail.rows) = (vec![channel], vec![[0, 199]], 200);
            trail
        };
        // Lines through eight readings with noise 0.1 have gaps of 2 · 0.1 · √(2/8) = 0.1, and 1 is ten times that; through 32 of 0.05, and 0.2 is
        // four times that.
        assert_eq!(breaks(&trail(1.0)).first(), Some(&100));
        assert_eq!([0.0, 0.2].map(|jump| breaks(&trail(jump)).len()), [0, 0]);
    }
}
