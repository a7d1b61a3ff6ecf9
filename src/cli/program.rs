//! Programs as commands name them, never written over a file that was read.

use std::path::Path;

use super::arguments::ProgramChoice;
use super::stop::Stop;
pub(super) use crate::disk::output::{protect, protect_program};
use crate::options::ProgramReading;
use crate::program::Program;
use crate::run;
pub(super) use crate::run::is_in_archive;

/// A program of the command line.
///
/// # Errors
/// If the file cannot be read.
pub(super) fn of(path: &Path, choice: &ProgramChoice) -> Result<Program, Stop> {
    Ok(Program::new(run::read(path)?, path, ProgramReading::from(choice)))
}

/// An original and a corrected program of the command line.
///
/// # Errors
/// If a file cannot be read.
pub(super) fn both(original: &Path, corrected: &Path, choice: &ProgramChoice) -> Result<[Program; 2], Stop> {
    Ok([of(original, choice)?, of(corrected, choice)?])
}

impl From<&ProgramChoice> for ProgramReading {
    fn from(choice: &ProgramChoice) -> ProgramReading {
        let ProgramChoice { dialect, max_blocks, skip, start } = choice;
        ProgramReading {
            dialect: dialect.clone(),
            max_blocks: *max_blocks,
            skip: skip.unwrap_or_default(),
            start: *start,
        }
    }
}
