//! From the flat stream to corrected pieces: subdivision, correction, arc fitting, and the residual error along the path.
//!
//! [`Corrector`] adapts an iterator of elements lazily: it holds one move at a time. Every emitted position is a whole number of the control's
//! increments, rounded from an absolute position, so nothing accumulates. Everything after the rounding (deviation, direction of motion, prediction,
//! the start of the next piece) uses the rounded commands.
//!
//! One forward function evaluates every piece. Its deviation is the distance of the tool tip at the emitted command, with all errors, from the
//! nominal tip at the same parameter of the programmed move.

mod ahead;
mod arc_fit;
mod check;
mod compare;

mod corrector;
mod cut;
mod cycle_block;
mod extend;
mod findings;
mod held;
mod increment;
mod interval;
mod lead;
mod live;
mod moves;
mod place;
mod poses;
mod prediction;
mod reach;
mod remaining;
mod repeated_blocks;
mod rotary_word;
mod route;
mod sampling;
mod segment_candidate;
mod side_plan;
mod sides;
mod singularity;
mod slope;
mod space_arc;
mod standing;
mod staying;
mod steps;
mod tip_divider;
mod tips;
mod treatment;
mod turn;
mod volume;
mod way;

pub use compare::{
    ActSubject, CONTINUES, CONTINUES_ON_THE_SPOT, Comparison, Course, Divergence, Follow, Grouping, How, ON_THE_SPOT,
    ProgramDifference, Promise, What, compare, compare_seeing,
};
pub use corrector::Corrector;
pub use cycle_block::CycleBlock;
pub use increment::Increments;
pub use interval::{ErrorInterval, PredictedInterval, StationInterval, predict, predict_from};
pub use live::{Allows, Applied, Asked, Doses, Live};
pub use moves::Moves;
pub use poses::{ErrorPlace, PoseSample};
pub use prediction::{Prediction, ShortBlocks, Spread};
pub use reach::ReachScan;
pub use remaining::{Remaining, remaining};
pub use repeated_blocks::RepeatedBlocks;
pub use steps::{ResidualSteps, SeriesRow, StepResidual, StepTrial, Steps, StraightLine};
pub use tips::Tips;
pub use volume::volume;

use ncfix_base::geometry::{AXIS_COUNT, AxisSet, AxisVector, Plane};
use ncfix_machine::machine::{Machine, ToolChange};
use ncfix_machine::snc::{BlockNumber, Element, FeedUnit, Kind, MotionMode, Origin, RotaryDirection, Word, WordValue};

/// Largest deviation of a hole that stays a drilling cycle, mm: a third of the finest grade of bores (IT5 of 6 to 10 mm is 6 µm, ISO 286-1). A tool that
/// drills keeps the line on which it enters, so that a correction along the hole has less effect than one of its place.
pub const HOLE_TOLERANCE_MM: f64 = 2e-3;

/// Options of a correction.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrectionOptions {
    /// Largest deviation of an emitted piece from the exactly corrected path, mm.
    pub tolerance_mm: f64,
    /// Largest deviation of a hole that stays a drilling cycle, mm; a value below [`Self::tolerance_mm`] has no effect.
    pub hole_tolerance_mm: f64,
    /// Subdivision of moves into pieces.
    pub subdivision: Subdivision,
    /// Treatment of arcs.
    pub arcs: Arcs,
    /// Largest turn of one block around a circle.
    pub turns: Turns,
    /// Coordinates of arc centers in the control.
    pub centers: Centers,
    /// The path to which the control's feed refers.
    pub feeds: Feeds,
    /// Treatment of rapid moves.
    pub rapids: Rapids,
    /// Frame of the emitted coordinates.
    pub frame: OutputFrame,
    /// Treatment of five-axis transformations.
    pub five_axis: FiveAxis,
    /// `true` if the output language has circles through an intermediate point in any plane.
    pub has_spatial_arcs: bool,
    /// `false` if the output language has no five-axis transformation: its paths of the tip become axis positions.
    pub has_transformation: bool,
    /// Largest accepted correction, mm; rotary axes count by the arc at the tool tip.
    pub max_correction_mm: f64,
    /// Participation of rotary axes in the correction.
    pub rotary: Rotary,
    /// Programmed position before the first block (mm, rad), if the program relies on one.
    pub start: Option<AxisVector>,
}

impl CorrectionOptions {
    /// `true` if the output keeps a five-axis transformation of the program.
    pub(crate) fn keeps_transform(&self) -> bool {
        self.has_transformation && self.five_axis == FiveAxis::Tcp
    }

    /// `true` if holes may stay drilling cycles.
    #[must_use]
    pub fn may_keep_cycles(&self) -> bool {
        (self.frame, self.five_axis, self.subdivision) == (OutputFrame::Work, FiveAxis::Tcp, Subdivision::Adaptive)
            && self.rapids != Rapids::None
    }
}

