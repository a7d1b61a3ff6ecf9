//! The dead bands of the axes: behind a reversal the body of an axis follows only when the command has gone through the lost motion.
//!
//! A band keeps, for each axis, how far the command must still go in either sense until the body follows for certain. At the beginning, and after
//! something unknown has moved the axis, that is the whole lost motion in both senses. An axis whose control adds more than it loses has no band: the
//! least motion turns it, and so it is for components across the axis that depend on the sense.

use ncfix_base::geometry::{AXIS_COUNT, Axis, AxisSet, AxisVector, Vector};
use ncfix_machine::machine::{Control, State};

use super::Model;

/// Share of the increment that two rounded commands may be off together.
const ROUNDED: f64 = 1.5;
/// Share of a lost motion that corrections of other axes change of the way across it.
const ACROSS: f64 = 0.01;

/// Two places within a dead band are the same if they differ by less than this share of it.
const SAME_SHARE: f64 = 1e-6;

/// How far the tip is from its nominal place, mm. Where the side of an axis is unknown there are several answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Off {
    /// With every unknown body in the middle of where it can be: a correction aims at this place.
    pub middle: Vector,
    /// For the sides that bring the tip nearest to its nominal place.
    pub nearest: Vector,
    /// The largest distance that any of the sides gives.
    pub most_mm: f64,
}

/// Where the axes are within their dead bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadBand {
    /// How far each axis must still go in the positive sense, and in the negative one, until its body follows for certain, mm or rad.
    ahead: AxisVector,
    back: AxisVector,
    /// The side on which a body is nearly enough to place the tool for it, 0 where it is on none.
    direction: [i8; AXIS_COUNT],
}

/// How far commands that are rounded to increments may be off, mm and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    linear_mm: f64,
    rotary_rad: f64,
}

impl Room {
    /// That of a control.
    #[must_use]
    pub fn of(control: &Control) -> Room {
        Room { linear_mm: ROUNDED * control.increment_mm, rotary_rad: ROUNDED * control.increment_rad }
    }

    /// That of an axis that loses so much.
    #[must_use]
    pub fn of_axis(&self, axis: Axis, lost: f64) -> f64 {
        ACROSS * lost + if axis.is_rotary() { self.rotary_rad } else { self.linear_mm }
    }
}

impl Default for DeadBand {
    fn default() -> Self {
        let far = AxisVector([f64::INFINITY; AXIS_COUNT]);
        DeadBand { ahead: far, back: far, direction: [0; AXIS_COUNT] }
    }
}

impl DeadBand {
    /// Forgets where axes are: something unknown has moved them.
    pub fn forget(&mut self, axes: AxisSet) {
        for axis in axes.iter() {
            (self.ahead[axis], self.back[axis]) = (f64::INFINITY, f64::INFINITY);
            self.direction[axis.slot()] = 0;
        }
    }

    /// Notes a motion of some axes on which none turns; of those that are not in `stated` nobody knows from where they come. What is at most
    /// `quiet` long, mm or rad, turns no axis. Gives the axes that went further.
    pub fn note(
        &mut self,
        model: &Model,
        (room, quiet): (&Room, f64),
        (axes, stated): (AxisSet, AxisSet),
        (from, to): (&AxisVector, &AxisVector),
    ) -> AxisSet {
        let mut moved = AxisSet::EMPTY;
        for axis in axes.iter() {
            let step = to[axis] - from[axis];
            if step == 0.0 {
                continue;
            }
            if step.abs() > quiet {
                moved.insert(axis);
            }
            if !stated.contains(axis) {
                self.forget(std::iter::once(axis).collect());
                continue;
            }
            let lost = model.lost_motion(axis, to);
            let [ahead, back] = self.ways(model, axis, to);
            let (ahead, back) = if step > 0.0 {
                ((ahead - step).max(0.0), (back + step).min(lost))
            } else {
                ((ahead - step).min(lost), (back + step).max(0.0))
            };
            (self.ahead[axis], self.back[axis]) = (ahead, back);
            if step.abs() <= quiet {
                continue;
            }
            let least = room.of_axis(axis, lost);
            let direction = &mut self.direction[axis.slot()];
            if step > 0.0 && ahead <= least {
                *direction = 1;
            } else if step < 0.0 && back <= least {
                *direction = -1;
            } else if ahead > least && back > least {
                *direction = 0;
            }
        }
        moved
    }

    /// How far an axis must still go in the positive sense, and in the negative one, until its body follows for certain, mm or rad.
    #[must_use]
    pub fn ways(&self, model: &Model, axis: Axis, command: &AxisVector) -> [f64; 2] {
        let lost = model.lost_motion(axis, command);
        [self.ahead[axis], self.back[axis]].map(|way| way.min(lost))
    }

    /// Whether the bodies of these axes are where a motion in these senses, by slot, leaves them.
    #[must_use]
    pub fn is_on(&self, axes: AxisSet, senses: &[i8; AXIS_COUNT]) -> bool {
        axes.iter().all(|axis| {
            let way = match senses[axis.slot()] {
                1 => self.ahead[axis],
                -1 => self.back[axis],
                _ => return false,
            };
            way == 0.0 && self.direction[axis.slot()] == senses[axis.slot()]
        })
    }

    /// Puts the body of an axis on the side of `sense` (−1 or 1), or in the middle for 0. `lost` is the lost motion there, mm or rad.
    pub fn put(&mut self, axis: Axis, sense: i8, lost: f64) {
        let back = 0.5 * lost * (1.0 + f64::from(sense));
        (self.ahead[axis], self.back[axis]) = (lost - back, back);
        self.direction[axis.slot()] = sense;
    }

