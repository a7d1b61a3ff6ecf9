//! Residual errors of a correction by source: the roll of the tool, its orientation if no rotary axis can correct it, and errors whose correction is
//! less than an increment.
//!
//! Each source is examined alone: it is corrected as the program was, and the residual is its own. Rounding belongs to no source and is excluded; it
//! is part of the predicted error along the path.

use ncfix_base::geometry::{AXES, AxisVector, ROTARY_AXES, Vector};
use ncfix_machine::machine::{Condition, Machine};
use ncfix_model::{Accumulator, ErrorModel, Model, Solve};

use super::{Increments, PoseSample};

/// The residual of one source, the largest over the poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remaining {
    /// The source.
    pub source: &'static str,
    /// Of the tip, because the correction of each axis is less than an increment, mm.
    pub position_mm: f64,
    /// Of the direction of the tool axis, rad.
    pub tilt_rad: f64,
    /// About the tool axis, rad.
    pub roll_rad: f64,
}

/// The residual of each source of the model after the correction.
#[must_use]
pub fn remaining(
    machine: &Machine,
    errors: &ErrorModel,
    condition: &Condition,
    poses: &[PoseSample],
) -> Vec<Remaining> {
    let increments = Increments::new(&machine.control);
    let mut all = Vec::new();
    for source in errors.sources() {
        let sum = Accumulator::sum(machine, errors, condition, |effect| effect.source().name == source.name);
        let model = Model::summed(&sum);
        if model.is_empty() {
            continue;
        }
        let mut left = Remaining { source: source.name, position_mm: 0.0, tilt_rad: 0.0, roll_rad: 0.0 };
        for pose in poses {
            let (nominal, tool_mm, state) = (&pose.nominal, &pose.tool_mm, &pose.state);
            let mode = if pose.turning.is_empty() { Solve::PositionOnly } else { Solve::Full };
            let Ok(mut command) = model.solve(nominal, tool_mm, state, nominal, mode) else { continue };
            let mut stays = ROTARY_AXES.into_iter().filter(|&axis| !pose.turning.contains(axis)).peekable();
            if mode == Solve::Full && stays.peek().is_some() {
                stays.for_each(|axis| command[axis] = nominal[axis]);
                let Ok(around) = model.solve(nominal, tool_mm, state, &command, Solve::PositionOnly) else { continue };
                command = around;
            }
            let moves = |axis| increments.count(axis, command[axis]) != increments.count(axis, nominal[axis]);
            let command = if AXES.into_iter().any(moves) { command } else { *nominal };
            let position = model.tip_error_mm(nominal, &command, tool_mm, state);
            if command == *nominal {
                left.position_mm = left.position_mm.max(position.norm());
            }
            let [tilt_rad, roll_rad] = turned(&model, nominal, &command, pose, &machine.spindle.axis);
            left.tilt_rad = left.tilt_rad.max(tilt_rad);
            left.roll_rad = left.roll_rad.max(roll_rad);
        }
        all.push(left);
    }
    all
}

/// Tilt of the tool axis, and rotation of the tool about it, rad.
fn turned(
    model: &Model,
    nominal: &AxisVector,
    command: &AxisVector,
    pose: &PoseSample,
    tool_axis: &Vector,
) -> [f64; 2] {
    let wanted = model.nominal(nominal, &pose.tool_mm);
    let actual = model.actual(command, &pose.tool_mm, &pose.state);
    let turn = wanted.turn_to(&actual);
    let roll = turn.dot(tool_axis);
    [(turn - tool_axis * roll).norm(), roll.abs()]
}
