//! A table for each axis over its own position: what a laser along one line sees, and nothing of the other axes.
//!
//! The shape of a table is the exact correction along the line through the middle of the region: other linear axes in the middle of their ranges, other
//! rotary axes at the position of their ranges nearest to 0. So a table is as smooth as the error model. A fit over the whole region would leave the
//! chance of its poses in every point, because the errors of the other axes are no function of this one. Only the level, which no line tells, is the mean
//! over the region.

use super::assembly::{Assembly, positions};
use super::{Holds, Scheme, Task};
use crate::tables::{Control, Orientation, Tables};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::State;
use ncfix_model::Solve;

pub(super) const SCHEME: Scheme = Scheme {
    name: "own",
    title: "a table for each axis over its own position: the correction along the line through the middle of the region",
    needs: &[Holds::Own],
    home: Orientation::Smooth,
    finds_nodes: false,
    fill,
};

/// Number of poses for the level of a table, and their seed.
const LEVEL_POSES: usize = 2000;
const SEED: u64 = 0x4f57_4e5f_4f4e_4550;

fn fill(task: &Task<'_>) -> Result<Tables, String> {
    let poses = task.region.poses(LEVEL_POSES, SEED);
    let mut tables = Tables { multiplication: task.multiplication, ..Tables::default() };
    if task.target.orientation != Orientation::Off {
        tables = along_lines(task, task.target.rotary(), &poses, &|poses| task.exact(poses))?;
    }
    // Position has priority over direction: the linear axes place the tip with the rotary corrections that the tables have.
    let control = Control::new(task.target.machine, &tables);
    let state = State::default();
    let wanted = |poses: &[AxisVector]| -> Result<Vec<AxisVector>, String> {
        let one = |pose: &AxisVector| {
            let start = *pose + control.correction(pose, &task.target.tool_mm, &state);
            let solved = task.target.model.solve(pose, &task.target.tool_mm, &state, &start, Solve::PositionOnly);
            let refused = "the tip cannot be brought to its position everywhere in the region";
            solved.map(|command| command - *pose).map_err(|_| refused.to_owned())
        };
        poses.iter().map(one).collect()
    };
    let linear = along_lines(task, task.linear(), &poses, &wanted)?;
    super::append(&mut tables, linear);
    Ok(tables)
}

/// Corrections at poses, or the reason for which a pose has no correction.
type Corrections<'a> = dyn Fn(&[AxisVector]) -> Result<Vec<AxisVector>, String> + 'a;

/// The tables of some axes: the corrections along their lines, with the level of the whole region.
fn along_lines(
    task: &Task<'_>,
    outputs: impl IntoIterator<Item = Axis>,
    poses: &[AxisVector],
    wanted: &Corrections<'_>,
) -> Result<Tables, String> {
    let everywhere = wanted(poses)?;
    let count = poses.len().max(1) as f64;
    let mut assembly = Assembly::new(task);
    for axis in outputs {
        let mean = everywhere.iter().map(|correction| correction[axis]).sum::<f64>() / count;
        if !task.region.axes().any(|one| one == axis) {
            assembly.add_constant(axis, mean);
            continue;
        }
        let nodes = positions(axis, task.region, task.points);
        let line: Vec<AxisVector> = nodes
            .iter()
            .map(|&at| {
                let mut pose = middle(task);
                pose[axis] = at;
                pose
            })
            .collect();
        let shape: Vec<f64> = wanted(&line)?.iter().map(|correction| correction[axis]).collect();
        let own = poses.iter().map(|pose| between(&nodes, &shape, pose[axis])).sum::<f64>() / count;
        let values: Vec<f64> = shape.iter().map(|value| value + mean - own).collect();
        assembly.add(axis, axis, &values);
    }
    Ok(assembly.finish())
}

/// The point through which the lines go.
fn middle(task: &Task<'_>) -> AxisVector {
    let mut middle = task.region.middle();
    for &(axis, [low, high]) in task.region.ranges.iter().filter(|(axis, _)| axis.is_rotary()) {
        middle[axis] = 0.0_f64.clamp(low, high.max(low));
    }
    middle
}

/// A function that is linear between nodes.
fn between(nodes: &[f64], values: &[f64], at: f64) -> f64 {
    let after = nodes.partition_point(|node| *node < at).clamp(1, nodes.len().saturating_sub(1).max(1));
    let place = |index: usize| Some((*nodes.get(index)?, *values.get(index)?));
    match (place(after - 1), place(after)) {
        (Some((low, first)), Some((high, second))) if high > low => {
            first + (second - first) * ((at - low) / (high - low)).clamp(0.0, 1.0)
        }
        (Some((_, only)), _) => only,
        _ => 0.0,
    }
}
