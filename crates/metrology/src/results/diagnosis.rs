//! A complete diagnosis: faults of the data, the search for causes, their presentation, and the extended machine file.

use std::panic::resume_unwind;

use serde::Serialize;

pub use super::data_faults::DataFault;
use super::extended::{Extended, ExtensionJob};
use super::hypotheses::{self, HypothesisReport, HypothesisSet};
use super::measurement::{Measurement, check_copies};
use super::readings::{self, ShownReadings};
use super::references::Together;
use super::size_range;
pub use super::size_range::{PositionUnit, SizeRange};
use super::{alignment, conditions, data_faults, has_errors, references};
use crate::diagnose::cause::Correctable;
use crate::diagnose::extend::extension;
use crate::diagnose::fault::{Checks, DefectKind};
use crate::diagnose::{
    self, ArmRisk, Causes, Compared, DiagnosedCauses, ExplanationSummary, FAR_OUT, Gate, NextMeasurement, NoiseSource,
    RivalCause, Scene, SignContradiction, fault, freedom_of, reads_angles, shape, stated,
};
use crate::measure::data::DataSet;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source;
use ncfix_base::units::UnitKey;
use ncfix_machine::machine::Machine;
use ncfix_model::{ErrorModel, ModelRegisters};

/// Minimum number of readings beyond the unknowns of set-ups.
const LEAST: usize = 3;

/// The version of the object.
pub const SCHEMA: u32 = 1;

/// Missing causes of the model, with evidence, and the residuals.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DiagnosisResult {
    /// Version of this format, 1.
    pub schema: u32,
    /// Unit of all sizes `…_um`: `um`, or `urad` if only angles were read.
    pub unit: UnitKey,
    /// Noise of the readings.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub noise_um: f64,
    /// Source of the noise estimate.
    pub noise_from: NoiseFrom,
    /// Noise stated in the descriptions of the instruments; `null` if not stated.
    pub noise_stated_um: Option<f64>,
    /// Residuals of an error-free machine.
    pub without_model: ReadingSizes,
    /// Residuals of the model.
    pub before: ReadingSizes,
    /// Missing causes, in the order of their gain on left-out readings.
    pub findings: Vec<CauseReport>,
    /// Faults of the data: excluded readings, and faults that are only reported.
    pub data_faults: Vec<DataFault>,
    /// Residuals after all findings.
    pub after: ReadingSizes,
    /// Relative reduction of the RMS.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub gain: f64,
    /// Relative reduction on the held-out data.
    pub holdout_gain: Option<f64>,
    /// Its 95 % interval.
    pub holdout_gain_95: Option<[f64; 2]>,
    /// True if the model fits the data (held-out data, if any) worse than no model.
    pub expired: bool,
    /// Residual beyond the noise.
    pub unexplained: Unexplained,
    /// Causes in the data that the held-out data did not confirm.
    pub not_confirmed: Vec<String>,
    /// Candidates that failed an acceptance test.
    pub rejected: Vec<RejectedReport>,
    /// The most probable explanations, each a set of causes; empty if none was compared.
    pub explanations: Vec<ExplanationSummary>,
    /// Probability that there is no cause, only noise; `null` if nothing was compared.
    pub no_cause_probability: Option<f64>,
    /// Measurements that separate the explanations, the best first; empty if the first explanation is certain, or no plan separates them.
    pub measure_next: Vec<NextMeasurement>,
    /// Files or set-ups that contradict each other in sign; `null` if all signs agree.
    pub contradiction: Option<SignContradiction>,
    /// Residuals with the extended machine file alone; `null` if there is nothing to write.
    pub written: Option<WrittenSizes>,
    /// Stated hypotheses, in their order.
    pub hypotheses: Vec<HypothesisReport>,
    /// Combinations of the stated hypotheses, the most probable first.
    pub hypotheses_together: Vec<HypothesisSet>,
    /// Number of candidates tried.
    pub tried: usize,
    /// Number of readings used.
    pub readings: usize,
    /// Name of the machine.
    pub machine: String,
}

