//! The part of the original that a piece of the corrected program covers.

use super::step::ComparedMove;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::Kinematics;

/// The part of a move that a piece covers.
#[derive(Clone, Copy, Debug)]
pub struct Course<'a> {
    pub(super) step: &'a ComparedMove<'a>,
    pub(super) piece: &'a ComparedMove<'a>,
    pub(super) kinematics: &'a Kinematics,
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Course<'_> {
    /// Angle swept on an arc, rad, never negative; 0 for a straight line.
    #[must_use]
    pub fn sweep_rad(&self) -> f64 {
        (self.step.route.sweep_rad() * (self.to - self.from)).abs()
    }

    /// The place at a share of the part, in the coordinates of the corrected program, mm and rad.
    #[must_use]
    pub fn at(&self, share: f64) -> AxisVector {
        let command = self.step.route.at(self.from + (self.to - self.from) * share);
        self.piece.programmed(&command, self.kinematics)
    }
}
