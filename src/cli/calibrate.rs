//! `ncfix calibrate`: from measured data to the machine file.

use std::fmt::Write as _;

use super::arguments::CalibrateArguments;
use super::calibrated;
use super::calibrated_report::{self, Held};
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::identifiable;
use super::input::{self, is_standard_stream, one_stream};
use super::machine_choice::{self, Chosen, short_hash};
use super::measurement::{self, Measurement};
use super::output::Target;
use super::pages::Pages;
use super::stop::Stop;
use super::together::Together;
use super::{conditions, figures, parameters, print, repeated, select, state, tell};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;
use ncfix_base::source::{FileId, Source};
use ncfix_base::units::um_from_mm;
use ncfix_metrology::calibrate::{Compared, Fit, Options, Parameter, Refusal, fit, quality, reversals};
use ncfix_metrology::measure::data::DataSet;
use ncfix_model::{file, write};
use ncfix_report::number::{micrometers, significant};
use ncfix_report::{calibration, json};

/// A line of the head that an earlier calibration wrote begins with this.
const HEAD: &str = "# calibrated:";
/// The model leaves more than the instrument explains beyond this many standard uncertainties.
const POOR: f64 = 3.0;
/// An angle counts by what it moves at this arm, mm.
const ARM_MM: f64 = 1000.0;
/// What is told of the data in a finding about the machine's file: its id, beyond those of measurements.
const MACHINE: FileId = FileId(0);

