//! Selects the sensor of an effect: every sensor gets its own best time constant. The time constants of the first pass are coarse, and can favor one sensor
//! by chance.

use std::collections::BTreeMap;

use super::cause::Candidate;
use super::search::{Field, Weights};
use ncfix_base::numeric::{Series, in_parts};

/// Maximum number of sensors that are compared.
const MOST: usize = 4;
/// Minimum evidence of their best candidates, as a share of the best of all.
const SHARE: f64 = 0.6;

/// Number of rounds in which the time constants are optimized in turn.
const ROUNDS: usize = 2;

impl Field<'_, '_> {
    /// Optimizes the time constants of the terms after the first `kept` again, each with all others in the model. The first ones were found before the later
    /// terms.
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

    /// Returns the best candidate for the effect of a term that depends on a sensor, over sensors and time constants; `open` has the evidence of each
    /// candidate.
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
