//! Selects the most probable explanation of the readings: the result of the search, or another set of terms.
//!
//! All terms compete in one comparison ([`super::explain`]): errors of axes in the form in which each has one name, and every candidate of the
//! registry. The result of the search is one of its starts. A set that is certainly more probable replaces it.

use std::collections::HashMap;

use super::cause::{Candidate, CauseId, EffectKind, Weight, motion};
use super::entrant::{EntrantSource, NamedEntrant, family, group, is_of_rotary, is_slope};
use super::harm::Harm;
use super::next::{self, NextMeasurement};
use super::search::{Field, Weights};
use super::twins::Twins;
use super::volume::Volume;
use crate::diagnose::explain::assumptions::Family;
use crate::diagnose::explain::contest::{Contest, Entrant, Outside, contest};
use crate::diagnose::explain::likelihood::ColumnGroup;
use crate::diagnose::explain::search::Explanation;
use crate::diagnose::explain::term;

/// Another set replaces the result of the search if its score is higher by this: 100 times as probable, as a natural logarithm.
const SURELY: f64 = 4.6;
/// The result of the search is also replaced if one of its terms is less probable than this.
const UNLIKELY: f64 = 0.02;
/// A term is named if it has at least this probability: more than all its alternatives together.
pub(super) const NAMED: f64 = 0.5;
/// A term is certain if the score falls by at least this without it and without a replacement, as a natural logarithm: a factor of 1000.
const SHOWN: f64 = 6.9;
/// The limit for a term that the search on the readings did not find: a factor of 10,000.
const SHOWN_NEW: f64 = 9.2;
/// A wave with one period is named from this probability; untested periods may be possible too.
const NAMED_WAVE: f64 = 0.9;
/// Approximate number of candidates that the search on the readings could also have found.
const SOUGHT: f64 = 100.0;

/// Maximum number of reported explanations.
pub(super) const MOST_SHOWN: usize = 20;

/// True for an effect about which the comparison decides. The likelihood models neither errors of single positions nor sensors with lags. So among waves,
/// temperatures and times it only judges results of the search.
pub(super) fn decides(effect: EffectKind) -> bool {
    matches!(
        effect,
        EffectKind::Location
            | EffectKind::Motion
            | EffectKind::Backlash
            | EffectKind::LateralPlay
            | EffectKind::Cross
            | EffectKind::ReversalSpike
            | EffectKind::ServoMismatch
            | EffectKind::Following
            | EffectKind::Setup
            | EffectKind::Earlier
            | EffectKind::Probe
            | EffectKind::Unknown
            | EffectKind::Own(_)
    )
}

/// A term with its probability.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    /// Index of its candidate.
    pub(super) candidate: usize,
    /// Sum of the probabilities of all explanations with it or a twin.
    pub(super) probability: f64,
    /// Its share among its twins.
    pub(super) share: f64,
    /// Its alternatives, if a correction of it would increase the error with them.
    pub(super) harmful: Option<Vec<CauseId>>,
    /// Probability that the readings show this much of it if it is absent.
    pub(super) chance: f64,
    /// Variance of its amount between the explanations that contain it, mm², rad²; 0 for a term with several columns.
    pub(super) between: f64,
}

impl Chosen {
    /// True if it is not refuted by its alternatives.
    pub(super) fn is_likely(&self) -> bool {
        self.probability >= UNLIKELY
    }
}

/// Share of the probability that an interval of 95 % leaves out: amounts of improbable explanations that are far from the others. As a variance they would
/// widen it although it contains more than 95 % without them.
const LEFT_OUT: f64 = 0.01;

/// Variance of values with weights, without the farthest ones of little weight; 0 without any weight.
fn variance(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut values: Vec<(f64, f64)> = values.filter(|(_, weight)| *weight > 0.0).collect();
    let Some(&(middle, _)) = values.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return 0.0 };
    let sum = |values: &[(f64, f64)]| values.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut rest = LEFT_OUT * sum(&values);
    values.sort_by(|a, b| (b.0 - middle).abs().total_cmp(&(a.0 - middle).abs()));
    let is_far = |(_, weight): &&(f64, f64)| {
        rest -= weight;
        rest >= 0.0
    };
    let far = values.iter().take_while(is_far).count();
    let kept = values.split_off(far);
    let whole = sum(&kept);
    let mean = kept.iter().map(|(value, weight)| weight * value).sum::<f64>() / whole;
    kept.iter().map(|(value, weight)| weight * (value - mean).powi(2)).sum::<f64>() / whole
}

