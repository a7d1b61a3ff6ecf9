//! Where the program and the machine stand between two pieces: what the next piece begins with.

use ncfix_base::geometry::{AXIS_COUNT, AxisSet, AxisVector};
use ncfix_machine::machine::State;
use ncfix_model::DeadBand;

/// Where program and machine stand between two pieces.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathState {
    /// Command of the program.
    pub(super) nominal: AxisVector,
    /// Command of the emitted program.
    pub(super) command: AxisVector,
    /// What was written last, and for which axes this is the place where they stand.
    pub(super) counts: [i64; AXIS_COUNT],
    pub(super) written: AxisSet,
    /// Axes whose place is known.
    pub(super) known: AxisSet,
    /// Axes of the machine whose place was known when the move began: in which sense the others move is not.
    pub(super) sensed: AxisSet,
    /// Sense of motion of the emitted commands, as far as it is known.
    pub(super) state: State,
    /// Where the axes are within their dead bands, by the emitted commands and by those of the program.
    pub(super) band: DeadBand,
    pub(super) nominal_band: DeadBand,
    /// Last correction, as a guess for the next.
    pub(super) correction: AxisVector,
    /// The machine may stand off the corrected path: an uncorrected move, another tool.
    pub(super) is_doubtful: bool,
}
