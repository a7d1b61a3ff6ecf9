//! Dead bands of the axes: after a reversal the body of an axis follows only when the command has passed the lost motion.
//!
//! For each axis and direction, a band holds the distance that the command must still travel until the body certainly follows. At the beginning, and after an
//! unknown motion of the axis, that is the whole lost motion in both directions. An axis whose control adds more than the axis loses has no band: the
//! smallest motion switches its side. The same applies to components perpendicular to the axis that depend on the direction of motion.

use ncfix_base::geometry::{AXIS_COUNT, Axis, AxisSet, AxisVector, Vector};
use ncfix_machine::machine::{Control, State};

use super::Model;

/// Share of the increment by which two rounded commands together may deviate.
const ROUNDED: f64 = 1.5;
/// Share of a lost motion by which corrections of other axes change the path through it.
const ACROSS: f64 = 0.01;

/// Two positions within a dead band are equal if they differ by less than this share of it.
const SAME_SHARE: f64 = 1e-6;

/// Distance of the tip from its nominal position, mm. If the side of an axis is unknown, there are several values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Off {
    /// Distance with every unknown body in the middle of its range; a correction aims at this position.
    pub middle: Vector,
    /// Distance for the places of the unknown bodies that bring the tip nearest to its nominal position.
    pub nearest: Vector,
    /// Largest distance over all sides.
    pub most_mm: f64,
    /// Largest magnitude along X, Y and Z over all sides.
    pub most: Vector,
}

/// Positions of the axes within their dead bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadBand {
    /// Distance that each axis must still travel in the positive direction, and in the negative one, until its body certainly follows, mm or rad.
    ahead: AxisVector,
    back: AxisVector,
    /// Side for which the tool is positioned: −1 or 1 if the body is close enough to it, 0 if it is on neither.
    direction: [i8; AXIS_COUNT],
}

/// Tolerance for commands that are rounded to increments, mm and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    linear_mm: f64,
    rotary_rad: f64,
}

impl Room {
    /// Returns the tolerance of a control.
    #[must_use]
    pub fn of(control: &Control) -> Room {
        Room { linear_mm: ROUNDED * control.increment_mm, rotary_rad: ROUNDED * control.increment_rad }
    }

    /// Returns the tolerance of an axis with the lost motion `lost`.
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
    /// Sets the positions of axes to unknown after an unknown motion.
    pub fn forget(&mut self, axes: AxisSet) {
        for axis in axes.iter() {
            (self.ahead[axis], self.back[axis]) = (f64::INFINITY, f64::INFINITY);
            self.direction[axis.slot()] = 0;
        }
    }

    /// Notes a motion of some axes without reversal. The start of axes that are not in `stated` is unknown. A motion of at most `quiet`, mm or rad, switches
    /// the side of no axis. Returns the axes that moved farther.
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

    /// Returns the distance that an axis must still travel in the positive direction, and in the negative one, until its body certainly follows, mm or rad.
    #[must_use]
    pub fn ways(&self, model: &Model, axis: Axis, command: &AxisVector) -> [f64; 2] {
        let lost = model.lost_motion(axis, command);
        [self.ahead[axis], self.back[axis]].map(|way| way.min(lost))
    }

    /// True if the bodies of these axes are on the sides where a motion in these directions, by slot, leaves them.
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

    /// Sets the body of an axis to the side `sense` (−1 or 1), or to the middle for 0. `lost` is the lost motion there, mm or rad.
    pub fn put(&mut self, axis: Axis, sense: i8, lost: f64) {
        let back = 0.5 * lost * (1.0 + f64::from(sense));
        (self.ahead[axis], self.back[axis]) = (lost - back, back);
        self.direction[axis.slot()] = sense;
    }

    /// Returns the side of each axis for which the tool is positioned: −1 after a motion in the negative direction, 1 in the positive, 0 within the dead band
    /// or unknown.
    #[must_use]
    pub fn direction(&self) -> [i8; AXIS_COUNT] {
        self.direction
    }

