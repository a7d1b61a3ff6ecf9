//! `--select`: which candidates there are, and what is said of the choice among them.

use std::collections::HashMap;
use std::path::Path;

use super::arguments::CalibrateArguments;
use super::findings::Findings;
use super::identifiable;
use super::measurement::Measurement;
use super::parameters;
use super::stop::Stop;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::candidates::{Pieces, of_component, of_motion};
use ncfix_metrology::calibrate::{Change, Gain, Options, Parameter, Refusal, Rule, Selected, select};
use ncfix_metrology::measure::data::DataSet;
use ncfix_model::ErrorModel;
use ncfix_model::name::{ErrorKind, ErrorName};
use ncfix_model::parameter::ParameterName;
use ncfix_model::preset;
use ncfix_report::selection;

/// Candidates at most.
const MOST: usize = 2000;

/// The candidates of `--select`; `None` where findings forbid to use them.
///
/// # Errors
/// Where a word is nothing, or there are too many of them.
pub(super) fn candidates(
    arguments: &CalibrateArguments,
    words: &str,
    machine: &Machine,
    errors: &ErrorModel,
    data: &[DataSet],
    findings: &mut Findings,
) -> Result<Option<Vec<Parameter>>, Stop> {
    let pieces = Pieces { spacing_mm: arguments.knots, degree: arguments.degree };
    let mut all: Vec<Parameter> = Vec::new();
    for word in words.split(',').map(str::trim) {
        if preset::find(word).is_some() || (Path::new(word).is_file() && word != "motion") {
            let Some(found) = parameters::choose(word, machine, errors, findings)? else { return Ok(None) };
            all.extend(found);
        } else if word == "motion" {
            all.extend(of_motion(machine, data, pieces).into_iter().map(Parameter::from));
        } else {
            all.extend(named(word, machine, data, pieces)?.into_iter().map(Parameter::from));
        }
    }
    if all.len() > MOST {
        let count = all.len();
        return Err(Stop::Usage(format!(
            "--select gives {count} candidates, of which {MOST} can be tried; give wider --knots"
        )));
    }
    Ok(Some(all))
}

/// An error with all its terms, or a parameter.
fn named(word: &str, machine: &Machine, data: &[DataSet], pieces: Pieces) -> Result<Vec<ParameterName>, Stop> {
    let component = word.parse::<ErrorName>().ok().filter(|name| name.kind == ErrorKind::Motion);
    let found = match component {
        Some(component) => of_component(component, data, pieces),
        None => vec![word.parse::<ParameterName>().map_err(|_| {
            Stop::Usage(format!(
                "--select {word} is no preset, no error such as EXX, no parameter such as EXX2@150 and no file; motion has all motion errors of the \
                 linear axes"
            ))
        })?],
    };
    match found.iter().find_map(|name| name.component.axis().filter(|&axis| machine.axis(axis).is_none())) {
        Some(axis) => Err(Stop::Usage(format!("--select {word}: the machine {} has no axis {axis}", machine.name))),
        None => Ok(found),
    }
}

/// Chooses and fits.
///
/// # Errors
/// [`Refusal`].
pub(super) fn chosen(
    arguments: &CalibrateArguments,
    machine: &Machine,
    start: &ErrorModel,
    base: &[Parameter],
    candidates: &[Parameter],
    data: &[DataSet],
) -> Result<(Selected, selection::Selection), Refusal> {
    let rule = Rule { significance: arguments.significance, ..Rule::default() };
    let options = Options { robust: !arguments.no_robust };
    let found = select(machine, start, base, candidates, data, options, rule)?;
    let report = told(&found, rule, data);
    Ok((found, report))
}

/// Adds findings for a choice that is not possible.
pub(super) fn refuse(refusal: Refusal, all: &[Measurement], findings: &mut Findings) {
    match refusal {
        Refusal::Fault(fault) => identifiable::refuse(fault, "", all, findings),
        Refusal::TooLarge { equations, columns } => {
            let message =
                format!("{equations} readings times {columns} parameters and candidates are more than fit into memory");
            let help = "name fewer candidates, or give wider --knots";
            findings.add(Diagnostic::nowhere(Code::NOT_TOLD, message, help), &[]);
        }
    }
}

fn told(found: &Selected, rule: Rule, data: &[DataSet]) -> selection::Selection {
    let choice = &found.choice;
    let name = |number: usize| found.candidates.get(number).map_or_else(String::new, Parameter::to_string);
    let gain = |gain: Gain| selection::Gain {
        before: gain.before,
        after: gain.after,
        gain: gain.share,
        error: gain.uncertainty,
    };
    let steps = choice.steps.iter().map(|step| selection::Step {
        change: match step.change {
            Change::Entered | Change::Replaced(_) => "in",
            Change::Left => "out",
            Change::NotSignificant => "not significant",
            Change::NoGain => "no gain",
        },
        name: name(step.candidate),
        instead_of: match step.change {
            Change::Replaced(other) => Some(name(other)),
            _ => None,
        },
        t: step.t,
        freedom: step.freedom,
        p: step.p,
        correlation: step.correlation,
    });
    let terms = choice.terms.iter().map(|term| selection::Term {
        name: name(term.candidate),
        t: term.t,
        freedom: term.freedom,
        p: term.p,
        held_out: gain(term.gain),
        rivals: term.rivals.iter().map(|rival| name(rival.candidate)).collect(),
    });
    let correlation = choice.correlation.iter().filter_map(|&(group, correlation)| {
        let set = data.get(group / 2)?;
        let name = if group % 2 == 1 { format!("{}, angles", set.name) } else { set.name.clone() };
        Some(selection::Correlation { name, correlation })
    });
    selection::Selection {
        tried: choice.tried,
        significance: rule.significance,
        not_told: not_told(found),
        steps: steps.collect(),
        terms: terms.collect(),
        correlation: correlation.collect(),
        held_out: choice.gain.filter(|gain| gain.uncertainty.is_finite()).map(gain),
        passes: found.passes,
        is_settled: found.is_settled,
    }
}

/// Candidates that are not told; an error of which no term is told has one entry.
fn not_told(found: &Selected) -> Vec<String> {
    let component = |parameter: &Parameter| match parameter {
        Parameter::Geometry(name) => Some(name.component),
        Parameter::Effect(_) => None,
    };
    let mut terms: HashMap<ErrorName, usize> = HashMap::new();
    for name in found.candidates.iter().filter_map(component) {
        *terms.entry(name).or_default() += 1;
    }
    let lost: Vec<&Parameter> =
        found.choice.not_told.iter().filter_map(|&number| found.candidates.get(number)).collect();
    let mut names = Vec::new();
    let mut whole: Vec<ErrorName> = Vec::new();
    for &parameter in &lost {
        let own = component(parameter);
        let count = lost.iter().filter(|other| own.is_some() && component(other) == own).count();
        match own.filter(|name| count > 1 && terms.get(name) == Some(&count)) {
            Some(name) if whole.contains(&name) => {}
            Some(name) => {
                whole.push(name);
                names.push(format!("{name} (all {count} terms)"));
            }
            None => names.push(parameter.to_string()),
        }
    }
    names
}
