//! SNC, "simple NC": the flat stream that is left after execution (Spaan, ch. 7).
//!
//! No loops, calls, variables or frames are left: only rapid, linear and circular moves, dwells and the auxiliary functions
//! in their places. Targets are **axis commands** (mm, rad); the text form adds the tool vector, so that it shows positions
//! at the tool center point. Elements of one executed block follow each other; the first has [`Element::starts_block`].

mod feed_unit;
mod manner;
mod text;
mod text_reader;

pub use feed_unit::{FEED_MODES, FeedUnit};
pub use manner::{Manner, Thread, ThreadCode};
pub use text::TextWriter;
pub use text_reader::{TextError, TextReader};

use std::sync;

use ncfix_base::geometry::{Arc, AxisSet, AxisVector, Frame, Plane, Vector};
use ncfix_base::source::{FileId, Span};

/// Where an element comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Origin {
    /// The file of the block.
    pub file: FileId,
    /// Its line, from 1.
    pub line: u32,
    /// Its bytes.
    pub span: Span,
    /// The chain of calls that led here: 0 for the main program, else a number that the execution resolves.
    pub calls: u32,
}

/// A block number as written: `N10` or `:10`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockNumber {
    /// `:` instead of `N`.
    pub main: bool,
    /// The number.
    pub number: u32,
}

/// One element of the stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Where it comes from.
    pub origin: Origin,
    /// Whether a new executed block starts with it.
    pub starts_block: bool,
    /// The block number, on the element that starts the block.
    pub number: Option<BlockNumber>,
    /// What it is.
    pub kind: Kind,
}

/// What an element is.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A motion.
    Move(Move),
    /// A dwell.
    Dwell(Dwell),
    /// A tool word, `T5` or `T="MILL_10"`.
    Tool(WordValue),
    /// S, M, H, D words of one block that act before its motion.
    Before(Vec<Word>),
    /// M words of one block that act behind its motion (M0, M5, M9, M30 …).
    After(Vec<Word>),
    /// A feed without a motion in its block, as written in the program's feed mode.
    Feed(f64),
    /// A word of the program's language that changes no position and is passed on: `G64`, `G17`, `SOFT`, and the
    /// `G53`, `G153`, `SUPA` of a block whose move is [`Move::in_machine_frame`].
    Keep(&'static str),
    /// Words of the program's language that change no position, values evaluated: `ADIS=0.5`, `SETMS(2)`. They stand before the words
    /// of the motion of their block.
    Verbatim(Vec<u8>),
    /// Where these axes are is unknown from here on: something that is not in the stream has moved them.
    Lost(AxisSet),
    /// From here on positions relate to axis commands like this. Does not show in the text form.
    Setup(sync::Arc<Setup>),
    /// A zero-offset or frame statement to be written in its place, values evaluated.
    Frame(FrameWords),
    /// `MSG("…")`, evaluated; bytes as in the source.
    Message(Vec<u8>),
    /// The comment of the block, with its `;`, bytes as in the source. Comes before the motion of its block, so that a
    /// writer can put it on the first line.
    Comment(Vec<u8>),
    /// The label of a block of the main program (`START` of `START:`), before everything else of the block. Does not show in the text form.
    Label(Vec<u8>),
    /// A header line, written as it is (`%_N_…_MPF`, `;$PATH=…`).
    Header(Vec<u8>),
    /// Nothing but a place: a block that only had a number.
    Empty,
}

/// A motion of the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Rapid (G0) or with feed.
    pub rapid: bool,
    /// Straight, or an arc with its center as axis commands.
    pub arc: Option<Arc>,
    /// Axis commands at the end, without tool vector: mm, rad.
    pub target: AxisVector,
    /// Axes that the block itself names.
    pub named: AxisSet,
    /// Axes whose position the program has stated by now (this block included); the others are assumptions. Behind a frame that mixes
    /// axes these are the axes of the program.
    pub known: AxisSet,
    /// Feed in force, mm/min in feed mode G94 (mm/rev in G95, 1/min in G93), 0 for none; also on rapid moves, which do not use it.
    pub feed: f64,
    /// Whether the block itself names F.
    pub feed_named: bool,
    /// What [`Self::feed`] counts.
    pub unit: FeedUnit,
    /// How the program names the positions of A, B and C.
    pub ways: [Way; 3],
    /// Whether the positions are written as machine coordinates for this block only (G53, G153, SUPA).
    pub in_machine_frame: bool,
    /// How the control carries it out.
    pub manner: Manner,
    /// How far the way that the program asks for may be off this straight move, which is a chord of it, mm; 0 where it is the way itself.
    pub off_curve_mm: f64,
}

