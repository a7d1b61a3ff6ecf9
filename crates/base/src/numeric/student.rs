//! Student's t distribution: p-values and limits.

use statrs::function::beta::beta_reg;

/// Number of halvings of an interval.
const HALVINGS: usize = 200;

/// Returns the p-value of a value at least as large as `t` in either direction, with `freedom` degrees of freedom (any positive number).
#[must_use]
pub fn two_sided(t: f64, freedom: f64) -> f64 {
    if t.is_nan() || freedom.is_nan() || freedom <= 0.0 {
        return 1.0;
    }
    let square = t * t;
    if square.is_infinite() {
        return 0.0;
    }
    incomplete_beta(freedom / 2.0, 0.5, freedom / (freedom + square), square / (freedom + square))
}

/// Returns the two-sided limit for a p-value, by bisection. The inverse of statrs has no correct digit if the p-value is tiny or the degrees of freedom are
/// many.
#[must_use]
pub fn limit(chance: f64, freedom: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while two_sided(high, freedom) > chance && high < 1e150 {
        low = high;
        high *= 2.0;
    }
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if two_sided(middle, freedom) > chance { low = middle } else { high = middle }
    }
    high
}

/// Returns I(a, b) at x = 1 − y; both are given because the smaller one has more digits.
pub(super) fn incomplete_beta(a: f64, b: f64, x: f64, y: f64) -> f64 {
    if x <= 0.0 || y <= 0.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    // The library mirrors on the same side, but uses 1 − x.
    if x < (a + 1.0) / (a + b + 2.0) { beta_reg(a, b, x) } else { 1.0 - beta_reg(b, a, y) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_what_tables_print() {
        // Two-sided limits of published tables.
        for (chance, freedom, expected) in [
            (0.05, 1.0, 12.706),
            (0.05, 10.0, 2.228),
            (0.01, 5.0, 4.032),
            (0.001, 30.0, 3.646),
            (0.05, 1e6, 1.960),
            (0.01, 120.0, 2.617),
        ] {
            assert!((limit(chance, freedom) - expected).abs() < 6e-4, "{chance} {freedom}: {}", limit(chance, freedom));
        }
    }

    #[test]
    fn one_and_two_degrees_of_freedom_have_formulas() {
        for t in [0.1_f64, 1.0, 3.0, 200.0] {
            let cauchy = 1.0 - 2.0 * t.atan() / std::f64::consts::PI;
            assert!((two_sided(t, 1.0) - cauchy).abs() < 1e-12);
            assert!((two_sided(-t, 2.0) - (1.0 - t / (2.0 + t * t).sqrt())).abs() < 1e-12);
        }
        assert_eq!([two_sided(0.0, 3.0), two_sided(f64::INFINITY, 3.0), two_sided(f64::NAN, 3.0)], [1.0, 0.0, 1.0]);
        assert!(two_sided(40.0, 1000.0) < 1e-100);
    }
}
