//! A motion between its block and the stream: what contour transitions and radius compensation may still change.
//!
//! Positions are **base coordinates**: the frame is applied and the tool at its zero pose taken off. Without a transformation these
//! are the axis commands; under a transformation [`super::resolve`] turns them into such.

use std::sync::Arc as Shared;

use ncfix_base::geometry::{AxisSet, AxisVector, PlaneBasis};
use ncfix_base::source::Span;
use ncfix_machine::snc::{Move, Setup};

/// A motion of one block.
#[derive(Clone, Debug)]
pub(in crate::exec) struct Path {
    /// Its target in base coordinates; [`Move::arc`] is not set yet.
    pub(in crate::exec) motion: Move,
    /// Where it starts, base coordinates.
    pub(in crate::exec) start: AxisVector,
    /// Axes whose place there the program has stated.
    pub(in crate::exec) start_known: AxisSet,
    /// The working plane behind the frame.
    pub(in crate::exec) basis: PlaneBasis,
    /// Its way.
    pub(in crate::exec) shape: Shape,
    /// Frame and tool that hold.
    pub(in crate::exec) setup: Shared<Setup>,
    /// Where its block stands.
    pub(in crate::exec) span: Span,
}

/// The way of a motion.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::exec) enum Shape {
    /// Every axis in proportion.
    Line,
    /// An arc of the working plane, the other axes in proportion to the angle.
    Arc {
        /// About the normal of the basis.
        clockwise: bool,
        /// Plane coordinates of the basis.
        center: [f64; 2],
        /// Full turns beyond the arc itself.
        extra_turns: u32,
    },
    /// Straight pieces along a curve, by their ends; the last is the target. Near enough to the curve by
    /// [`ncfix_machine::machine::Control::chord_tolerance_mm`].
    Chords(Vec<AxisVector>),
}
