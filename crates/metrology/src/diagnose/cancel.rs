//! Candidates that nearly cancel each other. If two columns are nearly equal, the fit gives one a large amount and the other the opposite amount. Their sum
//! explains the small difference of the columns. Outside the measured places it can reach meters.

use ncfix_base::numeric::Series;

/// A candidate whose effect exceeds the residual by this factor is cancelled by others.
const CANCELS: f64 = 3.0;

/// Triangular factor of the regression on the columns of the candidates, in the order in which they were taken.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// Number of basis columns that precede those of the candidates.
    before: usize,
    /// Sum of squares before the first candidate.
    squares: f64,
    /// For each column: its candidate, and its shares in the basis columns after `before`.
    columns: Vec<(usize, Vec<f64>)>,
    /// Sum of squares that each column explains.
    explained: Vec<f64>,
}

impl Triangle {
    /// Starts after the columns that a series already has.
    pub(super) fn new(series: &Series) -> Triangle {
        Triangle { before: series.rank(), squares: series.squares(), columns: Vec::new(), explained: Vec::new() }
    }

    /// Adds the columns of a candidate to a series.
    pub(super) fn take(&mut self, series: &mut Series, number: usize, columns: &[Vec<f64>]) {
        for column in columns {
            if let Some((shares, explained)) = series.take_with_shares(column) {
                self.columns.push((number, shares.get(self.before..).unwrap_or_default().to_vec()));
                self.explained.push(explained);
            }
        }
    }

    /// Returns the candidate taken last whose effect on the readings, after the set-up unknowns, far exceeds the sum of squares to explain. Candidates in
    /// `kept` are skipped.
    pub(super) fn cancelled(&self, kept: &[usize]) -> Option<usize> {
        let count = self.columns.len();
        let mut amounts = self.explained.clone();
        for k in (0..count).rev() {
            let own = self.columns[k].1.get(k).copied().unwrap_or(1.0);
            amounts[k] /= own;
            for (l, share) in self.columns[k].1.iter().enumerate().take(k) {
                amounts[l] -= share * amounts[k];
            }
        }
        let mut does: Vec<(usize, Vec<f64>)> = Vec::new();
        for ((number, shares), amount) in self.columns.iter().zip(&amounts) {
            if does.last().is_none_or(|(last, _)| last != number) {
                does.push((*number, vec![0.0; count]));
            }
            if let Some((_, sums)) = does.last_mut() {
                sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += amount * share);
            }
        }
        let most = CANCELS * CANCELS * self.squares;
        let is_large = |sums: &[f64]| sums.iter().map(|sum| sum * sum).sum::<f64>() > most;
        does.iter().rev().find(|(number, sums)| !kept.contains(number) && is_large(sums)).map(|(number, _)| *number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_that_are_nearly_one_the_later_is_cancelled() {
        let rows = 40;
        let first: Vec<f64> = (0..rows).map(f64::from).collect();
        let wave: Vec<f64> = (0..rows).map(|k| (f64::from(k) * 0.9).sin()).collect();
        // The columns differ by a hundredth of the wave, so the wave needs a hundred times both.
        let nearly: Vec<f64> = first.iter().zip(&wave).map(|(a, b)| a + 0.01 * b).collect();
        let other: Vec<f64> = (0..rows).map(|k| f64::from(k % 2)).collect();
        let taken = |columns: &[&Vec<f64>]| {
            let mut series = Series::new(&[0; 40], &[1.0; 40], 0.0);
            series.set_values(&wave);
            let mut triangle = Triangle::new(&series);
            for (number, column) in columns.iter().enumerate() {
                triangle.take(&mut series, number, &[(*column).clone()]);
            }
            triangle.cancelled(&[])
        };
        assert_eq!(taken(&[&first, &nearly, &other]), Some(1));
        assert_eq!(taken(&[&first, &wave, &other]), None);
    }
}
