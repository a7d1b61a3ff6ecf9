//! Selects the most probable explanation of the readings: the result of the search, or another set of terms.
//!
//! All terms compete in one comparison ([`super::explain`]): errors of axes in the form in which each has one name, and every candidate of the
//! register. The result of the search is one of its starts. A set that is certainly more probable replaces it.

use std::collections::HashMap;

use super::cause::{Candidate, EffectKind, Term, Weight, motion, servo, setup};
use super::scene::Through;
use super::search::{Field, Weights};
use super::volume::Volume;
use crate::diagnose::explain::assumptions::Family;
use crate::diagnose::explain::contest::{Contest, Entrant, Outside, contest};
use crate::diagnose::explain::likelihood::ColumnGroup;
use crate::diagnose::explain::search::Explanation;
use crate::diagnose::explain::term;
use ncfix_base::numeric::sums::dot;
use ncfix_model::name::ErrorName;
use ncfix_model::parameter::ComponentTerm;

/// Another set replaces the result of the search if its score is higher by this: 100 times as probable, as a natural logarithm.
const SURELY: f64 = 4.6;
/// The result of the search is also replaced if one of its terms is less probable than this.
const UNLIKELY: f64 = 0.02;
/// A term is named if it has at least this probability: more than all its alternatives together.
const NAMED: f64 = 0.5;
/// A term is certain if the score falls by at least this without it and without a replacement, as a natural logarithm: a factor of 1000.
const SHOWN: f64 = 6.9;
/// The limit for a term that the search on the readings did not find: a factor of 10,000.
const SHOWN_NEW: f64 = 9.2;
/// A wave with one period is named from this probability; untested periods may be possible too.
const NAMED_WAVE: f64 = 0.9;
/// A correction is refused if it would increase the error with more than this probability.
const HARMFUL: f64 = 0.1;
/// The limit for explanations that no reading separates from the first one: only typical sizes argue against them.
const HARMFUL_ALIKE: f64 = 0.01;
/// A correction helps if its residual is less than this share of the error.
const LEAVES: f64 = 0.8;
/// Two explanations fit the readings equally if their sums of squared residuals differ by less than this, in variances.
const ALIKE: f64 = 0.02;
/// Approximate number of candidates that the search on the readings could also have found.
const SOUGHT: f64 = 100.0;

/// Maximum number of reported explanations.
const MOST_SHOWN: usize = 20;

/// A term with its probability.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    /// Index of its candidate.
    pub(super) candidate: usize,
    /// Sum of the probabilities of all explanations with it.
    pub(super) probability: f64,
    /// Names of its alternatives, if a correction of it would increase the error with them.
    pub(super) harmful: Option<Vec<String>>,
    /// Probability that the readings show this much of it if it is absent.
    pub(super) chance: f64,
}

impl Chosen {
    /// True if it is not refuted by its alternatives.
    pub(super) fn is_likely(&self) -> bool {
        self.probability >= UNLIKELY
    }
}

/// One explanation as text.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExplanationSummary {
    /// Its terms: effect and parameter, as `location EC0X`.
    pub terms: Vec<String>,
    /// Its probability among all explanations.
    pub probability: f64,
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
}

impl Source {
    /// Effect and parameter: variants of one cause share a name.
    fn key(&self, field: &Field<'_, '_>) -> (EffectKind, String) {
        let one = match self {
            Source::Known(number) => &field.candidates[*number],
            Source::Shape(one) => one,
        };
        (one.cause.effect, one.parameter.clone())
    }
}

/// Displacements by each explanation over the used volume.
struct Harm<'f> {
    found: &'f Contest,
    /// By explanation: the field, mm.
    fields: Vec<Vec<f64>>,
    /// By entrant of the first explanation: its displacements, mm.
    own: HashMap<usize, Vec<f64>>,
    /// Number of values for one tool.
    part: usize,
    /// By entrant: true for offsets and tilts of rotary axes and of the spindle, and true for shapes, which are written as tables.
    is_offset: Vec<bool>,
    is_shape: Vec<bool>,
    /// By entrant: true for shapes that are angles.
    is_angle: Vec<bool>,
    /// Effect and parameter of each entrant.
    keys: Vec<(EffectKind, String)>,
}

