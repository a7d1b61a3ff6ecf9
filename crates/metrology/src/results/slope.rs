//! The slope of a straightness that readings do not show.
//!
//! An artifact that lies as it was set up shows the curvature of an axis, but not its slope: that belongs to the squareness of the axis (ISO 230-1). A fitted
//! curvature has its vertex at the zero of the axis, so that without a slope it would tilt the axis by an arbitrary angle.

use super::measurement::{Measurement, data_of};
use crate::calibrate::mean_line::mean_slope;
use crate::calibrate::{Column, Estimate, Fit, Parameter, identify};
use crate::diagnose::cause::own;
use crate::measure::data::DataSet;
use crate::measure::kind::Unknown;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::number::significant;
use ncfix_base::units::urad_from_rad;
use ncfix_machine::machine::Machine;
use ncfix_model::name::{DIRECTIONS, ErrorKind, ErrorName};
use ncfix_model::parameter::{ComponentTerm, ParameterName};

/// Gives every straightness whose curvature was fitted, but whose slope the readings do not show, the slope that makes it straight on average over the
/// measured range.
pub(super) fn level(
    machine: &Machine,
    parameters: &[Parameter],
    used: &[Measurement],
    fit: &mut Fit,
    findings: &mut Vec<Diagnostic>,
) {
    let data = data_of(used);
    for axis in AXES.into_iter().filter(|axis| !axis.is_rotary()) {
        if range(used, axis).is_none_or(|[low, high]| high <= low) {
            continue;
        }
        for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
            let fitted = numbers_of(component, parameters);
            let slope = ParameterName::coefficient(component, 1);
            let is_curve = |name: &ParameterName| match name.term {
                ComponentTerm::Coefficient(degree) | ComponentTerm::Knot { degree, .. } => degree > 1,
                _ => false,
            };
            // A slope of the start file is a measured one.
            if !is_across(component, axis)
                || !fitted.iter().any(is_curve)
                || fitted.contains(&slope)
                || slope.get(&fit.errors) != 0.0
            {
                continue;
            }
            // Alone: beside a squareness in the model, the slope is that of the squareness.
            let is_shown = identify(machine, &fit.errors, &[Parameter::from(slope)], &data)
                .is_some_and(|told| told.lost.leave_out.is_empty());
            if is_shown {
                let has_squareness = parameters.iter().any(|one| {
                    matches!(one, Parameter::Geometry(name)
                        if name.component.kind == ErrorKind::Location && name.component.direction.is_rotation())
                });
                if !has_squareness && is_direct(used, component) {
                    findings.push(left_out(component));
                }
                continue;
            }
            let curve: Vec<ParameterName> = fitted.iter().filter(|name| is_curve(name)).copied().collect();
            let Some([low, high]) = curve_range(machine, fit, &curve, used, axis) else { continue };
            let slope_of = |name: &ParameterName| name.get(&fit.errors) * mean_slope(name, axis, [low, high]);
            let value = -fitted.iter().map(slope_of).sum::<f64>();
            slope.set(&mut fit.errors, value);
            add_slope(fit, (slope, value), &fitted, (axis, [low, high]));
            align(fit, (component, value), &data);
            let message = format!(
                "the readings show the curvature of {component}, but not its slope; ncfix sets {slope} to {} µrad, so that the mean slope of \
                 {axis} from {low} to {high} mm is zero",
                significant(urad_from_rad(value)),
            );
            let help = "measure the squareness of this axis too; until then its slope is not corrected";
            findings.push(Diagnostic::nowhere(Code::SLOPE_NOT_SHOWN, message, help));
        }
    }
}

/// The fitted numbers of a component.
pub(super) fn numbers_of(component: ErrorName, parameters: &[Parameter]) -> Vec<ParameterName> {
    let of = |one: &Parameter| match one {
        Parameter::Geometry(name) if name.component == component => Some(*name),
        _ => None,
    };
    parameters.iter().filter_map(of).collect()
}

/// True for a straightness of an axis.
pub(super) fn is_across(component: ErrorName, axis: Axis) -> bool {
    !component.direction.is_rotation() && component != own(axis)
}

