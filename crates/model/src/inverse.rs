//! Inverse kinematics with errors: the commands whose actual pose is the nominal one.
//!
//! Five rows are solved, the position of the tip and two components of the direction of the tool axis. The roll of the tool about its
//! own axis is free: demanding it too (the six-row pseudo-inverse of Esmaeili 2021, eq. 37) spends rotary motion on what cuts nothing
//! and leaves the axis tilted.
//!
//! Orientation is corrected by the rotary axes alone, damped near a singularity ([`super::orientation`]).
//! Position comes first: whatever the rotary axes do, the linear axes bring the tip to its place exactly. A machine with less than
//! three linear axes corrects the directions that it has.

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::State;

use super::Model;
use super::body::Pointer;
use super::linear::{LinearStep, Singular};
use super::orientation::OrientationProblem;

/// The tip is in its place when it is this near, mm; a tenth of what is promised.
const POSITION_LIMIT_MM: f64 = 1e-7;
/// Promised accuracy of the tip, mm.
const PROMISED_MM: f64 = 1e-6;
/// The orientation is found when a step would change it by less, rad.
const DIRECTION_LIMIT_RAD: f64 = 1e-9;
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
    /// The command whose actual pose is the nominal pose of `nominal`, iterated from `start`: the nominal command, or better that plus
    /// the correction of a neighboring point. Axes that take no part (U where there is X) stay at their nominal command, rotary axes under
    /// [`Solve::PositionOnly`] at that of the start. Without errors the nominal command itself is returned, bit by bit.
    ///
    /// # Errors
    /// [`NotConverged`] when the tip cannot be brought to its place.
    pub fn solve(
        &self,
        nominal: &AxisVector,
        tool_mm: &Vector,
        state: &State,
        start: &AxisVector,
        mode: Solve,
    ) -> Result<AxisVector, NotConverged> {
        let mut command = *nominal;
        for axis in self.linear.axes().filter(|&axis| start[axis].is_finite()) {
            command[axis] = start[axis];
        }
        if mode == Solve::PositionOnly {
            self.rotary.iter().filter(|&axis| start[axis].is_finite()).for_each(|axis| command[axis] = start[axis]);
        }
        if self.is_empty() && self.rotary.iter().all(|axis| command[axis] == nominal[axis]) {
            return Ok(*nominal);
        }
        let search = Search { model: self, tool_mm, state };
        if let Some(step) = self.straight_step() {
            return search.straight_position(
                step.as_ref().map_err(|&singular| singular)?,
                self.nominal_tip(nominal, tool_mm),
                command,
            );
        }
        let target = self.pointer(nominal, tool_mm, None);
        match mode {
            Solve::Full => search.pose(&target, nominal, start, command),
            Solve::PositionOnly => search.position(target.tip, command),
        }
    }

    /// Whether the rotary axes stand so near to a singularity that [`Solve::Full`] damps the orientation.
    #[must_use]
    pub fn is_near_singularity(&self, command: &AxisVector, tool_mm: &Vector) -> bool {
        !self.rotary.is_empty()
            && OrientationProblem::at(&self.pointer(command, tool_mm, None), self.rotary).is_damped()
    }
}

/// What stays the same while one solution is looked for.
struct Search<'a> {
    model: &'a Model,
    tool_mm: &'a Vector,
    state: &'a State,
}

impl Search<'_> {
    fn pointer(&self, command: &AxisVector) -> Pointer {
        self.model.pointer(command, self.tool_mm, Some(self.state))
    }

    /// Position on a machine without rotary axes: the derivatives are the directions of the axes.
    fn straight_position(
        &self,
        step: &LinearStep,
        target: Vector,
        mut command: AxisVector,
    ) -> Result<AxisVector, NotConverged> {
        let mut residual_mm = f64::NAN;
        for _ in 0..MAX_STEPS {
            let residual = target - self.model.tip(&command, self.tool_mm, Some(self.state));
            residual_mm = step.reachable(&residual).norm();
            // The step is known already, so what is left is taken away as well: it is far below the limit then.
            step.apply(&residual, &mut command);
            if residual_mm < POSITION_LIMIT_MM {
                return Ok(command);
            }
        }
        last_resort(command, residual_mm)
    }

    /// Position by the linear axes, at the rotary commands given.
    fn position(&self, target: Vector, mut command: AxisVector) -> Result<AxisVector, NotConverged> {
        let mut residual_mm = f64::NAN;
        for _ in 0..MAX_STEPS {
            let now = self.pointer(&command);
            let step = LinearStep::new(&self.model.linear, self.model.linear.columns(&now))?;
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
    fn pose(
        &self,
        target: &Pointer,
        nominal: &AxisVector,
        start: &AxisVector,
        mut command: AxisVector,
    ) -> Result<AxisVector, NotConverged> {
        let orientation = OrientationProblem::at(target, self.model.rotary);
        let mut dual = orientation.dual_of(nominal, start);
        orientation.turn(nominal, &dual, &mut command);
        for _ in 0..MAX_STEPS {
            let now = self.pointer(&command);
            let step = LinearStep::new(&self.model.linear, self.model.linear.columns(&now))?;
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
            orientation.turn(nominal, &dual, &mut command);
            // What the rotary step does to the tip is taken back in the same step.
            for &axis in orientation.axes() {
                residual -= now.tip_by_command[axis.slot()] * (command[axis] - before[axis]);
            }
            step.apply(&residual, &mut command);
        }
        // The orientation would not settle (a step in an error table, say); the position still must.
        self.position(target.tip, command)
    }
}

impl From<Singular> for NotConverged {
    fn from(_: Singular) -> NotConverged {
        NotConverged { residual_mm: f64::NAN }
    }
}

/// Steps are used up: what is within the promise is good enough.
fn last_resort(command: AxisVector, residual_mm: f64) -> Result<AxisVector, NotConverged> {
    if residual_mm < PROMISED_MM { Ok(command) } else { Err(NotConverged { residual_mm }) }
}
