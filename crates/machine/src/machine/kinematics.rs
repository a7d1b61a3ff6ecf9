//! The machine without errors: where tip and tool axis are in the workpiece, and which axis commands bring them to a place.
//!
//! Directions of the tool are solved as R(k1, t1) · R(k2, t2) · s = u with two rotary axes wherever they stand in the chain, oblique
//! ones too (the second of the subproblems of Paden and Kahan); what the linear axes must do then follows from three linear equations.

use std::f64::consts::TAU;

use super::Machine;
use ncfix_base::geometry::{Axis, AxisVector, LINEAR_AXES, Matrix, Vector};

/// A tool axis this near to a rotary axis does not tell its angle: the sine of the angle between them.
const SINGULAR_SINE: f64 = 1e-7;
/// A direction that is out of reach by less is taken as the nearest one in reach, rad: vectors are written with few digits.
const REACH_RAD: f64 = 1e-5;
/// Travel limits are met with this in hand, mm or rad.
const TRAVEL_ROOM: f64 = 1e-9;
/// Linear axes whose directions span less than this cannot place the tip.
const LEAST_DETERMINANT: f64 = 1e-6;

/// The chain from the tool to the workpiece.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinematics {
    /// The axis nearest to the tool first.
    joints: Vec<Joint>,
    origin_mm: Vector,
    tool_axis: Vector,
    /// The linear axis of each direction: X, else U, and so on.
    linear: [Option<Axis>; 3],
}

/// An axis as the tool sees it: moved by the tool side, moved backwards by the workpiece side.
#[derive(Clone, Debug, PartialEq)]
struct Joint {
    axis: Axis,
    /// In F at the zero pose, turned about where the workpiece moves.
    direction: Vector,
    point_mm: Vector,
    travel: Option<[f64; 2]>,
}

impl Kinematics {
    /// The chain of a machine.
    #[must_use]
    pub fn new(machine: &Machine) -> Kinematics {
        let joint = |axis: &Axis, sense: f64| {
            machine.axis(*axis).map(|data| Joint {
                axis: *axis,
                direction: data.direction * sense,
                point_mm: data.point_mm,
                travel: data.travel,
            })
        };
        let tool = machine.topology.tool.iter().rev().filter_map(|axis| joint(axis, 1.0));
        let workpiece = machine.topology.workpiece.iter().filter_map(|axis| joint(axis, -1.0));
        let joints: Vec<Joint> = tool.chain(workpiece).collect();
        let mut linear = [None; 3];
        for axis in LINEAR_AXES.into_iter().filter(|&axis| joints.iter().any(|joint| joint.axis == axis)) {
            if let Some(place) = linear.get_mut(axis.dimension()) {
                place.get_or_insert(axis);
            }
        }
        Kinematics { joints, origin_mm: machine.spindle.origin_mm, tool_axis: machine.spindle.axis, linear }
    }

    /// The tool tip in the workpiece, mm, relative to the machine origin at the zero pose. `tool_mm` runs from the spindle gauge point
    /// to the tip, in F at the zero pose.
    #[must_use]
    pub fn tip_mm(&self, command: &AxisVector, tool_mm: &Vector) -> Vector {
        self.joints.iter().fold(self.origin_mm + tool_mm, |point, joint| joint.carry(&point, command[joint.axis]))
    }

    /// How far a rotary axis that goes to `end`, and nothing else, moves the tip in the workpiece, mm: by the arc about its line as the other
    /// axes have put that.
    #[must_use]
    pub fn arc_mm(&self, axis: Axis, (command, end): (&AxisVector, f64), tool_mm: &Vector) -> f64 {
        let mut turned = *command;
        turned[axis] = end;
        let [from, to] = [command, &turned].map(|command| self.tip_mm(command, tool_mm));
        (to - from).norm()
    }

    /// Direction of the tool in the workpiece, from the tip to the spindle.
    #[must_use]
    pub fn direction(&self, command: &AxisVector) -> Vector {
        self.turned(command, &self.tool_axis)
    }

    /// A vector that is fixed to the tool, given in F at the zero pose, as it stands in the workpiece.
    #[must_use]
    pub fn turned(&self, command: &AxisVector, vector: &Vector) -> Vector {
        self.rotary().fold(*vector, |vector, joint| turned(&vector, &joint.direction, command[joint.axis]))
    }

    /// How the tool is turned in the workpiece.
    #[must_use]
    pub fn rotation(&self, command: &AxisVector) -> Matrix {
        Matrix::from_columns(&[Vector::x(), Vector::y(), Vector::z()].map(|unit| self.turned(command, &unit)))
    }

    /// The rotary axes, the one nearest to the tool first.
    pub fn rotary_axes(&self) -> impl Iterator<Item = Axis> {
        self.rotary().map(|joint| joint.axis)
    }

    /// The linear axes that place the tip.
    pub fn placing_axes(&self) -> impl Iterator<Item = Axis> {
        self.linear.into_iter().flatten()
    }

