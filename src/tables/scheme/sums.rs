//! Sums of functions of one axis: 25 tables on a machine with five axes (Esmaeili 2021, chapter 5; Creamer et al. 2016).
//!
//! Δq_i = Σ_j f_ij(q_j), f_ij a cubic polynomial (eq. 24) or free at the points of the table. Products of two axes, such as the arm of an
//! angular error, are beyond it.

use super::fit::{Term, fill};
use super::{Holds, Scheme, Task};
use crate::tables::Tables;

/// Highest power (Esmaeili 2021, eq. 24).
const DEGREE: i32 = 3;

pub(super) const POLYNOMIALS: Scheme = Scheme {
    name: "polynomial",
    title: "a table for each pair of axes, cubic polynomials (25 on five axes)",
    needs: &[Holds::Own, Holds::Cross],
    fill: polynomials,
};

pub(super) const FREE: Scheme = Scheme {
    name: "free",
    title: "a table for each pair of axes, free at every point (25 on five axes)",
    needs: &[Holds::Own, Holds::Cross],
    fill: free,
};

fn polynomials(task: &Task<'_>) -> Result<Tables, String> {
    let powers = |axis| (1..=DEGREE).map(move |power| Term::Power(axis, power));
    let terms: Vec<Term> = [Term::One].into_iter().chain(task.region.axes().flat_map(powers)).collect();
    fill(task, &terms, &terms)
}

fn free(task: &Task<'_>) -> Result<Tables, String> {
    let hats = |axis| (0..task.points).map(move |node| Term::Hat(axis, node));
    let terms: Vec<Term> = task.region.axes().flat_map(hats).collect();
    fill(task, &terms, &terms)
}
