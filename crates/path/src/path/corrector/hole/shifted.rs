//! The places of the moves of a hole with a shift, and the state of the machine there.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::snc::{Element, Move};

use super::{Corrector, HoleLine, HoleShift, before_hole};
use crate::path::place::Placed;
use crate::path::segment_candidate::SAME_PLACE_MM;
use crate::path::standing::PathState;

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// The state at the reference plane of the call: a tool at that of another hole moves by the difference first.
    pub(super) fn leveled(&self, line: &HoleLine, shift: &HoleShift, mut standing: PathState) -> PathState {
        let along = line.axes[2];
        let mut place = self.placer.in_frame(&standing.command);
        place[along] = line.top[along] + self.placer.increments.position(along, shift.top);
        let placed = self.placer.round(&self.placer.of_frame(&place), standing.known);
        self.note_difference(&mut standing, &placed);
        (standing.command, standing.counts) = (placed.command, placed.counts);
        standing
    }

    /// The state at the position of the call: a tool that is at the programmed place moves by the difference first.
    pub(super) fn positioned(&self, line: &HoleLine, shift: &HoleShift, mut standing: PathState) -> PathState {
        let Some(plane) = shift.plane else { return standing };
        if shift.brought != [0.0; 2] {
            standing = self.at_shift(line, before_hole(plane, shift.brought), standing);
        }
        if line.has_approach { standing } else { self.at_shift(line, plane, standing) }
    }

    /// The state after a move to the place of a hole with a shift, at the height of the tool.
    pub(super) fn at_shift(&self, line: &HoleLine, plane: [f64; 2], mut standing: PathState) -> PathState {
        let mut place = self.placer.in_frame(&standing.command);
        for (axis, shift_mm) in line.axes.into_iter().zip(plane) {
            place[axis] = line.top[axis] + shift_mm;
        }
        standing.known = standing.known.union(line.axes.into_iter().take(2).collect());
        let placed = self.placer.round(&self.placer.of_frame(&place), standing.known);
        self.note_difference(&mut standing, &placed);
        if self.placer.is_parallel() {
            standing.sensed = standing.sensed.union(standing.known);
        }
        (standing.command, standing.counts) = (placed.command, placed.counts);
        standing
    }

    /// Notes the motion by the difference of two corrections: its directions, and where the axes are within their dead bands.
    pub(super) fn note_difference(&self, standing: &mut PathState, placed: &Placed) {
        standing.state.note_motion(&standing.command, &placed.command);
        let route = self.placer.emitted(standing.command, placed.command);
        self.lead.along(&mut standing.band, &route, standing.sensed, [0.0, 1.0]);
    }

    /// The end of a move of a hole, shifted.
    pub(super) fn shifted(&self, line: &HoleLine, shift: &HoleShift, motion: &Move, standing: &PathState) -> Placed {
        let [abscissa, ordinate, along] = line.axes;
        let [target, nominal, from] =
            [&motion.target, &standing.nominal, &standing.command].map(|command| self.placer.in_frame(command));
        let mut place = target;
        let keeps = |axis: Axis| (target[axis] - nominal[axis]).abs() <= SAME_PLACE_MM;
        let stays_across = keeps(abscissa) && keeps(ordinate);
        for axis in AXES {
            if axis != abscissa && axis != ordinate && standing.known.contains(axis) && keeps(axis) {
                place[axis] = from[axis];
            }
        }
        for (index, axis) in [abscissa, ordinate].into_iter().enumerate() {
            match shift.plane {
                Some(plane) if !stays_across => place[axis] += plane[index],
                _ => place[axis] += from[axis] - nominal[axis],
            }
        }
        if !keeps(along) || !standing.known.contains(along) {
            let is_at_top = |height_mm: f64| (height_mm - line.top[along]).abs() <= SAME_PLACE_MM;
            let is_level = |height_mm: f64| (height_mm - line.initial.nominal_mm).abs() <= SAME_PLACE_MM;
            let is_initial = line.returns && is_level(target[along]) && !is_level(line.top[along]);
            if is_initial {
                place[along] = line.initial.command_mm;
            } else {
                let count = if is_at_top(target[along]) { shift.top } else { shift.along };
                place[along] += self.placer.increments.position(along, count);
            }
        }
        self.placer.round(&self.placer.of_frame(&place), motion.known)
    }
}