impl Default for CorrectionOptions {
    fn default() -> Self {
        CorrectionOptions {
            tolerance_mm: 1e-3,
            hole_tolerance_mm: HOLE_TOLERANCE_MM,
            subdivision: Subdivision::Adaptive,
            arcs: Arcs::Keep,
            turns: Turns::Several,
            centers: Centers::OnBisector,
            feeds: Feeds::OfLinear,
            rapids: Rapids::Ends,
            frame: OutputFrame::Work,
            five_axis: FiveAxis::Tcp,
            has_spatial_arcs: false,
            has_transformation: true,
            max_correction_mm: 0.2,
            rotary: Rotary::Auto,
            start: None,
        }
    }
}

/// Subdivision of moves into pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Subdivision {
    /// The fewest pieces that keep the deviation within the tolerance.
    Adaptive,
    /// A fixed step along the axis that moves farthest, mm (Spaan, ch. 7). A rotary axis counts with an arm of 100 mm. Arcs are
    /// cut by the tolerance too, as chords of a fixed step would leave the circle.
    Step(f64),
}

/// Treatment of arcs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arcs {
    /// Arcs stay arcs if one fits within the tolerance and the control's center check.
    #[default]
    Keep,
    /// Arcs become straight pieces.
    Chords,
}

/// Largest turn of one output block around a circle; longer arcs become several blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turns {
    /// Any number of turns.
    #[default]
    Several,
    /// One turn.
    One,
    /// One turn if only the two axes of the circle move, otherwise less.
    OneFlat,
}

/// Interpretation of an arc center by the control if rounding makes the radii at start and end differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Centers {
    /// Moved onto the perpendicular bisector of the chord: both radii are equal.
    #[default]
    OnBisector,
    /// As written: the path is a spiral.
    AsWritten,
}

/// The path to which a control's feed refers in a block that turns rotary axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Feeds {
    /// The path of X, Y and Z; if only rotary axes move, their path in degrees (RS274/NGC; Sinumerik without FGROUP). A block may state its duration
    /// instead (G93).
    #[default]
    OfLinear,
    /// As [`Feeds::OfLinear`], but no block can state its duration.
    OfLinearOnly,
    /// The path of all axes, a degree counted as a millimeter, as on Fanuc; also with G93. Under a transformation, the path of the tip.
    OfAll,
}

/// Treatment of rapid moves. Only the approach to a cut may move axes that the source does not name. Moves in machine coordinates, to reference
/// points, to a tool change and along the tool stay as programmed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rapids {
    /// The end point is corrected, the path is one piece.
    #[default]
    Ends,
    /// Rapid moves stay as programmed, rounded to the increment (Spaan).
    None,
    /// The approach to a cut is treated like a feed move.
    All,
}

/// Frame of the emitted coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputFrame {
    /// The zero offset and frame of the program.
    #[default]
    Work,
    /// Machine coordinates of the tool tip.
    Machine,
}

/// Treatment of five-axis transformations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FiveAxis {
    /// Kept: the output contains positions of the tip in the workpiece and of rotary axes.
    #[default]
    Tcp,
    /// Resolved: the output contains axis positions, in [`OutputFrame::Machine`].
    Axes,
}

/// Participation of rotary axes in the correction. A clamped axis never participates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rotary {
    /// Axes that the operation turns with feed participate; the others stay as programmed.
    #[default]
    Auto,
    /// All rotary axes turn so that the tool axis has its nominal direction.
    Correct,
    /// Rotary axes stay as programmed; only the tip position is corrected.
    Hold,
}

/// Output of the corrector: elements without motion in their places, pieces of moves, and holes.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// An element without motion, unchanged.
    Element(Element),
    /// A piece of a move.
    Piece(Piece),
    /// A hole that stays a drilling cycle.
    Cycle(Box<CycleBlock>),
}

