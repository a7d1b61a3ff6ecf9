//! A complete calibration: checks of the readings, the fit, its uncertainties, and the residuals of every measurement.

pub use super::calibrated::{CalibrationResult, Data, EstimateReport, KeptReadings, MeanLineReport, OutlierRow};
use super::cells::{cell, estimate, weighted_down};
use super::held::{ComparedMeasurement, fitted};
use super::measurement::{Measurement, check_copies, data_of};
pub use super::not_identified::LeftOut;
use super::references::Together;
use super::residuals::residual_table;
use super::selection;
use super::widened::widen;
use super::{
    conditions, contradicting, figures, frame, has_errors, not_identified, omitted, references, relative, repeated,
    signs, slope, sorted_rows, uncertain,
};
use crate::calibrate::{
    ComparedReading, Fit, FitOptions, Parameter, Refusal, Rule, add_certificates, contradictions, fit, quality, select,
};
use crate::measure::data::{DataSet, Free, Observation};
use crate::measure::kind::Measurand;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::Vector;
use ncfix_base::number::{micrometers, significant};
use ncfix_base::source::Source;
use ncfix_base::units::{Unit, um_from_mm};
use ncfix_machine::describe;
use ncfix_machine::machine::{Condition, Machine, MeasuredRanges, Uncertainty};
use ncfix_model::{ErrorModel, Model, ModelRegisters, ParameterName, file, write};

/// Readings that do not fit, above which a lacking error is more probable than faults of readings.
const MOST_FAULTY: usize = 5;

/// Residual in standard uncertainties of the instrument above which the model is poor.
const POOR: f64 = 3.0;
/// A fit is refused if its residuals exceed the measured values by this share.
const WORSE: f64 = 0.05;
/// One file of several contradicts a fit if its residuals exceed its measured values by this share and are at least so large, µm or µrad: where nearly nothing
/// was measured, noise alone exceeds it.
const CONTRADICTS: f64 = 0.5;
const CONTRADICTS_FROM: f64 = 1.0;
/// Excess of a mean square over the described one, in its standard deviations, above which it is not scatter.
const CLEAR: f64 = 3.0;
/// Arm at which angles count as lengths, mm.
const ARM_MM: f64 = 1000.0;

/// The initial machine of a calibration.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationStart<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Its current errors.
    pub errors: &'a ErrorModel,
    /// The condition of the machine during the measurements, if their tables do not state it.
    pub condition: &'a Condition,
    /// Factors of the uncertainties of parameters: terms of the machine file that were fitted together with them, and stay in this fit.
    pub growth: &'a [(ParameterName, f64)],
}

impl CalibrationStart<'_> {
    fn model(&self) -> Model {
        Model::at(self.machine, self.errors, self.condition)
    }
}

/// Settings of a calibration.
#[derive(Clone, Copy, Debug, Default)]
pub struct CalibrationSettings {
    /// Largest accepted reading or parameter effect, mm.
    pub max_mm: f64,
    /// `true` to reduce the weight of rows that do not fit.
    pub robust: bool,
    /// `true` to leave out parameters that the data do not determine.
    pub reduce: bool,
    /// `true` if the parameters and candidates are those of the model `auto`: a scale that rests on the stated place of a rotary axis is left out, and
    /// without a selection the parameters alone are fitted.
    pub is_automatic: bool,
    /// Number of simulated repetitions, and the seed of their noise.
    pub monte_carlo: Option<[u64; 2]>,
    /// Significance level of the selection.
    pub significance: f64,
    /// `true` to keep single readings for pictures.
    pub with_readings: bool,
}

/// Checked measurements, with the parameters to be fitted.
#[derive(Debug)]
pub struct PreparedFit<'a> {
    begin: CalibrationStart<'a>,
    settings: CalibrationSettings,
    parameters: Vec<Parameter>,
    used: Vec<Measurement>,
    held_out: Vec<Measurement>,
}

