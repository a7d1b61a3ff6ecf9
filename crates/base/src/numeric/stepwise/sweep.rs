//! Gram matrix with sweep operations: shows the effect of adding, removing or exchanging a column directly.
//!
//! Symmetric sweep operator with the set S of columns inside. An element outside is its residual after projection on S, an element between inside and outside
//! is a coefficient, and an element inside is −(XᵀX)⁻¹ (Lange 2010, ch. 7). The last column is the value.

use nalgebra::DMatrix;

/// A column is dependent if a smaller share of its square remains, given the others.
const LEAST_LEFT: f64 = 1e-8;

/// Swept Gram matrix.
#[derive(Clone, Debug)]
pub(super) struct Swept {
    matrix: DMatrix<f64>,
    squares: Vec<f64>,
    inside: Vec<bool>,
}

impl Swept {
    /// Creates the matrix with no column inside.
    pub(super) fn new(gram: DMatrix<f64>) -> Swept {
        let squares: Vec<f64> = gram.diagonal().iter().copied().collect();
        let inside = vec![false; squares.len()];
        Swept { matrix: gram, squares, inside }
    }

    fn value(&self) -> usize {
        self.squares.len().saturating_sub(1)
    }

    pub(super) fn is_inside(&self, column: usize) -> bool {
        self.inside.get(column).copied().unwrap_or(false)
    }

    /// True if a column outside is linearly independent of those inside.
    pub(super) fn is_told(&self, column: usize) -> bool {
        let left = self.matrix[(column, column)];
        left > LEAST_LEFT * self.squares[column] && left > f64::MIN_POSITIVE
    }

    /// Sweeps a column in or out; returns false if it depends on those inside.
    pub(super) fn pivot(&mut self, column: usize) -> bool {
        let is_inside = self.is_inside(column);
        if !is_inside && !self.is_told(column) {
            return false;
        }
        let own = self.matrix.column(column).into_owned();
        let pivot = own[column];
        for (k, &factor) in own.iter().enumerate() {
            if factor == 0.0 || k == column {
                continue;
            }
            self.matrix.column_mut(k).axpy(-factor / pivot, &own, 1.0);
        }
        let scale = if is_inside { -1.0 / pivot } else { 1.0 / pivot };
        for (k, &factor) in own.iter().enumerate() {
            self.matrix[(k, column)] = factor * scale;
            self.matrix[(column, k)] = factor * scale;
        }
        self.matrix[(column, column)] = -1.0 / pivot;
        if let Some(inside) = self.inside.get_mut(column) {
            *inside = !is_inside;
        }
        true
    }

    /// Returns the residual sum of squares of the value.
    pub(super) fn left(&self) -> f64 {
        self.matrix[(self.value(), self.value())].max(0.0)
    }

    /// Returns the coefficient of a column inside.
    pub(super) fn coefficient(&self, column: usize) -> f64 {
        self.matrix[(column, self.value())]
    }

    /// Returns its variance at unit noise; for a column outside, the variance it would have inside.
    pub(super) fn variance(&self, column: usize) -> f64 {
        let own = self.matrix[(column, column)];
        if self.is_inside(column) { -own } else { 1.0 / own }
    }

    /// Returns the decrease of the squares if a column enters.
    pub(super) fn gain(&self, column: usize) -> f64 {
        self.coefficient(column).powi(2) / self.matrix[(column, column)]
    }

    /// Returns the increase of the squares if a column leaves.
    pub(super) fn loss(&self, column: usize) -> f64 {
        self.coefficient(column).powi(2) / self.variance(column)
    }

    /// Returns the decrease of the squares if `enters` replaces `leaves`; `None` if `enters` depends on the other columns.
    pub(super) fn exchange(&self, leaves: usize, enters: usize) -> Option<f64> {
        let (variance, shared) = (self.variance(leaves), self.matrix[(leaves, enters)]);
        let coefficient = self.coefficient(leaves);
        let left = self.matrix[(enters, enters)] + shared * shared / variance;
        let along = self.coefficient(enters) + shared * coefficient / variance;
        (left > LEAST_LEFT * self.squares[enters]).then(|| along * along / left - coefficient * coefficient / variance)
    }

