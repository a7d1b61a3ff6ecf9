//! Axes that a move may move: clamped axes, rotary axes that do not participate, and rapid moves that are not an approach to a cut.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_machine::machine::{Clamp, Machine};
use ncfix_machine::snc::{Element, MotionMode, Move, Word, WordValue};

use super::Corrector;
use crate::path::Rotary;
use crate::path::ahead::Upcoming;
use crate::path::place::SHORT_MM;
use crate::path::treatment::MoveTreatment;

/// The clamps of the axes, and their states (closed or open).
#[derive(Clone, Debug)]
pub(super) struct Clamps {
    all: Vec<(Axis, Clamp, bool)>,
    closed: AxisSet,
}

impl Clamps {
    /// `true` if no axis is clamped.
    pub(super) fn are_open(&self) -> bool {
        self.closed.is_empty()
    }

    /// The clamps of a machine, all open.
    pub(super) fn new(machine: &Machine) -> Clamps {
        let of_axis = |data: &ncfix_machine::machine::AxisData| {
            let axis = data.axis;
            data.clamps.iter().map(move |&clamp| (axis, clamp, false)).collect::<Vec<_>>()
        };
        Clamps { all: machine.axes.iter().flatten().flat_map(of_axis).collect(), closed: AxisSet::EMPTY }
    }

    /// Updates the clamps with M codes.
    pub(super) fn note(&mut self, words: &[Word]) {
        if self.all.is_empty() {
            return;
        }
        for word in words.iter().filter(|word| word.letter == b'M' && word.extension.is_none()) {
            let WordValue::Number(number) = word.value else { continue };
            for (_, clamp, is_closed) in &mut self.all {
                if number == f64::from(clamp.close) {
                    *is_closed = true;
                } else if number == f64::from(clamp.open) {
                    *is_closed = false;
                }
            }
        }
        self.closed = self.all.iter().filter(|(_, _, is_closed)| *is_closed).map(|&(axis, _, _)| axis).collect();
    }
}

/// The rotary axes of a machine.
pub(super) fn rotary_axes(machine: &Machine) -> AxisSet {
    machine.axis_set().iter().filter(|axis| axis.is_rotary()).collect()
}

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Treatment of a rapid move that moves these output axes; `approach` is the treatment if it leads to a cut.
    pub(super) fn treatment_of_rapid(
        &mut self,
        motion: &Move,
        approach: MoveTreatment,
        moving: AxisSet,
    ) -> MoveTreatment {
        if motion.in_machine_frame
            || motion.motion_mode == MotionMode::Reference
            || approach == MoveTreatment::Programmed
        {
            return MoveTreatment::Programmed;
        }
        let next = self.elements.next();
        let is_along_tool = || self.placer.is_along_tool(moving, [&self.standing.nominal, &motion.target]);
        match next {
            next if next.is_cut() => approach,
            Upcoming::Change => MoveTreatment::Programmed,
            _ if is_along_tool() => MoveTreatment::Programmed,
            _ => MoveTreatment::Named,
        }
    }

    /// Fixes axes that the next move must not move: those that are clamped, and rotary axes that do not participate, unless the program moves them.
    pub(super) fn fix(&mut self, motion: &Move, moving: AxisSet) {
        if self.placer.has_rotary {
            let turning = match self.options.rotary {
                Rotary::Auto => self.elements.turned(),
                Rotary::Correct => rotary_axes(self.machine),
                Rotary::Hold => AxisSet::EMPTY,
            };
            self.placer.set_turning(turning.difference(self.clamps.closed));
        } else if self.clamps.closed.is_empty() {
            return;
        }
        let standing = &self.standing;
        let moves = |axis: Axis| (motion.target[axis] - standing.nominal[axis]).abs() > SHORT_MM;
        let stays = |axis: &Axis| {
            let is_clamped = self.clamps.closed.contains(*axis);
            let takes_part = !axis.is_rotary() || self.placer.turning().contains(*axis);
            standing.known.contains(*axis) && !moves(*axis) && (is_clamped || !takes_part && !moving.contains(*axis))
        };
        let fixed = self.machine.axis_set().iter().filter(stays).collect();
        self.placer.fix(fixed, &self.standing.command);
    }
}
