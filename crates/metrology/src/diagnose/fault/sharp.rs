//! Sharpness of a shift: the jump between two readings, relative to the usual differences of the same readings. A drift or warming covers the same
//! range, but not at once.

use super::spread;
use super::trail::{ReadingTrail, Trail};

/// Sum of squares in units of the usual difference that is not a coincidence (probability 1e-7 or less over all rows), after each channel is reduced
/// by
pub(super) const CHANCE: f64 = 24.0;
/// this.
pub(super) const EACH: f64 = 4.0;
/// Number of readings at an end that show its sharpness.
pub(super) const END: usize = 4;
/// Numbers of readings on each side that are compared.
const SIDES: [usize; 4] = [2, 4, 8, 16];
/// Largest gap between readings of a channel, in its usual steps.
const GAP: usize = 8;
/// Smallest usual difference, as a share of that of white noise.
const LEAST: f64 = 0.8;

/// The jump at a row in squares of the usual difference, over all channels, less the expectation for more than one channel; with at most `most`
/// readings on each side. `None` if there are too few readings on a side.
pub(super) fn sharpness(trail: &Trail, row: usize, most: usize) -> Option<f64> {
    let block = trail.block_of(row)?;
    let of_side = |side: usize| {
        let (mut squares, mut count) = (0.0, 0.0);
        for channel in &trail.channels {
            if let Some(jump) = jump(channel, block, row, side) {
                squares += (jump / usual(channel, side).max(often(channel, side))).powi(2);
                count += 1.0;
            }
        }
        (count > 0.0).then_some(squares - (count - 1.0))
    };
    SIDES.into_iter().filter(|side| *side <= most.max(SIDES[0])).filter_map(of_side).reduce(f64::max)
}

/// Mean of some readings from a row on, minus the mean of an equal number before it.
fn jump(channel: &ReadingTrail, block: [usize; 2], row: usize, side: usize) -> Option<f64> {
    let piece = channel.range(block[0], block[1]);
    let at = channel.range(row, row).start;
    let [from, until] = [channel.before(at, side, piece.start), channel.beyond(at, side, piece.end)];
    let ((behind, many), (before, of_before)) = (channel.mean(at, until)?, channel.mean(from, at)?);
    // Between two parts of a channel other channels were read, and the drift continued.
    let far = GAP * channel.step.max(1);
    let goes_on = channel.at.get(from..until)?.windows(2).all(|pair| pair[1].0 - pair[0].0 <= far);
    (many == side && of_before == side && goes_on).then_some(behind - before)
}

fn jumps(channel: &ReadingTrail, side: usize) -> impl Iterator<Item = f64> {
    let at = (side..channel.at.len().saturating_sub(side)).step_by((side / 8).max(1));
    at.filter_map(move |k| Some(channel.mean(k, k + side)?.0 - channel.mean(k - side, k)?.0))
}

/// Warming makes larger differences in some parts: the standard deviation from the 90th percentile.
fn often(channel: &ReadingTrail, side: usize) -> f64 {
    tenth(jumps(channel, side).collect())
}

fn tenth(mut all: Vec<f64>) -> f64 {
    /// 90th percentile of the absolute values of normal noise, in standard deviations.
    const TENTH: f64 = 1.644_853_6;
    all.iter_mut().for_each(|jump| *jump = jump.abs());
    let place = all.len() * 9 / 10;
    if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(place, f64::total_cmp).1 / TENTH }
}

/// Usual size of jumps without a shift, at least that of the noise.
pub(super) fn usual_of(jumps: impl Iterator<Item = f64>, least: f64) -> f64 {
    let all: Vec<f64> = jumps.collect();
    spread(all.iter().copied()).max(tenth(all)).max(least)
}

/// Usual difference of neighboring parts without a shift.
pub(super) fn usual(channel: &ReadingTrail, side: usize) -> f64 {
    spread(jumps(channel, side)).max(LEAST * channel.noise * (2.0 / side as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_counts_in_what_is_usual_and_needs_readings_on_both_sides() {
        let mut channel = ReadingTrail::default();
        channel.at = (0..200).map(|row| (row, 0)).collect();
        channel.left = (0..200).map(|row| if row < 100 { 0.0 } else { 1.0 }).collect();
        (channel.noise, channel.step) = (0.1, 1);
        channel.sum_up();
        let mut trail = Trail::default();
        (trail.channels, trail.blocks, trail.rows) = (vec![channel], vec![[0, 199]], 200);
        // Means of two readings differ by the noise: 1 is 1/(0.8 · 0.1) times the smallest usual difference.
        let found = sharpness(&trail, 100, 2).unwrap();
        assert!((found - 156.25).abs() < 1e-9, "{found}");
        assert_eq!(sharpness(&trail, 50, 2), Some(0.0));
        assert_eq!([1, 199].map(|row| sharpness(&trail, row, 2)), [None; 2]);
    }
}
