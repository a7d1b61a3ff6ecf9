//! Modal state, which stays active from block to block: modal codes, frames, tool, position.

use std::sync::Arc;

use super::curve::End;
use super::five_axis::Transform;
use super::pole::Polar;
use super::stated::Stated;
use crate::exec::core::contour::ContourModal;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::modal::Modes;
use crate::exec::core::position::Position;
use crate::exec::core::tool::ToolState;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Plane, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::FrameStatement;
use ncfix_machine::snc::{FeedUnit, Setup, ThreadCode, WordValue, WrittenZero};

/// The active motion mode: G group 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MotionKind {
    /// G0
    Rapid,
    /// G1
    Line,
    /// G2
    Clockwise,
    /// G3
    CounterClockwise,
    /// CIP
    Through,
    /// CT
    Tangent,
    /// ASPLINE
    Akima,
    /// BSPLINE
    BSpline,
    /// CSPLINE
    Cubic,
    /// POLY
    Polynomial,
    /// G33 and related codes
    Thread(ThreadCode),
}

impl MotionKind {
    /// The motion mode of a code of the table.
    pub(super) fn of(code: &str) -> Option<MotionKind> {
        Some(match code {
            "G0" => MotionKind::Rapid,
            "G1" => MotionKind::Line,
            "G2" => MotionKind::Clockwise,
            "G3" => MotionKind::CounterClockwise,
            "CIP" => MotionKind::Through,
            "CT" => MotionKind::Tangent,
            "ASPLINE" => MotionKind::Akima,
            "BSPLINE" => MotionKind::BSpline,
            "CSPLINE" => MotionKind::Cubic,
            "POLY" => MotionKind::Polynomial,
            _ => return ThreadCode::of(code).map(MotionKind::Thread),
        })
    }
}

/// Feed unit after a code of the feed mode.
pub(super) fn unit_behind(unit: FeedUnit, word: &str) -> FeedUnit {
    match word {
        "G93" => FeedUnit::InverseTime,
        "G94" | "G942" | "G961" | "G971" => FeedUnit::PerMinute,
        "G95" | "G952" | "G96" | "G97" | "G973" => FeedUnit::PerTurn,
        // The others keep it.
        _ if unit == FeedUnit::InverseTime => FeedUnit::PerMinute,
        _ => unit,
    }
}

/// G group of the feed modes.
const FEED_MODES: u8 = 15;

/// The zero offset that is active at the start.
pub(super) fn initial_zero_offset(machine: &Machine) -> &str {
    machine.control.initial_zero_offset.as_deref().unwrap_or("G500")
}

/// Modal state of the channel.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    pub(super) modes: Modes<MotionKind>,
    /// Plane that determines the axes of the tool lengths, if fixed.
    pub(super) tool_length_plane: Option<Plane>,
    pub(super) inch_feed: bool,
    /// `true` under G700 or G710, which also apply to feeds and data, unlike G70 and G71.
    pub(super) technological: bool,
    /// Span that activated diameter programming, if active.
    pub(super) diameter: Option<Span>,
    /// Base frame, below the settable one.
    pub(super) base: Frame,
    /// `G500`, `G54` …
    pub(super) settable: Frame,
    /// Index of the settable zero offset among those of the machine.
    pub(super) zero: Option<u16>,
    /// The zero offset, if the program has set its value.
    pub(super) written_zero: Option<Arc<WrittenZero>>,
    /// TRANS, ROT, SCALE, MIRROR and their additive variants.
    pub(super) programmable: Frame,
    /// Plane of CYCLE800, below the programmable frame.
    pub(super) swivelled: Option<Box<Swivelled>>,
    /// The part of its shift that `G59` replaces.
    pub(super) fine: AxisVector,
    /// Pole and polar position.
    pub(super) polar: Polar,
    /// Direction at the end of the last motion, base coordinates, of any length.
    pub(super) tangent: Option<Vector>,
    /// Modal state written to the output.
    pub(super) stated: Stated,
    /// `true` if the frame has no value in the machine file.
    pub(super) offset_assumed: bool,
    /// Its lengths are L1, L2, L3.
    pub(super) tool: ToolState<WordValue, [f64; 3]>,
    pub(super) edge: u32,
    /// `true` if the program has stated the edge, by D or a tool change.
    pub(super) edge_stated: bool,
    /// Place at which an edge was activated before the program has loaded a tool: the length of that tool is unknown.
    pub(super) unknown_edge: Option<Span>,
    /// Radius compensation and contour transitions.
    pub(super) contour: ContourModal,
    pub(super) position: Position,
    /// Last programmed values per axis; after a frame change they may belong to the old frame (Sinumerik SD42440).
    pub(super) programmed: AxisVector,
    /// Start and end conditions of splines.
    pub(super) spline_ends: [End; 2],
    /// Five-axis transformation.
    pub(super) transform: Transform,
    /// Axes with unknown position because a plane change has moved the tool length to or from them.
    pub(super) moved_by_plane: AxisSet,
    /// Axes whose last programmed value belongs to a frame with another rotation, scale or mirroring.
    pub(super) stale: AxisSet,
}

impl Modal {
    pub(super) fn new(start: Option<AxisVector>, machine: &Machine) -> Self {
        let position = Position::at_start(start, machine);
        Modal {
            modes: Modes::new(MotionKind::Line, machine.control.initial_plane),
            tool_length_plane: machine.control.tool_length_plane,
            inch_feed: false,
            technological: false,
            diameter: None,
            base: Frame::identity(),
            settable: Frame::identity(),
            zero: None,
            written_zero: None,
            programmable: Frame::identity(),
            swivelled: None,
            fine: AxisVector::ZERO,
            polar: Polar::default(),
            tangent: None,
            stated: Stated::new(initial_zero_offset(machine)),
            offset_assumed: false,
            tool: ToolState::default(),
            edge: 0,
            edge_stated: false,
            unknown_edge: None,
            contour: ContourModal::default(),
            position,
            programmed: position.command,
            stale: AxisSet::EMPTY,
            spline_ends: [End::Natural; 2],
            transform: Transform::default(),
            moved_by_plane: AxisSet::EMPTY,
        }
    }

