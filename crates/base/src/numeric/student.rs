//! Student's t: how likely so large a value is by chance.

/// Steps of the continued fraction, at most.
const MAX_STEPS: usize = 20_000;
/// What stands for a vanishing term of the continued fraction.
const TINY: f64 = 1e-300;
/// Halvings of an interval.
const HALVINGS: usize = 200;

/// Chance of a value at least as large as `t`, in either direction, at `freedom` degrees of freedom (any number above 0).
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

/// The value that is exceeded, in either direction, with this chance.
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

/// I(a, b) at x = 1 − y; both are given because the smaller one has more digits.
pub(super) fn incomplete_beta(a: f64, b: f64, x: f64, y: f64) -> f64 {
    if x <= 0.0 || y <= 0.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    let front = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * y.ln()).exp();
    if x < (a + 1.0) / (a + b + 2.0) { front * fraction(a, b, x) / a } else { 1.0 - front * fraction(b, a, y) / b }
}

/// The continued fraction of the incomplete beta function, by the method of Lentz.
fn fraction(a: f64, b: f64, x: f64) -> f64 {
    let safe = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / safe(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for step in 1..MAX_STEPS {
        let m = step as f64;
        for part in [
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        ] {
            d = 1.0 / safe(1.0 + part * d);
            c = safe(1.0 + part / c);
            value *= c * d;
        }
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

/// ln Γ by the series of Stirling above 10, from below by the recurrence.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 10.0 {
        shift += x.ln();
        x += 1.0;
    }
    let square = x * x;
    let series = (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - 1.0 / (1680.0 * square)) / square) / square) / x;
    (x - 0.5) * x.ln() - x + 0.918_938_533_204_672_7 + series - shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_what_tables_print() {
        // Two-sided limits of printed tables.
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
