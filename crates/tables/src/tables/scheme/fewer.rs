//! The residual with fewer tables than were made (Esmaeili 2021, 9.2), and the residual over the number of nodes of a grid (Fig. 4.5 there).

use super::Task;
use super::best_sets::{best_sets, subset};
use super::mesh::{self, CountedResidual};
use crate::tables::check::{CheckedPose, left, stands};
use crate::tables::{Control, Tables};
use ncfix_base::geometry::Axis;

/// Number of poses.
const POSES: usize = 400;
const SEED: u64 = 0x4645_5745_5200;

/// The residuals with all tables and with the best set of each smaller number, in descending order; for a grid those of 2, 3, 4 … nodes along each
/// axis up to its own. A number whose best set is no better than that of a smaller number is omitted. Empty for other kinds of tables, or for a great
/// many.
#[must_use]
pub fn fewer(task: &Task<'_>, tables: &Tables) -> Vec<CountedResidual> {
    if let Some(grid) = &tables.grid {
        return mesh::by_nodes(task, grid.count.into_iter().max().unwrap_or(2));
    }
    let poses = poses(task);
    let row = |kept: &[bool], count: usize| {
        let control = Control::new(task.target.machine, &subset(tables, kept));
        CountedResidual { count, rms_mm: left(&task.target, &control, &poses).rms_mm() }
    };
    let mut rows: Vec<CountedResidual> = Vec::new();
    for set in best_sets(task, tables, &poses) {
        let row = row(&set.kept, set.count);
        let is_better = rows.last().is_none_or(|fewer| row.rms_mm < fewer.rms_mm);
        if is_better || set.count == tables.count() {
            rows.push(row);
        }
    }
    rows.reverse();
    rows
}

/// The best set of at most `most` of these tables; all of them if there are no more.
#[must_use]
pub fn at_most(task: &Task<'_>, tables: &Tables, most: usize) -> Tables {
    if tables.count() <= most {
        return tables.clone();
    }
    let sets = best_sets(task, tables, &poses(task));
    let small = sets.into_iter().filter(|set| set.count <= most);
    // Of equally good sets, the first is the smallest.
    let best = small.min_by(|one, other| one.rms_mm.total_cmp(&other.rms_mm));
    best.map_or_else(|| tables.clone(), |set| subset(tables, &set.kept))
}

fn poses(task: &Task<'_>) -> Vec<CheckedPose> {
    let has_senses = |axis: &Axis| task.target.model.features(*axis).backlash;
    let axes: Vec<Axis> = task.region.axes().filter(has_senses).collect();
    stands(&task.region.reached(task.target.machine).poses(POSES, SEED), &axes)
}
