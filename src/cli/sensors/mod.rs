//! `ncfix sensors`: selects the temperature sensors that predict the drift of a machine.

pub(in crate::cli) mod arguments;
mod watch;

use std::path::{Path, PathBuf};

use crate::cli::arguments::SensorsArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::is_standard_stream;
use crate::cli::output::Target;
use crate::cli::program::protect;
use crate::cli::stop::Stop;
use crate::cli::{deliver, input, machine_choice, pages};
use ncfix_base::source::{FileId, Source};
use ncfix_metrology::results::sensors::{SensorTexts, read, selected};
use ncfix_report::json;
use ncfix_report::sensors::SensorReport;

/// Selects the sensors.
pub(in crate::cli) fn run(arguments: &SensorsArguments) -> Result<ExitCode, Stop> {
    if arguments.watch {
        return watch::run(arguments);
    }
    let goes_out = arguments.output.as_deref().is_some_and(is_standard_stream);
    if arguments.json && goes_out {
        return Err(Stop::Usage("--json and the drift cannot both go to standard output; give -o a file".into()));
    }
    let mut findings = Findings::default();
    let mut report = SensorReport::default();
    let result = find(arguments, &mut findings, &mut report);
    let page = report.page();
    deliver(
        result,
        &findings,
        goes_out,
        page,
        arguments.json.then(|| {
            report.diagnostics = findings.json();
            json::line(&report)
        }),
    )
}

fn find(arguments: &SensorsArguments, findings: &mut Findings, report: &mut SensorReport) -> Result<(), Stop> {
    let mut sources: Vec<Source> = Vec::new();
    let paths: Vec<&PathBuf> = arguments.data.iter().chain(&arguments.verify).chain(&arguments.log).collect();
    for (path, number) in paths.iter().zip(0_u16..) {
        sources.push(input::read(path, FileId(number), "run of temperatures")?);
    }
    let target = arguments.output.as_deref().map(Target::new).transpose()?;
    let first = arguments.data.first().map_or(Path::new("."), PathBuf::as_path);
    let Some(chosen) = machine_choice::choose(&arguments.machine, first, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    if let Some(target) = &target {
        protect(target, chosen.files.iter().chain(paths), findings);
    }
    let learned_count = arguments.data.len();
    let (tables, logs) = sources.split_at(learned_count + arguments.verify.len());
    let (learned, independent) = tables.split_at(learned_count);
    let mut found = Vec::new();
    let runs = read(&SensorTexts { learned, independent, logs }, &chosen.machine, &mut found);
    findings.extend(std::mem::take(&mut found), &sources);
    let Some(runs) = runs.filter(|_| !findings.has_errors()) else { return Ok(()) };
    let text = selected(runs, learned_count, &arguments.options(), &chosen.machine, &mut found, &mut report.found);
    findings.extend(found, &sources);
    if let (Some(text), Some(target), Some(path)) = (text, target, &arguments.output) {
        pages::publish(target, &text)?;
        report.output = Some(path.display().to_string());
    }
    Ok(())
}
