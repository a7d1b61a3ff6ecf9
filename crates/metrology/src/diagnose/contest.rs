//! Which explanation of the readings is the most probable: what the search took, or another set of terms.
//!
//! All terms stand in one contest ([`crate::explain`]): errors of axes in the form in which each has one name, and every candidate of the register. What the search took is one of
//! its starts. Where another set is surely more probable it takes the place.

use std::collections::HashMap;

use super::cause::{Candidate, EffectKind, Term, Weight, motion};
use super::scene::Through;
use super::search::{Field, Weights};
use crate::explain::assumptions::Family;
use crate::explain::contest::{Contest, Entrant, Outside, contest};
use crate::explain::likelihood::Group;
use crate::explain::term;
use ncfix_model::name::ErrorName;
use ncfix_model::parameter::ComponentTerm;

/// Another set takes the place of what the search took if its probability is so many times as large, as a natural logarithm: 20 times.
const SURELY: f64 = 3.0;
/// A term is named if its probability is at least this: more than all that may stand in its place together.
const NAMED: f64 = 0.5;
/// Readings show a term surely if the score falls by this without it and with nothing in its place, as a natural logarithm: 1000 times.
const SHOWN: f64 = 6.9;
/// What the search found by its readings is one of about so many that it would have found as well.
const SOUGHT: f64 = 100.0;

/// A term with its probability.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    /// Number of its candidate.
    pub(super) candidate: usize,
    /// The sum of the probabilities of all explanations that have it.
    pub(super) probability: f64,
}

/// One explanation in words.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExplanationSummary {
    /// Its terms: cause and parameter.
    pub terms: Vec<String>,
    /// Its probability among all explanations.
    pub probability: f64,
}

/// The outcome.
#[derive(Clone, Debug, Default)]
pub(super) struct Outcome {
    /// Terms of the most probable explanation, where it takes the place of what the search took.
    pub(super) instead: Option<Vec<Chosen>>,
    /// The probability of each term that the search took.
    pub(super) of_taken: Vec<f64>,
    /// The most probable explanations.
    pub(super) explanations: Vec<ExplanationSummary>,
}

/// An entrant with what it is.
struct Named {
    candidate: Source,
    entrant: Entrant,
}

/// Where the candidate of an entrant is.
#[derive(Clone, Debug)]
enum Source {
    /// Among those of the field.
    Known(usize),
    /// A shape over the travel: axis component and one column.
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
        EffectKind::Cross if is_angle => Family::CrossAngle,
        EffectKind::Cross => Family::Cross,
        EffectKind::ServoMismatch | EffectKind::Following | EffectKind::Delay => Family::Lag,
        EffectKind::Dynamic => Family::Dynamic,
        EffectKind::ThermalDrift => Family::Drift,
        EffectKind::ThermalExpansion => Family::Expansion,
        EffectKind::ThermalSquareness => Family::ThermalSquareness,
        EffectKind::Drift => Family::Creep,
        EffectKind::Load => Family::Load,
        EffectKind::Setup => Family::Setup,
        EffectKind::Probe => Family::Probe,
        EffectKind::Sensor | EffectKind::Outlier | EffectKind::Program | EffectKind::Unknown => Family::Unnamed,
        EffectKind::Own(_) => Family::Own,
    }
}

/// Columns of a candidate; each is of the usual size of its family where it acts most.
fn group(field: &Field<'_, '_>, one: &Candidate) -> Group {
    let columns = field.columns(one);
    let size = |parts: &Vec<(Through, Weight)>| {
        // Travel does not count: the effect where it is largest is what is usual.
        let of = match family(one) {
            Family::Squareness | Family::Tilt | Family::Offset => return family(one).size(0.0),
            Family::Lag => return Family::Lag.size(0.0),
            other => other.size(1e3),
        };
        let largest = |(_, weight): &(Through, Weight)| {
            field.scene.rows.iter().map(|row| weight.of(row).abs()).fold(0.0, f64::max)
        };
        let most = parts.iter().map(largest).fold(0.0, f64::max);
        // Half of a reversal value on either side.
        let share = if one.cause.effect == EffectKind::Backlash { 0.5 } else { 1.0 };
        if most > 0.0 { share * of / most } else { 0.0 }
    };
    let sizes = one.columns.iter().map(size).collect();
    Group { columns, sizes }
}

impl Field<'_, '_> {
    /// Fills in what a unit of a deviation does to readings, where it is not known yet.
    fn know(&mut self, one: &Candidate) {
        let scene = self.scene;
        for (through, _) in one.columns.iter().flatten() {
            self.factors.entry(*through).or_insert_with(|| std::sync::Arc::new(scene.factors(*through)));
        }
    }

