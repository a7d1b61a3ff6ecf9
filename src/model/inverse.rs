//! Inverse kinematics with errors: the commands whose actual pose is the nominal one.
//!
//! Five rows are solved, the position of the tip and two components of the direction of the tool axis. The roll of the tool about its
//! own axis is free: demanding it too (the six-row pseudo-inverse of Esmaeili 2021, eq. 37) spends rotary motion on what cuts nothing
//! and leaves the axis tilted.
//!
//! **Orientation** is corrected by the rotary axes alone. With Jₒ the 2 × n matrix of the tool axis direction by the rotary commands
//! at the nominal pose, the correction is Δ = Jₒᵀ y, one y per eigenvector of Jₒ Jₒᵀ, and y solves
//!
//! ```text
//! r(q + Jₒᵀ y) + λ² y = 0,   λ² = ε² (1 − (s/ε)²)² where the singular value s < ε, else 0
//! ```
//!
//! with r the two components of the actual axis direction. Away from a singularity that is exact. Near one, where the tool axis is
//! almost parallel to a rotary axis and a small tilt would take a large motion, the damping (Tikhonov) bounds the motion and lets part
//! of the tilt stand; because it acts on the whole correction and not on its steps, iterating does not creep back.
//!
//! **Position** comes first: whatever the rotary axes do, the linear axes bring the tip to its place exactly. A machine with less than
//! three linear axes corrects the directions that it has.

use crate::geometry::{AXES, Axis, AxisSet, AxisVector, LINEAR_AXES, Matrix, ROTARY_AXES, Vector};
use crate::machine::State;

use super::Model;
use super::body::Pointer;

/// The tip is in its place when it is this near, mm; a tenth of what is promised.
const POSITION_LIMIT_MM: f64 = 1e-7;
/// Promised accuracy of the tip, mm.
const PROMISED_MM: f64 = 1e-6;
/// The orientation is found when a step would change it by less, rad.
const DIRECTION_LIMIT_RAD: f64 = 1e-9;
/// ε: singular value below which the orientation is damped; 2.9° from the singularity of two crossed rotary axes.
const SINGULAR_LIMIT: f64 = 0.05;
/// Eigenvalue of Jₒ Jₒᵀ below which a start says nothing about y.
const BLIND_LIMIT: f64 = 1e-6;
/// A start whose rotary commands are farther from the nominal ones is no start, rad.
const START_LIMIT_RAD: f64 = 0.1;
/// More steps than ever needed: errors of 1e-4 are divided by about 1e3 at each.
const MAX_STEPS: usize = 30;

/// What a solution may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solve {
    /// Tip position and tool axis direction, with linear and rotary axes.
    Full,
    /// Tip position only, with the linear axes; rotary commands stay those of the start (they were rounded to the increment).
    PositionOnly,
}

/// No command was found whose tip is within 1e-6 mm of the nominal one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotConverged {
    /// How far the last tip was from its place, mm; not a number where the model gave none.
    pub residual_mm: f64,
}

impl Model {
    /// The command whose actual pose is the nominal pose of `nominal`, iterated from `start` (the nominal command, or better that plus the
    /// correction of a neighboring point). Axes that take no part (rotary axes under [`Solve::PositionOnly`], U where there is X) keep
    /// their nominal, rotary ones their starting command.
    ///
    /// # Errors
    /// [`NotConverged`] when the tip cannot be brought to its place, although the machine has three linear axes that span space there.
    pub fn solve(
        &self,
        nominal: &AxisVector,
        tool_mm: &Vector,
        state: &State,
        start: &AxisVector,
        mode: Solve,
    ) -> Result<AxisVector, NotConverged> {
        let rotary = self.axes().intersection(ROTARY_AXES.into_iter().collect());
        let linear = LinearAxes::of(self.axes());
        let mut command = *nominal;
        for axis in linear.0.into_iter().flatten().filter(|&axis| start[axis].is_finite()) {
            command[axis] = start[axis];
        }
        if mode == Solve::PositionOnly {
            rotary.iter().filter(|&axis| start[axis].is_finite()).for_each(|axis| command[axis] = start[axis]);
        }
        let rotary_as_nominal = rotary.iter().all(|axis| command[axis] == nominal[axis]);
        if self.is_empty() && (mode == Solve::Full || rotary_as_nominal) {
            return Ok(*nominal);
        }
        if rotary.is_empty() {
            let target = self.tip(nominal, tool_mm, None);
            return self.reach_straight(&linear, target, command, tool_mm, state);
        }
        let target = self.pointer(nominal, tool_mm, None);
        if mode == Solve::Full {
            let orientation = Orientation::at(&target, rotary);
            self.reach_both(&linear, &orientation, &target, command, start, tool_mm, state)
        } else {
            self.reach(&linear, target.tip, command, tool_mm, state)
        }
    }

