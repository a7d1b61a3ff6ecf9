//! Squareness errors that the readings show and a stated model lacks.
//!
//! A model that a person states may have no term for the angle between two axes, although the readings show it. Straightness errors and the zeros of
//! rotary axes then absorb a part of the angle, often without a residual, and are wrong elsewhere.

use super::measurement::{Measurement, data_of};
use super::not_shown::lacking;
use crate::calibrate::{Estimate, FitOptions, Parameter, fit, identify};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::significant;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// Multiple of its standard uncertainty from which an angle is certain.
const CERTAIN: f64 = 5.0;
/// Smallest angle that matters, rad: 1 µm over 1 m.
const MATTERS_RAD: f64 = 1e-6;
/// Variance inflation beyond which the readings hardly separate the angle from the model.
const SEPARATE: f64 = 1e4;
/// Product of readings and parameters beyond which a second fit would take too long.
const MOST: usize = 5_000_000;

/// Warns of each squareness that a fit of the model with it finds with certainty; returns their names.
pub(super) fn check(
    (machine, start): (&Machine, &ErrorModel),
    parameters: &[Parameter],
    used: &[Measurement],
    options: FitOptions,
    findings: &mut Vec<Diagnostic>,
) -> Vec<String> {
    let data = data_of(used);
    let rows: usize = data.iter().map(|set| set.observations.len()).sum();
    if rows.saturating_mul(parameters.len()) > MOST {
        return Vec::new();
    }
    let missing: Vec<Parameter> = lacking(machine, start, parameters).into_iter().map(Parameter::from).collect();
    let is_separate = |name: &&Parameter| {
        let with: Vec<Parameter> = parameters.iter().chain([*name]).cloned().collect();
        let found = identify(machine, start, &with, &data);
        found.is_some_and(|found| found.inflation.get(parameters.len()).is_some_and(|inflation| *inflation < SEPARATE))
    };
    let shown: Vec<Parameter> = missing.iter().filter(is_separate).cloned().collect();
    if shown.is_empty() {
        return Vec::new();
    }
    let with: Vec<Parameter> = parameters.iter().chain(&shown).cloned().collect();
    let Ok(found) = fit(machine, start, &with, &data, options) else { return Vec::new() };
    let certain: Vec<&Estimate> = found
        .estimates
        .iter()
        .filter(|one| one.column.parameter().is_some_and(|name| shown.contains(&name)))
        .filter(|one| one.value.abs() > (CERTAIN * one.sigma).max(MATTERS_RAD))
        .collect();
    if certain.is_empty() {
        return Vec::new();
    }
    let names: Vec<String> = certain.iter().filter_map(|one| Some(one.column.parameter()?.to_string())).collect();
    let value = |(name, one): (&String, &&Estimate)| {
        let [value, sigma] = [one.value, one.sigma].map(|rad| significant(1e6 * rad));
        format!("{name} = {value} ± {sigma} µrad")
    };
    let values: Vec<String> = names.iter().zip(&certain).map(value).collect();
    let message = format!(
        "the readings show a squareness that the model lacks: {}; other parameters have absorbed a part of it",
        values.join(", ")
    );
    let help = "add it to --model, or let ncfix choose the parameters: without --model, calibrate fits all that the readings determine";
    findings.push(Diagnostic::nowhere(Code::SQUARENESS_OMITTED, message, help));
    names
}
