//! Correction of the tool axis direction by the rotary axes, damped near a singularity.
//!
//! With Jₒ the 2 × n matrix of the tool axis direction by the rotary commands at the nominal pose, the correction is Δ = Jₒᵀ y, with one component of y per
//! eigenvector of Jₒ Jₒᵀ. y solves
//!
//! ```text
//! r(q + Jₒᵀ y) + λ² y = 0,   λ² = ε² (1 − (s/ε)²)² where the singular value s < ε, else 0
//! ```
//!
//! with r the two components of the actual axis direction. Away from a singularity this is exact. Near one, the tool axis is almost parallel to a rotary
//! axis, and a small tilt would take a large motion. There the damping (Tikhonov) limits the motion and leaves part of the tilt uncorrected. It acts on the
//! whole correction and not on its steps, so the iteration does not undo it gradually.

use ncfix_base::geometry::{Axis, AxisSet, AxisVector, ROTARY_AXES, Vector};

use super::body::Pointer;

/// ε: singular value below which the orientation is damped; 2.9° from the singularity of two crossed rotary axes.
const SINGULAR_LIMIT: f64 = 0.05;
/// Eigenvalue of Jₒ Jₒᵀ below which a start does not determine y.
const BLIND_LIMIT: f64 = 1e-6;
/// Maximum distance of the rotary commands of a start from the nominal ones, rad; a start beyond it is ignored.
const START_LIMIT_RAD: f64 = 0.1;

/// Orientation problem at one nominal pose, split along the eigenvectors of Jₒ Jₒᵀ so that its two rows are decoupled.
#[derive(Clone, Copy, Debug)]
pub(super) struct OrientationProblem {
    rotary: [Axis; 3],
    count: usize,
    /// Eigenvectors in the workpiece frame, perpendicular to the nominal tool axis.
    tangents: [Vector; 2],
    /// Rows of Jₒ along the eigenvectors.
    rows: [[f64; 3]; 2],
    /// s²: eigenvalues.
    gains: [f64; 2],
    /// λ².
    dampings: [f64; 2],
}

impl OrientationProblem {
    /// Sets up the problem at the nominal pose of a machine with these rotary axes.
    pub(super) fn at(target: &Pointer, set: AxisSet) -> OrientationProblem {
        let mut rotary = [Axis::A; 3];
        let mut count = 0;
        for axis in ROTARY_AXES.into_iter().filter(|&axis| set.contains(axis)) {
            rotary[count] = axis;
            count += 1;
        }
        let derivatives = rotary.map(|axis| target.axis_by_command[axis.slot()]);
        let first = target.axis.cross(&Vector::ith(target.axis.iamin(), 1.0)).normalize();
        let second = target.axis.cross(&first);
        let (mut g11, mut g12, mut g22) = (0.0, 0.0, 0.0);
        for derivative in &derivatives[..count] {
            let (along, across) = (first.dot(derivative), second.dot(derivative));
            g11 += along * along;
            g12 += along * across;
            g22 += across * across;
        }
        // Angle that makes the 2 × 2 matrix diagonal.
        let (sine, cosine) = (0.5 * (2.0 * g12).atan2(g11 - g22)).sin_cos();
        let tangents = [first * cosine + second * sine, second * cosine - first * sine];
        // Slots beyond `count` repeat the first axis and must not count.
        let rows = tangents.map(|tangent| {
            let mut row = derivatives.map(|derivative| tangent.dot(&derivative));
            row[count..].fill(0.0);
            row
        });
        let gains = rows.map(|row| row.iter().map(|entry| entry * entry).sum());
        OrientationProblem { rotary, count, tangents, rows, gains, dampings: gains.map(damping) }
    }

    /// Returns the rotary axes.
    pub(super) fn axes(&self) -> &[Axis] {
        &self.rotary[..self.count]
    }