    fn axes(&self) -> AxisSet {
        self.tool_side.iter().chain(&self.workpiece_side).map(|link| link.axis).collect()
    }

    /// Position on a machine without rotary axes: the derivatives are the directions of the axes.
    fn reach_straight(
        &self,
        linear: &LinearAxes,
        target: Vector,
        mut command: AxisVector,
        tool_mm: &Vector,
        state: &State,
    ) -> Result<AxisVector, NotConverged> {
        let mut columns = linear.0.map(|_| Vector::zeros());
        for (links, sense) in [(&self.tool_side, 1.0), (&self.workpiece_side, -1.0)] {
            for link in links {
                if linear.0[link.axis.dimension()] == Some(link.axis) {
                    columns[link.axis.dimension()] = link.direction * sense;
                }
            }
        }
        let step = LinearStep::new(linear, columns)?;
        let mut residual_mm = f64::NAN;
        for _ in 0..MAX_STEPS {
            let residual = target - self.tip(&command, tool_mm, Some(state));
            residual_mm = step.reachable(&residual).norm();
            if residual_mm < POSITION_LIMIT_MM {
                return Ok(command);
            }
            step.apply(&residual, &mut command);
        }
        last_resort(command, residual_mm)
    }

    /// Position by the linear axes at the rotary commands given.
    fn reach(
        &self,
        linear: &LinearAxes,
        target: Vector,
        mut command: AxisVector,
        tool_mm: &Vector,
        state: &State,
    ) -> Result<AxisVector, NotConverged> {
        let mut residual_mm = f64::NAN;
        for _ in 0..MAX_STEPS {
            let now = self.pointer(&command, tool_mm, Some(state));
            let step = LinearStep::new(linear, linear.columns(&now))?;
            let residual = target - now.tip;
            residual_mm = step.reachable(&residual).norm();
            if residual_mm < POSITION_LIMIT_MM {
                return Ok(command);
            }
            step.apply(&residual, &mut command);
        }
        last_resort(command, residual_mm)
    }

    /// Orientation by the rotary axes and position by the linear ones, in common steps.
    #[expect(clippy::too_many_arguments, reason = "the parts of one problem, split off for the length of the function")]
    fn reach_both(
        &self,
        linear: &LinearAxes,
        orientation: &Orientation,
        target: &Pointer,
        mut command: AxisVector,
        start: &AxisVector,
        tool_mm: &Vector,
        state: &State,
    ) -> Result<AxisVector, NotConverged> {
        let nominal = command;
        let mut dual = orientation.dual_of(&nominal, start);
        orientation.turn(&nominal, &dual, &mut command);
        for _ in 0..MAX_STEPS {
            let now = self.pointer(&command, tool_mm, Some(state));
            let step = LinearStep::new(linear, linear.columns(&now))?;
            let mut residual = target.tip - now.tip;
            let (dual_step, tilt) = orientation.step(&now.axis, &dual);
            let distance = step.reachable(&residual).norm();
            if distance < POSITION_LIMIT_MM && tilt < DIRECTION_LIMIT_RAD {
                return Ok(command);
            }
            if !(distance + tilt).is_finite() {
                return Err(NotConverged { residual_mm: f64::NAN });
            }
            let before = command;
            dual[0] += dual_step[0];
            dual[1] += dual_step[1];
            orientation.turn(&nominal, &dual, &mut command);
            // What the rotary step does to the tip is taken back in the same step.
            for &axis in orientation.axes() {
                residual -= now.tip_by_command[axis.slot()] * (command[axis] - before[axis]);
            }
            step.apply(&residual, &mut command);
        }
        // The orientation would not settle (a step in an error table, say); the position still must.
        self.reach(linear, target.tip, command, tool_mm, state)
    }
}

/// Steps are used up: what is within the promise is good enough.
fn last_resort(command: AxisVector, residual_mm: f64) -> Result<AxisVector, NotConverged> {
    if residual_mm < PROMISED_MM { Ok(command) } else { Err(NotConverged { residual_mm }) }
}

/// The axis that corrects each direction of space: X, else U, and so on.
struct LinearAxes([Option<Axis>; 3]);

impl LinearAxes {
    fn of(axes: AxisSet) -> LinearAxes {
        let mut linear = [None; 3];
        for axis in LINEAR_AXES.into_iter().filter(|&axis| axes.contains(axis)) {
            linear[axis.dimension()].get_or_insert(axis);
        }
        LinearAxes(linear)
    }

