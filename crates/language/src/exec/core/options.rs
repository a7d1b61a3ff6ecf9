//! Options of the execution of a program.

use super::radius::Radius;
use ncfix_base::geometry::AxisVector;

/// Options of the execution.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Skip levels whose blocks are skipped.
    pub skip_levels: [bool; 10],
    /// Number of executed blocks after which the run stops with a diagnostic; `None` for ten million, or twenty times the blocks of the main program
    /// if that is more.
    pub max_blocks: Option<u64>,
    /// Axis commands (mm, rad) at the start, if known.
    pub start: Option<AxisVector>,
    /// Rejects input that a correction must not assume: zero offsets and tools without value, motions from unknown positions.
    pub strict: bool,
    /// Rejects zero offsets and tools without value, as a strict run does; the remainder of `strict` stays permitted.
    pub requires_values: bool,
    /// Reports at the end the places where radius compensation was converted to the tool center path (`W0236`), and milling cycles
    /// with moves of this program (`W0239`).
    pub tells_compensation: bool,
    /// Names values of earlier programs that are read as 0 or null (`W0240`), in a run that is not strict.
    pub tells_assumed: bool,
    /// Radius for G41 and G42.
    pub radius: Radius,
    /// Leaves the words that begin and end radius compensation to the control, for wear alone (`W0237`).
    pub keeps_wear: bool,
    /// Leaves rigid tapping to the control, as its cycle at a corrected place. The output must have the coordinates of the program.
    pub keeps_tapping: bool,
    /// Takes positions within tilted planes of a head (G68.2 with G53.1) as the control does, in the coordinates of the plane. A strict run leaves these planes
    /// to the control: the output must have the coordinates of the program, and the rotary axes their programmed positions.
    pub keeps_tilt: bool,
    /// Marks the holes of drilling cycles in the stream, so that a correction can leave them to the control.
    pub keeps_cycles: bool,
    /// Marks the holes of rigid tapping, which the control executes in any case, also without `keeps_cycles`.
    pub keeps_taps: bool,
    /// Changes comments that a reader of the output would take for the marks of added lines: `;+` becomes `;+ .`.
    pub hides_marks: bool,
    /// Writes a comment before the moves of a milling cycle.
    pub names_cycles: bool,
    /// Curves in the working plane become arcs where these fit, otherwise chords: an output has fewer blocks.
    pub fits_arcs: bool,
    /// Splitting of rapid moves if the control orders its axes.
    pub rapid_order: RapidOrder,
}

/// Rapid moves that an executor splits, as a control does that moves the tool axis first or last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RapidOrder {
    /// All; an unknown start is assumed, unless the run is strict.
    #[default]
    All,
    /// Those whose start the program has stated.
    Stated,
    /// None: in a corrected program they are already split, and their additional motion is only micrometers.
    None,
}