/// Checks measurements, of which the first `used` are used and the others held out, and leaves parameters out if requested; `None` if
/// diagnostics prevent it from continuing.
pub fn prepare<'a>(
    begin: CalibrationStart<'a>,
    settings: CalibrationSettings,
    mut all: Vec<Measurement>,
    used: usize,
    mut parameters: Vec<Parameter>,
    findings: &mut Vec<Diagnostic>,
    report: &mut CalibrationResult,
) -> Option<PreparedFit<'a>> {
    conditions::check((begin.errors, begin.condition), &all, &parameters, findings);
    if has_errors(findings) {
        return None;
    }
    findings.extend(check_copies(&all));
    if has_errors(findings) {
        return None;
    }
    let start = (begin.machine, begin.errors);
    sorted_rows::take_as_unknown(start, &parameters, settings.is_automatic, &mut all, findings);
    let held_out = all.split_off(used.min(all.len()));
    if settings.reduce {
        parameters = not_identified::reduced(start, &parameters, &all, findings, &mut report.left_out);
    }
    if settings.is_automatic {
        relative::leave_out_scales((begin.machine, begin.errors), &mut parameters, &all, findings, report);
    }
    Some(PreparedFit { begin, settings, parameters, used: all, held_out })
}

impl PreparedFit<'_> {
    /// The used data.
    #[must_use]
    pub fn data(&self) -> Vec<DataSet> {
        data_of(&self.used)
    }

    /// The used measurements.
    #[must_use]
    pub fn used(&self) -> &[Measurement] {
        &self.used
    }

    /// The fixed parameters, which are fitted for every selection.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Fits the parameters, and those of the `candidates` that the data need; `None` if the data do not allow it, as diagnostics report. `progress`
    /// receives the completed share of the repetitions.
    pub fn fit(
        &self,
        candidates: Option<&[Parameter]>,
        progress: &mut dyn FnMut(f64),
        findings: &mut Vec<Diagnostic>,
        report: &mut CalibrationResult,
    ) -> Option<Fit> {
        let fit = self.found(candidates, progress, findings, report)?;
        report.figures = self.used.iter().map(|one| figures::of(&one.data, self.begin.machine)).collect();
        not_identified::distances(&fit, &self.used, findings);
        references::check(self.used.iter().chain(&self.held_out), Together::Fit, findings);
        self.compare(&fit, findings, report);
        let known = findings.len();
        findings.extend(worse(report));
        if findings.iter().any(|one| one.code == Code::POOR_FIT || one.code == Code::NOT_SETTLED) {
            // The parameters of the fit, selected ones too.
            let fitted = fit.estimates.iter().filter(|one| one.inflation.is_finite());
            let fitted: Vec<Parameter> = fitted.filter_map(|one| one.column.parameter()).collect();
            let of = (self.begin.machine, self.begin.errors);
            if let Some(found) = signs::wrong_sign(of, &fitted, (&self.used, &fit), self.options()) {
                findings.truncate(known);
                findings.push(found);
            }
        }
        if candidates.is_none() && !self.settings.is_automatic {
            report.omitted = omitted::check(
                (self.begin.machine, self.begin.errors),
                &self.parameters,
                &self.used,
                self.options(),
                findings,
            );
        }
        self.rows(&fit, findings, report);
        findings.extend(uncertain::replaced(self.begin.machine.uncertainty.as_ref(), &fit));
        Some(fit)
    }

    /// The residual of each reading of a fit, as a table in CSV.
    #[must_use]
    pub fn residuals(&self, fit: &Fit) -> String {
        residual_table(self.begin.machine, fit, &self.used)
    }

    fn options(&self) -> FitOptions {
        FitOptions { robust: self.settings.robust }
    }

    fn found(
        &self,
        candidates: Option<&[Parameter]>,
        progress: &mut dyn FnMut(f64),
        findings: &mut Vec<Diagnostic>,
        report: &mut CalibrationResult,
    ) -> Option<Fit> {
        let data = self.data();
        let start = self.begin.errors;
        let reversals =
            conditions::check_reversals(start, self.parameters.iter().chain(candidates.unwrap_or_default()), &data);
        if !reversals.is_empty() {
            findings.extend(reversals);
            return None;
        }
        let (mut fit, parameters) = match self.fitted(candidates, &data, report) {
            Ok(found) => found,
            Err(refusal) => {
                selection::refuse(refusal, &self.used, findings);
                return None;
            }
        };
        widen(&mut fit, self.begin.growth);
        // Simulated repetitions have the noise of the readings alone.
        let mut of_noise = self.settings.monte_carlo.map(|how| (how, fit.clone()));
        if let Err(fault) = add_certificates(self.begin.machine, &parameters, &data, self.options(), &mut fit) {
            not_identified::refuse(fault, "with the lengths of certificates: ", &self.used, findings);
            return None;
        }
        let contradicting = contradictions(self.begin.machine, &parameters, &data, self.options(), &fit);
        contradicting::apply(&contradicting, &self.used, &data, &mut fit, findings);
        let (of, noise) = ((self.begin.machine, start), of_noise.as_mut().map(|(_, fit)| fit));
        report.mean_lines = frame::refer(of, &parameters, &self.used, &mut fit, noise);
        let badly = not_identified::badly_told(&fit, &self.used, self.settings.max_mm, findings);
        for found in &fit.estimates {
            let one = estimate(found, start, &data);
            let is_parameter = found.column.is_of_machine();
            if is_parameter && found.effect_mm > self.settings.max_mm && !badly {
                let effect = micrometers(um_from_mm(found.effect_mm));
                let message = format!("{} would move the tool by {effect} RMS", one.name);
                let help =
                    "check units and signs of the readings; give a larger --max if the machine really has such errors";
                findings.push(Diagnostic::nowhere(Code::DATA_SIZE, message, help));
            }
            if is_parameter { &mut report.parameters } else { &mut report.unknowns }.push(one);
        }
        report.condition = Some(fit.condition);
        report.degrees_of_freedom = fit.freedom;
        report.rounds = fit.rounds;
        if let Some((how, of_noise)) = of_noise {
            let (of, fitted) = ((self.begin.machine, parameters.as_slice()), (&of_noise, self.options()));
            repeated::repeat(of, &self.used, fitted, how, progress, findings, report);
        }
        slope::level(self.begin.machine, &parameters, &self.used, &mut fit, findings);
        // A slope of the axis is not one of the alignment.
        let unknowns = fit.estimates.iter().filter(|one| !one.column.is_of_machine());
        for (shown, found) in report.unknowns.iter_mut().zip(unknowns) {
            shown.value = estimate(found, start, &data).value;
        }
        relative::check(self.begin.machine, &parameters, &self.used, &fit, findings);
        relative::check_pivots(self.begin.machine, &parameters, &self.used, &fit, findings);
        Some(fit)
    }

    /// The fit, and its parameters.
    fn fitted(
        &self,
        candidates: Option<&[Parameter]>,
        data: &[DataSet],
        report: &mut CalibrationResult,
    ) -> Result<(Fit, Vec<Parameter>), Refusal> {
        let CalibrationStart { machine, errors, .. } = self.begin;
        let Some(candidates) = candidates.filter(|all| !(self.settings.is_automatic && all.is_empty())) else {
            let found = fit(machine, errors, &self.parameters, data, self.options())?;
            return Ok((found, self.parameters.clone()));
        };
        let rule = Rule { significance: self.settings.significance, ..Rule::default() };
        let found = match select(machine, errors, &self.parameters, candidates, data, self.options(), rule) {
            Err(_) if self.settings.is_automatic => {
                let found = fit(machine, errors, &self.parameters, data, self.options())?;
                return Ok((found, self.parameters.clone()));
            }
            found => found?,
        };
        report.selection = Some(selection::told(&found, rule, data));
        Ok((found.fit, found.parameters))
    }

    /// Reports rows that do not fit, once for each file; after the diagnostics about whole measurements.
    fn rows(&self, fit: &Fit, findings: &mut Vec<Diagnostic>, report: &mut CalibrationResult) {
        let mut groups: Vec<Vec<(OutlierRow, Place)>> = Vec::new();
        for (row, place) in weighted_down(fit, &self.used) {
            report.weighted_down.push(row.clone());
            let is_like = |(first, _): &(OutlierRow, Place)| {
                (&first.file, first.is_without_direction) == (&row.file, row.is_without_direction)
            };
            match groups.iter_mut().find(|group| group.first().is_some_and(is_like)) {
                Some(group) => group.push((row, place)),
                None => groups.push(vec![(row, place)]),
            }
        }
        for group in groups {
            // The least weight, and of several rows without weight the largest residual.
            let order = |(a, _): &&(OutlierRow, Place), (b, _): &&(OutlierRow, Place)| {
                a.weight.total_cmp(&b.weight).then(b.residual.abs().total_cmp(&a.residual.abs()))
            };
            let Some((row, place)) = group.iter().min_by(order) else { continue };
            let size = format!("{} {}", significant(row.residual), row.unit.sign());
            let others = match group.len() - 1 {
                0 => String::new(),
                1 => "; one more reading of this file does not fit".to_owned(),
                more => format!("; {more} more readings of this file do not fit, --residuals lists all"),
            };
            let message =
                format!("the residual of this reading is {size}; its weight is {:.0} %{others}", row.weight * 100.0);
            // Where the direction of approach does not follow from the table, the model has no backlash for the reading: the reading is not at fault.
            let help = if row.is_without_direction {
                "its direction of approach is not known, so the model has no backlash for it: give the directions in columns X_dir …"
            } else if group.len() > MOST_FAULTY {
                "several such readings may show an error that the model lacks: ncfix diagnose searches for it; --no-robust gives them full weight"
            } else {
                "find its cause; --no-robust gives it full weight"
            };
            findings.push(Diagnostic::at(Code::ROW_DOES_NOT_FIT, *place, message, help));
        }
    }

    /// Compares the result with all measurements.
    fn compare(&self, fit: &Fit, findings: &mut Vec<Diagnostic>, report: &mut CalibrationResult) {
        let used = self.used.iter().enumerate().map(|(number, one)| {
            let sigmas = [fit.sigmas.get(number).copied(), fit.angle_sigmas.get(number).copied()];
            (one, sigmas, fitted(fit, number), false)
        });
        let held_out = self.held_out.iter().map(|one| (one, [one.data.sigma, one.data.sigma_rad], Vec::new(), true));
        for (one, sigmas, fitted, is_held_out) in used.chain(held_out) {
            let data = &one.data;
            let quality = match quality(self.begin.machine, &fit.errors, data) {
                Ok(found) => found,
                Err(fault) => {
                    not_identified::refuse(fault, &format!("{}: ", data.name), std::slice::from_ref(one), findings);
                    continue;
                }
            };
            for (angles, described, key) in [(false, data.sigma, "sigma_um"), (true, data.sigma_rad, "sigma_urad")] {
                let is_of_unit = |line: &ComparedReading| {
                    data.observations.get(line.row).is_some_and(|row| row.is_angle() == angles)
                };
                let left = quality.part(String::new(), is_of_unit).left[0];
                if let Some(described) = described.filter(|&described| left > POOR * described) {
                    let times = significant(left / described);
                    let name = &quality.name;
                    let message = format!("{name}: the residual (RMS) is {times} times {key}");
                    let can_drift = data.kind.free.contains(&Free::Drift) && !data.free.contains(&Free::Drift);
                    let or_free = if can_drift { ", or add \"drift\" to free if the axis has no backlash" } else { "" };
                    let help = format!(
                        "search for the errors that the model lacks with ncfix diagnose, or correct {key}; check the sign of the file; if the readings drift, measure faster{or_free}"
                    );
                    findings.push(Diagnostic::nowhere(Code::POOR_FIT, message, help));
                }
            }
            let held = ComparedMeasurement { data, quality, sigmas, fitted, is_held_out };
            let shown = held.shown(self.begin.machine, self.settings.with_readings);
            findings.extend(shown.iter().filter_map(|one| beyond_repeats(one, data)));
            report.data.extend(shown);
        }
    }
}