    fn columns(&self, pointer: &Pointer) -> [Vector; 3] {
        self.0.map(|axis| axis.map_or(Vector::zeros(), |axis| pointer.tip_by_command[axis.slot()]))
    }
}

/// The step of the linear axes that takes a residual away, in the least-squares sense where there are less than three.
struct LinearStep {
    axes: [Option<Axis>; 3],
    columns: Matrix,
    inverse: Matrix,
}

impl LinearStep {
    /// From the derivatives of the tip by each linear command; zero where the machine has no axis.
    fn new(linear: &LinearAxes, columns: [Vector; 3]) -> Result<LinearStep, NotConverged> {
        let filled = fill(&linear.0, columns);
        // The adjugate: its rows are the cross products of the columns.
        let rows = [filled[1].cross(&filled[2]), filled[2].cross(&filled[0]), filled[0].cross(&filled[1])];
        let determinant = rows[0].dot(&filled[0]);
        // Axes that have become parallel, as X and Y behind a rotary axis may, cannot place the tip.
        if !(determinant.abs() > 1e-6) {
            return Err(NotConverged { residual_mm: f64::NAN });
        }
        let inverse = Matrix::from_columns(&rows.map(|row| row / determinant)).transpose();
        Ok(LinearStep { axes: linear.0, columns: Matrix::from_columns(&columns), inverse })
    }

    /// The part of a residual that the axes can take away, mm.
    fn reachable(&self, residual: &Vector) -> Vector {
        if self.axes.iter().all(Option::is_some) { *residual } else { self.columns * (self.inverse * residual) }
    }

    fn apply(&self, residual: &Vector, command: &mut AxisVector) {
        let step = self.inverse * residual;
        for (axis, step) in self.axes.iter().zip(step.iter()) {
            if let Some(axis) = axis {
                command[*axis] += step;
            }
        }
    }
}

/// Puts unit vectors at right angles to the others in the place of missing columns; the rows of the inverse that belong to the others
/// are then those of the pseudo-inverse.
fn fill(axes: &[Option<Axis>; 3], mut columns: [Vector; 3]) -> [Vector; 3] {
    let missing: [bool; 3] = axes.map(|axis| axis.is_none());
    match missing.iter().filter(|&&missing| missing).count() {
        0 => columns,
        1 => {
            let hole = missing.iter().position(|&missing| missing).unwrap_or(0);
            let normal = columns[(hole + 1) % 3].cross(&columns[(hole + 2) % 3]);
            columns[hole] = normal.try_normalize(1e-9).unwrap_or_default();
            columns
        }
        2 => {
            let only = missing.iter().position(|&missing| !missing).unwrap_or(0);
            let helper = Vector::ith(columns[only].iamin(), 1.0);
            columns[(only + 1) % 3] = columns[only].cross(&helper).try_normalize(1e-9).unwrap_or_default();
            columns[(only + 2) % 3] =
                columns[only].cross(&columns[(only + 1) % 3]).try_normalize(1e-9).unwrap_or_default();
            columns
        }
        _ => [Vector::x(), Vector::y(), Vector::z()],
    }
}

/// The orientation problem at one nominal pose, split along the eigenvectors of Jₒ Jₒᵀ so that its two rows do not mix.
struct Orientation {
    rotary: [Axis; 3],
    count: usize,
    /// Eigenvectors in the workpiece frame, at right angles to the nominal tool axis.
    tangents: [Vector; 2],
    /// Rows of Jₒ along the eigenvectors.
    rows: [[f64; 3]; 2],
    /// s²: eigenvalues.
    gains: [f64; 2],
    /// λ².
    dampings: [f64; 2],
}

impl Orientation {
    fn at(target: &Pointer, set: AxisSet) -> Orientation {
        let mut rotary = [Axis::A; 3];
        let mut count = 0;
        for axis in AXES.into_iter().filter(|&axis| set.contains(axis)).take(3) {
            rotary[count] = axis;
            count += 1;
        }
        let derivatives = rotary.map(|axis| target.axis_by_command[axis.slot()]);
        let first = target.axis.cross(&Vector::ith(target.axis.iamin(), 1.0)).normalize();
        let second = target.axis.cross(&first);
        let (mut g11, mut g12, mut g22) = (0.0, 0.0, 0.0);
        for derivative in &derivatives[..count] {
            let (along, across) = (first.dot(derivative), second.dot(derivative));
            g11 += along * along;
            g12 += along * across;
            g22 += across * across;
        }
        // The angle that makes the 2 × 2 matrix diagonal.
        let (sine, cosine) = (0.5 * (2.0 * g12).atan2(g11 - g22)).sin_cos();
        let tangents = [first * cosine + second * sine, second * cosine - first * sine];
        let mut orientation =
            Orientation { rotary, count, tangents, rows: [[0.0; 3]; 2], gains: [0.0; 2], dampings: [0.0; 2] };
        for k in 0..2 {
            for (i, derivative) in derivatives[..count].iter().enumerate() {
                orientation.rows[k][i] = tangents[k].dot(derivative);
            }
            let gain: f64 = orientation.rows[k].iter().map(|entry| entry * entry).sum();
            orientation.gains[k] = gain;
            orientation.dampings[k] = damping(gain);
        }
        orientation
    }