    /// The command whose tip is at `tip_mm` with the rotary axes of `command`. Axes that take no part (U where there is X) stay as they
    /// are; `None` where the machine lacks a direction.
    #[must_use]
    pub fn placed(&self, tip_mm: &Vector, command: &AxisVector, tool_mm: &Vector) -> Option<AxisVector> {
        let mut out = *command;
        for axis in self.placing_axes() {
            out[axis] = 0.0;
        }
        let mut columns = [None; 3];
        let mut tip = self.origin_mm + tool_mm;
        for joint in &self.joints {
            tip = joint.carry(&tip, out[joint.axis]);
            if joint.axis.is_rotary() {
                for column in columns.iter_mut().flatten() {
                    *column = turned(column, &joint.direction, out[joint.axis]);
                }
            }
            for (column, axis) in columns.iter_mut().zip(self.linear) {
                if axis == Some(joint.axis) {
                    *column = Some(joint.direction);
                }
            }
        }
        let [Some(x), Some(y), Some(z)] = columns else { return None };
        let matrix = Matrix::from_columns(&[x, y, z]);
        if matrix.determinant().abs() < LEAST_DETERMINANT {
            return None;
        }
        let steps = matrix.try_inverse()? * (tip_mm - tip);
        for (axis, step) in self.placing_axes().zip(steps.iter()) {
            out[axis] = *step;
        }
        Some(out)
    }

    /// An axis command as a position fixed to the workpiece, the tool at its zero pose taken off: what a control programs under a five-axis
    /// transformation. At the zero pose of the rotary axes it is the command itself.
    #[must_use]
    pub fn on_workpiece(&self, command: &AxisVector, tool_mm: &Vector) -> AxisVector {
        let mut out = *command;
        out.set_xyz(self.tip_mm(command, tool_mm) - self.origin_mm - tool_mm);
        out
    }

    /// The command of such a position; `None` where the machine lacks X, Y or Z.
    #[must_use]
    pub fn command_on_workpiece(&self, position: &AxisVector, tool_mm: &Vector) -> Option<AxisVector> {
        if self.linear != [Some(Axis::X), Some(Axis::Y), Some(Axis::Z)] {
            return None;
        }
        self.placed(&(position.xyz() + self.origin_mm + tool_mm), position, tool_mm)
    }

    /// The direction of the tool at which the rotary axis nearest to the workpiece has no effect on it; `None` without two
    /// rotary axes.
    #[must_use]
    pub fn pole(&self) -> Option<Vector> {
        let outer = self.rotary().last()?;
        (self.rotary().count() >= 2).then_some(outer.direction)
    }

    /// The rotary angles that give the tool a direction in the workpiece: up to two ways, each by the turns nearest to `near` that the
    /// travel allows, the shorter way first. An axis whose angle the direction does not tell keeps that of `near`; of three
    /// rotary axes the one nearest to the tool stays.
    #[must_use]
    pub fn orientations(&self, direction: &Vector, near: &AxisVector) -> [Option<AxisVector>; 2] {
        let Some(wanted) = direction.try_normalize(0.0).filter(|wanted| wanted.iter().all(|part| part.is_finite()))
        else {
            return [None; 2];
        };
        let count = self.rotary().count();
        let mut start = self.tool_axis;
        // What stays does so before the two that turn.
        for joint in self.rotary().take(count.saturating_sub(2)) {
            start = turned(&start, &joint.direction, near[joint.axis]);
        }
        let mut turning = self.rotary().skip(count.saturating_sub(2));
        let found = match (turning.next(), turning.next()) {
            (None, _) => [close(&start, &wanted).then_some([0.0; 2]), None],
            (Some(only), None) => {
                let angle = angle_between(&start, &wanted, &only.direction).unwrap_or(near[only.axis]);
                let reached = turned(&start, &only.direction, angle);
                [close(&reached, &wanted).then_some([angle, 0.0]), None]
            }
            (Some(inner), Some(outer)) => two_angles(inner, outer, &start, &wanted, near),
        };
        let mut ways = found.map(|angles| {
            let mut out = *near;
            for (joint, angle) in self.rotary().skip(count.saturating_sub(2)).zip(angles?) {
                out[joint.axis] = joint.nearest(angle, near[joint.axis])?;
            }
            Some(out)
        });
        let way = |angles: &Option<AxisVector>| {
            angles.map_or(f64::INFINITY, |angles| {
                self.rotary().map(|joint| (angles[joint.axis] - near[joint.axis]).abs()).sum::<f64>()
            })
        };
        if way(&ways[1]) < way(&ways[0]) {
            ways.swap(0, 1);
        }
        ways
    }

    /// The shorter way of [`Self::orientations`].
    #[must_use]
    pub fn orientation(&self, direction: &Vector, near: &AxisVector) -> Option<AxisVector> {
        let [first, second] = self.orientations(direction, near);
        first.or(second)
    }

