//! The error model of a machine: forward kinematics with errors, and the commands that cancel them.
//!
//! [`ErrorModel`] is what the file says: location errors ([`location`]) and motion errors ([`motion`], one file per kind of
//! function), named as in ISO 230-1 ([`name`]). [`Model`] is machine and errors prepared for evaluation; [`Model::actual`] is the only
//! forward function, and [`Model::solve`] inverts it. Nothing here knows of programs or instruments.

mod body;
mod features;
pub mod file;
mod forward;
mod inverse;
mod linear;
mod link;
pub mod location;
pub mod motion;
pub mod name;
mod orientation;
mod rotation;

pub use body::Pose;
pub use features::Features;
pub use forward::{Model, Twist};
pub use inverse::{NotConverged, Solve};
pub use location::LocationError;
pub use motion::MotionError;
pub use name::ErrorName;

/// The errors of a machine as its file gives them, in mm and rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorModel {
    /// Position-independent errors.
    pub location: Vec<LocationError>,
    /// Position-dependent errors; entries of one component add up.
    pub motion: Vec<MotionError>,
}
