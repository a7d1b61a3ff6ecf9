//! Statements that a Sinumerik rejects in its current state. `docs/reference/states.md` has the table.

use super::gathered::Gathered;
use super::modal::Modal;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Rejects words that the state before the block does not allow.
pub(super) fn check_state(modal: &Modal, gathered: &Gathered, span: Span) -> Result<(), Fault> {
    if modal.contour.compensates() {
        check_compensation(gathered, span)?;
    }
    if modal.transform.turning().is_some() && gathered.is_reference {
        let message =
            "G74 or G75 under TRAORI: the control does not move the axes of a transformation to a machine point";
        return Err(fault(Code::FORBIDDEN_STATE, span, message, "end it with TRAFOOF first"));
    }
    Ok(())
}

/// Programming manual, "reference point approach" and "fixed-point approach": only without radius compensation and without transformation. A tool
/// change moves the machine, and the start or end of a transformation changes the meaning of the contour.
fn check_compensation(gathered: &Gathered, span: Span) -> Result<(), Fault> {
    let found = if gathered.is_reference {
        Some("G74 or G75")
    } else if gathered.tool_change {
        Some("a tool change (M6)")
    } else {
        gathered.transform.switch.map(|(name, _)| name)
    };
    let Some(what) = found else { return Ok(()) };
    let message = format!("{what} while radius compensation is on");
    let help = "program G40 with a motion in the plane before it";
    Err(fault(Code::BAD_COMPENSATION, span, message, help))
}
