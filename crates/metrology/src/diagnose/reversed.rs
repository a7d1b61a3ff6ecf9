//! Readings of one file or set-up with the opposite sign: a simpler explanation of causes that only the contradiction of two instruments shows.
//!
//! A laser with the wrong sign beside a ball-bar of unknown length looks like three certain scales; two lines of opposite sign at two heights look like a
//! cross-coupling. Operators easily confuse the signs of direct measurements (Spaan 1995, ch. 3). So each file and each set-up takes the opposite sign in
//! turn. If usual errors of machines then explain all readings better, every finding that changes with the sign shares its probability with that mistake.

use super::cause::{Candidate, CauseId, EffectKind};
use super::contest::{ExplanationSummary, MOST_SHOWN};
use super::doubt::ExtrapolationRisk;
use super::entrant::{family, is_slope};
use super::explain::assumptions::Family;
use super::scene::{NO_ROW, Scene};
use super::search::{Field, Weights};
use super::size::{Amounts, size};
use super::undecided::RivalCause;
use super::verdict::AcceptedCause;
use crate::measure::kind::Measurand;
use ncfix_base::numeric::Series;

/// The opposite sign must be this much better without its own odds, as a natural logarithm: a sign that nothing contradicts is that of the file.
const BETTER: f64 = 1.0;
/// Units whose evidence is less by up to this are in question too, as a natural logarithm: a factor of 20.
const ALIKE: f64 = 3.0;
/// A size that changes by less than this share is the same with both signs.
pub(super) const SAME: f64 = 0.2;
/// Maximum number of units. With more of them, a single one decides nothing.
const MOST: usize = 12;
/// Maximum number of terms of an explanation.
const TERMS: usize = 10;
/// Maximum number of columns of a usual error.
const COLUMNS: usize = 2;

/// Readings of files or set-ups that are explained better with the opposite sign of one of them.
#[derive(Clone, Debug)]
pub(super) struct ReversedReadings {
    /// Those of which one may have the opposite sign, the best first. Of two that contradict each other, nothing accuses one of them alone.
    all: Vec<ReversedUnit>,
    /// The contradiction in words and sizes.
    pub(super) contradiction: SignContradiction,
}

/// A file or set-up with the opposite sign.
#[derive(Clone, Debug)]
struct ReversedUnit {
    /// Name of the file, and of the set-up if the file has several.
    name: String,
    /// Probability of the opposite sign, compared with the given ones.
    probability: f64,
    /// Terms that then explain the readings, with the amounts of their columns.
    terms: Vec<(usize, Vec<f64>)>,
}

impl ReversedUnit {
    /// True if a term has another size, or is absent, with the opposite sign.
    fn changes(&self, number: usize, amounts: &[f64]) -> bool {
        let Some((_, own)) = self.terms.iter().find(|(other, _)| *other == number) else { return true };
        let length = |squares: f64| squares.sqrt();
        let size = length(amounts.iter().map(|amount| amount * amount).sum());
        length(own.iter().zip(amounts).map(|(own, amount)| (own - amount).powi(2)).sum()) > SAME * size
    }

    fn id(&self) -> CauseId {
        CauseId::OppositeSign(self.name.clone())
    }
}

/// Files or set-ups whose readings contradict each other in sign.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SignContradiction {
    /// Files or set-ups of which one has the opposite sign: a single one if others confirm each other.
    pub one_of: Vec<String>,
    /// Files or set-ups that agree with each other and contradict a single one.
    pub supported_by: Vec<String>,
    /// Errors that change their signs, as the first of `one_of` reads them.
    pub errors: Vec<SignedError>,
    /// Probability of a wrong sign, compared with other causes of the difference.
    pub probability: f64,
}

/// An error with its size as one file reads it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SignedError {
    /// Its effect and parameter, as `motion EXX`.
    pub cause: String,
    /// Its size.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