    fn axes(&self) -> &[Axis] {
        &self.rotary[..self.count]
    }

    /// The y that gives the rotary corrections of a start; zero where the start is no use.
    fn dual_of(&self, nominal: &AxisVector, start: &AxisVector) -> [f64; 2] {
        let near = self.axes().iter().all(|&axis| (start[axis] - nominal[axis]).abs() < START_LIMIT_RAD);
        [0, 1].map(|k| {
            if !near || self.gains[k] < BLIND_LIMIT {
                return 0.0;
            }
            let corrections = self.axes().iter().zip(self.rows[k]);
            corrections.map(|(&axis, entry)| entry * (start[axis] - nominal[axis])).sum::<f64>() / self.gains[k]
        })
    }

    /// Sets the rotary commands to nominal + Jₒᵀ y.
    fn turn(&self, nominal: &AxisVector, dual: &[f64; 2], command: &mut AxisVector) {
        for (i, &axis) in self.axes().iter().enumerate() {
            command[axis] = nominal[axis] + self.rows[0][i] * dual[0] + self.rows[1][i] * dual[1];
        }
    }

    /// The step of y, and by how much the tool axis would turn with it, rad.
    fn step(&self, axis: &Vector, dual: &[f64; 2]) -> ([f64; 2], f64) {
        let step = [0, 1].map(|k| {
            let remainder = self.tangents[k].dot(axis) + self.dampings[k] * dual[k];
            -remainder / (self.gains[k] + self.dampings[k])
        });
        (step, (step[0] * self.gains[0]).hypot(step[1] * self.gains[1]))
    }
}

/// λ² for an eigenvalue s²: none from ε on, ε² at the singularity, with a continuous derivative between.
fn damping(gain: f64) -> f64 {
    let limit = SINGULAR_LIMIT * SINGULAR_LIMIT;
    if gain >= limit { 0.0 } else { limit * (1.0 - gain / limit).powi(2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_ends_smoothly() {
        let limit = SINGULAR_LIMIT * SINGULAR_LIMIT;
        assert_eq!(damping(0.0), limit);
        assert_eq!(damping(limit), 0.0);
        assert!(damping(limit * (1.0 - 1e-6)) < 1e-11 * limit);
        // Never less than three quarters of ε² in the sum that is divided by: 1 − x + x² at x = 1/2.
        for tenth in 0..=10 {
            let gain = limit * f64::from(tenth) / 10.0;
            assert!(gain + damping(gain) >= 0.75 * limit * (1.0 - 1e-12));
        }
    }

    #[test]
    fn missing_linear_axes_leave_the_least_squares_step() {
        let linear = LinearAxes([Some(Axis::X), None, Some(Axis::Z)]);
        let columns = [Vector::new(1.0, 0.2, 0.0), Vector::zeros(), Vector::new(0.0, 0.0, -1.0)];
        let step = LinearStep::new(&linear, columns).unwrap();
        let mut command = AxisVector::ZERO;
        step.apply(&Vector::new(1.0, 1.0, 1.0), &mut command);
        // Projection on (1, 0.2, 0): 1.2 / 1.04.
        assert!((command[Axis::X] - 1.2 / 1.04).abs() < 1e-15);
        assert_eq!((command[Axis::Y], command[Axis::Z]), (0.0, -1.0));
        let single = LinearAxes([None, Some(Axis::V), None]);
        let step = LinearStep::new(&single, [Vector::zeros(), Vector::new(0.6, 0.8, 0.0), Vector::zeros()]).unwrap();
        let reachable = step.reachable(&Vector::new(0.6, 0.8, 5.0));
        assert!((reachable - Vector::new(0.6, 0.8, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn parallel_linear_axes_are_refused() {
        let linear = LinearAxes([Some(Axis::X), Some(Axis::Y), Some(Axis::Z)]);
        assert!(LinearStep::new(&linear, [Vector::x(), Vector::x(), Vector::z()]).is_err());
        assert!(LinearStep::new(&linear, [Vector::x(), Vector::repeat(f64::NAN), Vector::z()]).is_err());
    }
}
