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
    /// Axes that a tool change has made unknown.
    by_change: AxisSet,
    /// Axes along which the tool length has changed without a motion.
    by_length: AxisSet,
    /// `true` if parameter 5006 of a Fanuc decides about these.
    has_parameter: bool,
}

impl Position {
    const NOWHERE: Position = Position {
        command: AxisVector::ZERO,
        known: AxisSet::EMPTY,
        probed: AxisSet::EMPTY,
        by_change: AxisSet::EMPTY,
        by_length: AxisSet::EMPTY,
        has_parameter: true,
    };

    /// The state before the first block: given by the caller, or as far as the machine states it.
    pub(in crate::exec) fn at_start(start: Option<AxisVector>, machine: &Machine) -> Self {
        if let Some(command) = start {
            return Position { command, known: machine.axis_set(), ..Position::NOWHERE };
        }
        let mut position = Position::NOWHERE;
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
        self.by_change = self.by_change.difference(lost);
        self.by_length = self.by_length.difference(lost);
        lost
    }

    /// Makes all positions unknown: a tool change may have moved the axes.
    pub(in crate::exec) fn forget_by_change(&mut self) {
        // Axes that nothing has stated were not known without the change either.
        self.by_change = self.by_change.union(self.known);
        (self.known, self.by_length, self.probed) = (AxisSet::EMPTY, AxisSet::EMPTY, AxisSet::EMPTY);
    }

    /// Makes axes unknown along which the length of the tool has changed without a motion. With `has_parameter`, a parameter of a Fanuc decides whether they
    /// have moved.
    pub(in crate::exec) fn forget_by_length(&mut self, axes: AxisSet, has_parameter: bool) {
        self.has_parameter = has_parameter;
        let lost = axes.intersection(self.known);
        self.known = self.known.difference(lost);
        self.by_change = self.by_change.difference(lost);
        self.by_length = self.by_length.union(lost);
    }

    /// Leaves only these positions known.
    pub(in crate::exec) fn keep(&mut self, known: AxisSet) {
        let lost = self.known.difference(known);
        self.known = known;
        self.by_change = self.by_change.difference(lost);
        self.by_length = self.by_length.difference(lost);
    }

    /// The advice for an axis of unknown position, by the reason.
    pub(in crate::exec) fn advice(&self, axis: Axis) -> &'static str {
        match () {
            () if self.probed.contains(axis) => MEASURE_APART,
            () if self.by_change.contains(axis) => AFTER_CHANGE,
            () => BEGIN_ABSOLUTE,
        }
    }

    /// The fault for an axis whose position the program has not stated.
    pub(in crate::exec) fn unknown(&self, span: Span, axis: Axis) -> Fault {
        if self.by_length.contains(axis) {
            let message = format!(
                "the position of {axis} is not known: the tool length has changed along it, and the control decides whether {axis} has followed"
            );
            let parameter = if self.has_parameter { "; the parameter of a Fanuc is 5006, bit 6 (TOS)" } else { "" };
            let help = format!("program an absolute position of {axis} with G43 or after it{parameter}");
            return fault(Code::UNKNOWN_START, span, message, help);
        }
        fault(Code::UNKNOWN_START, span, format!("the position of {axis} is not known yet"), self.advice(axis))
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

/// Advice for an axis that a tool change has made unknown.
const AFTER_CHANGE: &str = "the tool change before it may have moved the axes: program an absolute position of this axis after it; if the change moves no axis, state it in the machine file: [[opaque]] with name = \"M6\" and moves = false";

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::{AXES, Matrix};

    #[test]
    fn the_advice_names_a_tool_change_only_for_axes_that_were_known() {
        let mut position = Position { known: AxisSet::XYZ, ..Position::NOWHERE };
        position.forget_by_change();
        assert!(position.advice(Axis::Z).contains("M6"));
        assert_eq!(position.advice(Axis::A), BEGIN_ABSOLUTE);
        // Stated again, and lost for another reason.
        position.known = AxisSet::XYZ;
        position.keep(AxisSet::EMPTY);
        assert_eq!(position.advice(Axis::Z), BEGIN_ABSOLUTE);
    }

    #[test]
    fn axes_that_are_mixed_are_lost_together() {
        let all = Position { known: AXES.into_iter().collect(), ..Position::NOWHERE };
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
