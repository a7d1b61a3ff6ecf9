//! Orthonormal columns that are computed once and fitted many times, with other rows each time.

use nalgebra::{DMatrix, DVector};

use super::Series;
use super::sums::dot;

/// A column is dependent if less than this share of its squares remains, given the others, in the rows that count.
const DEPENDENT: f64 = 1e-8;

/// Orthonormal columns.
#[derive(Clone, Debug, Default)]
pub struct Upright {
    columns: Vec<Vec<f64>>,
}

impl Upright {
    /// Orthonormalizes columns; dependent ones are omitted.
    #[must_use]
    pub fn new(columns: &[Vec<f64>]) -> Upright {
        let rows = columns.first().map_or(0, Vec::len);
        let mut series = Series::new(&vec![0; rows], &vec![1.0; rows], 0.0);
        columns.iter().for_each(|column| {
            series.take(column);
        });
        Upright { columns: series.basis().iter().map(|direction| direction.whole(rows)).collect() }
    }

    /// Returns the least-squares fit of values in the rows that count, by all columns and another one: the prediction of all columns except that one for
    /// every row, and the amount of that one (0 if it is dependent). If the columns are dependent in these rows, the minimum-norm solution is used.
    ///
    /// JᵀJ of orthonormal columns is the identity minus the products of the rows that do not count. So a few omitted rows are cheap, and no precision is
    /// lost.
    #[must_use]
    pub fn fitted(&self, values: &[f64], counts: &[bool], other: Option<&[f64]>) -> (Vec<f64>, f64) {
        let zeroed = |column: &[f64]| -> Vec<f64> {
            column.iter().zip(counts).map(|(value, counts)| if *counts { *value } else { 0.0 }).collect()
        };
        let out: Vec<usize> = (0..counts.len()).filter(|&row| !counts[row]).collect();
        let count = self.columns.len();
        let at = |column: &Vec<f64>, row: usize| column.get(row).copied().unwrap_or(0.0);
        let inner = DMatrix::from_fn(count, count, |a, b| {
            let [one, two] = [&self.columns[a], &self.columns[b]];
            f64::from(u8::from(a == b)) - out.iter().map(|&row| at(one, row) * at(two, row)).sum::<f64>()
        });
        if count == 0 {
            let amount = other.map_or(0.0, |other| {
                let own = zeroed(other);
                let squares = dot(&own, &own);
                if squares > 0.0 { dot(&own, &zeroed(values)) / squares } else { 0.0 }
            });
            return (
                other.map_or(vec![0.0; values.len()], |other| other.iter().map(|one| amount * one).collect()),
                amount,
            );
        }
        let parts = inner.symmetric_eigen();
        let shares = parts.eigenvalues.map(|value| if value > DEPENDENT { 1.0 / value } else { 0.0 });
        let solve = &parts.eigenvectors * DMatrix::from_diagonal(&shares) * parts.eigenvectors.transpose();
        let of = |values: &[f64]| {
            let values = zeroed(values);
            DVector::from_iterator(count, self.columns.iter().map(|column| dot(column, &values)))
        };
        let mut amounts = &solve * of(values);
        let mut amount = 0.0;
        if let Some(other) = other {
            // Residual of the other column after projection on the columns (Schur complement).
            let (products, own) = (of(other), zeroed(other));
            let by_columns = &solve * &products;
            let squares = dot(&own, &own);
            let left = squares - products.dot(&by_columns);
            if left > DEPENDENT * squares {
                amount = (dot(&own, values) - products.dot(&amounts)) / left;
                amounts -= by_columns * amount;
            }
        }
        let mut fitted = vec![0.0; values.len()];
        for (column, amount) in self.columns.iter().zip(amounts.iter()) {
            fitted.iter_mut().zip(column).for_each(|(sum, value)| *sum += amount * value);
        }
        (fitted, amount)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_fitted_is_what_the_rows_that_count_say() {
        // 3 − 2 t + 0.5 t², and 7 more from row 6 on; two rows are outliers.
        let times: Vec<f64> = (0..12).map(f64::from).collect();
        let columns: Vec<Vec<f64>> = (0..3).map(|power| times.iter().map(|t| t.powi(power)).collect()).collect();
        let step: Vec<f64> = (0..12).map(|row| if row < 6 { 0.0 } else { 1.0 }).collect();
        let smooth: Vec<f64> = times.iter().map(|t| 3.0 - 2.0 * t + 0.5 * t * t).collect();
        let mut values: Vec<f64> = smooth.iter().zip(&step).map(|(value, step)| value + 7.0 * step).collect();
        let mut counts = vec![true; 12];
        for row in [2, 9] {
            values[row] = 1e3;
            counts[row] = false;
        }
        let mut with_twin = columns.clone();
        with_twin.push(columns[1].iter().map(|value| 2.0 * value).collect());
        let (fitted, amount) = Upright::new(&with_twin).fitted(&values, &counts, Some(&step));
        assert!((amount - 7.0).abs() < 1e-9, "{amount}");
        fitted.iter().zip(&smooth).for_each(|(one, other)| assert!((one - other).abs() < 1e-9));
        // A column that depends on the columns has no amount.
        let (_, amount) = Upright::new(&columns).fitted(&values, &counts, Some(&columns[2]));
        assert_eq!(amount, 0.0);
        // Two rows for three columns: both are matched.
        let few: Vec<bool> = (0..12).map(|row| row < 2).collect();
        let (fitted, _) = Upright::new(&columns).fitted(&values, &few, None);
        (0..2).for_each(|row| assert!((fitted[row] - values[row]).abs() < 1e-6, "{fitted:?}"));
    }
}
