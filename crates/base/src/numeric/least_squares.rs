//! Weighted linear least squares of many rows and few columns, with rank, covariance and null space.
//!
//! Rows are folded into a triangle as they arrive (QR by Householder reflections, block by block), so memory does not grow with their number. The singular
//! values are those of the triangle with columns of unit length. Combinations that are not identifiable from the data stay zero and are listed in the null
//! space; they are never filled with noise.

use nalgebra::{DMatrix, DVector};

/// Minimum number of rows that are folded at once; more if there are many columns.
const BLOCK: usize = 512;
/// Singular values below this share of the largest one are zero. Measurement plans in the literature have their last one at 2e-4, and the next one, which is
/// numerical noise, at 1e-16. If positions scatter slightly about a confounded arrangement, it lies in between. At 1e-6, noise of 1 µm would become
/// millimeters of errors that cancel each other.
pub const RANK_LIMIT: f64 = 1e-6;
/// Components of the null space above this are not rounding errors.
pub(super) const LOST: f64 = 1e-6;
/// Maximum number of steps of the decomposition.
pub(super) const MAX_SWEEPS: usize = 100_000;

/// System that grows row by row.
#[derive(Clone, Debug)]
pub struct System {
    columns: usize,
    /// Triangle, with rows below it that are not folded yet; the value is in the last column.
    pending: DMatrix<f64>,
    filled: usize,
    rows: usize,
}

/// Solution of a system.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Unknowns.
    pub unknowns: DVector<f64>,
    /// (JᵀJ)⁺: covariance at unit noise.
    pub cofactors: DMatrix<f64>,
    /// Singular values of the system with columns of unit length, in descending order.
    pub singular_values: Vec<f64>,
    /// Number of nonzero singular values.
    pub rank: usize,
    /// Directions that are not identifiable, each of unit length, by columns of unit length: the components of a direction are sizes of effects, whatever the
    /// units of the unknowns.
    pub null_space: Vec<DVector<f64>>,
    /// Sum of the squared residuals.
    pub squares: f64,
    /// Degrees of freedom: rows minus rank.
    pub freedom: usize,
    /// Variance inflation of every unknown: the growth of its variance because others are free; 1 if it is uncorrelated, infinite if it is in the null space.
    pub inflation: Vec<f64>,
}

impl System {
    /// Creates a system without rows.
    #[must_use]
    pub fn new(columns: usize) -> System {
        let rows = (columns + 1) + BLOCK.max(columns + 1);
        System { columns, pending: DMatrix::zeros(rows, columns + 1), filled: 0, rows: 0 }
    }

    /// Adds a row: factors, value and weight (1/σ).
    pub fn add(&mut self, factors: &[f64], value: f64, weight: f64) {
        if self.filled == self.pending.nrows() {
            self.fold();
        }
        for (column, factor) in factors.iter().enumerate().take(self.columns) {
            self.pending[(self.filled, column)] = factor * weight;
        }
        self.pending[(self.filled, self.columns)] = value * weight;
        self.filled += 1;
        self.rows += 1;
    }

    fn fold(&mut self) {
        let width = self.columns + 1;
        let height = self.filled.min(self.pending.nrows());
        if height > width {
            let triangle = self.pending.rows(0, height).into_owned().qr().unpack_r();
            self.pending.fill(0.0);
            self.pending.view_mut((0, 0), (width, width)).copy_from(&triangle);
            self.filled = width;
        }
    }

    /// Returns the number of rows so far.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Removes an unknown: its factors are set to zero in all rows so far.
    pub fn clear(&mut self, column: usize) {
        // The triangle of rows without a column is the triangle without it.
        if column < self.columns {
            self.pending.column_mut(column).fill(0.0);
        }
    }

    /// Returns the system of all rows with only the unknowns from `first` on.
    #[must_use]
    pub fn behind(&self, first: usize) -> System {
        let mut out = System::new(self.columns.saturating_sub(first));
        for row in self.pending.row_iter().take(self.filled) {
            let row: Vec<f64> = row.iter().copied().skip(first).collect();
            if let Some((value, factors)) = row.split_last() {
                out.add(factors, *value, 1.0);
            }
        }
        out.rows = self.rows;
        out
    }

