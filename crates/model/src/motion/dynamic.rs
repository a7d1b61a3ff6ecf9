//! Deflection while an axis accelerates: e = k·a + c·ȧ with the acceleration a and the jerk ȧ of the axis.
//!
//! A frame that gives way follows the force of inertia at once as long as the force changes slowly beside the first natural frequency; the jerk
//! is the first term of what it lags behind. Encoders do not see it (Andolfatto, Lavernhe and Mayer 2011, section 3.4, call what is left beside
//! contouring and quasi-static errors the dynamic geometric error).

use ncfix_base::geometry::Axis;
use ncfix_machine::machine::State;

/// A deflection that goes with the rates of the own axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dynamic {
    /// mm or rad, by mm/s² or rad/s² of the axis.
    pub by_acceleration: f64,
    /// The same by its jerk, mm/s³ or rad/s³.
    pub by_jerk: f64,
}

impl Dynamic {
    /// The value, mm or rad, of a function of `axis`.
    #[must_use]
    pub fn value(&self, axis: Axis, state: &State) -> f64 {
        self.by_acceleration * state.acceleration[axis] + self.by_jerk * state.jerk[axis]
    }
}
