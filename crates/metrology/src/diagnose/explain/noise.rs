//! Autocorrelated noise: white noise and an Ornstein–Uhlenbeck process in every series of readings.
//!
//! A series contains the readings of one value (each direction of a displacement is one) in one set-up and run, in order. Set-ups that were read in turn share
//! one series: a drift of the machine is the same in all of them. The Kalman filter with one
//! state filters the process (Durbin and Koopman 2012, Time Series Analysis by State Space Methods, ch. 4). Innovations divided by their standard
//! deviations are white. The filter is linear, so it is applied to readings and columns alike, in a time proportional to the number of readings.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnose::scene::NO_ROW;
use crate::diagnose::scene::Scene;

/// Correlation length of a random walk, as a multiple of the longest series.
const WALK: f64 = 10.0;
/// Variances of the step of a random walk from one reading to the next, divided by that of the white noise.
const STEPS: [f64; 4] = [0.01, 0.1, 1.0, 10.0];

/// Variance and correlation length of the process, in addition to white noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Memory {
    /// Variance of the process divided by that of the white noise; 0 for white noise alone.
    pub ratio: f64,
    /// Time, s, or number of rows without times, after which the correlation has decreased to 1/e.
    pub length: f64,
}

/// Readings in series, with the steps between them.
#[derive(Clone, Debug)]
pub struct NoiseSeries {
    series: Vec<Vec<(usize, f64)>>,
    /// The series of each reading of the scene; `None` for a rejected one.
    number: Vec<Option<usize>>,
    /// True if steps are in seconds.
    pub has_clock: bool,
    /// Longest series, s or rows.
    pub longest: f64,
    /// Median step, s or rows.
    pub step: f64,
}

impl NoiseSeries {
    /// Sorts the used readings of a scene into series; `weights` are 1/σ of each reading, 0 for rejected ones.
    #[must_use]
    pub fn new(scene: &Scene<'_>, weights: &[f64]) -> NoiseSeries {
        let mut places: BTreeMap<(usize, usize, bool), Vec<usize>> = BTreeMap::new();
        for (place, (item, weight)) in scene.items.iter().zip(weights).enumerate() {
            if item.row != NO_ROW
                && *weight > 0.0
                && let Some(row) = scene.row_of(item)
            {
                places.entry((row.series, item.value, item.is_angle)).or_default().push(place);
            }
        }
        let has_clock = scene.rows.iter().all(|row| row.time_s.is_some());
        let time = |place: usize| scene.row_of(&scene.items[place]).and_then(|row| row.time_s).unwrap_or(0.0);
        let mut steps = Vec::new();
        let mut longest = 0.0_f64;
        let series: Vec<Vec<(usize, f64)>> = places
            .into_values()
            .map(|places| {
                let mut length = 0.0;
                let with_steps = places.iter().enumerate().map(|(k, &place)| {
                    let step = match k.checked_sub(1).map(|before| places[before]) {
                        None => f64::INFINITY,
                        Some(before) if has_clock => (time(place) - time(before)).max(0.0),
                        Some(_) => 1.0,
                    };
                    (place, step)
                });
                let series: Vec<(usize, f64)> = with_steps.collect();
                for (_, step) in series.iter().skip(1) {
                    length += step;
                    steps.push(*step);
                }
                longest = longest.max(length);
                series
            })
            .collect();
        steps.sort_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
        let mut number = vec![None; scene.items.len()];
        for (own, series) in series.iter().enumerate() {
            series.iter().for_each(|&(place, _)| number[place] = Some(own));
        }
        NoiseSeries { series, number, has_clock, longest, step }
    }

    /// Indices of the readings of each series, in order.
    pub fn series(&self) -> impl Iterator<Item = impl Iterator<Item = usize> + '_> {
        self.series.iter().map(|series| series.iter().map(|&(place, _)| place))
    }

    /// Whitens values that are divided by the standard deviations of the readings; returns half the logarithm of the determinant of the noise.
    pub fn whiten(&self, memory: Memory, values: &mut [f64]) -> f64 {
        self.whiten_some(memory, 0..self.series.len(), values)
    }

    /// Numbers of the series with some readings, in order.
    pub fn series_with(&self, places: impl Iterator<Item = usize>) -> BTreeSet<usize> {
        places.filter_map(|place| self.number.get(place).copied().flatten()).collect()
    }

    /// As [`NoiseSeries::whiten`], for some series: the values of the others are 0.
    pub fn whiten_some(&self, memory: Memory, numbers: impl IntoIterator<Item = usize>, values: &mut [f64]) -> f64 {
        if memory.ratio <= 0.0 {
            return 0.0;
        }
        let mut half_log = 0.0;
        // Steps are mostly equal.
        let (mut last, mut fall): (f64, f64) = (f64::NAN, 0.0);
        for series in numbers.into_iter().filter_map(|number| self.series.get(number)) {
            let (mut state, mut variance) = (0.0, memory.ratio);
            for &(place, step) in series {
                if step.to_bits() != last.to_bits() {
                    (last, fall) = (step, (-step / memory.length).exp());
                }
                state *= fall;
                variance = fall * fall * variance + (1.0 - fall * fall) * memory.ratio;
                let spread = variance + 1.0;
                let innovation = values[place] - state;
                let gain = variance / spread;
                state += gain * innovation;
                variance *= 1.0 - gain;
                values[place] = innovation / spread.sqrt();
                half_log += 0.5 * spread.ln();
            }
        }
        half_log
    }

    /// Autocorrelations to select from: lengths from two steps to a third of the longest series, in ratios of 3, and random walks, which are correlated
    /// far beyond the series: their level at its start is open, and the variance of a step decides.
    #[must_use]
    pub fn memories(&self) -> Vec<Memory> {
        let mut out = vec![Memory::default()];
        let mut length = 2.0 * self.step;
        while length > 0.0 && length <= self.longest / 3.0 {
            out.extend([0.1, 0.3, 1.0, 3.0, 10.0, 30.0].map(|ratio| Memory { ratio, length }));
            length *= 3.0;
        }
        let length = WALK * self.longest;
        if length > 0.0 && self.step > 0.0 {
            // The variance increases by 2 · ratio · step / length from one reading to the next.
            out.extend(STEPS.map(|fresh| Memory { ratio: 0.5 * fresh * length / self.step, length }));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn innovations_have_the_density_of_the_whole_covariance() {
        let machine = bench::machine();
        let um = [0.3, 0.9, -0.4, 1.3, 2.2, 1.8];
        let sets = [bench::reads_along_x(&machine, &um)];
        let scene = bench::scene(&machine, &sets);
        let noise = NoiseSeries::new(&scene, &[1e3; 6]);
        assert_eq!((noise.has_clock, noise.longest, noise.step), (false, 5.0, 1.0));
        let memory = Memory { ratio: 2.5, length: 3.0 };
        let mut white: Vec<f64> = um.to_vec();
        let half_log = noise.whiten(memory, &mut white);
        let covariance = DMatrix::from_fn(6, 6, |row, column| {
            let apart = row.abs_diff(column) as f64;
            2.5 * (-apart / 3.0).exp() + if row == column { 1.0 } else { 0.0 }
        });
        let values = DVector::from_row_slice(&um);
        let root = covariance.clone().cholesky().unwrap();
        let square = values.dot(&root.solve(&values));
        let own: f64 = white.iter().map(|value| value * value).sum();
        assert!((own - square).abs() < 1e-12 * square, "{own} {square}");
        assert!((half_log - 0.5 * covariance.determinant().ln()).abs() < 1e-12, "{half_log}");
    }
}
