//! Axis vectors, frames, lines and arcs: values that evaluate and split themselves, without knowledge of machines.

mod arc;
mod axes;
mod axis_key;
mod basis;
mod bezier;
mod frame;
mod frame_parts;
mod rotation;
mod spline;

pub use arc::{Arc, CenterFault, Plane};
pub use axes::{AXES, AXIS_COUNT, Axis, AxisSet, AxisVector, LINEAR_AXES, ROTARY_AXES};
pub use axis_key::AxisKey;
pub use basis::PlaneBasis;
pub use bezier::{Bezier, CurveFault, Weighted, weighted};
pub use frame::Frame;
pub use frame_parts::FrameParts;
pub use rotation::{RotationOrder, about, by_solid_angles};
pub use spline::{BSpline, SplineEnd, akima_slopes, cubic_slopes};

/// A vector in space, mm or a direction.
pub type Vector = nalgebra::Vector3<f64>;
/// A 3 × 3 matrix, here always a rotation or a frame's linear part.
pub type Matrix = nalgebra::Matrix3<f64>;