    /// Total frame: base, settable, then programmable, which is nearest to the programmed value.
    pub(super) fn frame(&self) -> Frame {
        let below = self.base.compose(&self.settable);
        let below = self.swivelled.as_ref().map_or(below, |swivelled| below.compose(&swivelled.frame));
        below.compose(&self.programmable)
    }

    /// Gauge point to tip as in the control: L1, L2, L3 are along applicate, ordinate, abscissa of the plane (G17: Z Y X, G18: Y X Z, G19: X Z Y;
    /// Programming Manual NC programming, 12/2019, 3.13.3.4, tools other than turning and grinding tools).
    pub(super) fn tool_mm(&self) -> Vector {
        let plane = self.tool_length_plane.unwrap_or(self.modes.plane);
        let [abscissa, ordinate, applicate] = plane.axes();
        let mut tool = Vector::zeros();
        let [first, second, third] = self.tool.length_mm;
        tool[applicate.slot()] = -first;
        tool[ordinate.slot()] = -second;
        tool[abscissa.slot()] = -third;
        tool
    }

    /// The current relation between programmed positions and axis commands.
    pub(super) fn setup(&self) -> Setup {
        Setup {
            frame: self.frame(),
            tool_mm: self.tool_mm(),
            plane: self.modes.plane,
            transform: self.transform.turning(),
            assumed: self.offset_assumed || self.tool.assumed,
            zero: self.zero,
            written_zero: self.written_zero.clone(),
            head: self.tool.head,
        }
    }

    /// Rejects what depends on the length or radius of a tool that the program has not loaded.
    pub(super) fn check_length(&mut self, span: Span) -> Result<(), Fault> {
        // One cause is reported once.
        if self.unknown_edge.take().is_none() {
            return Ok(());
        }
        let message = format!(
            "this depends on the tool in the spindle, which is not known: D{} is active and no tool was loaded with M6",
            self.edge
        );
        let help = "program T and M6 before it, D0 for a position of the machine, or set control.tool_change = \"T\" if T changes the tool";
        Err(fault(Code::NO_TOOL, span, message, help))
    }

    /// Takes over the state that SAVE does not restore: position, tool, feed.
    pub(super) fn keep_position_of(&mut self, left: &Modal) {
        // A feed per revolution or of inverse time has no meaning in the caller's feed mode.
        if self.stated.codes.programmed(FEED_MODES) == left.stated.codes.programmed(FEED_MODES) {
            self.modes.feed = left.modes.feed;
        }
        self.modes.speed = left.modes.speed;
        self.tool.clone_from(&left.tool);
        self.edge = left.edge;
        self.edge_stated = left.edge_stated;
        self.unknown_edge = left.unknown_edge;
        self.position = left.position;
        self.programmed = left.programmed;
        self.stale = left.stale;
        self.transform.keep_switch_of(&left.transform);
        self.tangent = left.tangent;
    }

    /// Makes the position unknown: something has moved the machine.
    pub(super) fn forget_position(&mut self) {
        self.forget(AxisSet::ALL);
    }

    /// Makes the position unknown: a tool change has moved the machine.
    pub(super) fn forget_by_change(&mut self) {
        self.forget_position();
        self.position.forget_by_change();
    }

    /// Makes the position of axes unknown. Axes that a frame or transformation mixes become unknown together. Returns all unknown axes.
    pub(super) fn forget(&mut self, axes: AxisSet) -> AxisSet {
        let frame = self.frame();
        let lost = self.position.forget(axes, self.transform.turning().is_some(), &frame);
        self.moved_by_plane = self.moved_by_plane.difference(lost);
        self.tangent = None;
        lost
    }

    /// The error for an axis whose position the program has not stated.
    pub(super) fn unknown_start(&self, span: Span, axis: Axis) -> Fault {
        if !self.moved_by_plane.contains(axis) {
            return self.position.unknown(span, axis);
        }
        let message = format!(
            "the position of {axis} is not known since G{} was selected, because the tool length then acts along another axis",
            self.modes.plane.number()
        );
        let help = format!(
            "set control.tool_length_plane = 17 in the machine file if the length acts along Z in every plane (SD42940), otherwise program {axis} after the change of plane"
        );
        fault(Code::UNKNOWN_START, span, message, help)
    }
}

/// A swivelled plane.
#[derive(Clone, Debug)]
pub(super) struct Swivelled {
    /// Between the settable frame and the programmable one.
    pub(super) frame: Frame,
    /// Its statements in the output.
    pub(super) statements: [FrameStatement; 2],
    /// The tilt of the workpiece.
    pub(super) tilt: Frame,
    /// The tool for which the frame is valid.
    pub(super) tool_mm: Vector,
    /// `true` if TOROT or TOFRAME has made it, not CYCLE800.
    pub(super) is_of_tool: bool,
}

impl Swivelled {
    /// The word that has tilted the plane.
    pub(super) fn source(&self) -> &'static str {
        if self.is_of_tool { "TOROT" } else { "CYCLE800" }
    }

    /// The step that ends the plane, as a help.
    pub(super) fn way_out(&self) -> &'static str {
        if self.is_of_tool {
            "end the tilted plane with TOROTOF first"
        } else {
            "end the tilted plane with CYCLE800() first"
        }
    }
}
