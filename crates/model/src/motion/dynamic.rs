//! Deflection while an axis accelerates: e = k·a + c·ȧ with the acceleration a and the jerk ȧ of the axis.
//!
//! A compliant frame follows the inertial force at once as long as the force changes slowly compared with the first natural frequency. The jerk is the first
//! term of its lag. Encoders do not see this deflection. Andolfatto, Lavernhe and Mayer 2011, section 3.4, call the residual of contouring and quasi-static
//! errors the dynamic geometric error.

use ncfix_base::geometry::Axis;
use ncfix_machine::machine::State;

/// Deflection proportional to the rates of its own axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dynamic {
    /// Deflection by acceleration: mm or rad per mm/s² or rad/s² of the axis.
    pub by_acceleration: f64,
    /// Deflection by jerk: mm or rad per mm/s³ or rad/s³ of the axis.
    pub by_jerk: f64,
}

impl Dynamic {
    /// Returns the value of a function of `axis`, mm or rad.
    #[must_use]
    pub fn value(&self, axis: Axis, state: &State) -> f64 {
        self.by_acceleration * state.acceleration[axis] + self.by_jerk * state.jerk[axis]
    }
}
