//! The subject of a trial: the candidate of a stated hypothesis, its visibility in the readings, and the amounts of its terms.

use std::collections::BTreeMap;

use super::super::cause::cross::curved;
use super::super::cause::{Candidate, EffectKind};
use super::super::entrant::group;
use super::super::explain::contest::evidences;
use super::super::scene::Through;
use super::super::search::Field;
use super::super::shape::driver;
use super::super::size::{Amounts, EXPANDED};
use super::super::verdict::{AcceptedCause, Settled};
use super::build::{AmountUnit, Built, of_shape, of_sum};
use super::form::{StatedContent, StatedHypothesis, TermAmount};
use super::overlap::{Overlap, overlap};
use ncfix_base::geometry::Axis;

/// A column is invisible if less than this share of it remains after set-ups and other terms.
const OWN: f64 = 1e-9;
/// A term whose squares are less than this share of those of its component is zero but for rounding.
const ROUNDING: f64 = 1e-18;
/// An effect of typical size that changes all readings together by less than this, in standard deviations, is not visible, as in the likelihood.
const FAINT: f64 = 0.3;
/// Maximum number of variants of a named cause that are compared.
const VARIANTS: usize = 6;

/// A hypothesis with the index of its candidate in the field.
pub(super) struct StatedSubject {
    pub(super) number: usize,
    pub(super) units: Vec<AmountUnit>,
    pub(super) variants: usize,
    /// Accepted causes and simple errors that share its effect on the readings.
    pub(super) overlap: Overlap,
}

/// The candidate of a hypothesis, or the reason why these readings have none. `beside` are the candidates of a model in addition to which the best variant of
/// a named cause is selected.
pub(super) fn subject(
    one: &StatedHypothesis,
    outcome: &mut Settled<'_, '_, '_>,
    beside: &[usize],
) -> Result<StatedSubject, String> {
    let scene = outcome.field.scene;
    let (number, units, variants) = match &one.statement {
        StatedContent::Sum(through, terms) => {
            let Built { candidate, amounts } = of_sum(scene, *through, terms)?;
            (enter(outcome.field, candidate), amounts, 1)
        }
        StatedContent::Shape(name) => {
            let candidate = of_shape(scene, name).ok_or("the axes of the machine have no term of this name")?;
            (enter(outcome.field, candidate), Vec::new(), 1)
        }
        StatedContent::Named(effect, parameter) => {
            for curved in curved(scene, *effect, parameter) {
                enter(outcome.field, curved);
            }
            let (number, variants) = named(outcome, *effect, parameter, beside)?;
            (number, Vec::new(), variants)
        }
    };
    visible(outcome, number, !units.is_empty(), &units)?;
    let overlap = overlap(outcome, number, matches!(one.statement, StatedContent::Sum(..)));
    Ok(StatedSubject { number, units, variants, overlap })
}

pub(super) fn enter(field: &mut Field<'_, '_>, candidate: Candidate) -> usize {
    field.know(&candidate);
    field.candidates.push(candidate);
    field.candidates.len() - 1
}

/// The best variant of a cause, and the number of variants: an accepted one if there is one, else the one with the best score by its gain and number
/// of columns.
fn named(
    outcome: &Settled<'_, '_, '_>,
    effect: EffectKind,
    parameter: &str,
    beside: &[usize],
) -> Result<(usize, usize), String> {
    let field = &*outcome.field;
    let is_one = |number: &usize| {
        field.candidates.get(*number).is_some_and(|one| one.cause.effect == effect && one.parameter == parameter)
    };
    let all: Vec<usize> = (0..field.candidates.len()).filter(is_one).collect();
    if all.is_empty() {
        let mut known: Vec<String> = Vec::new();
        for one in field.candidates.iter().filter(|one| one.cause.effect == effect) {
            if !known.contains(&one.parameter) {
                known.push(one.parameter.clone());
            }
        }
        return Err(if known.is_empty() {
            format!("these readings have nothing on which {effect} could depend")
        } else {
            format!("{effect} has no parameter {parameter} here, only {}", known.join(", "))
        });
    }
    if let Some((taken, _)) = outcome.kept.iter().find(|(taken, _)| all.contains(&taken.candidate)) {
        return Ok((taken.candidate, all.len()));
    }
    let series = field.series(outcome.weights, beside, 0.0);
    let count = (series.count() as f64).max(2.0);
    // By the criterion of Schwarz (1978).
    let worth = |number: usize| {
        let gain = series.gain(&field.columns_of(number));
        let rest = (series.squares() - gain.squares).max(f64::MIN_POSITIVE);
        -count * rest.ln() - gain.rank as f64 * count.ln()
    };
    let mut order: Vec<(f64, usize)> = all.iter().map(|&number| (worth(number), number)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    order.truncate(VARIANTS);
    let some: Vec<usize> = order.iter().map(|(_, number)| *number).collect();
    let groups: Vec<_> = beside
        .iter()
        .chain(&some)
        .filter_map(|&number| field.candidates.get(number))
        .map(|one| group(field, one))
        .collect();
    let with = |k: usize| (0..beside.len()).chain([k]).collect();
    let sets: Vec<Vec<usize>> = (beside.len()..groups.len()).map(with).collect();
    let found = evidences(field.scene, &outcome.weights.items, &groups, &sets);
    let best = some.iter().zip(found).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(number, _)| *number);
    best.map(|number| (number, all.len())).ok_or_else(|| format!("{effect} {parameter} has no form here"))
}

