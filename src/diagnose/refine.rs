//! Periods and time constants moved to where they explain most.

use super::cause::{Candidate, Effect, periodic, thermal};
use super::scene::Through;
use super::search::{Field, Weights};
use super::seek::information_of;
use crate::geometry::Axis;
use crate::model::motion::Function;
use crate::model::name::ErrorName;
use crate::numeric::Series;

/// Half of the width of the peak of a period, cycles over the travel, and steps towards its top.
const PEAK: f64 = 0.4;
const REFINED: usize = 14;
/// Pitches of screws, mm (ISO 3408-2), from the coarsest.
pub(super) const PITCHES: [f64; 11] = [40.0, 32.0, 25.0, 20.0, 16.0, 12.0, 10.0, 8.0, 6.0, 5.0, 4.0];
/// The amplitude of another name of a wave is larger by this at most.
const LARGER: f64 = 1.5;
/// A rival explains nearly as much: so much of χ² less at most.
pub(super) const RIVAL: f64 = 6.0;
/// Peaks that explain this share of the best are looked at in full.
const ALIAS: f64 = 0.8;

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
            let refined = self.period_near(series, name, axis, first);
            let one = refined.as_ref().unwrap_or(one);
            return self.usual(series, name, axis, one).or(refined);
        }
        let [shortest, longest] = thermal::around(first)?;
        let with = |lag: f64| thermal::with_lag(self.scene, one, lag.exp());
        self.best_near(series, [shortest.ln(), first.ln(), longest.ln()], &with)
    }

    fn period_near(&self, series: &Series, name: ErrorName, axis: Axis, period: f64) -> Option<Candidate> {
        let travel = self.seek.sweep(axis)?.travel();
        let cycles = travel / period;
        let with = |cycles: f64| Some(periodic::candidate(name, axis, travel / cycles));
        self.best_near(series, [cycles - PEAK, cycles, cycles + PEAK], &with)
    }

    /// Of the periods that evenly spaced places show like one of them, one that the machine file has or that screws have.
    fn usual(&self, series: &Series, name: ErrorName, axis: Axis, one: &Candidate) -> Option<Candidate> {
        let sweep = self.seek.sweep(axis)?;
        let (period, _) = one.constant?;
        let aliases = sweep.aliases(period);
        let own = series.gain(&self.columns(one)).squares;
        let noise = (series.squares() - own).max(0.0) / (series.count() as f64).max(1.0);
        let is_near = |pitch: f64| {
            let cycles = sweep.travel() / pitch;
            let is_alike = |other: &f64| (sweep.travel() / other - cycles).abs() < PEAK;
            aliases.iter().chain([&period]).any(is_alike)
        };
        let known = self.scene.errors.motion.iter().filter(|error| error.name.axis() == Some(axis));
        let known = known.filter_map(|error| match &error.function {
            Function::Periodic(own) => Some(own.period),
            _ => None,
        });
        let pitches = known.chain(PITCHES).filter(|pitch| !aliases.is_empty() && is_near(*pitch));
        let mut all = pitches.map(|pitch| periodic::candidate(name, axis, pitch));
        // Where two steps are a period its sine and cosine are one column, and its amplitude is anything.
        let amplitude = |one: &Candidate| {
            let (amounts, _) = series.amounts(&self.columns(one));
            amounts.iter().map(|amount| amount * amount).sum::<f64>().sqrt()
        };
        let most = LARGER * amplitude(one);
        all.find(|other| own - series.gain(&self.columns(other)).squares < RIVAL * noise && amplitude(other) < most)
    }

    /// Other periods that a candidate beside some others may as well have: readings at these places do not tell.
    pub(super) fn aliases(
        &self,
        weights: &Weights,
        number: usize,
        others: &[usize],
        (memory, noise): (f64, f64),
    ) -> Vec<f64> {
        let series = self.series(weights, others, memory);
        let found = self.candidates.get(number).filter(|one| one.cause.effect == Effect::Periodic).and_then(|one| {
            let (Through::Component(name), _) = *one.columns.first()?.first()? else { return None };
            let axis = name.axis()?;
            let sweep = self.seek.sweep(axis)?;
            let (period, _) = one.constant?;
            let own = series.gain(&self.columns(one)).squares;
            let information = information_of(&self.factors, Through::Component(name), &weights.items);
            let left = series.unwhitened(series.left());
            let products: Vec<f64> =
                self.factors.get(&Through::Component(name))?.iter().zip(&left).map(|(a, b)| a * b).collect();
            let is_other = |other: &f64| (sweep.travel() / other - sweep.travel() / period).abs() > 2.0 * PEAK;
            let is_rival = |other: &f64| {
                let near = self.period_near(&series, name, axis, *other);
                let near = near.unwrap_or_else(|| periodic::candidate(name, axis, *other));
                (own - series.gain(&self.columns(&near)).squares) / noise < RIVAL
            };
            let all = sweep.peaks(&products, &information, ALIAS).into_iter();
            Some(all.filter(is_other).filter(is_rival).collect::<Vec<f64>>())
        });
        let mut found = found.unwrap_or_default();
        found.sort_by(|a, b| b.total_cmp(a));
        found
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
