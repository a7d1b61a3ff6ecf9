//! The fewest tables that reach the tolerance on a control: all schemes that it can hold are tried, and tables that are not needed are left out.

use super::{Scheme, Schemes, Task};
use crate::tables::check::{CheckedPose, Errors, left, stands};
use crate::tables::{Control, Tables};
use ncfix_base::geometry::Axis;

/// Poses at which schemes are compared, and at which tables are left out.
const POSES: usize = 1000;
const SEED: u64 = 0x4155_544f;
/// Points of a table that are tried, few first.
const POINTS: [usize; 5] = [5, 9, 17, 33, 65];
/// The share of the tolerance that the search aims at: other poses have a little more.
pub const AIM: f64 = 0.95;

/// A scheme that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Its name.
    pub scheme: &'static str,
    /// Points of a table.
    pub points: usize,
    /// Tables and values, and what they leave, root mean square: at the tip in mm, of the tilt in rad; or why it does not fit.
    pub outcome: Result<(usize, usize, [f64; 2]), String>,
}

/// The tables with the fewest that reach the tolerance, and what was tried. `None` where no scheme does.
#[must_use]
pub fn choose(task: &Task<'_>) -> (Option<(&'static Scheme, Tables)>, Vec<Tried>) {
    choose_with(&Schemes::default(), task)
}

/// The tables of the scheme among these with the fewest that reach the tolerance, as [`choose`] finds it.
#[must_use]
pub fn choose_with(schemes: &Schemes, task: &Task<'_>) -> (Option<(&'static Scheme, Tables)>, Vec<Tried>) {
    // What depends on the sense of motion is left by a control that has no tables for it: it counts in any case.
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
    // Too many tables may become few enough when those that do little are left out.
    let slim = if faults.is_empty() { tables } else { without_idle(task, tables, poses, errors.rms_mm()) };
    match task.format.faults_of(&slim, task.wiring).first() {
        None => Ok((slim, errors)),
        Some(fault) => Err(fault.clone()),
    }
}

/// Leaves out tables, and products, as long as the tolerance is kept; the smallest first.
fn without_idle(task: &Task<'_>, tables: Tables, poses: &[CheckedPose], rms_mm: f64) -> Tables {
    if tables.lookups.is_empty() || rms_mm > AIM * task.tolerance_mm {
        return tables;
    }
    let sample = &poses[..poses.len() / 3];
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
    // The sample was a third of the poses: all have the last word.
    let rms = left(&task.target, &Control::new(task.target.machine, &slim), poses).rms_mm();
    if rms <= AIM * task.tolerance_mm { slim } else { tables }
}

/// The tables that are kept, with the numbers of their factors.
fn subset(tables: &Tables, kept: &[bool]) -> Tables {
    let number = |old: usize| kept.iter().take(old).filter(|&&is_kept| is_kept).count();
    let mut subset = tables.clone();
    let lookups = tables.lookups.iter().zip(kept).filter(|&(_, &is_kept)| is_kept).map(|(one, _)| one.clone());
    subset.lookups = lookups.collect();
    subset.lookups.iter_mut().for_each(|one| one.factor = one.factor.map(number));
    subset
}
