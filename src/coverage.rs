//! Coverage of a run by the measured ranges of its machine.

use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_base::number::significant;
use ncfix_machine::snc::Origin;
use ncfix_machine::snc::extent::PathExtent;
use ncfix_model::coverage::{Coverage, UsedRanges};
use ncfix_report::coverage::CoverageReport;

/// The coverage of a program that has run, and its gaps: warnings, or errors if coverage is required.
pub(crate) fn of_run(machine: &Machine, extent: &PathExtent, is_required: bool) -> (CoverageReport, Vec<Diagnostic>) {
    let used = UsedRanges { axes: extent.axes().collect(), tools_mm: extent.tools_mm() };
    let coverage = of_ranges(machine, &used);
    let mut found = coverage.diagnostics(is_required);
    found.extend(backward_tool(machine, &used, is_required));
    found.extend(extent.unknown().map(|(origin, axes)| unknown_cut(origin, axes, is_required)));
    // A tool change leaves an axis where start_deg has it.
    let is_open = |axis: &Axis| machine.machine.axis(*axis).is_some_and(|data| data.start_rad.is_none());
    let rotary = machine.machine.axis_set().iter().filter(|axis| axis.is_rotary() && is_open(axis)).collect();
    found.extend(extent.unstated(rotary).map(|(origin, axes)| unstated_axes(origin, axes, is_required)));
    (CoverageReport::from(&coverage), found)
}

/// A tool with a negative length: its tip would be inside the spindle, and the arm of the angular errors has the wrong sign.
fn backward_tool(machine: &Machine, used: &UsedRanges, is_required: bool) -> Option<Diagnostic> {
    let lengths_mm = used.tools_mm.iter().flatten().map(|tool_mm| -tool_mm.dot(&machine.machine.spindle.axis));
    let shortest_mm = lengths_mm.fold(f64::INFINITY, f64::min);
    if shortest_mm >= 0.0 || !shortest_mm.is_finite() || machine.model().is_empty() {
        return None;
    }
    let code = if is_required { Code::NOT_COVERED } else { Code::BACKWARD_TOOL };
    let message = format!(
        "a tool of this program has the length {} mm; with a negative length, angular errors are corrected at a wrong place",
        significant(shortest_mm)
    );
    let help =
        "state lengths from the gauge point of the spindle to the tip, and Z of the zero offset for these lengths";
    Some(Diagnostic::nowhere(code, message, help))
}

/// A cut at an unknown position: the error of the machine there is unknown as well.
fn unknown_cut(origin: Origin, axes: AxisSet, is_required: bool) -> Diagnostic {
    let code = if is_required { Code::NOT_COVERED } else { Code::UNKNOWN_CUT };
    let names: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
    let names = names.join(" and ");
    let place = Place { file: origin.file, span: origin.span };
    let message =
        format!("the tool cuts here, and the position of {names} is not known, so the correction is incomplete");
    let help = format!(
        "program {names} before this cut; --start gives the position until the first tool change; \
         if a tool change, or a program that the control itself executes, moves no axis, state it: \
         [[opaque]] with its name (\"M6\") and moves = false"
    );
    Diagnostic::at(code, place, message, help)
}

/// A cut with rotary axes that nothing has positioned: the correction is right only if they are at 0.
fn unstated_axes(origin: Origin, axes: AxisSet, is_required: bool) -> Diagnostic {
    let code = if is_required { Code::NOT_COVERED } else { Code::ROTARY_ASSUMED };
    let names: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
    let zeros: Vec<String> = names.iter().map(|name| format!("{name}0")).collect();
    let (names, zeros) = (names.join(" and "), zeros.join(","));
    let place = Place { file: origin.file, span: origin.span };
    let message = format!("the tool cuts here, and the position of {names} is not stated; the correction is for 0°");
    let sections: Vec<String> = axes.iter().map(|axis| format!("[axis.{axis}]")).collect();
    let sections = sections.join(" and ");
    let help = format!(
        "program {names} before this cut, or state the position: start_deg in {sections} for all programs, or until the first tool change --start X0,Y0,Z0,{zeros}"
    );
    Diagnostic::at(code, place, message, help)
}

/// The coverage of positions and tools on a machine in its condition.
pub(crate) fn of_ranges(machine: &Machine, used: &UsedRanges) -> Coverage {
    Coverage::of(&machine.machine, &machine.errors, &machine.condition, used)
}
