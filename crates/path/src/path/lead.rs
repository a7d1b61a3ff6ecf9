//! How commands lead the bodies of axes through their dead bands, along a whole way.

use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet, AxisVector, Vector};
use ncfix_machine::machine::Machine;
use ncfix_model::{DeadBand, Model, Off, Room};

use super::route::Route;

/// What rounding the center of an arc moves an axis by at its turning point is less, mm: e²/2r for a center that is off by e.
const QUIET_MM: f64 = 5e-5;
/// Half the step over which the direction of a way is looked at, as a parameter, and the shortest way that has one, mm.
const DIRECTION_STEP: f64 = 1e-4;
const SHORTEST_MM: f64 = 1e-9;
/// What an overshoot goes beyond the lost motion, as a share of it, and at least so many increments.
const BIT_SHARE: f64 = 0.25;
const BIT_INCREMENTS: f64 = 5.0;
/// Turning points of one arc that are looked at.
const MOST_PLACES: usize = 4096;

/// What the bodies follow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lead<'a> {
    pub(super) model: &'a Model,
    /// Axes whose errors depend on the sense of motion.
    pub(super) axes: AxisSet,
    room: Room,
}

impl<'a> Lead<'a> {
    /// On a machine with its errors.
    pub(super) fn new(model: &'a Model, machine: &Machine) -> Lead<'a> {
        let axes = AXES.into_iter().filter(|&axis| model.features(axis).backlash).collect();
        Lead { model, axes, room: Room::of(&machine.control) }
    }

    /// Notes a way between two parameters; axes turn on it where an arc does. An axis without a dead band, or with one of about an increment, is
    /// at once on the side to which it is about to go.
    pub(super) fn along(&self, band: &mut DeadBand, route: &Route, stated: AxisSet, [from, to]: [f64; 2]) {
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

    /// Whether the least motion leads the body of an axis along: its dead band is no wider than what rounding moves its command by.
    pub(super) fn is_quick(&self, axis: Axis, command: &AxisVector) -> bool {
        let lost = self.model.lost_motion(axis, command);
        lost <= self.room.of_axis(axis, lost)
    }

    /// How far an overshoot leads that settles on which side an axis is, mm.
    pub(super) fn beyond_mm(&self, axis: Axis, command: &AxisVector, increment_mm: f64) -> f64 {
        let lost_mm = self.model.lost_motion(axis, command);
        lost_mm + (BIT_SHARE * lost_mm).max(BIT_INCREMENTS * increment_mm)
    }

    /// Whether it is known where the body of an axis is.
    pub(super) fn is_known(&self, band: &DeadBand, axis: Axis, command: &AxisVector) -> bool {
        band.is_known(self.model, axis, command)
    }

    /// Adds the parameters of a way at which bodies begin to follow for certain.
    pub(super) fn edges(&self, band: &DeadBand, way: &Route, parameters: &mut Vec<f64>) {
        for axis in self.axes.iter() {
            let from = way.start[axis];
            let [ahead, back] = band.ways(self.model, axis, &way.start);
            for place in [from + ahead, from - back] {
                way.crossings(axis, place, [0.0, 1.0], parameters);
            }
        }
    }

    /// Puts axes that the least motion turns on these sides, by slot.
    pub(super) fn put(&self, band: &mut DeadBand, sides: &[i8; AXIS_COUNT], command: &AxisVector) {
        for axis in self.axes.iter().filter(|axis| sides[axis.slot()] != 0) {
            if self.is_quick(axis, command) {
                band.put(axis, sides[axis.slot()], self.model.lost_motion(axis, command));
            }
        }
    }

    /// Whether an axis would come to a side by a step to `command`, if it were placed for that side instead of for `guess`.
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

    /// As [`DeadBand::error_mm`]; `way` is the route, and the parameter, along which the tool may wait.
    pub(super) fn error_mm(
        &self,
        band: &DeadBand,
        places: (&AxisVector, &AxisVector),
        tool_mm: &Vector,
        way: Option<(&Route, f64)>,
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
        way: Option<(&Route, f64)>,
    ) -> f64 {
        let along = || way.and_then(|(route, at)| self.direction(route, at, tool_mm));
        band.unknown_mm(self.model, (self.axes, axis), places, tool_mm, along)
    }

    /// The direction in which the tip goes along a route; `None` where it stays.
    fn direction(&self, route: &Route, at: f64, tool_mm: &Vector) -> Option<Vector> {
        let places = [at - DIRECTION_STEP, at + DIRECTION_STEP].map(|share| route.at(share.clamp(0.0, 1.0)));
        let [from, to] = places.map(|command| self.model.nominal(&command, tool_mm).translation);
        (to - from).try_normalize(SHORTEST_MM)
    }
}
