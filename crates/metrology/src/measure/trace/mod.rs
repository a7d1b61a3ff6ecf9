//! Traces: what a control and an instrument recorded while the machine moved, run by run.
//!
//! A trace is a table NAME.csv (or what a Sinumerik writes, [`xml`]) with a description NAME.toml of `kind = "trace"`. Columns:
//!
//! | column | meaning |
//! | --- | --- |
//! | `t_s` | time, increasing within a run |
//! | `X` …, `A` … | set-points of the control, mm, deg |
//! | `X_enc` … | positions by the encoders, mm, deg |
//! | `dx_um dy_um dz_um` | the tool from the ball on the table, or from the point of the workpiece that it should be at; along F's directions |
//! | `run`, `feed_mm_min` | label and programmed feed of a run |
//! | `tool_x_mm` … | from the spindle gauge point to the tip |
//!
//! The control and the instrument have clocks and rates of their own: a row may have the cells of one of them only. What is recorded is not
//! shifted, smoothed or resampled here; [`crate::decompose`] finds the delays.

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
    /// The name of its files without ending.
    pub name: String,
    /// Standard uncertainty of one reading, mm; `None` where it is to be estimated.
    pub sigma_mm: Option<f64>,
    /// The centre of the ball in the workpiece frame, mm, where readings are the tool from a ball; without it they are the tool from the point
    /// that nominally coincides with it.
    pub ball_mm: Option<Vector>,
    /// What is unknown of the set-up.
    pub free: Vec<TraceUnknown>,
    /// Its runs in the order in which they begin.
    pub runs: Vec<TraceRun>,
}

/// What may be unknown of the set-up of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceUnknown {
    /// The readings are shifted along F's directions: the zero of the instrument, the tool vector.
    Offset,
    /// The ball lies elsewhere in the workpiece.
    Place,
}

/// Unknowns by their words in `free`.
pub const UNKNOWNS: &[(&str, TraceUnknown)] = &[("offset", TraceUnknown::Offset), ("place", TraceUnknown::Place)];

/// One run over a path.
#[derive(Clone, Debug, Default)]
pub struct TraceRun {
    /// Its label; empty where there is no column `run`.
    pub label: String,
    /// Programmed feed, mm/min.
    pub feed_mm_min: Option<f64>,
    /// From the spindle gauge point to the tip, mm.
    pub tool_mm: Vector,
    /// What the control recorded.
    pub control: ControlSamples,
    /// What the instrument recorded.
    pub readings: Deviations,
    /// Its first row.
    pub place: Option<Place>,
}

/// Set-points and encoders of a run, by sample; mm and rad, s.
#[derive(Clone, Debug, Default)]
pub struct ControlSamples {
    /// When, by the clock of the control.
    pub t_s: Vec<f64>,
    /// Where the axes should be.
    pub set: Vec<AxisVector>,
    /// Where they are by their encoders.
    pub encoder: Vec<AxisVector>,
}

/// Readings of a run, by sample.
#[derive(Clone, Debug, Default)]
pub struct Deviations {
    /// When, by the clock of the instrument, s.
    pub t_s: Vec<f64>,
    /// The tool from the ball, along F's directions, mm.
    pub along: Vec<[f64; 3]>,
    /// Their rows; empty where they come from no table.
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
    /// Whether an instrument measured: else only the servo loops can be looked at.
    #[must_use]
    pub fn has_readings(&self) -> bool {
        self.runs.iter().any(|run| !run.readings.t_s.is_empty())
    }
}