/// A residual beyond this multiple of the noise is no noise.
const NOISY: f64 = 2.0;
/// An explanation with this probability is more probable than all others together.
const PROBABLE: f64 = 0.5;

impl DiagnosisResult {
    /// True if no cause is found or probable, and the residual does not exceed the noise: the machine file needs no change.
    #[must_use]
    pub fn needs_no_change(&self) -> bool {
        let is_probable = |first: &ExplanationSummary| !first.terms.is_empty() && first.probability >= PROBABLE;
        self.findings.is_empty()
            && !self.expired
            && !self.unexplained.structure
            && self.after.rms_um <= NOISY * self.noise_um
            && !self.explanations.first().is_some_and(is_probable)
    }

    /// Sets all sizes to unknown if nothing was diagnosed: `null` in JSON, not zero.
    pub fn forget_sizes(&mut self) {
        let none = ReadingSizes {
            rms_um: f64::NAN,
            rms_95_um: [f64::NAN; 2],
            max_um: f64::NAN,
            efficiency: f64::NAN,
            ..ReadingSizes::default()
        };
        [self.without_model, self.before, self.after] = [none; 3];
        [self.noise_um, self.gain, self.unexplained.rms_um, self.unexplained.p] = [f64::NAN; 4];
    }
}

/// Residuals of the model and of the extended machine file, which contains the causes that a file can hold, for the same readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WrittenSizes {
    /// Number of causes in it.
    pub causes: usize,
    /// RMS with the current model.
    pub before_rms_um: f64,
    /// RMS with the extended file.
    pub after_rms_um: f64,
    /// RMS of the held-out data with the current model.
    pub holdout_before_rms_um: Option<f64>,
    /// RMS of the held-out data with the extended file.
    pub holdout_after_rms_um: Option<f64>,
    /// Errors along lines through the whole travel, corrected and verified with the extended file; `null` without a written file.
    pub travel: Option<TravelSizes>,
}

/// Errors of the tool tip along lines through the whole travel with the longest tool, by the model of the file: as programmed, and corrected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TravelSizes {
    /// RMS as programmed.
    pub before_rms_um: f64,
    /// Largest as programmed.
    pub before_max_um: f64,
    /// RMS of the corrected lines.
    pub after_rms_um: f64,
    /// Largest of the corrected lines.
    pub after_max_um: f64,
}

/// Source of the noise estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum NoiseFrom {
    /// Nothing was diagnosed.
    #[default]
    #[serde(rename = "")]
    Nowhere,
    /// From repeated readings.
    Repeats,
    /// From the description of the instrument.
    Instrument,
    /// From differences of neighbors.
    Neighbours,
    /// From the whole residual: it is white, and larger than stated.
    Rest,
}

impl From<NoiseSource> for NoiseFrom {
    fn from(source: NoiseSource) -> NoiseFrom {
        match source {
            NoiseSource::Repeats => NoiseFrom::Repeats,
            NoiseSource::Instrument => NoiseFrom::Instrument,
            NoiseSource::Differences => NoiseFrom::Neighbours,
            NoiseSource::Rest => NoiseFrom::Rest,
        }
    }
}

/// Statistics of readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReadingSizes {
    /// RMS.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub rms_um: f64,
    /// Its 95 % interval.
    #[cfg_attr(feature = "schema", schemars(with = "[Option<f64>; 2]"))]
    pub rms_95_um: [f64; 2],
    /// Largest magnitude.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub max_um: f64,
    /// Explained share of the sum of magnitudes (Spaan 1995, eq. 3.6).
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub efficiency: f64,
    /// RMS of the held-out data.
    pub holdout_rms_um: Option<f64>,
    /// Its 95 % interval.
    pub holdout_rms_95_um: Option<[f64; 2]>,
    /// Largest magnitude of the held-out data.
    pub holdout_max_um: Option<f64>,
    /// Efficiency on the held-out data.
    pub holdout_efficiency: Option<f64>,
}

