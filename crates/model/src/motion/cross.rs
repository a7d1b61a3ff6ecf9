//! Cross-coupling: an error of one axis that also depends on another axis, e(q, r) = (Σ aₖ qᵏ)(Σ bₖ rᵏ).
//!
//! It arises from finite stiffness: the roll of Y may change with the position of X (Spaan, ch. 4, measured up to 10 µrad). The product of the coefficients
//! carries the unit: aₖ in mm or rad per power, bₖ per power only.

use super::polynomial::evaluate;
use super::{Entry, EntryFunction};
use ncfix_base::geometry::Axis;

/// Product of two polynomials.
#[derive(Clone, Debug, PartialEq)]
pub struct Cross {
    /// aₖ at index k, for the command of its own axis.
    pub coefficients: Vec<f64>,
    /// Other axis.
    pub with: Axis,
    /// bₖ at index k, of the other command.
    pub with_coefficients: Vec<f64>,
}

impl Cross {
    /// Returns the value at the commands of its own and of the other axis, mm or rad.
    #[must_use]
    pub fn value(&self, own: f64, other: f64) -> f64 {
        evaluate(&self.coefficients, own) * evaluate(&self.with_coefficients, other)
    }
}

/// Example entry.
pub(super) const EXAMPLE: &str = "component = \"EAY\"\nkind = \"cross\"\n\
    coefficients = [0, 1e-9]\nwith = \"X\"\nwith_coefficients = [0, 1.0]\n";

/// Reads `coefficients`, `with` and `with_coefficients`.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<EntryFunction> {
    let coefficients = entry.coefficients("coefficients");
    let with_coefficients = entry.coefficients("with_coefficients");
    let with = entry.other_axis("with")?;
    Some(EntryFunction::Cross(Cross { coefficients: coefficients?, with, with_coefficients: with_coefficients? }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_polynomials_are_multiplied() {
        let cross = Cross { coefficients: vec![0.0, 1e-9], with: Axis::X, with_coefficients: vec![2.0, 0.0, 1.0] };
        assert!((cross.value(100.0, 3.0) - 1.1e-6).abs() < 1e-21);
        assert_eq!(cross.value(0.0, 3.0), 0.0);
    }
}
