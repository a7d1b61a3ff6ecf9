//! Calibration: parameters of a machine's error model from measured data.

use crate::data::{DataSet, measurements};
use crate::diagnostics::Diagnostics;
use crate::disk::hash::short_hash;
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{MeasuredRanges, Uncertainty};
use ncfix_metrology::calibrate::{Fit, Parameter};
use ncfix_metrology::measure::ranges::measured_ranges;
use ncfix_metrology::results::calibration::{
    CalibrationResult as Found, CalibrationSettings, CalibrationStart, EstimateReport, check_sizes, holdout_um,
    machine_text, prepare, unexplained_um,
};
use ncfix_metrology::results::measurement::{Measurement, Purpose};
use ncfix_metrology::results::not_shown::not_shown;
use ncfix_metrology::results::parameters::{self, ModelText};
use ncfix_metrology::results::stated::{StatedStart, start_with_terms};
use ncfix_metrology::results::uncertain::uncertainty_of;
use ncfix_model::{ErrorModel, ParameterName};

/// Options of a calibration. `CalibrationOptions::default()` gives the options of `ncfix calibrate` without arguments; no parameter is chosen yet.
///
/// ```
/// use ncfix::prelude::*;
///
/// let mut options = CalibrationOptions::default();
/// options.parameters = vec!["EC0X".into(), "EXX1".into()];
/// assert!(options.robust && options.max_mm == 1.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CalibrationOptions {
    /// The parameters to fit: presets such as `mayer-13` (`ncfix machine presets` lists them), and parameters such as
    /// `EC0X`, `EXX1`, `EXXb`, `EXX2@150` or `load.EAX`.
    pub parameters: Vec<String>,
    /// True if outlying readings get a lower weight.
    pub robust: bool,
    /// True to leave out parameters that the data do not determine, with a warning that names them.
    pub reduce: bool,
    /// Largest plausible reading or effect of a parameter, mm; larger ones are errors.
    pub max_mm: f64,
    /// Number of simulated repetitions, whose scatter is compared with the uncertainties.
    pub monte_carlo: Option<u64>,
    /// Seed of their noise.
    pub seed: u64,
}

impl Default for CalibrationOptions {
    fn default() -> CalibrationOptions {
        CalibrationOptions {
            parameters: Vec::new(),
            robust: true,
            reduce: false,
            max_mm: 1.0,
            monte_carlo: None,
            seed: 1,
        }
    }
}

/// The parameters of a machine fitted to data, with their uncertainties, and the residuals of every measurement.
///
/// ```
/// use ncfix::prelude::*;
///
/// let data = [DataSet::read("samples/measurements/ball_bar.csv")?];
/// let mut options = CalibrationOptions::default();
/// options.parameters = ["EC0X", "EXX1", "EXXb"].map(String::from).to_vec();
/// let found = Calibration::run(&Machine::demo(), &data, &options)?;
/// // The data were simulated with a squareness of 43 µrad.
/// let squareness = &found.result().parameters[0];
/// assert!((squareness.value - 43.0).abs() < 3.0 * squareness.sigma && squareness.unit == "µrad");
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Calibration {
    found: Found,
    fit: Fit,
    start: Machine,
    head: Vec<String>,
    measured: MeasuredRanges,
    uncertainty: Uncertainty,
    diagnostics: Diagnostics,
}

impl Calibration {
    /// Fits parameters to data, starting with the error model of the machine. [Held-out](DataSet::held_out) data only
    /// evaluate the result.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = [DataSet::read("samples/measurements/ball_bar.csv")?];
    /// let mut options = CalibrationOptions::default();
    /// options.parameters = vec!["EC0Q".into()];
    /// let error = Calibration::run(&Machine::demo(), &data, &options).unwrap_err();
    /// assert!(error.to_string().contains("EC0Q"), "{error}");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a name is not a parameter of the machine, the data are wrong, or the parameters are not identifiable. The diagnostics state the reason, and the
    /// measurement that is missing.
    pub fn run(machine: &Machine, data: &[DataSet], options: &CalibrationOptions) -> Result<Calibration, Error> {
        machine.check_one_head()?;
        let mut diagnostics = Diagnostics::default();
        let parameters = chosen(machine, &options.parameters, &mut diagnostics)?;
        let read = measurements(data, machine, (Purpose::Fit, &machine.registry.instruments), &mut diagnostics);
        let Some((mut all, used, sources)) = read else { return Err(Error::found(diagnostics)) };
        let begin = CalibrationStart {
            machine: &machine.machine,
            errors: &machine.errors,
            condition: &machine.condition,
            growth: &[],
        };
        for one in &all {
            diagnostics.extend(check_sizes(&begin, one, options.max_mm), &sources);
        }
        if machine.state.is_some() {
            all.iter_mut().for_each(|one| one.data.fill_in(&machine.condition));
        }
        let settings = CalibrationSettings {
            max_mm: options.max_mm,
            robust: options.robust,
            reduce: options.reduce,
            monte_carlo: options.monte_carlo.map(|runs| [runs, options.seed]),
            ..CalibrationSettings::default()
        };
        let mut found =
            Found { machine: machine.machine.name.clone(), model: options.parameters.join(" "), ..Found::default() };
        let mut own = Vec::new();
        let prepared = if diagnostics.has_errors() {
            None
        } else {
            prepare(begin, settings, all, used, parameters, &mut own, &mut found)
        };
        let fit = prepared.as_ref().and_then(|prepared| prepared.fit(None, &mut |_| {}, &mut own, &mut found));
        diagnostics.extend(own, &sources);
        match (fit, prepared) {
            (Some(fit), Some(prepared)) if !diagnostics.has_errors() => {
                let mut head = vec![format!("parameters {}", options.parameters.join(" "))];
                head.extend(prepared.used().iter().map(line_of));
                let measured = measured_by(machine, prepared.used(), &found);
                let unexplained_um = unexplained_um(&found, prepared.used());
                let uncertainty = uncertainty_of(machine.machine.uncertainty.as_ref(), &fit, unexplained_um);
                Ok(Calibration { found, fit, start: machine.clone(), head, measured, uncertainty, diagnostics })
            }
            _ => Err(Error::found(diagnostics)),
        }
    }

