//! `ncfix iso230`: figures of the acceptance tests from measurements.

use super::arguments::FiguresArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::stop::Stop;
use super::{deliver, machine_choice, measurement};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_metrology::results::figures;
use ncfix_report::figures::Figures as Report;
use ncfix_report::json;

/// Prints figures.
pub(super) fn run(arguments: &FiguresArguments) -> Result<ExitCode, Stop> {
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
    let beside = arguments.data.first().map_or_else(Default::default, Clone::clone);
    let Some(chosen) = machine_choice::choose(&arguments.machine, &beside, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    let mut all = Vec::new();
    for (number, path) in arguments.data.iter().enumerate() {
        all.extend(measurement::read(path, number, false, &chosen.machine, findings)?);
    }
    if findings.has_errors() {
        return Ok(());
    }
    for one in &all {
        let of = figures::of(&one.data, &chosen.machine);
        if of.figures.is_empty() {
            let message = format!("{}: a {} measurement has no figures of ISO 230", of.name, of.kind);
            let help = "give readings of single components (direct) or of a ball-bar";
            findings.add(Diagnostic::nowhere(Code::DATA_COLUMN, message, help), &one.sources);
        }
        report.measurements.push(of);
    }
    Ok(())
}
