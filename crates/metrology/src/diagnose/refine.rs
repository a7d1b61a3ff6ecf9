//! Refinement of periods and time constants to the value that explains most. [`super::mimic`] finds others with equal effects on the readings.

use super::cause::{Candidate, EffectKind, periodic, thermal, with_spindle_speed};
use super::mimic::RIVAL;
use super::scene::Through;
use super::search::Field;
use ncfix_base::geometry::Axis;
use ncfix_base::numeric::{Series, peak};
use ncfix_model::name::ErrorName;

/// Half width of the peak of a period, in cycles over the travel.
pub(super) const PEAK: f64 = 0.4;
/// Tolerance of the refined value, as a share of the searched interval, and maximum number of evaluations.
const REFINED: f64 = 5e-4;
const TRIALS: usize = 18;
/// Largest ratio of the amplitude of an alias to that of the wave.
const LARGER: f64 = 1.5;

impl Field<'_, '_> {
    /// A candidate with its period or time constant refined to the value that explains most, because a wrong one leaves beats and tails in the
    /// residual. `None` if it has no such constant.
    pub(super) fn refined(&self, number: usize, series: &Series) -> Option<Candidate> {
        let one = self.candidates.get(number)?;
        let (first, _) = one.constant?;
        let (through, _) = one.columns.first()?.first()?;
        if one.cause.effect == EffectKind::Periodic {
            let Through::Component(name) = *through else { return None };
            let axis = name.axis()?;
            let refined = self.period_near(series, name, axis, first);
            let one = refined.as_ref().unwrap_or(one);
            return self.usual(series, name, axis, one).or(refined);
        }
        if let Some(([shortest, longest], ways)) = with_spindle_speed(self.scene, one) {
            let moved = ways.iter().filter_map(|way| {
                let with = |lag: f64| way(lag.exp());
                let moved = self.best_near(series, [shortest.ln(), first.ln(), longest.ln()], &with);
                moved.or_else(|| way(first))
            });
            let gain = |one: &Candidate| series.gain(&self.columns(one)).squares;
            let best = moved.map(|one| (gain(&one), one)).max_by(|a, b| a.0.total_cmp(&b.0));
            return best.filter(|(most, _)| *most > gain(one)).map(|(_, one)| one);
        }
        let [shortest, longest] = thermal::around(first)?;
        let with = |lag: f64| thermal::with_lag(self.scene, one, lag.exp());
        self.best_near(series, [shortest.ln(), first.ln(), longest.ln()], &with)
    }

    pub(super) fn period_near(&self, series: &Series, name: ErrorName, axis: Axis, period: f64) -> Option<Candidate> {
        let travel = self.seek.sweep(axis)?.travel();
        let cycles = travel / period;
        let with = |cycles: f64| Some(periodic::candidate(name, axis, travel / cycles));
        self.best_near(series, [cycles - PEAK, cycles, cycles + PEAK], &with)
    }

    /// A period that evenly spaced positions cannot distinguish from the found one, but that is in the machine file or usual for screws.
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
        let pitches = self.pitches(axis).filter(|pitch| !aliases.is_empty() && is_near(*pitch));
        let mut all = pitches.map(|pitch| periodic::candidate(name, axis, pitch));
        // If two steps equal a period, sine and cosine are the same column, and the amplitude is arbitrary.
        let amplitude = |one: &Candidate| {
            let (amounts, _) = series.amounts(&self.columns(one));
            amounts.iter().map(|amount| amount * amount).sum::<f64>().sqrt()
        };
        let most = LARGER * amplitude(one);
        all.find(|other| own - series.gain(&self.columns(other)).squares < RIVAL * noise && amplitude(other) < most)
    }

    /// The candidate with the largest gain between `low` and `high`, if it gains more than the middle one.
    fn best_near(
        &self,
        series: &Series,
        [low, middle, high]: [f64; 3],
        with: &dyn Fn(f64) -> Option<Candidate>,
    ) -> Option<Candidate> {
        let gain = |at: f64| with(at).map_or(0.0, |one| series.gain(&self.columns(&one)).squares);
        let (best, most) = peak(low, high, REFINED * (high - low), TRIALS, &gain);
        with(best).filter(|_| most > gain(middle))
    }
}