/// A straight or circular piece of a move, its end a whole number of increments on every axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Origin of its move.
    pub origin: Origin,
    /// `true` if a new executed block starts with it.
    pub starts_block: bool,
    /// The block number, on the piece that starts the block.
    pub number: Option<BlockNumber>,
    /// First piece of its move.
    pub first: bool,
    /// Last piece of its move.
    pub last: bool,
    /// Step on the spot: the path stands still, and the axes go from the previous correct command to the one for the next piece (reversal of an axis
    /// with backlash, or after an uncorrected rapid move).
    pub take_up: bool,
    /// `true` for a rapid piece, `false` for a feed piece.
    pub rapid: bool,
    /// Center and direction, if it is an arc.
    pub arc: Option<PieceArc>,
    /// Programmed coordinates at the end, in increments ([`Increments`]), in the emitted frame.
    pub counts: [i64; AXIS_COUNT],
    /// Axes to write.
    pub words: AxisSet,
    /// Active feed, as in the source or converted for [`Feeds`].
    pub feed: f64,
    /// Unit of the feed.
    pub unit: FeedUnit,
    /// `true` if the source names the feed in the block and this is its first piece.
    pub feed_named: bool,
    /// Notation of the words of A, B and C.
    pub rotary_words: [RotaryWord; 3],
    /// `true` if the source writes machine coordinates for this block only (G53, G153, SUPA).
    pub in_machine_frame: bool,
    /// Motion mode.
    pub motion_mode: MotionMode,
    /// Axis commands at the end, without tool: mm, rad.
    pub command: AxisVector,
    /// Commands of the program at the end.
    pub nominal: AxisVector,
    /// Axes whose position the program has stated so far.
    pub known: AxisSet,
    /// `true` if the piece is corrected.
    pub is_corrected: bool,
    /// Axes without a word stay, although they are not at their corrected position.
    pub others_stay: bool,
}

impl Piece {
    /// `true` for a further piece of its move without motion.
    #[must_use]
    pub fn stands_still(&self) -> bool {
        let is_further = !self.starts_block && !self.first && !self.feed_named;
        is_further && self.words.is_empty() && self.arc.is_none() && self.motion_mode == MotionMode::Path
    }
}

/// Notation of the position of a rotary axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotaryWord {
    /// The position with all its turns: `C370`.
    #[default]
    Plain,
    /// The position within the turn: `C10`, `DC(10)`, `ACP(10)` or `ACN(10)`.
    Within(RotaryDirection),
    /// `IC(…)`: more than a full turn, in increments.
    Step(i64),
}

impl RotaryWord {
    /// `true` if it is written with a function: `=DC(10)`.
    #[must_use]
    pub fn is_function(self) -> bool {
        !matches!(self, RotaryWord::Plain | RotaryWord::Within(RotaryDirection::Plain))
    }
}

/// The circle of a piece, in the emitted frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PieceArc {
    /// Plane of the circle.
    pub plane: Plane,
    /// `true` for G2, `false` for G3.
    pub clockwise: bool,
    /// Center minus start along X, Y, Z in increments: I J K.
    pub center_counts: [i64; 3],
    /// Programmed coordinates at the start along X, Y, Z, in increments, for controls with absolute centers.
    pub start_counts: [i64; 3],
    /// Full turns beyond the arc itself; 0 unless [`Turns::Several`].
    pub extra_turns: u32,
    /// Programmed coordinates of an intermediate point along X, Y, Z, in increments, of an arc in any plane: the circle leads from the start through it to the
    /// end, and the center is only near it.
    pub through_counts: Option<[i64; 3]>,
}

/// Axes whose position is unknown after an element: a tool change, or motion outside the stream.
fn lost_axes(element: &Element, machine: &Machine) -> AxisSet {
    let is_change =
        |word: &Word| word.letter == b'M' && word.extension.is_none() && word.value == WordValue::Number(6.0);
    let is_lost = match &element.kind {
        Kind::Tool(_) => machine.control.tool_change == ToolChange::T,
        Kind::Lost(axes) => return *axes,
        Kind::Before(words) | Kind::After(words) => words.iter().any(is_change),
        _ => false,
    };
    if is_lost && machine.control.tool_change_moves() { AxisSet::ALL } else { AxisSet::EMPTY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::{FileId, Source};

    /// The embedded machine.
    pub(super) fn demo() -> Machine {
        let text = ncfix_machine::machine::file::DEMO.as_bytes().to_vec();
        ncfix_model::file::load(&Source::new(FileId(0), "m.toml", text).unwrap()).0.unwrap().0
    }

    #[test]
    fn nobody_knows_where_axes_are_behind_a_change_of_the_tool() {
        let mut machine = demo();
        let element = |kind| Element { origin: Origin::default(), starts_block: true, number: None, kind };
        let tool = element(Kind::Tool(WordValue::Number(3.0)));
        let word = |number: f64| Word { letter: b'M', extension: None, value: WordValue::Number(number) };
        let [change, other] = [6.0, 8.0].map(|number| element(Kind::After(vec![word(number)])));
        // If M6 changes the tool, T only selects it.
        machine.control.tool_change = ToolChange::M6;
        let lost = |machine: &Machine| [&tool, &change, &other].map(|element| lost_axes(element, machine));
        assert_eq!(lost(&machine), [AxisSet::EMPTY, AxisSet::ALL, AxisSet::EMPTY]);
        machine.control.tool_change = ToolChange::T;
        assert_eq!(lost(&machine)[0], AxisSet::ALL);
    }
}