/// One explanation as text.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExplanationSummary {
    /// Its terms: effect and parameter, as `location EC0X`.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>"))]
    pub terms: Vec<CauseId>,
    /// Its probability among all explanations.
    pub probability: f64,
}

impl ExplanationSummary {
    /// Returns the texts of its terms with a separator between them; empty if it is noise alone.
    #[must_use]
    pub fn joined(&self, separator: &str) -> String {
        self.terms.iter().map(ToString::to_string).collect::<Vec<_>>().join(separator)
    }
}

/// The outcome.
#[derive(Clone, Debug, Default)]
pub(super) struct ContestOutcome {
    /// Terms of the most probable explanation, if it replaces the result of the search.
    pub(super) instead: Option<Vec<Chosen>>,
    /// True if all of its terms are named.
    pub(super) is_whole: bool,
    /// Terms of the search.
    pub(super) of_taken: Vec<Chosen>,
    /// The most probable explanations.
    pub(super) explanations: Vec<ExplanationSummary>,
    /// Probability that there is no cause, only noise; `None` if nothing was compared.
    pub(super) nothing: Option<f64>,
    /// Measurements that separate the explanations.
    pub(super) next: Vec<NextMeasurement>,
}

impl Field<'_, '_> {
    /// Adds the effects of unit deviations on the readings that are not known yet.
    pub(super) fn know(&mut self, one: &Candidate) {
        let scene = self.scene;
        for (through, _) in one.columns.iter().flatten() {
            self.factors.entry(*through).or_insert_with(|| std::sync::Arc::new(scene.factors(*through)));
        }
    }

    /// True if a term is named: by the probability of all its variants, a wave by that of its own period.
    fn is_named(&self, source: &EntrantSource, of_all: f64, of_own: f64, taken: &[usize]) -> bool {
        let EntrantSource::Known(number) = source else { return of_all >= NAMED };
        let one = &self.candidates[*number];
        let is_of_places = decides(one.cause.effect);
        let key = source.key(self);
        let is_same = |&other: &usize| EntrantSource::Known(other).key(self) == key;
        let from = if one.cause.effect == EffectKind::Periodic { NAMED_WAVE } else { NAMED };
        let probability = if one.cause.effect == EffectKind::Periodic { of_own } else { of_all };
        probability >= from && (is_of_places || taken.iter().any(is_same))
    }

    /// Smallest decrease of the score without a named term.
    fn shown(&self, source: &EntrantSource, taken: &[usize]) -> f64 {
        let key = source.key(self);
        if taken.iter().any(|&other| EntrantSource::Known(other).key(self) == key) { SHOWN } else { SHOWN_NEW }
    }

