//! Linear regression on rows in series with autocorrelated noise: each residual is ρ times the previous one plus independent noise.
//!
//! Rows are whitened – every row minus ρ times the one before it in its series – and then regressed as if they were independent (Cochrane & Orcutt 1949).
//! Columns are added to an orthonormal basis one after the other. So the contribution of a further column is known without solving a system.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::sums::dot;

/// A column whose residual, given the others, is below this share of its length is linearly dependent.
pub(super) const DEPENDENT: f64 = 1e-6;
/// Share of the length above which rounding errors are negligible.
pub(super) const CLEAR: f64 = 0.1;
/// Maximum autocorrelation: beyond it the noise is a random walk, equivalent to a single long row.
const MOST_MEMORY: f64 = 0.98;

/// Series of rows with weights, and a basis of columns.
#[derive(Clone, Debug)]
pub struct Series {
    /// Previous row in the series of each row.
    before: Arc<Vec<Option<usize>>>,
    weights: Arc<Vec<f64>>,
    memory: f64,
    basis: Vec<Arc<BasisColumn>>,
    left: Vec<f64>,
}

/// Column of a basis: of unit length, whitened, and nonzero only in some consecutive rows. A column of a single set-up is short.
#[derive(Clone, Debug)]
pub struct BasisColumn {
    first: usize,
    values: Vec<f64>,
}

/// Improvement by columns in addition to those of the basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Reduction of the sum of squares.
    pub squares: f64,
    /// Number of linearly independent columns.
    pub rank: usize,
}

impl Series {
    /// Creates a series. `series` contains the series number of each row; rows are in order within a series. Weights are 1/σ, 0 for an ignored row.
    #[must_use]
    pub fn new(series: &[usize], weights: &[f64], memory: f64) -> Series {
        let mut last: std::collections::HashMap<usize, usize> = std::collections::HashMap::new();
        // An ignored row is a gap that the autocorrelation bridges.
        let before =
            series
                .iter()
                .enumerate()
                .map(|(row, number)| {
                    if weights.get(row).is_some_and(|&weight| weight > 0.0) { last.insert(*number, row) } else { None }
                })
                .collect();
        Series {
            before: Arc::new(before),
            weights: Arc::new(weights.to_vec()),
            memory: memory.clamp(0.0, MOST_MEMORY),
            basis: Vec::new(),
            left: vec![0.0; series.len()],
        }
    }

    /// Returns the number of rows with weight.
    #[must_use]
    pub fn count(&self) -> usize {
        self.weights.iter().filter(|&&weight| weight > 0.0).count()
    }

    /// Returns a whitened column.
    #[must_use]
    pub fn whitened(&self, column: &[f64]) -> Vec<f64> {
        let fresh = (1.0 - self.memory * self.memory).sqrt();
        let own = |row: usize| self.weights[row] * column.get(row).copied().unwrap_or(0.0);
        (0..self.weights.len())
            .map(|row| match self.before[row] {
                _ if self.weights[row] <= 0.0 => 0.0,
                Some(before) => (own(row) - self.memory * own(before)) / fresh,
                None => own(row),
            })
            .collect()
    }

    /// Sets the values that are regressed on the columns; the existing basis is projected out.
    pub fn set_values(&mut self, values: &[f64]) {
        self.left = self.whitened(values);
        for direction in &self.basis {
            direction.take_out_of(&mut self.left);
        }
    }

    /// Adds a column to the basis. Returns false if it is linearly dependent.
    pub fn take(&mut self, column: &[f64]) -> bool {
        self.take_with_shares(column).is_some()
    }

    /// Adds a column to the basis. Returns its components along the columns of the basis, the last one along itself, and the part that it explains.
    pub fn take_with_shares(&mut self, column: &[f64]) -> Option<(Vec<f64>, f64)> {
        let (taken, shares) = self.take_by_shares(column);
        taken.map(|explained| (shares, explained))
    }

