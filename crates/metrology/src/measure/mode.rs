//! Measurement mode: where the tool was nominally, from what the axes read (Esmaeili 2021, eq. 33).
//!
//! A machine that reads q has its tool where a machine without errors has it at q′, and q is what the correction makes of q′:
//! q = q′ + Δq(q′). Eq. 33 takes Δq at q instead, which leaves the change of Δq over itself, a second-order error; here q′ is
//! iterated until correcting it gives q, by the same function that corrects programs.

use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_model::{Model, NotConverged, Solve};

use super::reading::Reading;

/// q′ is found when correcting it gives the reading to this, mm.
const SAME_MM: f64 = 1e-10;
/// What is promised, mm.
const PROMISED_MM: f64 = 1e-6;
/// The arm at which rotary axes are judged.
const ROTARY_ARM_MM: f64 = 1000.0;
/// Corrections of 0.1 mm that change by 1e-3 of themselves need three steps; near a singularity of the rotary axes more.
const MAX_STEPS: usize = 60;

/// The position whose correction is the reading: with [`Solve::Full`] of all axes, with [`Solve::PositionOnly`] of the linear ones.
///
/// # Errors
/// [`NotConverged`] where the tip cannot be brought to its place, or no position is corrected to the reading.
pub fn nominal(model: &Model, reading: &Reading, mode: Solve) -> Result<AxisVector, NotConverged> {
    let read = &reading.position;
    let mut nominal = *read;
    let mut best = (f64::INFINITY, nominal);
    let mut damping = 1.0;
    for _ in 0..MAX_STEPS {
        let start = if mode == Solve::PositionOnly { *read } else { nominal };
        let command = model.solve(&nominal, &reading.tool_mm, &reading.state, &start, mode)?;
        let left = *read - command;
        let size = AXES.into_iter().map(|axis| left[axis].abs() * if axis.is_rotary() { ROTARY_ARM_MM } else { 1.0 });
        let size = size.fold(0.0, f64::max);
        if !size.is_finite() {
            return Err(NotConverged { residual_mm: f64::NAN });
        }
        if size < best.0 {
            best = (size, nominal);
        } else {
            // Where the correction changes faster than the position, as next to a pole, whole steps go astray.
            damping = f64::max(damping / 2.0, 1.0 / 16.0);
        }
        if size < SAME_MM {
            break;
        }
        for axis in AXES {
            nominal[axis] += left[axis] * damping;
        }
    }
    let (residual_mm, nominal) = best;
    if residual_mm < PROMISED_MM { Ok(nominal) } else { Err(NotConverged { residual_mm }) }
}
