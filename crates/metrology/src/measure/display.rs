//! Steps of a display: the largest number that divides all readings of a file.
//!
//! Readings that are rounded to a step have at least the noise step/√12 of a uniform distribution. If the step is large relative to the noise of the
//! instrument, most readings may be the same number, and their differences say nothing about the noise.

use std::collections::BTreeSet;

use super::data::{DataSet, Observation};

/// Finest step, mm; for angles a thousandth of it, rad.
const FINEST: f64 = 1e-7;
/// Minimum number of readings.
const COUNT: usize = 20;
/// Largest number of finest steps in a value.
const MOST: f64 = 1e12;
/// Largest difference of a value from a multiple of the finest step, in such steps.
const ROUNDED: f64 = 0.02;

/// The largest step that divides all values, mm or rad; `None` if it is not much larger than the finest.
pub(crate) fn step(values: &[f64], is_angle: bool) -> Option<f64> {
    if values.len() < COUNT {
        return None;
    }
    let finest = if is_angle { FINEST * 1e-3 } else { FINEST };
    let mut common = 0_u64;
    let mut kinds = BTreeSet::new();
    for value in values {
        let steps = value / finest;
        if !(steps.abs() < MOST && (steps - steps.round()).abs() < ROUNDED) {
            return None;
        }
        kinds.insert(steps.round() as i64);
        let mut other = steps.round().abs() as u64;
        while other != 0 {
            (common, other) = (other, common % other);
        }
        if common == 1 {
            return None;
        }
    }
    // For two numbers any step is possible.
    (kinds.len() > 2).then_some(common as f64 * finest)
}

/// RMS noise from the steps of values, mm or rad: half a step on either side is one value.
pub(crate) fn noise(values: &[f64], is_angle: bool) -> f64 {
    step(values, is_angle).unwrap_or(0.0) / 12.0_f64.sqrt()
}

/// RMS noise from the steps in the readings of lengths, mm, or of angles, rad, of a file; 0 without such steps.
pub(crate) fn noise_of(data: &DataSet, is_angle: bool) -> f64 {
    let own = data.observations.iter().filter(|one| Observation::is_angle(one) == is_angle);
    noise(&own.flat_map(|one| one.values).flatten().collect::<Vec<f64>>(), is_angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_what_divides_all_readings() {
        let all = |step: f64| (0..24).map(|k| f64::from(k % 5) * step).collect::<Vec<f64>>();
        // 1 µm, 0.1 µm; 0.01 µrad.
        assert!((step(&all(1e-3), false).unwrap() - 1e-3).abs() < 1e-12);
        assert!((noise(&all(1e-4), false) - 1e-4 / 12.0_f64.sqrt()).abs() < 1e-12);
        let signed: Vec<f64> = (0..24).map(|k| f64::from(k % 3 - 1) * 1e-3).collect();
        assert!((step(&signed, false).unwrap() - 1e-3).abs() < 1e-12);
        assert!((step(&all(1e-8), true).unwrap() - 1e-8).abs() < 1e-15);
        // Two numbers, too few readings, and readings finer than the finest step have none.
        let two: Vec<f64> = (0..24).map(|k| f64::from(k % 2) * 1e-3).collect();
        let fine: Vec<f64> = (0..24).map(|k| f64::from(k) * 1.234_567_89e-7).collect();
        assert_eq!([step(&two, false), step(&all(1e-3)[..19], false), step(&fine, false)], [None; 3]);
    }
}
