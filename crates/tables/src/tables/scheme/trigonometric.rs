//! Products of linear axes with trigonometric functions of a rotary axis: 23 tables on a machine with five axes (Esmaeili 2021, chapter 6).
//!
//! Δq_I = f(A) + X·g(A) + Y·h(A) + Z·k(A) for the linear axes and Δq_J = f(A) for the rotary axes, every function a sum of 1, cos A, sin A, cos A sin
//! A and sin² A. The published basis (eq. 44) lacks the functions without an arm, which an offset of the C axis needs.

use super::fit::{FitTerm, Wave, fill};
use super::{Holds, Scheme, Task};
use crate::tables::check::{left, stands};
use crate::tables::{Control, Orientation, Tables};
use ncfix_base::geometry::Axis;

pub(super) const SCHEME: Scheme = Scheme {
    name: "trigonometric",
    title: "arms of the linear axes times trigonometric functions of a rotary axis (23 on five axes)",
    needs: &[Holds::Own, Holds::Cross, Holds::Products],
    home: Orientation::SixRows,
    finds_nodes: false,
    fill: trigonometric,
};

/// Number of poses for selecting a rotary axis.
const POSES: usize = 300;
/// Seed of their generator.
const SEED: u64 = 0x5452_4947;

fn trigonometric(task: &Task<'_>) -> Result<Tables, String> {
    let rotary: Vec<Axis> = task.target.rotary().collect();
    let mut best: Option<(f64, Tables)> = None;
    for axis in rotary {
        let tables = of(task, axis)?;
        let poses = stands(&task.region.poses(POSES, SEED), &[]);
        let rms_mm = left(&task.target, &Control::new(task.target.machine, &tables), &poses).rms_mm();
        if best.as_ref().is_none_or(|(least, _)| rms_mm < *least) {
            best = Some((rms_mm, tables));
        }
    }
    best.map(|(_, tables)| tables).ok_or_else(|| "the machine has no rotary axis".to_owned())
}

/// With the functions of one rotary axis.
fn of(task: &Task<'_>, axis: Axis) -> Result<Tables, String> {
    let waves = |lever| Wave::ALL.map(|wave| FitTerm::Wave(lever, axis, wave));
    let levers = task.region.axes().filter(|axis| !axis.is_rotary());
    let linear: Vec<FitTerm> = waves(None).into_iter().chain(levers.flat_map(|lever| waves(Some(lever)))).collect();
    fill(task, &|output| if output.is_rotary() { waves(None).to_vec() } else { linear.clone() })
}
