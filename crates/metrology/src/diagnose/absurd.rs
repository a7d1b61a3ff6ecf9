//! Rejects candidates to which the readings are insensitive: to explain micrometers, they would exceed any plausible machine error.

use super::cause::{Candidate, EffectKind, range};
use super::row::{NOWHERE, SceneRow};
use super::scene::Through;
use super::search::Field;
use super::size::{Amounts, size, weights_at};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::numeric::Series;
use ncfix_base::units::um_from_mm;

/// Largest plausible machine error where the readings are insensitive, mm and rad.
const ABSURD: [f64; 2] = [1.0, 1e-2];
/// Largest RMS residual at which this limit applies, mm or rad.
const LITTLE: f64 = 0.05;
/// Maximum number of rows at which a deviation is evaluated.
const ROWS: usize = 400;

impl Field<'_, '_> {
    /// True if a candidate, in addition to the terms of `series`, exceeds any plausible machine error although the residuals are small.
    pub(super) fn is_absurd(&self, number: usize, series: &Series) -> bool {
        let most = |one: &Candidate| match one.columns.first()?.first()?.0 {
            Through::Component(name) => Some(ABSURD[usize::from(name.direction.is_rotation())]),
            Through::Tip(_) => Some(ABSURD[0]),
            Through::Reading(_) | Through::Value(_) => None,
        };
        let Some((one, most)) = self.candidates.get(number).and_then(|one| Some((one, most(one)?))) else {
            return false;
        };
        let (amounts, covariance) = series.amounts(&self.columns(one));
        let step = (self.scene.rows.len() / ROWS).max(1);
        let is_large = |row: &SceneRow| {
            let all = weights_at(one, row);
            all.iter().zip(&amounts).map(|(weight, amount)| weight * amount).sum::<f64>().abs() > most
        };
        // A spike is largest at the reversal itself, where there may be no reading.
        let is_high = || {
            let covariance = covariance.row_iter().map(|row| row.iter().copied().collect()).collect();
            let amounts = Amounts { values: amounts.clone(), covariance };
            size(one, &amounts, self.scene, self.scene.sets.len()).value.abs() > um_from_mm(most)
        };
        // A dependence on two axes is evaluated at the ends of both: measured lines cover only its middle.
        let is_beyond = (one.cause.effect == EffectKind::ReversalSpike && is_high())
            || self.scene.rows.iter().step_by(step).any(is_large)
            || self.corners(one).iter().any(is_large);
        let squares: f64 = self.scene.items.iter().map(|item| item.left * item.left).sum();
        is_beyond && squares < LITTLE * LITTLE * self.scene.items.len() as f64
    }

    /// Combinations of the measured end positions of both axes of a candidate; empty if it depends on anything else.
    fn corners(&self, one: &Candidate) -> Vec<SceneRow> {
        let axis = |driver: &String| AXES.into_iter().find(|axis| axis.to_string() == *driver);
        let axes: Option<Vec<Axis>> = one.drivers.iter().map(axis).collect();
        let (Some(axes), Some(first)) = (axes.filter(|axes| axes.len() == 2), self.scene.rows.first()) else {
            return Vec::new();
        };
        let mut out = vec![SceneRow { number: NOWHERE, ..first.clone() }];
        for axis in axes {
            let Some(ends) = range(self.scene, axis) else { return Vec::new() };
            let at = |row: &SceneRow, place: f64| {
                let mut row = row.clone();
                row.position[axis] = place;
                row
            };
            out = out.iter().flat_map(|row| ends.map(|place| at(row, place))).collect();
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::cause::Weight;

    #[test]
    fn millimetres_for_readings_of_micrometres_are_absurd() {
        let machine = bench::machine();
        let found = |um: f64| {
            let sets = [bench::reads_along_x(&machine, &[um; 8])];
            let scene = bench::scene(&machine, &sets);
            // The readings show only a thousandth of it.
            let mut one = bench::candidate(EffectKind::Unknown, Through::Tip(0), |_| 1.0);
            one.columns[0].push((Through::Tip(0), Weight::new(|_| -0.999)));
            let field = Field::new(&scene, vec![one]);
            field.is_absurd(0, &field.series(&bench::even(&scene), &[], 0.0))
        };
        // 0.5 mm is plausible, 10 mm is not; with residuals of 0.1 mm the limit does not apply.
        assert_eq!([0.5, 10.0, 100.0].map(found), [false, true, false]);
    }
}
