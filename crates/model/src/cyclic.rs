//! Model for evaluation in the cycle of a control: errors on a grid of equal intervals, and a correction in a fixed number of steps.
//!
//! The chain is that of [`super::forward`]. Only the functions of the axes are looked up in tables ([`super::motion`]), and the number of Newton steps is
//! fixed. An error of 0.1 mm with a slope of 1e-4 leaves a residual of 1e-5 mm after the first step and 1e-9 mm after the second.

use std::f64::consts::TAU;

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};

use super::linear::LinearStep;
use super::orientation::OrientationProblem;
use super::{Model, Solve};

/// Newton steps of a correction.
const STEPS: usize = 2;

impl Model {
    /// Returns the model with the errors of every axis on `count` equal intervals, between its travel limits or over one turn of a modulo axis (Spaan 1995,
    /// ch. 6: 200). The errors of an axis without limits, functions of two axes, and functions for which the grid is too coarse (0.02 µm, 0.05 µrad) are
    /// still evaluated directly.
    #[must_use]
    pub fn on_intervals(&self, machine: &Machine, count: usize) -> Model {
        let mut model = self.clone();
        let modulo = model.modulo;
        for link in
            model.tool_side.iter_mut().chain(&mut model.workpiece_side).filter(|link| !link.functions.is_empty())
        {
            let travel = machine.axis(link.axis).and_then(|data| data.travel);
            let range = if modulo.contains(link.axis) { Some([0.0, TAU]) } else { travel };
            if let Some(range) = range.filter(|[low, high]| high > low && (high - low).is_finite()) {
                link.functions = link.functions.on_intervals(link.axis, range, count.max(1));
            }
        }
        model
    }

    /// Returns the number of functions of an axis that are evaluated one by one; after [`Self::on_intervals`] those that its tables do not contain.
    #[must_use]
    pub fn direct_functions(&self, axis: Axis) -> usize {
        let links = self.tool_side.iter().chain(&self.workpiece_side).filter(|link| link.axis == axis);
        links.map(|link| link.functions.direct()).sum()
    }

    /// Returns the command whose actual pose is the nominal pose of `nominal`, like [`Self::solve`], in a fixed number of steps from the nominal command. The
    /// time is constant, nothing is allocated, and no earlier command has an effect. `None` if no command brings the tip to its position.
    #[must_use]
    pub fn solve_in_cycle(
        &self,
        nominal: &AxisVector,
        tool_mm: &Vector,
        state: &State,
        mode: Solve,
    ) -> Option<AxisVector> {
        let command = if self.rotary.is_empty() {
            self.straight_in_cycle(nominal, tool_mm, state)
        } else {
            self.turned_in_cycle(nominal, tool_mm, state, mode)
        }?;
        command.0.iter().all(|value| value.is_finite()).then_some(command)
    }

    fn straight_in_cycle(&self, nominal: &AxisVector, tool_mm: &Vector, state: &State) -> Option<AxisVector> {
        let step = self.straight_step()?.as_ref().ok()?;
        let target = self.tip(nominal, tool_mm, None);
        let mut command = *nominal;
        for _ in 0..STEPS {
            let residual = target - self.tip(&command, tool_mm, Some(state));
            step.apply(&residual, &mut command);
        }
        Some(command)
    }

    /// Solves orientation and position in common steps with the derivatives at the nominal command: an error of 1e-4 changes them by that share only.
    fn turned_in_cycle(
        &self,
        nominal: &AxisVector,
        tool_mm: &Vector,
        state: &State,
        mode: Solve,
    ) -> Option<AxisVector> {
        let target = self.pointer(nominal, tool_mm, None);
        let step = LinearStep::new(&self.linear, self.linear.columns(&target)).ok()?;
        let mut command = *nominal;
        if mode == Solve::PositionOnly {
            for _ in 0..STEPS {
                let residual = target.tip - self.tip(&command, tool_mm, Some(state));
                step.apply(&residual, &mut command);
            }
            return Some(command);
        }
        let orientation = OrientationProblem::at(&target, self.rotary);
        let mut dual = [0.0; 2];
        for _ in 0..STEPS {
            let now = self.ray(&command, tool_mm, state);
            let mut residual = target.tip - now.tip;
            let (dual_step, _) = orientation.step(&now.axis, &dual);
            let before = command;
            dual[0] += dual_step[0];
            dual[1] += dual_step[1];
            orientation.turn(nominal, &dual, &mut command);
            // The effect of the rotary step on the tip is compensated in the same step.
            for &axis in orientation.axes() {
                residual -= target.tip_by_command[axis.slot()] * (command[axis] - before[axis]);
            }
            step.apply(&residual, &mut command);
        }
        Some(command)
    }
}
