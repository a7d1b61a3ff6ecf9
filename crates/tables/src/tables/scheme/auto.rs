//! The fewest tables that reach the tolerance on a control: all supported schemes are tried, and unnecessary tables are dropped.

use super::{Scheme, Schemes, Task};
use crate::tables::check::{CheckedPose, Errors, left, stands};
use crate::tables::{Control, Tables};
use ncfix_base::geometry::Axis;

/// Number of poses for comparing schemes and dropping tables.
const POSES: usize = 1000;
const SEED: u64 = 0x4155_544f;
/// Numbers of table points that are tried, ascending.
const POINTS: [usize; 5] = [5, 9, 17, 33, 65];
/// Share of the tolerance used as the target of the search: other poses have slightly larger errors.
pub const AIM: f64 = 0.95;

/// Result of a tried scheme.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Its name.
    pub scheme: &'static str,
    /// Number of points of a table.
    pub points: usize,
    /// Numbers of tables and values, and root mean square residual: tip in mm, tilt in rad; or the reason why it does not fit.
    pub outcome: Result<(usize, usize, [f64; 2]), String>,
}

/// The fewest tables that reach the tolerance, and the tried schemes. `None` if no scheme does.
#[must_use]
pub fn choose(task: &Task<'_>) -> (Option<(&'static Scheme, Tables)>, Vec<Tried>) {
    choose_with(&Schemes::default(), task)
}

/// The fewest tables among these schemes that reach the tolerance, as [`choose`] determines them.
#[must_use]
pub fn choose_with(schemes: &Schemes, task: &Task<'_>) -> (Option<(&'static Scheme, Tables)>, Vec<Tried>) {
    // Direction-dependent errors remain on a control without tables for them: they count in any case.
    let has_senses = |axis: &Axis| task.target.model.features(*axis).backlash;
    let axes: Vec<Axis> = task.region.axes().filter(has_senses).collect();
    let poses = stands(&task.region.reached(task.target.machine).poses(POSES, SEED), &axes);
    let mut best: Option<(&'static Scheme, Tables)> = None;
    let mut tried = Vec::new();
    let most = task.format.limits.points;
    for &scheme in schemes.iter() {
        for points in POINTS.into_iter().filter(|&points| most == 0 || points <= most) {
            let task = Task { points, ..*task };
            let outcome = attempt(&task, scheme, &poses);
            let (row, tables) = match outcome {
                Ok((tables, left)) => {
                    let rms_mm = left.rms_mm();
                    (Ok((tables.count(), tables.entries(), [rms_mm, left.rms_rad()])), Some((tables, rms_mm)))
                }
                Err(reason) => (Err(reason), None),
            };
            let is_hopeless = row.is_err();
            tried.push(Tried { scheme: scheme.name, points, outcome: row });
            if let Some((tables, rms_mm)) = tables.filter(|(_, rms_mm)| *rms_mm <= AIM * task.tolerance_mm) {
                let tables = without_idle(&task, tables, &poses, rms_mm);
                let size = |tables: &Tables| (tables.count(), tables.entries());
                if best.as_ref().is_none_or(|(_, best)| size(&tables) < size(best)) {
                    best = Some((scheme, tables));
                }
                break;
            }
            if is_hopeless || scheme.finds_nodes {
                break;
            }
        }
    }
    (best, tried)
}

fn attempt(task: &Task<'_>, scheme: &Scheme, poses: &[CheckedPose]) -> Result<(Tables, Errors), String> {
    let tables = scheme.tables(task)?;
    let errors = left(&task.target, &Control::new(task.target.machine, &tables), poses);
    let faults = task.format.faults_of(&tables, task.wiring);
    // An excessive number of tables may fit after dropping those with little effect.
    let slim = if faults.is_empty() { tables } else { without_idle(task, tables, poses, errors.rms_mm()) };
    match task.format.faults_of(&slim, task.wiring).first() {
        None => Ok((slim, errors)),
        Some(fault) => Err(fault.clone()),
    }
}

/// Drops tables and products, smallest first, as long as the tolerance is kept.
fn without_idle(task: &Task<'_>, tables: Tables, poses: &[CheckedPose], rms_mm: f64) -> Tables {
    if tables.lookups.is_empty() || rms_mm > AIM * task.tolerance_mm {
        return tables;
    }
    let sample = &poses[..poses.len() / 3];
    let mut groups = groups(&tables);
    groups.sort_by(|(_, one), (_, other)| one.total_cmp(other));
    let mut kept: Vec<bool> = vec![true; tables.lookups.len()];
    for (group, _) in groups {
        group.iter().for_each(|&index| kept[index] = false);
        let fewer = subset(&tables, &kept);
        let rms = left(&task.target, &Control::new(task.target.machine, &fewer), sample).rms_mm();
        if rms > AIM * task.tolerance_mm {
            group.iter().for_each(|&index| kept[index] = true);
        }
    }
    let slim = subset(&tables, &kept);
    // The sample was a third of the poses: all poses decide.
    let rms = left(&task.target, &Control::new(task.target.machine, &slim), poses).rms_mm();
    if rms <= AIM * task.tolerance_mm { slim } else { tables }
}

/// The tables that only work together, by their indices, with the largest value that they add: a table, or two that are multiplied.
pub(super) fn groups(tables: &Tables) -> Vec<(Vec<usize>, f64)> {
    let mut groups: Vec<(Vec<usize>, f64)> = Vec::new();
    for (index, one) in tables.lookups.iter().enumerate() {
        let largest =
            |index: usize| tables.lookups[index].values.iter().fold(0.0_f64, |most, value| value.abs().max(most));
        match one.factor {
            Some(factor) if factor < index => {}
            Some(factor) => groups.push((vec![index, factor], largest(index) * largest(factor))),
            None => groups.push((vec![index], largest(index))),
        }
    }
    groups
}

/// The kept tables, with renumbered factors.
pub(super) fn subset(tables: &Tables, kept: &[bool]) -> Tables {
    let number = |old: usize| kept.iter().take(old).filter(|&&is_kept| is_kept).count();
    let mut subset = tables.clone();
    let lookups = tables.lookups.iter().zip(kept).filter(|&(_, &is_kept)| is_kept).map(|(one, _)| one.clone());
    subset.lookups = lookups.collect();
    subset.lookups.iter_mut().for_each(|one| one.factor = one.factor.map(number));
    subset
}