impl ReversedReadings {
    /// Opposite signs that change a finding, as its rivals, if it has this share of the probability otherwise.
    pub(super) fn rivals(&self, number: usize, amounts: &[f64], share: f64) -> Vec<RivalCause> {
        let changing = self.all.iter().filter(|one| one.changes(number, amounts));
        changing.map(|one| RivalCause { cause: one.id(), probability: one.probability * share }).collect()
    }

    /// The reason why a finding that changes with a sign must not be corrected.
    pub(super) fn doubt(&self) -> ExtrapolationRisk {
        let names: Vec<&str> = self.all.iter().map(|one| one.name.as_str()).collect();
        let separate_by = format!("the sign of one reading of {} after a known motion of the axis", names.join(" or "));
        ExtrapolationRisk { rivals: self.all.iter().map(|one| one.id().to_string()).collect(), separate_by }
    }

    /// The share of a finding, and its rivals, without the opposite signs.
    pub(super) fn left_out_of(&self, one: &AcceptedCause) -> (f64, Vec<RivalCause>) {
        let is_of_sign = |rival: &RivalCause| self.all.iter().any(|one| one.id() == rival.cause);
        let own: f64 = one.rivals.iter().filter(|rival| is_of_sign(rival)).map(|rival| rival.probability).sum();
        (one.nature_share + own, one.rivals.iter().filter(|rival| !is_of_sign(rival)).cloned().collect())
    }

    /// Gives the opposite signs their shares of every explanation with a finding that changes; the other findings of an explanation stay.
    pub(super) fn share_out(
        &self,
        field: &Field<'_, '_>,
        findings: &[AcceptedCause],
        all: &mut Vec<ExplanationSummary>,
    ) {
        let mut added = Vec::new();
        let given = all.clone();
        for unit in &self.all {
            let is_rival = |one: &&AcceptedCause| one.rivals.iter().any(|rival| rival.cause == unit.id());
            let changed: Vec<CauseId> = findings.iter().filter(is_rival).map(|one| one.candidate.id()).collect();
            let found = unit.terms.iter().filter_map(|(number, _)| field.candidates.get(*number));
            let terms = CauseId::in_order(found.map(Candidate::id).chain([unit.id()]).collect());
            let mut moved = 0.0;
            for (one, given) in all.iter_mut().zip(&given) {
                if one.terms.iter().any(|term| changed.contains(term)) {
                    moved += unit.probability * given.probability;
                    one.probability -= unit.probability * given.probability;
                }
            }
            if moved > 0.0 {
                added.push(ExplanationSummary { terms, probability: moved });
            }
        }
        if !added.is_empty() {
            all.append(&mut added);
            all.sort_by(|a, b| b.probability.total_cmp(&a.probability));
            all.truncate(MOST_SHOWN);
        }
    }
}

/// Readings that share a sign: those of a measurement, or of one of its set-ups.
type Unit = (usize, Option<usize>);

/// Terms that explain readings.
struct SimpleFit {
    terms: Vec<usize>,
    squares: f64,
    rank: usize,
}

/// Candidates by their columns: usual errors, and the terms of the search.
struct Known(Vec<(usize, Vec<Vec<f64>>)>);

