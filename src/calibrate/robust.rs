//! Weights of rows that do not fit: Tukey's biweight on residuals in units of their spread.
//!
//! w = (1 − (r/(c s))²)² inside c = 4.685 spreads, 0 beyond; s from the median of the absolute residuals (Huber & Ronchetti 2009, ch. 7). The
//! first rounds use Huber's weights, which cannot lock on to a wrong start.

/// Tukey's constant for 95 % efficiency with normal noise.
const TUKEY: f64 = 4.685;
/// Huber's.
const HUBER: f64 = 1.345;
/// Median of the absolute values of normal noise, in standard deviations.
const MEDIAN: f64 = 0.674_489_750_196_081_7;

/// Standard deviation from the median of absolute values; 0 without any.
pub(super) fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    *median / MEDIAN
}

/// The weight of the square of a residual in units of the spread.
pub(super) fn weight(residual: f64, is_early: bool) -> f64 {
    let size = residual.abs();
    if is_early {
        if size <= HUBER { 1.0 } else { HUBER / size }
    } else if size < TUKEY {
        (1.0 - (size / TUKEY).powi(2)).powi(2)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_is_that_of_the_middle() {
        // Median of 1 … 9 is 5.
        let found = spread((1..=9).map(|k| f64::from(k) * if k % 2 == 0 { -1.0 } else { 1.0 }));
        assert!((found - 5.0 / 0.674_489_75).abs() < 1e-6);
        assert_eq!(spread(std::iter::empty()), 0.0);
    }

    #[test]
    fn weights_fall_to_nothing() {
        assert_eq!([weight(0.0, false), weight(5.0, false), weight(1.0, true)], [1.0, 0.0, 1.0]);
        assert!((weight(4.685 / 2.0, false) - 0.5625).abs() < 1e-12);
        assert!((weight(-13.45, true) - 0.1).abs() < 1e-12);
    }
}
