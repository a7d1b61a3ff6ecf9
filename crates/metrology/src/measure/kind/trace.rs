//! Traces: the tool from the workpiece while the machine moves, at samples of the encoders.
//!
//! The table of a trace is read by [`crate::measure::trace`], because set-points, encoders and readings have delays; what comes out of it, brought to one
//! clock, is a displacement at the positions that the encoders say, with the accelerations there. Every run is a set-up of its own, whose offset is
//! unknown: the machine drifts from run to run.

use super::{Kind, Measurand, displacement, no_ties, zeros};
use crate::measure::data::Free;

/// The kind.
pub(super) const KIND: Kind = Kind {
    name: "trace",
    title: "displacement of the tool from the workpiece while the machine moves",
    measurand: Measurand::MovingDisplacement,
    free: &[Free::Offset],
    read: displacement::read,
    check: displacement::check,
    unknowns: displacement::unknowns,
    start: zeros,
    equations: displacement::equations,
    ties: no_ties,
    temperature: None,
    columns: &displacement::COLUMNS,
};
