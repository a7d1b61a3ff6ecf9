//! Weights of rows that do not fit: Tukey's biweight on residuals in units of their spread.
//!
//! w = (1 − (r/(c s))²)² inside c = 4.685 spreads, 0 beyond; s from the median of the absolute residuals (Huber & Ronchetti 2009, ch. 7). The first
//! iterations use Huber's weights, which cannot lock on to a wrong start.

/// Tukey's constant for 95 % efficiency with normal noise.
const TUKEY: f64 = 4.685;
/// Huber's constant.
const HUBER: f64 = 1.345;
/// ⟨w⟩ / ⟨w r²⟩ of Tukey's weights for normal noise of unit variance.
const TEMPERED: f64 = 1.207_623;
/// Variance of an estimate relative to the variance from the weighted normal equations: ⟨ψ²⟩ ⟨w⟩ / ⟨ψ′⟩².
pub(super) const TUKEY_VARIANCE: f64 = 0.963_274;
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

/// Standard deviation from values weighted by an initial estimate: it uses almost all information, while the median uses a third.
pub(super) fn tempered(values: &[f64], scale: f64) -> f64 {
    let (sum, squares) = values.iter().fold((0.0, 0.0), |(sum, squares), value| {
        let weight = weight(value / scale, false);
        (sum + weight, squares + weight * value * value)
    });
    if sum > 0.0 { (TEMPERED * squares / sum).sqrt() } else { scale }
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
    fn tempered_spread_and_variance_are_those_of_normal_noise() {
        // Expectations over the normal density, by sums over a grid.
        let step = 1e-3;
        let expect = |of: &dyn Fn(f64) -> f64| {
            let at = |k: i32| f64::from(k) * step;
            (-9000..=9000).map(|k| of(at(k)) * (-at(k) * at(k) / 2.0).exp()).sum::<f64>() * step / 2.506_628_274_631
        };
        let tukey = |r: f64| weight(r, false);
        let slope = |r: f64| ((r + 1e-5) * tukey(r + 1e-5) - (r - 1e-5) * tukey(r - 1e-5)) / 2e-5;
        assert!((expect(&tukey) / expect(&|r| tukey(r) * r * r) - TEMPERED).abs() < 1e-5);
        let variance = expect(&|r| (tukey(r) * r).powi(2)) * expect(&tukey) / expect(&slope).powi(2);
        assert!((variance - TUKEY_VARIANCE).abs() < 1e-5);
    }

    #[test]
    fn weights_fall_to_nothing() {
        assert_eq!([weight(0.0, false), weight(5.0, false), weight(1.0, true)], [1.0, 0.0, 1.0]);
        assert!((weight(4.685 / 2.0, false) - 0.5625).abs() < 1e-12);
        assert!((weight(-13.45, true) - 0.1).abs() < 1e-12);
    }
}
