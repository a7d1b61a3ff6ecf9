//! The machine file: a TOML document whose every value knows its place.

use crate::diagnostic::Diagnostic;
use crate::source::Source;

use super::Machine;

/// The machine that is built in, for looking at; not for a real machine.
pub const DEMO: &str = include_str!("../../samples/machines/demo.toml");

/// A machine file, parsed.
#[derive(Clone, Debug)]
pub struct MachineFile;

impl MachineFile {
    /// Parses the TOML text.
    ///
    /// # Errors
    /// The findings of text that is no TOML.
    pub fn parse(_source: &Source) -> Result<MachineFile, Vec<Diagnostic>> {
        Ok(MachineFile)
    }
}

/// Reads the machine, without its errors.
#[must_use]
pub fn read_machine(_file: &MachineFile) -> (Option<Machine>, Vec<Diagnostic>) {
    (None, Vec::new())
}

/// Reads a set-up file, `[zero_offset.*]` and `[[tool]]`, into a machine: entries replace or add to what it has.
#[must_use]
pub fn apply_setup(_source: &Source, _machine: &mut Machine) -> Vec<Diagnostic> {
    Vec::new()
}