    /// Solves it with [`RANK_LIMIT`]; `None` if it contains numbers that are not finite.
    #[must_use]
    pub fn solve(self) -> Option<Solution> {
        self.solve_to(RANK_LIMIT)
    }

    /// Solves it with a given limit for singular values, as a share of the largest one.
    #[must_use]
    pub fn solve_to(self, limit: f64) -> Option<Solution> {
        self.solve_scaled(None, limit)
    }

    /// As [`System::solve_to`], with the factors by which columns are multiplied before the decomposition. Then `limit` is that of the singular values
    /// themselves.
    pub(super) fn solve_scaled(mut self, scale: Option<&[f64]>, limit: f64) -> Option<Solution> {
        self.fold();
        let n = self.columns;
        // Square, so that all right singular vectors exist.
        let height = self.filled.max(n);
        let mut matrix = self.pending.view((0, 0), (height, n)).into_owned();
        let values = self.pending.view((0, n), (height, 1)).column(0).into_owned();
        let total = values.norm_squared();
        if !total.is_finite() || matrix.iter().any(|factor| !factor.is_finite()) {
            return None;
        }
        let is_given = scale.is_some();
        let scale: Vec<f64> = match scale {
            Some(given) => given.to_vec(),
            None => matrix.column_iter().map(|column| unit_scale(column.norm())).collect(),
        };
        for (column, &scale) in scale.iter().enumerate() {
            matrix.column_mut(column).scale_mut(scale);
        }
        // Without columns there is nothing to decompose.
        let (left, found, right) = if n == 0 {
            (DMatrix::zeros(height, 0), DVector::zeros(0), DMatrix::zeros(0, 0))
        } else {
            let parts = matrix.try_svd(true, true, f64::EPSILON, MAX_SWEEPS)?;
            (parts.u?, parts.singular_values, parts.v_t?)
        };
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| found[b].total_cmp(&found[a]));
        let singular_values: Vec<f64> = order.iter().map(|&k| found[k]).collect();
        let limit = limit * if is_given { 1.0 } else { singular_values.first().copied().unwrap_or(0.0) };
        let rank = singular_values.iter().filter(|&&value| value > limit).count();
        let mut unknowns = DVector::zeros(n);
        let mut cofactors = DMatrix::zeros(n, n);
        let mut explained = DVector::zeros(height);
        for (&k, &value) in order.iter().zip(&singular_values).take(rank) {
            let amount = left.column(k).dot(&values);
            explained += left.column(k) * amount;
            let direction = right.row(k).transpose();
            unknowns += &direction * (amount / value);
            cofactors.ger(1.0 / (value * value), &direction, &direction, 1.0);
        }
        let null_space: Vec<DVector<f64>> = order.iter().skip(rank).map(|&k| right.row(k).transpose()).collect();
        let is_lost = |column: usize| null_space.iter().any(|vector| vector[column].abs() > LOST);
        let inflation =
            (0..n).map(|column| if is_lost(column) { f64::INFINITY } else { cofactors[(column, column)] }).collect();
        for (column, &scale) in scale.iter().enumerate() {
            unknowns[column] *= scale;
            cofactors.column_mut(column).scale_mut(scale);
            cofactors.row_mut(column).scale_mut(scale);
        }
        Some(Solution {
            unknowns,
            cofactors,
            singular_values,
            rank,
            null_space,
            // Not the difference of the squares, which loses all digits if the fit is good.
            squares: (values - explained).norm_squared(),
            freedom: self.rows.saturating_sub(rank),
            inflation,
        })
    }
}

/// Returns the factor that makes a column of this length a unit vector; 1 for an empty one.
pub(super) fn unit_scale(length: f64) -> f64 {
    if length > 0.0 { 1.0 / length } else { 1.0 }
}

