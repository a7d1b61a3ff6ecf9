//! Which machine a command is about.

use std::path::Path;

use super::arguments::MachineChoice;
use super::findings::Findings;
use super::stop::Stop;
pub(super) use crate::disk::hash::{digest, short_hash, whole_hash};
pub(super) use crate::disk::machine_file::{Found, Member, locate, members, read, source_of};
pub(super) use crate::machine::Machine as Chosen;

/// Chooses and reads the machine for `program`; `None` where findings forbid to use it.
///
/// # Errors
/// Where a file that was named cannot be read.
pub(super) fn choose(choice: &MachineChoice, program: &Path, findings: &mut Findings) -> Result<Option<Chosen>, Stop> {
    Ok(crate::disk::machine_file::choose(choice.machine.as_deref(), &choice.setup, program, findings)?)
}
