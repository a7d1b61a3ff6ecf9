//! Residuals of readings relative to their repetitions, if some rows may be shifted.
//!
//! If many visits of a position are in a pulse or after a step, their median is itself shifted. So a shift is compared with the visits outside it,
//! and its size is determined together with the medians.

use std::collections::HashMap;

use super::trail::{ReadingTrail, Trail};
use super::{median, spread};

/// Limit of an outlier, in standard deviations.
const FAR: f64 = 6.0;
/// Upper limit of a reading, in units of the noise.
const MOST: f64 = 6.0;
/// Number of iterations in which a shift and the medians converge.
const ROUNDS: usize = 4;

impl Trail {
    /// The trail with readings relative to the visits outside some rows.
    pub(super) fn around(&self, rows: [usize; 2]) -> Trail {
        let mut trail = self.clone();
        for channel in &mut trail.channels {
            channel.left = channel.beside_visits(Some(rows));
            channel.sum_up();
        }
        trail
    }

    /// The trail without the shift of the rows from one on in its block.
    pub(super) fn levelled(&self, rows: [usize; 2]) -> Trail {
        let mut trail = self.clone();
        for channel in &mut trail.channels {
            let left = channel.beside_visits(Some(rows));
            let range = channel.range(rows[0], rows[1]);
            let own: Vec<f64> = left.get(range.clone()).unwrap_or_default().to_vec();
            let shift = median(own.into_iter().filter(|left| left.is_finite()).collect());
            channel.left = left;
            channel.value.get_mut(range.clone()).into_iter().flatten().for_each(|value| *value -= shift);
            channel.left.get_mut(range).into_iter().flatten().for_each(|left| *left -= shift);
            channel.sum_up();
        }
        trail
    }

    /// Decrease of the sum of squares, in squares of the noise, if all readings of some rows are shifted.
    pub(super) fn window_gain(&self, rows: [usize; 2]) -> f64 {
        let of_channel = |channel: &ReadingTrail| {
            let (centred, _) = channel.centred(0..channel.left.len());
            let mut of_group = vec![[0.0_f64; 2]; channel.groups];
            let range = channel.range(rows[0], rows[1]);
            let mut sum = 0.0;
            for k in (0..channel.left.len()).filter(|&k| channel.left[k].is_finite()) {
                let Some([all, inside]) = of_group.get_mut(channel.group[k]) else { continue };
                *all += 1.0;
                if range.contains(&k) {
                    *inside += 1.0;
                    sum += centred[k];
                }
            }
            let squares: f64 =
                of_group.iter().filter(|[all, _]| *all > 0.0).map(|[all, inside]| inside - inside * inside / all).sum();
            if squares > 1.0 { sum * sum / squares / channel.noise.powi(2) } else { 0.0 }
        };
        self.channels.iter().map(of_channel).sum()
    }

    /// Decrease of the sum of squares, in squares of the noise, if all readings of a block from a row on are shifted: by row.
    pub(super) fn step_gains(&self, block: [usize; 2]) -> Vec<f64> {
        let mut gains = vec![0.0; (block[1] + 1).saturating_sub(block[0])];
        for channel in &self.channels {
            let range = channel.range(block[0], block[1]);
            let (centred, visits) = channel.centred(range.clone());
            let mut of_group: HashMap<usize, f64> = HashMap::new();
            let known = |k: usize| channel.left[k].is_finite() && channel.group[k] < channel.groups;
            // Backwards from the end of the block, to accumulate the rows after each row.
            let (mut sum, mut squares) = (0.0, 0.0_f64);
            let mut next = range.end;
            for (place, gain) in gains.iter_mut().enumerate().rev() {
                let row = block[0] + place;
                while next > range.start && channel.at[next - 1].0 >= row {
                    next -= 1;
                    if !known(next) {
                        continue;
                    }
                    let group = channel.group[next];
                    let behind = of_group.entry(group).or_insert(0.0);
                    squares += 1.0 - (2.0 * *behind + 1.0) / visits.get(&group).map_or(1.0, |visits| visits[1]);
                    *behind += 1.0;
                    sum += centred[next - range.start];
                }
                if squares > 1.0 {
                    *gain += sum * sum / squares / (channel.noise * channel.noise);
                }
            }
        }
        gains
    }
}

impl ReadingTrail {
    /// Readings relative to the mean of their visits, and sums and numbers of these visits; outliers are limited.
    fn centred(&self, range: std::ops::Range<usize>) -> (Vec<f64>, HashMap<usize, [f64; 2]>) {
        let limit = MOST * self.noise;
        let own = |k: usize| {
            let left = self.left.get(k).filter(|left| left.is_finite() && self.group[k] < self.groups)?;
            Some(left.clamp(-limit, limit))
        };
        let mut sums: HashMap<usize, [f64; 2]> = HashMap::new();
        for k in range.clone() {
            if let Some(left) = own(k) {
                let sum = sums.entry(self.group[k]).or_insert([0.0; 2]);
                *sum = [sum[0] + left, sum[1] + 1.0];
            }
        }
        let mean = |k: usize| sums.get(&self.group[k]).map_or(0.0, |[sum, count]| sum / count);
        let centred = range.map(|k| own(k).map_or(0.0, |left| left - mean(k))).collect();
        (centred, sums)
    }