    /// The complete result, with the units in the names or next to the numbers: parameters and set-up unknowns with
    /// standard uncertainties, the measured value and the residual of every measurement including the held-out ones,
    /// ISO 230 figures, and outliers. `--json` prints this value.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = DataSet::read("samples/measurements/ball_bar.csv")?;
    /// let mut options = CalibrationOptions::default();
    /// options.parameters = vec!["EC0X".into()];
    /// let found = Calibration::run(&Machine::demo(), &[data], &options)?;
    /// let bar = &found.result().data[0];
    /// assert!(bar.left_rms < bar.measured_rms && bar.readings == 192);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn result(&self) -> &Found {
        &self.found
    }

    /// Warnings about the data and the result.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = DataSet::read("samples/measurements/ball_bar.csv")?;
    /// let mut options = CalibrationOptions::default();
    /// options.parameters = vec!["EC0X".into()];
    /// let found = Calibration::run(&Machine::demo(), &[data], &options)?;
    /// assert!(found.diagnostics().iter().all(|one| one.severity() == Severity::Warning));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// The machine with the fitted parameters.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = DataSet::read("samples/measurements/ball_bar.csv")?;
    /// let mut options = CalibrationOptions::default();
    /// options.parameters = ["EC0X", "EXX1", "EXXb"].map(String::from).to_vec();
    /// let machine = Calibration::run(&Machine::demo(), &[data.clone()], &options)?.machine();
    /// // There is nothing more to find in the same data.
    /// let again = Calibration::run(&machine, &[data], &options)?;
    /// assert!((again.result().parameters[0].value - again.result().parameters[0].start).abs() < 0.01);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn machine(&self) -> Machine {
        let mut machine = Machine { errors: self.fit.errors.clone(), ..self.start.clone() };
        machine.machine.measured = Some(self.measured.clone());
        machine.machine.uncertainty = Some(self.uncertainty.clone());
        machine
    }

    /// The text of a machine file with the result, and comments at its beginning that list the data. `text` is that
    /// of the machine file with which the calibration started; its comments stay.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let text = std::fs::read_to_string("samples/machines/demo.toml").unwrap();
    /// let machine = Machine::from_text("demo.toml", &text)?;
    /// let data = DataSet::read("samples/measurements/ball_bar.csv")?;
    /// let mut options = CalibrationOptions::default();
    /// options.parameters = vec!["EC0X".into()];
    /// let extended = Calibration::run(&machine, &[data], &options)?.extended_machine_text(&text)?;
    /// assert!(extended.starts_with("# calibrated: ") && Machine::from_text("new.toml", &extended).is_ok());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the text cannot hold the parameters.
    pub fn extended_machine_text(&self, text: &str) -> Result<String, Error> {
        let fault = |reason: String| Error::usage(format!("cannot write into the text of the machine file: {reason}"));
        let source = Source::new(FileId(0), "machine file", text.as_bytes().to_vec());
        let source = source.map_err(|_| fault("it is too long".into()))?;
        // A name may have any character; a comment ends with its line.
        let head: Vec<String> = self.head.iter().map(|line| line.replace(char::is_control, " ")).collect();
        let found = (&self.fit, &self.measured, &self.uncertainty);
        machine_text((&source, &self.start.registry.model), &self.start.errors, found, &head).map_err(fault)
    }

    /// The parameters of the machine, each with its standard uncertainty, in the order of the options.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = DataSet::read("samples/measurements/ball_bar.csv")?;
    /// let mut options = CalibrationOptions::default();
    /// options.parameters = vec!["EC0X".into()];
    /// for one in Calibration::run(&Machine::demo(), &[data], &options)?.parameters() {
    ///     println!("{} {:.1} ± {:.1} {}", one.name, one.value, one.sigma, one.unit);
    /// }
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn parameters(&self) -> &[EstimateReport] {
        &self.found.parameters
    }
}

