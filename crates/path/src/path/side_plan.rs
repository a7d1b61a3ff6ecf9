//! A way to lead the bodies of axes on a piece, where their motion alone leads them badly.

use ncfix_base::geometry::{AXIS_COUNT, AxisSet};
use ncfix_machine::machine::State;

use super::place::Placed;
use super::segment_candidate::{SAMPLED_SHARE, SegmentFitter};
use super::standing::PathState;

/// A way to lead bodies on a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct SidePlan {
    /// Sides that are tried first, by slot; 0 for an axis whose motion decides.
    pub(super) sides: [i8; AXIS_COUNT],
    /// Axes that keep the command with which the piece begins: their bodies then stay where they are.
    pub(super) held: AxisSet,
    /// Share of the tolerance by which the tip may be off at the start before a step on the spot.
    pub(super) ready_share: f64,
}

impl Default for SidePlan {
    fn default() -> Self {
        SidePlan { sides: [0; AXIS_COUNT], held: AxisSet::EMPTY, ready_share: SAMPLED_SHARE }
    }
}

impl SidePlan {
    /// Sets the directions that the plan states.
    pub(super) fn direct(&self, state: &mut State, standing: &State) {
        for axis in self.held.iter() {
            state.direction[axis.slot()] = standing.direction(axis);
        }
        for (sense, &side) in state.direction.iter_mut().zip(&self.sides) {
            if side != 0 {
                *sense = side;
            }
        }
    }
}

impl SegmentFitter<'_, '_> {
    /// The end of a piece with the words of held axes as at its start, which is a step on the spot or the current position.
    pub(super) fn hold_words(&self, standing: &PathState, start: Option<&Placed>, mut end: Placed) -> Placed {
        for axis in self.plan.held.intersection(standing.written).iter() {
            let slot = axis.slot();
            (end.counts[slot], end.command[axis]) = match start {
                Some(start) => (start.counts[slot], start.command[axis]),
                None => (standing.counts[slot], standing.command[axis]),
            };
        }
        end
    }
}