impl Field<'_, '_> {
    /// Returns the units of which one explains the readings better with the opposite sign than the terms in `taken`, if there are any. `bare` are the readings without a model.
    pub(super) fn reversed(&self, bare: &Scene<'_>, weights: &Weights, taken: &[usize]) -> Option<ReversedReadings> {
        let units = self.units(weights);
        if taken.is_empty() || !(2..=MOST).contains(&units.len()) {
            return None;
        }
        let is_known = |number: &usize| {
            taken.contains(number)
                || (!self.bows.contains(number) && self.candidates.get(*number).is_some_and(is_usual))
        };
        let numbers = (0..self.candidates.len()).filter(is_known);
        let known = Known(numbers.map(|number| (number, self.columns_of(number))).collect());
        let base = self.series(weights, &[], self.memory(weights, taken));
        let count = base.count().max(2) as f64;
        let variance = |of: &SimpleFit| of.squares / (count - of.rank as f64).max(1.0);
        // A stated hypothesis may leave other causes in the readings, so the given sign is searched in the same way.
        let given: Vec<f64> = self.scene.items.iter().map(|item| item.left).collect();
        let own = [known.of(&base, &given, taken), self.by_usual_errors(&known, &base, &given)];
        let mut found: Vec<(f64, Unit, Vec<f64>, SimpleFit)> = Vec::new();
        for unit in units {
            let values = self.opposite(bare, unit);
            let other = self.by_usual_errors(&known, &base, &values);
            let noise = own.iter().map(variance).fold(variance(&other), f64::min).max(f64::MIN_POSITIVE);
            let evidence = |of: &SimpleFit| {
                let odds = of.terms.iter().filter_map(|&number| self.candidates.get(number)).map(log_odds).sum::<f64>();
                // Schwarz (1978).
                odds - 0.5 * (of.squares / noise + of.rank as f64 * count.ln())
            };
            let gain = evidence(&other) - own.iter().map(evidence).fold(f64::NEG_INFINITY, f64::max);
            if gain > BETTER {
                found.push((gain, unit, values, other));
            }
        }
        let most = found.iter().map(|(gain, ..)| *gain).fold(f64::NEG_INFINITY, f64::max);
        // Of two that explain the readings equally well, only those whose sign an operator states are in question.
        let is_stated = |unit: &Unit| self.measurand(*unit) == Some(Measurand::Component);
        let has_stated = found.iter().any(|(gain, unit, ..)| *gain >= most - BETTER && is_stated(unit));
        found.retain(|(gain, unit, ..)| *gain >= most - ALIKE && (is_stated(unit) || !has_stated));
        // In proportion to the odds, relative to the best.
        let odds = |gain: f64| Family::Sign.assumption().odds * (gain - most).exp();
        let whole = (-most).exp() + found.iter().map(|(gain, ..)| odds(*gain)).sum::<f64>();
        let units: Vec<Unit> = found.iter().map(|(_, unit, ..)| *unit).collect();
        let all: Vec<ReversedUnit> = found
            .iter()
            .map(|(gain, unit, values, fit)| ReversedUnit {
                name: self.name_of(*unit),
                probability: odds(*gain) / whole,
                terms: known.amounts(base.clone(), values, fit),
            })
            .collect();
        let contradiction = self.contradiction(weights, &known, (&units, &all))?;
        Some(ReversedReadings { all, contradiction })
    }

    /// The contradiction between the given signs of these units, in sizes.
    fn contradiction(
        &self,
        weights: &Weights,
        known: &Known,
        (units, all): (&[Unit], &[ReversedUnit]),
    ) -> Option<SignContradiction> {
        // The signs of the first one hold if another one is reversed; alone, it is the reversed one.
        let (first, last) = (units.first()?, all.last()?);
        let own = if units.len() > 1 { 1.0 } else { -1.0 };
        let is_in = |item: usize, (set, setup): Unit| {
            let row = self.scene.items.get(item).and_then(|item| self.scene.rows.get(item.row));
            row.is_some_and(|row| row.set == set && setup.is_none_or(|setup| setup == row.setup))
        };
        let shows = |number: usize, unit: Unit| {
            known.columns(&[number]).flatten().any(|column| {
                let mut all = column.iter().zip(&weights.items).enumerate();
                all.any(|(item, (value, weight))| *value != 0.0 && *weight > 0.0 && is_in(item, unit))
            })
        };
        let terms: Vec<&(usize, Vec<f64>)> = last.terms.iter().filter(|(number, _)| shows(*number, *first)).collect();
        let of = |(number, amounts): &&(usize, Vec<f64>)| {
            let one = self.candidates.get(*number)?;
            let covariance = vec![vec![0.0; amounts.len()]; amounts.len()];
            let size = size(one, &Amounts { values: amounts.clone(), covariance }, self.scene, self.scene.sets.len());
            Some(SignedError { cause: one.title(), value: own * size.value, unit: size.unit.to_owned() })
        };
        // Those that agree with each other: files, or the other set-ups of one file.
        let others = self.units(weights).into_iter().filter(|other| {
            let is_other = if first.1.is_some() { other.0 == first.0 && other.1.is_some() } else { other.1.is_none() };
            is_other && other != first && terms.iter().any(|(number, _)| shows(*number, *other))
        });
        let supported_by = if units.len() > 1 { Vec::new() } else { others.map(|unit| self.name_of(unit)).collect() };
        Some(SignContradiction {
            one_of: all.iter().map(|one| one.name.clone()).collect(),
            supported_by,
            errors: terms.iter().filter_map(of).collect(),
            probability: all.iter().map(|one| one.probability).sum::<f64>().min(1.0),
        })
    }

