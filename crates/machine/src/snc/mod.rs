//! SNC, "simple NC": the flat stream of moves after execution (Spaan, ch. 7).
//!
//! It contains no loops, calls or variables: only rapid, linear and circular moves, dwells, and the auxiliary functions in their places. Frames and tools are
//! resolved. The stream also states the active ones, and carries comments, messages, labels and cycle calls, which the output keeps. Targets are
//! **axis commands** (mm, rad). The text form adds the tool vector, so it shows positions of the tool tip. Elements of one executed block follow
//! each other; the first has [`Element::starts_block`].

mod drilling;
pub mod extent;
mod feed_unit;
mod here;
mod motion_mode;
mod text;
mod text_reader;
mod written_zero;

pub use drilling::{CycleArgument, DrillingCycle, HoleTrigger, Peck};
pub use feed_unit::{FEED_MODES, FeedUnit};
pub use here::HereStatement;
pub use motion_mode::{MotionMode, Thread, ThreadCode};
pub use text::{TextWriter, stated_machine};
pub use text_reader::{TextError, TextReader};
pub use written_zero::{WrittenZero, WrittenZeros};

use std::sync;

use ncfix_base::geometry::{Arc, AxisSet, AxisVector, Frame, Matrix, Plane, Vector};
use ncfix_base::source::{FileId, Span};

/// Place in the programs from which an element comes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Origin {
    /// File of the block.
    pub file: FileId,
    /// Line of the block in its file, from 1.
    pub line: u32,
    /// Range of bytes in the file.
    pub span: Span,
    /// Chain of calls that led here: 0 for the main program, else a number that the execution resolves.
    pub calls: u32,
}

/// Block number as written: `N10` or `:10`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockNumber {
    /// True for `:` instead of `N`.
    pub main: bool,
    /// Its digits as a number.
    pub number: u32,
}

/// One move, function or text of the stream, in the order of execution.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Block of the program that caused it.
    pub origin: Origin,
    /// True if a new executed block starts with it.
    pub starts_block: bool,
    /// Block number, on the element that starts the block.
    pub number: Option<BlockNumber>,
    /// The move, function or text itself.
    pub kind: Kind,
}

/// Kinds of elements, each with its data.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A motion.
    Move(Move),
    /// A dwell.
    Dwell(Dwell),
    /// A tool word: `T5` or `T="MILL_10"`.
    Tool(WordValue),
    /// Words S, M, H, D of one block that act before its motion.
    Before(Vec<Word>),
    /// M words of one block that act after its motion (M0, M5, M9, M30 …).
    After(Vec<Word>),
    /// A feed in a block without motion, as written in the feed mode of the program.
    Feed(f64),
    /// A word of the program's language that changes no position and is passed on: `G64`, `G17`, `SOFT`. Also `G53`, `G153`, `SUPA` of a block whose move is
    /// [`Move::in_machine_frame`].
    Keep(&'static str),
    /// Words of the program's language that change no position, values evaluated: `ADIS=0.5`, `SETMS(2)`. They come before the motion words of their block.
    Verbatim(Vec<u8>),
    /// Data that the control computes from the place where it stands: `G10 L20`. Not part of the text form.
    Here(Box<HereStatement>),
    /// The positions of these axes are unknown from here on: something outside the stream has moved them.
    Lost(AxisSet),
    /// Relation of positions to axis commands from here on. Not part of the text form.
    Setup(sync::Arc<Setup>),
    /// A zero-offset or frame statement to be written at this place, values evaluated.
    Frame(FrameWords),
    /// `MSG("…")`, evaluated; bytes as in the source.
    Message(Vec<u8>),
    /// The comment of the block with its `;`, bytes as in the source. It comes before the motion of its block, so that a writer can put it on the first line.
    Comment(Vec<u8>),
    /// The label of a block of the main program (`START` of `START:`), before everything else of the block. Not part of the text form.
    Label(Vec<u8>),
    /// A header line, written unchanged (`%_N_…_MPF`, `;$PATH=…`).
    Header(Vec<u8>),
    /// The moves of one hole of a drilling cycle begin, or end with `None`. Not part of the text form.
    Cycle(Option<sync::Arc<DrillingCycle>>),
    /// Only a place: a block with nothing but a number.
    Empty,
}

