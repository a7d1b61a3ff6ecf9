//! Measurements against a result, reading by reading and direction by direction: what tables sum up and pictures show.

use ncfix_base::units::Unit;
use serde::Serialize;

/// Readings that count less than this do not fit: a residual of 3.3 standard deviations.
pub const DOES_NOT_FIT: f64 = 0.25;

/// The readings of one direction or component of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Part {
    /// `dx`, `EXX`, `dr`.
    pub name: String,
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
    /// Standard deviation of what the model leaves about its mean; `null` for one reading.
    pub left_sigma: Option<f64>,
    /// Share of the measured sizes that the model explains (Spaan, eq. 3.6).
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub efficiency: f64,
}

/// The readings of a measurement in one unit, one after another; all lists of readings are of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readings {
    /// Labels of the set-ups.
    pub setups: Vec<String>,
    /// The readings in the order of the table.
    pub points: Vec<Point>,
    /// Time and axes that moved: name with unit (`X in mm`), and the value of each reading.
    pub axes: Vec<(String, Vec<f64>)>,
    /// Circles of a ball-bar.
    pub circles: Vec<Circle>,
}

/// A reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Row of the table, from 1.
    pub row: usize,
    /// Number of its [`Part`].
    pub part: usize,
    /// Number of its set-up.
    pub setup: usize,
    /// What a machine without errors leaves.
    pub measured: f64,
    /// What the model leaves.
    pub left: f64,
    /// What it counted, 0 to 1; 1 for readings that were held out.
    pub weight: f64,
}

/// A run of a ball-bar in a plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Circle {
    /// Number of its set-up.
    pub setup: usize,
    /// `XY`, or the azimuth of the plane.
    pub plane: String,
    /// What lies at angle 0, and at 90°.
    pub axes: [String; 2],
    /// Nominal length of the ball-bar, mm.
    pub radius_mm: f64,
    /// Whether it went counterclockwise.
    pub is_counterclockwise: bool,
    /// Number of a point and angle, rad.
    pub angles: Vec<(usize, f64)>,
}
