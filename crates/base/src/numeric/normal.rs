//! Weighted normal equations: faster than folding rows into a triangle, but with half the digits.
//!
//! Suitable for iterated steps: the next step corrects the errors of the current one. Rank and covariance come from [`super::System`].

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};

/// Number of rows that are multiplied at once.
const BLOCK: usize = 256;
/// Smallest pivot, for columns of unit length; a matrix that is closer to singular leaves too few digits.
const LEAST_PIVOT: f64 = 1e-10;

/// JᵀWJ, for each of several groups of rows, and JᵀWr.
#[derive(Clone, Debug)]
pub struct Normal {
    groups: Vec<DMatrix<f64>>,
    right: DVector<f64>,
    /// Rows that are not multiplied yet, one per column, all of one group.
    pending: DMatrix<f64>,
    filled: usize,
    group: usize,
}

/// Step of the iteration.
#[derive(Clone, Debug)]
pub struct NormalStep {
    /// Unknowns.
    pub unknowns: DVector<f64>,
    /// Their variances at unit noise.
    pub variances: DVector<f64>,
    /// Degrees of freedom used by each group of rows; their sum is the number of unknowns.
    pub used: Vec<f64>,
}

impl Normal {
    /// Creates equations without rows.
    #[must_use]
    pub fn new(columns: usize, groups: usize) -> Normal {
        Normal {
            groups: vec![DMatrix::zeros(columns, columns); groups.max(1)],
            right: DVector::zeros(columns),
            pending: DMatrix::zeros(columns, BLOCK),
            filled: 0,
            group: 0,
        }
    }

    /// Adds a row of a group: factors, value and weight (1/σ). Consecutive rows of one group are faster.
    pub fn add(&mut self, group: usize, factors: &[f64], value: f64, weight: f64) {
        if self.filled == BLOCK || group != self.group {
            self.multiply();
            self.group = group.min(self.groups.len() - 1);
        }
        for ((to, sum), factor) in
            self.pending.column_mut(self.filled).iter_mut().zip(self.right.iter_mut()).zip(factors)
        {
            *to = factor * weight;
            *sum += factor * weight * (value * weight);
        }
        self.filled += 1;
    }

    fn multiply(&mut self) {
        if let (Some(group), true) = (self.groups.get_mut(self.group), self.filled > 0) {
            let rows = self.pending.columns(0, self.filled);
            group.gemm(1.0, &rows, &rows.transpose(), 1.0);
        }
        self.filled = 0;
    }

    /// Solves them; `None` if the matrix is not safely regular.
    #[must_use]
    pub fn solve(mut self) -> Option<NormalStep> {
        self.multiply();
        let count = self.right.len();
        let mut whole = DMatrix::zeros(count, count);
        self.groups.iter().for_each(|group| whole += group);
        let scale = whole.diagonal().map(|square| 1.0 / square.sqrt());
        if !scale.iter().all(|scale| scale.is_finite()) {
            return None;
        }
        let scaled = DMatrix::from_fn(count, count, |row, column| whole[(row, column)] * scale[row] * scale[column]);
        let factored = Cholesky::new(scaled)?;
        if factored.l_dirty().diagonal().iter().any(|pivot| pivot * pivot < LEAST_PIVOT) {
            return None;
        }
        let unknowns = factored.solve(&self.right.component_mul(&scale)).component_mul(&scale);
        let mut inverse = factored.inverse();
        for column in 0..count {
            inverse.column_mut(column).scale_mut(scale[column]);
            inverse.row_mut(column).scale_mut(scale[column]);
        }
        // tr(N⁻¹ Nᵍ) of each group; both are symmetric.
        let used = self.groups.iter().map(|group| group.dot(&inverse)).collect();
        Some(NormalStep { unknowns, variances: inverse.diagonal(), used })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::System;

    #[test]
    fn it_gives_what_the_triangle_gives() {
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut normal, mut system) = (Normal::new(3, 2), System::new(3));
        for k in 0..1000 {
            let row = [random(), 1e4 * random(), 1e-4 * random() + 1e-5];
            let (value, weight) = (random(), 1.5 + random());
            normal.add(usize::from(k > 700), &row, value, weight);
            system.add(&row, value, weight);
        }
        let (step, solution) = (normal.solve().unwrap(), system.solve().unwrap());
        for k in 0..3 {
            assert!((step.unknowns[k] / solution.unknowns[k] - 1.0).abs() < 1e-9);
            assert!((step.variances[k] / solution.cofactors[(k, k)] - 1.0).abs() < 1e-9);
        }
        assert!((step.used.iter().sum::<f64>() - 3.0).abs() < 1e-9);
        assert!((step.used[0] - 2.1).abs() < 0.2, "701 of 1000 rows alike use 70 %");
    }

    #[test]
    fn what_is_not_regular_gives_no_step() {
        let mut normal = Normal::new(2, 1);
        for k in 0..10 {
            normal.add(0, &[f64::from(k), 2.0 * f64::from(k)], 1.0, 1.0);
        }
        assert!(normal.solve().is_none());
        assert!(Normal::new(1, 1).solve().is_none());
    }
}
