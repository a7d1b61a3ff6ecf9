//! Tables for one direction of motion: the correction of a reversal error in addition to the mean of both directions.
//!
//! Errors that a format cannot hold remain, such as backlash that moves another axis if only the axis itself has a table for each direction.

use super::assembly::{nodes, positions, repeat};
use super::{Holds, Task};
use crate::tables::{Lookup, Sense, Tables};
use ncfix_base::geometry::{AXES, Axis, AxisVector};
use ncfix_machine::machine::State;

/// Size below which there is no reversal error, mm or rad.
const NOTHING: f64 = 1e-6;

/// Two tables, one for each direction, for every correction that depends on the direction of an axis. Other axes are at their middle.
pub(super) fn tables(task: &Task<'_>) -> Tables {
    let mut tables = Tables::default();
    let moving = task.region.axes().filter(|&axis| task.target.model.features(axis).backlash);
    for input in moving {
        let at = positions(input, task.region, task.points);
        let halves: Option<Vec<AxisVector>> = at.iter().map(|&at| half_difference(task, input, at)).collect();
        let Some(halves) = halves else { continue };
        let has_place = |output: &Axis| *output == input || task.format.can_hold(Holds::CrossSenses);
        for output in AXES.into_iter().filter(has_place) {
            let mut values: Vec<f64> = halves.iter().map(|half| half[output]).collect();
            if values.iter().all(|value| value.abs() < NOTHING) {
                continue;
            }
            if values.iter().all(|value| (value - values[0]).abs() < NOTHING / 10.0) {
                values.truncate(2);
            }
            for (sense, sign) in [(Sense::Positive, 1.0), (Sense::Negative, -1.0)] {
                let unit = |value: f64| sign * if output.is_rotary() { value.to_degrees() } else { value };
                let nodes = nodes(input, task.region.range(input), values.len());
                let mut one = Lookup::added(input, output, nodes, values.iter().map(|&value| unit(value)).collect());
                one.sense = sense;
                repeat(task, &mut one);
                tables.lookups.push(one);
            }
        }
    }
    tables
}

/// The reversal value of an axis for the backlash compensation of a control: its correction after a positive motion minus that after a negative one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reversal {
    /// The axis.
    pub axis: Axis,
    /// Mean over its range, mm or rad.
    pub mean: f64,
    /// Largest distance from the mean, mm or rad.
    pub spread: f64,
}

/// The reversal values of all axes that have one.
#[must_use]
pub fn reversals(task: &Task<'_>) -> Vec<Reversal> {
    let moving = task.region.axes().filter(|&axis| task.target.model.features(axis).backlash);
    let of = |axis: Axis| {
        let at = positions(axis, task.region, task.points);
        let values: Option<Vec<f64>> =
            at.iter().map(|&at| half_difference(task, axis, at).map(|half| 2.0 * half[axis])).collect();
        let values = values?;
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let spread = values.iter().map(|value| (value - mean).abs()).fold(0.0, f64::max);
        (mean.abs() >= NOTHING || spread >= NOTHING).then_some(Reversal { axis, mean, spread })
    };
    moving.filter_map(of).collect()
}

/// Half the difference of the correction between both directions of an axis at a position.
fn half_difference(task: &Task<'_>, axis: Axis, at: f64) -> Option<AxisVector> {
    let mut pose = task.region.middle();
    pose[axis] = at;
    let in_sense = |sense: i8| {
        let mut state = State::default();
        state.direction[axis.slot()] = sense;
        task.target.correction(&pose, &state)
    };
    let mut difference = in_sense(1)? - in_sense(-1)?;
    difference.0.iter_mut().for_each(|value| *value /= 2.0);
    Some(difference)
}
