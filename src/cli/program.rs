//! Programs as commands open and run them: with their arguments, with a line of progress, and never over a file that was read.

use std::path::{Path, PathBuf};

use super::arguments::ProgramChoice;
use super::findings::Findings;
use super::machine_choice::Chosen;
use super::output::Target;
use super::progress;
use super::stop::Stop;
use crate::options::Reading;
use crate::program::Program;
use crate::run::{self, Subprograms};
pub(super) use crate::run::{Opened, Running, is_in_archive, keep_unit, without_motion};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::Source;
use ncfix_language::exec::{Options, RapidOrder};
use ncfix_machine::machine::Machine;

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

/// Reads the bytes of a program.
///
/// # Errors
/// Where the file cannot be read.
pub(super) fn read(path: &Path) -> Result<Source, Stop> {
    Ok(run::read(path)?)
}

/// Parses the program in `source`; `None` where it was not understood, which findings say.
///
/// # Errors
/// Where the dialect does not exist.
pub(super) fn open(
    source: &Source,
    choice: &ProgramChoice,
    chosen: Option<&Chosen>,
    findings: &mut Findings,
) -> Result<Option<Opened>, Stop> {
    Ok(run::open(source, &Subprograms::Disk(None), &Reading::from(choice), chosen, findings)?)
}

/// Starts a program with a line of progress. With `is_strict` a position that is not known for sure is an error, else a warning; `rapid_order`
/// says which rapid moves are taken apart.
pub(super) fn start<'a>(
    opened: Opened,
    path: &Path,
    choice: &ProgramChoice,
    machine: &'a Machine,
    is_strict: bool,
    rapid_order: RapidOrder,
) -> Running<'a> {
    // In a correction the control loses radius compensation.
    let options = Options { strict: is_strict, tells_compensation: is_strict, rapid_order, ..Options::default() };
    start_as(opened, path, choice, machine, options)
}

/// The same as options say.
pub(super) fn start_as<'a>(
    opened: Opened,
    path: &Path,
    choice: &ProgramChoice,
    machine: &'a Machine,
    options: Options,
) -> Running<'a> {
    let running = Running::start(opened, &Subprograms::of(path), &Reading::from(choice), machine, options);
    running.watched(progress::watch())
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