impl Solution {
    /// Returns the condition number: largest by smallest nonzero singular value, for columns of unit length.
    #[must_use]
    pub fn condition(&self) -> f64 {
        match (self.singular_values.first(), self.rank.checked_sub(1).and_then(|last| self.singular_values.get(last))) {
            (Some(largest), Some(smallest)) => largest / smallest,
            _ => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_points() {
        // y = 2 + 3 x with residuals 1, -2, 1 at 0, 1, 2: orthogonal to both columns.
        let mut system = System::new(2);
        for (x, y) in [(0.0, 3.0), (1.0, 3.0), (2.0, 9.0)] {
            system.add(&[1.0, x], y, 1.0);
        }
        let solution = system.solve().unwrap();
        assert!((solution.unknowns[0] - 2.0).abs() < 1e-12 && (solution.unknowns[1] - 3.0).abs() < 1e-12);
        assert!((solution.squares - 6.0).abs() < 1e-12);
        assert_eq!((solution.rank, solution.freedom), (2, 1));
        // σ² (XᵀX)⁻¹ with XᵀX = [3 3; 3 5].
        assert!((solution.cofactors[(0, 0)] - 5.0 / 6.0).abs() < 1e-12);
        assert!((solution.cofactors[(0, 1)] + 0.5).abs() < 1e-12);
    }

    #[test]
    fn many_rows_give_what_the_normal_equations_give() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let truth = [1.0, -2.0, 0.5, 3e3];
        let mut system = System::new(4);
        let (mut normal, mut right) = (DMatrix::<f64>::zeros(4, 4), DVector::<f64>::zeros(4));
        for _ in 0..5000 {
            let row = [random(), random(), 1.0, 1e-3 * random()];
            let value = row.iter().zip(truth).map(|(factor, truth)| factor * truth).sum::<f64>() + 0.01 * random();
            let weight = 1.0 + random().abs();
            system.add(&row, value, weight);
            let vector = DVector::from_row_slice(&row) * weight;
            normal += &vector * vector.transpose();
            right += &vector * (value * weight);
        }
        let inverse = normal.try_inverse().unwrap();
        let expected = &inverse * right;
        let solution = system.solve().unwrap();
        for k in 0..4 {
            assert!((solution.unknowns[k] - expected[k]).abs() < 1e-8 * expected[k].abs().max(1.0));
            assert!((solution.cofactors[(k, k)] / inverse[(k, k)] - 1.0).abs() < 1e-7);
        }
        assert_eq!((solution.rank, solution.freedom), (4, 4996));
    }

    #[test]
    fn what_cannot_be_told_is_named() {
        // The third column is the sum of the first two.
        let mut system = System::new(3);
        for k in 0..20 {
            let (a, b) = (f64::from(k), f64::from(k * k % 7));
            system.add(&[a, b, a + b], a, 1.0);
        }
        let solution = system.solve().unwrap();
        assert_eq!((solution.rank, solution.freedom, solution.null_space.len()), (2, 18, 1));
        let direction = &solution.null_space[0];
        // By columns of unit length: a x₁ + b x₂ − (a + b) x₃ = 0.
        let length = |of: fn(f64) -> f64| (0..20).map(|k| of(f64::from(k)).powi(2)).sum::<f64>().sqrt();
        let lengths = [length(|k| k), length(|k| k * k % 7.0), length(|k| k + k * k % 7.0)];
        let parts = [0, 1, 2].map(|k| direction[k] / lengths[k]);
        assert!((parts[0] - parts[1]).abs() < 1e-12 && (parts[0] + parts[2]).abs() < 1e-12);
        assert!(solution.inflation.iter().all(|value| value.is_infinite()));
        assert!(solution.squares < 1e-18);
    }

    #[test]
    fn without_unknowns_all_is_left() {
        let mut system = System::new(0);
        system.add(&[], 3.0, 1.0);
        system.add(&[], 2.0, 2.0);
        let solution = system.solve().unwrap();
        assert_eq!((solution.rank, solution.freedom), (0, 2));
        assert!((solution.squares - 25.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_finite_has_no_solution() {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut system = System::new(1);
            (0..600).for_each(|_| system.add(&[1.0], 1.0, 1.0));
            system.add(&[bad], 1.0, 1.0);
            assert!(system.solve().is_none());
        }
    }

    #[test]
    fn fewer_rows_than_unknowns_are_no_failure() {
        let mut system = System::new(3);
        system.add(&[1.0, 0.0, 2.0], 5.0, 1.0);
        let solution = system.solve().unwrap();
        assert_eq!((solution.rank, solution.freedom), (1, 0));
        // The shortest solution in columns of unit length.
        assert!((solution.unknowns[0] + 2.0 * solution.unknowns[2] - 5.0).abs() < 1e-12);
    }
}
