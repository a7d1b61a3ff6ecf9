//! Linear regression on rows that come in series whose noise remembers: each residual is ρ times the one before plus something new.
//!
//! Rows are whitened – every row less ρ times the one before it in its series – and regressed on as if they were independent (Cochrane &
//! Orcutt 1949). Columns are taken into an orthonormal basis one after the other, so that what a further column would explain beside them is
//! known without solving anything.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::sums::dot;

/// A column of which less than this share of its length is left beside the others says nothing of its own.
pub(super) const DEPENDENT: f64 = 1e-6;
/// Where this share of the length is left, rounding leaves nothing that counts.
pub(super) const CLEAR: f64 = 0.1;
/// Memory beyond this is a random walk, of which one long row is left.
const MOST_MEMORY: f64 = 0.98;

/// Series of rows with weights, and a basis of columns.
#[derive(Clone, Debug)]
pub struct Series {
    /// The row before each one in its series.
    before: Arc<Vec<Option<usize>>>,
    weights: Arc<Vec<f64>>,
    memory: f64,
    basis: Vec<Arc<BasisColumn>>,
    left: Vec<f64>,
}

/// A column of a basis: of unit length, whitened, and zero but for some rows that follow each other; what belongs to one set-up is short.
#[derive(Clone, Debug)]
pub struct BasisColumn {
    first: usize,
    values: Vec<f64>,
}

/// What columns explain beside those of the basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// By how much the sum of the squares falls.
    pub squares: f64,
    /// Columns that say something of their own.
    pub rank: usize,
}

impl Series {
    /// `series` numbers the series of each row, which are in order within it; weights are 1/σ, 0 for a row that does not count.
    #[must_use]
    pub fn new(series: &[usize], weights: &[f64], memory: f64) -> Series {
        let mut last: std::collections::HashMap<usize, usize> = std::collections::HashMap::new();
        // A row that does not count is a gap that the memory bridges.
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

    /// Rows that count.
    #[must_use]
    pub fn count(&self) -> usize {
        self.weights.iter().filter(|&&weight| weight > 0.0).count()
    }

    /// A column whitened.
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

    /// What is regressed on the columns; those of the basis are taken out of it.
    pub fn set_values(&mut self, values: &[f64]) {
        self.left = self.whitened(values);
        for direction in &self.basis {
            direction.take_out_of(&mut self.left);
        }
    }

    /// Takes a column into the basis. Returns whether it says something of its own.
    pub fn take(&mut self, column: &[f64]) -> bool {
        self.take_with_shares(column).is_some()
    }

    /// Takes a column into the basis. Returns what it is of each column of the basis, at last of its own, and what is explained by this one.
    pub fn take_with_shares(&mut self, column: &[f64]) -> Option<(Vec<f64>, f64)> {
        let (taken, shares) = self.take_by_shares(column);
        taken.map(|explained| (shares, explained))
    }

    /// Takes a column into the basis if it says something of its own. Returns what is explained by it then, and what it is of each column of the basis.
    pub(super) fn take_by_shares(&mut self, column: &[f64]) -> (Option<f64>, Vec<f64>) {
        let mut shares = vec![0.0; self.basis.len()];
        let Some((direction, own)) = self.direction(column, &[], &mut shares) else { return (None, shares) };
        shares.push(own);
        let explained = direction.take_out_of(&mut self.left);
        self.basis.push(Arc::new(direction));
        (Some(explained), shares)
    }

    /// The columns of the basis, at right angles to each other.
    #[must_use]
    pub fn basis(&self) -> &[Arc<BasisColumn>] {
        &self.basis
    }

    /// Memory of the noise.
    #[must_use]
    pub fn memory(&self) -> f64 {
        self.memory
    }

    /// 1/σ of the rows.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The transpose of [`Series::whitened`]: the product of a column with what comes out is that of the whitened column with `direction`.
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

    /// Columns of the basis.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.basis.len()
    }

    /// Sum of the squares of what is left, in squares of σ.
    #[must_use]
    pub fn squares(&self) -> f64 {
        dot(&self.left, &self.left)
    }

    /// What is left, whitened.
    #[must_use]
    pub fn left(&self) -> &[f64] {
        &self.left
    }

    /// What columns would explain beside those of the basis.
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

    /// Amounts of columns that explain most beside the basis, and their covariance at unit noise; columns that depend on those before them get
    /// the amount 0 and no variance.
    #[must_use]
    pub fn amounts(&self, columns: &[Vec<f64>]) -> (Vec<f64>, DMatrix<f64>) {
        // Each column by the directions that it and those before it have of their own: a triangle.
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

    /// The part of a column at right angles to the basis and to others, of unit length, and its length; `shares` gets what the column is of those of
    /// the basis and of the others.
    fn direction(&self, column: &[f64], others: &[BasisColumn], shares: &mut [f64]) -> Option<(BasisColumn, f64)> {
        let mut rest = self.whitened(column);
        let length = dot(&rest, &rest).sqrt();
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        let mut own = length;
        let mut span = span(&rest);
        // Twice where little is left: what rounding leaves of the first time.
        for _ in 0..2 {
            for (place, other) in self.basis.iter().map(Arc::as_ref).chain(others).enumerate() {
                // What is zero wherever the other is not has none of it.
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

    /// Memory of residuals that are not whitened: the correlation of neighbours in the series.
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

/// Between which rows a column is not zero.
fn span(column: &[f64]) -> Range<usize> {
    let first = column.iter().position(|value| *value != 0.0).unwrap_or(column.len());
    let last = column.iter().rposition(|value| *value != 0.0).map_or(first, |last| last + 1);
    first..last
}

impl BasisColumn {
    fn end(&self) -> usize {
        self.first + self.values.len()
    }

    /// All of it, for so many rows.
    #[must_use]
    pub fn whole(&self, rows: usize) -> Vec<f64> {
        let mut out = vec![0.0; rows];
        self.add(1.0, &mut out);
        out
    }

    /// Its product with a column.
    #[must_use]
    pub fn dot(&self, column: &[f64]) -> f64 {
        dot(&self.values, column.get(self.first..).unwrap_or_default())
    }

    /// Adds so much of it to a column.
    pub(super) fn add(&self, amount: f64, to: &mut [f64]) {
        let to = to.get_mut(self.first..).unwrap_or_default();
        to.iter_mut().zip(&self.values).for_each(|(value, part)| *value += amount * part);
    }

    /// Takes it out of a column. Returns how much it was.
    fn take_out_of(&self, from: &mut [f64]) -> f64 {
        let amount = self.dot(from);
        self.add(-amount, from);
        amount
    }
}
