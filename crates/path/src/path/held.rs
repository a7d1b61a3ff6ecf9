//! Axes at rest that the corrections of other axes would reverse repeatedly within their backlash.

use ncfix_base::geometry::{Axis, AxisSet, AxisVector};
use ncfix_machine::machine::State;

use super::place::Placed;
use super::route::distance_mm;
use super::segment_candidate::{PieceEnds, SAME_PLACE_MM, SAMPLED_SHARE, SegmentFitter};
use super::standing::PathState;

impl SegmentFitter<'_, '_> {
    /// The ends for an axis that the program does not move and that the errors of the others push one way: it is held through the piece. Its error is
    /// then the change of its correction along the piece instead of its backlash. It is held on the side of a step on the spot, or else at its
    /// current position. `None` if the program moves all such axes.
    pub(super) fn held(
        &self,
        standing: &PathState,
        between: [f64; 2],
        (state, sense): (&State, &State),
        is_arc: bool,
    ) -> Option<PieceEnds> {
        let nominal = between.map(|parameter| self.route.at(parameter));
        let undecided = self.sampler.backlash.iter().filter(|&axis| state.direction(axis) != sense.direction(axis));
        let held: AxisSet = undecided.filter(|&axis| nominal[0][axis] == nominal[1][axis]).collect();
        if held.is_empty() {
            return None;
        }
        let hold = |placed: Placed, at: &AxisVector, nominal: &AxisVector, sense: &State| {
            let mut command = placed.command;
            let Placed { mut failure, is_held_back, .. } = placed;
            if held.iter().any(Axis::is_rotary) {
                // The linear axes compensate the error of the rotary axes.
                held.iter().filter(|axis| axis.is_rotary()).for_each(|axis| command[axis] = at[axis]);
                match self.placer.around(nominal, self.known, sense, &command) {
                    Ok(around) => command = around,
                    Err(found) => failure = Some(found),
                }
            }
            held.iter().for_each(|axis| command[axis] = at[axis]);
            self.unmoved(standing, Placed { failure, is_held_back, ..self.placer.round(&command, self.known) })
        };
        let mut at_rest = *state;
        held.iter().for_each(|axis| at_rest.direction[axis.slot()] = standing.state.direction(axis));
        let mut ends = None;
        for (sense, moves) in [(sense, true), (state, true), (&at_rest, false)] {
            let place = |nominal, correction: &AxisVector| self.place(between, nominal, sense, correction);
            let mut take_up = None;
            if self.takes_up
                && (standing.is_doubtful || !self.same_sense(sense, &standing.state))
                && self.turning_mm(standing, &nominal[0], sense) > SAMPLED_SHARE * self.tolerance_mm
            {
                let free = place(&nominal[0], &standing.correction);
                let start = if moves { free } else { hold(free, &standing.command, &nominal[0], sense) };
                take_up = Some(start).filter(|start| distance_mm(&start.command, &standing.command) > SAME_PLACE_MM);
            }
            let ready = take_up.and_then(|start| self.ready(standing, &start, sense));
            let start = take_up.map_or(standing.command, |placed| placed.command);
            let correction = take_up.map_or(standing.correction, |placed| placed.command - nominal[0]);
            let end = hold(place(&nominal[1], &correction), &start, &nominal[1], sense);
            let first = ready.map_or(standing.command, |placed| placed.command);
            let state = self.led(standing, &[standing.command, first, start, end.command], is_arc);
            let is_found = self.same_sense(&state, sense);
            let begins_off = take_up.is_none() && (standing.is_doubtful || !self.same_sense(&state, &standing.state));
            let sense = state.direction;
            ends = Some(PieceEnds { ready, take_up, start, end, sense, is_torn: true, begins_off });
            if is_found {
                break;
            }
        }
        ends
    }
}