    /// Residuals relative to the medians of visits. The shift of the rows of a window stays in them and does not affect the medians. Rows in the
    /// window without a visit outside are NaN.
    pub(super) fn beside_visits(&self, window: Option<[usize; 2]>) -> Vec<f64> {
        let count = self.value.len();
        let range = window.map_or(0..0, |[first, last]| self.range(first, last));
        let is_inside = |k: usize| range.contains(&k);
        let known: Vec<usize> =
            (0..count).filter(|&k| self.value[k].is_finite() && self.group[k] < self.groups).collect();
        let mut visits = vec![[0.0_f64; 2]; self.groups];
        known.iter().for_each(|&k| visits[self.group[k]][usize::from(is_inside(k))] += 1.0);
        let share = |k: usize| {
            let [outside, inside] = visits[self.group[k]];
            inside / (inside + outside)
        };
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); self.groups];
        known.iter().for_each(|&k| members[self.group[k]].push(k));
        let mut amount = 0.0;
        let mut left = vec![f64::NAN; count];
        for _ in 0..if range.is_empty() { 1 } else { ROUNDS } {
            let own = |k: usize| self.value[k] - if is_inside(k) { amount } else { 0.0 };
            for group in &members {
                let middle = median(group.iter().map(|&k| own(k)).collect());
                group.iter().for_each(|&k| left[k] = own(k) - middle);
            }
            let column: Vec<f64> = known.iter().map(|&k| f64::from(u8::from(is_inside(k))) - share(k)).collect();
            if !self.senses().is_empty() {
                self.take_senses_out(&known, &column, &mut left);
            }
            if range.is_empty() {
                return left;
            }
            let limit = if self.noise > 0.0 { MOST * self.noise } else { f64::MAX };
            let (mut with, mut of) = (0.0, 0.0);
            for (&k, column) in known.iter().zip(&column) {
                with += column * left[k].clamp(-limit, limit);
                of += column * column;
            }
            if of > 0.0 {
                amount += with / of;
            }
        }
        for k in known {
            if is_inside(k) {
                left[k] = if share(k) < 1.0 { left[k] + amount } else { f64::NAN };
            }
        }
        left
    }

    /// Subtracts terms that depend on the directions of the axes; a shift of some rows is fitted too and kept.
    fn take_senses_out(&self, known: &[usize], shift: &[f64], left: &mut [f64]) {
        let own: Vec<f64> = known.iter().map(|&k| left[k]).collect();
        let senses = self.spanned(known);
        let shift = shift.iter().any(|shift| *shift != 0.0).then_some(shift);
        let mut rest = own.clone();
        for round in 0..2 {
            let limit = FAR * spread(rest.iter().copied());
            let counts: Vec<bool> = rest.iter().map(|rest| rest.abs() <= limit).collect();
            let (fitted, amount) = senses.fitted(&own, &counts, shift);
            let shifted = |k: usize| if round == 0 { shift.map_or(0.0, |shift| shift[k] * amount) } else { 0.0 };
            rest = (0..own.len()).map(|k| own[k] - fitted[k] - shifted(k)).collect();
        }
        known.iter().zip(rest).for_each(|(&k, rest)| left[k] = rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wild_reading_of_a_shifted_piece_counts_up_to_its_limit() {
        // Four visits with readings 0 and seven in a window with readings 1, except for one of 100, which is limited to 3 beyond the median with a
        // noise of 0.5.
        let mut channel = ReadingTrail::default();
        channel.at = (0..11).map(|row| (row, 0)).collect();
        channel.value = [0.0; 4].into_iter().chain([1.0; 6]).chain([100.0]).collect();
        (channel.group, channel.groups, channel.noise) = (vec![0; 11], 1, 0.5);
        let left = channel.beside_visits(Some([4, 10]));
        // The median of all is 1 at first: columns of −7/11 and 4/11 give (4 · 7/11 + 4/11 · 3) / (28/11) = 10/7 for the shift. Then the median is 1
        // − 10/7, the four are 3/7 above it, and 4 · 7/11 · 3/7 = 4/11 · 3: it has converged.
        for (k, left) in left.iter().enumerate().take(10) {
            let expected = if k < 4 { 3.0 / 7.0 } else { 10.0 / 7.0 };
            assert!((left - expected).abs() < 1e-12, "{k} {left}");
        }
    }
}
