//! Traces: recordings of a control and an instrument during motion, run by run.
//!
//! A trace is a table NAME.csv (or a Sinumerik trace file, [`xml`]) with a description NAME.toml of `kind = "trace"`. Columns:
//!
//! | column | meaning |
//! | --- | --- |
//! | `t_s` | time, increasing within a run |
//! | `X` …, `A` … | set-points of the control, mm, deg |
//! | `X_enc` … | positions by the encoders, mm, deg |
//! | `dx_um dy_um dz_um` | displacement of the tool from the table ball, or from its nominal point of the workpiece; along F's directions |
//! | `block` | number of the block, a row of the control each; may be missing |
//! | `run`, `feed_mm_min` | label and programmed feed of a run |
//! | `tool_x_mm` … | vector from the spindle gauge point to the tip |
//!
//! The control and the instrument have separate clocks and rates: a row may have the cells of only one of them. Recordings are not shifted, smoothed
//! or resampled here; [`crate::decompose`] determines the delays.

mod description;
mod table;
pub mod xml;

pub use description::{Described, describe};
pub use table::read;

use ncfix_base::diagnostic::Place;
use ncfix_base::geometry::{AxisVector, Vector};

/// A trace.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// The name of its files without extension.
    pub name: String,
    /// Standard uncertainty of one reading, mm; `None` if it is to be estimated.
    pub sigma_mm: Option<f64>,
    /// The center of the ball in the workpiece frame, mm, if readings are relative to a ball; otherwise they are relative to the point that nominally
    /// coincides with the tool.
    pub ball_mm: Option<Vector>,
    /// Unknowns of the set-up.
    pub free: Vec<TraceUnknown>,
    /// Its runs in the order of their start.
    pub runs: Vec<TraceRun>,
}

/// Possible unknowns of the set-up of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceUnknown {
    /// The readings are shifted along F's directions: the zero of the instrument, the tool vector.
    Offset,
    /// The position of the ball in the workpiece.
    Place,
}

/// Unknowns by their words in `free`.
pub const UNKNOWNS: &[(&str, TraceUnknown)] = &[("offset", TraceUnknown::Offset), ("place", TraceUnknown::Place)];

/// One run over a path.
#[derive(Clone, Debug, Default)]
pub struct TraceRun {
    /// Its label; empty without the column `run`.
    pub label: String,
    /// Programmed feed, mm/min.
    pub feed_mm_min: Option<f64>,
    /// Vector from the spindle gauge point to the tip, mm.
    pub tool_mm: Vector,
    /// Samples of the control.
    pub control: ControlSamples,
    /// Samples of the instrument.
    pub readings: Deviations,
    /// Times at which the control began another block, by its clock, s; empty without the column `block`.
    pub transitions_s: Vec<f64>,
    /// Its first row.
    pub place: Option<Place>,
}

/// Set-points and encoders of a run, by sample; mm and rad, s.
#[derive(Clone, Debug, Default)]
pub struct ControlSamples {
    /// Time by the clock of the control, s.
    pub t_s: Vec<f64>,
    /// Set-points of the axes.
    pub set: Vec<AxisVector>,
    /// Encoder positions of the axes.
    pub encoder: Vec<AxisVector>,
}

/// Readings of a run, by sample.
#[derive(Clone, Debug, Default)]
pub struct Deviations {
    /// Time by the clock of the instrument, s.
    pub t_s: Vec<f64>,
    /// Displacement of the tool from the ball, along F's directions, mm.
    pub along: Vec<[f64; 3]>,
    /// Their rows; empty if they come from no table.
    pub places: Vec<Place>,
}

impl Deviations {
    /// The row of the reading at a time, or of the next one.
    #[must_use]
    pub fn place_at(&self, t_s: f64) -> Option<Place> {
        let number = self.t_s.partition_point(|&time| time < t_s);
        self.places.get(number).or(self.places.last()).copied()
    }
}

impl Trace {
    /// `true` if an instrument measured; otherwise only the servo loops can be evaluated.
    #[must_use]
    pub fn has_readings(&self) -> bool {
        self.runs.iter().any(|run| !run.readings.t_s.is_empty())
    }
}
