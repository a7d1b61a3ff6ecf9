//! A calibration with terms stated by the user: the machine file that holds them, and the parameters that remain to be fitted.

use serde::Serialize;

use super::extended::{StartFile, load, made};
use crate::calibrate::Parameter;
use crate::diagnose::cause::Causes;
use crate::diagnose::extend::{Anchor, Change, again};
use crate::diagnose::stated::{self, ModelTerm, StatedHypothesis, StatedModel, TermAmount, TermRefusal, stated_model};
use crate::diagnose::{EXPANDED, Scene};
use crate::measure::data::DataSet;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::number::significant;
use ncfix_base::source::Source;
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_machine::machine::uncertainty::SECTION;
use ncfix_model::{ErrorModel, ModelRegisters, ParameterName};

const SECTIONS: &str = "write [location] and [[motion]] as separate sections";

/// The amount of a stated term that the machine file holds as a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StatedEstimate {
    /// The hypothesis as stated.
    pub hypothesis: String,
    /// The term.
    pub term: String,
    /// Its amount.
    pub value: f64,
    /// Its standard uncertainty.
    pub sigma: f64,
    /// Unit of both.
    pub unit: String,
}

/// The start of a calibration with stated terms.
#[derive(Clone, Debug)]
pub struct StatedStart {
    /// The machine file with the terms.
    pub source: Source,
    /// Its errors.
    pub errors: ErrorModel,
    /// All parameters that a fit finds: those of the model, and those of the terms.
    pub parameters: Vec<Parameter>,
    /// Amounts of the terms that are not parameters.
    pub terms: Vec<StatedEstimate>,
    /// Factors by which these terms enlarge the uncertainties of parameters.
    pub growth: Vec<(ParameterName, f64)>,
}

/// Fits stated terms to the used measurements and puts them into the machine file; `None` if there are errors, all in the text of the terms.
#[must_use]
pub fn start_with_terms(
    (file, registers): (&Source, &ModelRegisters),
    (machine, errors): (&Machine, &ErrorModel),
    (text, mut parameters): (&Source, Vec<Parameter>),
    sets: &[DataSet],
    findings: &mut Vec<Diagnostic>,
) -> Option<StatedStart> {
    let before = findings.len();
    let (stated, faults) = stated::read(text, machine, &sets.iter().collect::<Vec<_>>());
    findings.extend(faults);
    if findings.len() > before {
        return None;
    }
    let refuse = |findings: &mut Vec<Diagnostic>, one: Option<&StatedHypothesis>, message: String, help: &str| {
        let Some(one) = one.or(stated.first()) else { return };
        let place = Place { file: text.id(), span: one.span };
        findings.push(Diagnostic::at(Code::NOT_TOLD, place, message, help));
    };
    let (Ok(scene), Ok(bare)) = (Scene::new(machine, errors, sets), Scene::new(machine, &ErrorModel::default(), sets))
    else {
        let help = "check the columns of positions and their units, or describe what is known of the set-ups";
        refuse(findings, None, "the readings do not even determine the set-ups".into(), help);
        return None;
    };
    let beside: Vec<ParameterName> = parameters
        .iter()
        .filter_map(|one| match one {
            Parameter::Geometry(name) => Some(*name),
            Parameter::Effect(_) => None,
        })
        .collect();
    let StatedModel { terms: found, growth, lack } = stated_model(&stated, &beside, &Causes::default(), &scene, &bare);
    let (mut grown, mut terms, mut all) = (std::str::from_utf8(file.bytes()).ok()?.to_owned(), Vec::new(), Vec::new());
    let mut is_sound = true;
    let mut doubts = Vec::new();
    for (one, found) in stated.iter().zip(found) {
        match found {
            Ok(ModelTerm::Parameters(names)) => {
                for name in names.into_iter().map(Parameter::from) {
                    if !parameters.contains(&name) {
                        parameters.push(name);
                    }
                }
            }
            Ok(ModelTerm::Changes(changes, amounts)) => {
                let entered = enter((file, registers, None), &grown, &changes, &note(one, &changes, &amounts));
                match entered {
                    Ok(text) => grown = with_uncertainty(machine, text, &changes, &amounts),
                    Err(why) => {
                        is_sound = false;
                        refuse(findings, Some(one), format!("{}: {why}", one.text), "remove the entry, or the term");
                    }
                }
                doubts.extend(doubt(one, &amounts, Place { file: text.id(), span: one.span }));
                if changes.iter().any(|change| matches!(change, Change::Shape { .. })) {
                    terms.extend(amounts.into_iter().map(|amount| estimate(one, amount)));
                }
                all.extend(changes);
            }
            Err(TermRefusal::NotIdentified(why)) => {
                is_sound = false;
                let help =
                    "test it with ncfix diagnose --hypothesis, which reports the evidence and the measurement it needs";
                refuse(findings, Some(one), format!("{} cannot be fitted: {why}", one.text), help);
            }
            Err(TermRefusal::NotStorable(why)) => {
                is_sound = false;
                let help = "remove it from --model; ncfix diagnose --hypothesis gives its amount, but no program can be corrected for it";
                let place = Place { file: text.id(), span: one.span };
                findings.push(Diagnostic::at(Code::TERM_NOT_STORABLE, place, format!("{}: {why}", one.text), help));
            }
        }
    }
    if !is_sound {
        return None;
    }
    findings.extend(doubts);
    findings.extend(lack.and_then(|times| lacking(&stated, times, text)));
    let read = load((file, registers, None), &grown);
    let Some(read) = read else {
        refuse(findings, None, format!("{} cannot be read back", file.name()), SECTIONS);
        return None;
    };
    // Time constants are those of the terms.
    let new = again(errors, &read, &all).into_iter().filter(Parameter::is_linear);
    for one in new {
        if !parameters.contains(&one) {
            parameters.push(one);
        }
    }
    let source = Source::new(file.id(), file.name(), grown.into_bytes()).ok()?;
    Some(StatedStart { source, errors: read, parameters, terms, growth })
}

