//! Results of a calibration: parameters, unknowns of the set-ups, and the comparison with each measurement.

use serde::Serialize;

use super::compared::{MeasurementPart, ReadingSeries};
use super::figures;
use super::not_identified::LeftOut;
use super::selection::Selection;
use super::stated::StatedEstimate;
use ncfix_base::units::Unit;

/// Calibration of a machine. Uncertainties are standard uncertainties.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibrationResult {
    /// Parameters of the machine.
    pub parameters: Vec<EstimateReport>,
    /// Stated terms that the machine file holds as tables, with their amounts; other stated terms are among the parameters.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<StatedEstimate>,
    /// Squareness errors that the readings show and the stated model lacks.
    #[serde(skip)]
    pub omitted: Vec<String>,
    /// Slopes that give axes the direction of their mean lines, because no reading fixes it; they are among the parameters.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mean_lines: Vec<MeanLineReport>,
    /// Unknowns of the set-ups.
    pub unknowns: Vec<EstimateReport>,
    /// Parameters of the model that were left out because the data do not determine them.
    pub left_out: Vec<LeftOut>,
    /// Measurements.
    pub data: Vec<Data>,
    /// Figures of ISO 230 of the measurements, independent of the model.
    pub figures: Vec<figures::MeasurementFigures>,
    /// Rows with a reduced weight because they do not fit.
    pub weighted_down: Vec<OutlierRow>,
    /// Condition number of the equations, largest to smallest singular value; `null` without a result.
    pub condition: Option<f64>,
    /// Equations minus unknowns.
    pub degrees_of_freedom: usize,
    /// Number of Gauss–Newton iterations.
    pub rounds: usize,
    /// The preset or file of parameters.
    pub model: String,
    /// Name of the machine.
    pub machine: String,
    /// Selection of the parameters, if any.
    pub selection: Option<Selection>,
}

/// The mean line of a straightness, which has the direction of its axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MeanLineReport {
    /// Its slope at the zero of the axis: `EYX1`.
    pub slope: String,
    /// Lower end of the range in which the readings show the straightness.
    pub from_mm: f64,
    /// Upper end of the range.
    pub to_mm: f64,
    /// Standard uncertainty of the direction, because the travel is longer than the range.
    pub turn_urad: f64,
}

/// An estimated number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct EstimateReport {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its uncertainty.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub sigma: f64,
    /// The scatter of simulated repetitions, if requested.
    pub sigma_monte_carlo: Option<f64>,
    /// The unit of value and uncertainty: `µm`, `µrad/m`.
    pub unit: String,
    /// Its value in the initial machine file; 0 for set-ups.
    pub start: f64,
    /// Tip motion due to it, RMS over the readings; `null` for set-ups.
    pub effect_um: Option<f64>,
    /// Variance inflation factor due to the other unknowns.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub inflation: f64,
}

/// Comparison of a measurement with the result.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Data {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// True if it was held out of the fit.
    pub is_held_out: bool,
    /// Number of readings.
    pub readings: usize,
    /// The unit of all sizes.
    pub unit: Unit,
    /// RMS of the measured values, i.e. the residuals of an error-free machine.
    pub measured_rms: f64,
    /// The largest measured value.
    pub measured_max: f64,
    /// RMS residual of the model.
    pub left_rms: f64,
    /// The largest residual.
    pub left_max: f64,
    /// Standard uncertainty of a reading, described or estimated; `null` if neither is known.
    pub sigma: Option<f64>,
    /// Share of the measured sizes that the model explains (Spaan, eq. 3.6).
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub efficiency: f64,
    /// Residuals without the readings of weight 0, which all other sizes include; `null` if there are no such readings.
    pub kept: Option<KeptReadings>,
    /// By direction or component.
    pub parts: Vec<MeasurementPart>,
    /// Scatter of readings that were repeated at the same pose, by direction or component; empty without any.
    pub repeated: Vec<RepeatedReadings>,
    /// Sums of the magnitudes of measured values and of residuals, for the efficiency of several measurements together.
    #[serde(skip)]
    pub sums: [f64; 2],
    /// The readings themselves; empty if no pictures are requested.
    #[serde(skip)]
    pub shown: ReadingSeries,
}

/// Scatter of repeated readings, pooled over all poses.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RepeatedReadings {
    /// Direction or component.
    pub name: String,
    /// Pooled standard deviation, in the unit of the measurement.
    pub sigma: f64,
    /// Number of readings beyond the first of each pose.
    pub repetitions: usize,
    /// True if the readings change slowly from one to the next, so that most of the scatter is a drift and not the noise of the instrument.
    pub has_drift: bool,
}

/// Readings that the fit used: those whose weight is not 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KeptReadings {
    /// Number of the readings of weight 0.
    pub rejected: usize,
    /// RMS residual of the other readings.
    pub left_rms: f64,
    /// The largest residual of the other readings.
    pub left_max: f64,
}

/// A row that does not fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OutlierRow {
    /// Its file.
    pub file: String,
    /// Its line, from 1.
    pub line: usize,
    /// Its residual.
    pub residual: f64,
    /// The unit of the residual.
    pub unit: Unit,
    /// Its weight, 0 to 1.
    pub weight: f64,
    /// True if the direction of approach of its axis is not known.
    #[serde(skip)]
    pub is_without_direction: bool,
}

impl CalibrationResult {
    /// The efficiency of all measurements in a unit together, held out or used; `None` without such measurements.
    #[must_use]
    pub fn efficiency(&self, is_held_out: bool, unit: Unit) -> Option<f64> {
        let own = self.data.iter().filter(|one| one.is_held_out == is_held_out && one.unit == unit);
        let [measured, left] =
            own.fold([0.0, 0.0], |[measured, left], one| [measured + one.sums[0], left + one.sums[1]]);
        (measured > 0.0).then(|| 1.0 - left / measured)
    }
}
