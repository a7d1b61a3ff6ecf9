//! The scale of one set-up of an instrument that may as well be that of another one.
//!
//! If a laser shows another scale in a second file, either of the two set-ups may have it. The scale of the machine then has one of two sizes, and the residual
//! is the same. So each other set-up takes the place of the one found, and every finding whose size changes with it shares its probability.

use super::cause::setup;
use super::entrant::family;
use super::reversed::SAME;
use super::search::{Field, Weights};
use super::undecided::{LEAST, RivalCause};

/// A finding whose cause or size depends on which set-up is wrong.
#[derive(Clone, Debug)]
pub(super) struct SwappedSetups {
    /// Its candidate.
    pub(super) number: usize,
    /// True if it is the scale of the set-up, false if its size depends on it.
    pub(super) is_itself: bool,
    /// The other set-ups, with their shares.
    pub(super) rivals: Vec<RivalCause>,
}

impl Field<'_, '_> {
    /// Returns the findings that depend on the choice between set-ups. `noise` is the variance of the readings.
    pub(super) fn swapped(
        &self,
        weights: &Weights,
        taken: &[usize],
        (memory, noise): (f64, f64),
    ) -> Vec<SwappedSetups> {
        let is_scale =
            |number: usize| self.candidates.get(number).is_some_and(|one| one.cause.name == setup::SCALE.name);
        let mut out: Vec<SwappedSetups> = Vec::new();
        for &number in taken.iter().filter(|number| is_scale(**number)) {
            let others: Vec<usize> = taken.iter().copied().filter(|&other| other != number).collect();
            let series = self.series(weights, &others, memory);
            let noise = noise * self.inflation(weights, taken, &others, number);
            // Schwarz (1978): each further column must gain this much.
            let price = (series.count().max(2) as f64).ln();
            let worth = |place: usize| {
                let gain = series.gain(&self.columns_of(place));
                let odds = self.candidates.get(place).map_or(1.0, |one| family(one).assumption().odds);
                (gain.rank > 0)
                    .then(|| gain.squares / noise.max(f64::MIN_POSITIVE) - price * gain.rank as f64 + 2.0 * odds.ln())
            };
            let Some(own) = worth(number) else { continue };
            let rest = (0..self.candidates.len()).filter(|&place| is_scale(place) && !taken.contains(&place));
            let rivals: Vec<(usize, f64)> = rest
                .filter_map(|place| Some((place, (0.5 * (worth(place)? - own)).exp())))
                .filter(|(_, weight)| *weight >= LEAST)
                .collect();
            if rivals.is_empty() {
                continue;
            }
            let whole = 1.0 + rivals.iter().map(|(_, weight)| weight).sum::<f64>();
            let of = |place: usize, weight: f64| {
                let cause = self.candidates.get(place)?.title();
                Some(RivalCause { cause, probability: weight / whole })
            };
            let all = rivals.iter().filter_map(|&(place, weight)| of(place, weight)).collect();
            out.push(SwappedSetups { number, is_itself: true, rivals: all });
            let given = self.sizes(weights, (&others, number), memory);
            let with: Vec<Vec<Vec<f64>>> =
                rivals.iter().map(|&(place, _)| self.sizes(weights, (&others, place), memory)).collect();
            for (k, &other) in others.iter().enumerate() {
                let is_changed =
                    |with: &Vec<Vec<f64>>| given.get(k).zip(with.get(k)).is_some_and(|(a, b)| differ(a, b));
                let changing = rivals.iter().zip(&with).filter(|(_, with)| is_changed(with));
                let rivals: Vec<RivalCause> = changing.filter_map(|(&(place, weight), _)| of(place, weight)).collect();
                if !rivals.is_empty() {
                    out.push(SwappedSetups { number: other, is_itself: false, rivals });
                }
            }
        }
        out
    }

    /// Amounts of the columns of some terms, together with one more.
    fn sizes(&self, weights: &Weights, (terms, more): (&[usize], usize), memory: f64) -> Vec<Vec<f64>> {
        let columns: Vec<Vec<Vec<f64>>> =
            terms.iter().copied().chain([more]).map(|number| self.columns_of(number)).collect();
        let flat: Vec<Vec<f64>> = columns.iter().flatten().cloned().collect();
        let mut amounts = self.series(weights, &[], memory).amounts(&flat).0.into_iter();
        columns.iter().map(|own| amounts.by_ref().take(own.len()).collect()).collect()
    }
}

/// True if amounts differ by a considerable share of their size.
fn differ(one: &[f64], other: &[f64]) -> bool {
    let squares: f64 = one.iter().map(|amount| amount * amount).sum();
    let apart: f64 = one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum();
    apart > SAME * SAME * squares
}
