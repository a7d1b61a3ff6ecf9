//! The scale of one set-up of an instrument that may as well be that of another one.
//!
//! If a laser shows another scale in a second file, either of the two set-ups may have it. The scale of the machine then has one of two sizes, and the residual
//! is the same. So each other set-up takes the place of the one found, and every finding whose size changes with it shares its probability.
//!
//! The machine may have changed too: the scale of an axis follows its temperature and its maintenance. A scale that only one file shows, while another file
//! has the same error of the axis, is that change with exactly the same effect on the readings. The odds of both alone decide.

use super::cause::{CauseId, EffectKind, own, setup};
use super::entrant::family;
use super::explain::assumptions::Family;
use super::reversed::SAME;
use super::scene::Through;
use super::search::{Field, Weights};
use super::undecided::{LEAST, RivalCause};
use ncfix_model::name::ErrorName;

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

/// The error of an axis that may have changed between files.
struct ChangedScale {
    component: ErrorName,
    /// The change.
    cause: CauseId,
    /// True if one other file shows the error: nothing tells which of the two has the present scale.
    is_one_of_two: bool,
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
            let changed = self.changed(number);
            if rivals.is_empty() && changed.is_none() {
                continue;
            }
            let odds = |family: Family| family.assumption().odds;
            let of_change = if changed.is_some() { odds(Family::Expansion) / odds(Family::Setup) } else { 0.0 };
            let whole = 1.0 + of_change + rivals.iter().map(|(_, weight)| weight).sum::<f64>();
            let change = changed.map(|change| {
                let rival = RivalCause { cause: change.cause, probability: of_change / whole };
                (change.component, change.is_one_of_two, rival)
            });
            let of = |place: usize, weight: f64| {
                let cause = self.candidates.get(place)?.id();
                Some(RivalCause { cause, probability: weight / whole })
            };
            let all = rivals.iter().filter_map(|&(place, weight)| of(place, weight));
            let all = all.chain(change.iter().map(|(.., rival)| rival.clone())).collect();
            out.push(SwappedSetups { number, is_itself: true, rivals: all });
            let given = self.sizes(weights, (&others, number), memory);
            let with: Vec<Vec<Vec<f64>>> =
                rivals.iter().map(|&(place, _)| self.sizes(weights, (&others, place), memory)).collect();
            for (k, &other) in others.iter().enumerate() {
                let is_changed =
                    |with: &Vec<Vec<f64>>| given.get(k).zip(with.get(k)).is_some_and(|(a, b)| differ(a, b));
                let changing = rivals.iter().zip(&with).filter(|(_, with)| is_changed(with));
                // With another scale since, the present size of the same error is another one. If further files agree, they decide.
                let is_same = |name: ErrorName| {
                    let motion = self.candidates.get(other).filter(|one| one.cause.effect == EffectKind::Motion);
                    let parts = motion.and_then(|one| one.columns.first()?.first());
                    parts.is_some_and(|(through, _)| *through == Through::Component(name))
                };
                let of_change = change.iter().filter(|(name, is_one_of_two, _)| *is_one_of_two && is_same(*name));
                let of_change = of_change.map(|(.., rival)| rival.clone());
                let of_setups = changing.filter_map(|(&(place, weight), _)| of(place, weight));
                let rivals: Vec<RivalCause> = of_setups.chain(of_change).collect();
                if !rivals.is_empty() {
                    out.push(SwappedSetups { number: other, is_itself: false, rivals });
                }
            }
        }
        out
    }

    /// The change between files that has the effect of the scale of a set-up; `None` if no other file shows this error.
    fn changed(&self, number: usize) -> Option<ChangedScale> {
        let columns = self.columns_of(number);
        let rows =
            || self.scene.items.iter().enumerate().filter_map(|(k, item)| Some((k, self.scene.rows.get(item.row)?)));
        let is_inside = |k: usize| columns.iter().any(|column| column.get(k).is_some_and(|value| *value != 0.0));
        let (_, first) = rows().find(|(k, _)| is_inside(*k))?;
        let component = first.component?;
        let axis = component.axis().filter(|axis| !axis.is_rotary() && own(*axis) == component)?;
        let is_alone = rows().all(|(k, row)| !is_inside(k) || (row.set, row.component) == (first.set, first.component));
        let others = rows().filter(|(_, row)| row.set != first.set && row.component == Some(component));
        let mut others: Vec<usize> = others.map(|(_, row)| row.set).collect();
        others.sort_unstable();
        others.dedup();
        let file = &self.scene.sets.get(first.set)?.name;
        (is_alone && !others.is_empty()).then(|| ChangedScale {
            component,
            cause: CauseId::ChangedSlope(component, axis, file.clone()),
            is_one_of_two: others.len() == 1,
        })
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