/// Motion of the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// True for rapid (G0), false for feed.
    pub rapid: bool,
    /// Arc with its center as axis commands, or, with [`Self::tip`], as positions on the workpiece; `None` for a straight move.
    pub arc: Option<Arc>,
    /// Some if the plane of [`Self::arc`] is tilted: orthonormal columns, along which the coordinates of the arc count, X, Y and Z in this order.
    pub arc_basis: Option<Matrix>,
    /// Some if the control interpolates the tip in the workpiece (TRAORI, G43.4): positions fixed to the workpiece follow the line or the arc, and the tool turns
    /// in this manner. The axes then move along curves. `None` if the axes themselves are interpolated.
    pub tip: Option<Turning>,
    /// Axis commands at the end, without tool vector: mm, rad.
    pub target: AxisVector,
    /// Axes that the block names.
    pub named: AxisSet,
    /// Axes whose position the program has stated so far, including this block; the others are assumptions. After a frame that mixes axes these are the axes
    /// of the program.
    pub known: AxisSet,
    /// Feed in force, mm/min in feed mode G94 (mm/rev in G95, 1/min in G93), 0 if there is none; also present on rapid moves, which do not use it.
    pub feed: f64,
    /// True if the block names F.
    pub feed_named: bool,
    /// Unit of [`Self::feed`].
    pub unit: FeedUnit,
    /// Rotary directions of A, B and C as programmed.
    pub ways: [RotaryDirection; 3],
    /// True if the positions are written as machine coordinates for this block only (G53, G153, SUPA).
    pub in_machine_frame: bool,
    /// Part of the path, thread, positioning, reference point or probing.
    pub motion_mode: MotionMode,
    /// Maximum deviation of the programmed path from this straight move, which is a chord of it, mm; 0 if the move is the path itself.
    pub off_curve_mm: f64,
}

impl Move {
    /// True if the feed is the reciprocal of the time of this move, 1/min (G93).
    #[must_use]
    pub fn is_inverse_time(&self) -> bool {
        self.unit == FeedUnit::InverseTime
    }

    /// True if the control decides in which direction a rotary axis turns ([`RotaryDirection::Either`]).
    #[must_use]
    pub fn turns_either_way(&self) -> bool {
        self.ways.contains(&RotaryDirection::Either)
    }
}

/// Direction in which a rotary axis moves to its position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotaryDirection {
    /// As given by the position.
    #[default]
    Plain,
    /// `DC`: the shortest path.
    Shortest,
    /// The shortest path if both directions are half a turn: the control decides.
    Either,
    /// `ACP`: in the positive direction.
    Positive,
    /// `ACN`: in the negative direction.
    Negative,
}

/// Duration of a dwell (G4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dwell {
    /// Seconds.
    Seconds(f64),
    /// Spindle revolutions.
    Turns(f64),
}

/// Auxiliary word: `M3`, `S2=500`, `H5`.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// Address letter, upper case.
    pub letter: u8,
    /// Address extension, the 2 of `S2=500`.
    pub extension: Option<u32>,
    /// Number or name after the address.
    pub value: WordValue,
}

/// Value of an auxiliary word.
#[derive(Clone, Debug, PartialEq)]
pub enum WordValue {
    /// A number.
    Number(f64),
    /// A name, as in `T="MILL_10"`; bytes as in the source.
    Name(Vec<u8>),
}

/// Statement that changes the frame, to be written again with evaluated values.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameWords {
    /// `G500`, `G54` …
    Settable(String),
    /// `TRANS`, `AROT` …
    Statement(FrameStatement),
}

