//! What stays in force from block to block.

use std::collections::BTreeMap;

use super::defined::Defined;
use super::shifts::Frames;
use crate::exec::core::contour::ContourModal;
use ncfix_base::geometry::{AxisSet, AxisVector, Plane};
use ncfix_base::units::{MM_PER_INCH, sin_deg};
use ncfix_machine::machine::{Control, Machine};

/// The kind of motion that is in force.
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

/// The active tool.
#[derive(Clone, Debug, Default)]
pub(super) struct ActiveTool {
    /// T word that waits for M6, M66 or M67.
    pub(super) selected: Option<f64>,
    /// T word of the tool in the spindle.
    pub(super) number: Option<f64>,
    /// Length in force, mm.
    pub(super) length_mm: f64,
    /// Radius in force, mm.
    pub(super) radius_mm: f64,
    /// Allowances of G39, mm.
    pub(super) allowance_mm: [f64; 2],
    /// G66: the tool points the other way.
    pub(super) reversed: bool,
    /// Whether the tool has no value in the machine file.
    pub(super) assumed: bool,
}

impl ActiveTool {
    /// Radius with its allowance, mm.
    pub(super) fn whole_radius_mm(&self) -> f64 {
        self.radius_mm + self.allowance_mm[1]
    }
}

/// Modal state.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    pub(super) motion: MotionKind,
    pub(super) plane: Plane,
    pub(super) incremental: bool,
    pub(super) inch: bool,
    /// mm/min, mm per turn behind G95; 0 for none yet.
    pub(super) feed: f64,
    /// G95: feeds are per turn.
    pub(super) per_turn: bool,
    /// G96: S is the cutting speed.
    pub(super) constant_cutting_speed: bool,
    /// Last speed of the spindle.
    pub(super) speed: Option<f64>,
    /// Whether rapid moves go to the tool axis and the plane one behind the other.
    pub(super) positioning_logic: bool,
    /// G64: words for the calculation of intersections.
    pub(super) geometry: bool,
    /// The pole of B2, L2, as programmed.
    pub(super) pole: AxisVector,
    pub(super) points: BTreeMap<u32, Point>,
    pub(super) frames: Frames,
    pub(super) tool: ActiveTool,
    pub(super) contour: ContourModal,
    pub(super) cycle: Option<Defined>,
    /// Axis commands, mm and rad.
    pub(super) command: AxisVector,
    /// Axes of the program whose place it has stated.
    pub(super) known: AxisSet,
}

impl Modal {
    pub(super) fn new(start: Option<AxisVector>, machine: &Machine) -> Modal {
        let control: &Control = &machine.control;
        Modal {
            motion: MotionKind::Rapid,
            plane: control.initial_plane,
            incremental: false,
            inch: false,
            feed: 0.0,
            per_turn: false,
            constant_cutting_speed: false,
            speed: None,
            positioning_logic: control.grundig.positioning_logic,
            geometry: false,
            pole: AxisVector::ZERO,
            points: BTreeMap::new(),
            frames: Frames::new(machine),
            tool: ActiveTool::default(),
            contour: ContourModal::grundig(control),
            cycle: None,
            command: start.unwrap_or(AxisVector::ZERO),
            known: if start.is_some() { machine.axis_set() } else { AxisSet::EMPTY },
        }
    }

    /// mm per unit of lengths.
    pub(super) fn scale(&self) -> f64 {
        if self.inch { MM_PER_INCH } else { 1.0 }
    }

    /// The direction of an angle in the working plane: from X (in G19 from Y) counter-clockwise as seen against the tool axis, in G18
    /// towards −Z.
    pub(super) fn direction(&self, degrees: f64) -> AxisVector {
        let (sine, cosine) = (sin_deg(degrees), sin_deg(degrees + 90.0));
        let mut out = AxisVector::ZERO;
        match self.plane {
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
