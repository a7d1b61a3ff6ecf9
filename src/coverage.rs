//! Coverage of a run by the measured ranges of its machine.

use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::AxisSet;
use ncfix_machine::snc::Origin;
use ncfix_machine::snc::extent::PathExtent;
use ncfix_model::coverage::{Coverage, UsedRanges};
use ncfix_report::coverage::CoverageReport;

/// The coverage of a program that has run, and its gaps: warnings, or errors if coverage is required.
pub(crate) fn of_run(machine: &Machine, extent: &PathExtent, is_required: bool) -> (CoverageReport, Vec<Diagnostic>) {
    let used = UsedRanges { axes: extent.axes().collect(), tools_mm: extent.tools_mm() };
    let coverage = of_ranges(machine, &used);
    let mut found = coverage.diagnostics(is_required);
    found.extend(extent.unknown().map(|(origin, axes)| unknown_cut(origin, axes, is_required)));
    (CoverageReport::from(&coverage), found)
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
        "program {names} before this cut; for the beginning of a program, --start gives the position; \
         a program of the control that moves no axis is named by [[opaque]] with moves = false"
    );
    Diagnostic::at(code, place, message, help)
}

/// The coverage of positions and tools on a machine in its condition.
pub(crate) fn of_ranges(machine: &Machine, used: &UsedRanges) -> Coverage {
    Coverage::of(&machine.machine, &machine.errors, &machine.condition, used)
}
