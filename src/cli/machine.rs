//! `ncfix machine check` and `ncfix machine show`: one machine file on its own.

use super::arguments::{MachineArguments, MachineCommand};
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::stop::Stop;
use super::{input, print, tell};
use crate::report::machine::table;
use crate::source::FileId;

/// Checks or shows a machine file.
pub(super) fn run(command: &MachineCommand) -> Result<ExitCode, Stop> {
    let (MachineCommand::Check(arguments) | MachineCommand::Show(arguments)) = command;
    let mut findings = Findings::default();
    let chosen = read(arguments, &mut findings)?;
    findings.draw();
    match (command, chosen) {
        (MachineCommand::Show(_), Some(chosen)) => print(&table(&chosen.machine, &chosen.errors))?,
        _ => tell(&format!("{}: {}\n", arguments.file.display(), findings.count())),
    }
    Ok(findings.exit_code())
}

/// Reads the machine file with its set-up files.
fn read(arguments: &MachineArguments, findings: &mut Findings) -> Result<Option<Chosen>, Stop> {
    let source = input::read(&arguments.file, FileId(0))?;
    machine_choice::read(&source, &arguments.setup, findings)
}
