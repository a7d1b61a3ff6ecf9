//! The path of the tool from hole to hole: positions and actions.

use super::cycles::HoleStep;
use crate::exec::core::step::{Place, Step};

/// Distance below which there is no motion, mm: an active length leaves a rounding error.
const SAME_MM: f64 = 1e-9;

/// The path of the tool.
pub(super) struct Trip<'a> {
    pub(super) here: Place,
    /// `true` if the position is an assumption.
    pub(super) is_lost: bool,
    pub(super) out: &'a mut Vec<Step>,
}

impl Trip<'_> {
    /// Moves to a hole.
    pub(super) fn approach(&mut self, to: Place) {
        if std::mem::take(&mut self.is_lost) {
            self.state(to);
        } else {
            self.rapid(to);
        }
    }

    /// Moves at rapid, even over zero distance.
    pub(super) fn state(&mut self, to: Place) {
        self.out.push(Step::rapid(to));
        self.here = to;
    }

    /// Moves at rapid, if the distance is not zero.
    pub(super) fn rapid(&mut self, to: Place) {
        let steps = [to.plane[0] - self.here.plane[0], to.plane[1] - self.here.plane[1], to.height - self.here.height];
        if steps.iter().any(|step| step.abs() > SAME_MM) {
            self.out.push(Step::rapid(to));
            self.here = to;
        }
    }

    /// Appends the steps of a hole.
    pub(super) fn hole(&mut self, plane: [f64; 2], steps: &[HoleStep]) {
        for step in steps {
            match *step {
                HoleStep::Rapid(height) => self.rapid(Place { height, ..self.here }),
                HoleStep::Feed(height) => {
                    let to = Place { height, ..self.here };
                    if to != self.here {
                        self.out.push(Step::line(to));
                        self.here = to;
                    }
                }
                HoleStep::Aside([a, b]) => {
                    let plane = [plane[0] + a, plane[1] + b];
                    self.rapid(Place { plane, ..self.here });
                }
                HoleStep::Dwell(seconds) => self.out.push(Step::Dwell(seconds)),
                HoleStep::Spindle(turn) => self.out.push(Step::Spindle(turn)),
                HoleStep::Stop => self.out.push(Step::Stop),
                HoleStep::DrawnOut(height) => {
                    self.here.height = height;
                    self.is_lost = true;
                    self.out.push(Step::Brought(self.here));
                }
            }
        }
    }
}
