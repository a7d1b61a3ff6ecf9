//! Propagation of commands through the dead bands of the axis bodies along a path.

use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector, Vector};
use ncfix_machine::machine::Machine;
use ncfix_model::{DeadBand, Model, Off, Room};

use super::route::Route;

/// Upper bound of the axis displacement at a turning point due to rounding of the arc center, mm: e²/2r for a center that is off by e.
const QUIET_MM: f64 = 5e-5;
/// Half the parameter step for the direction of a path, and the shortest path that has a direction, mm.
const DIRECTION_STEP: f64 = 1e-4;
const SHORTEST_MM: f64 = 1e-9;
/// Excess of an overshoot beyond the lost motion: a share of it, and a minimum number of increments.
const BIT_SHARE: f64 = 0.25;
const BIT_INCREMENTS: f64 = 5.0;
/// Maximum number of turning points of one arc.
const MOST_PLACES: usize = 4096;

/// Data that determine the motion of the bodies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lead<'a> {
    pub(super) model: &'a Model,
    /// Axes whose errors depend on the direction of motion.
    pub(super) axes: AxisSet,
    room: Room,
}

impl<'a> Lead<'a> {
    /// For a machine with its errors.
    pub(super) fn new(model: &'a Model, machine: &Machine) -> Lead<'a> {
        let axes = AXES.into_iter().filter(|&axis| model.features(axis).backlash).collect();
        Lead { model, axes, room: Room::of(&machine.control) }
    }

    /// For another head of the same machine.
    pub(super) fn with(self, model: &'a Model) -> Lead<'a> {
        let axes = AXES.into_iter().filter(|&axis| model.features(axis).backlash).collect();
        Lead { model, axes, ..self }
    }

    /// Follows a path between two parameters; axes reverse on it at the turning points of an arc. An axis without a dead band, or with one of about
    /// an increment, is immediately on the side of its next motion.
    pub(super) fn along(&self, band: &mut DeadBand, route: &Route<'_>, stated: AxisSet, [from, to]: [f64; 2]) {
        if self.axes.is_empty() {
            return;
        }
        let quiet = if route.arc().is_some() { QUIET_MM } else { 0.0 };
        let mut moved = AxisSet::EMPTY;
        let (mut from, mut at) = (from, route.at(from));
        for k in 0..MOST_PLACES {
            let next = if k + 1 < MOST_PLACES { route.next_turning(self.axes, from).min(to) } else { to };
            let place = route.at(next);
            moved = moved.union(band.note(self.model, (&self.room, quiet), (self.axes, stated), (&at, &place)));
            (from, at) = (next, place);
            if next >= to {
                break;
            }
        }
        let about_to = |axis: &Axis| self.is_quick(*axis, &at);
        let mut waiting: AxisSet = self.axes.difference(moved).intersection(stated).iter().filter(about_to).collect();
        for _ in 0..MOST_PLACES {
            if waiting.is_empty() || from >= 1.0 {
                return;
            }
            let next = route.next_turning(self.axes, from);
            let place = route.at(next);
            for axis in waiting.iter() {
                let step = place[axis] - at[axis];
                if step.abs() > quiet {
                    band.put(axis, if step > 0.0 { 1 } else { -1 }, self.model.lost_motion(axis, &at));
                    waiting = waiting.difference(std::iter::once(axis).collect());
                }
            }
            (from, at) = (next, place);
        }
    }

    /// `true` if the smallest motion moves the body of an axis: its dead band is no wider than the rounding of its command.
    pub(super) fn is_quick(&self, axis: Axis, command: &AxisVector) -> bool {
        let lost = self.model.lost_motion(axis, command);
        lost <= self.room.of_axis(axis, lost)
    }

    /// Length of an overshoot that determines the side of an axis, mm.
    pub(super) fn beyond_mm(&self, axis: Axis, command: &AxisVector, increment_mm: f64) -> f64 {
        let lost_mm = self.model.lost_motion(axis, command);
        lost_mm + (BIT_SHARE * lost_mm).max(BIT_INCREMENTS * increment_mm)
    }

    /// `true` if the position of the axis body in its dead band is known.
    pub(super) fn is_known(&self, band: &DeadBand, axis: Axis, command: &AxisVector) -> bool {
        band.is_known(self.model, axis, command)
    }

    /// Adds the parameters of a path at which bodies certainly begin to follow.
    pub(super) fn edges(&self, band: &DeadBand, way: &Route<'_>, parameters: &mut Vec<f64>) {
        for axis in self.axes.iter() {
            let from = way.start[axis];
            let [ahead, back] = band.ways(self.model, axis, &way.start);
            for place in [from + ahead, from - back] {
                way.crossings(axis, place, [0.0, 1.0], parameters);
            }
        }
    }

    /// `true` if a step to `command` would bring the axis to a side if it were placed for that side instead of for `guess`.
    pub(super) fn is_reached(
        &self,
        band: &DeadBand,
        (axis, side): (Axis, i8),
        (command, step): (&AxisVector, f64),
        guess: i8,
    ) -> bool {
        let half = 0.5 * self.model.lost_motion(axis, command);
        let mut to = *command;
        to[axis] += half * f64::from(side - guess);
        let mut from = *command;
        from[axis] -= step;
        let mut band = *band;
        let all = std::iter::once(axis).collect();
        band.note(self.model, (&self.room, 0.0), (all, all), (&from, &to));
        band.direction()[axis.slot()] == side
    }

    /// As [`DeadBand::error_mm`]; `way` is the route, and the parameter, along which the tool may lag.
    pub(super) fn error_mm(
        &self,
        band: &DeadBand,
        places: (&AxisVector, &AxisVector),
        tool_mm: &Vector,
        way: Option<(&Route<'_>, f64)>,
    ) -> Off {
        let along = || way.and_then(|(route, at)| self.direction(route, at, tool_mm));
        band.error_mm(self.model, self.axes, places, tool_mm, along)
    }

    /// As [`DeadBand::unknown_mm`].
    pub(super) fn unknown_mm(
        &self,
        band: &DeadBand,
        axis: Axis,
        places: (&AxisVector, &AxisVector),
        tool_mm: &Vector,
        way: Option<(&Route<'_>, f64)>,
    ) -> f64 {
        let along = || way.and_then(|(route, at)| self.direction(route, at, tool_mm));
        band.unknown_mm(self.model, (self.axes, axis), places, tool_mm, along)
    }

    /// The direction of the tip along a route; `None` if it does not move.
    pub(super) fn direction(&self, route: &Route<'_>, at: f64, tool_mm: &Vector) -> Option<Vector> {
        let places = [at - DIRECTION_STEP, at + DIRECTION_STEP].map(|share| route.at(share.clamp(0.0, 1.0)));
        let [from, to] = places.map(|command| self.model.nominal(&command, tool_mm).translation);
        (to - from).try_normalize(SHORTEST_MM)
    }
}
