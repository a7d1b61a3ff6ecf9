//! Forward kinematics with errors by homogeneous matrices, from the conventions alone.
//!
//! With L the place of an axis, M its motion and D a small displacement (rotated by the exponential of EA EB EC, then shifted by EX EY EZ),
//! an axis is L D(e0) M D(e) L⁻¹, or L D(e0) D(e) M L⁻¹ where the lever is fixed. The spindle is D(e0) at its gauge point.

use nalgebra::{Matrix4, Rotation3, Translation3};
use ncfix::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix::machine::{AxisData, Lever, Machine, State};
use ncfix::model::Model;
use ncfix::path::Increments;

use super::draw::{Pair, Random};

/// The judge of one machine.
pub(super) struct Judge<'a> {
    pair: &'a Pair,
    /// Without rotary axes the ideal tip is a sum: its place at zero, and its way per mm of each axis.
    straight: Option<(Vector, Vec<(Axis, Vector)>)>,
}

fn displacement([x, y, z, a, b, c]: [f64; 6]) -> Matrix4<f64> {
    Translation3::new(x, y, z).to_homogeneous() * Rotation3::from_scaled_axis(Vector::new(a, b, c)).to_homogeneous()
}

fn shift(by: Vector) -> Matrix4<f64> {
    Translation3::from(by).to_homogeneous()
}

/// In which senses the axes have moved last.
pub(super) struct Senses {
    /// The sense of each axis as far as it is certain, by slot.
    pub(super) certain: [i8; 9],
    /// The furthest that each axis has gone in its sense.
    furthest: AxisVector,
    /// Axes that have gone back by less than an increment: a control may see a turn there or none.
    unsure: Vec<Axis>,
    increments: Increments,
}

impl Senses {
    pub(super) fn new(machine: &Machine) -> Senses {
        let increments = Increments::new(&machine.control);
        Senses { certain: [0; 9], furthest: AxisVector::ZERO, unsure: Vec::new(), increments }
    }

    /// Notes a short way.
    pub(super) fn note(&mut self, from: &AxisVector, to: &AxisVector) {
        for axis in AXES {
            let certain = &mut self.certain[axis.slot()];
            if *certain == 0 {
                self.furthest[axis] = from[axis];
            }
            let gone = to[axis] - self.furthest[axis];
            // The noise of a turned frame moves nothing.
            let is_further = gone * f64::from(*certain) >= -1e-9;
            let is_turn = self.increments.ratio(axis, gone).abs() > 1.0 - 1e-6 || *certain == 0;
            if gone.abs() > 1e-9 && !is_further && !is_turn {
                if !self.unsure.contains(&axis) {
                    self.unsure.push(axis);
                }
                continue;
            }
            self.unsure.retain(|&other| other != axis);
            if gone.abs() > 1e-9 {
                *certain = if gone > 0.0 { 1 } else { -1 };
                self.furthest[axis] = to[axis];
            }
        }
    }

    /// All senses that the axes may have now.
    pub(super) fn possible(&self) -> Vec<[i8; 9]> {
        let mut possible = vec![self.certain];
        for axis in &self.unsure {
            for k in 0..possible.len() {
                let mut other = possible[k];
                other[axis.slot()] = -other[axis.slot()];
                possible.push(other);
            }
        }
        possible
    }
}

impl<'a> Judge<'a> {
    pub(super) fn new(pair: &'a Pair) -> Judge<'a> {
        let mut judge = Judge { pair, straight: None };
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

    /// The same with errors.
    pub(super) fn actual(&self, command: &AxisVector, sense: &[i8; 9]) -> Vector {
        self.tip(command, Some(sense))
    }

    /// What half an increment of each rotary axis moves the tip by, mm, together.
    pub(super) fn rotary_rounding_mm(&self, command: &AxisVector, sense: &[i8; 9]) -> f64 {
        let half = Increments::new(&self.pair.machine.control).rotary_deg.to_radians() / 2.0;
        let rotary = self.pair.machine.axis_set().iter().filter(|axis| axis.is_rotary());
        let moved = rotary.map(|axis| {
            let mut rounded = *command;
            rounded[axis] += half;
            (self.actual(&rounded, sense) - self.actual(command, sense)).norm()
        });
        moved.sum()
    }

    fn tip(&self, command: &AxisVector, sense: Option<&[i8; 9]>) -> Vector {
        let machine = &self.pair.machine;
        let chain = |axes: &[Axis]| {
            let data = axes.iter().map(|&axis| machine.axis(axis).unwrap());
            data.fold(Matrix4::<f64>::identity(), |chain, data| chain * self.axis(data, command, sense))
        };
        let mut tool = chain(&machine.topology.tool) * shift(machine.spindle.origin_mm);
        if sense.is_some() {
            tool *= displacement(self.pair.errors.spindle);
        }
        tool *= shift(self.pair.tool_mm);
        let seen: Matrix4<f64> = chain(&machine.topology.workpiece).try_inverse().unwrap() * tool;
        seen.fixed_view::<3, 1>(0, 3).into_owned()
    }

    fn axis(&self, data: &AxisData, command: &AxisVector, sense: Option<&[i8; 9]>) -> Matrix4<f64> {
        let position = command[data.axis];
        let motion = if data.axis.is_rotary() {
            Rotation3::from_scaled_axis(data.direction * position).to_homogeneous()
        } else {
            shift(data.direction * position)
        };
        let place = shift(data.point_mm);
        let back = shift(-data.point_mm);
        let Some(sense) = sense else { return place * motion * back };
        let errors = &self.pair.errors;
        let slot = data.axis.slot();
        let location = displacement(errors.location[slot]);
        let mut components = [0.0; 6];
        for (component, shape) in errors.motion[slot].iter() {
            components[*component] += shape.value(position, sense[slot]);
        }
        let error = displacement(components);
        match data.lever {
            Lever::Carried => place * location * motion * error * back,
            Lever::Fixed => place * location * error * motion * back,
        }
    }
}

/// The judge and the model of the correction agree about where the tip is.
pub(super) fn check_forward(pair: &Pair) {
    let model = Model::new(&pair.machine, &pair.model());
    let judge = Judge::new(pair);
    let mut random = Random(pair.seed ^ 0x5eed);
    for _ in 0..3 {
        let mut command = AxisVector::ZERO;
        let mut sense = [0; 9];
        for data in pair.machine.axes.iter().flatten() {
            let [low, high] = data.travel.unwrap();
            command[data.axis] = random.between(low, high);
            sense[data.axis.slot()] = [-1, 0, 1][random.below(3)];
        }
        let state = State { direction: sense, ..State::default() };
        let expected = model.actual(&command, &pair.tool_mm, &state).translation;
        let away_mm = (judge.actual(&command, &sense) - expected).norm();
        assert!(away_mm < 1e-9, "pair {}: judge and model differ by {away_mm:e} mm", pair.seed);
        let away_mm = (judge.ideal(&command) - model.nominal(&command, &pair.tool_mm).translation).norm();
        assert!(away_mm < 1e-9, "pair {}: {away_mm:e} mm without errors", pair.seed);
    }
}