/// The part that no finding explains.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Unexplained {
    /// RMS beyond the noise.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub rms_um: f64,
    /// True if it is more than noise, and large enough to matter.
    pub structure: bool,
    /// p-value of its autocorrelation (Ljung & Box).
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub p: f64,
    /// Columns with which it correlates.
    pub with: Vec<With>,
}

/// A column with which the residual correlates.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct With {
    /// Its name.
    pub driver: String,
    /// Correlated part, RMS.
    pub rms_um: f64,
}

/// A candidate that was not accepted.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RejectedReport {
    /// Kind of effect.
    pub effect: String,
    /// ISO 230-1 name, axes or direction.
    pub parameter: String,
    /// Its drivers.
    pub drivers: Vec<String>,
    /// The acceptance test that it failed.
    pub why: Gate,
    /// p-value, corrected for all candidates.
    pub p: f64,
    /// Relative reduction of the RMS of left-out readings; `null` if not determined.
    pub gain: Option<f64>,
    /// Its value in each file, if files differ significantly; otherwise empty.
    pub by_file: Vec<InFile>,
}

/// The value of a cause in one file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InFile {
    /// The measurement.
    pub file: String,
    /// Size.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Expanded uncertainty (95 %).
    pub u95: f64,
}

/// A point of a shape.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShapePlace {
    /// Values of the drivers, in their order and units.
    pub at: Vec<f64>,
    /// The deviation at this point (µrad if the unit of the finding is `urad`).
    pub value_um: f64,
}

/// A missing cause that was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CauseReport {
    /// Kind of effect.
    pub effect: String,
    /// ISO 230-1 name, axes or direction.
    pub parameter: String,
    /// Its drivers.
    pub drivers: Vec<String>,
    /// Temperature sensor; `null` without one.
    pub sensor: Option<String>,
    /// Its time constant.
    pub lag_s: Option<f64>,
    /// Period, if periodic.
    pub period: Option<f64>,
    /// Path from a reversal over which a spike decays, mm.
    pub decay_mm: Option<f64>,
    /// Positions of an axis between which it begins, mm, if it acts only on one side of them.
    pub threshold_mm: Option<[f64; 2]>,
    /// Axis of `threshold_mm`.
    pub threshold_axis: Option<String>,
    /// Size: reversal value, amplitude, slope, range over the travel.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Expanded uncertainty (95 %).
    pub u95: f64,
    /// Measured ranges over which it has this size; empty if the size is the same everywhere.
    pub over: Vec<SizeRange>,
    /// RMS of its effect on the readings.
    pub rms_um: f64,
    /// Range of its effect on the readings of a set-up: largest minus smallest.
    pub alone_um: f64,
    /// Share of this range in the sum over all findings.
    pub alone_share: f64,
    /// Relative reduction of the RMS of left-out readings.
    pub gain_holdout: f64,
    /// Share of the squares (Shapley).
    pub share: f64,
    /// Share of the squares without it in the model.
    pub share_alone: f64,
    /// p-value, corrected for all candidates.
    pub p: f64,
    /// Probability: sum over all explanations that contain it; `null` if explanations were not compared.
    pub probability: Option<f64>,
    /// True if it is certain enough to act on it; only then a machine file can contain it.
    pub certain: bool,
    /// Causes that predict its readings to within the noise but depend on another quantity, such as time or direction, the most probable first.
    pub rivals: Vec<RivalCause>,
    /// Its value in each file, if files differ significantly; otherwise empty.
    pub by_file: Vec<InFile>,
    /// An angle that explains its readings as well, because they have one arm, and what this changes elsewhere; `null` if the readings separate them.
    pub arm: Option<ArmRisk>,
    /// Equivalent explanations, itself first.
    pub class: Vec<String>,
    /// The same squareness by the names of other axes, each with its value in `unit`.
    pub same_as: Vec<OtherName>,
    /// The measurement that separates the causes of `class`; `null` for a single one.
    pub separate_by: Option<String>,
    /// Possible correction.
    pub correctable: Correctable,
    /// True if a machine file was written and contains it; false without a written file.
    pub extends: bool,
    /// Reason why a machine file must not contain it; `null` if it can.
    pub extends_why: Option<String>,
    /// Physical cause.
    pub made_by: String,
    /// Evidence.
    pub shown_by: String,
    /// For an unnamed finding: its drivers and the range where it acts, as a sentence.
    pub what: Option<String>,
    /// Its value over its drivers; empty if the single value suffices.
    pub shape: Vec<ShapePlace>,
    /// The unit of the shape.
    #[serde(skip)]
    pub shape_unit: UnitKey,
}

