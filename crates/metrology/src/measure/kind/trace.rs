//! Traces: displacement of the tool from the workpiece while the machine moves, at samples of the encoders.
//!
//! [`crate::measure::trace`] reads the table of a trace, because set-points, encoders and readings have delays. Its result, on a common clock, is a
//! displacement at the encoder positions, with their accelerations. Every run is a separate set-up with an unknown offset: the machine drifts from
//! run to run.

use super::{Instrument, Measurand, displacement, no_ties, zeros};
use crate::measure::data::Free;

/// The kind.
pub(super) const KIND: Instrument = Instrument {
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