impl Move {
    /// Whether the feed is the reciprocal of the time of this move, 1/min (G93).
    #[must_use]
    pub fn is_inverse_time(&self) -> bool {
        self.unit == FeedUnit::InverseTime
    }

    /// Whether the control decides which way a rotary axis turns ([`Way::Either`]).
    #[must_use]
    pub fn turns_either_way(&self) -> bool {
        self.ways.contains(&Way::Either)
    }
}

/// How a rotary axis gets to its position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Way {
    /// As the position says.
    #[default]
    Plain,
    /// `DC`: the shortest way.
    Shortest,
    /// The shortest way, and both are half a turn: the control decides.
    Either,
    /// `ACP`: in the positive sense.
    Positive,
    /// `ACN`: in the negative sense.
    Negative,
}

/// A dwell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dwell {
    /// Seconds.
    Seconds(f64),
    /// Turns of the spindle.
    Turns(f64),
}

/// An auxiliary word: `M3`, `S2=500`, `H5`.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// Address letter, upper case.
    pub letter: u8,
    /// Address extension, the 2 of `S2=500`.
    pub extension: Option<u32>,
    /// Value.
    pub value: WordValue,
}

/// The value of an auxiliary word.
#[derive(Clone, Debug, PartialEq)]
pub enum WordValue {
    /// A number.
    Number(f64),
    /// A name, as in `T="MILL_10"`; bytes as in the source.
    Name(Vec<u8>),
}

/// A statement that changes the frame, to be written again with evaluated values.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameWords {
    /// `G500`, `G54` …
    Settable(String),
    /// `TRANS`, `AROT` …
    Statement(FrameStatement),
}

/// A statement that programs the frame, values evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameStatement {
    /// What it does.
    pub kind: FrameKind,
    /// Whether it goes on top of the frame in force (`ATRANS`) instead of replacing it (`TRANS`).
    pub additive: bool,
    /// Shifts (mm, rad), angles (rad), factors, or for mirroring what stands behind the axis.
    pub values: AxisVector,
    /// Axes named.
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
    /// `G58`: the shift but for its fine part.
    Coarse,
    /// `G59`: the fine part of the shift.
    Fine,
}

impl FrameKind {
    /// The kind of a word, and whether the word is additive.
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

/// How the tool turns under a five-axis transformation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turning {
    /// Rotary axes in proportion to the way.
    Axes,
    /// The tool along a great circle.
    Vector,
}

/// How programmed positions relate to axis commands: `axis command = frame(programmed) − tool`. Under a five-axis transformation
/// the right side is the position fixed to the workpiece, which the kinematics turn into a command.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Programmed to the control's machine coordinates of the tool center point.
    pub frame: Frame,
    /// From the spindle gauge point to the tool tip as the control sees it, along F's directions at the zero pose, mm.
    pub tool_mm: Vector,
    /// The working plane.
    pub plane: Plane,
    /// The five-axis transformation, where one is in force.
    pub transform: Option<Turning>,
    /// Where frame or tool had no value and zero was assumed, the code of the finding is not repeated but the
    /// correction must not use it.
    pub assumed: bool,
}

impl Setup {
    /// Programmed positions to axis commands.
    #[must_use]
    pub fn command(&self, programmed: &AxisVector) -> AxisVector {
        let mut out = self.frame.apply(programmed);
        out.set_xyz(out.xyz() - self.tool_mm);
        out
    }

    /// Axis commands to programmed positions.
    #[must_use]
    pub fn programmed(&self, command: &AxisVector) -> AxisVector {
        let mut out = *command;
        out.set_xyz(out.xyz() + self.tool_mm);
        self.frame.unapply(&out)
    }
}

impl Default for Setup {
    fn default() -> Self {
        Setup { frame: Frame::identity(), tool_mm: Vector::zeros(), plane: Plane::XY, transform: None, assumed: false }
    }
}

impl Kind {
    /// Whether the text form has a line for it.
    #[must_use]
    pub fn is_in_text(&self) -> bool {
        matches!(self, Kind::Move(_) | Kind::Dwell(_) | Kind::Tool(_) | Kind::Before(_) | Kind::After(_))
    }
}
