//! Simulates a program at its feed: the set-points over time, the axis positions, and the distance of the tool from its path.
//!
//! ```text
//! moves ─▶ chords ─▶ speeds (look-ahead) ─▶ positions by cycles ─▶ smoothing ─▶ loops of the axes ─▶ distance from the path
//! ```
//!
//! - `chord`: lines and arcs become straight pieces, with the speed and acceleration limits of the axes along each.
//! - `plan`: the speed at every corner and the trapezoids between them, over a bounded look-ahead.
//! - `smoothing`: two box filters in series, a triangular kernel of the length T. A step dv of the velocity of an axis becomes a ramp; the corner is
//!   rounded by dv T/12, with an acceleration of 2 dv/T and a jerk of 4 dv/T².
//! - `response`: the position loop of each axis, x′ = K (s − x) + f s′ after a dead time.
//! - `contour`: the distance of the tool from its path in the workpiece, at right angles.
//!
//! The set-points of a real control differ in detail; the path depends on the speed at corners and on the difference in lag between axes. The
//! contouring error is that of L. Andolfatto, S. Lavernhe and J. R. R. Mayer (International Journal of Machine Tools and Manufacture 51 (2011)
//! 787–796). Deflection under acceleration (`[[dynamic]]`) is added to it. Units: mm, rad, s.

mod chord;
mod contour;
mod drive;
mod follow;
mod group;
mod limit;
mod plan;
mod response;
mod run;
mod smoothing;

pub use chord::{MoveSpeed, ServoMove, SpaceCircle};
pub use contour::OnPath;
pub use drive::Drive;
pub use follow::CycleState;
pub use limit::{Limited, Limiter};
pub use run::{Run, Tally};
