//! Comparison of measurements with a result, reading by reading and direction by direction, for tables and pictures.

use ncfix_base::units::Unit;
use serde::Serialize;

/// Weight below which readings do not fit: a residual of 3.3 standard deviations.
pub const DOES_NOT_FIT: f64 = 0.25;

/// The readings of one direction or component of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeasurementPart {
    /// `dx`, `EXX`, `dr`.
    pub name: String,
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
    /// Standard deviation of the residuals about their mean; `null` for one reading.
    pub left_sigma: Option<f64>,
    /// Share of the measured sizes that the model explains (Spaan, eq. 3.6).
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub efficiency: f64,
}

/// The readings of a measurement in one unit; all lists of readings have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadingSeries {
    /// Labels of the set-ups.
    pub setups: Vec<String>,
    /// The readings in the order of the table.
    pub points: Vec<ReadingPoint>,
    /// Time and moving axes: name with unit (`X in mm`), and the value for each reading.
    pub axes: Vec<(String, Vec<f64>)>,
    /// Circles of a ball-bar.
    pub circles: Vec<Circle>,
}

/// A reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadingPoint {
    /// Row of the table, from 1.
    pub row: usize,
    /// Index of its [`MeasurementPart`].
    pub part: usize,
    /// Index of its set-up.
    pub setup: usize,
    /// Residual of an error-free machine.
    pub measured: f64,
    /// Residual of the model.
    pub left: f64,
    /// Its weight, 0 to 1; 1 for held-out readings.
    pub weight: f64,
}

/// A run of a ball-bar in a plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Circle {
    /// Index of its set-up.
    pub setup: usize,
    /// `XY`, or the azimuth of the plane.
    pub plane: String,
    /// The directions at angle 0 and at 90°.
    pub axes: [String; 2],
    /// Nominal length of the ball-bar, mm.
    pub radius_mm: f64,
    /// True if it is counterclockwise.
    pub is_counterclockwise: bool,
    /// Index of a point and its angle, rad.
    pub angles: Vec<(usize, f64)>,
}
