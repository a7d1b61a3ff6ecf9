//! Sums of functions of one axis: 25 tables on a machine with five axes (Esmaeili 2021, chapter 5; Creamer et al. 2016).
//!
//! Δq_i = Σ_j f_ij(q_j), f_ij a cubic polynomial (eq. 24) or free at the points of the table. Where the polynomials leave less, `free` takes them. Products of two axes, such as the arm of an angular
//! error, are not represented.

use super::fit::{FitTerm, fill};
use super::rival::better;
use super::{Holds, Scheme, Task};
use crate::tables::{Orientation, Tables};
use ncfix_base::geometry::{AXES, Axis, AxisVector};

/// Highest power (Esmaeili 2021, eq. 24).
const DEGREE: i32 = 3;
/// Number of poses that compare both ends of a turn, and their seed.
const END_POSES: usize = 20;
const END_SEED: u64 = 0x454e_4453;
/// Difference of corrections at both ends that is rounding, mm or rad: 1 nm.
const SAME_END: f64 = 1e-6;

pub(super) const POLYNOMIALS: Scheme = Scheme {
    name: "polynomial",
    title: "a table for each pair of axes, cubic polynomials (25 on five axes)",
    needs: &[Holds::Own, Holds::Cross],
    home: Orientation::SixRows,
    finds_nodes: false,
    fill: polynomials,
};

pub(super) const FREE: Scheme = Scheme {
    name: "free",
    title: "a table for each pair of axes, each point fitted freely (25 on five axes)",
    needs: &[Holds::Own, Holds::Cross],
    home: Orientation::Smooth,
    finds_nodes: false,
    fill: free,
};

fn polynomials(task: &Task<'_>) -> Result<Tables, String> {
    let powers = |axis| (1..=DEGREE).map(move |power| FitTerm::Power(axis, power));
    let terms: Vec<FitTerm> = [FitTerm::One].into_iter().chain(task.region.axes().flat_map(powers)).collect();
    fill(task, &|_| terms.clone())
}

fn free(task: &Task<'_>) -> Result<Tables, String> {
    let rings = rings(task)?;
    let terms: Vec<FitTerm> = task.region.axes().flat_map(|axis| hats(task, axis, rings.contains(&axis))).collect();
    let own = fill(task, &|_| terms.clone())?;
    Ok(better(task, own, polynomials(task)))
}

/// A function of an axis that is free at every point.
fn hats(task: &Task<'_>, axis: Axis, is_ring: bool) -> Vec<FitTerm> {
    if is_ring {
        (0..task.points - 1).map(|node| FitTerm::Ring(axis, node)).collect()
    } else {
        (0..task.points).map(|node| FitTerm::Hat(axis, node)).collect()
    }
}

/// The rotary axes over a turn at whose ends the corrections are the same: tables that differ there by the chance of a fit could not repeat.
fn rings(task: &Task<'_>) -> Result<Vec<Axis>, String> {
    let mut rings = Vec::new();
    for axis in task.region.axes().filter(|axis| axis.is_rotary()) {
        let [low, high] = task.region.range(axis);
        if task.points < 3 || (high - low - std::f64::consts::TAU).abs() > 1e-9 {
            continue;
        }
        let mut poses = task.region.poses(END_POSES, END_SEED);
        poses.iter_mut().for_each(|pose| pose[axis] = low);
        let first = task.exact(&poses)?;
        poses.iter_mut().for_each(|pose| pose[axis] = high);
        let differs = |one: &AxisVector, other: &AxisVector| {
            AXES.into_iter().any(|axis| (one[axis] - other[axis]).abs() > SAME_END)
        };
        if !first.iter().zip(&task.exact(&poses)?).any(|(one, other)| differs(one, other)) {
            rings.push(axis);
        }
    }
    Ok(rings)
}
