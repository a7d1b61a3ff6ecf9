//! A grid of corrections with the fewest nodes that reach the tolerance, axis by axis (Esmaeili 2021, chapter 4).
//!
//! To the first order, the error of the trilinear interpolation is the sum of the errors along each axis. These are determined with few poses for any
//! number of nodes. The smallest grid whose sum is within the tolerance is then verified, with the interpolation of the control, at separate poses.
//! The residual error is compared with the tolerance, not its change from one grid to the next (eq. 11), which ends the search too early.

use super::{AIM, Holds, Scheme, Task};
use crate::tables::check::left;
use crate::tables::region::Region;
use crate::tables::{Control, Grid, Orientation, Tables};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::State;

pub(super) const SCHEME: Scheme = Scheme {
    name: "grid",
    title: "corrections of X, Y, Z on the smallest grid of positions that reaches the tolerance; rotary axes at 0",
    needs: &[Holds::Grid],
    home: Orientation::Smooth,
    finds_nodes: true,
    fill: grid,
};

/// Number of poses for the errors along one axis, and for the verification.
const POSES: usize = 400;
const VERIFIED: usize = 2000;
/// Seed of their generator.
const SEED: u64 = 0x4752_4944;
/// Maximum number of nodes along an axis, and of all nodes.
const MOST_NODES: usize = 200;
const MOST_VALUES: usize = 1_000_000;
/// Number of nodes along each axis up to which residuals are listed.
const MOST_SHOWN: usize = 40;

/// The residual with a number of tables, or of nodes along each axis of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountedResidual {
    /// Number of tables, or of nodes along each axis.
    pub count: usize,
    /// Root mean square of the tip error over the region, mm.
    pub rms_mm: f64,
}

fn grid(task: &Task<'_>) -> Result<Tables, String> {
    with_mesh(task, smallest_grid)
}

/// Prepares grids for the linear axes, with the rotary axes at 0.
fn with_mesh<T>(task: &Task<'_>, act: impl FnOnce(&Mesh<'_>, &Region) -> Result<T, String>) -> Result<T, String> {
    let axes: [Axis; 3] = task.linear().try_into().map_err(|_| "a grid needs three linear axes".to_owned())?;
    let mut region = task.region.clone();
    for axis in task.target.rotary() {
        let [low, high] = region.range(axis);
        let at = 0_f64.clamp(low, high);
        region.set(axis, [at, at]);
    }
    // A grid has no rotary axes, so their orientation corrections are excluded.
    let task = &task.without_rotary_corrections();
    act(&Mesh { task, axes, ranges: axes.map(|axis| region.range(axis)), rest: region.middle() }, &region)
}

/// The residuals of grids with 2, 3, 4 … nodes along each axis, up to a number (Esmaeili 2021, Fig. 4.5).
pub(super) fn by_nodes(task: &Task<'_>, most: usize) -> Vec<CountedResidual> {
    let found = with_mesh(task, |mesh, region| {
        let poses = region.poses(POSES / 2, SEED + 2);
        let one = |count| mesh.rms_mm([count; 3], &poses).map(|rms_mm| CountedResidual { count, rms_mm });
        (2..=most.min(MOST_SHOWN)).map(one).collect()
    });
    found.unwrap_or_default()
}

fn smallest_grid(mesh: &Mesh<'_>, region: &Region) -> Result<Tables, String> {
    let task = mesh.task;
    let poses = region.poses(POSES, SEED);
    let along: Vec<Vec<f64>> = (0..3).map(|i| mesh.along(i, &poses)).collect::<Result<_, String>>()?;
    let verified = region.poses(VERIFIED, SEED + 1);
    let aim = task.tolerance_mm * AIM;
    let mut goal = aim;
    // The sum of the errors along the axes is a first guess, corrected in a few iterations.
    for _ in 0..8 {
        let count = smallest(&along, goal).ok_or_else(|| {
            format!("a grid of {MOST_NODES} nodes along an axis does not reach {:.4} µm", task.tolerance_mm * 1e3)
        })?;
        let found = mesh.rms_mm(count, &verified)?;
        if found <= aim {
            let count = mesh.trimmed(count, aim, &verified)?;
            return Ok(Tables { grid: Some(mesh.grid(count)?), ..Tables::default() });
        }
        goal *= 0.95 * aim / found;
    }
    Err(format!(
        "no grid that the format holds reaches {:.4} µm; a larger --tolerance needs fewer points",
        task.tolerance_mm * 1e3
    ))
}

/// A grid under construction.
struct Mesh<'a> {
    task: &'a Task<'a>,
    axes: [Axis; 3],
    ranges: [[f64; 2]; 3],
    /// Positions of the axes that the grid does not contain.
    rest: AxisVector,
}

