//! Axis vectors, frames, lines and arcs: values with their evaluation and subdivision, independent of machines.

mod arc;
mod axes;
mod basis;
mod bezier;
mod frame;
mod frame_parts;
mod rotation;
mod spline;

pub use arc::{Arc, CenterFault, Plane};
pub use axes::{AXES, AXIS_COUNT, Axis, AxisKey, AxisSet, AxisVector, LINEAR_AXES, ROTARY_AXES};
pub use basis::PlaneBasis;
pub use bezier::{Bezier, CurveFault, Weighted, weighted};
pub use frame::Frame;
pub use frame_parts::FrameParts;
pub use rotation::{RotationOrder, about, by_solid_angles};
pub use spline::{BSpline, SplineEnd, akima_slopes, cubic_slopes};

/// Vector in space, mm or a direction.
pub type Vector = nalgebra::Vector3<f64>;
/// 3 × 3 matrix, here always a rotation or the linear part of a frame.
pub type Matrix = nalgebra::Matrix3<f64>;
