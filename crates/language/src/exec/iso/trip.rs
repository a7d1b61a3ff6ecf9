//! The way of the tool from hole to hole: places, and what is to be done at them.

use super::cycles::{Step, Turn};

/// A place: in the plane, and along the tool axis; program coordinates, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Place {
    /// Along abscissa and ordinate.
    pub(super) plane: [f64; 2],
    /// Along the tool axis.
    pub(super) height: f64,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Action {
    /// To a place at rapid.
    Rapid(Place),
    /// To a place with feed.
    Feed(Place),
    /// Dwell, s.
    Dwell(f64),
    /// The spindle.
    Spindle(Turn),
    /// M0.
    Stop,
    /// Something else has brought the tool to a place.
    Brought(Place),
}

/// The way of the tool.
pub(super) struct Trip<'a> {
    pub(super) here: Place,
    /// Whether that is an assumption.
    pub(super) is_lost: bool,
    pub(super) out: &'a mut Vec<Action>,
}

impl Trip<'_> {
    /// To a hole.
    pub(super) fn approach(&mut self, to: Place) {
        if std::mem::take(&mut self.is_lost) {
            self.state(to);
        } else {
            self.rapid(to);
        }
    }

    /// At rapid, whether that looks like a way or not.
    pub(super) fn state(&mut self, to: Place) {
        self.out.push(Action::Rapid(to));
        self.here = to;
    }

    /// At rapid, where that is a way.
    pub(super) fn rapid(&mut self, to: Place) {
        if to != self.here {
            self.out.push(Action::Rapid(to));
            self.here = to;
        }
    }

    /// The steps of a hole.
    pub(super) fn hole(&mut self, plane: [f64; 2], steps: &[Step]) {
        for step in steps {
            match *step {
                Step::Rapid(height) => self.rapid(Place { height, ..self.here }),
                Step::Feed(height) => {
                    let to = Place { height, ..self.here };
                    if to != self.here {
                        self.out.push(Action::Feed(to));
                        self.here = to;
                    }
                }
                Step::Aside([a, b]) => {
                    let plane = [plane[0] + a, plane[1] + b];
                    self.rapid(Place { plane, ..self.here });
                }
                Step::Dwell(seconds) => self.out.push(Action::Dwell(seconds)),
                Step::Spindle(turn) => self.out.push(Action::Spindle(turn)),
                Step::Stop => self.out.push(Action::Stop),
                Step::DrawnOut(height) => {
                    self.here.height = height;
                    self.is_lost = true;
                    self.out.push(Action::Brought(self.here));
                }
            }
        }
    }
}
