//! The error model of a machine: forward kinematics with errors, and the commands that cancel them.

pub mod file;
mod forward;
mod inverse;

pub use forward::{Features, Model, Pose, Twist};
pub use inverse::{NotConverged, Solve};

/// The errors of a machine as its file gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorModel {
    /// Position-independent errors.
    pub location: Vec<LocationError>,
    /// Position-dependent errors; entries of one component add up.
    pub motion: Vec<MotionError>,
}

/// A position-independent error.
#[derive(Clone, Debug, PartialEq)]
pub struct LocationError {}

/// A position-dependent error.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionError {}