    /// Adds a column to the basis if it is linearly independent. Returns the part that it then explains, and its components along the columns of the basis.
    pub(super) fn take_by_shares(&mut self, column: &[f64]) -> (Option<f64>, Vec<f64>) {
        let mut shares = vec![0.0; self.basis.len()];
        let Some((direction, own)) = self.direction(column, &[], &mut shares) else { return (None, shares) };
        shares.push(own);
        let explained = direction.take_out_of(&mut self.left);
        self.basis.push(Arc::new(direction));
        (Some(explained), shares)
    }

    /// Returns the orthonormal columns of the basis.
    #[must_use]
    pub fn basis(&self) -> &[Arc<BasisColumn>] {
        &self.basis
    }

    /// Returns the autocorrelation of the noise.
    #[must_use]
    pub fn memory(&self) -> f64 {
        self.memory
    }

    /// Returns 1/σ of the rows.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Applies the transpose of [`Series::whitened`]: the product of a column with the result equals that of the whitened column with `direction`.
    #[must_use]
    pub fn unwhitened(&self, direction: &[f64]) -> Vec<f64> {
        let fresh = (1.0 - self.memory * self.memory).sqrt();
        let mut out = vec![0.0; self.weights.len()];
        for (row, value) in direction.iter().enumerate().take(out.len()) {
            let weight = self.weights[row];
            if weight <= 0.0 {
                continue;
            }
            match self.before[row] {
                Some(before) if self.memory != 0.0 => {
                    out[row] += weight * value / fresh;
                    out[before] -= self.weights[before] * self.memory * value / fresh;
                }
                _ => out[row] += weight * value,
            }
        }
        out
    }

