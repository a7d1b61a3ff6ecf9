//! The state of program and machine between two pieces, from which the next piece begins.

use ncfix_base::geometry::{AXIS_COUNT, AxisSet, AxisVector};
use ncfix_machine::machine::State;
use ncfix_model::DeadBand;

/// The state of program and machine between two pieces.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathState {
    /// Command of the program.
    pub(super) nominal: AxisVector,
    /// Command of the emitted program.
    pub(super) command: AxisVector,
    /// Last written counts, and the axes for which they are the current position.
    pub(super) counts: [i64; AXIS_COUNT],
    pub(super) written: AxisSet,
    /// Axes at a known position.
    pub(super) known: AxisSet,
    /// Machine axes whose position was known when the move began; the direction of other axes is unknown.
    pub(super) sensed: AxisSet,
    /// Direction of motion of the emitted commands, as far as known.
    pub(super) state: State,
    /// Positions of the axes in their dead bands, by the emitted commands and by those of the program.
    pub(super) band: DeadBand,
    pub(super) nominal_band: DeadBand,
    /// Last correction, as a guess for the next.
    pub(super) correction: AxisVector,
    /// `true` if the machine may be off the corrected path: after an uncorrected move or a tool change.
    pub(super) is_doubtful: bool,
}
