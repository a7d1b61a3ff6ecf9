//! From the flat stream to corrected pieces: subdivision, correction, arc fitting, and the error that is left along the path.
//!
//! [`Corrector`] adapts an iterator of elements and is as lazy as that: it holds one move at a time. Every position that leaves it is
//! a whole number of the control's increments, rounded from an absolute position, so nothing accumulates; everything behind the
//! rounding (deviation, sense of motion, prediction, the start of the next piece) uses the rounded commands.
//!
//! One forward function judges all: the deviation of a piece is the distance of the tool tip at the emitted command, with all errors,
//! from the nominal tip at the same parameter of the programmed move.

mod ahead;
mod arc_fit;
mod check;
mod compare;

mod corrector;
mod cut;
mod extend;
mod findings;
mod held;
mod increment;
mod lead;
mod live;
mod moves;
mod place;
mod poses;
mod prediction;
mod reach;
mod remaining;
mod rotary_word;
mod route;
mod sides;
mod singularity;
mod slope;
mod standing;
mod steps;
mod tips;
mod treatment;
mod trial;
mod turn;
mod volume;
mod way;

pub use compare::{
    ActSubject, CONTINUES, CONTINUES_ON_THE_SPOT, Comparison, Course, Difference, Follow, Grouping, How, ON_THE_SPOT,
    Parting, Promise, What, compare, compare_seeing,
};
pub use corrector::Corrector;
pub use increment::Increments;
pub use live::{Allows, Applied, Asked, Doses, Live};
pub use moves::Moves;
pub use poses::PoseSample;
pub use prediction::{Prediction, Spread};
pub use reach::Reach;
pub use remaining::{Remaining, remaining};
pub use steps::{Answer, Line, SeriesRow, StepResidual, StepTrial, Steps};
pub use tips::Tips;
pub use volume::volume;

use ncfix_base::geometry::{AXIS_COUNT, AxisSet, AxisVector, Plane};
use ncfix_machine::machine::{Machine, ToolChange};
use ncfix_machine::snc::{BlockNumber, Element, FeedUnit, Kind, Manner, Origin, Way, Word, WordValue};

/// What is to be done with a program.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Largest deviation of an emitted piece from the exactly corrected path, mm.
    pub tolerance_mm: f64,
    /// How moves are cut into pieces.
    pub subdivision: Subdivision,
    /// What becomes of arcs.
    pub arcs: Arcs,
    /// How far one block may lead around a circle.
    pub turns: Turns,
    /// Where the control has the center of an arc.
    pub centers: Centers,
    /// For which way the control takes a feed.
    pub feeds: Feeds,
    /// What becomes of rapid moves.
    pub rapids: Rapids,
    /// What the emitted coordinates relate to.
    pub frame: OutputFrame,
    /// What becomes of five-axis transformations.
    pub five_axis: FiveAxis,
    /// Corrections beyond this are refused, mm; rotary axes are judged by the arc at the tool tip.
    pub max_correction_mm: f64,
    /// Whether rotary axes take part in the correction.
    pub rotary: Rotary,
    /// Distance of the samples of the prediction along the path, mm.
    pub sample_mm: f64,
    /// Programmed position before the first block (mm, rad), where the program relies on one.
    pub start: Option<AxisVector>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            tolerance_mm: 1e-3,
            subdivision: Subdivision::Adaptive,
            arcs: Arcs::Keep,
            turns: Turns::Several,
            centers: Centers::OnBisector,
            feeds: Feeds::OfLinear,
            rapids: Rapids::Ends,
            frame: OutputFrame::Work,
            five_axis: FiveAxis::Tcp,
            max_correction_mm: 0.2,
            rotary: Rotary::Auto,
            sample_mm: 1.0,
            start: None,
        }
    }
}

/// How moves are cut into pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Subdivision {
    /// As few pieces as keep the deviation within the tolerance.
    Adaptive,
    /// A fixed step along the axis that moves farthest, mm (Spaan, ch. 7). A rotary axis counts with an arm of 100 mm. Arcs are
    /// cut by the tolerance too, as chords of a fixed step would leave the circle.
    Step(f64),
}

/// What becomes of arcs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arcs {
    /// They stay arcs where one fits within the tolerance and the control's check of the center.
    #[default]
    Keep,
    /// They become straight pieces.
    Chords,
}

/// How far one block of the output may lead around a circle; what goes further becomes several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turns {
    /// As often as it likes.
    #[default]
    Several,
    /// Once.
    One,
    /// Once, where nothing but the two axes of the circle moves; else less.
    OneFlat,
}

/// Where a control has the center of an arc whose radii at start and end differ by what rounding has left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Centers {
    /// Moved onto the perpendicular bisector of the chord: both radii are one.
    #[default]
    OnBisector,
    /// As written: the way is a spiral.
    AsWritten,
}

/// For which way a control takes the feed of a block that turns rotary axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Feeds {
    /// That of X, Y and Z; that of the rotary axes, in degrees, where nothing else moves (RS274/NGC; Sinumerik without FGROUP). A block may
    /// say instead how long it takes (G93).
    #[default]
    OfLinear,
    /// The same, and no block says how long it takes.
    OfLinearOnly,
    /// That of all axes, a degree counted as a millimeter, as Fanuc does; with G93 as well. Under a transformation that of the tip.
    OfAll,
}

/// What becomes of rapid moves. Only the approach to a cut may move axes that the source does not name; moves in machine coordinates, to
/// reference points, to the change of a tool and along the tool stay as programmed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rapids {
    /// The end point is corrected, the way is one piece.
    #[default]
    Ends,
    /// They stay as programmed, rounded to the increment (Spaan).
    None,
    /// The approach to a cut is treated like a move with feed.
    All,
}

