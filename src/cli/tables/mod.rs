//! `ncfix tables`: makes compensation tables, checks them with the interpolation of the control, reads, draws, compares and converts them.

pub(in crate::cli) mod arguments;

use std::path::{Path, PathBuf};

use crate::cli::arguments::TablesArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::feed::keys::Keys;
use crate::cli::findings::Findings;
use crate::cli::machine_choice::{self, Chosen};
use crate::cli::output::Target;
use crate::cli::stop::Stop;
use crate::cli::{input, print, program, tell};
use crate::disk::machine_file::is_toml;
use crate::registry::Registry;
use crate::tables::live::LiveTables;
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
    arguments.options().check_unique()?;
    let mut findings = Findings::default();
    let mut report = TablesReport::default();
    let result = if arguments.read.is_empty() {
        make(arguments, &mut report, &mut findings)
    } else {
        reread(arguments, &mut report, &mut findings).map(|()| None)
    };
    if !arguments.json || result.is_err() {
        findings.draw();
    }
    let live = result?;
    let goes_out = arguments.output.as_deref().is_some_and(input::is_standard_stream);
    if arguments.json {
        report.diagnostics = findings.json();
        print(&json::line(&report).map_err(Stop::Usage)?)?;
    } else if report.found.tables > 0 {
        if goes_out { tell(&report.page()) } else { print(&report.page())? }
    }
    if let Some(live) = live {
        let keys = Keys::new()?;
        live.run(arguments.renewal(), || keys.pressed(), Findings::draw, print)?;
    }
    Ok(findings.exit_code())
}

/// The machine itself, without tables that are active in its control; `None` if there are errors.
fn machine(arguments: &TablesArguments, findings: &mut Findings) -> Result<Option<Chosen>, Stop> {
    let chosen = machine_choice::choose_in(&arguments.machine, &arguments.state, beside(arguments), findings)?;
    Ok(chosen.filter(|_| !findings.has_errors()).map(|chosen| itself(&chosen)))
}

/// The text of the machine file.
fn text(arguments: &TablesArguments, findings: &mut Findings) -> Result<String, Stop> {
    let (path, found) = machine_choice::locate(arguments.machine.machine.as_deref(), beside(arguments));
    let source = machine_choice::source_of(path.as_deref(), found, &mut Findings::default())?;
    program::protect(&Target::new(arguments.output.as_deref().unwrap_or(Path::new("-")))?, path.iter(), findings);
    Ok(String::from_utf8_lossy(source.bytes()).into_owned())
}

/// The file beside which the machine file is searched.
fn beside(arguments: &TablesArguments) -> &Path {
    arguments.output.as_deref().or(arguments.read.first().map(PathBuf::as_path)).unwrap_or(Path::new("."))
}

/// Makes tables; those that are renewed, if that is wanted and there are no errors.
fn make<'a>(
    arguments: &'a TablesArguments,
    report: &mut TablesReport,
    findings: &mut Findings,
) -> Result<Option<LiveTables<'a>>, Stop> {
    let Some(format) = arguments.format else {
        return Err(Stop::Usage("give --format; `ncfix tables --list` lists the formats".into()));
    };
    let Some(output) = &arguments.output else {
        return Err(Stop::Usage("give -o, the file to write; -o - for standard output".into()));
    };
    let scheme = scheme_of(&Registry::default().schemes, &arguments.scheme)?;
    if arguments.watch && (scheme.is_none() || input::is_standard_stream(output)) {
        return Err(Stop::Usage("--watch needs a --scheme other than auto, and a file with -o".into()));
    }
    let Some(machine) = machine(arguments, findings)? else { return Ok(None) };
    let made = Tables::make_noting(&machine, format, &arguments.options(), &mut report.found, findings)?;
    if !arguments.check {
        report.found.check = None;
    }
    let Some(made) = made else { return Ok(None) };
    let files = made.files_at(output)?;
    arguments.outputs().publish(files, &[("", made.inner())], &machine.files, report, findings)?;
    let is_live = arguments.watch && !findings.has_errors();
    let live = || LiveTables::new(machine, (&arguments.state).into(), &arguments.options(), output, made);
    Ok(is_live.then(live))
}

/// Shows the tables of a control, checks them, compares them and converts them.
fn reread(arguments: &TablesArguments, report: &mut TablesReport, findings: &mut Findings) -> Result<(), Stop> {
    let to_machine = arguments.format.is_none() && arguments.output.as_deref().is_some_and(is_toml);
    let needs_machine = arguments.machine.machine.is_some() || arguments.check || to_machine;
    let machine = if needs_machine { machine(arguments, findings)? } else { None };
    if needs_machine && machine.is_none() {
        return Ok(());
    }
    let text = to_machine.then(|| text(arguments, findings)).transpose()?;
    let asked = Reread {
        files: &arguments.read,
        compare: arguments.compare.as_deref(),
        format: arguments.format,
        is_converted: arguments.output.is_some() && !to_machine,
        machine_text: text.as_deref(),
        is_checked: arguments.check,
    };
    let read = asked.run(machine.as_ref(), &arguments.options(), &mut report.found, findings)?;
    let Some(read) = read else { return Ok(()) };
    let files = match (&read.converted, read.machine_file, &arguments.output) {
        (Some(tables), _, Some(output)) => tables.files_at(output)?,
        (None, Some(text), Some(output)) => vec![(output.clone(), text)],
        _ => Vec::new(),
    };
    let sets = match &read.other {
        Some(other) => vec![("first ", &read.tables), ("second ", other)],
        None => vec![("", &read.tables)],
    };
    let inputs: Vec<PathBuf> = arguments.read.iter().chain(&arguments.compare).cloned().collect();
    Ok(arguments.outputs().publish(files, &sets, &inputs, report, findings)?)
}
