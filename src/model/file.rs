//! Reads machine and error model from one file.

use crate::diagnostic::Diagnostic;
use crate::machine::Machine;
use crate::machine::file::{MachineFile, read_machine};
use crate::source::Source;

use super::ErrorModel;

/// Reads a machine file; all findings of the file in one run.
#[must_use]
pub fn load(source: &Source) -> (Option<(Machine, ErrorModel)>, Vec<Diagnostic>) {
    match MachineFile::parse(source) {
        Ok(file) => {
            let (machine, findings) = read_machine(&file);
            (machine.map(|machine| (machine, ErrorModel::default())), findings)
        }
        Err(findings) => (None, findings),
    }
}
