//! Forward kinematics with errors by homogeneous matrices, from the conventions alone.
//!
//! With L the place of an axis, M its motion and D a small displacement (rotated by the exponential of EA EB EC, then shifted by EX EY EZ),
//! an axis is L D(e0) M D(e) L⁻¹, or L D(e0) D(e) M L⁻¹ where the lever is fixed. The spindle is D(e0) at its gauge point.

use ncfix_base::geometry::{AXES, Axis, AxisVector, Matrix, Vector};
use ncfix_machine::machine::{AxisData, Lever, State};
use ncfix_model::Model;
use ncfix_path::path::Increments;

use super::draw::{Pair, Random, Shape};

/// The judge of one machine.
pub(super) struct Judge<'a> {
    pair: &'a Pair,
    /// Links of the two chains from the foundation outwards: to the workpiece and to the tool.
    chains: [Vec<Link<'a>>; 2],
    /// From the gauge point of the spindle to the tip, seen by the last axis before it, without errors and with them.
    tips: [Vector; 2],
    /// Without rotary axes the ideal tip is a sum: its place at zero, and its way per mm of each axis.
    straight: Option<(Vector, Vec<(Axis, Vector)>)>,
}

/// What a homogeneous matrix holds: a rotation about the origin, then a shift.
#[derive(Clone, Copy)]
struct Rigid {
    /// Unit vector of the rotation.
    about: Vector,
    sine: f64,
    cosine: f64,
    shift: Vector,
}

impl Rigid {
    /// A rotation by the length of a vector about it.
    fn new(rotation: Vector, shift: Vector) -> Rigid {
        let angle = rotation.norm();
        let about = if angle > 0.0 { rotation / angle } else { Vector::zeros() };
        let (sine, cosine) = angle.sin_cos();
        Rigid { about, sine, cosine, shift }
    }

    /// By Rodrigues' formula, in the sense of `sine`.
    fn turned(&self, point: Vector, sine: f64) -> Vector {
        let along = self.about * (self.about.dot(&point) * (1.0 - self.cosine));
        point * self.cosine + self.about.cross(&point) * sine + along
    }

    fn apply(&self, point: Vector) -> Vector {
        self.turned(point, self.sine) + self.shift
    }

    fn unapply(&self, point: Vector) -> Vector {
        self.turned(point - self.shift, -self.sine)
    }
}

fn displacement([x, y, z, a, b, c]: [f64; 6]) -> Rigid {
    Rigid::new(Vector::new(a, b, c), Vector::new(x, y, z))
}

/// An axis of a chain; what is constant of it is made once.
struct Link<'a> {
    data: &'a AxisData,
    location: Rigid,
}

/// On which sides of their play the bodies of the axes are: −1 behind a motion in the negative sense, 1 behind one in the positive.
#[derive(Debug)]
pub(super) struct Sides {
    /// Between which sides each body is, by slot; one place where that is certain. Without play along the axis the least motion turns it.
    between: [[f64; 2]; 9],
    /// How far the command must go from the one side to the other, mm or rad, by slot.
    play: [f64; 9],
    /// The furthest that each axis without play has gone in its sense, or where it stood first.
    furthest: AxisVector,
    has_begun: [bool; 9],
    /// Axes without play that have gone back, or gone at all, by less than an increment: a control may see a turn there or none.
    unsure: Vec<Axis>,
    increments: Increments,
}

impl Sides {
    pub(super) fn new(pair: &Pair) -> Sides {
        let increments = Increments::new(&pair.machine.control);
        let mut play = [0.0; 9];
        for data in pair.machine.axes.iter().flatten() {
            let own = data.axis.dimension() + if data.axis.is_rotary() { 3 } else { 0 };
            for (component, shape) in &pair.errors.motion[data.axis.slot()] {
                if let (true, Shape::Reversal(size)) = (*component == own, shape) {
                    // A body that stays behind is off against the way that a positive command leads it.
                    play[data.axis.slot()] -= data.direction[data.axis.dimension()] * size;
                }
            }
        }
        let play = play.map(|play| play.max(0.0));
        let (furthest, has_begun) = (AxisVector::ZERO, [false; 9]);
        Sides { between: [[-1.0, 1.0]; 9], play, furthest, has_begun, unsure: Vec::new(), increments }
    }

    /// Something has moved an axis that nobody knows.
    pub(super) fn forget(&mut self, axis: Axis) {
        self.between[axis.slot()] = [-1.0, 1.0];
        self.has_begun[axis.slot()] = false;
        self.unsure.retain(|&other| other != axis);
    }

