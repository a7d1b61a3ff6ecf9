//! What changes while a machine runs and the error model may depend on.

use crate::geometry::{AXIS_COUNT, Axis, AxisVector};

/// The state of the machine at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Sense of the last motion of each axis: −1, 0 (none yet) or 1.
    pub direction: [i8; AXIS_COUNT],
}

impl State {
    /// Sense of the last motion of an axis: −1, 0 or 1.
    #[must_use]
    pub fn direction(&self, axis: Axis) -> i8 {
        self.direction[axis.slot()]
    }

    /// Notes a motion; axes that stand still keep the sense of their last motion.
    pub fn note_motion(&mut self, from: &AxisVector, to: &AxisVector) {
        for slot in 0..AXIS_COUNT {
            let step = to.0[slot] - from.0[slot];
            if step > 0.0 {
                self.direction[slot] = 1;
            } else if step < 0.0 {
                self.direction[slot] = -1;
            }
        }
    }
}
