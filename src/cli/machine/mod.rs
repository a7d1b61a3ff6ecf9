//! `ncfix machine check` and `ncfix machine show`: one machine file on its own, and its errors at a pose.

pub(in crate::cli) mod arguments;
mod new;
mod presets;

use std::path::Path;

use crate::cli::arguments::{MachineArguments, MachineCommand, ShowArguments};
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::machine_choice::{self, Chosen, FoundFile};
use crate::cli::stop::Stop;
use crate::cli::{print, state, tell};
use crate::disk::origin;
use crate::tool::ToolVector;
use ncfix_base::geometry::Vector;
use ncfix_base::source::Source;
use ncfix_report::json;
use ncfix_report::machine::table;
use ncfix_report::shares::Shares;

/// Checks, shows or writes a machine file, or shows the presets of its error model.
pub(in crate::cli) fn run(command: &MachineCommand) -> Result<ExitCode, Stop> {
    match command {
        MachineCommand::Check(arguments) => check(arguments),
        MachineCommand::Show(arguments) => show(arguments),
        MachineCommand::Presets(arguments) => presets::run(arguments),
        MachineCommand::New(arguments) => new::run(arguments),
    }
}

fn check(arguments: &MachineArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let doubts = read(arguments, &mut findings)?.map(|chosen| chosen.doubts());
    findings.extend(doubts.unwrap_or_default(), &[]);
    findings.draw();
    tell(&format!("{}: {}\n", name(arguments), findings.count()));
    Ok(findings.exit_code())
}

fn show(arguments: &ShowArguments) -> Result<ExitCode, Stop> {
    if arguments.json && !arguments.origin && arguments.at.is_none() {
        let sentence = "--json shows the errors at a pose or the origin of values: give --at or --origin";
        return Err(Stop::Usage(sentence.into()));
    }
    let mut findings = Findings::default();
    let chosen = read(&arguments.file, &mut findings)?;
    let of_head = |chosen: Chosen| chosen.with_shown_head(arguments.head.as_deref(), arguments.at.is_some());
    let mut chosen = chosen.map(of_head).transpose()?;
    if arguments.origin {
        return show_origin(arguments, chosen.is_some(), &findings);
    }
    if let Some(found) = &mut chosen
        && arguments.at.is_some()
        && !state::apply(&arguments.state, found, &mut findings)?
    {
        chosen = None;
    }
    if let (Some(chosen), Some(at)) = (&chosen, arguments.at) {
        chosen.check_pose(&at)?;
    } else if arguments.at.is_none() && (!arguments.state.state.is_empty() || arguments.state.load.is_some()) {
        return Err(Stop::Usage("--state and --load take effect only at a pose: give --at".into()));
    }
    let shares = chosen.as_ref().zip(arguments.at).map(|(chosen, at)| Shares {
        found: chosen.shares(&at, arguments.tool.unwrap_or_else(gauge_point), &arguments.sense.unwrap_or_default()),
        diagnostics: findings.json(),
    });
    if let (Some(shares), true) = (&shares, arguments.json) {
        print(&json::line(shares).map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    match (chosen, shares) {
        (_, Some(shares)) => print(&shares.table())?,
        (Some(chosen), None) => print(&table(&chosen.machine, &chosen.errors))?,
        (None, None) => tell(&format!("{}: {}\n", name(&arguments.file), findings.count())),
    }
    Ok(findings.exit_code())
}

/// Gauge point of the spindle, the default tool.
fn gauge_point() -> ToolVector {
    ToolVector::Tip(Vector::zeros())
}

/// Shows the source of every value of a machine.
fn show_origin(arguments: &ShowArguments, is_sound: bool, findings: &Findings) -> Result<ExitCode, Stop> {
    findings.draw();
    if !is_sound {
        tell(&format!("{}: {}\n", name(&arguments.file), findings.count()));
        return Ok(findings.exit_code());
    }
    let (source, found) = locate(&arguments.file, &mut Findings::default())?;
    let origins = origin::origins(&source, found, &arguments.file.setup)?;
    print(&if arguments.json { json::line(&origins).map_err(Stop::Usage)? } else { origins.table() })?;
    Ok(findings.exit_code())
}

/// Name of the machine in a sentence.
fn name(arguments: &MachineArguments) -> String {
    arguments.file.as_ref().map_or_else(|| "the machine file".to_owned(), |file| file.display().to_string())
}

/// The text of the machine file, and how it was found.
fn locate(arguments: &MachineArguments, findings: &mut Findings) -> Result<(Source, FoundFile), Stop> {
    let (path, found) = match &arguments.file {
        Some(file) => (Some(file.clone()), FoundFile::Named),
        // No program has a folder to search for a machine file.
        None => machine_choice::locate(None, Path::new("-")),
    };
    Ok((machine_choice::source_of(path.as_deref(), found, findings)?, found))
}

/// Reads the machine file with its set-up files.
fn read(arguments: &MachineArguments, findings: &mut Findings) -> Result<Option<Chosen>, Stop> {
    let (source, _) = locate(arguments, findings)?;
    Ok(machine_choice::read(&source, &arguments.setup, findings)?)
}