/// Checks that the readings can show a candidate.
///
/// # Errors
/// The reason why they cannot.
fn visible(outcome: &Settled<'_, '_, '_>, number: usize, has_terms: bool, units: &[AmountUnit]) -> Result<(), String> {
    let field = &*outcome.field;
    let Some(one) = field.candidates.get(number) else { return Err("there is no candidate".into()) };
    let weights = outcome.weights;
    let columns = field.columns_of(number);
    let squares =
        |column: &[f64]| column.iter().zip(&weights.items).map(|(value, weight)| (value * weight).powi(2)).sum::<f64>();
    let still = still(outcome, one);
    let because = if still.is_empty() { String::new() } else { format!(": {}", joined(&still)) };
    if columns.iter().all(|column| squares(column) == 0.0) {
        let has_effect = one
            .columns
            .iter()
            .flatten()
            .any(|(through, _)| field.factors.get(through).is_some_and(|factors| squares(factors) > 0.0));
        return Err(match (has_effect, one.columns.first().and_then(|parts| parts.first())) {
            (true, _) => no_value(outcome, one, &still),
            (false, Some((Through::Component(name), _))) => format!("no reading responds to {name}"),
            (false, _) => "no reading responds to it".into(),
        });
    }
    let mut series = field.series(weights, &[], 0.0);
    let mut of_setups = Vec::new();
    for column in &columns {
        series.set_values(column);
        of_setups.push(series.squares());
    }
    if columns.iter().zip(&of_setups).all(|(column, rest)| *rest <= OWN * squares(column)) {
        return Err(format!("the unknowns of the set-ups absorb it completely{because}"));
    }
    // A factor that is the same in all readings has left no trace: a term without it has the same effect on them.
    // Of two sensors whose difference counts, one may be constant.
    let is_axis = |name: &str| matches!(name.as_bytes(), [letter] if Axis::from_letter(*letter).is_some());
    let still: Vec<(String, String)> = still.into_iter().filter(|(name, _)| is_axis(name)).collect();
    if has_terms && !still.is_empty() && still.len() < one.drivers.len() {
        let names: Vec<&str> = still.iter().map(|(name, _)| name.as_str()).collect();
        return Err(format!(
            "{}, so a term without {} explains the same readings; measure at several of its values",
            joined(&still),
            names.join(" and ")
        ));
    }
    if has_terms {
        let responses = one.columns.iter().flatten().filter_map(|(through, _)| field.factors.get(through));
        let response = responses.map(|factors| squares(factors)).fold(0.0, f64::max);
        let nothing = columns.iter().position(|column| squares(column) <= ROUNDING * response);
        if let Some(place) = nothing {
            let own = units.iter().rev().find(|unit| unit.column <= place);
            let other = own.map(|unit| if place == unit.column { place + 1 } else { unit.column });
            let is_constant =
                other.and_then(|other| Some(*of_setups.get(other)? <= OWN * squares(columns.get(other)?)));
            return Err(match own {
                Some(unit) if unit.is_wave && is_constant == Some(true) => {
                    format!(
                        "the positions are whole periods of {} apart, so it has the same value at all of them",
                        unit.term
                    )
                }
                Some(unit) if unit.is_wave => {
                    format!("the positions are half a period apart, so half of the wave {} is not measured", unit.term)
                }
                _ => format!("{} is zero at all readings", own.map_or("a term", |unit| unit.term.as_str())),
            });
        }
        let mut beside = field.series(weights, &[], 0.0);
        for (place, column) in columns.iter().enumerate() {
            if !beside.take(column) {
                let own = units.iter().rev().find(|unit| unit.column <= place).map_or("", |unit| unit.term.as_str());
                return Err(format!(
                    "the readings cannot separate {own} from the other terms and the unknowns of the set-ups{because}"
                ));
            }
        }
    }
    let group = group(field, one);
    let is_faint = of_setups.iter().zip(&group.sizes).all(|(rest, size)| rest.sqrt() * size < FAINT);
    if is_faint {
        return Err(
            "at its usual size, it would change all readings together by less than a third of their noise".into()
        );
    }
    Ok(())
}

