//! Position-independent errors: where the axes and the spindle are in the machine, in place of where they should be.
//!
//! `EC0Y` is the squareness of Y (its body turned about Z), `EX0C` the offset of the axis C, `EX0S` the offset of the spindle
//! (ISO 230-1, ISO 230-7). They are the displacement D(e0) at the place of the axis, and always that of the moving body, on
//! the workpiece side too.

use super::name::{Carrier, ErrorName};

/// A position-independent error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocationError {
    /// Which.
    pub name: ErrorName,
    /// mm for displacements, rad for rotations.
    pub value: f64,
}

/// EX0 EY0 EZ0 (mm) and EA0 EB0 EC0 (rad) of one axis or of the spindle; entries of one component add up.
pub(super) fn components(errors: &[LocationError], carrier: Carrier) -> [f64; 6] {
    let mut components = [0.0; 6];
    for error in errors.iter().filter(|error| error.name.carrier == carrier) {
        components[error.name.direction.index()] += error.value;
    }
    components
}