impl<'f> Harm<'f> {
    fn new(field: &'f Field<'_, '_>, found: &'f Contest, sources: &[Source], volume: Option<&Volume>) -> Harm<'f> {
        let mut units: HashMap<usize, Vec<Vec<f64>>> = HashMap::new();
        let mut of = |entrant: usize| -> Vec<Vec<f64>> {
            let make = || match (volume, sources.get(entrant)) {
                (Some(volume), Some(Source::Known(number))) => {
                    let one = &field.candidates[*number];
                    let moves = matches!(
                        one.cause.effect,
                        EffectKind::Location | EffectKind::Motion | EffectKind::Cross | EffectKind::Periodic
                    );
                    if moves { volume.fields(one, false) } else { Vec::new() }
                }
                // The file stores it as a table, which is constant beyond the measured range; an angle also acts beyond it, by its arm.
                (Some(volume), Some(Source::Shape(one))) => {
                    let is_angle = one.parameter.parse::<ErrorName>().is_ok_and(|name| name.direction.is_rotation());
                    volume.fields(one, !is_angle)
                }
                _ => Vec::new(),
            };
            units.entry(entrant).or_insert_with(make).clone()
        };
        let mut own = HashMap::new();
        let mut fields = Vec::new();
        for (rank, one) in found.explanations.iter().enumerate() {
            let mut all: Vec<f64> = Vec::new();
            let mut amounts = one.posterior.mean.iter();
            for &entrant in &one.set {
                let columns = of(entrant);
                let width = found.widths.get(entrant).copied().unwrap_or(1);
                let mut mine: Vec<f64> = Vec::new();
                for (k, amount) in amounts.by_ref().take(width).enumerate() {
                    if let Some(column) = columns.get(k) {
                        mine.resize(column.len(), 0.0);
                        mine.iter_mut().zip(column).for_each(|(sum, value)| *sum += amount * value);
                    }
                }
                if !mine.is_empty() {
                    all.resize(mine.len(), 0.0);
                    all.iter_mut().zip(&mine).for_each(|(sum, value)| *sum += value);
                }
                if rank == 0 {
                    own.insert(entrant, mine);
                }
            }
            fields.push(all);
        }
        let part = volume.map_or(1, Volume::numbers_of_a_tool).max(1);
        let keys = sources.iter().map(|source| source.key(field)).collect();
        let is_offset = |source: &Source| match source {
            Source::Known(number) => matches!(family(&field.candidates[*number]), Family::Offset | Family::Tilt),
            Source::Shape(_) => false,
        };
        let is_shape = |source: &Source| matches!(source, Source::Shape(_));
        let [is_offset, is_shape] =
            [sources.iter().map(is_offset).collect(), sources.iter().map(is_shape).collect::<Vec<bool>>()];
        let is_angle = |source: &Source| {
            let Source::Shape(one) = source else { return false };
            one.parameter.parse::<ErrorName>().is_ok_and(|name| name.direction.is_rotation())
        };
        let is_angle = sources.iter().map(is_angle).collect();
        Harm { found, fields, own, part, is_offset, is_shape, is_angle, keys }
    }

    /// True if a correction by a term of the first explanation also helps, with each tool, if another explanation is true.
    fn helps(&self, first: &[f64], own: &[f64], field: &[f64]) -> bool {
        let at = |values: &[f64], k: usize| values.get(k).copied().unwrap_or(0.0);
        // The alternative to the term: the difference of both explanations plus the term itself.
        let instead: Vec<f64> = (0..own.len()).map(|k| at(field, k) - at(first, k) + own[k]).collect();
        instead.chunks(self.part).zip(own.chunks(self.part)).all(|(instead, own)| {
            let left: f64 = instead.iter().zip(own).map(|(other, own)| (other - own).powi(2)).sum();
            left <= LEAVES * LEAVES * dot(instead, instead)
        })
    }

    /// Alternatives to a term of the first explanation, if correcting by that term would probably increase the error with them. A term found by the
    /// search has passed its own acceptance tests: unless it `is_new`, only explanations count that no reading separates.
    fn of(&self, entrant: usize, is_new: bool) -> Option<Vec<usize>> {
        let none = Vec::new();
        let (first, own) = (self.fields.first()?, self.own.get(&entrant).unwrap_or(&none));
        let square = dot(own, own);
        let best = self.found.explanations.first()?;
        let (mut harmful, mut harmful_alike) = (0.0, 0.0);
        let mut others: Vec<usize> = Vec::new();
        let all = self.found.explanations.iter().zip(&self.fields);
        for (one, field) in all.filter(|(one, _)| !one.set.contains(&entrant)) {
            let is_variant = |other: &usize| {
                !best.set.contains(other)
                    && self.keys.get(*other).zip(self.keys.get(entrant)).is_some_and(|(a, b)| a == b)
            };
            // Backlash has no displacements over the volume, and a shape is written only over the measured range: a variant is equivalent.
            let by_variant = square <= 0.0 || self.is_shape.get(entrant).copied().unwrap_or(false);
            let helps =
                (by_variant && one.set.iter().any(is_variant)) || (square > 0.0 && self.helps(first, own, field));
            if helps {
                continue;
            }
            harmful += one.probability;
            // Only tools of several lengths separate the offsets and tilts of rotary axes and of the spindle.
            let scale = best.posterior.scale;
            let is_same = |with: &&Explanation| {
                let apart = (one.posterior.misfit - with.posterior.misfit).abs() / (scale * scale);
                let others = with.set.iter().filter(|other| **other != entrant);
                apart < ALIKE
                    && one.set.len() == with.set.len()
                    && others.into_iter().all(|other| one.set.contains(other))
            };
            let mut with = self.found.explanations.iter().filter(|with| with.set.contains(&entrant));
            if self.is_offset.get(entrant).copied().unwrap_or(false) && with.any(|with| is_same(&with)) {
                harmful_alike += one.probability;
            }
            if others.is_empty() {
                others = one.set.iter().copied().filter(|other| !best.set.contains(other)).collect();
            }
        }
        // An angle acts by its arm far from where it was measured.
        let most = if self.is_angle.get(entrant).copied().unwrap_or(false) { HARMFUL_ALIKE } else { HARMFUL };
        ((is_new && harmful > most) || harmful_alike > HARMFUL_ALIKE).then_some(others)
    }
}

