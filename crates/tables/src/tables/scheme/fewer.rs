//! The residual with fewer tables than were made: which of them are worth their place in a control with few (Esmaeili 2021, 9.2), and the residual over
//! the number of nodes of a grid (Fig. 4.5 there).
//!
//! The least useful table, or pair of tables that are multiplied, is dropped again and again: the one without which the residual is smallest. This
//! greedy order is not always the best set of a size, but each residual is that of the tables that are left, as they are.

use super::Task;
use super::auto::{groups, subset};
use super::mesh::{self, CountedResidual};
use crate::tables::check::{CheckedPose, left, stands};
use crate::tables::{Control, Tables};
use ncfix_base::geometry::Axis;

/// Number of poses that decide which table is dropped, and of those that the residual is of.
const DECIDING: usize = 60;
const POSES: usize = 400;
const SEED: u64 = 0x4645_5745_5200;
/// Number of tables or pairs up to which the search is made: its time grows with the square.
const MOST_GROUPS: usize = 80;

/// The residuals with all tables and with fewer, in descending order of their number; for a grid those of 2, 3, 4 … nodes along each axis up to its
/// own. Empty for other kinds of tables, or for a great many.
#[must_use]
pub fn fewer(task: &Task<'_>, tables: &Tables) -> Vec<CountedResidual> {
    if let Some(grid) = &tables.grid {
        return mesh::by_nodes(task, grid.count.into_iter().max().unwrap_or(2));
    }
    let mut groups: Vec<Vec<usize>> = groups(tables).into_iter().map(|(group, _)| group).collect();
    if groups.is_empty() || groups.len() > MOST_GROUPS {
        return Vec::new();
    }
    let has_senses = |axis: &Axis| task.target.model.features(*axis).backlash;
    let axes: Vec<Axis> = task.region.axes().filter(has_senses).collect();
    let poses = stands(&task.region.reached(task.target.machine).poses(POSES, SEED), &axes);
    let rms_mm = |kept: &[bool], poses: &[CheckedPose]| {
        left(&task.target, &Control::new(task.target.machine, &subset(tables, kept)), poses).rms_mm()
    };
    let mut kept = vec![true; tables.lookups.len()];
    let mut found = Vec::new();
    loop {
        let count = kept.iter().filter(|&&is_kept| is_kept).count();
        found.push(CountedResidual { count, rms_mm: rms_mm(&kept, &poses) });
        let without = |group: &Vec<usize>| {
            let mut fewer = kept.clone();
            group.iter().for_each(|&index| fewer[index] = false);
            fewer
        };
        let residuals = groups.iter().map(|group| rms_mm(&without(group), &poses[..DECIDING.min(poses.len())]));
        let least = residuals.enumerate().min_by(|(_, one), (_, other)| one.total_cmp(other));
        let Some((least, _)) = least else { return found };
        kept = without(&groups.swap_remove(least));
    }
}
