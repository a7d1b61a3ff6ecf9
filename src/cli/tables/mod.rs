//! `ncfix tables`: makes compensation tables, checks them with the interpolation of the control, reads, draws, compares and converts them.

pub(in crate::cli) mod arguments;
mod write;

use std::path::{Path, PathBuf};

use crate::cli::arguments::TablesArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::machine_choice::{self, Chosen};
use crate::cli::stop::Stop;
use crate::cli::{input, print, tell};
use crate::registry::Registry;
use crate::tables::reread::Reread;
use crate::tables::{Tables, itself, scheme_of};
use ncfix_report::json;
use ncfix_report::tables::{TablesReport, list};

/// Makes or reads tables.
pub(in crate::cli) fn run(arguments: &TablesArguments) -> Result<ExitCode, Stop> {
    if arguments.list {
        print(&list())?;
        return Ok(ExitCode::Done);
    }
    arguments.check_names()?;
    let mut findings = Findings::default();
    let mut report = TablesReport::default();
    let result = if arguments.read.is_empty() {
        make(arguments, &mut report, &mut findings)
    } else {
        reread(arguments, &mut report, &mut findings)
    };
    if !arguments.json || result.is_err() {
        findings.draw();
    }
    result?;
    let goes_out = arguments.output.as_deref().is_some_and(input::is_standard_stream);
    if arguments.json {
        report.diagnostics = findings.json();
        print(&json::line(&report).map_err(Stop::Usage)?)?;
    } else if report.found.tables > 0 {
        if goes_out { tell(&report.page()) } else { print(&report.page())? }
    }
    Ok(findings.exit_code())
}

/// The machine itself, without tables that are active in its control; `None` if there are errors.
fn machine(arguments: &TablesArguments, findings: &mut Findings) -> Result<Option<Chosen>, Stop> {
    arguments.check_ranges()?;
    let beside = arguments.output.as_deref().or(arguments.read.first().map(PathBuf::as_path)).unwrap_or(Path::new("."));
    let chosen = machine_choice::choose_in(&arguments.machine, &arguments.state, beside, findings)?;
    Ok(chosen.filter(|_| !findings.has_errors()).map(|chosen| itself(&chosen)))
}

fn make(arguments: &TablesArguments, report: &mut TablesReport, findings: &mut Findings) -> Result<(), Stop> {
    let Some(format) = arguments.format else {
        return Err(Stop::Usage("give --format; `ncfix tables --list` lists the formats".into()));
    };
    let Some(output) = &arguments.output else {
        return Err(Stop::Usage("give -o, the file to write; -o - for standard output".into()));
    };
    scheme_of(&Registry::default().schemes, &arguments.scheme)?;
    let Some(machine) = machine(arguments, findings)? else { return Ok(()) };
    let made = Tables::make_noting(&machine, format, &arguments.options(), &mut report.found, findings)?;
    if !arguments.check {
        report.found.check = None;
    }
    let Some(made) = made else { return Ok(()) };
    let files = made.files_at(output)?;
    write::publish(arguments, files, &[("", made.inner())], machine.files, report, findings)
}

/// Shows the tables of a control, checks them, compares them and converts them.
fn reread(arguments: &TablesArguments, report: &mut TablesReport, findings: &mut Findings) -> Result<(), Stop> {
    let needs_machine = arguments.machine.machine.is_some() || arguments.check;
    let machine = if needs_machine { machine(arguments, findings)? } else { None };
    if needs_machine && machine.is_none() {
        return Ok(());
    }
    let asked = Reread {
        files: &arguments.read,
        compare: arguments.compare.as_deref(),
        format: arguments.format,
        is_converted: arguments.output.is_some(),
        is_checked: arguments.check,
    };
    let read = asked.run(machine.as_ref(), &arguments.options(), &mut report.found, findings)?;
    let Some(read) = read else { return Ok(()) };
    let files = match (&read.converted, &arguments.output) {
        (Some(tables), Some(output)) => tables.files_at(output)?,
        _ => Vec::new(),
    };
    let sets = match &read.other {
        Some(other) => vec![("first ", &read.tables), ("second ", other)],
        None => vec![("", &read.tables)],
    };
    let inputs = arguments.read.iter().chain(&arguments.compare).cloned().collect();
    write::publish(arguments, files, &sets, inputs, report, findings)
}