    /// Returns the state on which errors depend.
    #[must_use]
    pub fn state(&self) -> State {
        State { direction: self.direction, ..State::default() }
    }

    /// Returns the range of the body of an axis in shares of the half reversal, −1 to 1; both limits are equal if the position is known.
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

    /// True if the position of the body of an axis is known.
    #[must_use]
    pub fn is_known(&self, model: &Model, axis: Axis, command: &AxisVector) -> bool {
        let [low, high] = self.shares(model, axis, command);
        high - low < SAME_SHARE
    }

    /// Returns the axes whose bodies are within their dead bands or unknown, and the state with the sides of all others.
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

    /// Returns the distance of the tip at `command` from the nominal tip at `nominal`. A tool that waits for a body only lags on its path, and one whose axis the
    /// control moves too far at a reversal leads: its distance along the direction `along` does not count. Correction, prediction and comparison all use this
    /// function for axes with direction-dependent errors.
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
            // A tool whose axis is moved too far at a reversal leads on its path, as one that waits lags.
            let leads = |axis: Axis| model.features(axis).is_over_compensated(command[axis]);
            let middle = if axes.iter().any(leads) { across(middle, along()) } else { middle };
            return Off { middle, nearest: middle, most_mm: middle.norm(), most: middle.abs() };
        }
        let along = along();
        let mut corners = [Vector::zeros(); 1 << OPEN_AXES];
        corners[0] = middle;
        let mut count = 1;
        let mut ranges = [(Vector::zeros(), [0.0; 2]); OPEN_AXES];
        for (axis, range) in within.iter().zip(&mut ranges) {
            let half = half(model, axis, (nominal, command), tool_mm, &mut state);
            let [low, high] = self.shares(model, axis, command);
            *range = (across(half, along), [low, high]);
            middle += half * (0.5 * (low + high));
            for k in 0..count {
                corners[count + k] = corners[k] + half * high;
                corners[k] += half * low;
            }
            count *= 2;
        }
        let corners = corners.iter().take(count).map(|corner| across(*corner, along));
        let middle = across(middle, along);
        let (most_mm, most) = corners.fold((0.0_f64, Vector::zeros()), |(most_mm, most), corner| {
            (most_mm.max(corner.norm()), most.sup(&corner.abs()))
        });
        Off { middle, nearest: nearest(middle, &ranges), most_mm, most }
    }

    /// Returns the largest distance of the tip from its nominal position that is due to the unknown side of one axis, mm.
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

/// Returns the displacement of the tip when an axis moves from the middle of its dead band to the positive side, mm. `state` has the axis on neither side.
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

/// Returns the smallest of the vectors that bodies within these ranges give. Each range has the effect of half a reversal and its limits in shares of it;
/// `middle` is the vector with all of them in the middle.
fn nearest(middle: Vector, ranges: &[(Vector, [f64; 2]); OPEN_AXES]) -> Vector {
    let mut shares = ranges.map(|(_, [low, high])| 0.5 * (low + high));
    let mut best = middle;
    for _ in 0..SWEEPS {
        for ((half, [low, high]), share) in ranges.iter().zip(&mut shares).filter(|((half, _), _)| half.norm() > 0.0) {
            let better = (*share - best.dot(half) / half.norm_squared()).clamp(*low, *high);
            best += *half * (better - *share);
            *share = better;
        }
    }
    best
}

/// Returns the part of a vector that is perpendicular to a direction.
fn across(vector: Vector, along: Option<Vector>) -> Vector {
    along.map_or(vector, |along| vector - along * along.dot(&vector))
}

/// Maximum number of axes whose sides are considered together; a machine has three axes that position the tip, and two that rotate.
const OPEN_AXES: usize = 5;
/// Number of times that each axis is brought to its best place: effects of different axes are almost perpendicular, and two sweeps are exact then.
const SWEEPS: usize = 4;