/// The warning about readings of a file without a stated uncertainty that miss the model by far more than they differ from each other at the same pose.
fn beyond_repeats(shown: &Data, described: &DataSet) -> Option<Diagnostic> {
    /// Residual over scatter that cannot be a chance.
    const BEYOND: f64 = 5.0;
    /// Degrees of freedom below which the scatter is not well known.
    const LEAST: usize = 10;
    let is_described = if shown.unit == Unit::Um { described.sigma.is_some() } else { described.sigma_rad.is_some() };
    let freedom: usize = shown.repeated.iter().map(|one| one.repetitions).sum();
    if is_described || shown.is_held_out || freedom < LEAST {
        return None;
    }
    let squares: f64 = shown.repeated.iter().map(|one| one.repetitions as f64 * one.sigma.powi(2)).sum();
    let scatter = (squares / freedom as f64).sqrt();
    let left = shown.kept.as_ref().map_or(shown.left_rms, |kept| kept.left_rms);
    if scatter == 0.0 || left <= BEYOND * scatter {
        return None;
    }
    let message = format!(
        "{}: the residual (RMS) is {} times the scatter of its repeated readings",
        shown.name,
        significant(left / scatter)
    );
    let help = "the model lacks an error of the machine, or the files contradict each other: calibrate this file alone, compare signs, set-ups and \
                reference temperatures, and search with ncfix diagnose";
    Some(Diagnostic::nowhere(Code::POOR_FIT, message, help))
}