    /// True if a direction in which these axes could rotate the tool is damped. A single rotary axis acts in one direction only; its lack of effect in the
    /// other is not a singularity.
    pub(super) fn is_damped(&self) -> bool {
        let [first, second] = self.gains;
        damping(if self.count > 1 { first.min(second) } else { first.max(second) }) > 0.0
    }

    /// Returns the y that gives the rotary corrections of a start; zero if the start is not usable.
    pub(super) fn dual_of(&self, nominal: &AxisVector, start: &AxisVector) -> [f64; 2] {
        let near = self.axes().iter().all(|&axis| (start[axis] - nominal[axis]).abs() < START_LIMIT_RAD);
        [0, 1].map(|k| {
            if !near || self.gains[k] < BLIND_LIMIT {
                return 0.0;
            }
            let corrections = self.axes().iter().zip(self.rows[k]);
            corrections.map(|(&axis, entry)| entry * (start[axis] - nominal[axis])).sum::<f64>() / self.gains[k]
        })
    }

    /// Sets the rotary commands to nominal + Jₒᵀ y.
    pub(super) fn turn(&self, nominal: &AxisVector, dual: &[f64; 2], command: &mut AxisVector) {
        for (i, &axis) in self.axes().iter().enumerate() {
            command[axis] = nominal[axis] + self.rows[0][i] * dual[0] + self.rows[1][i] * dual[1];
        }
    }

    /// Returns the step of y, and the resulting rotation of the tool axis, rad.
    pub(super) fn step(&self, axis: &Vector, dual: &[f64; 2]) -> ([f64; 2], f64) {
        let step = [0, 1].map(|k| {
            let remainder = self.tangents[k].dot(axis) + self.dampings[k] * dual[k];
            -remainder / (self.gains[k] + self.dampings[k])
        });
        (step, (step[0] * self.gains[0]).hypot(step[1] * self.gains[1]))
    }
}

/// Returns λ² for an eigenvalue s²: zero from ε on, ε² at the singularity, with a continuous derivative between.
fn damping(gain: f64) -> f64 {
    let limit = SINGULAR_LIMIT * SINGULAR_LIMIT;
    if gain >= limit { 0.0 } else { limit * (1.0 - gain / limit).powi(2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_ends_smoothly() {
        let limit = SINGULAR_LIMIT * SINGULAR_LIMIT;
        assert_eq!(damping(0.0), limit);
        assert_eq!(damping(limit), 0.0);
        assert!(damping(limit * (1.0 - 1e-6)) < 1e-11 * limit);
        // The sum in the denominator is never less than three quarters of ε²: 1 − x + x² at x = 1/2.
        for tenth in 0..=10 {
            let gain = limit * f64::from(tenth) / 10.0;
            assert!(gain + damping(gain) >= 0.75 * limit * (1.0 - 1e-12));
        }
    }

    /// Without damping, two axes can rotate the tool to any direction that a small correction of theirs reaches.
    #[test]
    fn a_start_is_found_again() {
        let mut target = Pointer::new(Vector::zeros(), Vector::z());
        target.axis_by_command[Axis::A.slot()] = Vector::new(0.0, -1.0, 0.0);
        target.axis_by_command[Axis::C.slot()] = Vector::new(0.75_f64.sqrt(), 0.3, 0.0);
        let orientation = OrientationProblem::at(&target, [Axis::A, Axis::C].into_iter().collect());
        let mut nominal = AxisVector::ZERO;
        (nominal[Axis::A], nominal[Axis::C]) = (1.2, -0.4);
        let mut start = nominal;
        (start[Axis::A], start[Axis::C]) = (1.2 + 0.03, -0.4 - 0.05);
        let mut command = nominal;
        orientation.turn(&nominal, &orientation.dual_of(&nominal, &start), &mut command);
        assert!((command - start).max_abs(&[Axis::A, Axis::C]) < 1e-14);
        // A start more than 0.1 rad away is ignored.
        start[Axis::C] = -0.4 - 0.11;
        assert_eq!(orientation.dual_of(&nominal, &start), [0.0; 2]);
    }
}
