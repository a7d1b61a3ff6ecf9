//! `ncfix iso230`: figures of the acceptance tests from measurements.

pub(in crate::cli) mod arguments;

use crate::cli::arguments::FiguresArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::{deliver, machine_choice, measurement};
use ncfix_metrology::results::figures;
use ncfix_report::figures::FiguresReport as Report;
use ncfix_report::json;

/// Prints figures.
pub(in crate::cli) fn run(arguments: &FiguresArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let mut report = Report::default();
    let result = read(arguments, &mut findings, &mut report);
    let page = report.table();
    let json = arguments.json.then(|| {
        report.diagnostics = findings.json();
        json::line(&report)
    });
    deliver(result, &findings, false, page, json)
}

fn read(arguments: &FiguresArguments, findings: &mut Findings, report: &mut Report) -> Result<(), Stop> {
    let tables = measurement::tables(&arguments.data, &[])?.all;
    let beside = tables.first().map_or_else(Default::default, Clone::clone);
    let Some(chosen) = machine_choice::choose(&arguments.machine, &beside, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    let mut all = Vec::new();
    for (number, path) in tables.iter().enumerate() {
        all.extend(measurement::read(path, number, false, &chosen.machine, findings)?);
    }
    if findings.has_errors() {
        return Ok(());
    }
    let (measurements, found) = figures::of_all(&all, &chosen.machine, &chosen.errors);
    report.measurements = measurements;
    findings.extend(found, &[]);
    Ok(())
}
