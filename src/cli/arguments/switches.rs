//! The switches of all commands: `--quiet` and `--verbose`.

use std::ffi::{OsStr, OsString};

use clap::{Arg, ArgAction, ArgMatches, Command};

use crate::cli::voice::Voice;

const QUIET: &str = "quiet";
const VERBOSE: &str = "verbose";

/// Adds them to a definition.
pub(super) fn add(command: Command) -> Command {
    let switch = |name: &'static str, help: &'static str| {
        let short = name.chars().next().unwrap_or_default();
        Arg::new(name).short(short).long(name).action(ArgAction::SetTrue).global(true).help(help)
    };
    command
        .arg(
            switch(QUIET, "Say errors only: no warnings, no tables beside the result, no progress")
                .conflicts_with(VERBOSE),
        )
        .arg(switch(VERBOSE, "Say which files were read and how each was found, the dialect and why, and the version"))
}

/// What they choose.
pub(super) fn voice(matches: &ArgMatches) -> Voice {
    match (matches.get_flag(QUIET), matches.get_flag(VERBOSE)) {
        (true, _) => Voice::Quiet,
        (_, true) => Voice::Verbose,
        _ => Voice::Usual,
    }
}

/// Words with the switches that stand before a command moved behind it: clap takes what follows an option of the command without a name
/// for the file of that command.
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
