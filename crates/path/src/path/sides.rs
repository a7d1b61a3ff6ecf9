//! The sides of their dead bands on which axis bodies are before and after a piece.

use ncfix_base::geometry::{Axis, AxisSet, AxisVector};
use ncfix_machine::machine::State;

use super::place::Placed;
use super::route::Route;
use super::segment_candidate::{SegmentCandidate, SegmentFitter};
use super::standing::PathState;

impl SegmentFitter<'_, '_> {
    /// The largest distance of the tip from its place while axes change to these directions, mm. Their bodies leave the dead bands one after the
    /// other, in any order.
    pub(super) fn turning_mm(&self, standing: &PathState, nominal: &AxisVector, sense: &State) -> f64 {
        let error_mm = |state: &State| self.placer.tip_error_mm(nominal, &standing.command, state);
        let lags = |axis: &Axis| {
            standing.state.direction(*axis) != sense.direction(*axis) && !self.lead.is_quick(*axis, &standing.command)
        };
        let turning: AxisSet = self.lead.axes.iter().filter(lags).collect();
        let mut most_mm = error_mm(sense);
        // The state with all of them is included; the state with none is the current one.
        for waiting in 1..(1_u32 << turning.iter().count()).saturating_sub(1) {
            let mut state = *sense;
            for (_, axis) in turning.iter().enumerate().filter(|(k, _)| (waiting >> k) & 1 == 1) {
                state.direction[axis.slot()] = standing.state.direction(axis);
            }
            most_mm = most_mm.max(error_mm(&state));
        }
        most_mm
    }

    /// `true` if a step to `start` would only move the tool further in its old direction: the control adds more at a reversal than the axis loses, so the
    /// body goes on until the axis reverses. Without the step, the tool is ahead on its path, and across it off by at most `enough_mm`.
    pub(super) fn leads_away(
        &self,
        standing: &PathState,
        (start, parameter): (&Placed, f64),
        sense: &State,
        enough_mm: f64,
    ) -> bool {
        let leads = self.is_pushed(standing, start, sense);
        let tool_mm = &self.placer.setup.tool_mm;
        leads
            && self.lead.direction(self.route, parameter, tool_mm).is_some_and(|along| {
                let nominal = self.route.at(parameter);
                let off = self.lead.model.tip_error_mm(&nominal, &standing.command, tool_mm, sense);
                (off - along * along.dot(&off)).norm() <= enough_mm
            })
    }

    /// `true` if a step to `start` moves an axis in its old direction that the control moves too far at a reversal.
    fn is_pushed(&self, standing: &PathState, start: &Placed, sense: &State) -> bool {
        self.lead.axes.iter().any(|axis| {
            let wanted = sense.direction(axis);
            let step = (start.command[axis] - standing.command[axis]) * f64::from(wanted);
            let is_over_compensated = self.lead.model.features(axis).is_over_compensated(standing.command[axis]);
            wanted != standing.state.direction(axis) && step < 0.0 && is_over_compensated
        })
    }

    /// Distance of the tip from its place at the end of a step on the spot that moves an axis in its old direction, mm; 0 without such a step. Only the motion
    /// after it brings the tool back.
    pub(super) fn pushed_mm(&self, standing: &PathState, trial: &SegmentCandidate<'_>) -> f64 {
        let step = trial.take_up.filter(|start| self.is_pushed(standing, start, &trial.state()));
        step.map_or(0.0, |start| {
            self.placer.tip_error_mm(&self.route.at(trial.between[0]), &start.command, &standing.state)
        })
    }

    /// A position on the spot for bodies that a step to `start` would leave within their dead bands. From there they reach it in these directions.
    /// None is moved beyond its place.
    pub(super) fn ready(&self, standing: &PathState, start: &Placed, sense: &State) -> Option<Placed> {
        let axes = self.lead.axes.intersection(standing.sensed);
        let led = self.led(standing, &[standing.command, start.command], false);
        let mut ready = start.command;
        let mut changes = false;
        for axis in axes.iter().filter(|&axis| led.direction(axis) != sense.direction(axis)) {
            let lost = self.lead.model.lost_motion(axis, &start.command);
            ready[axis] -= lost * f64::from(sense.direction(axis));
            changes |= lost > 0.0 && sense.direction(axis) != 0;
        }
        changes.then(|| self.placer.round(&ready, self.known))
    }

    /// The sides of axis bodies after the paths through these commands, the last of which is straight, or an arc with `ends_in_arc`.
    pub(super) fn led(&self, standing: &PathState, commands: &[AxisVector], ends_in_arc: bool) -> State {
        if self.lead.axes.is_empty() {
            let mut state = standing.state;
            for way in commands.windows(2) {
                state.note_stated(standing.sensed, &way[0], &way[1]);
            }
            return state;
        }
        let mut band = standing.band;
        for (k, way) in commands.windows(2).enumerate() {
            // No axis reverses within an arc piece. On the chord of the tip it may: turning axes bend the path of the others.
            let is_arc = ends_in_arc && k + 2 == commands.len();
            let route = if is_arc { Route::new(way[0], way[1], None) } else { self.placer.emitted(way[0], way[1]) };
            self.lead.along(&mut band, &route, standing.sensed, [0.0, 1.0]);
        }
        band.state()
    }

    /// If the end was placed for `sense` and would leave a body within its dead band, the other side may be reachable: it is tried next.
    pub(super) fn turn(&self, standing: &PathState, state: &mut State, sense: &State, end: &AxisVector) {
        for axis in self.lead.axes.intersection(standing.sensed).iter() {
            if state.direction(axis) != 0 {
                continue;
            }
            let guess = sense.direction(axis);
            let step = end[axis] - standing.command[axis];
            let side = match guess {
                0 if step > 0.0 => 1,
                0 => -1,
                guess => -guess,
            };
            // A step on the spot can lead it to either side.
            let is_free = self.takes_up || self.lead.is_known(&standing.band, axis, end);
            if step != 0.0 && (is_free || self.lead.is_reached(&standing.band, (axis, side), (end, step), guess)) {
                state.direction[axis.slot()] = side;
            }
        }
    }

    /// Sets the directions that an overshoot determines.
    pub(super) fn settle(&self, state: &mut State) {
        for (sense, &settled) in state.direction.iter_mut().zip(&self.settled) {
            if settled != 0 {
                *sense = settled;
            }
        }
    }

    pub(super) fn same_sense(&self, a: &State, b: &State) -> bool {
        self.sampler.backlash.iter().all(|axis| a.direction(axis) == b.direction(axis))
    }
}
