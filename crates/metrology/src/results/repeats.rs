//! Repeatability: the scatter of readings that were repeated at the same pose, pooled over all poses (Esmaeili 2021, 4.7 and 5.9.1).
//!
//! The model has no part in it: σ² is the sum of squares about the mean of each pose, over the readings beyond the first of each pose.

use std::collections::BTreeMap;

use crate::measure::data::Observation;
use ncfix_base::geometry::AXES;

/// Common properties of repeated readings, positions in nanometers or nanoradians: set-up, ball, component, positions and directions of motion, tool
/// and spindle angle.
type ReadingPlace = (usize, Option<usize>, Option<String>, Vec<i64>, Vec<i8>);

/// The place of a reading.
pub(super) fn place(row: &Observation) -> ReadingPlace {
    let nano = |value: f64| (value * 1e6).round() as i64;
    let position = AXES.into_iter().map(|axis| row.reading.position[axis]);
    let rest = row.reading.tool_mm.iter().copied().chain([row.spindle_rad]);
    let component = row.component.map(|component| component.to_string());
    let directions = row.reading.state.direction.to_vec();
    (row.setup, row.target, component, position.chain(rest).map(nano).collect(), directions)
}

/// The pooled standard deviation of values with their places, and the number of repetitions beyond the first of each place; `None` without any.
pub(super) fn pooled<P: Ord>(values: impl IntoIterator<Item = (P, f64)>) -> Option<(f64, usize)> {
    let mut places: BTreeMap<P, Vec<f64>> = BTreeMap::new();
    for (place, value) in values {
        places.entry(place).or_default().push(value);
    }
    let (mut squares, mut repetitions) = (0.0, 0);
    for values in places.values() {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        squares += values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        repetitions += values.len() - 1;
    }
    (repetitions > 0).then(|| ((squares / repetitions as f64).sqrt(), repetitions))
}

/// True if the deviations from the mean of each place, in the order of the readings, change slowly: the scatter is then mostly a drift.
///
/// The ratio of von Neumann (1941): half the mean square of the steps over the mean square. It is 1 for noise, with a standard deviation of 1/√n.
pub(super) fn drifts<P: Ord>(values: impl IntoIterator<Item = (P, f64)>) -> bool {
    /// Ratio below which less than half of the scatter is noise.
    const NOISE: f64 = 0.5;
    /// Number of its standard deviations by which it must differ from that of noise.
    const SURELY: f64 = 4.0;
    let values: Vec<(P, f64)> = values.into_iter().collect();
    let mut places: BTreeMap<&P, (f64, f64)> = BTreeMap::new();
    for (place, value) in &values {
        let sums = places.entry(place).or_default();
        *sums = (sums.0 + value, sums.1 + 1.0);
    }
    let of = |(place, value): &(P, f64)| places.get(place).map(|(sum, count)| (value - sum / count, *count));
    let repeated: Vec<f64> =
        values.iter().filter_map(of).filter(|(_, count)| *count > 1.0).map(|(off, _)| off).collect();
    let count = repeated.len() as f64;
    let squares: f64 = repeated.iter().map(|off| off * off).sum();
    let steps: f64 = repeated.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    let ratio = if squares > 0.0 { steps / 2.0 / squares } else { 1.0 };
    ratio < NOISE && ratio < 1.0 - SURELY / count.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_is_pooled_about_the_mean_of_each_place() {
        // 1, 2, 3 about 2: squares 2; 10, 14 about 12: squares 8; 7 stands alone. 10 over 3 repetitions.
        let values = [(1, 1.0), (2, 10.0), (1, 2.0), (3, 7.0), (2, 14.0), (1, 3.0)];
        let (sigma, repetitions) = pooled(values).unwrap();
        assert!((sigma - (10.0_f64 / 3.0).sqrt()).abs() < 1e-12 && repetitions == 3, "{sigma} {repetitions}");
        assert_eq!(pooled([(1, 1.0), (2, 5.0)]), None);
    }

    #[test]
    fn a_slow_change_is_a_drift_and_an_alternating_one_is_not() {
        // Steps of 1 over 40 readings of one place: Σ steps² = 39, Σ squares = 40 (40² − 1)/12 = 5330; ratio 0.004.
        assert!(drifts((0..40).map(|k| (0, f64::from(k)))));
        // ±1 in turn: Σ steps² = 4 · 39, Σ squares = 40; ratio 1.95.
        assert!(!drifts((0..40).map(|k| (0, if k % 2 == 0 { 1.0 } else { -1.0 }))));
        // The error of each place is not a drift: ten runs over four places without any scatter in order.
        assert!(!drifts(
            (0..40).map(|k| (k % 4, 100.0 * f64::from(k % 4) + if (k / 4 + k) % 2 == 0 { 1.0 } else { -1.0 }))
        ));
    }
}