/// Beginning of a header line of an earlier calibration.
const HEAD: &str = "# calibrated:";

/// The RMS residual of the held-out readings of lengths, µm; `None` without such readings.
#[must_use]
pub fn holdout_um(result: &CalibrationResult) -> Option<f64> {
    let own = result.data.iter().filter(|one| one.is_held_out && one.unit == Unit::Um && one.readings > 0);
    let [squares, count] = own.fold([0.0, 0.0], |[squares, count], one| {
        let readings = one.readings as f64;
        [squares + readings * one.left_rms * one.left_rms, count + readings]
    });
    // Nanometers suffice in a file that people read.
    (count > 0.0).then(|| ((squares / count).sqrt() * 1e3).round() / 1e3)
}

/// Refuses a fit that predicts the readings used worse than a machine without errors: most of them may be outliers without weight, or the errors that stay
/// in the file contradict them.
fn worse(report: &CalibrationResult) -> Option<Diagnostic> {
    if let Some(found) = contradicting(report) {
        return Some(found);
    }
    let of = |unit: Unit| report.efficiency(false, unit).filter(|efficiency| *efficiency < -WORSE);
    let efficiency = of(Unit::Um).or_else(|| of(Unit::Urad))?;
    let message = format!(
        "the readings are {:.0} % farther from the fitted model than from a machine without errors",
        -100.0 * efficiency
    );
    let help =
        "state sigma_um, or check signs and set-ups in the description; --no-robust gives all rows the same weight";
    Some(Diagnostic::nowhere(Code::NOT_SETTLED, message, help))
}

