//! `ncfix diagnose`: errors of the model and their causes.

pub(in crate::cli) mod arguments;

use std::path::{Path, PathBuf};

use crate::cli::arguments::DiagnoseArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::{self, is_standard_stream, one_stream};
use crate::cli::machine_choice;
use crate::cli::output::Target;
use crate::cli::pages::{self, Pages};
use crate::cli::progress::Progress;
use crate::cli::stop::Stop;
use crate::cli::{measurement, print, tell};
use crate::travel_trial::tried;
use ncfix_base::source::{FileId, Source};
use ncfix_metrology::results::diagnosis::{self, DiagnosisSettings, SCHEMA};
use ncfix_metrology::results::hypotheses;
use ncfix_metrology::results::measurement::{Measurement, check_copies};
use ncfix_report::diagnosis::{DiagnosisReport, PageReadings};
use ncfix_report::{json, page};

/// Finds the causes of residual errors.
pub(in crate::cli) fn run(arguments: &DiagnoseArguments) -> Result<ExitCode, Stop> {
    let goes_out = arguments.output.as_deref().is_some_and(is_standard_stream);
    one_stream(arguments.json, goes_out)?;
    let mut findings = Findings::default();
    let mut report = DiagnosisReport::default();
    report.found.schema = SCHEMA;
    let mut shown = PageReadings { version: env!("CARGO_PKG_VERSION"), ..PageReadings::default() };
    let page = arguments.page.pages(arguments.output.as_deref(), arguments.json)?;
    let mut files = AtomicWrites::default();
    let mut result = find(arguments, (page.as_ref(), &mut files), &mut findings, &mut report, &mut shown);
    if let (Some(page), Ok(())) = (page.filter(|_| !shown.inputs.is_empty()), &result) {
        report.diagnostics = findings.json();
        result = page.add(&page::diagnosis::diagnosis(&report, &shown), &mut files).map_err(Stop::from);
        if result.is_ok() {
            report.report = arguments.page.report.as_ref().map(|path| path.display().to_string());
        }
    }
    result = result.and_then(|()| Ok(files.publish()?));
    if result.is_ok() && arguments.json {
        report.diagnostics = findings.json();
        if report.found.readings == 0 {
            report.forget_sizes();
        }
        print(&json::line(&report).map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    result?;
    if report.found.readings > 0 {
        let text = report.page();
        if goes_out || arguments.page.report.as_deref().is_some_and(is_standard_stream) {
            tell(&text);
        } else {
            print(&text)?;
        }
    }
    if findings.has_errors() {
        let what = if report.report.is_some() { "only the page" } else { "nothing" };
        tell(&format!("{}; {what} was written\n", findings.count()));
    }
    Ok(findings.exit_code())
}

fn find(
    arguments: &DiagnoseArguments,
    (page, files): (Option<&Pages>, &mut AtomicWrites),
    findings: &mut Findings,
    report: &mut DiagnosisReport,
    shown: &mut PageReadings,
) -> Result<(), Stop> {
    let first = arguments.data.first().map_or(Path::new("."), PathBuf::as_path);
    let target = arguments.output.as_deref().map(Target::new).transpose()?;
    report.is_to_be_written = target.is_some();
    let Some(chosen) = machine_choice::choose(&arguments.machine, first, findings)? else { return Ok(()) };
    report.found.machine.clone_from(&chosen.machine.name);
    if target.is_some() && chosen.is_demo {
        return Err(Stop::Usage("-o extends a machine file; give it with --machine".into()));
    }
    let tables = measurement::tables(&arguments.data, &arguments.holdout)?;
    measurement::protect_inputs(
        target.iter().chain(page.and_then(Pages::target)),
        chosen.files.clone(),
        tables.all.iter(),
        findings,
    )?;
    if findings.has_errors() {
        return Ok(());
    }
    target.iter().try_for_each(Target::must_be_machine_file)?;
    for path in &chosen.files {
        shown.inputs.push(pages::input(&input::read(path, FileId(0), "")?, "machine"));
    }
    let mut all: Vec<Measurement> = Vec::new();
    for (number, path) in tables.all.iter().enumerate() {
        let read = measurement::read_with_dead(path, number, (&chosen.machine, &chosen.errors), findings)?;
        if let Some(one) = &read {
            shown.inputs.extend(measurement::inputs(one, number >= tables.used));
        }
        all.extend(read);
    }
    if findings.has_errors() {
        // Duplicate readings are reported with all other errors.
        let sources = measurement::sources_of(&all);
        findings.extend(check_copies(&all), &sources);
        return Ok(());
    }
    let file = old(target.is_some(), chosen.files.last())?;
    let stated = hypotheses::source(&arguments.hypothesis);
    let settings = DiagnosisSettings {
        hypotheses: stated.as_ref(),
        file: file.as_ref(),
        is_extended: target.is_some(),
        with_readings: page.is_some(),
        ..DiagnosisSettings::default()
    };
    let sources: Vec<Source> = measurement::sources_of(&all).into_iter().chain(stated.clone()).collect();
    let (mut progress, mut found) = (Progress::new(), Vec::new());
    let made = diagnosis::run(
        (&chosen.machine, &chosen.errors),
        all,
        tables.used,
        settings,
        &mut |what, share| progress.share(what, share),
        &mut found,
        (&mut report.found, &mut shown.readings),
    );
    progress.clear();
    let written = match (target, made) {
        (Some(to), Some(Some(new))) => tried(new, file.as_ref(), &mut report.found, &mut found).map(|text| (to, text)),
        _ => None,
    };
    findings.extend(found, &sources);
    if let Some((target, text)) = written {
        files.add(target, text.as_bytes())?;
        report.output = arguments.output.as_ref().map(|path| path.display().to_string());
    }
    Ok(())
}

/// Machine file to extend. If nothing is written, it only limits what could be added.
fn old(is_written: bool, path: Option<&PathBuf>) -> Result<Option<Source>, Stop> {
    let Some(path) = path else {
        return if is_written { Err(Stop::Usage("-o needs --machine".into())) } else { Ok(None) };
    };
    match input::read_written(path, FileId(0), "machine file to extend") {
        Ok(file) => Ok(Some(file)),
        Err(error) if is_written => Err(error.into()),
        Err(_) => Ok(None),
    }
}
