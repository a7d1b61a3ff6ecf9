//! Kinematics of the machine without errors: position of tip and tool axis in the workpiece, and the axis commands for a position.
//!
//! Tool directions are solved as R(k1, t1) · R(k2, t2) · s = u with two rotary axes at any place in the chain, including oblique ones (the second of the
//! subproblems of Paden and Kahan). The commands of the linear axes then follow from three linear equations.

use std::f64::consts::TAU;

use super::Machine;
use ncfix_base::geometry::{Axis, AxisVector, LINEAR_AXES, Matrix, Vector};

/// If the tool axis is this close to a rotary axis, its angle is not determined: sine of the angle between them.
const SINGULAR_SINE: f64 = 1e-7;
/// A direction that is out of reach by less is replaced by the nearest one in reach, rad: vectors are written with few digits.
const REACH_RAD: f64 = 1e-5;
/// Tolerance of the travel limits, mm or rad.
const TRAVEL_ROOM: f64 = 1e-9;
/// Linear axes whose directions span less than this cannot position the tip.
const LEAST_DETERMINANT: f64 = 1e-6;

/// Kinematic chain from the tool to the workpiece.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinematics {
    /// Joints, starting at the tool.
    joints: Vec<Joint>,
    origin_mm: Vector,
    tool_axis: Vector,
    /// Linear axis of each direction: X, else U, and so on.
    linear: [Option<Axis>; 3],
    /// Angle from a pole below which the control moves the rotary axes in proportion, rad.
    pole_limit_rad: f64,
}

/// Axis as seen from the tool: positive on the tool side, reversed on the workpiece side.
#[derive(Clone, Debug, PartialEq)]
struct Joint {
    axis: Axis,
    /// In F at the zero pose, reversed if the axis moves the workpiece.
    direction: Vector,
    point_mm: Vector,
    travel: Option<[f64; 2]>,
    /// Maximum feed of a rotary axis, rad/min, infinite if not given.
    most_rad_min: f64,
}

