//! Inverse kinematics with errors: commands whose actual pose is the nominal one.
//!
//! Five rows are solved: the position of the tip and two components of the direction of the tool axis. The roll of the tool about its own axis is free. The
//! six-row pseudo-inverse of Esmaeili 2021, eq. 37, also requires the roll. That spends rotary motion on something without effect on the cut, and leaves the
//! axis tilted.
//!
//! Orientation is corrected by the rotary axes alone, damped near a singularity ([`super::orientation`]). Position takes precedence: whatever the rotary axes
//! do, the linear axes bring the tip exactly to its position. A machine with fewer than three linear axes corrects the directions that it has.

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::State;

use super::Model;
use super::body::Pointer;
use super::linear::{LinearStep, Singular};
use super::orientation::OrientationProblem;

/// Convergence limit of the tip position, mm; a tenth of the guaranteed accuracy.
const POSITION_LIMIT_MM: f64 = 1e-7;
/// Guaranteed accuracy of the tip, mm.
const PROMISED_MM: f64 = 1e-6;
/// The orientation has converged when a step would change it by less, rad.
const DIRECTION_LIMIT_RAD: f64 = 1e-9;
/// More steps than ever needed: each divides errors of 1e-4 by about 1e3.
const MAX_STEPS: usize = 30;

/// Commands that a solution may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solve {
    /// Linear and rotary axes, for tip position and tool axis direction.
    Full,
    /// Linear axes only, for the tip position; rotary commands stay those of the start (they were rounded to the increment).
    PositionOnly,
}

/// Error if no command has its tip within 1e-6 mm of the nominal one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotConverged {
    /// Distance of the last tip from its position, mm; NaN if the model gave none.
    pub residual_mm: f64,
}

impl Model {
    /// Returns the command whose actual pose is the nominal pose of `nominal`, iterated from `start`. A good start is the nominal command plus the correction
    /// of a neighboring point. Axes that take no part (U if there is X) stay at their nominal command, rotary axes under [`Solve::PositionOnly`] at that of
    /// the start. Without errors the nominal command itself is returned, bit by bit.
    ///
    /// # Errors
    /// [`NotConverged`] if the tip cannot be brought to its position.
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

    /// True if the rotary axes are so close to a singularity that [`Solve::Full`] damps the orientation.
    #[must_use]
    pub fn is_near_singularity(&self, command: &AxisVector, tool_mm: &Vector) -> bool {
        !self.rotary.is_empty()
            && OrientationProblem::at(&self.pointer(command, tool_mm, None), self.rotary).is_damped()
    }
}

/// Constant data of the search for one solution.
struct Search<'a> {
    model: &'a Model,
    tool_mm: &'a Vector,
    state: &'a State,
}

impl Search<'_> {
    fn pointer(&self, command: &AxisVector) -> Pointer {
        self.model.pointer(command, self.tool_mm, Some(self.state))
    }

    /// Solves the position on a machine without rotary axes: the derivatives are the directions of the axes.
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
            // The step is known already, so the residual is removed as well and is then far below the limit.
            step.apply(&residual, &mut command);
            if residual_mm < POSITION_LIMIT_MM {
                return Ok(command);
            }
        }
        last_resort(command, residual_mm)
    }

    /// Solves the position by the linear axes, at the given rotary commands.
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

    /// Solves the orientation by the rotary axes and the position by the linear ones, in common steps.
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
            // The effect of the rotary step on the tip is compensated in the same step.
            for &axis in orientation.axes() {
                residual -= now.tip_by_command[axis.slot()] * (command[axis] - before[axis]);
            }
            step.apply(&residual, &mut command);
        }
        // The orientation did not converge (because of a step in an error table, for example); the position still must.
        self.position(target.tip, command)
    }
}

impl From<Singular> for NotConverged {
    fn from(_: Singular) -> NotConverged {
        NotConverged { residual_mm: f64::NAN }
    }
}

/// The steps are used up: a result within the guaranteed accuracy is accepted.
fn last_resort(command: AxisVector, residual_mm: f64) -> Result<AxisVector, NotConverged> {
    if residual_mm < PROMISED_MM { Ok(command) } else { Err(NotConverged { residual_mm }) }
}
