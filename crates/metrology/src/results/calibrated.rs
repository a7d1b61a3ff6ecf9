//! What a calibration found: parameters, unknowns of the set-ups, and each measurement against the result.

use serde::Serialize;

use super::compared::{Part, Readings};
use super::figures;
use super::not_told::LeftOut;
use super::selection::Selection;
use ncfix_base::units::Unit;

/// What was found of a machine. Uncertainties are standard uncertainties.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibrationResult {
    /// Parameters of the machine.
    pub parameters: Vec<Estimate>,
    /// What was unknown of the set-ups.
    pub unknowns: Vec<Estimate>,
    /// Parameters of the model that were left out because the data cannot tell them.
    pub left_out: Vec<LeftOut>,
    /// Measurements.
    pub data: Vec<Data>,
    /// Figures of ISO 230 of the measurements, which do not depend on the model.
    pub figures: Vec<figures::Measurement>,
    /// Rows that count for less because they do not fit.
    pub weighted_down: Vec<Row>,
    /// Largest by smallest singular value of the equations; `null` without a result.
    pub condition: Option<f64>,
    /// Equations less unknowns.
    pub degrees_of_freedom: usize,
    /// Rounds of Gauss–Newton.
    pub rounds: usize,
    /// The preset or file of parameters.
    pub model: String,
    /// Name of the machine.
    pub machine: String,
    /// How parameters were chosen, where they were.
    pub selection: Option<Selection>,
}

/// A number that was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its uncertainty.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub sigma: f64,
    /// The scatter of simulated repetitions, where they were asked for.
    pub sigma_monte_carlo: Option<f64>,
    /// The unit of these: `µm`, `µrad/m`.
    pub unit: String,
    /// Its value in the machine file that the calibration began with; 0 for set-ups.
    pub start: f64,
    /// How far it moves the tip, root of the mean square over the readings; `null` for set-ups.
    pub effect_um: Option<f64>,
    /// How much its variance grows because the others are unknown too.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub inflation: f64,
}

/// A measurement against the result.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Data {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Whether it was held out of the fit.
    pub is_held_out: bool,
    /// Readings.
    pub readings: usize,
    /// The unit of all sizes.
    pub unit: Unit,
    /// Root of the mean square of what a machine without errors leaves.
    pub measured_rms: f64,
    /// The largest of it.
    pub measured_max: f64,
    /// Root of the mean square of what the model leaves.
    pub left_rms: f64,
    /// The largest of it.
    pub left_max: f64,
    /// Standard uncertainty of a reading, described or estimated; `null` where neither is.
    pub sigma: Option<f64>,
    /// Share of the measured sizes that the model explains (Spaan, eq. 3.6).
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub efficiency: f64,
    /// By direction or component.
    pub parts: Vec<Part>,
    /// Sums of the measured sizes and of those that are left, for the efficiency of several measurements together.
    #[serde(skip)]
    pub sums: [f64; 2],
    /// The readings themselves; empty where nobody asks for pictures.
    #[serde(skip)]
    pub shown: Readings,
}

/// A row that does not fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Row {
    /// Its file.
    pub file: String,
    /// Its line, from 1.
    pub line: usize,
    /// What is left of it.
    pub residual: f64,
    /// The unit of it.
    pub unit: Unit,
    /// What it counts, 0 to 1.
    pub weight: f64,
}

impl CalibrationResult {
    /// The efficiency of all measurements in a unit together, those held out or those used; `None` where there are none.
    #[must_use]
    pub fn efficiency(&self, is_held_out: bool, unit: Unit) -> Option<f64> {
        let own = self.data.iter().filter(|one| one.is_held_out == is_held_out && one.unit == unit);
        let [measured, left] =
            own.fold([0.0, 0.0], |[measured, left], one| [measured + one.sums[0], left + one.sums[1]]);
        (measured > 0.0).then(|| 1.0 - left / measured)
    }
}