    fn measurand(&self, (set, _): Unit) -> Option<Measurand> {
        self.scene.sets.get(set).map(|data| data.kind.measurand)
    }

    /// Measurements of deviations with weight, and their set-ups if they have several.
    fn units(&self, weights: &Weights) -> Vec<Unit> {
        let mut setups: Vec<(usize, usize)> = Vec::new();
        for (item, weight) in self.scene.items.iter().zip(&weights.items) {
            let Some(row) = self.scene.rows.get(item.row).filter(|_| *weight > 0.0) else { continue };
            setups.push((row.set, row.setup));
        }
        setups.sort_unstable();
        setups.dedup();
        let mut units: Vec<Unit> = Vec::new();
        for &(set, setup) in &setups {
            let has_sign = self.scene.sets.get(set).is_some_and(|data| {
                matches!(
                    data.kind.measurand,
                    Measurand::BallDistance
                        | Measurand::Component
                        | Measurand::Displacement
                        | Measurand::MovingDisplacement
                )
            });
            let count = setups.iter().filter(|one| one.0 == set).count();
            // The planes of one ball-bar have one sign.
            let is_of_setups = self.scene.sets.get(set).is_some_and(|data| data.kind.measurand == Measurand::Component);
            if has_sign && !units.contains(&(set, None)) {
                units.push((set, None));
            }
            if has_sign && count > 1 && is_of_setups {
                units.push((set, Some(setup)));
            }
        }
        // The opposite sign of all readings contradicts nothing.
        if setups.iter().all(|one| one.0 == setups[0].0) {
            units.retain(|unit| unit.1.is_some());
        }
        units
    }

    /// The residuals if a unit has the opposite sign: −reading − prediction, where the residual is reading − prediction.
    fn opposite(&self, bare: &Scene<'_>, (set, setup): Unit) -> Vec<f64> {
        let is_in = |row: usize| {
            let row = self.scene.rows.get(row).filter(|_| row != NO_ROW);
            row.is_some_and(|row| row.set == set && setup.is_none_or(|setup| setup == row.setup))
        };
        let both = self.scene.items.iter().zip(&bare.items);
        both.map(|(item, reading)| item.left - if is_in(item.row) { 2.0 * reading.left } else { 0.0 }).collect()
    }

