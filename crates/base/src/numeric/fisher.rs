//! Fisher's F distribution: p-values of variance ratios.

use super::student::incomplete_beta;

/// Returns the p-value of a ratio at least this large with `above` degrees of freedom over `below`; 1 if there are no degrees of freedom.
#[must_use]
pub fn exceeded(ratio: f64, above: f64, below: f64) -> f64 {
    if !(ratio > 0.0 && above > 0.0 && below > 0.0) {
        return 1.0;
    }
    if ratio.is_infinite() {
        return 0.0;
    }
    let whole = below + above * ratio;
    incomplete_beta(below / 2.0, above / 2.0, below / whole, above * ratio / whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_what_tables_print() {
        // Upper limits of published tables.
        for (chance, above, below, ratio) in
            [(0.05, 3.0, 10.0, 3.708), (0.05, 2.0, 20.0, 3.493), (0.01, 5.0, 30.0, 3.699), (0.05, 1.0, 1e6, 3.8415)]
        {
            let found = exceeded(ratio, above, below);
            assert!((found / chance - 1.0).abs() < 2e-3, "{above} {below}: {found}");
        }
    }

    #[test]
    fn two_above_has_a_formula() {
        // (1 + 2 F/n)^(−n/2)
        for (ratio, below) in [(0.3_f64, 7.0_f64), (4.0, 50.0), (30.0, 400.0)] {
            let expected = (1.0 + 2.0 * ratio / below).powf(-below / 2.0);
            assert!((exceeded(ratio, 2.0, below) / expected - 1.0).abs() < 1e-10);
        }
        assert_eq!(
            [exceeded(0.0, 2.0, 3.0), exceeded(f64::INFINITY, 2.0, 3.0), exceeded(f64::NAN, 2.0, 3.0)],
            [1.0, 0.0, 1.0]
        );
    }
}
