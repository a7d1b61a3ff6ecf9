//! Commands that may run for long before they print anything.

use super::{Command, MachineCommand};

impl Command {
    /// Name of a command that may run for long before it prints anything; `None` if it prints as it goes.
    pub(in crate::cli) fn silent_work(&self) -> Option<&'static str> {
        Some(match self {
            Command::Fix(_) => "fix",
            Command::Check(_) => "check",
            Command::Snc(arguments) if arguments.output.is_some() => "snc",
            Command::Verify(_) => "verify",
            Command::Diff(_) => "diff",
            Command::Measured(_) => "correct-readings",
            Command::Steps(_) => "max-step",
            Command::Load(_) => "weigh",
            Command::Diagnose(_) => "diagnose",
            Command::Decompose(_) => "decompose",
            Command::Sensors(arguments) if !arguments.watch => "sensors",
            Command::Feed(_) => "feed",
            Command::Realtime(_) => "realtime",
            Command::Resume(_) => "resume",
            Command::Plan(_) => "plan",
            Command::Calibrate(_) => "calibrate",
            Command::Simulate(_) => "simulate",
            Command::Figures(_) => "iso230",
            Command::Tables(_) => "tables",
            // A question of `machine new` must stay on its line.
            Command::Machine(MachineCommand::New(_)) | Command::Square(_) => return None,
            Command::Machine(_) => "machine",
            Command::Snc(_) | Command::Sensors(_) => return None,
            Command::Explain(_) | Command::Completions(_) | Command::Import(_) | Command::Man(_) => return None,
        })
    }
}
