//! A matrix between the axes and their motors: errors that are linear in the positions of X, Y and Z, i.e. scales and squareness.
//!
//! The nine numbers are fitted to the exact corrections together with a constant of each axis. A matrix cannot hold the constant, such as the arm of
//! a tilted tool at Z0, which a zero offset compensates. Without it in the fit, it would distort scales and squareness.

use super::{Holds, Scheme, Task};
use crate::tables::region::Region;
use crate::tables::{Orientation, Tables};
use ncfix_base::geometry::Axis;
use ncfix_base::numeric::System;

pub(super) const SCHEME: Scheme = Scheme {
    name: "matrix",
    title: "a matrix for scales and squareness of X, Y, Z",
    needs: &[Holds::Matrix],
    home: Orientation::Smooth,
    finds_nodes: true,
    fill: matrix,
};

/// Number of fitted poses, and the seed of their generator.
const POSES: usize = 2000;
const SEED: u64 = 0x4d41_5452;
/// Limit for directions that the region does not determine, such as an axis that does not move in it.
const RANK_LIMIT: f64 = 1e-9;

fn matrix(task: &Task<'_>) -> Result<Tables, String> {
    let axes: [_; 3] = task.linear().try_into().map_err(|_| "a matrix needs three linear axes".to_owned())?;
    let mut region = task.region.clone();
    for axis in task.target.rotary() {
        let [low, high] = region.range(axis);
        let at = 0_f64.clamp(low, high);
        region.set(axis, [at, at]);
    }
    let task = task.without_rotary_corrections();
    let poses = region.poses(POSES, SEED);
    let wanted = task.exact(&poses)?;
    let mut matrix = [[0.0; 3]; 3];
    for ((i, row), output) in matrix.iter_mut().enumerate().zip(axes) {
        let mut system = System::new(4);
        for (pose, correction) in poses.iter().zip(&wanted) {
            // From the middle and in units of the range: a stationary axis is not identifiable, and all unknowns have similar sizes.
            let [x, y, z] = axes.map(|axis| scaled(&region, axis, pose[axis]));
            system.add(&[x, y, z, 1.0], correction[output], 1.0);
        }
        let solution = system.solve_to(RANK_LIMIT).ok_or("the corrections are not finite numbers")?;
        for ((to, axis), value) in row.iter_mut().zip(axes).zip(solution.unknowns.iter()) {
            let [low, high] = region.range(axis);
            *to = if high > low { 2.0 * value / (high - low) } else { 0.0 };
        }
        row[i] += 1.0;
    }
    Ok(Tables { matrix: Some(matrix), ..Tables::default() })
}

/// A position in units of half the range, from its middle.
fn scaled(region: &Region, axis: Axis, at: f64) -> f64 {
    let [low, high] = region.range(axis);
    if high > low { (2.0 * at - low - high) / (high - low) } else { 0.0 }
}
