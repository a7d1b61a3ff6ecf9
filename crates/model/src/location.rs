//! Position-independent errors: deviations of the axes and the spindle from their nominal locations in the machine.
//!
//! `EC0Y` is the squareness of Y (its body rotated about Z), `EX0C` the offset of the axis C, `EX0S` the offset of the spindle (ISO 230-1, ISO 230-7). They
//! are the displacement D(e0) at the place of the axis, always of the moving body, on the workpiece side, too.

use super::name::ErrorName;

/// Position-independent error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocationError {
    /// Name.
    pub name: ErrorName,
    /// Value, mm for displacements, rad for rotations.
    pub value: f64,
}
