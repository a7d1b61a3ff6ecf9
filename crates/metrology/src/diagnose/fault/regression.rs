//! Least squares of the readings of a sensor or an instrument on columns by row, over some rows.

use nalgebra::{DMatrix, DVector};

/// Ridge relative to the squares of a column, for columns that are nearly equal.
const RIDGE: f64 = 1e-9;

/// Products of columns with each other and with the readings.
pub(super) struct ColumnProducts {
    gram: DMatrix<f64>,
    right: DVector<f64>,
}

impl ColumnProducts {
    /// The products over some rows; rows without a reading have no part.
    pub(super) fn new(columns: &[Vec<f64>], values: &[f64], rows: impl Iterator<Item = usize>) -> ColumnProducts {
        let width = columns.len();
        let (mut gram, mut right) = (DMatrix::zeros(width, width), DVector::zeros(width));
        let mut own = DVector::zeros(width);
        for row in rows.filter(|&row| values[row].is_finite()) {
            own.iter_mut().zip(columns).for_each(|(to, column)| *to = column[row]);
            gram.ger(1.0, &own, &own, 1.0);
            right.axpy(values[row], &own, 1.0);
        }
        ColumnProducts { gram, right }
    }

    /// Without the rows of others.
    pub(super) fn without(&self, other: &ColumnProducts) -> ColumnProducts {
        ColumnProducts { gram: &self.gram - &other.gram, right: &self.right - &other.right }
    }

    /// The amounts of the columns; `None` if they are not identifiable.
    pub(super) fn amounts(&self) -> Option<DVector<f64>> {
        let mut gram = self.gram.clone();
        for k in 0..gram.nrows() {
            gram[(k, k)] *= 1.0 + RIDGE;
        }
        Some(gram.cholesky()?.solve(&self.right))
    }
}

/// Readings minus the columns with these amounts, in a range of rows; rows without a reading are left out.
pub(super) fn residuals(
    columns: &[Vec<f64>],
    values: &[f64],
    amounts: &DVector<f64>,
    rows: std::ops::Range<usize>,
) -> Vec<f64> {
    let fitted =
        |row: usize| columns.iter().zip(amounts.iter()).map(|(column, amount)| column[row] * amount).sum::<f64>();
    rows.filter(|&row| values[row].is_finite()).map(|row| values[row] - fitted(row)).collect()
}
