//! `ncfix man`: the pages of the manual, made from the definition of the command line.

use std::io;
use std::path::Path;

use clap::Command;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};

use super::arguments::{EXAMPLES, ManArguments, STATUSES, definition};
use super::exit_code::ExitCode;
use super::output::{Old, Spool, Target};
use super::stop::Stop;
use super::{print, tell};

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
    print(&page(command, &path).map_err(|error| Stop::Usage(error.to_string()))?)?;
    Ok(ExitCode::Done)
}

/// Writes the page of a command and those of its subcommands; returns their number.
fn write(command: &Command, path: &str, folder: &Path) -> Result<usize, Stop> {
    let file = folder.join(format!("{}.1", path.replace(' ', "-")));
    let text = page(command, path).map_err(|error| Stop::Usage(error.to_string()))?;
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
fn page(command: &Command, path: &str) -> io::Result<String> {
    let mut out = Vec::new();
    let source = concat!("ncfix ", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command.clone()).title(path.replace(' ', "-")).source(source).manual("ncfix");
    man.render_title(&mut out)?;
    man.render_name_section(&mut out)?;
    man.render_synopsis_section(&mut out)?;
    man.render_description_section(&mut out)?;
    let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let (said, rest) = text.split_at(text.find(STATUSES).unwrap_or(text.len()));
    let mut roff = Roff::new();
    said.split("\n\n").for_each(|block| paragraph(&mut roff, block));
    roff.to_writer(&mut out)?;
    man.render_options_section(&mut out)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut out)?;
    }
    let mut roff = Roff::new();
    roff.control("SH", ["EXIT STATUS"]);
    for (code, meaning) in ExitCode::of_command(command.get_name()) {
        term(&mut roff, &(code as u8).to_string(), meaning);
    }
    roff.control("SH", ["ENVIRONMENT"]);
    let pagers = (command.get_name() == "diff").then_some(&PAGERS);
    ENVIRONMENT.iter().chain(pagers).for_each(|(name, meaning)| term(&mut roff, name, meaning));
    if let Some((_, examples)) = rest.split_once(EXAMPLES) {
        roff.control("SH", ["EXAMPLES"]);
        paragraph(&mut roff, examples);
    }
    if let Some((above, _)) = path.rsplit_once(' ') {
        roff.control("SH", ["SEE ALSO"]);
        roff.text([bold(above.replace(' ', "-")), roman("(1)")]);
    }
    roff.to_writer(&mut out)?;
    String::from_utf8(out).map_err(io::Error::other)
}

/// A term and what it means.
fn term(roff: &mut Roff, name: &str, meaning: &str) {
    roff.control("TP", []);
    roff.text([bold(name)]);
    roff.text([roman(meaning)]);
}

/// A paragraph; lines that are indented are a table or examples and stay lines.
fn paragraph(roff: &mut Roff, block: &str) {
    if block.trim().is_empty() {
        return;
    }
    roff.control("PP", []);
    let is_table = block.lines().any(|line| line.starts_with(' '));
    if is_table {
        roff.control("nf", []);
    }
    block.lines().for_each(|line| {
        roff.text([roman(line)]);
    });
    if is_table {
        roff.control("fi", []);
    }
}
