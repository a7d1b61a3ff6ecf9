//! Coverage of a run by the measured ranges of its machine.

use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_base::number::significant;
use ncfix_base::units::{shown_position, um_from_mm};
use ncfix_machine::machine::Tool;
use ncfix_machine::snc::extent::{AssumedAxis, BareTool, PathExtent};
use ncfix_machine::snc::{Origin, WordValue};
use ncfix_model::coverage::{Coverage, UsedRanges};
use ncfix_report::coverage::CoverageReport;

/// Errors below this are no reason for a warning, mm.
const SMALL_MM: f64 = 1e-4;

/// The coverage of a program that has run, and its gaps: warnings, or errors if coverage is required.
pub(crate) fn of_run(machine: &Machine, extent: &PathExtent, is_required: bool) -> (CoverageReport, Vec<Diagnostic>) {
    let used = UsedRanges { axes: extent.axes().collect(), tools_mm: extent.tools_mm() };
    let coverage = of_ranges(machine, &used);
    let mut found = coverage.diagnostics(is_required);
    found.extend(backward_tool(machine, &used, is_required));
    found.extend(extent.bare_tools().iter().filter_map(|bare| bare_tool(machine, &used, bare, is_required)));
    found.extend(extent.unknown().map(|(origin, axes)| unknown_cut(origin, axes, is_required)));
    // A tool change leaves an axis where start_deg has it.
    let begins = |axis: &Axis| machine.machine.axis(*axis).is_some_and(|data| data.start_rad.is_some());
    let rotary: AxisSet = machine.machine.axis_set().iter().filter(|axis| axis.is_rotary()).collect();
    let assumed: Vec<AssumedAxis> = extent.assumed(rotary, rotary.iter().filter(begins).collect()).copied().collect();
    let cuts = assumed.chunk_by(|one, next| one.origin == next.origin && one.has_moved == next.has_moved);
    found.extend(cuts.filter_map(|axes| assumed_axes(axes, is_required)));
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

/// A tool that cuts while the control adds no length: its angular errors are corrected at the gauge point, and not at its tip.
fn bare_tool(machine: &Machine, used: &UsedRanges, bare: &BareTool, is_required: bool) -> Option<Diagnostic> {
    let name = match &bare.tool {
        WordValue::Number(number) => format!("T{number}"),
        WordValue::Name(name) => format!("T \"{}\"", String::from_utf8_lossy(name)),
    };
    let is_own = |tool: &&Tool| match &bare.tool {
        WordValue::Number(number) => f64::from(tool.number) == *number,
        WordValue::Name(name) => tool.name.as_ref().is_some_and(|own| own.as_bytes() == name.as_slice()),
    };
    let tools = &machine.machine.tools;
    let length_of = |tool: &Tool| tool.length_mm[0].abs();
    let own_mm = tools.iter().filter(is_own).map(length_of).reduce(f64::max);
    let length_mm = own_mm.or_else(|| tools.iter().map(length_of).reduce(f64::max))?;
    let tip_mm = machine.machine.spindle.axis * -length_mm;
    let none = ncfix_base::geometry::Vector::zeros();
    let size_mm =
        Coverage::change_with_tool(&machine.machine, &machine.errors, &machine.condition, used, [&none, &tip_mm]);
    if size_mm < SMALL_MM {
        return None;
    }
    let whose = if own_mm.is_some() { "its length in the machine file" } else { "the longest one of the machine file" };
    let message = format!(
        "{name} cuts here, and the control adds no tool length: the correction is for the gauge point of the spindle; with {} mm ({whose}) its tip is up to {} µm off",
        significant(length_mm),
        significant(um_from_mm(size_mm))
    );
    let help = format!(
        "activate the length before this move (G43 H, or D), with the zero offset for it; if the control never adds a length, \
         state the tip as the gauge point: origin_mm in [spindle] includes the tool, and [[tool]] of {name} has length_mm = 0"
    );
    let code = if is_required { Code::NOT_COVERED } else { Code::BARE_TOOL };
    let place = Place { file: bare.origin.file, span: bare.origin.span };
    Some(Diagnostic::at(code, place, message, help))
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

/// A cut with rotary axes at a place that nothing states: the correction is right only if they are where the last motion left them, or at 0.
fn assumed_axes(axes: &[AssumedAxis], is_required: bool) -> Option<Diagnostic> {
    let first = axes.first()?;
    let code = if is_required { Code::NOT_COVERED } else { Code::ROTARY_ASSUMED };
    let joined = |text: &dyn Fn(&AssumedAxis) -> String| axes.iter().map(text).collect::<Vec<_>>().join(" and ");
    let names = joined(&|one| one.axis.to_string());
    let places = match axes.iter().all(|one| one.position == 0.0) {
        true => "0°".to_owned(),
        false => joined(&|one| format!("{} {}°", one.axis, shown_position(true, one.position))),
    };
    let place = Place { file: first.origin.file, span: first.origin.span };
    let (is, help) = if first.has_moved {
        let help = format!(
            "program {names} before this cut: a reference point or a program of the control came after the last motion of {names}, which may be elsewhere now"
        );
        ("no longer known", help)
    } else {
        let sections = joined(&|one| format!("[axis.{}]", one.axis));
        let zeros: Vec<String> = axes.iter().map(|one| format!("{}0", one.axis)).collect();
        let zeros = zeros.join(",");
        let help = format!(
            "program {names} before this cut, or state the position: start_deg in {sections} for all programs, or until the first tool change --start X0,Y0,Z0,{zeros}"
        );
        ("not stated", help)
    };
    let message = format!("the tool cuts here, and the position of {names} is {is}; the correction is for {places}");
    Some(Diagnostic::at(code, place, message, help))
}

/// The coverage of positions and tools on a machine in its condition.
pub(crate) fn of_ranges(machine: &Machine, used: &UsedRanges) -> Coverage {
    Coverage::of(&machine.machine, &machine.errors, &machine.condition, used)
}
