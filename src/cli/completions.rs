//! `ncfix completions`: a script with which a shell completes commands and options.

use super::arguments::{CompletionsArguments, definition};
use super::exit_code::ExitCode;
use super::print;
use super::stop::Stop;

/// Prints the script.
pub(super) fn run(arguments: &CompletionsArguments) -> Result<ExitCode, Stop> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut definition(), "ncfix", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::Done)
}
