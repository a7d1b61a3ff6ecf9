//! The positions of the axes, and the axes whose position the program has stated.

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame};
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;

/// The positions of the axes.
#[derive(Clone, Copy, Debug)]
pub(in crate::exec) struct Position {
    /// Axis commands, mm and rad; under a transformation positions fixed to the workpiece.
    pub(in crate::exec) command: AxisVector,
    /// Axes whose position the program has stated, in the active frame.
    pub(in crate::exec) known: AxisSet,
    /// Unknown axes that a probe has stopped: a motion to a stated position would leave the measured place.
    pub(in crate::exec) probed: AxisSet,
}

impl Position {
    /// The state before the first block: given by the caller, or as far as the machine states it.
    pub(in crate::exec) fn at_start(start: Option<AxisVector>, machine: &Machine) -> Self {
        if let Some(command) = start {
            return Position { command, known: machine.axis_set(), probed: AxisSet::EMPTY };
        }
        let mut position = Position { command: AxisVector::ZERO, known: AxisSet::EMPTY, probed: AxisSet::EMPTY };
        for axis in machine.axis_set().iter() {
            if let Some(start_rad) = machine.axis(axis).and_then(|data| data.start_rad) {
                position.command[axis] = start_rad;
                position.known.insert(axis);
            }
        }
        position
    }

    /// Makes the position of axes unknown. Axes that a transformation or frame mixes become unknown together. Returns all unknown axes.
    pub(in crate::exec) fn forget(&mut self, axes: AxisSet, turns: bool, frame: &Frame) -> AxisSet {
        let mut lost = axes;
        if turns {
            lost = AxisSet::ALL;
        } else if !axes.intersection(AxisSet::XYZ).is_empty() && !frame.is_translation() {
            lost = axes.union(AxisSet::XYZ);
        }
        self.known = self.known.difference(lost);
        self.probed = self.probed.difference(lost);
        lost
    }

    /// The fault for an axis whose position the program has not stated.
    pub(in crate::exec) fn unknown(&self, span: Span, axis: Axis) -> Fault {
        let probed = [axis].into_iter().collect::<AxisSet>().intersection(self.probed);
        fault(Code::UNKNOWN_START, span, format!("the position of {axis} is not known yet"), advice(probed))
    }
}

/// The advice if the position of one of these axes is not known, and a probe has stopped `probed`.
pub(in crate::exec) fn advice(probed: AxisSet) -> &'static str {
    if probed.is_empty() { BEGIN_ABSOLUTE } else { MEASURE_APART }
}

/// Advice for an axis of unknown position.
pub(in crate::exec) const BEGIN_ABSOLUTE: &str = "program an absolute position of this axis before it; --start states the position at the beginning only, and a tool change, a reference motion or a program that the control itself executes makes it unknown again";

/// Advice for a position at which only the control knows that it stands: a motion before it would change what is measured or set.
pub(in crate::exec) const MEASURE_APART: &str = "only the control knows this position: measure and set the zero or the length in a program of its own that is not corrected, and remove the blocks from this one; a motion before the block would set another value";

/// The fault for an axis whose position the program has not stated.
pub(in crate::exec) fn unknown_start(span: Span, axis: Axis) -> Fault {
    fault(Code::UNKNOWN_START, span, format!("the position of {axis} is not known yet"), BEGIN_ABSOLUTE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::{AXES, Matrix};

    #[test]
    fn axes_that_are_mixed_are_lost_together() {
        let all = Position { command: AxisVector::ZERO, known: AXES.into_iter().collect(), probed: AxisSet::EMPTY };
        let lost_of = |axis: Axis, turns: bool, frame: &Frame| {
            let mut position = all;
            let lost = position.forget([axis].into_iter().collect(), turns, frame);
            assert_eq!(position.known, all.known.difference(lost));
            lost
        };
        let turned = Frame::rotation(Matrix::new(0.8, -0.6, 0.0, 0.6, 0.8, 0.0, 0.0, 0.0, 1.0));
        assert_eq!(lost_of(Axis::X, false, &Frame::identity()), [Axis::X].into_iter().collect());
        assert_eq!(lost_of(Axis::X, false, &turned), AxisSet::XYZ);
        assert_eq!(lost_of(Axis::B, false, &turned), [Axis::B].into_iter().collect());
        assert_eq!(lost_of(Axis::B, true, &turned), AxisSet::ALL);
    }
}