/// Refuses a fit of several files that contradicts one of them: with the model, its readings are much farther off than without any error.
fn contradicting(report: &CalibrationResult) -> Option<Diagnostic> {
    let used = || report.data.iter().filter(|one| !one.is_held_out && one.readings > 0);
    let one = used()
        .filter(|_| used().count() > 1)
        .find(|one| one.efficiency < -CONTRADICTS && one.left_rms > CONTRADICTS_FROM)?;
    let message = format!(
        "the fitted model contradicts {}: its readings are {:.0} % farther from the model than from a machine without errors",
        one.name,
        -100.0 * one.efficiency
    );
    let help = format!(
        "check the sign of the readings of {} and its set-up in the description; ncfix diagnose with these files tests the sign of each file",
        one.name
    );
    Some(Diagnostic::nowhere(Code::NOT_SETTLED, message, help))
}

/// The part of the residual that the described uncertainty of the instruments does not explain, root mean square of the lengths, µm: of held-out readings if
/// there are any, else of the `used` ones. `None` if no description states an uncertainty.
#[must_use]
pub fn unexplained_um(result: &CalibrationResult, used: &[Measurement]) -> Option<f64> {
    let described_um = |name: &str| {
        let own = used.iter().find(|one| one.data.name == name);
        own.and_then(|one| one.data.sigma).map(um_from_mm)
    };
    let of = |is_held_out: bool| {
        let own = result.data.iter().filter(|one| one.is_held_out == is_held_out && one.unit == Unit::Um);
        let squares = own.filter_map(|one| {
            let sigma = if is_held_out { one.sigma } else { described_um(&one.name) }?;
            let readings = one.readings as f64;
            let (square, expected) = (one.left_rms * one.left_rms, sigma * sigma);
            let is_scatter = square <= expected * (1.0 + CLEAR * (2.0 / readings.max(1.0)).sqrt());
            Some([readings, if is_scatter { 0.0 } else { readings * (square - expected) }])
        });
        let [count, sum] = squares.fold([0.0, 0.0], |[count, sum], one| [count + one[0], sum + one[1]]);
        (count > 0.0).then(|| (sum / count).sqrt())
    };
    // Nanometres suffice in a file that people read.
    of(true).or_else(|| of(false)).map(|um| (um * 1e3).round() / 1e3)
}

