//! Coverage of a run by the measured ranges of its machine.

use crate::machine::Machine;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_machine::snc::extent::PathExtent;
use ncfix_model::coverage::{Coverage, UsedRanges};
use ncfix_report::coverage::CoverageReport;

/// The coverage of a program that has run, and its gaps: warnings, or errors if coverage is required.
pub(crate) fn of_run(machine: &Machine, extent: &PathExtent, is_required: bool) -> (CoverageReport, Vec<Diagnostic>) {
    let used = UsedRanges { axes: extent.axes().collect(), tools_mm: extent.tools_mm() };
    let coverage = of_ranges(machine, &used);
    (CoverageReport::from(&coverage), coverage.diagnostics(is_required))
}

/// The coverage of positions and tools on a machine in its condition.
pub(crate) fn of_ranges(machine: &Machine, used: &UsedRanges) -> Coverage {
    Coverage::of(&machine.machine, &machine.errors, &machine.condition, used)
}