impl Mesh<'_> {
    fn correction(&self, position: [f64; 3]) -> Result<[f64; 3], String> {
        let mut pose = self.rest;
        self.axes.iter().zip(position).for_each(|(&axis, at)| pose[axis] = at);
        let exact = self.task.target.correction(&pose, &State::default());
        let exact = exact.ok_or("the tip cannot be brought to its position everywhere in the region")?;
        Ok(self.axes.map(|axis| exact[axis]))
    }

    /// Root mean square residual of linear interpolation along one axis, for 2, 3, 4 … nodes.
    fn along(&self, i: usize, poses: &[AxisVector]) -> Result<Vec<f64>, String> {
        let [low, high] = self.ranges[i];
        let mut left = Vec::new();
        for count in 2..=MOST_NODES {
            let step = (high - low) / (count - 1) as f64;
            let mut squares = 0.0;
            // Fine grids need fewer poses for their small residual.
            let sample = &poses[..if count > 20 { POSES / 4 } else { POSES }];
            for pose in sample {
                let position = self.axes.map(|axis| pose[axis]);
                let node = ((position[i] - low) / step).floor().clamp(0.0, (count - 2) as f64);
                let at = |node: f64| {
                    let mut corner = position;
                    corner[i] = low + step * node;
                    self.correction(corner)
                };
                let share = (position[i] - low) / step - node;
                let (lower, upper, exact) = (at(node)?, at(node + 1.0)?, self.correction(position)?);
                squares += (0..3).map(|k| (lower[k] + (upper[k] - lower[k]) * share - exact[k]).powi(2)).sum::<f64>();
            }
            let rms = (squares / sample.len() as f64).sqrt();
            left.push(rms);
            if rms < 0.02 * self.task.tolerance_mm {
                break;
            }
        }
        Ok(left)
    }

    /// Residual of a grid at poses: only the corners around each are computed.
    fn rms_mm(&self, count: [usize; 3], poses: &[AxisVector]) -> Result<f64, String> {
        let mut squares = 0.0;
        for pose in poses {
            let mut cell = self.empty([2; 3]);
            for i in 0..3 {
                let [low, high] = self.ranges[i];
                let step = (high - low) / (count[i] - 1) as f64;
                let node = ((pose[self.axes[i]] - low) / step).floor().clamp(0.0, (count[i] - 2) as f64);
                cell.start[i] = low + step * node;
                cell.step[i] = step;
            }
            cell.values =
                (0..8).map(|index| self.correction(cell.position(cell.node(index)))).collect::<Result<_, _>>()?;
            let tables = Tables { grid: Some(cell), ..Tables::default() };
            let control = Control::new(self.task.target.machine, &tables);
            squares += left(&self.task.target, &control, &[(*pose, State::default())]).tip_mm[0].powi(2);
        }
        Ok((squares / poses.len() as f64).sqrt())
    }

    /// Reduces the nodes along each axis as long as the target is met.
    fn trimmed(&self, mut count: [usize; 3], aim: f64, poses: &[AxisVector]) -> Result<[usize; 3], String> {
        loop {
            let mut order = [0, 1, 2];
            // The axis where one node less saves most comes first.
            order.sort_by_key(|&i| count[i]);
            let mut is_smaller = false;
            for i in order {
                let mut fewer = count;
                fewer[i] -= 1;
                if fewer[i] >= 2 && self.rms_mm(fewer, poses)? <= aim {
                    count = fewer;
                    is_smaller = true;
                    break;
                }
            }
            if !is_smaller {
                return Ok(count);
            }
        }
    }

    fn empty(&self, count: [usize; 3]) -> Grid {
        let step = std::array::from_fn(|i| (self.ranges[i][1] - self.ranges[i][0]) / (count[i] - 1) as f64);
        Grid { axes: self.axes, start: self.ranges.map(|[low, _]| low), step, count, values: Vec::new() }
    }

    fn grid(&self, count: [usize; 3]) -> Result<Grid, String> {
        let mut grid = self.empty(count);
        let all = count.iter().product();
        grid.values =
            (0..all).map(|index| self.correction(grid.position(grid.node(index)))).collect::<Result<_, _>>()?;
        Ok(grid)
    }
}

/// The counts with the smallest product whose summed errors meet a goal.
fn smallest(along: &[Vec<f64>], goal: f64) -> Option<[usize; 3]> {
    let mut best: Option<[usize; 3]> = None;
    for (x, ex) in along[0].iter().enumerate() {
        for (y, ey) in along[1].iter().enumerate() {
            let rest = goal * goal - ex * ex - ey * ey;
            if rest <= 0.0 {
                continue;
            }
            let Some(z) = along[2].iter().position(|ez| ez * ez <= rest) else { continue };
            let count = [x + 2, y + 2, z + 2];
            let size = |count: [usize; 3]| count.iter().product::<usize>();
            if size(count) <= MOST_VALUES && best.is_none_or(|best| size(count) < size(best)) {
                best = Some(count);
            }
        }
    }
    best
}