/// The text of a machine file with the parameters of a fit, the measured ranges and the uncertainties. Header lines with their origin replace those of an earlier calibration.
///
/// # Errors
/// The reason why it cannot be written, as a part of a sentence.
pub fn machine_text(
    (start, registers): (&Source, &ModelRegisters),
    before: &ErrorModel,
    (fit, measured, uncertainty): (&Fit, &MeasuredRanges, &Uncertainty),
    head: &[String],
) -> Result<String, String> {
    let old = std::str::from_utf8(start.bytes()).map_err(|_| "it is not UTF-8")?;
    let errors = &fit.errors;
    let body = write::write(old, before, errors).map_err(|reason| reason.0)?;
    let names = fit.estimates.iter().filter_map(|one| one.column.parameter()).map(|name| name.to_string());
    let body = names.fold(body, |body, name| describe::measured(&body, &name));
    let body = measured.written_into(&body).ok_or("measured is not a section")?;
    let body = uncertainty.written_into(&body).ok_or("uncertainty is not a section")?;
    let head = head.iter().map(|line| format!("{HEAD} {line}"));
    let kept = body.lines().skip_while(|line| line.starts_with(HEAD)).map(str::to_owned);
    let text: String = head.chain(kept).map(|line| line + "\n").collect();
    // The written text must give the fitted values.
    let again =
        Source::new(start.id(), start.name(), text.clone().into_bytes()).map_err(|_| "it is too long".to_owned())?;
    let Some((_, written)) = file::load_with(&again, registers).0 else {
        return Err("the result is not a valid machine file".into());
    };
    let is_own =
        |head: &&ErrorModel| head.head_entries.map(|place| place.index) == before.head_entries.map(|place| place.index);
    let written = written.heads.iter().find(is_own).cloned().unwrap_or(written);
    for parameter in fit.estimates.iter().filter_map(|one| one.column.parameter()) {
        let (found, read) = (parameter.get(errors), parameter.get(&written));
        if (found - read).abs() > 1e-9 * found.abs() + f64::MIN_POSITIVE {
            return Err(format!("{parameter} would read {read:e} instead of {found:e}"));
        }
    }
    Ok(text)
}

/// Reports readings whose size indicates another unit than that of their column.
#[must_use]
pub fn check_sizes(begin: &CalibrationStart<'_>, measurement: &Measurement, max_mm: f64) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    let data = &measurement.data;
    let help = "check the unit of the column; if the machine really has such errors, give a larger --max";
    // Lengths, then angles: sum of squares, count, the first row.
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
                let (place, shown) = cell(measurement, row.place, index);
                let message =
                    format!("{shown} is beyond {}, more than any plausible reading", micrometers(um_from_mm(max_mm)));
                findings.push(Diagnostic::at(Code::DATA_SIZE, place, message, help));
            }
        }
    }
    let kinds = [(data.sigma, "lengths", "sigma_um"), (data.sigma_rad, "angles", "sigma_urad")];
    for ((sum, count, first), (sigma, what, key)) in sums.into_iter().zip(kinds) {
        if let (Some(sigma), Some(first)) = (sigma, first)
            && (sum / count).sqrt() < sigma * if count < FEW { LEAST_OF_FEW } else { LEAST_OF_MANY }
        {
            let (place, _) = cell(measurement, first, 0);
            let message = format!("the RMS of all {what} is far less than {key}");
            let help = format!("check the unit of the column and {key} in the description");
            findings.push(Diagnostic::at(Code::DATA_SIZE, place, message, help));
        }
    }
    check_balls(begin, measurement, max_mm, &mut findings);
    check_bars(begin, measurement, max_mm, &mut findings);
    findings
}

