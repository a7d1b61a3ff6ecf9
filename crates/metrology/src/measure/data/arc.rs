//! Directions of approach on the circles of a ball-bar: those of the tangent in each row.
//!
//! The last change of position is the chord from the row before. In the first row after a reversal this chord may still have the old direction, although the
//! axis has reversed between the two rows. The backlash would then have the wrong sign in this row, like a spike at the reversal.

use std::collections::HashSet;

use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::machine::Machine;

use super::DataSet;
use crate::measure::circles::circles;
use crate::measure::kind::Measurand;

/// An axis turns in a row if its speed is at most this share of the fastest axis: rounded positions do not determine the direction there.
const TURNING: f64 = 1e-3;
/// Number of rows that determine a tangent.
const ROWS: usize = 3;

/// Sets the directions of the axes on circles. `is_stated` is true for an axis whose directions the table states.
pub(super) fn along_circles(machine: &Machine, data: &mut DataSet, is_stated: impl Fn(Axis) -> bool) {
    if data.kind.measurand != Measurand::BallDistance {
        return;
    }
    let axes: Vec<Axis> = AXES.into_iter().filter(|axis| machine.axis(*axis).is_some() && !is_stated(*axis)).collect();
    // A row between two circles belongs to the end of the first.
    let mut known: HashSet<usize> = HashSet::new();
    for circle in circles(machine, data) {
        let angles = unwrapped(circle.rows.iter().map(|(_, angle)| *angle));
        let sense = if circle.is_counterclockwise { 1.0 } else { -1.0 };
        for (k, (row, _)) in circle.rows.iter().enumerate() {
            let first = k.saturating_sub(1).min(angles.len().saturating_sub(ROWS));
            let (Some(at), true) = (angles.get(first..first + ROWS), known.insert(*row)) else { continue };
            let weights = derivative(at, k - first);
            let speed = |axis: Axis| -> f64 {
                let near = circle.rows.iter().skip(first).filter_map(|(row, _)| data.observations.get(*row));
                near.zip(weights).map(|(own, weight)| weight * own.reading.position[axis]).sum::<f64>() * sense
            };
            let speeds: Vec<f64> = axes.iter().map(|axis| speed(*axis)).collect();
            let fastest = speeds.iter().fold(0.0_f64, |most, speed| most.max(speed.abs()));
            // At an end of the circle, the error of the tangent is of third order in the step.
            let step = (at[ROWS - 1] - at[0]).abs() / (ROWS - 1) as f64;
            let least = if k == first + 1 { TURNING } else { TURNING + step.powi(3) };
            let Some(observation) = data.observations.get_mut(*row) else { continue };
            for (axis, speed) in axes.iter().zip(speeds).filter(|(_, speed)| speed.abs() > least * fastest) {
                observation.reading.state.direction[axis.slot()] = if speed > 0.0 { 1 } else { -1 };
            }
        }
    }
}

/// Angles without jumps of a full turn, rad.
fn unwrapped(angles: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::new();
    for angle in angles {
        let last = out.last().copied().unwrap_or(angle);
        let step = angle - last;
        out.push(last + step.sin().atan2(step.cos()));
    }
    out
}

/// Weights of three values in the derivative, at one of them, of the parabola through them.
fn derivative(at: &[f64], place: usize) -> [f64; ROWS] {
    let mut out = [0.0; ROWS];
    let own = at[place];
    for (k, weight) in out.iter_mut().enumerate() {
        let [one, other] = [at[(k + 1) % ROWS], at[(k + 2) % ROWS]];
        *weight = (2.0 * own - one - other) / ((at[k] - one) * (at[k] - other));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_derivative_of_a_parabola_is_exact() {
        // 2 a² − 3 a + 1 has the derivative 4 a − 3.
        let at = [0.1, 0.4, 1.0];
        let values = at.map(|a| 2.0 * a * a - 3.0 * a + 1.0);
        for (place, a) in at.into_iter().enumerate() {
            let found: f64 = derivative(&at, place).iter().zip(values).map(|(weight, value)| weight * value).sum();
            assert!((found - (4.0 * a - 3.0)).abs() < 1e-12, "{found}");
        }
    }

    #[test]
    fn angles_go_on_across_a_full_turn() {
        let degrees = [170.0_f64, -170.0, -150.0].map(f64::to_radians);
        let found: Vec<f64> = unwrapped(degrees.into_iter()).into_iter().map(f64::to_degrees).collect();
        for (found, expected) in found.iter().zip([170.0, 190.0, 210.0]) {
            assert!((found - expected).abs() < 1e-9, "{found}");
        }
    }
}
