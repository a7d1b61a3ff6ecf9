//! Position-independent errors: where the axes and the spindle are in the machine, in place of where they should be.
//!
//! `EC0Y` is the squareness of Y (its body turned about Z), `EX0C` the offset of the axis C, `EX0S` the offset of the spindle
//! (ISO 230-1, ISO 230-7). They are the displacement D(e0) at the place of the axis, and always that of the moving body, on
//! the workpiece side too.

use super::name::ErrorName;

/// A position-independent error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocationError {
    /// Which.
    pub name: ErrorName,
    /// mm for displacements, rad for rotations.
    pub value: f64,
}
