//! `ncfix man`: the pages of the manual, made from the definition of the command line.

use std::path::Path;

use clap::Command;

use super::arguments::{EXAMPLES, ManArguments, STATUSES, definition};
use super::exit_code::ExitCode;
use super::output::{Old, Spool, Target};
use super::stop::Stop;
use super::{print, tell};
use ncfix_report::manual::{self, ManualSections};

/// Environment variables of every command.
const ENVIRONMENT: [(&str, &str); 2] = [
    ("NCFIX_MACHINE", "Machine file if --machine is not given; takes precedence over the nearest ncfix.toml."),
    ("NO_COLOR", "If set, diagnostics are printed without colors."),
];

/// Environment variables of `ncfix diff`.
const PAGERS: (&str, &str) = ("NCFIX_PAGER, PAGER", "Pager for long output on a terminal (default: less).");

/// Prints a page, or writes all of them.
pub(super) fn run(arguments: &ManArguments) -> Result<ExitCode, Stop> {
    let mut root = definition().disable_help_subcommand(true);
    root.build();
    if let Some(folder) = &arguments.output {
        std::fs::create_dir_all(folder).map_err(|error| Stop::file("make", folder, &error))?;
        let count = write(&root, "ncfix", folder)?;
        tell(&format!("{count} pages written into {}\n", folder.display()));
        return Ok(ExitCode::Done);
    }
    let mut command = &root;
    let mut path = "ncfix".to_owned();
    for word in &arguments.command {
        command = command.find_subcommand(word).ok_or_else(|| {
            let known: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
            let known = if known.is_empty() { "none".into() } else { known.join(", ") };
            Stop::Usage(format!("'{word}' is not a command of {path}; commands: {known}"))
        })?;
        path = format!("{path} {word}");
    }
    print(&page(command, &path)?)?;
    Ok(ExitCode::Done)
}

/// Writes the page of a command and those of its subcommands; returns their number.
fn write(command: &Command, path: &str, folder: &Path) -> Result<usize, Stop> {
    let file = folder.join(format!("{}.1", path.replace(' ', "-")));
    let text = page(command, path)?;
    let mut spool = Spool::new(Target::new(&file)?)?;
    if let Err(error) = spool.writer().write_all(text.as_bytes()) {
        return Err(spool.fault(&error).into());
    }
    spool.publish(Old::Replaced)?;
    let mut count = 1;
    for inner in command.get_subcommands() {
        count += write(inner, &format!("{path} {}", inner.get_name()), folder)?;
    }
    Ok(count)
}

/// The page of a command.
fn page(command: &Command, path: &str) -> Result<String, Stop> {
    let statuses: Vec<_> = ExitCode::of_command(command.get_name()).map(|(code, text)| (code as u8, text)).collect();
    let pagers = (command.get_name() == "diff").then_some(PAGERS);
    let environment: Vec<_> = ENVIRONMENT.into_iter().chain(pagers).collect();
    let sections = ManualSections {
        statuses: &statuses,
        environment: &environment,
        end_of_description: STATUSES,
        examples: EXAMPLES,
    };
    manual::page(command, path, &sections).map_err(|error| Stop::Usage(error.to_string()))
}
