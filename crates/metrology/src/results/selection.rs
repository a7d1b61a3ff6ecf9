//! The selection of parameters: steps, terms with alternatives, gain on left-out readings.

use std::collections::HashMap;

use serde::Serialize;

use super::measurement::Measurement;
use super::not_identified;
use crate::calibrate::{Parameter, Refusal, Rule, Selected};
use crate::measure::data::DataSet;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::numeric::stepwise;
use ncfix_model::name::ErrorName;

/// The selection among candidates.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Selection {
    /// Number of identifiable candidates that were tried.
    pub tried: usize,
    /// Probability of accepting anything if there is no effect.
    pub significance: f64,
    /// Unidentifiable candidates, by themselves or in addition to the fixed parameters.
    #[serde(rename = "not_told")]
    pub not_identified: Vec<String>,
    /// Steps of the last selection.
    pub steps: Vec<SelectionStep>,
    /// Selected terms.
    pub terms: Vec<SelectedTerm>,
    /// Autocorrelation of neighboring readings, by measurement.
    pub correlation: Vec<Correlation>,
    /// Gain of all terms on left-out readings, with the selection repeated in every fold; `null` if nothing was selected.
    pub held_out: Option<HoldoutGain>,
    /// Number of alternations between selection and fit.
    pub passes: usize,
    /// True if the last selection equals the previous one.
    pub is_settled: bool,
}

/// A step.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SelectionStep {
    /// Kind of change.
    pub change: StepChange,
    /// The candidate.
    pub name: String,
    /// The candidate that it replaced.
    pub instead_of: Option<String>,
    /// Its t value; F is its square.
    pub t: f64,
    /// Effective degrees of freedom.
    pub freedom: f64,
    /// p-value, times the number of candidates.
    pub p: f64,
    /// Assumed autocorrelation.
    pub correlation: f64,
}

/// Change of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum StepChange {
    /// The candidate was added.
    #[default]
    #[serde(rename = "in")]
    In,
    /// The candidate was removed.
    #[serde(rename = "out")]
    Out,
    /// It was not significant.
    #[serde(rename = "not significant")]
    NotSignificant,
    /// It did not improve the prediction of left-out readings.
    #[serde(rename = "no gain")]
    NoGain,
}

impl StepChange {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            StepChange::In => "in",
            StepChange::Out => "out",
            StepChange::NotSignificant => "not significant",
            StepChange::NoGain => "no gain",
        }
    }
}

/// A selected term.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SelectedTerm {
    /// The parameter.
    pub name: String,
    /// Its t value.
    pub t: f64,
    /// Effective degrees of freedom.
    pub freedom: f64,
    /// p-value, times the number of candidates.
    pub p: f64,
    /// Gain on left-out readings, in addition to the other terms.
    pub held_out: HoldoutGain,
    /// Candidates that are not distinguishable from it.
    pub rivals: Vec<String>,
}

/// Residuals of left-out readings, in units of their uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HoldoutGain {
    /// RMS without it.
    pub before: f64,
    /// RMS with it.
    pub after: f64,
    /// Relative reduction of the squares.
    pub gain: f64,
    /// Its standard error, over blocks.
    pub error: f64,
}

/// Autocorrelation of neighboring readings.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Correlation {
    /// The measurement; its angles are separate if it also has lengths.
    pub name: String,
    /// The autocorrelation.
    pub correlation: f64,
}

/// Adds diagnostics for an impossible selection.
pub(super) fn refuse(refusal: Refusal, all: &[Measurement], findings: &mut Vec<Diagnostic>) {
    match refusal {
        Refusal::Fault(fault) => not_identified::refuse(fault, "", all, findings),
        Refusal::TooLarge { equations, columns } => {
            let message =
                format!("{equations} readings times {columns} parameters and candidates do not fit into memory");
            let help = "name fewer candidates, or give wider --knots";
            findings.push(Diagnostic::nowhere(Code::NOT_TOLD, message, help));
        }
    }
}

/// The result of the selection, with names and numbers for the report.
pub(super) fn told(found: &Selected, rule: Rule, data: &[DataSet]) -> Selection {
    let choice = &found.choice;
    let name = |number: usize| found.candidates.get(number).map_or_else(String::new, Parameter::to_string);
    let gain = |gain: stepwise::Gain| HoldoutGain {
        before: gain.before,
        after: gain.after,
        gain: gain.share,
        error: gain.uncertainty,
    };
    let steps = choice.steps.iter().map(|step| SelectionStep {
        change: match step.change {
            stepwise::Change::Entered | stepwise::Change::Replaced(_) => StepChange::In,
            stepwise::Change::Left => StepChange::Out,
            stepwise::Change::NotSignificant => StepChange::NotSignificant,
            stepwise::Change::NoGain => StepChange::NoGain,
        },
        name: name(step.candidate),
        instead_of: match step.change {
            stepwise::Change::Replaced(other) => Some(name(other)),
            _ => None,
        },
        t: step.t,
        freedom: step.freedom,
        p: step.p,
        correlation: step.correlation,
    });
    let terms = choice.terms.iter().map(|term| SelectedTerm {
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
        Some(Correlation { name, correlation })
    });
    Selection {
        tried: choice.tried,
        significance: rule.significance,
        not_identified: names_not_identified(found),
        steps: steps.collect(),
        terms: terms.collect(),
        correlation: correlation.collect(),
        held_out: choice.gain.filter(|gain| gain.uncertainty.is_finite()).map(gain),
        passes: found.passes,
        is_settled: found.is_settled,
    }
}

/// Unidentifiable candidates; an error without any identifiable term has one entry.
fn names_not_identified(found: &Selected) -> Vec<String> {
    let component = |parameter: &Parameter| match parameter {
        Parameter::Geometry(name) => Some(name.component),
        Parameter::Effect(_) => None,
    };
    let mut terms: HashMap<ErrorName, usize> = HashMap::new();
    for name in found.candidates.iter().filter_map(component) {
        *terms.entry(name).or_default() += 1;
    }
    let lost: Vec<&Parameter> =
        found.choice.not_identified.iter().filter_map(|&number| found.candidates.get(number)).collect();
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