/// An entrant and its source.
struct Named {
    candidate: Source,
    entrant: Entrant,
}

/// Source of the candidate of an entrant.
#[derive(Clone, Debug)]
enum Source {
    /// Among the candidates of the field.
    Known(usize),
    /// A shape over the travel: an axis component with one column.
    Shape(Box<Candidate>),
}

/// The family of a candidate.
fn family(one: &Candidate) -> Family {
    let component = match one.columns.first().and_then(|parts| parts.first()) {
        Some((Through::Component(name), _)) => Some(*name),
        _ => None,
    };
    let is_angle = component.is_some_and(|name| name.direction.is_rotation());
    let is_rotary = component.and_then(|name| name.axis()).is_some_and(|axis| axis.is_rotary());
    match one.cause.effect {
        EffectKind::Location if component.is_some_and(|name| name.axis().is_some_and(|axis| !axis.is_rotary())) => {
            Family::Squareness
        }
        EffectKind::Location if is_angle => Family::Tilt,
        EffectKind::Location => Family::Offset,
        EffectKind::Motion if is_angle => Family::Angle,
        EffectKind::Motion if is_rotary => Family::Rotary,
        EffectKind::Motion
            if component.is_some_and(|name| name.axis().is_some_and(|axis| super::cause::own(axis) == name)) =>
        {
            Family::Positioning
        }
        EffectKind::Motion => Family::Straightness,
        EffectKind::Periodic => Family::Wave,
        EffectKind::Backlash => Family::Backlash,
        EffectKind::LateralPlay if is_angle => Family::AngularPlay,
        EffectKind::LateralPlay => Family::LateralPlay,
        EffectKind::ReversalSpike => Family::Spike,
        EffectKind::Cross if one.threshold.is_some() => Family::Threshold,
        EffectKind::Cross if is_angle => Family::CrossAngle,
        EffectKind::Cross => Family::Cross,
        EffectKind::ServoMismatch | EffectKind::Following | EffectKind::Delay => Family::Lag,
        EffectKind::Dynamic if is_by_acceleration(one) => Family::Deflection,
        EffectKind::Dynamic => Family::Dynamic,
        EffectKind::ThermalDrift | EffectKind::SpindleSpeed => Family::Drift,
        EffectKind::ThermalExpansion => Family::Expansion,
        EffectKind::ThermalSquareness => Family::ThermalSquareness,
        EffectKind::Drift => Family::Creep,
        EffectKind::Load => Family::Load,
        EffectKind::Setup if one.cause.name == setup::TOOL.name => Family::Probe,
        EffectKind::Setup => Family::Setup,
        EffectKind::Earlier => Family::Earlier,
        EffectKind::Probe => Family::Probe,
        EffectKind::Sensor | EffectKind::Outlier | EffectKind::Program | EffectKind::Unknown => Family::Unnamed,
        EffectKind::Own(_) => Family::Own,
    }
}

