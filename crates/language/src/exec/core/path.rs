//! A motion between its block and the stream: the data that contour transitions and radius compensation may still change.
//!
//! Positions are **base coordinates**: the frame is applied and the tool at its zero pose subtracted. Without a transformation these are the axis
//! commands; under a transformation [`super::resolve`] converts them to axis commands.

use std::sync::Arc as Shared;

use ncfix_base::geometry::{Arc, AxisSet, AxisVector, Matrix, Plane, PlaneBasis};
use ncfix_base::source::Span;
use ncfix_machine::snc::{Move, Setup};

/// A motion of one block.
#[derive(Clone, Debug)]
pub(in crate::exec) struct Path {
    /// Its target in base coordinates; [`Move::arc`] is not set yet.
    pub(in crate::exec) motion: Move,
    /// Its start, base coordinates.
    pub(in crate::exec) start: AxisVector,
    /// Axes whose start position the program has stated.
    pub(in crate::exec) start_known: AxisSet,
    /// The working plane after the frame.
    pub(in crate::exec) basis: PlaneBasis,
    /// Its shape.
    pub(in crate::exec) shape: Shape,
    /// Active frame and tool.
    pub(in crate::exec) setup: Shared<Setup>,
    /// Span of its block.
    pub(in crate::exec) span: Span,
}

/// The shape of a motion.
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
    /// Straight pieces along a curve, by their ends; the last is the target. Their distance from the curve is within
    /// [`ncfix_machine::machine::Control::chord_tolerance_mm`].
    Chords(Vec<AxisVector>),
}

/// An arc of the working plane with the basis of its coordinates.
pub(in crate::exec) fn tilted_arc(
    basis: &PlaneBasis,
    clockwise: bool,
    center_mm: [f64; 2],
    extra_turns: u32,
) -> (Arc, Option<Matrix>) {
    match basis {
        PlaneBasis::Principal(plane) => (Arc { plane: *plane, clockwise, center_mm, extra_turns }, None),
        PlaneBasis::Tilted(columns) => {
            // In plane coordinates the working plane is XY.
            (Arc { plane: Plane::XY, clockwise, center_mm, extra_turns }, Some(*columns))
        }
    }
}