/// Why a hypothesis is zero at all readings, although they respond to its component.
fn no_value(outcome: &Settled<'_, '_, '_>, one: &Candidate, still: &[(String, String)]) -> String {
    let is_constant = |name: &String| is_constant_in_runs(outcome, name);
    if one.cause.effect == EffectKind::ThermalDrift && !one.drivers.is_empty() && one.drivers.iter().all(is_constant) {
        let (names, verb) = (one.drivers.join(" and "), if one.drivers.len() > 1 { "are" } else { "is" });
        return format!(
            "{names} {verb} constant within each run of a set-up, and a drift counts from the first row of the run; where the zero is free, it absorbs a constant drift"
        );
    }
    match still {
        [] => "its drivers have no value in these readings, or it is zero at all of them".into(),
        _ => format!("it is zero at all readings: {}", joined(still)),
    }
}

/// Returns `true` if a driver has values, and they are equal within each run of each set-up.
fn is_constant_in_runs(outcome: &Settled<'_, '_, '_>, name: &str) -> bool {
    let scene = outcome.field.scene;
    let Some(found) = driver(scene, name) else { return false };
    let mut ranges: BTreeMap<[usize; 3], (f64, f64)> = BTreeMap::new();
    for (row, &value) in scene.rows.iter().zip(&found.values) {
        if row.set < outcome.used && value.is_finite() {
            let range = ranges.entry([row.set, row.setup, row.run]).or_insert((value, value));
            *range = (range.0.min(value), range.1.max(value));
        }
    }
    ranges.values().all(|(low, high)| high - low <= 1e-9 * high.abs().max(low.abs()))
}

/// The constant drivers in words.
fn joined(still: &[(String, String)]) -> String {
    let all: Vec<String> = still.iter().map(|(name, at)| format!("{name} stays at {at}")).collect();
    all.join(" and ")
}

/// Drivers that are constant, with their values as text.
fn still(outcome: &Settled<'_, '_, '_>, one: &Candidate) -> Vec<(String, String)> {
    let scene = outcome.field.scene;
    let is_used = |row: usize| scene.rows.get(row).is_some_and(|row| row.set < outcome.used);
    let of = |name: &String| {
        let found = driver(scene, name)?;
        let values = found.values.iter().enumerate().filter(|(row, value)| is_used(*row) && value.is_finite());
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, value)| (low.min(*value), high.max(*value)));
        let unit = if found.unit.is_empty() { String::new() } else { format!(" {}", found.unit) };
        (high >= low && high - low <= 1e-9 * high.abs().max(low.abs())).then(|| (name.clone(), format!("{low}{unit}")))
    };
    one.drivers.iter().filter_map(of).collect()
}

/// Amounts of the terms; for a named cause, its size.
pub(super) fn amounts(name: &str, subject: &StatedSubject, accepted: &AcceptedCause) -> Vec<TermAmount> {
    if subject.units.is_empty() {
        let size = &accepted.size;
        let (term, unit) = (name.to_owned(), size.unit.to_owned());
        return vec![TermAmount { term, value: size.value, u95: size.u95, sigma: size.u95 / EXPANDED, unit }];
    }
    subject.units.iter().map(|unit| amount(unit, &accepted.amounts)).collect()
}

fn amount(unit: &AmountUnit, amounts: &Amounts) -> TermAmount {
    let count = amounts.values.len();
    let at = |k: usize| amounts.values.get(k).copied().unwrap_or(0.0);
    let mut along = vec![0.0; count];
    let parts: Vec<usize> = if unit.is_wave { vec![unit.column, unit.column + 1] } else { vec![unit.column] };
    let length = parts.iter().map(|&k| at(k) * at(k)).sum::<f64>().sqrt();
    for &k in &parts {
        if let Some(one) = along.get_mut(k) {
            *one = if unit.is_wave && length > 0.0 { at(k) / length } else { 1.0 };
        }
    }
    let (value, sigma) = amounts.form(&along);
    TermAmount {
        term: unit.term.clone(),
        value: unit.factor * value,
        u95: EXPANDED * unit.factor.abs() * sigma,
        sigma: unit.factor.abs() * sigma,
        unit: unit.unit.clone(),
    }
}