/// Statement that programs the frame, values evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameStatement {
    /// The operation on the frame.
    pub kind: FrameKind,
    /// True if it adds to the frame in force (`ATRANS`), false if it replaces it (`TRANS`).
    pub additive: bool,
    /// Shifts (mm, rad), angles (rad), factors; for mirroring the values after the axes.
    pub values: AxisVector,
    /// Named axes.
    pub named: AxisSet,
    /// `RPL=`: angle in the working plane, rad.
    pub in_plane_rad: Option<f64>,
}

/// Kinds of frame statements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameKind {
    /// `TRANS`
    Translate,
    /// `ROT`
    Rotate,
    /// `ROTS`
    SolidAngles,
    /// `SCALE`
    Scale,
    /// `MIRROR`
    Mirror,
    /// `G58`: the shift without its fine part.
    Coarse,
    /// `G59`: the fine part of the shift.
    Fine,
}

impl FrameKind {
    /// Returns the kind of a word, and whether the word is additive.
    #[must_use]
    pub fn of(word: &str) -> Option<(FrameKind, bool)> {
        let kind = |word: &str| {
            Some(match word {
                "TRANS" => FrameKind::Translate,
                "ROT" => FrameKind::Rotate,
                "ROTS" => FrameKind::SolidAngles,
                "SCALE" => FrameKind::Scale,
                "MIRROR" => FrameKind::Mirror,
                "G58" => FrameKind::Coarse,
                "G59" => FrameKind::Fine,
                _ => return None,
            })
        };
        kind(word).map(|kind| (kind, false)).or_else(|| word.strip_prefix('A').and_then(kind).map(|kind| (kind, true)))
    }
}

/// Motion of the tool orientation under a five-axis transformation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turning {
    /// Rotary axes in proportion to the path.
    Axes,
    /// Tool along a great circle.
    Vector,
}

/// Relation of programmed positions to axis commands: `axis command = frame(programmed) − tool`. Under a five-axis transformation the right side is the
/// position fixed to the workpiece, which the kinematics convert to a command.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// From programmed positions to the machine coordinates of the tool tip in the control.
    pub frame: Frame,
    /// From the spindle gauge point to the tool tip as known to the control, along the directions of F at the zero pose, mm.
    pub tool_mm: Vector,
    /// Working plane.
    pub plane: Plane,
    /// Five-axis transformation, if one is in force.
    pub transform: Option<Turning>,
    /// True if frame or tool had no value and zero was assumed. The diagnostic is not repeated, but the correction must not use such a setup.
    pub assumed: bool,
    /// Index of the zero offset in force: among those of the machine, or after them for a value that the program has set. `None` without one.
    pub zero: Option<u16>,
    /// The zero offset in force, if the program has set its value.
    pub written_zero: Option<sync::Arc<WrittenZero>>,
    /// Index of the active head among those of the machine; 0 without heads.
    pub head: u16,
}

impl Setup {
    /// Converts programmed positions to axis commands.
    #[must_use]
    pub fn command(&self, programmed: &AxisVector) -> AxisVector {
        let mut out = self.frame.apply(programmed);
        out.set_xyz(out.xyz() - self.tool_mm);
        out
    }

    /// Converts axis commands to programmed positions.
    #[must_use]
    pub fn programmed(&self, command: &AxisVector) -> AxisVector {
        let mut out = *command;
        out.set_xyz(out.xyz() + self.tool_mm);
        self.frame.unapply(&out)
    }
}

impl Default for Setup {
    fn default() -> Self {
        Setup {
            frame: Frame::identity(),
            tool_mm: Vector::zeros(),
            plane: Plane::XY,
            transform: None,
            assumed: false,
            zero: None,
            written_zero: None,
            head: 0,
        }
    }
}

impl Kind {
    /// True if the text form has a line for it.
    #[must_use]
    pub fn is_in_text(&self) -> bool {
        matches!(self, Kind::Move(_) | Kind::Dwell(_) | Kind::Tool(_) | Kind::Before(_) | Kind::After(_))
    }
}