/// Another name of a squareness.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OtherName {
    /// Its ISO 230-1 name.
    pub name: String,
    /// Its value.
    pub value: f64,
}

/// Settings of a diagnosis other than the causes.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiagnosisSettings<'a> {
    /// The causes to search; default: the built-in ones.
    pub causes: Option<&'a Causes>,
    /// The kinds of faults of the data to search; default: the built-in ones.
    pub checks: Option<&'a Checks>,
    /// Error types of the machine file; default: the built-in ones.
    pub model: Option<&'a ModelRegisters>,
    /// The machine file, if any: errors that it cannot contain are not called correctable.
    pub file: Option<&'a source::Source>,
    /// `true` if it is to be written with the findings; they then contain the reason if they are not in it.
    pub is_extended: bool,
    /// `true` to keep single readings for pictures.
    pub with_readings: bool,
    /// Hypotheses to test, one per line.
    pub hypotheses: Option<&'a source::Source>,
}

/// Diagnoses measurements, of which the first `used` are used and the others held out; `None` if diagnostics explain why nothing was diagnosed.
/// `progress` receives the current step and the completed share. Returns the machine file with the findings, if one was given.
pub fn run(
    (machine, errors): (&Machine, &ErrorModel),
    mut all: Vec<Measurement>,
    used: usize,
    settings: DiagnosisSettings<'_>,
    progress: &mut dyn FnMut(&str, f64),
    findings: &mut Vec<Diagnostic>,
    (report, shown): (&mut DiagnosisResult, &mut ShownReadings),
) -> Option<Option<Extended>> {
    report.schema = SCHEMA;
    report.machine.clone_from(&machine.name);
    let stated = match settings.hypotheses {
        Some(text) => {
            let sets: Vec<&DataSet> = all.iter().map(|one| &one.data).collect();
            let (stated, faults) = stated::read_options(text, machine, &sets);
            findings.extend(faults);
            stated
        }
        None => Vec::new(),
    };
    findings.extend(check_copies(&all));
    let drifting: Vec<DataSet> =
        all.iter().filter(|one| !one.data.cycles.is_empty()).map(|one| one.data.clone()).collect();
    findings.extend(conditions::check_reversals(errors, std::iter::empty(), &drifting));
    if has_errors(findings) {
        return None;
    }
    alignment::release(&mut all, used, findings);
    references::check(all.iter(), Together::Search, findings);
    let checks = settings.checks.cloned().unwrap_or_default();
    let faults = data_faults::look((machine, errors, &checks), &mut all, used, findings, &mut report.data_faults);
    let sets: Vec<DataSet> = all.into_iter().map(|one| one.data).collect();
    if has_errors(findings) {
        return None;
    }
    let scene = |errors: &ErrorModel| Scene::new(machine, errors, &sets);
    let (of_model, bare) = std::thread::scope(|scope| {
        let of_model = scope.spawn(|| scene(errors));
        let bare = scene(&ErrorModel::default());
        (of_model.join().unwrap_or_else(|fault| resume_unwind(fault)), bare)
    });
    let (Ok(mut of_model), Ok(mut bare)) = (of_model, bare) else {
        let message = "the readings do not even determine the set-ups";
        let help =
            "check the columns of positions and their units, describe what is known of the set-ups, or measure more";
        findings.push(Diagnostic::nowhere(Code::NOT_TOLD, message, help));
        return None;
    };
    fault::exclude(&mut of_model, &faults);
    fault::exclude(&mut bare, &faults);
    let [readings, unknowns] = freedom_of(&of_model, used);
    if readings < unknowns + LEAST {
        let message =
            format!("{readings} usable readings and {unknowns} unknowns of the set-ups: no degree of freedom remains");
        let help = "measure more, or describe what is known of the set-ups (remove it from free)";
        findings.push(Diagnostic::nowhere(Code::NOT_TOLD, message, help));
        return None;
    }
    let built_in = Causes::default();
    let causes = settings.causes.unwrap_or(&built_in);
    let (found, trials) = stated::diagnose_stated(&stated, causes, &of_model, (&bare, used), progress);
    tell_all(&found, &of_model, (&sets, used), report);
    findings.extend(outliers(&found, &sets, used));
    (report.hypotheses, report.hypotheses_together) = hypotheses::reports(&trials, &of_model);
    let extension = extension(&found, &of_model, used);
    let refused: Vec<Option<String>> = extension.iter().map(|changes| changes.as_ref().err().cloned()).collect();
    let registers = settings.model.cloned().unwrap_or_default();
    let job = ExtensionJob { machine, registers, scene: &of_model, used, found: &found, extension };
    let mut aside = Vec::new();
    let made = settings.file.and_then(|file| job.make(file, if settings.is_extended { findings } else { &mut aside }));
    can_be_done(made.as_ref().map_or(&refused, |made| &made.why_not), report);
    report.written = made.as_ref().and_then(|made| written(made, report.unit));
    if settings.is_extended
        && let Some(made) = &made
    {
        report.findings.iter_mut().zip(&made.why_not).for_each(|(one, why_not)| one.extends = why_not.is_none());
    }
    if settings.with_readings {
        readings::fill((&found, &trials), &of_model, used, shown);
    }
    Some(made)
}

