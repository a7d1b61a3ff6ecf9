//! Periods and time constants moved to where they explain most.

use super::cause::{Candidate, Effect, periodic, thermal};
use super::scene::Through;
use super::search::Field;
use crate::numeric::Series;

/// Half of the width of the peak of a period, cycles over the travel, and steps towards its top.
const PEAK: f64 = 0.4;
const REFINED: usize = 14;

impl Field<'_, '_> {
    /// A candidate with its period or its time constant moved to where it explains most: one that is a little off leaves beats and tails. `None` where
    /// there is none to move.
    pub(super) fn refined(&self, number: usize, series: &Series) -> Option<Candidate> {
        let one = self.candidates.get(number)?;
        let (first, _) = one.constant?;
        let (through, _) = one.columns.first()?.first()?;
        if one.cause.effect == Effect::Periodic {
            let Through::Component(name) = *through else { return None };
            let axis = name.axis()?;
            let travel = self.seek.travel(axis)?;
            let cycles = travel / first;
            let with = |cycles: f64| Some(periodic::candidate(name, axis, travel / cycles));
            return self.best_near(series, [cycles - PEAK, cycles, cycles + PEAK], &with);
        }
        let [shortest, longest] = thermal::around(first)?;
        let with = |lag: f64| thermal::with_lag(self.scene, one, lag.exp());
        self.best_near(series, [shortest.ln(), first.ln(), longest.ln()], &with)
    }

    /// The candidate of the number between two others that gains most, if it gains more than that of the middle one.
    fn best_near(
        &self,
        series: &Series,
        [low, middle, high]: [f64; 3],
        with: &dyn Fn(f64) -> Option<Candidate>,
    ) -> Option<Candidate> {
        let gain = |at: f64| with(at).map_or(0.0, |one| series.gain(&self.columns(&one)).squares);
        let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
        let [mut low, mut high] = [low, high];
        let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_left, mut at_right) = (gain(left), gain(right));
        for _ in 0..REFINED {
            if at_left > at_right {
                (high, right, at_right) = (right, left, at_left);
                left = high - golden * (high - low);
                at_left = gain(left);
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = low + golden * (high - low);
                at_right = gain(right);
            }
        }
        let best = f64::midpoint(low, high);
        with(best).filter(|_| gain(best) > gain(middle))
    }
}