    /// Returns the decrease of the squares if two columns enter together; `None` if they depend on each other, given those inside.
    pub(super) fn gain_of_two(&self, one: usize, other: usize) -> Option<f64> {
        let (first, second, shared) = (self.matrix[(one, one)], self.matrix[(other, other)], self.matrix[(one, other)]);
        let (along_first, along_second) = (self.coefficient(one), self.coefficient(other));
        let apart = first * second - shared * shared;
        let fall = along_first * (along_first * second - along_second * shared)
            + along_second * (along_second * first - along_first * shared);
        (apart > LEAST_LEFT * first * second).then(|| fall / apart)
    }

    /// Returns an element of (XᵀX)⁻¹ of the columns inside; zero for others.
    pub(super) fn cofactor(&self, one: usize, other: usize) -> f64 {
        if self.is_inside(one) && self.is_inside(other) { -self.matrix[(one, other)] } else { 0.0 }
    }

    /// Returns the partial correlation of two columns outside, given those inside.
    pub(super) fn correlation(&self, one: usize, other: usize) -> f64 {
        self.matrix[(one, other)] / (self.matrix[(one, one)] * self.matrix[(other, other)]).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns four columns and a value in seven rows.
    fn rows() -> DMatrix<f64> {
        DMatrix::from_row_slice(
            7,
            5,
            &[
                1.0, 2.0, 0.5, 3.0, 1.1, 1.0, -1.0, 0.2, 1.0, 2.0, 1.0, 0.3, -2.0, 0.0, 0.7, 1.0, 4.0, 1.0, -1.0, 3.3,
                1.0, 0.0, 0.0, 2.0, -1.0, 1.0, 1.5, 3.0, 1.0, 0.4, 1.0, -2.0, 1.0, 1.0, 5.0,
            ],
        )
    }

    fn squares(columns: &[usize]) -> (f64, Vec<f64>) {
        let rows = rows();
        let (x, y) = (rows.select_columns(columns), rows.column(4).into_owned());
        let found = (x.transpose() * &x).try_inverse().unwrap() * x.transpose() * &y;
        ((y - x * &found).norm_squared(), found.iter().copied().collect())
    }

    #[test]
    fn entering_leaving_and_exchange_are_those_of_least_squares() {
        let rows = rows();
        let mut swept = Swept::new(rows.transpose() * &rows);
        assert!(swept.pivot(0) && swept.pivot(2));
        let (both, found) = squares(&[0, 2]);
        assert!((swept.left() - both).abs() < 1e-9);
        assert!((swept.coefficient(0) - found[0]).abs() < 1e-9 && (swept.coefficient(2) - found[1]).abs() < 1e-9);
        assert!((swept.gain(3) - (both - squares(&[0, 2, 3]).0)).abs() < 1e-9);
        assert!((swept.gain_of_two(1, 3).unwrap() - (both - squares(&[0, 1, 2, 3]).0)).abs() < 1e-9);
        assert!((swept.loss(2) - (squares(&[0]).0 - both)).abs() < 1e-9);
        assert!((swept.exchange(2, 1).unwrap() - (both - squares(&[0, 1]).0)).abs() < 1e-9);
        assert!(swept.pivot(2));
        assert!((swept.left() - squares(&[0]).0).abs() < 1e-9 && !swept.is_inside(2));
    }

    #[test]
    fn what_others_tell_does_not_enter() {
        let mut rows = rows();
        let sum = rows.column(0) + rows.column(1);
        rows.set_column(2, &sum);
        let mut swept = Swept::new(rows.transpose() * &rows);
        assert!(swept.pivot(0) && swept.pivot(1) && !swept.pivot(2));
        assert!(swept.exchange(1, 2).is_some(), "but it may stand for one of them");
    }
}