/// Number of readings below which they can all be near zero by chance.
const FEW: f64 = 10.0;
/// Least RMS of many and of few readings, relative to their standard uncertainty. A wrong unit is a factor of 1000. A perfect axis has readings as large as their
/// uncertainty, and a single one is below a hundredth of it with a probability of 0.8 %.
const LEAST_OF_MANY: f64 = 0.1;
const LEAST_OF_FEW: f64 = 0.01;

/// Reports set-ups of a ball-bar in which most positions are not at its length from its center. A fit would take the difference for a free length.
fn check_bars(begin: &CalibrationStart<'_>, measurement: &Measurement, max_mm: f64, findings: &mut Vec<Diagnostic>) {
    let data = &measurement.data;
    if data.kind.measurand != Measurand::BallDistance {
        return;
    }
    let model = begin.model();
    for (number, setup) in data.setups.iter().enumerate() {
        let rows = || data.observations.iter().filter(|row| row.setup == number);
        let away = |row: &Observation| {
            (model.nominal(&row.reading.position, &row.reading.tool_mm).translation - setup.centre_mm).norm()
        };
        let mut all: Vec<f64> = rows().map(away).collect();
        let (Some(first), half) = (rows().next(), all.len() / 2) else { continue };
        let off = |away: &f64| (away - setup.length_mm).abs();
        let distance = *all.select_nth_unstable_by(half, |a, b| off(a).total_cmp(&off(b))).1;
        if setup.length_mm > 0.0 && off(&distance) > max_mm {
            let message = format!(
                "half of the positions{} are {:.3} mm or more from a circle of length_mm = {} about centre_mm; one is {distance:.3} mm from centre_mm",
                if setup.label.is_empty() { String::new() } else { format!(" of set-up {}", setup.label) },
                off(&distance),
                setup.length_mm
            );
            let help = "check centre_mm and length_mm of the description, and tool_z_mm; give a larger --max if the machine really has such errors";
            findings.push(Diagnostic::at(Code::DATA_SIZE, first.place, message, help));
        }
    }
}

/// Reports probings that are far from the others of their ball.
fn check_balls(begin: &CalibrationStart<'_>, measurement: &Measurement, max_mm: f64, findings: &mut Vec<Diagnostic>) {
    let data = &measurement.data;
    if data.kind.measurand != Measurand::BallPlace || !data.free.is_empty() {
        return;
    }
    let model = begin.model();
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
                let message = format!("the tip is {off:.3} mm from the position of the ball {label} in the other rows");
                let help = "check the positions, target and tool_x_mm … of the row; give a larger --max if the machine really has such errors";
                findings.push(Diagnostic::at(Code::DATA_SIZE, row.place, message, help));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::calibrated::Data;

    #[test]
    fn a_fit_that_is_worse_than_no_model_is_refused() {
        let report = |left: f64, is_held_out: bool| {
            let one = Data { sums: [10.0, left], is_held_out, unit: Unit::Um, ..Data::default() };
            CalibrationResult { data: vec![one], ..CalibrationResult::default() }
        };
        // Sums of magnitudes: 23 left of 10 are 130 % more; 10.4 are within the scatter of a fit without effect.
        let found = worse(&report(23.0, false)).unwrap();
        assert!(found.code == Code::NOT_SETTLED && found.message.contains("130 %"), "{found:?}");
        assert!([worse(&report(10.4, false)), worse(&report(23.0, true))].iter().all(Option::is_none));
    }
}
