//! The switches of all commands: `--quiet` and `--verbose`.

use std::ffi::{OsStr, OsString};

use clap::{Arg, ArgAction, ArgMatches, Command};

use crate::cli::verbosity::Verbosity;

const QUIET: &str = "quiet";
const VERBOSE: &str = "verbose";

/// Adds the switches to a definition.
pub(super) fn add(command: Command) -> Command {
    let switch = |name: &'static str, help: &'static str| {
        let short = name.chars().next().unwrap_or_default();
        Arg::new(name).short(short).long(name).action(ArgAction::SetTrue).global(true).help(help)
    };
    command.arg(switch(QUIET, "On standard error, print only errors").conflicts_with(VERBOSE)).arg(switch(
        VERBOSE,
        "Also print the version, the files read and how each was found, and the dialect of a program with the reason",
    ))
}

/// Verbosity chosen by the switches.
pub(super) fn verbosity(matches: &ArgMatches) -> Verbosity {
    match (matches.get_flag(QUIET), matches.get_flag(VERBOSE)) {
        (true, _) => Verbosity::Quiet,
        (_, true) => Verbosity::Verbose,
        _ => Verbosity::Usual,
    }
}

/// Moves switches that precede a command after it: clap would take the command for the file of the default command.
pub(super) fn moved_behind(mut words: Vec<OsString>, definition: &Command) -> Vec<OsString> {
    let is_switch =
        |word: &OsStr| word.to_str().is_some_and(|word| matches!(word, "-q" | "-v" | "--quiet" | "--verbose"));
    let count = words.iter().skip(1).take_while(|word| is_switch(word)).count();
    let is_command = words.get(count + 1).is_some_and(|word| definition.find_subcommand(word).is_some());
    if is_command && let Some(front) = words.get_mut(1..=count + 1) {
        front.rotate_right(1);
    }
    words
}
