//! Which of several sensors it is: each with its own best time constant, since the ones that are tried first are far apart and suit one by chance.

use std::collections::BTreeMap;

use super::cause::Candidate;
use super::search::{Field, Weights};
use ncfix_base::numeric::{Series, in_parts};

/// Sensors that are looked at.
const MOST: usize = 4;
/// Their best candidates are worth this share of the best of all at least.
const SHARE: f64 = 0.6;

/// Rounds in which time constants are found again beside each other.
const ROUNDS: usize = 2;

impl Field<'_, '_> {
    /// Finds the time constants of those that were taken behind the first `kept` again, each beside all others: the first ones were found while what
    /// the later ones explain was still there.
    pub(super) fn polish(&mut self, weights: &Weights, taken: &mut [usize], kept: usize) {
        let has_lag = |one: &Candidate| one.sensor.is_some() && one.constant.is_some();
        if taken.len() < 2 {
            return;
        }
        for _ in 0..ROUNDS {
            for place in kept..taken.len() {
                let Some(number) = taken.get(place).copied().filter(|&k| self.candidates.get(k).is_some_and(has_lag))
                else {
                    continue;
                };
                let others: Vec<usize> = taken.iter().copied().filter(|&other| other != number).collect();
                let series = self.series(weights, &others, 0.0);
                let Some(refined) = self.refined(number, &series) else { continue };
                self.candidates.push(refined);
                if let Some(own) = taken.get_mut(place) {
                    *own = self.candidates.len() - 1;
                }
            }
        }
    }

    /// The best candidate for the effect of one that goes with a sensor, over sensors and time constants; `open` has what each candidate is worth.
    pub(super) fn best_sensor(&self, number: usize, open: &[(f64, usize)], series: &Series) -> Option<Candidate> {
        let one = self.candidates.get(number)?;
        one.sensor.as_ref()?;
        let is_rival = |other: &Candidate| {
            other.cause.name == one.cause.name
                && other.parameter == one.parameter
                && other.drivers.len() == one.drivers.len()
                && other.columns.len() == one.columns.len()
        };
        let mut of_sensors: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
        for &(worth, other) in open {
            let Some(sensor) =
                self.candidates.get(other).filter(|other| is_rival(other)).and_then(|other| other.sensor.as_deref())
            else {
                continue;
            };
            let own = of_sensors.entry(sensor).or_insert((worth, other));
            if worth > own.0 {
                *own = (worth, other);
            }
        }
        let mut best: Vec<(f64, usize)> = of_sensors.into_values().collect();
        best.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let least = SHARE * best.first()?.0;
        best.truncate(MOST);
        best.retain(|(worth, _)| *worth >= least);
        let refined = in_parts(&best, &|&(_, other): &(f64, usize)| {
            let own = self.refined(other, series).or_else(|| self.candidates.get(other).cloned())?;
            Some((series.gain(&self.columns(&own)).squares, own))
        });
        refined.into_iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, own)| own)
    }
}
