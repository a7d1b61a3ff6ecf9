//! Groups of commands, as listed by the help and the overview, and renamed commands.

use std::ffi::OsString;
use std::fmt::Write as _;

use clap::Command;
use clap::builder::Styles;

/// Groups in the order of the work: a program, measurements, the model fitted to them, the machine, a transfer.
const GROUPS: &[(&str, &[&str])] = &[
    ("Program", &["fix", "check", "snc", "diff", "verify", "max-step"]),
    ("Measure", &["plan", "simulate", "import", "correct-readings", "iso230", "square", "weigh"]),
    ("Model", &["calibrate", "diagnose", "decompose", "sensors"]),
    ("Machine", &["machine", "tables"]),
    ("Live", &["feed", "resume", "realtime"]),
];

/// Commands about ncfix itself.
const HELP: (&str, &[&str]) = ("Help", &["explain", "completions", "man", "help"]);

/// Old names of commands, still accepted, and the new ones.
const RENAMED: &[(&str, &str)] =
    &[("measured", "correct-readings"), ("figures", "iso230"), ("steps", "max-step"), ("load", "weigh")];

/// Description of `help` in a list of commands.
const ABOUT_HELP: &str = "Print the help of a command";

/// One-line description of a command.
fn about(definition: &Command, name: &str) -> String {
    let found = definition.get_subcommands().find(|one| one.get_name() == name);
    found.and_then(Command::get_about).map_or_else(|| ABOUT_HELP.to_owned(), ToString::to_string)
}

/// Width of the longest name plus two blanks.
fn width() -> usize {
    let names = GROUPS.iter().flat_map(|(_, names)| names.iter());
    2 + names.map(|name| name.len()).max().unwrap_or_default()
}

/// The definition whose help lists the commands in groups.
pub(super) fn in_groups(definition: Command) -> Command {
    let (style, width) = (Styles::default(), width());
    let header = style.get_header();
    let literal = style.get_literal();
    let mut list = String::new();
    for (group, names) in GROUPS.iter().chain([&HELP]) {
        // Writing into a String cannot fail.
        let _ = writeln!(list, "{header}{group}:{header:#}");
        for name in *names {
            let about = about(&definition, name);
            let _ = writeln!(list, "  {literal}{name}{literal:#}{:1$}{about}", "", width - name.len());
        }
        list.push('\n');
    }
    let template = format!(
        "{{before-help}}{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}\
         {header}Arguments:{header:#}\n{{positionals}}\n\n{header}Options:{header:#}\n{{options}}{{after-help}}"
    );
    definition.help_template(template)
}

/// Text printed by `ncfix` without arguments: one line per command, no options.
pub(in crate::cli) fn overview(definition: &Command) -> String {
    let width = width();
    let mut out = "Corrects part programs for the measured errors of one machine tool.\n  \
                   ncfix part.mpf -o corrected.mpf --machine mill.toml\n"
        .to_owned();
    for (group, names) in GROUPS {
        for (number, name) in names.iter().enumerate() {
            let head = if number == 0 { *group } else { "" };
            let _ = writeln!(out, "{head:<9}{name:<width$}{}", about(definition, name));
        }
    }
    out.push_str("`ncfix COMMAND --help` lists the options; `ncfix man COMMAND` prints its manual page.\n");
    out
}

/// The old and the new name if a command line uses an old one.
pub(in crate::cli) fn renamed(words: &[OsString]) -> Option<(&'static str, &'static str)> {
    let first = words.iter().skip(1).find(|word| !word.to_string_lossy().starts_with('-'))?;
    RENAMED.iter().copied().find(|(old, _)| first.to_str() == Some(old))
}

#[cfg(test)]
mod tests {
    use super::super::definition;
    use super::*;

    #[test]
    fn every_command_stands_in_one_group() {
        let mut own: Vec<String> = definition().get_subcommands().map(|one| one.get_name().to_owned()).collect();
        let mut listed: Vec<String> =
            GROUPS.iter().chain([&HELP]).flat_map(|(_, names)| names.iter().map(|&name| name.to_owned())).collect();
        listed.retain(|name| name != "help");
        own.sort();
        listed.sort();
        assert_eq!(own, listed);
    }
}
