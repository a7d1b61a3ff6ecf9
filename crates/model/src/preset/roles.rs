//! Roles of the axes in a chain. They transfer a preset from its printed machine to others.

use super::Unsuitable;
use crate::name::{DIRECTIONS, Direction, ErrorName};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_machine::machine::{AxisData, Branch, Machine};

/// Sine of the smallest angle at which two axes count as different directions; for three axes the limit of their triple product.
const LEAST_ANGLE: f64 = 0.05;

/// Three linear axes in the order of the chain from the workpiece to the tool.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear<'a>(pub(super) [&'a AxisData; 3]);

/// Two rotary axes that are not parallel.
#[derive(Clone, Copy, Debug)]
pub(super) struct RotaryPair<'a> {
    /// Axis relative to which the other is described: nearer to the linear axes if both are on one side, else on the tool side.
    pub(super) first: &'a AxisData,
    /// Other axis.
    pub(super) second: &'a AxisData,
}

/// Returns the axes in the order of the chain from the workpiece to the tool.
fn chain(machine: &Machine) -> impl Iterator<Item = &AxisData> {
    let order = machine.topology.workpiece.iter().rev().chain(&machine.topology.tool);
    order.filter_map(|&axis| machine.axis(axis))
}

/// Lists the axes as `X, Y`, or `none`.
fn listed<'a>(axes: impl Iterator<Item = &'a AxisData>) -> String {
    let letters: Vec<String> = axes.map(|data| data.axis.to_string()).collect();
    if letters.is_empty() { "none".into() } else { letters.join(", ") }
}

impl<'a> Linear<'a> {
    /// Returns the linear axes of a machine that has three of them in independent directions.
    pub(super) fn of(machine: &'a Machine) -> Result<Linear<'a>, Unsuitable> {
        let linear = || chain(machine).filter(|data| !data.axis.is_rotary());
        let three: Vec<&AxisData> = linear().collect();
        let three: [&AxisData; 3] = three.try_into().map_err(|_| {
            Unsuitable(format!("it is for machines with three linear axes, and this one has {}", listed(linear())))
        })?;
        let [a, b, c] = three.map(|data| data.direction);
        if a.cross(&b).dot(&c).abs() < LEAST_ANGLE {
            return Err(Unsuitable(format!(
                "it is for machines whose linear axes span space, and {} do not",
                listed(linear())
            )));
        }
        Ok(Linear(three))
    }

    /// Returns the three squareness errors: per pair of axes, the later axis of the chain about the direction perpendicular to both.
    ///
    /// The first axis from the workpiece is the datum. If two axes are on the workpiece side, however, the later one carries the earlier one, and tilting it
    /// would tilt both. In this case the earlier one has the error.
    pub(super) fn squareness(&self, machine: &Machine) -> [ErrorName; 3] {
        let [a, b, c] = self.0;
        [[a, b], [b, c], [a, c]].map(|[earlier, later]| {
            let on_table = machine.topology.branch(later.axis) == Some(Branch::Workpiece);
            let carrier = if on_table { earlier } else { later };
            ErrorName::location(about(&earlier.direction.cross(&later.direction), None), carrier.axis)
        })
    }
}

impl<'a> RotaryPair<'a> {
    /// Returns the rotary axes of a machine that has two which are not parallel.
    pub(super) fn of(machine: &'a Machine) -> Result<RotaryPair<'a>, Unsuitable> {
        let rotary = || chain(machine).filter(|data| data.axis.is_rotary());
        let two: Vec<&AxisData> = rotary().collect();
        let [earlier, later]: [&AxisData; 2] = two.try_into().map_err(|_| {
            Unsuitable(format!("it is for machines with two rotary axes, and this one has {}", listed(rotary())))
        })?;
        if earlier.direction.cross(&later.direction).norm() < LEAST_ANGLE {
            let axes = listed(rotary());
            return Err(Unsuitable(format!("it is for machines whose rotary axes are not parallel, and {axes} are")));
        }
        let both_on_tool_side = machine.topology.branch(earlier.axis) == Some(Branch::Tool);
        let (first, second) = if both_on_tool_side { (earlier, later) } else { (later, earlier) };
        Ok(RotaryPair { first, second })
    }

    /// Returns the offset of the second axis from the first, along their common normal.
    pub(super) fn offset(&self) -> ErrorName {
        let normal = self.first.direction.cross(&self.second.direction);
        ErrorName::location(along(&normal), self.second.axis)
    }
}

/// Returns the two tilts of a rotary axis: rotations about the directions other than its own.
pub(super) fn tilts(data: &AxisData) -> [ErrorName; 2] {
    let own = about(&data.direction, Some(data.axis));
    let [a, b] = others([Direction::A, Direction::B, Direction::C], own);
    [ErrorName::location(a, data.axis), ErrorName::location(b, data.axis)]
}

/// Returns the two offsets of the spindle perpendicular to its axis.
pub(super) fn spindle_offsets(machine: &Machine) -> [ErrorName; 2] {
    lateral(&machine.spindle.axis).map(ErrorName::spindle)
}

/// Returns the displacements perpendicular to a direction.
pub(super) fn lateral(axis: &Vector) -> [Direction; 2] {
    others([Direction::X, Direction::Y, Direction::Z], along(axis))
}

/// Returns the displacement along the direction of F that is nearest to a vector.
pub(super) fn along(vector: &Vector) -> Direction {
    DIRECTIONS[vector.iamax()]
}

/// Returns the rotation about the direction of F that is nearest to a vector; at a tie, for example at 45°, that of the axis letter.
pub(super) fn about(vector: &Vector, letter: Option<Axis>) -> Direction {
    let nearest = vector.iamax();
    let own = letter.map_or(nearest, Axis::dimension);
    let is_tie = vector[own].abs() > vector[nearest].abs() * (1.0 - 1e-6);
    DIRECTIONS[3 + if is_tie { own } else { nearest }]
}

fn others(all: [Direction; 3], without: Direction) -> [Direction; 2] {
    let [a, b, c] = all;
    match without {
        direction if direction == a => [b, c],
        direction if direction == b => [a, c],
        _ => [a, b],
    }
}
