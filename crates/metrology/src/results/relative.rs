//! Scales that readings show only relative to those of other axes.
//!
//! Circles of a bar of unknown length are the same if all axes are longer by the same share. A model with the scales of some of these axes fits the
//! differences, and takes the others as they are in the machine file: its uncertainty does not contain theirs. Balls on a turning table, without a known
//! distance, show scales only relative to the stated places of the rotary axes.

use super::calibrated::CalibrationResult;
use super::measurement::{Measurement, data_of};
use super::not_identified::LeftOut;
use super::slope::range;
use crate::calibrate::{Fit, Parameter, identify};
use crate::diagnose::cause::own;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis, ROTARY_AXES};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;
use ncfix_model::motion::EntryFunction;
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::parameter::ParameterName;

/// Names the fitted scales that are relative to scales which neither the model nor the machine file states.
pub(super) fn check(
    machine: &Machine,
    parameters: &[Parameter],
    used: &[Measurement],
    fit: &Fit,
    findings: &mut Vec<Diagnostic>,
) {
    // An axis that stood still in every file has no scale in them, even if it stood at different places.
    let moved =
        |one: &Measurement, axis: Axis| range(std::slice::from_ref(one), axis).is_some_and(|[low, high]| high > low);
    let moves = |axis: &Axis| !axis.is_rotary() && used.iter().any(|one| moved(one, *axis));
    let scales: Vec<(Axis, ParameterName)> =
        AXES.into_iter().filter(moves).map(|axis| (axis, ParameterName::coefficient(own(axis), 1))).collect();
    let is_fitted = |name: &ParameterName| {
        parameters.iter().any(|one| matches!(one, Parameter::Geometry(fitted) if fitted == name))
    };
    let fitted: Vec<String> =
        scales.iter().filter(|(_, name)| is_fitted(name)).map(|(_, name)| name.to_string()).collect();
    let is_stated = |name: &ParameterName| {
        let mut own = fit.errors.motion.iter().filter(|error| error.name == name.component);
        own.any(|error| !matches!(error.function, EntryFunction::Backlash(_)))
    };
    let data = data_of(used);
    let shows_all = |scales: &[(Axis, ParameterName)]| {
        let all: Vec<Parameter> = scales.iter().map(|(_, name)| Parameter::from(*name)).collect();
        identify(machine, &fit.errors, &all, &data).is_some_and(|found| found.lost.leave_out.is_empty())
    };
    // An axis that a laser only stood at does not act on the readings: its scale is not in them.
    let of_unknown: Vec<(Axis, ParameterName)> = scales
        .iter()
        .filter(|(_, name)| !fitted.is_empty() && !is_fitted(name) && !is_stated(name))
        .filter(|scale| shows_all(std::slice::from_ref(*scale)))
        .cloned()
        .collect();
    let unknown: Vec<String> = of_unknown.iter().map(|(axis, _)| axis.to_string()).collect();
    if fitted.is_empty() || unknown.is_empty() {
        return;
    }
    let of_model: Vec<(Axis, ParameterName)> = scales.iter().filter(|(_, name)| is_fitted(name)).cloned().collect();
    let together: Vec<(Axis, ParameterName)> = of_model.iter().chain(&of_unknown).cloned().collect();
    if shows_all(&together) || !shows_all(&of_model) {
        return;
    }
    let are = if fitted.len() > 1 { "are" } else { "is" };
    let count = if unknown.len() > 1 { "count" } else { "counts" };
    let scale = if unknown.len() > 1 { "scales" } else { "scale" };
    let [fitted, unknown] = [fitted, unknown].map(|names| names.join(" and "));
    let message = format!(
        "the readings show only differences of scales: {fitted} {are} relative to the {scale} of {unknown}, which {count} as 0, \
         and the uncertainty does not include that"
    );
    let help = "give a calibrated length (remove length from free), measure the positioning of one axis with a laser, or state the scale of the other axis";
    findings.push(Diagnostic::nowhere(Code::RELATIVE_SCALE, message, help));
}