    /// Explains readings by usual errors, one by one; then leaves out what the others make unnecessary.
    fn by_usual_errors(&self, known: &Known, base: &Series, values: &[f64]) -> SimpleFit {
        let price = (base.count().max(2) as f64).ln();
        let mut series = base.clone();
        series.set_values(values);
        let mut terms: Vec<usize> = Vec::new();
        while terms.len() < TERMS {
            let worth = |(number, columns): &(usize, Vec<Vec<f64>>)| {
                let one = self.candidates.get(*number).filter(|one| !terms.contains(number) && is_usual(one))?;
                let gain = series.gain(columns);
                // The noise is unknown: its best value belongs to each candidate.
                let share = series.squares() / (series.squares() - gain.squares).max(f64::MIN_POSITIVE);
                let worth = 0.5 * (series.count() as f64 * share.ln() - price * gain.rank as f64);
                (gain.rank > 0).then_some((worth + log_odds(one), *number))
            };
            let best = known.0.iter().filter_map(worth).max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, number)) = best.filter(|(worth, _)| *worth > 0.0) else { break };
            known.columns(&[number]).flatten().for_each(|column| {
                series.take(column);
            });
            terms.push(number);
        }
        let mut found = known.of(base, values, &terms);
        while let Some(fewer) = self.with_fewer(known, (base, values), &found) {
            found = fewer;
        }
        found
    }

    /// An explanation without one of its terms, if that one is not worth its price.
    fn with_fewer(&self, known: &Known, (base, values): (&Series, &[f64]), found: &SimpleFit) -> Option<SimpleFit> {
        let count = base.count().max(2) as f64;
        let noise = (found.squares / (count - found.rank as f64).max(1.0)).max(f64::MIN_POSITIVE);
        let without = found.terms.iter().filter_map(|&out| {
            let terms: Vec<usize> = found.terms.iter().copied().filter(|&number| number != out).collect();
            let fewer = known.of(base, values, &terms);
            let columns = found.rank.saturating_sub(fewer.rank) as f64;
            let worth = 0.5 * ((fewer.squares - found.squares) / noise - columns * count.ln());
            Some((worth + log_odds(self.candidates.get(out)?), fewer))
        });
        without.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(worth, _)| *worth <= 0.0).map(|(_, fewer)| fewer)
    }

    fn name_of(&self, (set, setup): Unit) -> String {
        let data = self.scene.sets.get(set);
        let label = setup.and_then(|setup| data?.setups.get(setup)).map_or("", |setup| &setup.label);
        format!("{} {label}", data.map_or("", |data| &data.name)).trim().to_owned()
    }
}

impl Known {
    fn columns<'k>(&'k self, terms: &'k [usize]) -> impl Iterator<Item = &'k Vec<Vec<f64>>> {
        terms.iter().filter_map(|number| self.0.iter().find(|(own, _)| own == number)).map(|(_, columns)| columns)
    }

    /// Explains readings by these terms.
    fn of(&self, base: &Series, values: &[f64], terms: &[usize]) -> SimpleFit {
        let mut series = base.clone();
        for column in self.columns(terms).flatten() {
            series.take(column);
        }
        series.set_values(values);
        SimpleFit { terms: terms.to_vec(), squares: series.squares(), rank: series.rank() }
    }

    /// The amounts of the terms of an explanation.
    fn amounts(&self, mut base: Series, values: &[f64], found: &SimpleFit) -> Vec<(usize, Vec<f64>)> {
        base.set_values(values);
        let columns: Vec<Vec<f64>> = self.columns(&found.terms).flatten().cloned().collect();
        let mut amounts = base.amounts(&columns).0.into_iter();
        let of = |(&number, own): (&usize, &Vec<Vec<f64>>)| (number, amounts.by_ref().take(own.len()).collect());
        found.terms.iter().zip(self.columns(&found.terms)).map(of).collect()
    }
}

/// True for errors that most machines have, in a form with few amounts.
fn is_usual(one: &Candidate) -> bool {
    let is_of_place = matches!(one.cause.effect, EffectKind::Location | EffectKind::Motion | EffectKind::Backlash);
    is_of_place && one.columns.len() <= COLUMNS
}

/// The logarithm of the odds of a term. A slope along its own axis is a scale, which nearly every machine has.
fn log_odds(one: &Candidate) -> f64 {
    let family = match family(one) {
        Family::Positioning if is_slope(one) => Family::Scale,
        other => other,
    };
    family.assumption().odds.ln()
}
