//! Classes: candidates that explain the readings nearly as well as a finding.

use super::cause::{Candidate, EffectKind};
use super::entrant::family;
use super::explain::assumptions::Family;
use super::mimic::RIVAL;
use super::search::{Field, Weights};
use super::size::is_angle;
use ncfix_base::numeric::Gain;
use ncfix_base::numeric::sums::dot;

/// Gains are equal if they agree to one part in this number.
const ROUNDED: f64 = 1e6;
/// Two effects on the readings are the same if the square of their correlation differs from 1 by less than this: rounding.
const SAME: f64 = 1e-6;

impl Field<'_, '_> {
    /// Returns the name of another squareness with the same effect on all readings, and the factor of its size; `None` if it is another error.
    pub(super) fn same_squareness(&self, weights: &Weights, number: usize, other: usize) -> Option<(String, f64)> {
        // Both are angles, so the factor has no unit.
        let is_squareness =
            |one: &&Candidate| family(one) == Family::Squareness && is_angle(one) && one.columns.len() == 1;
        let own = self.candidates.get(number).filter(is_squareness)?;
        let same = self.candidates.get(other).filter(is_squareness).filter(|_| other != number)?;
        let mut series = self.series(weights, &[], 0.0);
        let mut seen = |one: &Candidate| {
            series.set_values(self.columns(one).first()?);
            Some(series.left().to_vec())
        };
        let (own, seen) = (seen(own)?, seen(same)?);
        let [squares, products, others] = [dot(&own, &own), dot(&own, &seen), dot(&seen, &seen)];
        let is_same = squares > 0.0 && others > 0.0 && products * products > (1.0 - SAME) * squares * others;
        is_same.then(|| (same.parameter.clone(), products / others))
    }
}

/// Returns the candidates that explain nearly as much instead of one, itself first. `gains` are those of all candidates, given the other findings, `noise`
/// is the variance of the readings.
pub(super) fn class(field: &Field<'_, '_>, gains: &[Gain], number: usize, noise: f64) -> Vec<usize> {
    let own = gains.get(number).map_or(0.0, |gain| gain.squares);
    let mut rivals: Vec<(f64, usize)> = gains
        .iter()
        .enumerate()
        .filter(|(place, gain)| *place != number && (own - gain.squares) / noise < RIVAL && gain.squares > 0.5 * own)
        .map(|(place, gain)| (gain.squares, place))
        .collect();
    // The simplest comes first, because a slightly larger gain with more unknowns is no evidence. Candidates that differ only by rounding stay in the order
    // of the catalog.
    let rounded = |gain: f64| (gain / own.max(f64::MIN_POSITIVE) * ROUNDED).round();
    let far = |number: usize| field.candidates.get(number).map_or(u32::MAX, Candidate::plausibility_rank);
    rivals.sort_by(|a, b| far(a.1).cmp(&far(b.1)).then(rounded(b.0).total_cmp(&rounded(a.0))));
    let mut class: Vec<usize> = Vec::new();
    let mut names: Vec<(EffectKind, String)> = Vec::new();
    for place in std::iter::once(number).chain(rivals.into_iter().map(|(_, place)| place)) {
        if let Some(one) = field.candidates.get(place) {
            let name = (one.cause.effect, one.parameter.clone());
            if !names.contains(&name) {
                names.push(name);
                class.push(place);
            }
        }
    }
    class
}