    /// How well the direction of the tool tells the angle of every rotary axis: the sine of the smallest angle between the tool and an
    /// axis that it could be parallel to; 1 without two rotary axes.
    #[must_use]
    pub fn distance_from_singularity(&self, command: &AxisVector) -> f64 {
        let count = self.rotary().count();
        if count < 2 {
            return 1.0;
        }
        let mut direction = self.tool_axis;
        let mut least = 1.0_f64;
        for (place, joint) in self.rotary().enumerate() {
            // Behind the axes nearer to the tool, the tool may stand along this one.
            if place > 0 {
                least = least.min(direction.cross(&joint.direction).norm());
            }
            direction = turned(&direction, &joint.direction, command[joint.axis]);
        }
        least
    }

    /// The axis whose command is outside its travel, if any.
    #[must_use]
    pub fn beyond_travel(&self, command: &AxisVector) -> Option<Axis> {
        let beyond = |joint: &&Joint| {
            let value = command[joint.axis];
            joint.travel.is_some_and(|[low, high]| !(low - TRAVEL_ROOM..=high + TRAVEL_ROOM).contains(&value))
        };
        self.joints.iter().find(beyond).map(|joint| joint.axis)
    }

    fn rotary(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|joint| joint.axis.is_rotary())
    }
}

impl Joint {
    fn carry(&self, point: &Vector, value: f64) -> Vector {
        if self.axis.is_rotary() {
            self.point_mm + turned(&(point - self.point_mm), &self.direction, value)
        } else {
            point + self.direction * value
        }
    }

    /// The angle, by full turns, that is nearest to `near` and within the travel.
    fn nearest(&self, angle: f64, near: f64) -> Option<f64> {
        let best = angle + ((near - angle) / TAU).round() * TAU;
        let Some([low, high]) = self.travel.map(|[low, high]| [low - TRAVEL_ROOM, high + TRAVEL_ROOM]) else {
            return Some(best);
        };
        if best < low {
            Some(best + ((low - best) / TAU).ceil() * TAU).filter(|angle| *angle <= high)
        } else if best > high {
            Some(best - ((best - high) / TAU).ceil() * TAU).filter(|angle| *angle >= low)
        } else {
            Some(best)
        }
    }
}

/// Both pairs of angles (inner, outer) that turn `start` to `wanted`: first by the inner axis, then by the outer one.
fn two_angles(
    inner: &Joint,
    outer: &Joint,
    start: &Vector,
    wanted: &Vector,
    near: &AxisVector,
) -> [Option<[f64; 2]>; 2] {
    let (k1, k2) = (&outer.direction, &inner.direction);
    let cosine = k1.dot(k2);
    let across = k1.cross(k2);
    let square = across.norm_squared();
    if square < SINGULAR_SINE * SINGULAR_SINE {
        // Parallel axes turn as one.
        let angle = angle_between(&turned(start, k2, near[inner.axis]), wanted, k1).unwrap_or(near[outer.axis]);
        let reached = turned(&turned(start, k2, near[inner.axis]), k1, angle);
        return [close(&reached, wanted).then_some([near[inner.axis], angle]), None];
    }
    let (by_outer, by_inner) = (k1.dot(wanted), k2.dot(start));
    let along_outer = (by_outer - cosine * by_inner) / square;
    let along_inner = (by_inner - cosine * by_outer) / square;
    let in_plane = along_outer.powi(2) + along_inner.powi(2) + 2.0 * along_outer * along_inner * cosine;
    let height = ((1.0 - in_plane) / square).max(0.0).sqrt();
    [height, -height].map(|height| {
        let between = k1 * along_outer + k2 * along_inner + across * height;
        let second = angle_between(start, &between, k2).unwrap_or(near[inner.axis]);
        let first = angle_between(&between, wanted, k1).unwrap_or(near[outer.axis]);
        let reached = turned(&turned(start, k2, second), k1, first);
        close(&reached, wanted).then_some([second, first])
    })
}

/// The angle about an axis from one direction to another; `None` where one of them is parallel to the axis.
fn angle_between(from: &Vector, to: &Vector, axis: &Vector) -> Option<f64> {
    let sines = from.cross(axis).norm().min(to.cross(axis).norm());
    let along = axis.dot(from) * axis.dot(to);
    (sines > SINGULAR_SINE).then(|| axis.dot(&from.cross(to)).atan2(from.dot(to) - along))
}

fn close(reached: &Vector, wanted: &Vector) -> bool {
    (reached - wanted).norm() < REACH_RAD
}

/// Rodrigues' formula.
fn turned(vector: &Vector, axis: &Vector, angle: f64) -> Vector {
    if angle == 0.0 {
        return *vector;
    }
    let (sine, cosine) = angle.sin_cos();
    let along = axis * axis.dot(vector);
    along + (vector - along) * cosine + axis.cross(vector) * sine
}
