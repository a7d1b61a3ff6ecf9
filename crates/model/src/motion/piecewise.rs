//! Piecewise polynomial in truncated powers: e(q) = Σⱼ β₀ⱼ qʲ + Σᵢ Σⱼ βᵢⱼ (q − tᵢ)₊ʲ (Spaan, eq. 3.3).
//!
//! (x)₊ is x if x is positive and 0 otherwise; a term j = 0 is a step from the knot on. With only the highest power at its knots the function is a spline,
//! smooth except for its highest derivative.

use super::polynomial::{degree, evaluate};
use super::{Entry, EntryFunction};
use ncfix_base::diagnostic::{Code, Place};

/// Global polynomial with additions from each knot on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piecewise {
    /// β₀ⱼ at index j, mm or rad per power of mm or rad.
    pub coefficients: Vec<f64>,
    /// Knots, increasing.
    pub knots: Vec<Knot>,
}

/// Knot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knot {
    /// tᵢ, mm or rad.
    pub at: f64,
    /// βᵢⱼ at index j, mm or rad per power of mm or rad.
    pub coefficients: Vec<f64>,
}

impl Piecewise {
    /// Returns the value at a command, mm or rad.
    #[must_use]
    pub fn value(&self, command: f64) -> f64 {
        let reached = self.knots.iter().take_while(|knot| command >= knot.at);
        reached.fold(evaluate(&self.coefficients, command), |sum, knot| {
            sum + evaluate(&knot.coefficients, command - knot.at)
        })
    }

    /// Returns the highest power.
    pub(super) fn degree(&self) -> usize {
        let knots = self.knots.iter().map(|knot| degree(&knot.coefficients));
        knots.fold(degree(&self.coefficients), usize::max)
    }
}

/// Example entry.
pub(super) const EXAMPLE: &str = "component = \"EZY\"\nkind = \"piecewise\"\ndegree = 2\n\
    coefficients = [0.0, 1e-5, 2e-8]\nknots = [{ at_mm = 100, coefficients = [0, 0, 3e-8] }]\n";

/// Reads `coefficients`, `knots` (`at_mm` or `at_deg` and `coefficients` each) and the optional `degree`, which they must not exceed.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<EntryFunction> {
    let highest = entry.section.integer("degree");
    let coefficients = entry.coefficients("coefficients");
    let mut knots = Vec::new();
    let mut complete = true;
    for section in entry.section.sections("knots") {
        let mut knot = Entry { section, name: entry.name, axes: entry.axes };
        let at = knot.position("at");
        let own = knot.coefficients("coefficients");
        let place = knot.section.place_of("coefficients");
        entry.take_findings(knot.section);
        match (at, own) {
            (Some(at), Some(own)) => {
                check_degree(entry, highest, &own, place);
                knots.push(Knot { at, coefficients: own });
            }
            _ => complete = false,
        }
    }
    let coefficients = coefficients?;
    let place = entry.section.place_of("coefficients");
    check_degree(entry, highest, &coefficients, place);
    let positions: Vec<f64> = knots.iter().map(|knot| knot.at).collect();
    entry.demand_increase("knots", &positions)?;
    complete.then_some(EntryFunction::Piecewise(Piecewise { coefficients, knots }))
}

fn check_degree(entry: &mut Entry<'_>, highest: Option<u32>, coefficients: &[f64], place: Place) {
    if let Some(highest) = highest
        && coefficients.len() > highest as usize + 1
    {
        let message = format!("{} coefficients for a polynomial of degree {highest}", coefficients.len());
        let help = format!("give at most {} coefficients, from degree 0, or raise degree", highest as usize + 1);
        entry.section.report(Code::BAD_VALUE, place, message, help);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_knot_adds_its_powers_from_its_place_on() {
        let knots = vec![
            Knot { at: 100.0, coefficients: vec![0.0, 0.0, 3.0] },
            Knot { at: 200.0, coefficients: vec![7.0, -1.0] },
        ];
        let piecewise = Piecewise { coefficients: vec![1.0, 0.5], knots };
        assert_eq!(piecewise.value(50.0), 26.0);
        assert_eq!(piecewise.value(100.0), 51.0);
        assert_eq!(piecewise.value(110.0), 56.0 + 300.0);
        assert_eq!(piecewise.value(202.0), 1.0 + 101.0 + 3.0 * 102.0 * 102.0 + 7.0 - 2.0);
        assert_eq!(piecewise.degree(), 2);
    }
}