impl Kinematics {
    /// Creates the chain of a machine.
    #[must_use]
    pub fn new(machine: &Machine) -> Kinematics {
        let joint = |axis: &Axis, sense: f64| {
            machine.axis(*axis).map(|data| Joint {
                axis: *axis,
                direction: data.direction * sense,
                point_mm: data.point_mm,
                travel: data.travel,
                most_rad_min: data.max_feed.map_or(f64::INFINITY, f64::to_radians),
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
        Kinematics {
            joints,
            origin_mm: machine.spindle.origin_mm,
            tool_axis: machine.spindle.axis,
            linear,
            pole_limit_rad: machine.control.pole_limit_rad,
        }
    }

    /// Creates the chain of a machine with one of its heads.
    #[must_use]
    pub fn of_head(machine: &Machine, head: u16) -> Kinematics {
        let mut out = Kinematics::new(machine);
        out.set_head(machine, head);
        out
    }

    /// Replaces the spindle by that of a head of the machine.
    pub fn set_head(&mut self, machine: &Machine, head: u16) {
        let spindle = machine.spindle_of(head);
        (self.origin_mm, self.tool_axis) = (spindle.origin_mm, spindle.axis);
    }

    /// Returns the tool tip in the workpiece, mm, relative to the machine origin at the zero pose. `tool_mm` runs from the spindle gauge point to the tip, in
    /// F at the zero pose.
    #[must_use]
    pub fn tip_mm(&self, command: &AxisVector, tool_mm: &Vector) -> Vector {
        self.joints.iter().fold(self.origin_mm + tool_mm, |point, joint| joint.carry(&point, command[joint.axis]))
    }

    /// Returns the length of the arc by which the tip moves in the workpiece if only one rotary axis moves to `end`, mm. The other axes determine the
    /// position of its line.
    #[must_use]
    pub fn arc_mm(&self, axis: Axis, (command, end): (&AxisVector, f64), tool_mm: &Vector) -> f64 {
        let mut turned = *command;
        turned[axis] = end;
        let [from, to] = [command, &turned].map(|command| self.tip_mm(command, tool_mm));
        (to - from).norm()
    }

    /// Returns the direction of the tool in the workpiece, from the tip to the spindle.
    #[must_use]
    pub fn direction(&self, command: &AxisVector) -> Vector {
        self.turned(command, &self.tool_axis)
    }

    /// Returns the direction of the tool from the tip to the spindle, in F at the zero pose.
    #[must_use]
    pub fn tool_axis(&self) -> &Vector {
        &self.tool_axis
    }

    /// Returns a vector fixed to the tool, given in F at the zero pose, in its current orientation in the workpiece.
    #[must_use]
    pub fn turned(&self, command: &AxisVector, vector: &Vector) -> Vector {
        self.rotary().fold(*vector, |vector, joint| turned(&vector, &joint.direction, command[joint.axis]))
    }

    /// Returns the rotation of the tool in the workpiece.
    #[must_use]
    pub fn rotation(&self, command: &AxisVector) -> Matrix {
        Matrix::from_columns(&[Vector::x(), Vector::y(), Vector::z()].map(|unit| self.turned(command, &unit)))
    }

    /// Returns the rotary axes, starting at the tool.
    pub fn rotary_axes(&self) -> impl Iterator<Item = Axis> {
        self.rotary().map(|joint| joint.axis)
    }

    /// Returns the maximum feed of a rotary axis, rad/min; infinite if the machine file does not give it.
    #[must_use]
    pub fn most_rad_min(&self, axis: Axis) -> f64 {
        self.rotary().find(|joint| joint.axis == axis).map_or(f64::INFINITY, |joint| joint.most_rad_min)
    }

    /// Returns the linear axes that position the tip.
    pub fn placing_axes(&self) -> impl Iterator<Item = Axis> {
        self.linear.into_iter().flatten()
    }

    /// Returns the command whose tip is at `tip_mm` with the rotary axes of `command`. Axes that take no part (U if there is X) keep their values. `None` if
    /// the machine lacks a direction.
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

    /// Converts an axis command to a position fixed to the workpiece, minus the tool at its zero pose. This is the position that is programmed under a
    /// five-axis transformation. At the zero pose of the rotary axes it equals the command.
    #[must_use]
    pub fn on_workpiece(&self, command: &AxisVector, tool_mm: &Vector) -> AxisVector {
        let mut out = *command;
        out.set_xyz(self.tip_mm(command, tool_mm) - self.origin_mm - tool_mm);
        out
    }

    /// Returns the command of such a position; `None` if the machine lacks X, Y or Z.
    #[must_use]
    pub fn command_on_workpiece(&self, position: &AxisVector, tool_mm: &Vector) -> Option<AxisVector> {
        if self.linear != [Some(Axis::X), Some(Axis::Y), Some(Axis::Z)] {
            return None;
        }
        self.placed(&(position.xyz() + self.origin_mm + tool_mm), position, tool_mm)
    }

    /// Returns the tool direction at which the rotary axis nearest to the workpiece has no effect on it. `None` without two rotary axes.
    #[must_use]
    pub fn pole(&self) -> Option<Vector> {
        let outer = self.rotary().last()?;
        (self.rotary().count() >= 2).then_some(outer.direction)
    }

    /// Returns the angle from a pole below which the control moves the rotary axes in proportion instead of along a great circle, rad.
    #[must_use]
    pub fn pole_limit_rad(&self) -> f64 {
        self.pole_limit_rad
    }

    /// Returns the rotary angles that give the tool a direction in the workpiece: up to two solutions, the shorter path first. Each uses the turns nearest to
    /// `near` within the travel. An axis whose angle is not determined by the direction keeps that of `near`. Of three rotary axes the one nearest to the
    /// tool stays.
    #[must_use]
    pub fn orientations(&self, direction: &Vector, near: &AxisVector) -> [Option<AxisVector>; 2] {
        let Some(wanted) = direction.try_normalize(0.0).filter(|wanted| wanted.iter().all(|part| part.is_finite()))
        else {
            return [None; 2];
        };
        let count = self.rotary().count();
        let mut start = self.tool_axis;
        // The axes that stay act before the two that rotate.
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

    /// Returns the solution of [`Self::orientations`] with the shorter path.
    #[must_use]
    pub fn orientation(&self, direction: &Vector, near: &AxisVector) -> Option<AxisVector> {
        let [first, second] = self.orientations(direction, near);
        first.or(second)
    }

    /// Returns how well the tool direction determines the angles of all rotary axes: the sine of the smallest angle between the tool and an axis that it
    /// could be parallel to. 1 without two rotary axes.
    #[must_use]
    pub fn distance_from_singularity(&self, command: &AxisVector) -> f64 {
        let count = self.rotary().count();
        if count < 2 {
            return 1.0;
        }
        let mut direction = self.tool_axis;
        let mut least = 1.0_f64;
        for (place, joint) in self.rotary().enumerate() {
            // After the rotation by the axes nearer to the tool, the tool may be parallel to this one.
            if place > 0 {
                least = least.min(direction.cross(&joint.direction).norm());
            }
            direction = turned(&direction, &joint.direction, command[joint.axis]);
        }
        least
    }

    /// Returns the first axis whose command is outside its travel.
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

    /// Returns the angle, modulo full turns, that is nearest to `near` and within the travel.
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

/// Returns both pairs of angles (inner, outer) that rotate `start` to `wanted`: first about the inner axis, then about the outer one.
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
        // Parallel axes act as one.
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

/// Returns the angle about an axis from one direction to another; `None` if one of them is parallel to the axis.
fn angle_between(from: &Vector, to: &Vector, axis: &Vector) -> Option<f64> {
    let sines = from.cross(axis).norm().min(to.cross(axis).norm());
    let along = axis.dot(from) * axis.dot(to);
    (sines > SINGULAR_SINE).then(|| axis.dot(&from.cross(to)).atan2(from.dot(to) - along))
}

fn close(reached: &Vector, wanted: &Vector) -> bool {
    (reached - wanted).norm() < REACH_RAD
}

/// Rotates a vector about an axis by Rodrigues' formula.
fn turned(vector: &Vector, axis: &Vector, angle: f64) -> Vector {
    if angle == 0.0 {
        return *vector;
    }
    let (sine, cosine) = angle.sin_cos();
    let along = axis * axis.dot(vector);
    along + (vector - along) * cosine + axis.cross(vector) * sine
}