/// Residuals of the extended file, in display units.
fn written(made: &Extended, unit: UnitKey) -> Option<WrittenSizes> {
    let micro = unit.unit().shown(1.0);
    let [used, held_out] = made.residuals;
    let [before, after] = used?;
    Some(WrittenSizes {
        causes: made.why_not.iter().filter(|why_not| why_not.is_none()).count(),
        before_rms_um: micro * before,
        after_rms_um: micro * after,
        holdout_before_rms_um: held_out.map(|[before, _]| micro * before),
        holdout_after_rms_um: held_out.map(|[_, after]| micro * after),
        travel: None,
    })
}

/// Sets the possible correction of findings, with or without a written file: a table of the file needs no name, and an error that the file cannot
/// contain is not correctable.
fn can_be_done(why_not: &[Option<String>], report: &mut DiagnosisResult) {
    for (told, why_not) in report.findings.iter_mut().zip(why_not) {
        told.extends_why.clone_from(why_not);
        if why_not.is_some() {
            told.correctable = Correctable::No;
        } else if told.correctable == Correctable::No {
            told.correctable = Correctable::Program;
        }
    }
}

/// All findings, in display units.
fn tell_all(
    found: &DiagnosedCauses,
    scene: &Scene<'_>,
    (sets, used): (&[DataSet], usize),
    report: &mut DiagnosisResult,
) {
    let of_angles = reads_angles(scene);
    report.unit = UnitKey::of(of_angles);
    let micro = report.unit.unit().shown(1.0);
    let level = |of: fn(&Compared) -> diagnose::Sizes| {
        let held_out = found.held_out.as_ref().map(of);
        let own = of(&found.used);
        ReadingSizes {
            rms_um: micro * own.rms,
            rms_95_um: own.interval.map(|end| micro * end),
            max_um: micro * own.max,
            efficiency: own.efficiency,
            holdout_rms_um: held_out.map(|sizes| micro * sizes.rms),
            holdout_rms_95_um: held_out.map(|sizes| sizes.interval.map(|end| micro * end)),
            holdout_max_um: held_out.map(|sizes| micro * sizes.max),
            holdout_efficiency: held_out.map(|sizes| sizes.efficiency),
        }
    };
    report.without_model = level(|compared| compared.measured);
    report.before = level(|compared| compared.before);
    report.after = level(|compared| compared.after);
    report.readings = found.used.readings;
    report.gain = found.used.gain.0;
    report.holdout_gain = found.held_out.as_ref().map(|held_out| held_out.gain.0);
    report.holdout_gain_95 = found.held_out.as_ref().map(|held_out| held_out.gain.1);
    report.expired = found.held_out.as_ref().map_or(found.used.is_expired, |held_out| held_out.is_expired);
    report.noise_um = micro * found.left.noise;
    report.noise_stated_um = found.left.stated.map(|stated| micro * stated);
    report.noise_from = found.left.source.into();
    report.unexplained = Unexplained {
        rms_um: micro * found.left.unexplained,
        structure: found.left.has_structure,
        p: found.left.chance,
        with: found
            .left
            .places
            .iter()
            .map(|(driver, rms)| With { driver: driver.clone(), rms_um: micro * rms })
            .collect(),
    };
    report.tried = found.tried;
    report.explanations.clone_from(&found.explanations);
    report.no_cause_probability = found.nothing;
    report.measure_next.clone_from(&found.next);
    report.contradiction.clone_from(&found.contradiction);
    let alone: f64 = found.findings.iter().map(|one| one.alone).sum();
    report.findings = found.findings.iter().map(|one| cause(one, scene, used, (micro, alone))).collect();
    report.rejected = found.rejected.iter().map(|one| rejected(one, scene)).collect();
    report.not_confirmed =
        found.not_confirmed.iter().map(|one| format!("{} {}", one.cause.effect, one.parameter)).collect();
    for (number, set) in sets.iter().enumerate().take(used) {
        let rows: Vec<usize> =
            found.outliers.iter().filter(|(set, _)| *set == number).map(|(_, row)| row + 1).collect();
        if !rows.is_empty() {
            let times = FAR_OUT;
            report.data_faults.push(DataFault {
                kind: DefectKind::Outlier,
                name: set.name.clone(),
                what: "far from all others".to_owned(),
                evidence: format!(
                    "no explanation fits {} within {times} times the usual scatter of this file",
                    if rows.len() == 1 {
                        "the reading of 1 row".to_owned()
                    } else {
                        format!("the readings of {} rows", rows.len())
                    }
                ),
                excluded: "these readings".into(),
                is_range: false,
                file: set.name.clone(),
                rows,
            });
        }
    }
}