/// What the emitted coordinates relate to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputFrame {
    /// The zero offset and frame of the program.
    #[default]
    Work,
    /// Machine coordinates of the tool center point.
    Machine,
}

/// What becomes of five-axis transformations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FiveAxis {
    /// They stay: the output is positions of the tip in the workpiece and rotary axes.
    #[default]
    Tcp,
    /// The output is positions of the axes, in [`OutputFrame::Machine`].
    Axes,
}

/// Whether rotary axes take part in the correction. One that is clamped never does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rotary {
    /// Those that the operation turns with feed do; the others stay as programmed.
    #[default]
    Auto,
    /// They turn so that the tool axis points where it should.
    Correct,
    /// They stay as programmed; only the position of the tip is corrected.
    Hold,
}

/// What leaves the corrector: elements without motion in their places, and pieces of moves.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all are pieces; a box would be an allocation for each")]
pub enum Output {
    /// An element without motion, unchanged.
    Element(Element),
    /// A piece of a move.
    Piece(Piece),
}

/// A straight or circular piece of a move, its end a whole number of increments on every axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Where its move comes from.
    pub origin: Origin,
    /// Whether a new executed block starts with it.
    pub starts_block: bool,
    /// The block number, on the piece that starts the block.
    pub number: Option<BlockNumber>,
    /// First piece of its move.
    pub first: bool,
    /// Last piece of its move.
    pub last: bool,
    /// The path stands still: the axes only go from the command that was right before to the one that is right for what
    /// follows (reversal of an axis with backlash, a rapid move that was left uncorrected).
    pub take_up: bool,
    /// Rapid or with feed.
    pub rapid: bool,
    /// Center and sense where it is an arc.
    pub arc: Option<PieceArc>,
    /// Programmed coordinates at the end, in increments ([`Increments`]), in the emitted frame.
    pub counts: [i64; AXIS_COUNT],
    /// Axes to write.
    pub words: AxisSet,
    /// Feed in force, as in the source, or what [`Feeds`] makes of it.
    pub feed: f64,
    /// What that counts.
    pub unit: FeedUnit,
    /// Whether the source names the feed in the block and this is the first piece of it.
    pub feed_named: bool,
    /// How the words of A, B and C are written.
    pub rotary_words: [RotaryWord; 3],
    /// Whether the source writes machine coordinates for this block only (G53, G153, SUPA).
    pub in_machine_frame: bool,
    /// How the control carries it out.
    pub manner: Manner,
    /// Axis commands at the end, without tool: mm, rad.
    pub command: AxisVector,
    /// The commands that the program asks for there.
    pub nominal: AxisVector,
    /// Axes whose position the program has stated by now.
    pub known: AxisSet,
    /// Whether it is corrected at all.
    pub is_corrected: bool,
    /// Axes without a word stay where they are, though that is not their corrected place.
    pub others_stay: bool,
}

impl Piece {
    /// Whether it is a further piece of its move that moves nothing.
    #[must_use]
    pub fn stands_still(&self) -> bool {
        let is_further = !self.starts_block && !self.first && !self.feed_named;
        is_further && self.words.is_empty() && self.arc.is_none() && self.manner == Manner::Path
    }
}

/// How the position of a rotary axis is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotaryWord {
    /// The position with all its turns: `C370`.
    #[default]
    Plain,
    /// The position within the turn, `C10`, or as `DC(10)`, `ACP(10)`, `ACN(10)`.
    Within(Way),
    /// `IC(…)`: a full turn and more, in increments.
    Step(i64),
}

impl RotaryWord {
    /// Whether it is written with a function: `=DC(10)`.
    #[must_use]
    pub fn is_function(self) -> bool {
        !matches!(self, RotaryWord::Plain | RotaryWord::Within(Way::Plain))
    }
}

/// The circle of a piece, in the emitted frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PieceArc {
    /// Plane of the circle.
    pub plane: Plane,
    /// G2 rather than G3.
    pub clockwise: bool,
    /// Center minus start along X, Y, Z in increments: I J K.
    pub center_counts: [i64; 3],
    /// Programmed coordinates at the start along X, Y, Z, in increments, for controls that want the center itself.
    pub start_counts: [i64; 3],
    /// Full turns beyond the arc itself; 0 unless [`Turns::Several`].
    pub extra_turns: u32,
}

/// Axes whose place is unknown behind an element: it changes the tool, or something else has moved the machine.
fn lost_axes(element: &Element, machine: &Machine) -> AxisSet {
    let is_change =
        |word: &Word| word.letter == b'M' && word.extension.is_none() && word.value == WordValue::Number(6.0);
    let is_lost = match &element.kind {
        Kind::Tool(_) => machine.control.tool_change == ToolChange::T,
        Kind::Lost(axes) => return *axes,
        Kind::Before(words) | Kind::After(words) => words.iter().any(is_change),
        _ => false,
    };
    if is_lost { AxisSet::ALL } else { AxisSet::EMPTY }
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
        // Where M6 changes, T only selects.
        machine.control.tool_change = ToolChange::M6;
        let lost = |machine: &Machine| [&tool, &change, &other].map(|element| lost_axes(element, machine));
        assert_eq!(lost(&machine), [AxisSet::EMPTY, AxisSet::ALL, AxisSet::EMPTY]);
        machine.control.tool_change = ToolChange::T;
        assert_eq!(lost(&machine)[0], AxisSet::ALL);
    }
}
