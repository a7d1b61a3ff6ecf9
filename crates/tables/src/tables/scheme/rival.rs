//! The better of the tables of a scheme and those of simpler functions that it contains: a scheme with more freedom must not leave more.
//!
//! A fit at many points carries the chance of its poses in every point. Where a polynomial leaves less, its values are taken. The residual decides, at
//! poses that no fit used.

use super::Task;
use crate::tables::check::{left, stands};
use crate::tables::{Control, Tables};

/// Number of poses that decide, and their seed.
const POSES: usize = 1000;
const SEED: u64 = 0x5249_5641_4c00;
/// Share of the residual by which simpler tables must be better, and the same in mm: below it, the difference is chance.
const GAIN: f64 = 0.005;
const LEAST_GAIN_MM: f64 = 1e-6;

/// The first tables, unless the second ones leave less. A reason instead of the second ones excludes them.
pub(super) fn better(task: &Task<'_>, own: Tables, simpler: Result<Tables, String>) -> Tables {
    let Ok(simpler) = simpler else { return own };
    let poses = stands(&task.region.reached(task.target.machine).poses(POSES, SEED), &[]);
    let rms_mm = |tables: &Tables| left(&task.target, &Control::new(task.target.machine, tables), &poses).rms_mm();
    let (with_own, with_simpler) = (rms_mm(&own), rms_mm(&simpler));
    if with_simpler < with_own * (1.0 - GAIN) - LEAST_GAIN_MM { simpler } else { own }
}
