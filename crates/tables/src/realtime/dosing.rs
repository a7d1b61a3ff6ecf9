//! Rate limit: the active correction follows its target by at most one dose per cycle (Spaan 1995, Fig. 6.8).

use ncfix_base::geometry::{AXES, AxisSet, AxisVector};

/// The active correction, and its rate limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dosing {
    dose_mm: f64,
    dose_rad: f64,
    in_force: AxisVector,
}

impl Dosing {
    /// Doses per cycle of linear axes, mm, and of rotary axes, rad; [`f64::INFINITY`] for no limit. The first correction starts from zero.
    #[must_use]
    pub fn new(dose_mm: f64, dose_rad: f64) -> Dosing {
        Dosing { dose_mm, dose_rad, in_force: AxisVector::ZERO }
    }

    /// The active correction, mm and rad.
    #[must_use]
    pub fn in_force(&self) -> &AxisVector {
        &self.in_force
    }

    /// Moves towards a target correction. Returns the axes that have not reached it.
    pub(super) fn follow(&mut self, wanted: &AxisVector) -> AxisSet {
        let mut behind = AxisSet::EMPTY;
        for axis in AXES {
            let dose = if axis.is_rotary() { self.dose_rad } else { self.dose_mm };
            let change = wanted[axis] - self.in_force[axis];
            // A rounding error of accumulated doses does not count as a dose.
            if change.abs() <= dose * (1.0 + 1e-9) {
                self.in_force[axis] = wanted[axis];
            } else {
                self.in_force[axis] += dose.copysign(change);
                behind.insert(axis);
            }
        }
        behind
    }

    /// Resets the correction to zero, as when an axis is referenced (Spaan 1995, Fig. 6.2, process 5).
    pub(super) fn reset(&mut self) {
        self.in_force = AxisVector::ZERO;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::Axis;

    #[test]
    fn a_jump_is_taken_in_doses() {
        let mut dosing = Dosing::new(2e-3, 5e-6);
        let mut wanted = AxisVector::ZERO;
        (wanted[Axis::X], wanted[Axis::C]) = (-5e-3, 7e-6);
        let mut steps = Vec::new();
        for _ in 0..4 {
            let behind = dosing.follow(&wanted);
            steps.push((dosing.in_force()[Axis::X], dosing.in_force()[Axis::C], behind.iter().count()));
        }
        assert_eq!(steps, [(-2e-3, 5e-6, 2), (-4e-3, 7e-6, 1), (-5e-3, 7e-6, 0), (-5e-3, 7e-6, 0)]);
    }
}
