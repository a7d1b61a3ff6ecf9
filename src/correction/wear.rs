//! `--compensation wear`: options that it excludes, and a check that the control can follow the output with wear.

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::Options;
use crate::program::Program;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_language::exec::{self, Radius, RapidOrder};
use ncfix_path::path::{FiveAxis, OutputFrame, Rapids};

/// A motion to the contour up to this length is one block, mm: twice the part in which the control receives the wear.
const SHORTEST_STEP_MM: f64 = 10.0;

/// The diagnostic about an output in which G41 is not allowed, or does not lead straight to the contour.
pub(super) fn refusal(choice: &Options) -> Option<Diagnostic> {
    let message = if (choice.frame, choice.five_axis) != (OutputFrame::Work, FiveAxis::Tcp) {
        "--compensation wear is not possible with --frame machine or --five-axis axes: controls do not compensate the radius in blocks with machine coordinates"
    } else if choice.rapids == Rapids::All || choice.step_mm.is_some_and(|step_mm| step_mm < SHORTEST_STEP_MM) {
        "--compensation wear is not possible with --rapids all or a --step below 10 mm: the approach to the contour would have several pieces, with a corner after the first one, where the control begins with the wear"
    } else {
        return None;
    };
    Some(Diagnostic::nowhere(Code::NO_WEAR, message, "remove one of them"))
}

/// Executes a written program as the control would with the largest wear to either side.
///
/// # Errors
/// If it cannot be opened.
pub(super) fn try_both(
    text: &Program,
    largest_mm: f64,
    machine: &Machine,
    findings: &mut Diagnostics,
) -> Result<(), Error> {
    let text = text.clone().without_block_limit();
    for wear_mm in [largest_mm, -largest_mm] {
        let mut own = Diagnostics::default();
        let Some(opened) = text.open(Some(machine), &mut own)? else {
            findings.absorb(own);
            return Ok(());
        };
        let options =
            exec::Options { radius: Radius::Alone(wear_mm), rapid_order: RapidOrder::None, ..exec::Options::default() };
        let mut running = text.start_as(opened, &machine.machine, options);
        // That the way of the tool center is no wall of the part does not matter.
        let is_other = |found: &Diagnostic| found.is_error() || found.code == Code::ELEMENT_LEFT_OUT;
        let Some(found) = running.find_map(|item| item.err().filter(is_other)) else { continue };
        let message = format!("with a wear of {wear_mm:+} mm the control could not follow this: {}", found.message);
        let help = "give the largest wear that will be entered with --largest-wear, or leave out --compensation wear; move heights that the correction shifts sideways before G41 or after G40";
        let finding = Diagnostic { place: found.place, ..Diagnostic::nowhere(Code::NO_WEAR, message, help) };
        findings.add(finding, running.sources());
    }
    Ok(())
}