    /// The side of each axis to place the tool for: −1 behind a motion in the negative sense, 1 in the positive, 0 within the dead band or
    /// unknown.
    #[must_use]
    pub fn direction(&self) -> [i8; AXIS_COUNT] {
        self.direction
    }

    /// The state that errors depend on.
    #[must_use]
    pub fn state(&self) -> State {
        State { direction: self.direction, ..State::default() }
    }

    /// Between which shares of the half reversal the body of an axis is, −1 to 1; both are one where that is known.
    fn shares(&self, model: &Model, axis: Axis, command: &AxisVector) -> [f64; 2] {
        let lost = model.lost_motion(axis, command);
        if lost <= 0.0 {
            let sense = f64::from(self.direction[axis.slot()]);
            return if sense == 0.0 { [-1.0, 1.0] } else { [sense; 2] };
        }
        let [ahead, back] = [self.ahead[axis], self.back[axis]].map(|way| (way / lost).min(1.0));
        let low = 1.0 - 2.0 * ahead;
        [low, (2.0 * back - 1.0).max(low)]
    }

    /// Whether it is known where the body of an axis is.
    #[must_use]
    pub fn is_known(&self, model: &Model, axis: Axis, command: &AxisVector) -> bool {
        let [low, high] = self.shares(model, axis, command);
        high - low < SAME_SHARE
    }

    /// Axes that are within their dead bands, or nobody knows where, and the state with the sides of all others.
    fn within(&self, model: &Model, axes: AxisSet, command: &AxisVector) -> (AxisSet, State) {
        let mut state = self.state();
        let mut within = AxisSet::EMPTY;
        for axis in axes.iter() {
            let [low, high] = self.shares(model, axis, command);
            state.direction[axis.slot()] = match () {
                () if low >= 1.0 => 1,
                () if high <= -1.0 => -1,
                () => {
                    within.insert(axis);
                    0
                }
            };
        }
        (within, state)
    }

    /// How far the tip at `command` is from the nominal tip at `nominal`. A tool that waits for a body is late on its way: its distance along the
    /// direction `along` does not count. The one function of correction, prediction and comparison for axes whose errors depend on the sense.
    #[must_use]
    pub fn error_mm(
        &self,
        model: &Model,
        axes: AxisSet,
        (nominal, command): (&AxisVector, &AxisVector),
        tool_mm: &Vector,
        along: impl FnOnce() -> Option<Vector>,
    ) -> Off {
        let (within, mut state) = self.within(model, axes, command);
        let mut middle = model.tip_error_mm(nominal, command, tool_mm, &state);
        if within.is_empty() {
            return Off { middle, nearest: middle, most_mm: middle.norm() };
        }
        let mut corners = [Vector::zeros(); 1 << OPEN_AXES];
        corners[0] = middle;
        let mut count = 1;
        for axis in within.iter().take(OPEN_AXES) {
            let half = half(model, axis, (nominal, command), tool_mm, &mut state);
            let [low, high] = self.shares(model, axis, command);
            middle += half * (0.5 * (low + high));
            for k in 0..count {
                corners[count + k] = corners[k] + half * high;
                corners[k] += half * low;
            }
            count *= 2;
        }
        let along = along();
        let corners = corners.iter().take(count).map(|corner| across(*corner, along));
        let middle = across(middle, along);
        let mut off = Off { middle, nearest: middle, most_mm: 0.0 };
        for corner in corners {
            off.most_mm = off.most_mm.max(corner.norm());
            if corner.norm() < off.nearest.norm() {
                off.nearest = corner;
            }
        }
        off
    }

    /// The largest distance of the tip from its nominal place that an unknown side of one axis allows, as far as it comes from that, mm.
    #[must_use]
    pub fn unknown_mm(
        &self,
        model: &Model,
        (axes, axis): (AxisSet, Axis),
        (nominal, command): (&AxisVector, &AxisVector),
        tool_mm: &Vector,
        along: impl FnOnce() -> Option<Vector>,
    ) -> f64 {
        let [low, high] = self.shares(model, axis, command);
        if high - low < SAME_SHARE {
            return 0.0;
        }
        let (within, mut state) = self.within(model, axes, command);
        let mut others = model.tip_error_mm(nominal, command, tool_mm, &state);
        for other in within.iter().filter(|&other| other != axis) {
            let [low, high] = self.shares(model, other, command);
            others += half(model, other, (nominal, command), tool_mm, &mut state) * (0.5 * (low + high));
        }
        let half = half(model, axis, (nominal, command), tool_mm, &mut state);
        let along = along();
        let [one, other] = [low, high].map(|side| across(others + half * side, along));
        one.norm().max(other.norm()).min((other - one).norm())
    }
}

/// How far the tip moves when an axis goes from the middle of its dead band to the positive side, mm. `state` has the axis on no side.
fn half(
    model: &Model,
    axis: Axis,
    (nominal, command): (&AxisVector, &AxisVector),
    tool_mm: &Vector,
    state: &mut State,
) -> Vector {
    let [one, other] = [1, -1].map(|sense| {
        state.direction[axis.slot()] = sense;
        model.tip_error_mm(nominal, command, tool_mm, state)
    });
    state.direction[axis.slot()] = 0;
    (one - other) * 0.5
}

/// The part of a vector that is perpendicular to a direction.
fn across(vector: Vector, along: Option<Vector>) -> Vector {
    along.map_or(vector, |along| vector - along * along.dot(&vector))
}

/// Axes whose sides are looked at together; a machine has three that place the tip, and two that turn.
const OPEN_AXES: usize = 5;
