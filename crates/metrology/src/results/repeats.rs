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
}
