//! The curve of a straightness whose slope the set-ups absorb.
//!
//! Over its travel a straightness has no slope (ISO 230-1). A polynomial about the zero of the axis has one, and where the alignment of the reference is an
//! unknown, no reading determines it. So the curve gets the slope that makes it straight on average over the measured range.

use super::cause::{Candidate, EffectKind, Term, own, range};
use super::row::{NOWHERE, SceneRow};
use super::search::{Field, Weights};
use super::size::{Amounts, weights_at};
use ncfix_model::parameter::ComponentTerm;

/// Number of intervals of the measured range.
const LOOKS: u32 = 100;

/// Mean slopes of the columns of a straightness, the first of which is the slope itself.
pub(super) struct MeanSlopes(Vec<f64>);

impl MeanSlopes {
    /// Returns amounts with the slope that makes the curve straight on average. The given amount of the slope is 0.
    pub(super) fn level(&self, amounts: Amounts) -> Amounts {
        let Amounts { mut values, mut covariance } = amounts;
        let rest = || self.0.iter().enumerate().skip(1);
        let given = covariance.clone();
        let at = |k: usize, l: usize| given.get(k).and_then(|row| row.get(l)).copied().unwrap_or(0.0);
        let slope: f64 = rest().map(|(k, slope)| slope * values.get(k).copied().unwrap_or(0.0)).sum();
        values.first_mut().into_iter().for_each(|first| *first = -slope);
        for l in 0..values.len() {
            let with: f64 = rest().map(|(k, slope)| slope * at(k, l)).sum();
            let both: f64 = rest().map(|(k, one)| rest().map(|(j, other)| one * other * at(k, j)).sum::<f64>()).sum();
            let value = if l == 0 { both } else { -with };
            for (k, m) in [(0, l), (l, 0)] {
                covariance.get_mut(k).and_then(|row| row.get_mut(m)).into_iter().for_each(|own| *own = value);
            }
        }
        Amounts { values, covariance }
    }
}

impl Field<'_, '_> {
    /// Returns the mean slopes of the columns of a curve across its axis; `None` if the readings show its slope.
    pub(super) fn mean_slopes(&self, weights: &Weights, one: &Candidate) -> Option<MeanSlopes> {
        let Term::Parameters(names) = &one.term else { return None };
        let first = names.first().filter(|name| names.len() > 1 && name.term == ComponentTerm::Coefficient(1))?;
        let axis = first.component.axis().filter(|axis| !axis.is_rotary())?;
        let is_across = !first.component.direction.is_rotation() && first.component != own(axis);
        if one.cause.effect != EffectKind::Motion || !is_across {
            return None;
        }
        let columns = self.columns(one);
        if self.series(weights, &[], 0.0).gain(columns.get(..1)?).rank > 0 {
            return None;
        }
        let [low, high] = range(self.scene, axis)?;
        let row = self.scene.rows.first()?;
        let mut products = vec![0.0; columns.len()];
        let mut squares = 0.0;
        for k in 0..=LOOKS {
            let away = (high - low) * (f64::from(k) / f64::from(LOOKS) - 0.5);
            let mut row = SceneRow { number: NOWHERE, ..row.clone() };
            row.position[axis] = f64::midpoint(low, high) + away;
            products.iter_mut().zip(weights_at(one, &row)).for_each(|(sum, weight)| *sum += away * weight);
            squares += away * away;
        }
        (squares > 0.0).then(|| MeanSlopes(products.into_iter().map(|product| product / squares).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_far_from_the_zero_becomes_level() {
        // x² has the mean slope 2 · 450 about the middle 450.
        let slopes = MeanSlopes(vec![1.0, 900.0]);
        let given = Amounts { values: vec![0.0, 2.0], covariance: vec![vec![0.0, 0.0], vec![0.0, 0.25]] };
        let level = slopes.level(given);
        assert_eq!(level.values, [-1800.0, 2.0]);
        assert_eq!(level.covariance, [[900.0 * 900.0 * 0.25, -225.0], [-225.0, 0.25]]);
        // The deviation at 650 is that at 250.
        let at = |x: f64| level.form(&[x - 450.0, x * x - 450.0 * 450.0]);
        assert!((at(650.0).0 - at(250.0).0).abs() < 1e-6 && (at(650.0).1 - at(250.0).1).abs() < 1e-6);
    }
}
