//! Measurement mode: the nominal tool position from the axis positions (Esmaeili 2021, eq. 33).
//!
//! A machine at the axis positions q has its tool where an error-free machine has it at q′, and q is the corrected q′: q = q′ + Δq(q′). Eq. 33 uses
//! Δq at q instead, which neglects the change of Δq over itself, a second-order error. Here q′ is iterated until its correction gives q, with the
//! function that corrects programs.

use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_model::{Model, NotConverged, Solve};

use super::reading::Reading;

/// Convergence limit of q′: distance of its correction from the reading, mm.
const SAME_MM: f64 = 1e-10;
/// Promised accuracy, mm.
const PROMISED_MM: f64 = 1e-6;
/// Arm for comparing rotary axes with lengths.
const ROTARY_ARM_MM: f64 = 1000.0;
/// Maximum number of iterations. Corrections of 0.1 mm that change by 1e-3 of themselves need three; near a singularity of the rotary axes more.
const MAX_STEPS: usize = 60;

/// The position whose correction is the reading: with [`Solve::Full`] of all axes, with [`Solve::PositionOnly`] of the linear ones.
///
/// # Errors
/// [`NotConverged`] if the tip cannot be brought to its place, or no position is corrected to the reading.
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
            // If the correction changes faster than the position, as near a pole, full steps diverge.
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
