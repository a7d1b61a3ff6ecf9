//! Choice of the machine.

use super::arguments::{MachineChoice, StateChoice};
use super::findings::Findings;
use super::state;
use super::stop::Stop;
pub(super) use crate::disk::hash::digest;
pub(super) use crate::disk::machine_file::{FoundFile, locate, read, read_head, source_of};
pub(super) use crate::disk::stated_machine::{self, MachineSearch};
pub(super) use crate::machine::Machine as Chosen;

/// Chooses and reads the machine for `program`; `None` if there are errors.
///
/// # Errors
/// If a named file cannot be read.
pub(super) fn choose<'a>(
    choice: &MachineChoice,
    program: impl Into<MachineSearch<'a>>,
    findings: &mut Findings,
) -> Result<Option<Chosen>, Stop> {
    let MachineChoice { machine, head, setup } = choice;
    Ok(stated_machine::choose((machine.as_deref(), head.as_deref()), setup, program.into(), findings)?)
}

/// Chooses and reads the machine for `program`, in the condition given.
///
/// # Errors
/// If a named file cannot be read.
pub(super) fn choose_in<'a>(
    choice: &MachineChoice,
    condition: &StateChoice,
    program: impl Into<MachineSearch<'a>>,
    findings: &mut Findings,
) -> Result<Option<Chosen>, Stop> {
    let Some(mut chosen) = choose(choice, program, findings)? else { return Ok(None) };
    Ok(state::apply(condition, &mut chosen, findings)?.then_some(chosen))
}
