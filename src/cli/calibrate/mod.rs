//! `ncfix calibrate`: from measured data to the machine file.

pub(in crate::cli) mod arguments;

use crate::calibration::{text_of, with_terms};
use crate::cli::arguments::CalibrateArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::{self, is_standard_stream, one_stream};
use crate::cli::machine_choice;
use crate::cli::measurement;
use crate::cli::output::Target;
use crate::cli::pages::{self, Pages};
use crate::cli::progress::Progress;
use crate::cli::stop::Stop;
use crate::cli::{parameters, print, state, tell};
use crate::disk::parameters::ChosenModel;
use crate::next_line;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::FileId;
use ncfix_metrology::calibrate::candidates::PiecewisePolynomials;
use ncfix_metrology::results::calibration::{CalibrationSettings, CalibrationStart, check_sizes, prepare};
use ncfix_metrology::results::measurement::data_of;
use ncfix_report::calibration::CalibrationReport;
use ncfix_report::{json, page};

/// Id of the machine file in diagnostics.
const MACHINE: FileId = FileId(0);

/// Calibrates.
pub(in crate::cli) fn run(arguments: &CalibrateArguments) -> Result<ExitCode, Stop> {
    one_stream(arguments.json, is_standard_stream(&arguments.output))?;
    let mut findings = Findings::default();
    let mut report = CalibrationReport { version: env!("CARGO_PKG_VERSION"), ..CalibrationReport::default() };
    report.found.model.clone_from(&arguments.model);
    let page = arguments.page.pages(Some(&arguments.output), arguments.json)?;
    let mut files = AtomicWrites::default();
    let mut result = calibrate(arguments, page.as_ref(), &mut files, &mut findings, &mut report);
    if let (Some(page), Ok(())) = (page.filter(|_| !report.inputs.is_empty()), &result) {
        report.diagnostics = findings.json();
        result = page.add(&page::calibration::calibration(&report), &mut files).map_err(Stop::from);
        if result.is_ok() {
            report.report = arguments.page.report.as_ref().map(|path| path.display().to_string());
        }
    }
    result = result.and_then(|()| Ok(files.publish()?));
    if result.is_ok() && arguments.json {
        report.diagnostics = findings.json();
        print(&json::line(&report).map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    result?;
    if !report.found.parameters.is_empty() || report.found.selection.is_some() || !report.found.terms.is_empty() {
        tell(&report.table());
    }
    if findings.has_errors() {
        let what = if report.report.is_some() { "no machine file" } else { "nothing" };
        tell(&format!("{}; {what} was written\n", findings.count()));
    }
    Ok(findings.exit_code())
}

fn calibrate(
    arguments: &CalibrateArguments,
    page: Option<&Pages>,
    files: &mut AtomicWrites,
    findings: &mut Findings,
    report: &mut CalibrationReport,
) -> Result<(), Stop> {
    let target = Target::new(&arguments.output)?;
    let start = input::read_written(&arguments.machine, MACHINE, input::option("machine file, --machine"))?;
    let chosen = machine_choice::read_head(&start, &[], arguments.head.as_deref(), findings)?;
    let read = std::iter::once(&arguments.machine).chain(&arguments.state.state).cloned().collect();
    let tables = measurement::tables(&arguments.data, &arguments.hold_out)?;
    let residuals = arguments.residuals.as_deref().map(pages::file).transpose()?;
    let targets = std::iter::once(&target).chain(page.and_then(Pages::target)).chain(&residuals);
    measurement::protect_inputs(targets, read, tables.all.iter(), findings)?;
    if page.is_some() && findings.has_errors() {
        return Ok(());
    }
    report.inputs.push(pages::input(&start, "machine"));
    for path in &arguments.state.state {
        report.inputs.push(pages::input(&input::read(path, MACHINE, "")?, "condition"));
    }
    let Some(mut chosen) = chosen else { return Ok(()) };
    if !state::read(&arguments.state, &mut chosen, findings)? {
        return Ok(());
    }
    report.found.machine.clone_from(&chosen.machine.name);
    let (model, select) = (arguments.model.as_str(), arguments.select.as_deref());
    let model = ChosenModel::read(model, select.is_some(), &chosen.machine, &chosen.errors, findings)?;
    let mut begin = CalibrationStart {
        machine: &chosen.machine,
        errors: &chosen.errors,
        condition: &chosen.condition,
        growth: &[],
    };
    let mut all = Vec::new();
    for (number, path) in tables.all.iter().enumerate() {
        let read = measurement::read(path, number, false, &chosen.machine, findings)?;
        if let Some(measurement) = &read {
            findings.extend(check_sizes(&begin, measurement, arguments.max), &measurement.sources);
            report.inputs.extend(measurement::inputs(measurement, number >= tables.used));
        }
        all.extend(read);
    }
    let Some(model) = model.filter(|_| !findings.has_errors()) else { return Ok(()) };
    target.must_be_machine_file()?;
    if chosen.state.is_some() {
        all.iter_mut().for_each(|one| one.data.fill_in(&chosen.condition));
    }
    let is_automatic = model.is_automatic;
    let data = data_of(all.get(..tables.used).unwrap_or_default());
    let (model, undetermined) = model.for_data(&chosen.machine, &chosen.errors, &data);
    let settings = CalibrationSettings {
        max_mm: arguments.max,
        robust: !arguments.no_robust,
        reduce: arguments.reduce || is_automatic,
        is_automatic,
        monte_carlo: arguments.monte_carlo.map(|runs| [runs, arguments.seed]),
        significance: arguments.significance,
        with_readings: arguments.page.is_wanted(),
    };
    let Some((mut parameters, grown)) = with_terms(&chosen, &start, model, (&all, tables.used), findings) else {
        return Ok(());
    };
    parameters.extend(undetermined);
    report.found.terms = grown.as_ref().map_or_else(Vec::new, |grown| grown.terms.clone());
    let (from, errors) = grown.as_ref().map_or((&start, &chosen.errors), |grown| (&grown.source, &grown.errors));
    begin.errors = errors;
    begin.growth = grown.as_ref().map_or(&[], |grown| &grown.growth);
    let sources = measurement::sources_of(&all);
    let mut found = Vec::new();
    let prepared = prepare(begin, settings, all, tables.used, parameters, &mut found, &mut report.found);
    findings.extend(found, &sources);
    let Some(prepared) = prepared else { return Ok(()) };
    let pieces = PiecewisePolynomials { spacing_mm: arguments.knots, degree: arguments.degree };
    let words = select.or(is_automatic.then_some(parameters::AUTO));
    let mut select =
        |words| parameters::candidates((words, pieces), &chosen.machine, errors, &prepared.data(), findings);
    let candidates = words.map(&mut select).transpose()?;
    if candidates.as_ref().is_some_and(Option::is_none) {
        return Ok(());
    }
    let (mut line, mut found) = (Progress::new(), Vec::new());
    let mut progress = |share: f64| line.share("repetitions", share);
    let fit = prepared.fit(candidates.flatten().as_deref(), &mut progress, &mut found, &mut report.found);
    line.clear();
    let is_poor = found.iter().any(|one| one.code == Code::POOR_FIT);
    findings.extend(found, &sources);
    let Some(fit) = fit.filter(|_| !findings.has_errors()) else { return Ok(()) };
    let text = text_of((&chosen, errors), (&start, from), &arguments.model, (&fit, &report.found), prepared.used())?;
    files.add(target, text.as_bytes())?;
    if let Some(target) = residuals {
        files.add(target, prepared.residuals(&fit).as_bytes())?;
    }
    report.next = if is_poor {
        next_line::after_poor_fit(&arguments.data, &arguments.output)
    } else {
        next_line::after_calibration(&arguments.output, !chosen.machine.zero_offsets.is_empty())
    };
    report.output = Some(arguments.output.display().to_string());
    Ok(())
}