/// Names fitted scales that the readings of balls cannot separate from an offset of a rotary axis, which the model takes as the machine file states it.
pub(super) fn check_pivots(
    machine: &Machine,
    parameters: &[Parameter],
    used: &[Measurement],
    fit: &Fit,
    findings: &mut Vec<Diagnostic>,
) {
    let Some(found) = pivots(machine, parameters, used, &fit.errors) else { return };
    let [scales, confused] = [found.scales, found.offsets].map(|names| names.join(" and "));
    let message = format!(
        "without a known distance of two balls, the readings cannot separate {scales} from {confused}, which counts as in the \
         machine file: if that is wrong, so are the scales"
    );
    let help = format!(
        "give the distance of two balls in [[length]], measure an axis with a laser, or fit {confused} in place of the scales"
    );
    findings.push(Diagnostic::nowhere(Code::SCALE_BY_PIVOT, message, help));
}

/// Leaves out scales that rest on the stated place of a rotary axis: nobody chose them.
pub(super) fn leave_out_scales(
    (machine, errors): (&Machine, &ErrorModel),
    parameters: &mut Vec<Parameter>,
    used: &[Measurement],
    findings: &mut Vec<Diagnostic>,
    report: &mut CalibrationResult,
) {
    let Some(found) = pivots(machine, parameters, used, errors) else { return };
    parameters.retain(|one| !found.scales.contains(&one.to_string()));
    let [scales, confused] = [&found.scales, &found.offsets].map(|names| names.join(" and "));
    let reason =
        format!("without a known distance of two balls, the readings cannot separate {scales} from {confused}");
    let help = "give the distance of two balls in [[length]], or measure an axis with a laser";
    findings.push(Diagnostic::nowhere(Code::REDUCED, format!("left out: {scales}: {reason}"), help));
    report.left_out.push(LeftOut { parameters: found.scales, reason });
}

/// Scales of a model, and offsets of rotary axes which it takes as stated and from which the readings do not separate the scales.
struct RestingScales {
    scales: Vec<String>,
    offsets: Vec<String>,
}

/// The scales that rest on the place of a rotary axis; `None` without any.
fn pivots(
    machine: &Machine,
    parameters: &[Parameter],
    used: &[Measurement],
    errors: &ErrorModel,
) -> Option<RestingScales> {
    let scale = |axis: Axis| ParameterName::coefficient(own(axis), 1);
    let is_scale = |one: &&Parameter| AXES.into_iter().any(|axis| !axis.is_rotary() && **one == scale(axis).into());
    let scales: Vec<String> = parameters.iter().filter(is_scale).map(ToString::to_string).collect();
    if scales.is_empty() {
        return None;
    }
    let data = data_of(used);
    let shows =
        |all: &[Parameter]| identify(machine, errors, all, &data).is_some_and(|found| found.lost.leave_out.is_empty());
    let without: Vec<Parameter> = parameters.iter().filter(|one| !is_scale(one)).cloned().collect();
    let axes = ROTARY_AXES.into_iter().filter(|axis| machine.axis(*axis).is_some());
    let offsets =
        axes.flat_map(|axis| DIRECTIONS.into_iter().map(move |direction| ErrorName::location(direction, axis)));
    let offsets: Vec<String> = offsets
        .filter(|name| !name.direction.is_rotation())
        .map(ParameterName::location)
        .filter(|name| !parameters.contains(&Parameter::from(*name)))
        .filter(|name| {
            let with = |parameters: &[Parameter]| -> Vec<Parameter> {
                parameters.iter().cloned().chain([Parameter::from(*name)]).collect()
            };
            shows(&with(&without)) && !shows(&with(parameters))
        })
        .map(|name| name.to_string())
        .collect();
    (!offsets.is_empty()).then_some(RestingScales { scales, offsets })
}