    /// Runs the comparison. Candidates of the outcome are added to the field.
    pub(super) fn contest(&mut self, weights: &Weights, taken: &[usize], volume: Option<&Volume>) -> ContestOutcome {
        let mut named: Vec<NamedEntrant> = Vec::new();
        let mut is_in: Vec<bool> = vec![false; self.candidates.len()];
        let mut place_of: Vec<Option<usize>> = Vec::new();
        for one in term::terms(self.scene) {
            let (before, parent) = (named.len(), one.parent);
            self.enter(one, &mut named, &mut is_in);
            place_of.push((named.len() > before).then_some(before));
            if let Some(last) = named.get_mut(before) {
                last.entrant.parent = parent.and_then(|parent| place_of.get(parent).copied().flatten());
            }
        }
        let mut outside: Vec<usize> = Vec::new();
        let mut counts: HashMap<(Family, EffectKind, &str), f64> = HashMap::new();
        for (number, one) in self.candidates.iter().enumerate() {
            *counts.entry((family(one), one.cause.effect, one.parameter.as_str())).or_insert(0.0) += 1.0;
            // These are represented by shapes over the travel.
            let is_shape = one.cause.effect == EffectKind::Motion && !is_of_rotary(one);
            let is_location = one.cause.effect == EffectKind::Location;
            if !is_in[number] && !is_shape && !is_location && !self.bows.contains(&number) && !taken.contains(&number) {
                outside.push(number);
            }
        }
        let log_odds = |number: usize| {
            let one = &self.candidates[number];
            let count = counts.get(&(family(one), one.cause.effect, one.parameter.as_str())).copied().unwrap_or(1.0);
            family(one).assumption().odds.ln() - count.ln()
        };
        for &number in taken.iter().filter(|&&number| !is_in[number]) {
            let is_sought = number >= self.bows.end;
            let entrant = Entrant {
                group: group(self, &self.candidates[number]),
                log_odds: log_odds(number) - if is_sought { SOUGHT.ln() } else { 0.0 },
                parent: None,
                is_simple: false,
            };
            named.push(NamedEntrant { candidate: EntrantSource::Known(number), entrant });
        }
        let start: Option<Vec<usize>> = taken
            .iter()
            .map(|&number| {
                named.iter().position(|one| matches!(one.candidate, EntrantSource::Known(own) if own == number))
            })
            .collect();
        let start = start.unwrap_or_default();
        let found = contest(
            self.scene,
            &weights.items,
            named.iter().map(|one| one.entrant.clone()).collect(),
            &Outside {
                count: outside.len(),
                log_odds: &|k| log_odds(outside[k]),
                group: &|k| group(self, &self.candidates[outside[k]]),
            },
            std::slice::from_ref(&start),
        );
        let joined = found.joined.iter().map(|&k| EntrantSource::Known(outside[k]));
        let sources: Vec<EntrantSource> = named.into_iter().map(|one| one.candidate).chain(joined).collect();
        self.outcome(&found, &sources, (&start, taken, volume))
    }

    /// Adds a term: as its candidate if there is one, else as a shape.
    fn enter(&mut self, one: term::Term, named: &mut Vec<NamedEntrant>, is_in: &mut [bool]) {
        let name = one.component.to_string();
        let is_simple = one.family.is_simple();
        let log_odds = (one.share * one.family.assumption().odds).ln();
        let known = |effect: EffectKind, is_one: &dyn Fn(&Candidate) -> bool| {
            let fits = |own: &Candidate| {
                own.cause.effect == effect && own.parameter == name && own.columns.len() == 1 && is_one(own)
            };
            self.candidates.iter().position(fits)
        };
        let number = match one.family {
            Family::Squareness | Family::Tilt | Family::Offset => known(EffectKind::Location, &|_| true),
            Family::Scale => known(EffectKind::Motion, &|own| is_slope(own)),
            Family::Backlash => known(EffectKind::Backlash, &|_| true),
            Family::LateralPlay | Family::AngularPlay => known(EffectKind::LateralPlay, &|_| true),
            // Lags and products are candidates of the registry.
            Family::Lag | Family::Cross | Family::CrossAngle => return,
            _ => None,
        };
        let Some(number) = number else {
            if matches!(one.family, Family::Positioning | Family::Straightness | Family::Angle | Family::Rotary) {
                let axis = one.component.axis().map_or_else(String::new, |axis| axis.to_string());
                let shape =
                    Candidate::one(&motion::CAUSE, one.component, one.through(), self.weight_without_mean(&one));
                let shape = shape.driven_by(&[&axis]);
                self.know(&shape);
                let group = ColumnGroup::one(self.columns(&shape).remove(0), one.size);
                let entrant = Entrant { group, log_odds, parent: None, is_simple };
                named.push(NamedEntrant { candidate: EntrantSource::Shape(Box::new(shape)), entrant });
            }
            return;
        };
        let candidate = &self.candidates[number];
        let column = self.columns(candidate).remove(0);
        // In the unit of the candidate.
        let size = match one.family {
            Family::Scale => Family::Scale.size(2.0),
            Family::Backlash | Family::LateralPlay | Family::AngularPlay => 0.5 * one.size,
            _ => one.size,
        };
        is_in[number] = true;
        let entrant = Entrant { group: ColumnGroup::one(column, size), log_odds, parent: None, is_simple };
        named.push(NamedEntrant { candidate: EntrantSource::Known(number), entrant });
    }

