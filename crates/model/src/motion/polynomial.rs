//! Polynomial of the axis command: e(q) = Σ cₖ qᵏ, q in mm or rad, cₖ in mm or rad per power of mm or rad.
//!
//! This is the form in which the literature prints calibrated motion errors (Esmaeili 2021, eq. 3 and Tables 4-2, 4-3). Outside the measured travel it grows
//! without bound, so a machine file should state the travel.

use super::{Entry, EntryFunction};

/// Coefficients from degree 0, mm or rad per power of mm or rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polynomial {
    /// cₖ at index k.
    pub coefficients: Vec<f64>,
}

impl Polynomial {
    /// Returns the value at a command, mm or rad.
    #[must_use]
    pub fn value(&self, command: f64) -> f64 {
        evaluate(&self.coefficients, command)
    }
}

/// Evaluates Σ cₖ qᵏ by Horner's rule.
pub(super) fn evaluate(coefficients: &[f64], command: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * command + coefficient)
}

/// Returns the highest power with a nonzero coefficient.
pub(super) fn degree(coefficients: &[f64]) -> usize {
    coefficients.iter().rposition(|&coefficient| coefficient != 0.0).unwrap_or(0)
}

/// Example entry.
pub(super) const EXAMPLE: &str = "component = \"EXX\"\nkind = \"polynomial\"\n\
    coefficients = [0.0, -3.13e-4, 7.53e-8, 1.35e-10]\n";

/// Reads `coefficients`.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<EntryFunction> {
    Some(EntryFunction::Polynomial(Polynomial { coefficients: entry.coefficients("coefficients")? }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_summed() {
        let polynomial = Polynomial { coefficients: vec![0.5, -3.0, 0.0, 0.25] };
        assert_eq!(polynomial.value(4.0), 0.5 - 12.0 + 16.0);
        assert_eq!(polynomial.value(-2.0), 0.5 + 6.0 - 2.0);
        assert_eq!(degree(&[1.0, 2.0, 0.0]), 1);
        assert_eq!(Polynomial::default().value(3.0), 0.0);
    }
}