    /// Returns the number of columns of the basis.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.basis.len()
    }

    /// Returns the residual sum of squares, in squares of σ.
    #[must_use]
    pub fn squares(&self) -> f64 {
        dot(&self.left, &self.left)
    }

    /// Returns the residuals, whitened.
    #[must_use]
    pub fn left(&self) -> &[f64] {
        &self.left
    }

    /// Returns the improvement by columns in addition to those of the basis.
    #[must_use]
    pub fn gain(&self, columns: &[Vec<f64>]) -> Gain {
        let mut own: Vec<BasisColumn> = Vec::new();
        let mut squares = 0.0;
        for column in columns {
            if let Some((direction, _)) = self.direction(column, &own, &mut []) {
                squares += direction.dot(&self.left).powi(2);
                own.push(direction);
            }
        }
        Gain { squares, rank: own.len() }
    }

    /// Returns the least-squares amounts of columns, given the basis, and their covariance at unit noise. Columns that depend on those before them get the
    /// amount 0 and no variance.
    #[must_use]
    pub fn amounts(&self, columns: &[Vec<f64>]) -> (Vec<f64>, DMatrix<f64>) {
        // Each column by the independent directions of it and of those before it: a triangle.
        let mut own: Vec<BasisColumn> = Vec::new();
        let mut places = Vec::new();
        let mut triangle: Vec<Vec<f64>> = Vec::new();
        for (place, column) in columns.iter().enumerate() {
            let mut shares = vec![0.0; self.basis.len() + own.len()];
            let Some((direction, length)) = self.direction(column, &own, &mut shares) else { continue };
            own.push(direction);
            shares.push(length);
            triangle.push(shares.split_off(self.basis.len()));
            places.push(place);
        }
        let count = places.len();
        let upper = DMatrix::from_fn(count, count, |row, column| triangle[column].get(row).copied().unwrap_or(0.0));
        let right = DVector::from_iterator(count, own.iter().map(|direction| direction.dot(&self.left)));
        let mut amounts = vec![0.0; columns.len()];
        let mut covariance = DMatrix::zeros(columns.len(), columns.len());
        let identity = DMatrix::identity(count, count);
        let (Some(found), Some(inverse)) =
            (upper.solve_upper_triangular(&right), upper.solve_upper_triangular(&identity))
        else {
            return (amounts, covariance);
        };
        let small = &inverse * inverse.transpose();
        for (k, &place) in places.iter().enumerate() {
            amounts[place] = found[k];
            for (l, &other) in places.iter().enumerate() {
                covariance[(place, other)] = small[(k, l)];
            }
        }
        (amounts, covariance)
    }

    /// Returns the part of a column perpendicular to the basis and to others, normalized to unit length, and its length. `shares` receives the components of
    /// the column along the basis and the others.
    fn direction(&self, column: &[f64], others: &[BasisColumn], shares: &mut [f64]) -> Option<(BasisColumn, f64)> {
        let mut rest = self.whitened(column);
        let length = dot(&rest, &rest).sqrt();
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        let mut own = length;
        let mut span = span(&rest);
        // Twice if little remains, to remove the rounding errors of the first pass.
        for _ in 0..2 {
            for (place, other) in self.basis.iter().map(Arc::as_ref).chain(others).enumerate() {
                // Columns without common nonzero rows are orthogonal.
                if span.start.max(other.first) >= span.end.min(other.end()) {
                    continue;
                }
                let amount = other.take_out_of(&mut rest);
                span = span.start.min(other.first)..span.end.max(other.end());
                if let Some(share) = shares.get_mut(place) {
                    *share += amount;
                }
            }
            let part = rest.get(span.clone()).unwrap_or_default();
            own = dot(part, part).sqrt();
            if own > CLEAR * length {
                break;
            }
        }
        if own < DEPENDENT * length {
            return None;
        }
        let part = rest.get(span.clone()).unwrap_or_default();
        Some((BasisColumn { first: span.start, values: part.iter().map(|value| value / own).collect() }, own))
    }

    /// Returns the autocorrelation of residuals that are not whitened: the correlation of neighbors in the series.
    #[must_use]
    pub fn memory_of(&self, residuals: &[f64]) -> f64 {
        let own = |row: usize| self.weights[row] * residuals.get(row).copied().unwrap_or(0.0);
        let (mut product, mut square) = (0.0, 0.0);
        for (row, before) in self.before.iter().enumerate() {
            if let Some(before) = before {
                product += own(row) * own(*before);
                square += (own(row).powi(2) + own(*before).powi(2)) / 2.0;
            }
        }
        if square > 0.0 { (product / square).clamp(0.0, MOST_MEMORY) } else { 0.0 }
    }
}

/// Returns the range of rows in which a column is nonzero.
fn span(column: &[f64]) -> Range<usize> {
    let first = column.iter().position(|value| *value != 0.0).unwrap_or(column.len());
    let last = column.iter().rposition(|value| *value != 0.0).map_or(first, |last| last + 1);
    first..last
}

impl BasisColumn {
    fn end(&self) -> usize {
        self.first + self.values.len()
    }

    /// Returns the full column for `rows` rows.
    #[must_use]
    pub fn whole(&self, rows: usize) -> Vec<f64> {
        let mut out = vec![0.0; rows];
        self.add(1.0, &mut out);
        out
    }

    /// Returns its product with a column.
    #[must_use]
    pub fn dot(&self, column: &[f64]) -> f64 {
        dot(&self.values, column.get(self.first..).unwrap_or_default())
    }

    /// Adds it to a column, multiplied by `amount`.
    pub(super) fn add(&self, amount: f64, to: &mut [f64]) {
        let to = to.get_mut(self.first..).unwrap_or_default();
        to.iter_mut().zip(&self.values).for_each(|(value, part)| *value += amount * part);
    }

    /// Projects it out of a column. Returns the removed amount.
    fn take_out_of(&self, from: &mut [f64]) -> f64 {
        let amount = self.dot(from);
        self.add(-amount, from);
        amount
    }
}
