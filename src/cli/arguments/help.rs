//! The arguments of `ncfix completions` and `ncfix man`, and the exit statuses in the help of every command.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use crate::cli::exit_code::ExitCode;

/// Heading of the exit statuses.
pub(in crate::cli) const STATUSES: &str = "Exit status:\n";

/// Heading of the examples, which come last.
pub(in crate::cli) const EXAMPLES: &str = "Examples:\n";

/// `ncfix completions`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct CompletionsArguments {
    /// Shell
    #[arg(value_name = "SHELL")]
    pub(in crate::cli) shell: Shell,
}

/// `ncfix man`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct ManArguments {
    /// Command, such as fix or machine show (default: the page of ncfix itself)
    #[arg(value_name = "COMMAND")]
    pub(in crate::cli) command: Vec<String>,
    /// Folder for the pages of all commands: ncfix.1, ncfix-fix.1 …
    #[arg(short, long, value_name = "DIR", conflicts_with = "command")]
    pub(in crate::cli) output: Option<PathBuf>,
}

/// The definition with the exit statuses above the examples of every command.
pub(super) fn with_statuses(command: Command) -> Command {
    let mut statuses = String::from(STATUSES);
    for (code, meaning) in ExitCode::of_command(command.get_name()) {
        // Writing into a String cannot fail.
        let _ = writeln!(statuses, "{:>3}  {meaning}", code as u8);
    }
    let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let (said, examples) = text.split_at(text.find(EXAMPLES).unwrap_or(text.len()));
    command.after_help(format!("{said}{statuses}\n{examples}")).mut_subcommands(with_statuses)
}