/// The text with the changes of a term, and a note at the first of them.
fn enter(from: StartFile<'_>, text: &str, changes: &[Change], note: &[String]) -> Result<String, String> {
    let mut own = text.to_owned();
    let mut first = None;
    for change in changes {
        let anchor = made(from, &mut own, change)?;
        first.get_or_insert(anchor);
    }
    let first = first.ok_or("the readings do not determine its size")?;
    let Some(mut edit) = Edit::parse(&own) else { return Ok(own) };
    let is_noted = match &first {
        Anchor::Key(section, key) => edit.note_key(section, key, note),
        Anchor::Entry(list, index) => edit.note(list, *index, note),
    };
    Ok(if is_noted { edit.text() } else { own })
}

/// The text with the standard uncertainties of its new tables and grids in `[uncertainty]`: each that of the whole error, the largest of its values. An
/// uncertainty that the file states already stays.
fn with_uncertainty(machine: &Machine, text: String, changes: &[Change], amounts: &[TermAmount]) -> String {
    let Some(mut edit) = Edit::parse(&text) else { return text };
    let is_known = |name: &str| machine.uncertainty.as_ref().is_some_and(|own| own.rows.contains_key(name));
    // Of the fit: that of the values also has the other explanations.
    let shares = amounts.iter().map(|own| EXPANDED * own.sigma / own.u95).filter(|share| share.is_finite());
    let share = shares.fold(0.0, f64::max);
    let mut is_done = true;
    for change in changes {
        // A play has the key of its reversal value.
        let Change::Shape { name, u95, kind: "table" | "grid", .. } = change else { continue };
        let largest = u95.iter().flatten().copied().fold(0.0, f64::max);
        // To 0.1 nm or 0.1 nrad.
        let sigma = (1e4 * share * largest / EXPANDED).ceil() / 1e4;
        if sigma > 0.0 && sigma.is_finite() && !is_known(&name.to_string()) {
            is_done &= edit.set(SECTION, &name.to_string(), &Given::Number(sigma));
        }
    }
    if is_done { edit.text() } else { text }
}

/// The warning that the readings do not show a term: every amount of it may be 0. The term is written all the same, because the user stated it.
fn doubt(one: &StatedHypothesis, amounts: &[TermAmount], place: Place) -> Option<Diagnostic> {
    if amounts.is_empty() || amounts.iter().any(|own| own.value.abs() > own.u95) {
        return None;
    }
    let sizes: Vec<String> = amounts
        .iter()
        .map(|own| {
            let [value, u95] = [own.value, own.u95].map(significant);
            // Names of keys have no µ.
            format!("{value} ± {u95} {}", own.unit.replacen('u', "µ", 1))
        })
        .collect();
    let message = format!(
        "{}: the readings do not show this term: its 95 % interval contains 0 ({})",
        one.text,
        sizes.join(", ")
    );
    let help = "remove the term, or measure where it acts; `ncfix diagnose --hypothesis` weighs the evidence";
    Some(Diagnostic::at(Code::NOT_SHOWN, place, message, help))
}

/// The warning that the model of stated terms lacks an error: the amounts absorb a part of it.
fn lacking(stated: &[StatedHypothesis], times: f64, text: &Source) -> Option<Diagnostic> {
    let first = stated.first()?;
    let place = Place { file: text.id(), span: first.span };
    let message = format!(
        "{}: the readings have another error beside this model: the residual (RMS) is {} times the scatter of repeated readings",
        first.text,
        significant(times)
    );
    let help = format!(
        "name the whole model: `ncfix diagnose DATA --machine M.toml --hypothesis \"{}\"` states it after `next:`; until then the amount can be \
         wrong by more than its uncertainty",
        first.text
    );
    Some(Diagnostic::at(Code::POOR_FIT, place, message, help))
}

/// The note at the term in the file. Amounts that are parameters of the fit stand in the entry itself, and a later fit may change them.
fn note(one: &StatedHypothesis, changes: &[Change], amounts: &[TermAmount]) -> Vec<String> {
    let text = one.text.replace(char::is_control, " ");
    if changes.iter().all(|change| matches!(change, Change::Drift { .. } | Change::Growth { .. } | Change::Load { .. }))
    {
        return vec![format!("stated: {text}; the entry has the fitted values")];
    }
    let amount = |own: &TermAmount| {
        let TermAmount { term, value, sigma, unit, .. } = own;
        format!("{term} {value:.4} {unit}, 95 %: +-{:.4}", EXPANDED * sigma)
    };
    let all: Vec<String> = amounts.iter().map(amount).collect();
    vec![format!("stated: {text}; {}", all.join("; "))]
}

fn estimate(one: &StatedHypothesis, amount: TermAmount) -> StatedEstimate {
    let TermAmount { term, value, sigma, unit, .. } = amount;
    StatedEstimate { hypothesis: one.text.clone(), term, value, sigma, unit }
}