    /// Holds the contest. The candidates of the outcome are among those of the field afterwards.
    pub(super) fn contest(&mut self, weights: &Weights, taken: &[usize]) -> Outcome {
        let mut named: Vec<Named> = Vec::new();
        let mut is_in: Vec<bool> = vec![false; self.candidates.len()];
        for one in term::terms(self.scene) {
            self.enter(one, &mut named, &mut is_in);
        }
        let mut outside: Vec<usize> = Vec::new();
        let mut counts: HashMap<(EffectKind, &str), f64> = HashMap::new();
        for (number, one) in self.candidates.iter().enumerate() {
            *counts.entry((one.cause.effect, one.parameter.as_str())).or_insert(0.0) += 1.0;
            // Shapes over the travel stand for these.
            let is_shape = one.cause.effect == EffectKind::Motion && !is_of_rotary(one) && !one.cause.name.is_empty();
            let is_location = one.cause.effect == EffectKind::Location;
            if !is_in[number] && !is_shape && !is_location && !self.bows.contains(&number) && !taken.contains(&number) {
                outside.push(number);
            }
        }
        let log_odds = |number: usize| {
            let one = &self.candidates[number];
            let count = counts.get(&(one.cause.effect, one.parameter.as_str())).copied().unwrap_or(1.0);
            family(one).assumption().odds.ln() - count.ln()
        };
        for &number in taken.iter().filter(|&&number| !is_in[number]) {
            let is_sought = number >= self.bows.end;
            let entrant = Entrant {
                group: group(self, &self.candidates[number]),
                log_odds: log_odds(number) - if is_sought { SOUGHT.ln() } else { 0.0 },
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
        self.outcome(&found, &sources, &start)
    }

    /// Adds a term: by its candidate where there is one, else as a shape.
    fn enter(&mut self, one: term::Term, named: &mut Vec<Named>, is_in: &mut [bool]) {
        let name = one.component.to_string();
        let is_simple = one.family.is_simple();
        let log_odds = one.family.assumption().odds.ln();
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
                let shape = Candidate::one(&motion::CAUSE, one.component, one.through(), one.weight.clone());
                let shape = shape.driven_by(&[&axis]);
                self.know(&shape);
                let group = Group::one(self.columns(&shape).remove(0), one.size);
                let entrant = Entrant { group, log_odds, is_simple };
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
        let entrant = Entrant { group: Group::one(column, size), log_odds, is_simple };
        named.push(Named { candidate: Source::Known(number), entrant });
    }

    fn outcome(&mut self, found: &Contest, sources: &[Source], start: &[usize]) -> Outcome {
        let Some(first) = found.explanations.first() else { return Outcome::default() };
        let same =
            |number: usize| found.alike.iter().find(|(one, _)| *one == number).map_or(number, |(_, other)| *other);
        let of_taken = start.iter().map(|&number| found.probability(same(number))).collect();
        let in_words = |source: &Source| match source {
            Source::Known(number) => {
                let one = &self.candidates[*number];
                format!("{} {}", one.cause.name, one.parameter).trim_end().to_owned()
            }
            Source::Shape(one) => format!("{} {}", one.cause.name, one.parameter),
        };
        let explanations = found.explanations.iter().take(20).map(|one| {
            let mut terms: Vec<String> = one.set.iter().filter_map(|&k| sources.get(k)).map(in_words).collect();
            terms.sort();
            terms.dedup();
            ExplanationSummary { terms, probability: one.probability }
        });
        let explanations = explanations.collect();
        if std::env::var_os("NCFIX_DEBUG_CONTEST").is_some() {
            eprintln!(
                "entrants {} joined {} memory {:?} behind {:?} start {:?}",
                found.entrants,
                found.joined.len(),
                found.memory,
                found.behind,
                start
            );
            for (&k, loss) in first.set.iter().zip(&found.losses) {
                eprintln!("  {:.3} {:.2} {}", found.probability(k), loss, in_words(&sources[k]));
            }
            eprintln!("  mean {:?} scale {}", first.posterior.mean, first.posterior.scale);
        }
        let is_better = found.behind.first().is_some_and(|behind| *behind < -SURELY);
        let instead = is_better.then(|| {
            let mut chosen: Vec<Chosen> = Vec::new();
            // Shapes of one component are one candidate.
            let mut shapes: Vec<(Candidate, f64)> = Vec::new();
            for (&k, loss) in first.set.iter().zip(&found.losses) {
                let probability = found.probability(k);
                let Some(source) = sources.get(k).filter(|_| probability >= NAMED && *loss >= SHOWN) else { continue };
                match source {
                    Source::Known(number) => chosen.push(Chosen { candidate: *number, probability }),
                    Source::Shape(one) => match shapes.iter_mut().find(|(own, _)| own.parameter == one.parameter) {
                        Some((own, least)) => {
                            own.columns.extend(one.columns.iter().cloned());
                            *least = least.min(probability);
                        }
                        None => shapes.push(((**one).clone(), probability)),
                    },
                }
            }
            for (one, probability) in shapes {
                chosen.push(Chosen { candidate: self.candidates.len(), probability });
                self.candidates.push(one);
            }
            chosen
        });
        Outcome { instead, of_taken, explanations }
    }
}

fn is_of_rotary(one: &Candidate) -> bool {
    let name = one.parameter.parse::<ErrorName>().ok();
    name.and_then(|name| name.axis()).is_some_and(|axis| axis.is_rotary())
}

/// A slope and nothing else.
fn is_slope(one: &Candidate) -> bool {
    matches!(&one.term, Term::Parameters(names) if names.len() == 1 && names[0].term == ComponentTerm::Coefficient(1))
}
