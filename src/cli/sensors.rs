//! `ncfix sensors`: selects the sensors of temperature that tell the drift of a machine.

use std::path::PathBuf;

use super::arguments::SensorsArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::input::is_standard_stream;
use super::machine_choice::Chosen;
use super::output::Target;
use super::program::protect;
use super::stop::Stop;
use super::{deliver, input, machine_choice, pages, watch};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Condition;
use ncfix_machine::machine::condition::log;
use ncfix_metrology::calibrate::sensors::data::{self, SensorRun};
use ncfix_metrology::calibrate::sensors::{SelectionOptions, SensorSelection, select, text};
use ncfix_report::json;
use ncfix_report::sensors::{SelectionReport, SensorReport, SizeRow};

/// Selects.
pub(super) fn run(arguments: &SensorsArguments) -> Result<ExitCode, Stop> {
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
    let first = arguments.data.first().map_or(std::path::Path::new("."), PathBuf::as_path);
    let Some(chosen) = machine_choice::choose(&arguments.machine, first, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    if let Some(target) = &target {
        protect(target, chosen.files.iter().chain(paths), findings);
    }
    let Some(mut runs) = read(arguments, &sources, &chosen, findings) else { return Ok(()) };
    let over = match data::over(&runs) {
        Ok(over) => over,
        Err(finding) => {
            findings.add(finding, &sources);
            return Ok(());
        }
    };
    let independent = runs.split_off(arguments.data.len().min(runs.len()));
    report.independent = (!independent.is_empty()).then(|| independent.iter().map(|run| run.name.clone()).collect());
    let places: Vec<_> = match over {
        Some((axis, positions)) => positions.into_iter().map(|at| Some((axis, at))).collect(),
        None => vec![None],
    };
    let options = SelectionOptions {
        most: usize::from(arguments.most),
        lags: arguments.lags,
        fault_k: arguments.ridge.unwrap_or_default(),
    };
    let mut selections = Vec::new();
    for direction in 0..3 {
        for &at in &places {
            selections.extend(select(&runs, &independent, direction, at, &options));
        }
    }
    if selections.is_empty() {
        let message = "there are too few readings for a single sensor, or no sensor moves";
        let help = "record at least some hours of warming up and cooling down, a reading every minute or so";
        findings.add(Diagnostic::nowhere(Code::DATA_NO_TABLE, message, help), &sources);
    }
    if findings.has_errors() {
        return Ok(());
    }
    report.selections = selections.iter().map(row).collect();
    if let (Some(target), Some(path)) = (target, &arguments.output) {
        let text = file(&selections, &runs, &chosen);
        pages::publish(target, &text)?;
        report.output = Some(path.display().to_string());
    }
    Ok(())
}

/// Reads all runs, those that are learned from first; `None` where findings forbid it.
fn read(
    arguments: &SensorsArguments,
    sources: &[Source],
    chosen: &Chosen,
    findings: &mut Findings,
) -> Option<Vec<SensorRun>> {
    let (tables, logs) = sources.split_at_checked(arguments.data.len() + arguments.verify.len())?;
    let mut temperatures: Option<Condition> = None;
    for source in logs {
        let (condition, found) = log::load_with_dead(source);
        findings.extend(found, sources);
        temperatures = Some(condition?);
    }
    let mut runs = Vec::new();
    for source in tables {
        match data::read(source, temperatures.as_ref(), &chosen.machine) {
            Ok(mut run) => {
                findings.extend(std::mem::take(&mut run.warnings), sources);
                runs.push(run);
            }
            Err(found) => findings.extend(found, sources),
        }
    }
    (!findings.has_errors()).then_some(runs)
}

fn row(selection: &SensorSelection) -> SelectionReport {
    let size = |size: &ncfix_metrology::calibrate::sensors::SubsetSize| SizeRow {
        sensors: size.terms.iter().map(|term| term.sensor.clone()).collect(),
        um_per_k: size.terms.iter().map(|term| term.um_per_k).collect(),
        lag_s: size.terms.iter().map(|term| term.lag_s).collect(),
        cp: size.cp,
        efficiency: size.efficiency,
        independent_efficiency: size.independent,
        is_exact: size.is_exact,
    };
    SelectionReport {
        direction: ["X", "Y", "Z"].get(selection.direction).copied().unwrap_or("Z"),
        place: selection.at.map(|(axis, at)| format!("{axis}{at}")),
        readings: selection.rows,
        drift_um: selection.drift_um,
        left_um: selection.model().map(|model| model.left_um),
        chosen: selection.model().map(|model| model.terms.len()),
        sizes: selection.sizes.iter().map(size).collect(),
    }
}

/// The file.
fn file(selections: &[SensorSelection], runs: &[SensorRun], chosen: &Chosen) -> String {
    // A name may have any character; a comment ends with its line.
    let name = |text: &str| text.replace(char::is_control, " ");
    let names: Vec<String> = runs.iter().map(|run| name(&run.name)).collect();
    format!(
        "# Drift of {} from {}: for the machine file, in place of the [[drift]] there.\n\n{}",
        name(&chosen.machine.name),
        names.join(", "),
        text::entries(selections)
    )
}
