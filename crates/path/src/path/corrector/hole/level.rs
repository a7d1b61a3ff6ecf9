//! The levels of a hole: those at which the tool is before it and after it, and the ways by which it reaches its place.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::snc::{CycleArgument, DrillingCycle, Element, HoleTrigger, Kind, Move};

use super::{Corrector, HoleLine};
use crate::path::segment_candidate::SAME_PLACE_MM;
use crate::path::standing::PathState;
use crate::path::staying::is_better_whole;

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// The shift of R with which it is the level of the tool, increments; `None` if the program has another R, or a call that states no R of its own.
    pub(super) fn level_of(&self, cycle: &DrillingCycle, line: &HoleLine) -> Option<i64> {
        let along = line.axes[2];
        let has_heights = cycle.arguments.iter().any(|argument| matches!(argument, CycleArgument::Height(_)));
        let [nominal_mm, command_mm] =
            [&self.standing.nominal, &self.standing.command].map(|place| self.placer.in_frame(place)[along]);
        let is_there = self.standing.known.contains(along) && (nominal_mm - line.top[along]).abs() <= SAME_PLACE_MM;
        let is_own = cycle.trigger == HoleTrigger::Position && !has_heights;
        (is_own && is_there).then(|| self.placer.increments.count(along, command_mm - line.top[along]))
    }

    /// `true` if the tool leaves the hole with the feed: in some languages to the initial level, in others to R.
    pub(super) fn rises_with_feed(&self, cycle: &DrillingCycle, line: &HoleLine, hole: &[Element]) -> bool {
        let along = line.axes[2];
        let rises = |motion: &Move| {
            let end = self.placer.in_frame(&motion.target)[along];
            !motion.rapid && (end - line.top[along]).abs() <= SAME_PLACE_MM
        };
        let is_up = |element: &Element| matches!(&element.kind, Kind::Move(motion) if rises(motion));
        line.returns && !is_better_whole(cycle) && hole.iter().any(is_up)
    }

    /// The state at the initial level after a hole, if that is the level of R in the program but not in the output.
    pub(super) fn returned(&self, cycle: &DrillingCycle, line: &HoleLine, mut standing: PathState) -> PathState {
        let along = line.axes[2];
        let has_heights = cycle.arguments.iter().any(|argument| matches!(argument, CycleArgument::Height(_)));
        let is_level = (line.initial.nominal_mm - line.top[along]).abs() <= SAME_PLACE_MM;
        if !line.returns || !is_level || has_heights || cycle.trigger != HoleTrigger::Position {
            return standing;
        }
        let mut place = self.placer.in_frame(&standing.command);
        if (place[along] - line.initial.command_mm).abs() <= SAME_PLACE_MM {
            return standing;
        }
        place[along] = line.initial.command_mm;
        let placed = self.placer.round(&self.placer.of_frame(&place), standing.known);
        self.note_difference(&mut standing, &placed);
        (standing.command, standing.counts) = (placed.command, placed.counts);
        standing
    }

    /// The ways across a hole by which the axes with backlash reach it, mm; `None` without such an axis, or without room.
    pub(super) fn brought(&self, cycle: &DrillingCycle, line: &HoleLine, top: &AxisVector) -> Option<[f64; 2]> {
        // A move between modal holes gives them another initial level.
        let level_mm = self.placer.in_frame(&self.standing.nominal)[line.axes[2]];
        let is_modal = cycle.trigger == HoleTrigger::Position;
        if is_modal && (level_mm - line.initial.nominal_mm).abs() > SAME_PLACE_MM {
            return None;
        }
        // In a frame that turns, dead bands of axes do not lie along its coordinates.
        let [abscissa, ordinate, _] = line.axes;
        let mut ways = [0.0; 2];
        for (way_mm, axis) in ways.iter_mut().zip([abscissa, ordinate]) {
            if self.sampler.backlash.contains(axis) {
                let beyond_mm = self.beyond_mm(axis, top);
                let side = [1.0, -1.0].into_iter().find(|side| self.has_room(axis, top[axis], -side * beyond_mm))?;
                *way_mm = side * beyond_mm;
            }
        }
        Some(ways).filter(|ways| *ways != [0.0; 2] && self.placer.is_parallel())
    }
}
