//! Programs as commands name them, never written over a file that was read.

use std::path::{Path, PathBuf};

use super::arguments::ProgramChoice;
use super::findings::Findings;
use super::output::Target;
use super::stop::Stop;
use crate::options::Reading;
use crate::program::Program;
use crate::run;
pub(super) use crate::run::is_in_archive;
use ncfix_base::diagnostic::{Code, Diagnostic};

/// A program of the command line.
///
/// # Errors
/// Where the file cannot be read.
pub(super) fn of(path: &Path, choice: &ProgramChoice) -> Result<Program, Stop> {
    Ok(Program::new(run::read(path)?, path, Reading::from(choice)))
}

/// An original and a corrected program of the command line.
///
/// # Errors
/// Where a file cannot be read.
pub(super) fn both(original: &Path, corrected: &Path, choice: &ProgramChoice) -> Result<[Program; 2], Stop> {
    Ok([of(original, choice)?, of(corrected, choice)?])
}

impl From<&ProgramChoice> for Reading {
    fn from(choice: &ProgramChoice) -> Reading {
        let ProgramChoice { dialect, max_blocks, skip, start } = choice;
        Reading { dialect: dialect.clone(), max_blocks: *max_blocks, skip: skip.unwrap_or_default(), start: *start }
    }
}

/// Adds a finding where the output would overwrite one of the files that were read.
pub(super) fn protect<'f>(target: &Target, files: impl IntoIterator<Item = &'f PathBuf>, findings: &mut Findings) {
    protect_with(target, files, "choose another output", findings);
}

/// The same for a command that can overwrite its program.
pub(super) fn protect_program<'f>(
    target: &Target,
    files: impl IntoIterator<Item = &'f PathBuf>,
    findings: &mut Findings,
) {
    let help = "choose another output; to overwrite the program itself and keep it as a .bak file, give --in-place";
    protect_with(target, files, help, findings);
}

fn protect_with<'f>(
    target: &Target,
    files: impl IntoIterator<Item = &'f PathBuf>,
    help: &str,
    findings: &mut Findings,
) {
    if let Some(file) = files.into_iter().find(|file| target.is(file)) {
        findings.add(
            Diagnostic::nowhere(
                Code::WRONG_FILE,
                format!("the output would overwrite {}, which is an input of this run", file.display()),
                help,
            ),
            &[],
        );
    }
}