    /// The weight of a shape. If set-ups have unknowns, the mean of a displacement over the measured positions is subtracted: it belongs to the zero. So is
    /// that of an angle of a rotary axis: it belongs to the orientation of the next axis.
    fn weight_without_mean(&self, one: &term::Term) -> Weight {
        let weight = one.weight.clone();
        let is_of_rotary = one.component.axis().is_some_and(|axis| axis.is_rotary());
        let has_no_mean = match one.component.direction.is_rotation() {
            true => is_of_rotary,
            false => self.scene.unknowns > 0,
        };
        if !has_no_mean {
            return weight;
        }
        let count = self.scene.rows.len().max(1) as f64;
        let mean = self.scene.rows.iter().map(|row| weight.of(row)).sum::<f64>() / count;
        Weight::new(move |row| weight.of(row) - mean)
    }

    fn outcome(
        &mut self,
        found: &Contest,
        sources: &[EntrantSource],
        (start, taken, volume): (&[usize], &[usize], Option<&Volume>),
    ) -> ContestOutcome {
        let Some(first) = found.explanations.first() else { return ContestOutcome::default() };
        let same =
            |number: usize| found.alike.iter().find(|(one, _)| *one == number).map_or(number, |(_, other)| *other);
        // Variants of one cause count together, such as shapes of an unknown cause or lags of a drift.
        let probability = |k: usize| -> f64 {
            let Some(source) = sources.get(k) else { return 0.0 };
            let key = source.key(self);
            let has = |one: &&Explanation| {
                one.set.iter().any(|&other| sources.get(other).is_some_and(|other| other.key(self) == key))
            };
            // Rounding must not make a sum of probabilities exceed 1.
            found.explanations.iter().filter(has).map(|one| one.probability).fold(0.0, |sum, one| sum + one).min(1.0)
        };
        let twins = Twins::new(self, found, sources, volume);
        // Sets that differ only in variants of a cause are reported as one explanation.
        let mut explanations: Vec<ExplanationSummary> = Vec::new();
        for one in &found.explanations {
            for (way, share) in twins.ways(&one.set) {
                let terms = way.iter().filter_map(|twin| sources.get(twin.entrant)).map(|one| one.id(self));
                let terms = CauseId::in_order(terms.collect());
                let probability = share * one.probability;
                match explanations.iter_mut().find(|known| known.terms == terms) {
                    Some(known) => known.probability = (known.probability + probability).min(1.0),
                    None => explanations.push(ExplanationSummary { terms, probability }),
                }
            }
        }
        explanations.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        // One that is not listed has a probability below that of the least one that the comparison keeps.
        let nothing = explanations.iter().find(|one| one.terms.is_empty()).map_or(0.0, |one| one.probability);
        explanations.truncate(MOST_SHOWN);
        let next = next::measurements(self, found, sources, &twins);
        let harm = Harm::new(self, found, sources, volume);
        let said = |k: usize, is_new: bool| -> Option<Vec<CauseId>> {
            Some(harm.of(k, is_new)?.iter().filter_map(|&k| sources.get(k)).map(|one| one.id(self)).collect())
        };
        let between = |k: usize| -> f64 {
            if found.widths.get(k) != Some(&1) {
                return 0.0;
            }
            let amount = |one: &Explanation| -> Option<f64> {
                let place = one.set.iter().position(|&own| own == k)?;
                let before: usize = one.set.iter().take(place).filter_map(|own| found.widths.get(*own)).sum();
                one.posterior.mean.get(before).copied()
            };
            variance(found.explanations.iter().filter_map(|one| Some((amount(one)?, one.probability))))
        };
        let of_taken: Vec<Chosen> = start
            .iter()
            .zip(taken)
            .map(|(&k, &candidate)| Chosen {
                candidate,
                probability: probability(same(k)),
                share: twins.share(k),
                harmful: said(same(k), false),
                chance: 0.0,
                between: between(same(k)),
            })
            .collect();
        let keys = |sources: &mut dyn Iterator<Item = EntrantSource>| {
            let mut keys: Vec<(EffectKind, String)> = sources.map(|one| one.key(self)).collect();
            keys.sort();
            keys
        };
        // Only typical sizes separate offsets and tilts with equal effects.
        let is_offset = |one: &Chosen| matches!(family(&self.candidates[one.candidate]), Family::Offset | Family::Tilt);
        let is_of_places = |&number: &usize| {
            let effect = self.candidates[number].cause.effect;
            matches!(effect, EffectKind::Location | EffectKind::Motion | EffectKind::Backlash | EffectKind::LateralPlay)
        };
        let is_variant = !taken.iter().all(is_of_places)
            && keys(&mut first.set.iter().filter_map(|&k| sources.get(k).cloned()))
                == keys(&mut taken.iter().map(|&number| EntrantSource::Known(number)));
        let is_better = found.behind.first().is_some_and(|behind| *behind < -SURELY)
            || of_taken.iter().any(|one: &Chosen| !one.is_likely() || (is_offset(one) && one.probability < NAMED));
        // The search handles variants of one cause better: it refines their constants.
        let is_better = is_better && !is_variant;
        let decided = is_better.then(|| {
            let mut chosen: Vec<Chosen> = Vec::new();
            // Shapes of one component form one candidate, which gets its index at the end.
            let mut shapes: Vec<(Candidate, Chosen)> = Vec::new();
            for (&k, loss) in first.set.iter().zip(&found.losses) {
                let probability = probability(k);
                let Some(source) = sources.get(k).filter(|source| {
                    self.is_named(source, probability, found.probability(k), taken)
                        && *loss >= self.shown(source, taken)
                }) else {
                    continue;
                };
                let (harmful, chance, share) = (said(k, true), (-loss).exp(), twins.share(k));
                let one = Chosen {
                    candidate: self.candidates.len(),
                    probability,
                    share,
                    harmful,
                    chance,
                    between: between(k),
                };
                match source {
                    EntrantSource::Known(number) => chosen.push(Chosen { candidate: *number, ..one }),
                    EntrantSource::Shape(shape) => {
                        match shapes.iter_mut().find(|(own, _)| own.parameter == shape.parameter) {
                            Some((own, all)) => {
                                own.columns.extend(shape.columns.iter().cloned());
                                all.chance = all.chance.max(one.chance);
                                all.probability = all.probability.min(one.probability);
                                all.share = all.share.min(one.share);
                                all.harmful = all.harmful.take().or(one.harmful);
                                all.between = 0.0;
                            }
                            None => shapes.push(((**shape).clone(), one)),
                        }
                    }
                }
            }
            (chosen, shapes)
        });
        let is_whole = first.set.iter().zip(&found.losses).all(|(&k, loss)| {
            sources.get(k).is_some_and(|one| {
                self.is_named(one, probability(k), found.probability(k), taken) && *loss >= self.shown(one, taken)
            })
        });
        let instead = decided.map(|(mut chosen, shapes)| {
            for (shape, one) in shapes {
                chosen.push(Chosen { candidate: self.candidates.len(), ..one });
                self.candidates.push(shape);
            }
            chosen
        });
        ContestOutcome { instead, is_whole, of_taken, explanations, nothing: Some(nothing), next }
    }
}

#[cfg(test)]
mod tests {
    use super::variance;

    #[test]
    fn a_variance_weighs_its_values() {
        // Mean 2.5: 0.25 · 1.5² + 0.75 · 0.5² = 0.75; weights need not sum to 1.
        assert!((variance([(1.0, 0.5), (3.0, 1.5)].into_iter()) - 0.75).abs() < 1e-12);
        assert_eq!(variance(std::iter::empty()), 0.0);
        // An explanation of 0.4 % is left out, one of 2 % is not: 0.98 · 0.02 · 2.5² = 0.1225.
        assert!(variance([(2.5, 0.004), (5.0, 0.996)].into_iter()).abs() < 1e-12);
        assert!((variance([(5.0, 0.98), (2.5, 0.02)].into_iter()) - 0.1225).abs() < 1e-12);
        assert_eq!(variance([(2.0, 0.3)].into_iter()), 0.0);
    }
}