/// True for an angle, false for a displacement.
fn acts_as_angle(one: &Candidate) -> bool {
    let first = one.columns.first().and_then(|parts| parts.first());
    first.is_some_and(|(through, _)| matches!(through, Through::Component(name) if name.direction.is_rotation()))
}

/// True for a deflection that is proportional to the acceleration of an axis.
fn is_by_acceleration(one: &Candidate) -> bool {
    one.cause.name == servo::DYNAMIC.name
}

/// Columns of a candidate, each scaled to the typical size of its family at its maximum.
pub(super) fn group(field: &Field<'_, '_>, one: &Candidate) -> ColumnGroup {
    let columns = field.columns(one);
    let size = |parts: &Vec<(Through, Weight)>| {
        // The travel does not matter: the typical size is that of the maximum effect.
        let of = match family(one) {
            Family::Squareness | Family::Tilt | Family::Offset => return family(one).size(0.0),
            // Angles have their own typical size; displacements that differ between files do so as reversal values do.
            Family::Earlier if !acts_as_angle(one) => Family::Backlash.size(0.0),
            own @ (Family::Lag | Family::Deflection) => return own.size(0.0),
            other => other.size(1e3),
        };
        let largest = |(_, weight): &(Through, Weight)| {
            field.scene.rows.iter().map(|row| weight.of(row).abs()).fold(0.0, f64::max)
        };
        let most = parts.iter().map(largest).fold(0.0, f64::max);
        // A reversal value acts with half its size on either side.
        let share = if one.cause.effect == EffectKind::Backlash { 0.5 } else { 1.0 };
        if most > 0.0 { share * of / most } else { 0.0 }
    };
    let sizes = one.columns.iter().map(size).collect();
    let is_of_instrument = matches!(family(one), Family::Setup | Family::Probe);
    ColumnGroup { columns, sizes, is_of_instrument }
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
    fn is_named(&self, source: &Source, of_all: f64, of_own: f64, taken: &[usize]) -> bool {
        let Source::Known(number) = source else { return of_all >= NAMED };
        let one = &self.candidates[*number];
        // The likelihood models neither errors of single positions nor sensors with lags. So among waves, temperatures and times it only judges
        // results of the search.
        let is_of_places = matches!(
            one.cause.effect,
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
        );
        let key = source.key(self);
        let is_same = |&other: &usize| Source::Known(other).key(self) == key;
        let from = if one.cause.effect == EffectKind::Periodic { NAMED_WAVE } else { NAMED };
        let probability = if one.cause.effect == EffectKind::Periodic { of_own } else { of_all };
        probability >= from && (is_of_places || taken.iter().any(is_same))
    }

    /// Smallest decrease of the score without a named term.
    fn shown(&self, source: &Source, taken: &[usize]) -> f64 {
        let key = source.key(self);
        if taken.iter().any(|&other| Source::Known(other).key(self) == key) { SHOWN } else { SHOWN_NEW }
    }

    /// Runs the comparison. Candidates of the outcome are added to the field.
    pub(super) fn contest(&mut self, weights: &Weights, taken: &[usize], volume: Option<&Volume>) -> ContestOutcome {
        let mut named: Vec<Named> = Vec::new();
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
            named.push(Named { candidate: Source::Known(number), entrant });
        }
        let start: Option<Vec<usize>> = taken
            .iter()
            .map(|&number| named.iter().position(|one| matches!(one.candidate, Source::Known(own) if own == number)))
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
        let joined = found.joined.iter().map(|&k| Source::Known(outside[k]));
        let sources: Vec<Source> = named.into_iter().map(|one| one.candidate).chain(joined).collect();
        self.outcome(&found, &sources, (&start, taken, volume))
    }

    /// Adds a term: as its candidate if there is one, else as a shape.
    fn enter(&mut self, one: term::Term, named: &mut Vec<Named>, is_in: &mut [bool]) {
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
            // Lags and products are candidates of the register.
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
                named.push(Named { candidate: Source::Shape(Box::new(shape)), entrant });
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
        named.push(Named { candidate: Source::Known(number), entrant });
    }

    /// The weight of a shape. If set-ups have unknowns, the mean of a displacement over the measured positions is subtracted: it belongs to the zero.
    fn weight_without_mean(&self, one: &term::Term) -> Weight {
        let weight = one.weight.clone();
        if one.component.direction.is_rotation() || self.scene.unknowns == 0 {
            return weight;
        }
        let count = self.scene.rows.len().max(1) as f64;
        let mean = self.scene.rows.iter().map(|row| weight.of(row)).sum::<f64>() / count;
        Weight::new(move |row| weight.of(row) - mean)
    }

    fn outcome(
        &mut self,
        found: &Contest,
        sources: &[Source],
        (start, taken, volume): (&[usize], &[usize], Option<&Volume>),
    ) -> ContestOutcome {
        let Some(first) = found.explanations.first() else { return ContestOutcome::default() };
        let same =
            |number: usize| found.alike.iter().find(|(one, _)| *one == number).map_or(number, |(_, other)| *other);
        // Named as causes and their equivalent explanations are.
        let in_words = |source: &Source| {
            let (effect, parameter) = source.key(self);
            format!("{effect} {parameter}").trim_end().to_owned()
        };
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
        // Sets that differ only in variants of a cause are reported as one explanation.
        let mut explanations: Vec<ExplanationSummary> = Vec::new();
        for one in &found.explanations {
            let mut terms: Vec<String> = one.set.iter().filter_map(|&k| sources.get(k)).map(in_words).collect();
            terms.sort();
            terms.dedup();
            match explanations.iter_mut().find(|known| known.terms == terms) {
                Some(known) => known.probability = (known.probability + one.probability).min(1.0),
                None => explanations.push(ExplanationSummary { terms, probability: one.probability }),
            }
        }
        explanations.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        explanations.truncate(MOST_SHOWN);
        let harm = Harm::new(self, found, sources, volume);
        let said = |k: usize, is_new: bool| -> Option<Vec<String>> {
            Some(harm.of(k, is_new)?.iter().filter_map(|&k| sources.get(k)).map(in_words).collect())
        };
        let of_taken: Vec<Chosen> = start
            .iter()
            .zip(taken)
            .map(|(&k, &candidate)| Chosen {
                candidate,
                probability: probability(same(k)),
                harmful: said(same(k), false),
                chance: 0.0,
            })
            .collect();
        let keys = |sources: &mut dyn Iterator<Item = Source>| {
            let mut keys: Vec<String> =
                sources.map(|one| one.key(self)).map(|(effect, name)| format!("{effect} {name}")).collect();
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
                == keys(&mut taken.iter().map(|&number| Source::Known(number)));
        let is_better = found.behind.first().is_some_and(|behind| *behind < -SURELY)
            || of_taken.iter().any(|one: &Chosen| !one.is_likely() || (is_offset(one) && one.probability < NAMED));
        // The search handles variants of one cause better: it refines their constants.
        let is_better = is_better && !is_variant;
        let decided = is_better.then(|| {
            let mut chosen: Vec<Chosen> = Vec::new();
            // Shapes of one component form one candidate.
            let mut shapes: Vec<(Candidate, f64, Option<Vec<String>>, f64)> = Vec::new();
            for (&k, loss) in first.set.iter().zip(&found.losses) {
                let probability = probability(k);
                let Some(source) = sources.get(k).filter(|source| {
                    self.is_named(source, probability, found.probability(k), taken)
                        && *loss >= self.shown(source, taken)
                }) else {
                    continue;
                };
                let (harmful, chance) = (said(k, true), (-loss).exp());
                match source {
                    Source::Known(number) => chosen.push(Chosen { candidate: *number, probability, harmful, chance }),
                    Source::Shape(one) => match shapes.iter_mut().find(|(own, ..)| own.parameter == one.parameter) {
                        Some((own, least, known, most)) => {
                            *most = most.max(chance);
                            own.columns.extend(one.columns.iter().cloned());
                            *least = least.min(probability);
                            *known = known.take().or(harmful);
                        }
                        None => shapes.push(((**one).clone(), probability, harmful, chance)),
                    },
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
            for (one, probability, harmful, chance) in shapes {
                chosen.push(Chosen { candidate: self.candidates.len(), probability, harmful, chance });
                self.candidates.push(one);
            }
            chosen
        });
        ContestOutcome { instead, is_whole, of_taken, explanations }
    }
}

fn is_of_rotary(one: &Candidate) -> bool {
    let name = one.parameter.parse::<ErrorName>().ok();
    name.and_then(|name| name.axis()).is_some_and(|axis| axis.is_rotary())
}

/// True for a slope alone.
fn is_slope(one: &Candidate) -> bool {
    matches!(&one.term, Term::Parameters(names) if names.len() == 1 && names[0].term == ComponentTerm::Coefficient(1))
}