/// The text of the new machine file: the original with the parameters, and comments at its beginning that list their
/// source. The calibration starts from the original, or from the original with the stated terms.
///
/// # Errors
/// If they cannot be written into it.
pub(crate) fn text_of(
    (chosen, errors): (&Machine, &ErrorModel),
    (original, start): (&Source, &Source),
    model: &str,
    (fit, found): (&Fit, &Found),
    used: &[Measurement],
) -> Result<String, Error> {
    let condition = chosen.state.as_ref().map_or_else(String::new, |hash| format!(", condition ({hash})"));
    let hash = short_hash([original.bytes()]);
    let mut head = vec![format!("model {}, began with {} ({hash}){condition}", in_line(model), in_line(start.name()))];
    head.extend(used.iter().map(line_of));
    let measured = measured_by(chosen, used, found);
    let uncertainty = uncertainty_of(chosen.machine.uncertainty.as_ref(), fit, unexplained_um(found, used));
    machine_text((start, &chosen.registry.model), errors, (fit, &measured, &uncertainty), &head)
        .map_err(|reason| Error::usage(format!("cannot write into the text of {}: {reason}", start.name())))
}

/// Fits the parameters of a model to the first `used` measurements; with stated terms, from the start model that
/// contains them. `None` if there are errors.
pub(crate) fn with_terms(
    chosen: &Machine,
    start: &Source,
    model: ModelText,
    (all, used): (&[Measurement], usize),
    findings: &mut Diagnostics,
) -> Option<(Vec<Parameter>, Option<StatedStart>)> {
    let Some(terms) = model.terms else { return Some((model.parameters, None)) };
    if !chosen.machine.heads.is_empty() {
        let message = "stated terms are written into a machine file without heads only";
        let help = "fit parameters, such as EX0S or EXX1; or state the term in the machine file, in [[motion]] or [[head.motion]]";
        findings.add(Diagnostic::nowhere(Code::NOT_SUPPORTED, message, help), std::slice::from_ref(&terms));
        return None;
    }
    let sets: Vec<_> = all.iter().take(used).map(|one| one.data.clone()).collect();
    let mut found = Vec::new();
    let file = (start, &chosen.registry.model);
    let of = (&chosen.machine, &chosen.errors);
    let grown = start_with_terms(file, of, (&terms, model.parameters), &sets, &mut found);
    findings.extend(found, std::slice::from_ref(&terms));
    grown.map(|grown| (grown.parameters.clone(), Some(grown)))
}

/// The measured ranges of a machine after a calibration from these measurements.
fn measured_by(machine: &Machine, used: &[Measurement], found: &Found) -> MeasuredRanges {
    let sets: Vec<&ncfix_metrology::measure::data::DataSet> = used.iter().map(|one| &one.data).collect();
    let mut ranges = measured_ranges(&machine.machine, sets.iter().copied(), holdout_um(found));
    let left_out = found.left_out.iter().flat_map(|one| &one.parameters);
    let omitted: Vec<String> = found.omitted.iter().chain(left_out).cloned().collect();
    let fitted: Vec<ParameterName> = found.parameters.iter().filter_map(|one| one.name.parse().ok()).collect();
    ranges.not_shown = not_shown(&machine.machine, &machine.errors, &ranges, &sets, (&omitted, &fitted));
    ranges
}

/// The line about a measurement in such a head.
fn line_of(one: &Measurement) -> String {
    let hash = short_hash(one.sources.iter().map(Source::bytes));
    format!("{} {} ({hash})", one.data.kind.name, in_line(one.sources[0].name()))
}

/// A name may have any character; a comment ends with its line.
fn in_line(name: &str) -> String {
    name.replace(char::is_control, " ")
}

/// The parameters of names and presets.
fn chosen(machine: &Machine, names: &[String], found: &mut Diagnostics) -> Result<Vec<Parameter>, Error> {
    let mut all: Vec<Parameter> = Vec::new();
    let mut text = String::new();
    for name in names {
        let Some(preset) = machine.registry.model.presets.find(name) else {
            text += &format!("{name}\n");
            continue;
        };
        let own = (preset.parameters)(&machine.machine).map_err(|reason| {
            Error::usage(format!("preset {name} is not applicable to the machine {}: {reason}", machine.machine.name))
        })?;
        all.extend(own.into_iter().map(Parameter::from));
    }
    if !text.is_empty() || all.is_empty() {
        let source = Source::new(FileId(0), "parameters", text.into_bytes());
        let source = source.map_err(|_| Error::usage("there are too many parameters".into()))?;
        let (named, diagnostics) = parameters::read(&source, &machine.machine, &machine.errors);
        found.extend(diagnostics, std::slice::from_ref(&source));
        if named.terms.is_some() {
            let terms: Vec<&str> =
                names.iter().map(String::as_str).filter(|name| parameters::states_term(name)).collect();
            return Err(Error::usage(format!(
                "'{}' is neither a preset nor a parameter; a stated term needs the text of the machine file: test it with DiagnosisOptions::hypotheses, or fit it with ncfix calibrate --model",
                terms.join("', '")
            )));
        }
        all.extend(named.parameters.into_iter().filter(|one| !all.contains(one)).collect::<Vec<_>>());
    }
    Ok(all)
}
