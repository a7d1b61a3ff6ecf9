//! Selection of the temperature sensors that explain the drift of a machine, from the texts of runs.

use serde::Serialize;

use super::has_errors;
use crate::calibrate::sensors::data::{self, SensorRun};
use crate::calibrate::sensors::{SelectionOptions, SensorSelection, SubsetSize, select, text};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::Source;
use ncfix_machine::machine::condition::log;
use ncfix_machine::machine::{Condition, Machine};

/// The selections.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorsResult {
    /// Selections by direction and place.
    pub selections: Vec<SensorChoice>,
    /// Independent runs; `null` if the last third of every run was held out instead.
    pub independent: Option<Vec<String>>,
}

/// A direction of the foundation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub enum DriftDirection {
    X,
    Y,
    #[default]
    Z,
}

impl DriftDirection {
    /// Its letter.
    #[must_use]
    pub fn letter(self) -> &'static str {
        match self {
            DriftDirection::X => "X",
            DriftDirection::Y => "Y",
            DriftDirection::Z => "Z",
        }
    }
}

/// Selection for one direction at one place.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorChoice {
    /// The direction in which it drifts.
    pub direction: DriftDirection,
    /// Axis and position; `null` if there is only one place.
    pub place: Option<String>,
    /// Number of training readings.
    pub readings: usize,
    /// Drift on the independent readings (RMS).
    pub drift_um: f64,
    /// Residual of the selected model on them.
    pub left_um: Option<f64>,
    /// Selected number of sensors; `null` if none predicts the independent readings.
    pub chosen: Option<usize>,
    /// Best sensors for each number.
    pub sizes: Vec<SensorSubset>,
}

/// Best sensors for one number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorSubset {
    /// Names.
    pub sensors: Vec<String>,
    /// Coefficients.
    #[serde(rename = "um_per_K")]
    pub um_per_k: Vec<f64>,
    /// Time constants.
    pub lag_s: Vec<f64>,
    /// Mallows' Cp.
    pub cp: Option<f64>,
    /// Efficiency on the training readings, 1 if everything is explained.
    pub efficiency: f64,
    /// Efficiency on the independent readings.
    pub independent_efficiency: f64,
    /// True if the search was exhaustive.
    pub is_exact: bool,
}

/// The texts of runs with temperatures and displacements.
#[derive(Clone, Copy, Debug)]
pub struct SensorTexts<'a> {
    /// Training runs.
    pub learned: &'a [Source],
    /// Independent runs.
    pub independent: &'a [Source],
    /// Temperature logs with the same clock, if the runs have none; the last one is used.
    pub logs: &'a [Source],
}

/// The runs, training runs first; `None` if there are errors.
pub fn read(texts: &SensorTexts<'_>, machine: &Machine, findings: &mut Vec<Diagnostic>) -> Option<Vec<SensorRun>> {
    let mut temperatures: Option<Condition> = None;
    for source in texts.logs {
        let (condition, found) = log::load_with_dead(source);
        findings.extend(found);
        temperatures = Some(condition?);
    }
    let mut runs = Vec::new();
    for source in texts.learned.iter().chain(texts.independent) {
        match data::read(source, temperatures.as_ref(), machine) {
            Ok(mut run) => {
                findings.append(&mut run.warnings);
                runs.push(run);
            }
            Err(found) => findings.extend(found),
        }
    }
    (!has_errors(findings)).then_some(runs)
}

/// Selects sensors from runs, the first `learned` of which are training runs. The selections go into `result`. Returns the text of drift entries for a
/// machine file; `None` if there are errors.
pub fn selected(
    mut runs: Vec<SensorRun>,
    learned: usize,
    options: &SelectionOptions,
    machine: &Machine,
    findings: &mut Vec<Diagnostic>,
    result: &mut SensorsResult,
) -> Option<String> {
    let over = match data::over(&runs) {
        Ok(over) => over,
        Err(diagnostic) => {
            findings.push(diagnostic);
            return None;
        }
    };
    let independent = runs.split_off(learned.min(runs.len()));
    result.independent = (!independent.is_empty()).then(|| independent.iter().map(|run| run.name.clone()).collect());
    let places: Vec<_> = match over {
        Some((axis, positions)) => positions.into_iter().map(|at| Some((axis, at))).collect(),
        None => vec![None],
    };
    let mut selections = Vec::new();
    for direction in 0..3 {
        for &at in &places {
            selections.extend(select(&runs, &independent, direction, at, options));
        }
    }
    if selections.is_empty() {
        let message = "there are too few readings for a single sensor, or no sensor changes";
        let help = "record several hours of warming up and cooling down, about one reading per minute";
        findings.push(Diagnostic::nowhere(Code::DATA_NO_TABLE, message, help));
    }
    if has_errors(findings) {
        return None;
    }
    result.selections = selections.iter().map(SensorChoice::from).collect();
    Some(file(&selections, &runs, machine))
}

impl From<&SubsetSize> for SensorSubset {
    fn from(size: &SubsetSize) -> SensorSubset {
        SensorSubset {
            sensors: size.terms.iter().map(|term| term.sensor.clone()).collect(),
            um_per_k: size.terms.iter().map(|term| term.um_per_k).collect(),
            lag_s: size.terms.iter().map(|term| term.lag_s).collect(),
            cp: size.cp,
            efficiency: size.efficiency,
            independent_efficiency: size.independent,
            is_exact: size.is_exact,
        }
    }
}

impl From<&SensorSelection> for SensorChoice {
    fn from(selection: &SensorSelection) -> SensorChoice {
        let directions = [DriftDirection::X, DriftDirection::Y, DriftDirection::Z];
        SensorChoice {
            direction: directions.get(selection.direction).copied().unwrap_or_default(),
            place: selection.at.map(|(axis, at)| format!("{axis}{at}")),
            readings: selection.rows,
            drift_um: selection.drift_um,
            left_um: selection.model().map(|model| model.left_um),
            chosen: selection.model().map(|model| model.terms.len()),
            sizes: selection.sizes.iter().map(SensorSubset::from).collect(),
        }
    }
}

/// The file with drift entries.
fn file(selections: &[SensorSelection], runs: &[SensorRun], machine: &Machine) -> String {
    // A name may contain any character; a comment ends with its line.
    let name = |text: &str| text.replace(char::is_control, " ");
    let names: Vec<String> = runs.iter().map(|run| name(&run.name)).collect();
    format!(
        "# Drift of {} from {}: for the machine file; replaces its [[drift]].\n\n{}",
        name(&machine.name),
        names.join(", "),
        text::entries(selections)
    )
}