/// A warning for each file with readings that the search excluded, at the first of them.
fn outliers(found: &DiagnosedCauses, sets: &[DataSet], used: usize) -> Vec<Diagnostic> {
    let of = |(number, set): (usize, &DataSet)| {
        let mut rows: Vec<usize> =
            found.outliers.iter().filter(|(set, _)| *set == number).map(|(_, row)| *row).collect();
        rows.sort_unstable();
        rows.dedup();
        let first = set.observations.get(*rows.first()?)?;
        let message = match rows.len() {
            1 => format!("this reading is not used: no explanation fits it within {FAR_OUT} times the usual scatter"),
            count => format!(
                "{count} readings of this file are not used, the first of them here: no explanation fits them within {FAR_OUT} times the usual scatter"
            ),
        };
        let help = "find its cause; ncfix does not change the file";
        Some(Diagnostic::at(Code::FAULTY_DATA, first.place, message, help))
    };
    sets.iter().take(used).enumerate().filter_map(of).collect()
}

fn cause(found: &diagnose::AcceptedCause, scene: &Scene<'_>, used: usize, (micro, alone): (f64, f64)) -> CauseReport {
    let one = &found.candidate;
    // Causes of the same effect have one name.
    let mut class: Vec<String> = Vec::new();
    for (cause, parameter) in &found.class {
        let name = format!("{} {parameter}", cause.effect).trim_end().to_owned();
        if !class.contains(&name) {
            class.push(name);
        }
    }
    let is_spike = one.cause.effect == diagnose::cause::EffectKind::ReversalSpike;
    CauseReport {
        effect: one.cause.effect.to_string(),
        parameter: one.parameter.clone(),
        drivers: one.drivers.clone(),
        sensor: one.sensor.clone(),
        lag_s: (one.sensor.is_some() || one.cause.effect == diagnose::cause::EffectKind::SpindleSpeed)
            .then(|| one.constant.filter(|(_, unit)| *unit == "s").map_or(0.0, |(lag, _)| lag)),
        period: one.constant.filter(|(_, unit)| !is_spike && ["mm", "deg"].contains(unit)).map(|(period, _)| period),
        decay_mm: one.constant.filter(|_| is_spike).map(|(length, _)| length),
        threshold_mm: one.threshold.map(|(_, ends)| ends),
        threshold_axis: one.threshold.map(|(axis, _)| axis.to_string()),
        value: found.size.value,
        unit: found.size.unit.into(),
        u95: found.size.u95,
        over: size_range::ranges(found, scene, used),
        rms_um: micro * found.rms,
        alone_um: micro * found.alone,
        alone_share: if alone > 0.0 { found.alone / alone } else { 0.0 },
        gain_holdout: found.gain_unseen,
        share: found.share.fair,
        share_alone: found.share.alone,
        p: found.chance,
        probability: found.probability,
        certain: found.is_certain(),
        rivals: found.rivals.clone(),
        arm: found.arm.clone(),
        by_file: by_file(&found.by_file, &found.size, scene),
        separate_by: found.separate_by.clone().filter(|_| class.len() > 1),
        same_as: found
            .same_as
            .iter()
            .map(|(name, factor)| OtherName { name: name.clone(), value: factor * found.size.value })
            .collect(),
        class,
        correctable: one.cause.correctable,
        extends: false,
        extends_why: None,
        made_by: one.cause.made_by.to_owned(),
        shown_by: one.cause.shown_by.to_owned(),
        what: shape::sentence(found, scene, used),
        // If columns represent positions, the single value is not meaningful.
        shape: if one.points.is_empty() { Vec::new() } else { shape::shape(found, scene, used) }
            .into_iter()
            .map(|(at, value_um)| ShapePlace { at, value_um })
            .collect(),
        shape_unit: UnitKey::of(diagnose::is_angle(&found.candidate)),
    }
}

fn by_file(parts: &[diagnose::FileShare], size: &diagnose::Size, scene: &Scene<'_>) -> Vec<InFile> {
    let of = |part: &diagnose::FileShare| InFile {
        file: scene.sets.get(part.set).map_or_else(String::new, |set| set.name.clone()),
        value: part.share * size.value,
        unit: size.unit.into(),
        u95: (part.u95 * size.value).abs(),
    };
    parts.iter().map(of).collect()
}

fn rejected(found: &diagnose::Rejected, scene: &Scene<'_>) -> RejectedReport {
    RejectedReport {
        effect: found.candidate.cause.effect.to_string(),
        parameter: found.candidate.parameter.clone(),
        drivers: found.candidate.drivers.clone(),
        why: found.gate,
        p: found.chance,
        gain: found.gain,
        by_file: by_file(&found.by_file, &found.size, scene),
    }
}
