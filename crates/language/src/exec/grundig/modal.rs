//! Modal state, which stays active from block to block.

use std::collections::BTreeMap;

use super::defined::{Defined, LastHole};
use super::shifts::Frames;
use super::tilted::Tilted;
use crate::exec::core::contour::ContourModal;
use crate::exec::core::modal::{CodesInForce, Modes};
use crate::exec::core::position::Position;
use crate::exec::core::tool::ToolState;
use ncfix_base::geometry::{AxisSet, AxisVector, Plane};
use ncfix_base::units::sin_deg;
use ncfix_machine::machine::{Control, Machine};
use ncfix_machine::snc::{FeedUnit, Turning};

/// The active motion mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum MotionKind {
    /// G0
    #[default]
    Rapid,
    /// G1
    Line,
    /// G2
    Clockwise,
    /// G3
    CounterClockwise,
}

/// A point of G78.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Workpiece coordinates, mm and rad.
    pub(super) values: AxisVector,
    /// The axes that were programmed.
    pub(super) named: AxisSet,
}

/// Modal state.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    pub(super) modes: Modes<MotionKind>,
    /// Active codes of the other groups of the code table.
    pub(super) codes: CodesInForce<u8, u16>,
    /// `true` if rapid moves position the tool axis and the plane one after the other.
    pub(super) positioning_logic: bool,
    /// The pole of B2, L2, as programmed.
    pub(super) pole: AxisVector,
    pub(super) points: BTreeMap<u32, Point>,
    pub(super) frames: Frames,
    /// Tools are T words: the hundredths select the edge.
    pub(super) tool: ToolState<f64, f64>,
    /// Allowances of G39 on length and radius, mm.
    pub(super) allowance_mm: [f64; 2],
    /// G66: the tool direction is reversed.
    pub(super) tool_reversed: bool,
    pub(super) contour: ContourModal,
    pub(super) cycle: Option<Defined>,
    pub(super) last_hole: Option<LastHole>,
    pub(super) position: Position,
    /// The plane of G7.
    pub(super) tilted: Option<Box<Tilted>>,
    /// Rotary axes that `G7 L1=1` has turned to zero or not.
    pub(super) unturned: AxisSet,
    /// G141: positions are those of the tip, fixed to the workpiece.
    pub(super) turning: Option<Turning>,
}

/// Groups of the code table with an effect here, in addition to [`Modes`].
pub(super) const GEOMETRY: u8 = 9;
pub(super) const SPINDLE: u8 = 15;
/// Active codes at the start.
const START: &[(u8, u16)] = &[(GEOMETRY, 63), (SPINDLE, 97)];

impl Modal {
    pub(super) fn new(start: Option<AxisVector>, machine: &Machine) -> Modal {
        let control: &Control = &machine.control;
        Modal {
            modes: Modes::new(MotionKind::Rapid, control.initial_plane),
            codes: CodesInForce::new(START),
            positioning_logic: control.grundig.positioning_logic,
            pole: AxisVector::ZERO,
            points: BTreeMap::new(),
            frames: Frames::new(machine),
            tool: ToolState::default(),
            allowance_mm: [0.0; 2],
            tool_reversed: false,
            contour: ContourModal::grundig(control),
            cycle: None,
            last_hole: None,
            position: Position::at_start(start, machine),
            tilted: None,
            unturned: AxisSet::EMPTY,
            turning: None,
        }
    }

    /// Radius of the tool with its allowance, mm.
    pub(super) fn whole_radius_mm(&self) -> f64 {
        self.tool.radius_mm + self.allowance_mm[1]
    }

    /// `true` under G95: feeds are per turn.
    pub(super) fn is_per_turn(&self) -> bool {
        self.modes.feed_unit == FeedUnit::PerTurn
    }

    /// `true` under G96: S is the cutting speed.
    pub(super) fn has_cutting_speed(&self) -> bool {
        self.codes.is(SPINDLE, 96)
    }

    /// `true` under G64: words for the intersection calculation.
    pub(super) fn calculates_geometry(&self) -> bool {
        self.codes.is(GEOMETRY, 64)
    }

    /// The direction of an angle in the working plane: from X (in G19 from Y) counter-clockwise as seen against the tool axis, in G18 towards −Z.
    pub(super) fn direction(&self, degrees: f64) -> AxisVector {
        let (sine, cosine) = (sin_deg(degrees), sin_deg(degrees + 90.0));
        let mut out = AxisVector::ZERO;
        match self.modes.plane {
            Plane::XY => (out.0[0], out.0[1]) = (cosine, sine),
            Plane::ZX => (out.0[0], out.0[2]) = (cosine, -sine),
            Plane::YZ => (out.0[1], out.0[2]) = (cosine, sine),
        }
        out
    }
}

/// `a + factor · b`
pub(super) fn plus(a: &AxisVector, b: &AxisVector, factor: f64) -> AxisVector {
    let mut out = *a;
    out.0.iter_mut().zip(b.0).for_each(|(a, b)| *a += factor * b);
    out
}