/// Calibrates.
pub(super) fn run(arguments: &CalibrateArguments) -> Result<ExitCode, Stop> {
    let goes_out = is_standard_stream(&arguments.output);
    one_stream(arguments.json, goes_out)?;
    let mut findings = Findings::default();
    let version = env!("CARGO_PKG_VERSION");
    let mut report = calibration::Calibration { model: arguments.model.clone(), version, ..Default::default() };
    let page = Pages::new(&arguments.page, Some(&arguments.output), arguments.json)?;
    let mut files = Together::default();
    let mut result = calibrate(arguments, page.as_ref(), &mut files, &mut findings, &mut report);
    if let (Some(page), Ok(())) = (page.filter(|_| !report.inputs.is_empty()), &result) {
        result = calibrated_report::write(page, arguments, &mut files, &findings, &mut report);
    }
    result = result.and_then(|()| Ok(files.publish()?));
    if result.is_ok() && arguments.json {
        report.diagnostics = findings.json();
        print(&json::line(&report).map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    result?;
    if !report.parameters.is_empty() || report.selection.is_some() {
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
    files: &mut Together,
    findings: &mut Findings,
    report: &mut calibration::Calibration,
) -> Result<(), Stop> {
    let target = Target::new(&arguments.output)?;
    let start = input::read_written(&arguments.machine, MACHINE, "machine file, --machine")?;
    let chosen = machine_choice::read(&start, &[], findings)?;
    let read = std::iter::once(&arguments.machine).chain(&arguments.state.state).cloned().collect();
    let tables = arguments.data.iter().chain(&arguments.hold_out);
    measurement::protect_inputs(std::iter::once(&target).chain(page.and_then(Pages::target)), read, tables, findings)?;
    if page.is_some() && findings.has_errors() {
        return Ok(());
    }
    report.inputs.push(calibrated_report::machine_input(&start));
    for path in &arguments.state.state {
        report.inputs.push(calibrated_report::condition_input(&input::read(path, MACHINE, "")?));
    }
    let Some(mut chosen) = chosen else { return Ok(()) };
    if !state::read(&arguments.state, &mut chosen, findings)? {
        return Ok(());
    }
    report.machine.clone_from(&chosen.machine.name);
    let parameters = match arguments.model.as_str() {
        "none" if arguments.select.is_some() => Some(Vec::new()),
        model => parameters::choose(model, &chosen.machine, &chosen.errors, findings)?,
    };
    let mut all = Vec::new();
    for (number, path) in arguments.data.iter().chain(&arguments.hold_out).enumerate() {
        let read = measurement::read(path, number, false, &chosen.machine, findings)?;
        if let Some(measurement) = &read {
            check_sizes(&chosen, measurement, arguments.max, findings);
            report.inputs.extend(calibrated_report::inputs(measurement, number >= arguments.data.len()));
        }
        all.extend(read);
    }
    let Some(mut parameters) = parameters.filter(|_| !findings.has_errors()) else { return Ok(()) };
    if chosen.state.is_some() {
        all.iter_mut().for_each(|one| one.data.fill_in(&chosen.condition));
    }
    conditions::check(&chosen, &all, &parameters, findings);
    if findings.has_errors() {
        return Ok(());
    }
    measurement::check_copies(&all, findings);
    if findings.has_errors() {
        return Ok(());
    }
    let held_out = all.split_off(arguments.data.len().min(all.len()));
    if arguments.reduce {
        parameters = identifiable::reduced((&chosen.machine, &chosen.errors), &parameters, &all, findings, report);
    }
    let data: Vec<DataSet> = all.iter().map(|one| one.data.clone()).collect();
    let candidates = match &arguments.select {
        Some(words) => select::candidates(arguments, words, &chosen.machine, &chosen.errors, &data, findings)?,
        None => Some(Vec::new()),
    };
    let Some(candidates) = candidates else { return Ok(()) };
    let job = Job { arguments, chosen: &chosen, parameters: &parameters, candidates: &candidates };
    let Some(fit) = job.fit(&all, findings, report) else { return Ok(()) };
    report.figures = all.iter().map(|one| figures::of(&one.data, &chosen.machine)).collect();
    identifiable::distances(&fit, &all, findings);
    job.compare(&fit, &all, &held_out, findings, report);
    Job::rows(&fit, &all, findings, report);
    if findings.has_errors() {
        return Ok(());
    }
    let text = job.text(&start, &fit, &all)?;
    files.add(target, text.as_bytes())?;
    report.output = Some(arguments.output.display().to_string());
    Ok(())
}

struct Job<'a> {
    arguments: &'a CalibrateArguments,
    chosen: &'a Chosen,
    parameters: &'a [Parameter],
    candidates: &'a [Parameter],
}

impl Job<'_> {
    /// Fits; `None` where the data do not allow it, which findings say.
    fn fit(&self, all: &[Measurement], findings: &mut Findings, report: &mut calibration::Calibration) -> Option<Fit> {
        let data: Vec<DataSet> = all.iter().map(|one| one.data.clone()).collect();
        let reversals = reversals(&self.chosen.errors, self.parameters.iter().chain(self.candidates), &data);
        if !reversals.is_empty() {
            let help =
                "a reversal cannot be told from a drift: take \"drift\" out of free, or the reversal out of the model";
            for message in reversals {
                findings.add(Diagnostic::nowhere(Code::DRIFT_NOT_TOLD, message, help), &[]);
            }
            return None;
        }
        let (fit, parameters) = match self.found(&data, report) {
            Ok(found) => found,
            Err(refusal) => {
                select::refuse(refusal, all, findings);
                return None;
            }
        };
        let badly = identifiable::badly_told(&fit, all, self.arguments.max, findings);
        for found in &fit.estimates {
            let one = calibrated::estimate(found, &self.chosen.errors, &data);
            let is_parameter = found.column.is_of_machine();
            if is_parameter && found.effect_mm > self.arguments.max && !badly {
                let effect = micrometers(um_from_mm(found.effect_mm));
                let message = format!("{} would move the tool by {effect} (root of the mean square)", one.name);
                let help = "check units and signs of the readings; give a larger --max if the machine is like this";
                findings.add(Diagnostic::nowhere(Code::DATA_SIZE, message, help), &[]);
            }
            if is_parameter { &mut report.parameters } else { &mut report.unknowns }.push(one);
        }
        report.condition = Some(fit.condition);
        report.degrees_of_freedom = fit.freedom;
        report.rounds = fit.rounds;
        if let Some(runs) = self.arguments.monte_carlo {
            let (machine, how) = (&self.chosen.machine, [runs, self.arguments.seed]);
            repeated::repeat(machine, &parameters, all, (&fit, self.options()), how, findings, report);
        }
        Some(fit)
    }

    /// Says which rows do not fit; behind what is said of whole measurements, as they may be many.
    fn rows(fit: &Fit, all: &[Measurement], findings: &mut Findings, report: &mut calibration::Calibration) {
        for (row, set, place) in calibrated::weighted_down(fit, all) {
            let size = format!("{} {}", significant(row.residual), row.unit);
            let message = format!("{size} are left of this reading, which counts {:.0} %", row.weight * 100.0);
            let help = "look for its cause; --no-robust lets it count like the others";
            let found = Diagnostic::at(Code::ROW_DOES_NOT_FIT, place, message, help);
            findings.add(found, all.get(set).map_or(&[], |one| &one.sources));
            report.weighted_down.push(row);
        }
    }

    fn options(&self) -> Options {
        Options { robust: !self.arguments.no_robust }
    }

    /// The fit, and the parameters of which it is.
    fn found(&self, data: &[DataSet], report: &mut calibration::Calibration) -> Result<(Fit, Vec<Parameter>), Refusal> {
        let (machine, start) = (&self.chosen.machine, &self.chosen.errors);
        if self.arguments.select.is_none() {
            let found = fit(machine, start, self.parameters, data, self.options())?;
            return Ok((found, self.parameters.to_vec()));
        }
        let (found, told) = select::chosen(self.arguments, machine, start, self.parameters, self.candidates, data)?;
        report.selection = Some(told);
        Ok((found.fit, found.parameters))
    }

    /// Holds the result against all measurements.
    fn compare(
        &self,
        fit: &Fit,
        used: &[Measurement],
        held_out: &[Measurement],
        findings: &mut Findings,
        report: &mut calibration::Calibration,
    ) {
        let used = used.iter().enumerate().map(|(number, one)| {
            let sigmas = [fit.sigmas.get(number).copied(), fit.angle_sigmas.get(number).copied()];
            (one, sigmas, calibrated_report::weights(fit, number), false)
        });
        let held_out = held_out.iter().map(|one| (one, [one.data.sigma, one.data.sigma_rad], Vec::new(), true));
        for (one, sigmas, weights, is_held_out) in used.chain(held_out) {
            let data = &one.data;
            let quality = match quality(&self.chosen.machine, &fit.errors, data) {
                Ok(found) => found,
                Err(fault) => {
                    identifiable::refuse(fault, &format!("{}: ", data.name), std::slice::from_ref(one), findings);
                    continue;
                }
            };
            for (angles, described, key) in [(false, data.sigma, "sigma_um"), (true, data.sigma_rad, "sigma_urad")] {
                let is_of_unit =
                    |line: &Compared| data.observations.get(line.row).is_some_and(|row| row.is_angle() == angles);
                let left = quality.part(String::new(), is_of_unit).left[0];
                if let Some(described) = described.filter(|&described| left > POOR * described) {
                    let times = significant(left / described);
                    let name = &quality.name;
                    let message =
                        format!("{name}: what is left (root of the mean square) is {times} times what {key} says");
                    let help = format!("choose a model with more parameters, measure faster, or correct {key}");
                    findings.add(Diagnostic::nowhere(Code::POOR_FIT, message, help), &[]);
                }
            }
            let held = Held { data, quality, sigmas, weights, is_held_out };
            report.data.extend(held.shown(&self.chosen.machine, self.arguments.page.is_wanted()));
        }
    }

    /// The new machine file: the text of the old one with the parameters, and a head that says where they come from.
    fn text(&self, start: &Source, fit: &Fit, used: &[Measurement]) -> Result<String, Stop> {
        let wrong = |reason: String| Stop::Usage(format!("cannot write into the text of {}: {reason}", start.name()));
        let old = std::str::from_utf8(start.bytes()).map_err(|_| wrong("it is not UTF-8".into()))?;
        let errors = &fit.errors;
        let body = write::write(old, &self.chosen.errors, errors).map_err(|reason| wrong(reason.0))?;
        // A name may have any character; a comment ends with its line.
        let name = |text: &str| text.replace(char::is_control, " ");
        let mut text = format!("{HEAD} model {}", name(&self.arguments.model));
        let condition = self.chosen.state.as_ref().map_or_else(String::new, |hash| format!(", condition ({hash})"));
        // Writing into a String cannot fail.
        let _ = writeln!(text, ", began with {} ({}){condition}", name(start.name()), short_hash([start.bytes()]));
        for one in used {
            let hash = short_hash(one.sources.iter().map(Source::bytes));
            let _ = writeln!(text, "{HEAD} {} {} ({hash})", one.data.kind.name, name(one.sources[0].name()));
        }
        body.lines().skip_while(|line| line.starts_with(HEAD)).for_each(|line| {
            text.push_str(line);
            text.push('\n');
        });
        // What is written must be what was found.
        let again = Source::new(MACHINE, start.name(), text.clone().into_bytes())
            .map_err(|_| wrong("it is too long".into()))?;
        let Some((_, written)) = file::load(&again).0 else {
            return Err(wrong("the result is no machine file".into()));
        };
        for parameter in fit.estimates.iter().filter_map(|one| one.column.parameter()) {
            let (found, read) = (parameter.get(errors), parameter.get(&written));
            if (found - read).abs() > 1e-9 * found.abs() + f64::MIN_POSITIVE {
                return Err(wrong(format!("{parameter} would read {read:e} in place of {found:e}")));
            }
        }
        Ok(text)
    }
}

/// Says where readings are in another unit than their column, as far as their size tells.
fn check_sizes(chosen: &Chosen, measurement: &Measurement, max_mm: f64, findings: &mut Findings) {
    let data = &measurement.data;
    let help = "check the unit of the column; if the machine is like this, give a larger --max";
    // Lengths, then angles: sum of squares, number, the first row.
    let mut sums = [(0.0, 0.0_f64, None); 2];
    for row in &data.observations {
        let arm = if row.is_angle() { ARM_MM } else { 1.0 };
        for (index, value) in row.values.iter().enumerate() {
            let Some(size) = value.map(|value| value.abs()) else { continue };
            let (sum, count, first) = &mut sums[usize::from(row.is_angle())];
            *sum += size * size;
            *count += 1.0;
            first.get_or_insert(row.place);
            if size * arm > max_mm {
                let (place, shown) = calibrated::cell(measurement, row.place, index);
                let message =
                    format!("{shown} is beyond {}, which no reading should be", micrometers(um_from_mm(max_mm)));
                findings.add(Diagnostic::at(Code::DATA_SIZE, place, message, help), &measurement.sources);
            }
        }
    }
    let kinds = [(data.sigma, "lengths", "sigma_um"), (data.sigma_rad, "angles", "sigma_urad")];
    for ((sum, count, first), (sigma, what, key)) in sums.into_iter().zip(kinds) {
        if let (Some(sigma), Some(first)) = (sigma, first)
            && (sum / count).sqrt() < sigma
        {
            let (place, _) = calibrated::cell(measurement, first, 0);
            let message =
                format!("all {what} that were read are together less than their uncertainty (root of the mean square)");
            let help = format!("check the unit of the column and {key} in the description");
            findings.add(Diagnostic::at(Code::DATA_SIZE, place, message, help), &measurement.sources);
        }
    }
    check_balls(chosen, measurement, max_mm, findings);
}

/// Says which probing is far from the others of its ball.
fn check_balls(chosen: &Chosen, measurement: &Measurement, max_mm: f64, findings: &mut Findings) {
    let data = &measurement.data;
    if data.kind.name != "probe" || !data.free.is_empty() {
        return;
    }
    let model = chosen.model();
    for (number, label) in data.targets.iter().enumerate() {
        let own = || data.observations.iter().filter(|row| row.target == Some(number));
        let tips: Vec<Vector> =
            own().map(|row| model.nominal(&row.reading.position, &row.reading.tool_mm).translation).collect();
        let middle = |k: usize| {
            let mut all: Vec<f64> = tips.iter().map(|tip| tip[k]).collect();
            let half = all.len() / 2;
            if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(half, f64::total_cmp).1 }
        };
        let center = Vector::new(middle(0), middle(1), middle(2));
        for (row, tip) in own().zip(&tips) {
            let off = (tip - center).norm();
            if off > max_mm {
                let message = format!("the tip is {off:.3} mm from where the ball {label} is in the other rows");
                let help = "check the positions, target and tool_x_mm … of the row; give a larger --max if the machine is like this";
                findings.add(Diagnostic::at(Code::DATA_SIZE, row.place, message, help), &measurement.sources);
            }
        }
    }
}
