//! A matrix between the axes and their motors: what is straight in the positions of X, Y and Z – scales and squareness.
//!
//! The nine numbers are fitted to the exact corrections without a constant, which a matrix does not have.

use super::{Holds, Scheme, Task};
use crate::numeric::System;
use crate::tables::{Orientation, Tables};

pub(super) const SCHEME: Scheme = Scheme {
    name: "matrix",
    title: "a matrix for scales and squareness of X, Y, Z",
    needs: &[Holds::Matrix],
    home: Orientation::Smooth,
    fill: matrix,
};

/// Poses of the fit, and the start of their generator.
const POSES: usize = 2000;
const SEED: u64 = 0x4d41_5452;
/// Directions that the region does not tell: an axis that does not move in it.
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
        let mut system = System::new(3);
        for (pose, correction) in poses.iter().zip(&wanted) {
            system.add(&axes.map(|axis| pose[axis]), correction[output], 1.0);
        }
        let solution = system.solve_to(RANK_LIMIT).ok_or("the corrections are no numbers")?;
        row.iter_mut().zip(solution.unknowns.iter()).for_each(|(to, value)| *to = *value);
        row[i] += 1.0;
    }
    Ok(Tables { matrix: Some(matrix), ..Tables::default() })
}