/// Range of the axis in the files that show a curve of it, mm: other files do not extend it.
pub(super) fn curve_range(
    machine: &Machine,
    fit: &Fit,
    curve: &[ParameterName],
    used: &[Measurement],
    axis: Axis,
) -> Option<[f64; 2]> {
    let curve: Vec<Parameter> = curve.iter().copied().map(Parameter::from).collect();
    let shows = |one: &&Measurement| {
        identify(machine, &fit.errors, &curve, std::slice::from_ref(&one.data))
            .is_some_and(|told| told.lost.leave_out.len() < curve.len())
    };
    let ranges = used.iter().filter(shows).filter_map(|one| range(std::slice::from_ref(one), axis));
    let own = ranges.reduce(|[low, high], [from, to]| [low.min(from), high.max(to)]).or(range(used, axis));
    own.filter(|[low, high]| high > low)
}

/// Adds a slope that follows from the fitted curve, with the uncertainty that it has by the curve, so that the mean slope has none. The unknown mean slope is
/// that of the squareness. Its inflation is infinite, because no reading shows it.
fn add_slope(
    fit: &mut Fit,
    (slope, value): (ParameterName, f64),
    fitted: &[ParameterName],
    (axis, range): (Axis, [f64; 2]),
) {
    let own = fit.estimates.iter().filter_map(|one| one.column.parameter());
    let rows: Vec<(f64, &Vec<f64>)> = own
        .zip(&fit.factor)
        .filter_map(|(parameter, row)| {
            let name = fitted.iter().find(|name| Parameter::from(**name) == parameter)?;
            Some((mean_slope(name, axis, range), row))
        })
        .collect();
    let width = rows.iter().map(|(_, row)| row.len()).max().unwrap_or(0);
    let part =
        |at: usize| -> f64 { rows.iter().map(|(share, row)| -share * row.get(at).copied().unwrap_or(0.0)).sum() };
    let row: Vec<f64> = (0..width).map(part).collect();
    let sigma = row.iter().map(|part| part * part).sum::<f64>().sqrt();
    let column = Column::from(Parameter::from(slope));
    fit.estimates.push(Estimate { column, value, sigma, inflation: f64::INFINITY, effect_mm: 0.0 });
    fit.factor.push(row);
}

/// Takes a slope of the axis out of the alignments that contain it.
fn align(fit: &mut Fit, (component, value): (ErrorName, f64), data: &[DataSet]) {
    for one in &mut fit.estimates {
        let Column::Unknown(set, Unknown::Slope(place)) = one.column else { continue };
        // A set-up without readings of the component has no alignment of it.
        if !one.inflation.is_finite() {
            continue;
        }
        let Some(targets) = data.get(set).map(|set| &set.targets) else { continue };
        let own = targets.get(place % targets.len().max(1)).and_then(|name| name.parse::<ErrorName>().ok());
        if own == Some(component) {
            one.value -= value;
        }
    }
}

/// True if an instrument read the component itself.
fn is_direct(used: &[Measurement], component: ErrorName) -> bool {
    used.iter().flat_map(|one| &one.data.observations).any(|row| row.component == Some(component))
}

/// A warning that a slope of the readings is fitted as curvature.
fn left_out(component: ErrorName) -> Diagnostic {
    let message = format!(
        "the readings of {component} may have a slope, but the model has neither {component}1 nor a squareness, so the fitted curvature contains a part of it"
    );
    let help = format!(
        "if the reference was aligned by hand, free its alignment: free = [\"offset\", \"slope\"] in [measurement]; otherwise add {component}1 to --model"
    );
    Diagnostic::nowhere(Code::SLOPE_LEFT_OUT, message, help)
}

/// Measured range of an axis, mm.
pub(super) fn range(used: &[Measurement], axis: Axis) -> Option<[f64; 2]> {
    let all = used.iter().flat_map(|one| &one.data.observations).map(|row| row.reading.position[axis]);
    all.fold(None, |known: Option<[f64; 2]>, value| {
        Some(known.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
    })
}
