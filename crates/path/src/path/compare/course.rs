//! What the original does while the corrected program runs a piece.

use super::step::ComparedMove;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::Kinematics;

/// The part of a move that a piece covers.
#[derive(Clone, Copy, Debug)]
pub struct Course<'a> {
    pub(super) step: &'a ComparedMove,
    pub(super) piece: &'a ComparedMove,
    pub(super) kinematics: &'a Kinematics,
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Course<'_> {
    /// Through how much of an arc it leads, rad, never below zero; 0 for a straight line.
    #[must_use]
    pub fn sweep_rad(&self) -> f64 {
        (self.step.route.sweep_rad() * (self.to - self.from)).abs()
    }

    /// The place at a share of it, in the coordinates in which the corrected program writes, mm and rad.
    #[must_use]
    pub fn at(&self, share: f64) -> AxisVector {
        let command = self.step.route.at(self.from + (self.to - self.from) * share);
        self.piece.programmed(&command, self.kinematics)
    }
}
