//! Directions of approach that rest on the order of sorted rows: a calibration takes them as unknown.

use super::measurement::Measurement;
use crate::calibrate::{Parameter, sorted_axes};
use crate::measure::data::DataSet;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;
use ncfix_model::motion::EntryFunction;
use ncfix_model::parameter::ComponentTerm;

/// Sets the directions of these axes in a measurement to unknown.
fn forget(set: &mut DataSet, axes: &[Axis]) {
    for row in &mut set.observations {
        axes.iter().for_each(|axis| row.reading.state.direction[axis.slot()] = 0);
    }
}

/// Takes inferred directions of sorted rows as unknown, and names the files if a backlash makes them matter: a fitted one, one of the errors at the start, or any if the model is automatic.
pub(super) fn take_as_unknown(
    (machine, start): (&Machine, &ErrorModel),
    parameters: &[Parameter],
    is_automatic: bool,
    all: &mut [Measurement],
    findings: &mut Vec<Diagnostic>,
) {
    let is_fitted = |axis: &Axis| {
        parameters.iter().any(|one| match one {
            Parameter::Geometry(name) => name.term == ComponentTerm::Backlash && name.component.axis() == Some(*axis),
            Parameter::Effect(_) => false,
        })
    };
    let is_known = |axis: &Axis| {
        start
            .motion
            .iter()
            .any(|error| error.name.axis() == Some(*axis) && matches!(error.function, EntryFunction::Backlash(_)))
    };
    for one in all {
        let axes = sorted_axes(machine, &one.data);
        forget(&mut one.data, &axes);
        let matters: Vec<&Axis> =
            axes.iter().filter(|axis| is_automatic || is_fitted(axis) || is_known(axis)).collect();
        if matters.is_empty() {
            continue;
        }
        let letters: Vec<String> = matters.iter().map(ToString::to_string).collect();
        let message = format!(
            "{}: the rows are sorted by position, so their order does not state the direction of approach of {}; it counts as unknown, and no \
             backlash is fitted to this file",
            one.sources[0].name(),
            letters.join(" and ")
        );
        let help = format!(
            "if the axes moved in the order of the rows, write order = \"motion\" into [measurement]; if not, add {}_dir with 1 or -1",
            letters.join("_dir and ")
        );
        let place = Place { file: one.sources[0].id(), span: Span::new(0, 0) };
        findings.push(Diagnostic::at(Code::ORDER_UNKNOWN, place, message, help));
    }
}
