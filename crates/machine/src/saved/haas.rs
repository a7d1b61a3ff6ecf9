//! Numbered blocks of a Haas from RS-232: `N9 V12345`. The numbers of its offsets are not published for all releases, so the file is recognized and refused.

use super::lines::words;
use super::{SavedFormat, SavedLine, SavedValues};
use crate::machine::Machine;
use ncfix_base::diagnostic::Diagnostic;

/// Numbered blocks of a Haas.
pub(super) const FORMAT: SavedFormat = SavedFormat { name: "Haas settings", language: "", is, read };

fn is(lines: &[SavedLine<'_>]) -> bool {
    let is_block = |line: &SavedLine<'_>| matches!(words(&line.text).as_deref(), Some([(b'N', _), (b'V', _)]));
    let blocks = lines.iter().filter(|line| line.text.trim() != "%");
    lines.len() >= 2 && blocks.clone().count() > 0 && blocks.clone().all(is_block)
}

fn read(lines: &[SavedLine<'_>], _machine: &Machine) -> Result<SavedValues, Diagnostic> {
    let message = "numbered blocks state neither the unit nor the meaning of their values";
    let help = "write the offsets as a program with G10 L2 and G10 L10 to L13, or into a .toml file";
    match lines.get(1).or(lines.first()) {
        Some(line) => Err(line.fault(message, help)),
        None => Ok(SavedValues::default()),
    }
}
