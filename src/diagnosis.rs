//! Diagnosis: errors that the error model of a machine lacks, and their causes.

use crate::data::{DataSet, measurements};
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::source::{FileId, Source};
use ncfix_metrology::results::diagnosis::{self, CauseReport, DiagnosisResult as Found, DiagnosisSettings};
use ncfix_metrology::results::extended::Extended;
use ncfix_metrology::results::hypotheses::{self, HypothesisReport};
use ncfix_metrology::results::measurement::Purpose;
use ncfix_metrology::results::readings::ShownReadings;

/// Options of a diagnosis.
///
/// ```
/// use ncfix::prelude::*;
///
/// let mut options = DiagnosisOptions::default();
/// options.machine_text = Some(std::fs::read_to_string("samples/machines/demo.toml").unwrap());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DiagnosisOptions {
    /// The text of the machine file. The result has a copy of it with the causes found. A cause that a machine file cannot hold is not reported as
    /// correctable. `None`: no such copy is made.
    pub machine_text: Option<String>,
    /// Hypotheses to test in addition to the search, such as `EXX ~ Y^2` or `backlash EXX`; `docs/reference/terms.md`
    /// describes the grammar.
    pub hypotheses: Vec<String>,
}

/// The causes that the error model of a machine lacks, in the order of their gain on left-out readings, each with its evidence, its gain on
/// held-out readings, and whether it can be corrected; and the residual.
///
/// ```
/// use ncfix::prelude::*;
///
/// let data = [DataSet::read("samples/measurements/laser.csv")?];
/// let found = Diagnosis::run(&Machine::demo(), &data, &DiagnosisOptions::default())?;
/// for cause in found.causes() {
///     println!("{} {}: {:.1} ± {:.1} {}", cause.effect, cause.parameter, cause.value, cause.u95, cause.unit);
/// }
/// // The data were simulated with a backlash of 5 µm in X, which the machine file lacks.
/// assert!(found.causes().iter().any(|one| one.effect == "backlash" && one.parameter == "EXX"));
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Diagnosis {
    found: Found,
    extended: Option<Extended>,
    diagnostics: Diagnostics,
}

impl Diagnosis {
    /// Checks the data for faults and searches for causes of the residual errors, including causes from the
    /// [registry](crate::Registry) of the machine. Data that are [held out](DataSet::held_out) only evaluate the
    /// result.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let few = DataSet::parse("few", "component,X,Y,Z,value_um\nEXX,0,0,0,0\nEXX,350,0,0,8\n", "[measurement]\nkind = \"direct\"\n")?;
    /// let error = Diagnosis::run(&Machine::demo(), &[few], &DiagnosisOptions::default()).unwrap_err();
    /// assert!(error.to_string().contains("readings"), "{error}");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If data are invalid or not informative: the diagnostics state the reason, and what to measure.
    pub fn run(machine: &Machine, data: &[DataSet], options: &DiagnosisOptions) -> Result<Diagnosis, Error> {
        machine.check_one_head()?;
        let mut diagnostics = Diagnostics::default();
        let how = (Purpose::Diagnosis(&machine.errors), &machine.registry.instruments);
        let read = measurements(data, machine, how, &mut diagnostics);
        let Some((all, used, sources)) = read else { return Err(Error::found(diagnostics)) };
        let text = options.machine_text.as_ref();
        let file = text.map(|text| Source::new(FileId(0), "machine file", text.as_bytes().to_vec()));
        let file = file.transpose().map_err(|_| Error::usage("the machine file is too long".into()))?;
        let stated = hypotheses::source(&options.hypotheses);
        let sources: Vec<Source> = sources.into_iter().chain(stated.clone()).collect();
        let settings = DiagnosisSettings {
            hypotheses: stated.as_ref(),
            causes: Some(&machine.registry.causes),
            checks: Some(&machine.registry.checks),
            model: Some(&machine.registry.model),
            file: file.as_ref(),
            ..DiagnosisSettings::default()
        };
        let (mut found, mut own) = (Found::default(), Vec::new());
        let extended = diagnosis::run(
            (&machine.machine, &machine.errors),
            all,
            used,
            settings,
            &mut |_, _| {},
            &mut own,
            (&mut found, &mut ShownReadings::default()),
        );
        diagnostics.extend(own, &sources);
        extended
            .map(|extended| Diagnosis { found, extended, diagnostics: diagnostics.clone() })
            .ok_or_else(|| Error::found(diagnostics))
    }

    /// The accepted causes, in the order of their gain on left-out readings: each with its value and expanded uncertainty (95 %), its share of the
    /// residual, its gain on held-out readings, its p-value, other explanations, and whether a corrected program
    /// removes it.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = [DataSet::read("samples/measurements/laser.csv")?];
    /// let found = Diagnosis::run(&Machine::demo(), &data, &DiagnosisOptions::default())?;
    /// let first = &found.causes()[0];
    /// assert!(first.gain_holdout > 0.0 && first.p < 0.01 && first.correctable == Correctable::Program);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn causes(&self) -> &[CauseReport] {
        &self.found.findings
    }

    /// The results for the stated hypotheses, in their order: amounts, evidence, gain on left-out readings, other
    /// explanations.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let mut options = DiagnosisOptions::default();
    /// options.hypotheses = vec!["EXX ~ dir(X)".to_owned()];
    /// let data = [DataSet::read("samples/measurements/laser.csv")?];
    /// let found = Diagnosis::run(&Machine::demo(), &data, &options)?;
    /// // The data were simulated with a backlash of 5 µm in X, which the machine file lacks.
    /// let one = &found.hypotheses()[0];
    /// assert!(one.log_evidence_beside.is_some_and(|evidence| evidence > 3.0));
    /// assert!((one.amounts[0].value - 5.0).abs() < 2.0 * one.amounts[0].u95);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn hypotheses(&self) -> &[HypothesisReport] {
        &self.found.hypotheses
    }

    /// The complete result: noise, sizes before and after, causes, faults of the data, rejected candidates, the
    /// unexplained residual. `--json` prints it.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = [DataSet::read("samples/measurements/laser.csv")?];
    /// let found = Diagnosis::run(&Machine::demo(), &data, &DiagnosisOptions::default())?;
    /// assert!(found.result().after.rms_um < found.result().before.rms_um);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn result(&self) -> &Found {
        &self.found
    }

    /// Warnings about the data.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = [DataSet::read("samples/measurements/laser.csv")?];
    /// let found = Diagnosis::run(&Machine::demo(), &data, &DiagnosisOptions::default())?;
    /// assert!(!found.diagnostics().has_errors());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// The text of the machine file with the causes that it can hold, all parameters fitted together again; comments
    /// stay.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let mut options = DiagnosisOptions::default();
    /// options.machine_text = Some(std::fs::read_to_string("samples/machines/demo.toml").unwrap());
    /// let data = [DataSet::read("samples/measurements/laser.csv")?];
    /// let text = Diagnosis::run(&Machine::demo(), &data, &options)?.extended_machine_text()?;
    /// assert!(text.contains("kind = \"backlash\"") && Machine::from_text("new.toml", &text).is_ok());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the options had no machine file, or it cannot hold anything that was found.
    pub fn extended_machine_text(&self) -> Result<String, Error> {
        let Some(extended) = &self.extended else {
            return Err(Error::usage("there is no machine file to extend; give its text in the options".into()));
        };
        extended.text.clone().map_err(|(message, help)| Error::usage(format!("{message}; {help}")))
    }
}
