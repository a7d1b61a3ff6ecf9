//! Sums of functions of one axis: 25 tables on a machine with five axes (Esmaeili 2021, chapter 5; Creamer et al. 2016).
//!
//! Δq_i = Σ_j f_ij(q_j), f_ij a cubic polynomial (eq. 24) or free at the points of the table. Products of two axes, such as the arm of an angular
//! error, are not represented.

use super::fit::{FitTerm, fill};
use super::{Holds, Scheme, Task};
use crate::tables::{Orientation, Tables};
use ncfix_base::geometry::Axis;

/// Highest power (Esmaeili 2021, eq. 24).
const DEGREE: i32 = 3;

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
    let terms: Vec<FitTerm> = task.region.axes().flat_map(|axis| hats(task, axis)).collect();
    fill(task, &|_| terms.clone())
}

/// A function of an axis that is free at every point.
fn hats(task: &Task<'_>, axis: Axis) -> Vec<FitTerm> {
    let moves = task.region.axes().any(|one| one == axis);
    if moves { (0..task.points).map(|node| FitTerm::Hat(axis, node)).collect() } else { vec![FitTerm::One] }
}