    /// Notes a short way of an axis.
    pub(super) fn note(&mut self, axis: Axis, from: &AxisVector, to: &AxisVector) {
        let (between, play) = (&mut self.between[axis.slot()], self.play[axis.slot()]);
        if play > 0.0 {
            let turned = 2.0 * (to[axis] - from[axis]) / play;
            *between = between.map(|side| (side + turned).clamp(-1.0, 1.0));
            return;
        }
        if !std::mem::replace(&mut self.has_begun[axis.slot()], true) {
            self.furthest[axis] = from[axis];
        }
        let gone = to[axis] - self.furthest[axis];
        // The noise of a turned frame moves nothing.
        let has_moved = gone.abs() > 1e-9;
        let is_further = between[0] == between[1] && gone * between[0] >= -1e-9;
        if has_moved && !is_further && self.increments.ratio(axis, gone).abs() < 1.0 - 1e-6 {
            if !self.unsure.contains(&axis) {
                self.unsure.push(axis);
            }
            return;
        }
        self.unsure.retain(|&other| other != axis);
        if has_moved {
            *between = [gone.signum(); 2];
            self.furthest[axis] = to[axis];
        }
    }

    /// The middle of what is possible.
    pub(super) fn middle(&self) -> [f64; 9] {
        self.between.map(|[low, high]| 0.5 * (low + high))
    }

    /// Axes of whose bodies nobody knows where they are, with both ends of what is possible.
    pub(super) fn open(&self) -> impl Iterator<Item = (Axis, [f64; 2])> {
        let between = |axis: Axis| self.between[axis.slot()];
        AXES.into_iter().map(move |axis| (axis, between(axis))).filter(|(_, [low, high])| high - low > 1e-9)
    }

    /// What a control may see where axes without play have turned by less than an increment, or `turning` are about to turn: either side.
    pub(super) fn possible(&self, turning: &[Axis]) -> Vec<[f64; 9]> {
        let mut possible = vec![self.middle()];
        let is_certain = |axis: Axis| self.between[axis.slot()][0] == self.between[axis.slot()][1];
        let others = turning
            .iter()
            .filter(|&&axis| self.play[axis.slot()] == 0.0 && !self.unsure.contains(&axis) && is_certain(axis));
        for axis in self.unsure.iter().chain(others) {
            for k in 0..possible.len() {
                let others: &[f64] = match possible[k][axis.slot()] {
                    0.0 => &[-1.0, 1.0],
                    side => &[-side],
                };
                for &side in others {
                    let mut other = possible[k];
                    other[axis.slot()] = side;
                    possible.push(other);
                }
            }
        }
        possible
    }
}

