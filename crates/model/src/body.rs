//! Bodies that are carried through the chain of axes: a point, a pose, or a point with its derivatives by all commands.
//!
//! The chain ([`super::link`]) is written once and moves any [`RigidBody`]; the amount of computation depends on the body.

use ncfix_base::geometry::{AXIS_COUNT, Axis, Matrix, Vector};

use super::name::Carrier;
use super::rotation::{Rotation, vector_of};

/// Place in the transform of an axis at which a body is observed, see [`super::link`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BodyPlace {
    /// Place of the location errors D(e0).
    Location,
    /// Place of the motion errors D(e).
    Motion,
}

/// Rigid body that is moved from the tool to the foundation and on to the workpiece.
pub(super) trait RigidBody {
    /// Translates it, mm.
    fn translate(&mut self, by: &Vector);

    /// Rotates it about the origin by an error, which is small.
    fn tilt(&mut self, by: &Rotation);

    /// Rotates it about the origin by the motion of a rotary axis.
    fn turn(&mut self, by: &Rotation);

    /// Observes the body at the place where an error of `carrier` acts, in coordinates whose origin is a point of the axis.
    fn visit(&mut self, _carrier: Carrier, _place: BodyPlace) {}

    /// Notes that an axis with this direction has just moved the body; `sense` is −1 on the workpiece side.
    fn moved(&mut self, _axis: Axis, _direction: &Vector, _sense: f64) {}
}

impl RigidBody for Vector {
    fn translate(&mut self, by: &Vector) {
        *self += by;
    }

    fn tilt(&mut self, by: &Rotation) {
        *self = by.apply(self);
    }

    fn turn(&mut self, by: &Rotation) {
        *self = by.apply(self);
    }
}

/// Pose of the tool: the map from tool coordinates (origin at the tip, parallel to F at the zero pose) to workpiece coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Directions of the tool frame in the workpiece frame, as columns.
    pub rotation: Matrix,
    /// Tool tip in the workpiece frame, mm.
    pub translation: Vector,
}

impl Pose {
    /// Returns a tool frame parallel to F with its tip at a point.
    pub(super) fn parallel_at(translation: Vector) -> Pose {
        Pose { rotation: Matrix::identity(), translation }
    }

    /// Returns the small rotation vector from this pose to another one, in this tool frame, rad.
    #[must_use]
    pub fn turn_to(&self, other: &Pose) -> Vector {
        vector_of(&(self.rotation.transpose() * other.rotation))
    }

    /// Returns the inverse of this pose times the other: the other as seen from this one.
    pub(super) fn inverse_times(&self, other: &Pose) -> Pose {
        let back = self.rotation.transpose();
        Pose { rotation: back * other.rotation, translation: back * (other.translation - self.translation) }
    }
}

impl RigidBody for Pose {
    fn translate(&mut self, by: &Vector) {
        self.translation += by;
    }

    fn tilt(&mut self, by: &Rotation) {
        let matrix = by.matrix();
        self.translation = matrix * self.translation;
        self.rotation = matrix * self.rotation;
    }

    fn turn(&mut self, by: &Rotation) {
        self.tilt(by);
    }
}

/// Tip and axis of the tool, without derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Tool tip, mm.
    pub(super) tip: Vector,
    /// Unit vector from the tip to the spindle.
    pub(super) axis: Vector,
}

impl RigidBody for Ray {
    fn translate(&mut self, by: &Vector) {
        self.tip += by;
    }

    fn tilt(&mut self, by: &Rotation) {
        self.tip = by.apply(&self.tip);
        self.axis = by.apply(&self.axis);
    }

    fn turn(&mut self, by: &Rotation) {
        self.tilt(by);
    }
}

/// Tip and axis of the tool with their derivatives by every axis command.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pointer {
    /// Tool tip, mm.
    pub(super) tip: Vector,
    /// Unit vector from the tip to the spindle.
    pub(super) axis: Vector,
    /// d tip / d command by slot, mm/mm or mm/rad.
    pub(super) tip_by_command: [Vector; AXIS_COUNT],
    /// d axis / d command by slot, 1/rad; zero for linear axes.
    pub(super) axis_by_command: [Vector; AXIS_COUNT],
    /// Axes that have been passed, in order.
    passed: [Axis; AXIS_COUNT],
    passed_count: usize,
}

impl Pointer {
    pub(super) fn new(tip: Vector, axis: Vector) -> Pointer {
        Pointer {
            tip,
            axis,
            tip_by_command: [Vector::zeros(); AXIS_COUNT],
            axis_by_command: [Vector::zeros(); AXIS_COUNT],
            passed: [Axis::X; AXIS_COUNT],
            passed_count: 0,
        }
    }
}

impl RigidBody for Pointer {
    fn translate(&mut self, by: &Vector) {
        self.tip += by;
    }

    /// Leaves the derivatives unchanged: an error rotates them by about 1e-4, which costs less in the iteration than here.
    fn tilt(&mut self, by: &Rotation) {
        self.tip = by.apply(&self.tip);
        self.axis = by.apply(&self.axis);
    }

    fn turn(&mut self, by: &Rotation) {
        self.tilt(by);
        for axis in &self.passed[..self.passed_count] {
            let slot = axis.slot();
            self.tip_by_command[slot] = by.apply(&self.tip_by_command[slot]);
            self.axis_by_command[slot] = by.apply(&self.axis_by_command[slot]);
        }
    }

    fn moved(&mut self, axis: Axis, direction: &Vector, sense: f64) {
        let slot = axis.slot();
        if axis.is_rotary() {
            self.tip_by_command[slot] = direction.cross(&self.tip) * sense;
            self.axis_by_command[slot] = direction.cross(&self.axis) * sense;
        } else {
            self.tip_by_command[slot] = direction * sense;
        }
        if let Some(next) = self.passed.get_mut(self.passed_count) {
            *next = axis;
            self.passed_count += 1;
        }
    }
}

/// Pose that also records the tool frame at the place where one error acts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Witness {
    pose: Pose,
    carrier: Carrier,
    place: BodyPlace,
    /// Tool frame in the coordinates in which the error acts.
    pub(super) seen: Option<Pose>,
}

impl Witness {
    pub(super) fn new(pose: Pose, carrier: Carrier, place: BodyPlace) -> Witness {
        Witness { pose, carrier, place, seen: None }
    }
}

impl RigidBody for Witness {
    fn translate(&mut self, by: &Vector) {
        self.pose.translate(by);
    }

    fn tilt(&mut self, by: &Rotation) {
        self.pose.tilt(by);
    }

    fn turn(&mut self, by: &Rotation) {
        self.pose.turn(by);
    }

    fn visit(&mut self, carrier: Carrier, place: BodyPlace) {
        if (carrier, place) == (self.carrier, self.place) {
            self.seen = Some(self.pose);
        }
    }
}