impl<'a> Judge<'a> {
    pub(super) fn new(pair: &'a Pair) -> Judge<'a> {
        let machine = &pair.machine;
        let link = |&axis: &Axis| {
            let location = displacement(pair.errors.location[axis.slot()]);
            Link { data: machine.axis(axis).unwrap(), location }
        };
        let workpiece: Vec<Link> = machine.topology.workpiece.iter().map(link).collect();
        let tool = machine.topology.tool.iter().map(link).collect();
        let seen = displacement(pair.errors.spindle).apply(pair.tool_mm);
        let tips = [pair.tool_mm, seen].map(|tip| machine.spindle.origin_mm + tip);
        let mut judge = Judge { pair, chains: [workpiece, tool], tips, straight: None };
        let axes: Vec<Axis> = pair.machine.axis_set().iter().collect();
        if axes.iter().all(|axis| !axis.is_rotary()) {
            let zero = judge.tip(&AxisVector::ZERO, None);
            let column = |axis| {
                let mut command = AxisVector::ZERO;
                command[axis] = 1.0;
                (axis, judge.tip(&command, None) - zero)
            };
            judge.straight = Some((zero, axes.into_iter().map(column).collect()));
        }
        judge
    }

    /// The tip in the workpiece without errors, mm.
    pub(super) fn ideal(&self, command: &AxisVector) -> Vector {
        match &self.straight {
            Some((zero, columns)) => columns.iter().fold(*zero, |tip, (axis, column)| tip + column * command[*axis]),
            None => self.tip(command, None),
        }
    }

    /// The place of the tip in the workpiece, as the linear axes of the pose with all rotary axes at 0; the rotary axes are as they are.
    pub(super) fn fixed(&self, command: &AxisVector) -> AxisVector {
        self.solved(self.ideal(command), &AxisVector::ZERO, command)
    }

    /// The command of such a place.
    pub(super) fn command_of(&self, fixed: &AxisVector) -> AxisVector {
        let mut upright = *fixed;
        for axis in AXES.into_iter().filter(|axis| axis.is_rotary()) {
            upright[axis] = 0.0;
        }
        self.solved(self.ideal(&upright), fixed, fixed)
    }

    /// X, Y and Z that bring the tip to a point, with the rotary axes of `turned`; the others are those of `others`.
    fn solved(&self, tip: Vector, turned: &AxisVector, others: &AxisVector) -> AxisVector {
        let mut pose = *turned;
        let linear = [Axis::X, Axis::Y, Axis::Z];
        linear.iter().for_each(|&axis| pose[axis] = 0.0);
        let zero = self.tip(&pose, None);
        let columns = linear.map(|axis| {
            let mut moved = pose;
            moved[axis] = 1.0;
            self.tip(&moved, None) - zero
        });
        let found = Matrix::from_columns(&columns).try_inverse().unwrap() * (tip - zero);
        let mut out = *others;
        linear.iter().zip(found.iter()).for_each(|(&axis, &value)| out[axis] = value);
        out
    }

    /// The same with errors.
    pub(super) fn actual(&self, command: &AxisVector, side: &[f64; 9]) -> Vector {
        self.tip(command, Some(side))
    }

    pub(super) fn increment_mm(&self) -> f64 {
        self.pair.machine.control.increment_mm
    }

    /// What the backlash of some axes is at the tip, mm, together.
    pub(super) fn backlash_mm(&self, command: &AxisVector, side: &[f64; 9], axes: impl Iterator<Item = Axis>) -> f64 {
        let owed = axes.map(|axis| {
            let [one, other] = [1.0, -1.0].map(|turned| {
                let mut side = *side;
                side[axis.slot()] = turned;
                self.actual(command, &side)
            });
            // From an unknown side it is half of that, which is less.
            (one - other).norm()
        });
        owed.sum()
    }

    /// What the tip is moved by between the ends of what is possible of axes, mm, together.
    pub(super) fn open_mm(&self, command: &AxisVector, sides: &Sides) -> f64 {
        let middle = sides.middle();
        let moved = sides.open().map(|(axis, ends)| {
            let [one, other] = ends.map(|side| {
                let mut all = middle;
                all[axis.slot()] = side;
                self.actual(command, &all)
            });
            (one - other).norm()
        });
        moved.sum()
    }

    /// What half an increment of each rotary axis moves the tip by, mm, together.
    pub(super) fn rotary_rounding_mm(&self, command: &AxisVector, side: &[f64; 9]) -> f64 {
        let half = Increments::new(&self.pair.machine.control).rotary_deg.to_radians() / 2.0;
        let rotary = self.pair.machine.axis_set().iter().filter(|axis| axis.is_rotary());
        let moved = rotary.map(|axis| {
            let mut rounded = *command;
            rounded[axis] += half;
            (self.actual(&rounded, side) - self.actual(command, side)).norm()
        });
        moved.sum()
    }

    /// From the tip inwards to the foundation, and outwards to the workpiece by the inverse of its chain.
    fn tip(&self, command: &AxisVector, side: Option<&[f64; 9]>) -> Vector {
        let [workpiece, tool] = &self.chains;
        let tip = self.tips[usize::from(side.is_some())];
        let on_foundation = tool.iter().rev().fold(tip, |point, link| self.through(link, point, command, side, false));
        workpiece.iter().fold(on_foundation, |point, link| self.through(link, point, command, side, true))
    }

    /// A point behind an axis as it is before it, or the inverse of that.
    fn through(
        &self,
        link: &Link,
        point: Vector,
        command: &AxisVector,
        side: Option<&[f64; 9]>,
        is_inverse: bool,
    ) -> Vector {
        let data = link.data;
        let position = command[data.axis];
        let way = data.direction * position;
        let motion =
            if data.axis.is_rotary() { Rigid::new(way, Vector::zeros()) } else { Rigid::new(Vector::zeros(), way) };
        let at_place = point - data.point_mm;
        let Some(side) = side else {
            let moved = if is_inverse { motion.unapply(at_place) } else { motion.apply(at_place) };
            return moved + data.point_mm;
        };
        let slot = data.axis.slot();
        let mut components = [0.0; 6];
        for (component, shape) in &self.pair.errors.motion[slot] {
            components[*component] += shape.value(position, side[slot]);
        }
        let error = displacement(components);
        let [outer, inner] = match data.lever {
            Lever::Carried => [&motion, &error],
            Lever::Fixed => [&error, &motion],
        };
        let moved = if is_inverse {
            inner.unapply(outer.unapply(link.location.unapply(at_place)))
        } else {
            link.location.apply(outer.apply(inner.apply(at_place)))
        };
        moved + data.point_mm
    }
}

/// The judge and the model of the correction agree about where the tip is.
pub(super) fn check_forward(pair: &Pair) {
    let model = Model::new(&pair.machine, &pair.model());
    let judge = Judge::new(pair);
    let mut random = Random(pair.seed ^ 0x5eed);
    for _ in 0..3 {
        let mut command = AxisVector::ZERO;
        let mut side = [0.0; 9];
        for data in pair.machine.axes.iter().flatten() {
            let [low, high] = data.travel.unwrap();
            command[data.axis] = random.between(low, high);
            side[data.axis.slot()] = [-1.0, 0.0, 1.0][random.below(3)];
        }
        let state = State { direction: side.map(|side| side as i8), ..State::default() };
        let expected = model.actual(&command, &pair.tool_mm, &state).translation;
        let away_mm = (judge.actual(&command, &side) - expected).norm();
        assert!(away_mm < 1e-9, "pair {}: judge and model differ by {away_mm:e} mm", pair.seed);
        let away_mm = (judge.ideal(&command) - model.nominal(&command, &pair.tool_mm).translation).norm();
        assert!(away_mm < 1e-9, "pair {}: {away_mm:e} mm without errors", pair.seed);
    }
}
