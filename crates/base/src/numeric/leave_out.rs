//! Regressions without some of their columns, derived from one with all of them.
//!
//! In the basis of a regression with all columns, each column is represented by a few numbers, and so is the explained part. The contribution of some columns,
//! given any others, then needs sums over these numbers instead of sums over all rows.

use super::series::{CLEAR, DEPENDENT, Gain, Series};
use super::sums::dot;

/// Regression with groups of columns, any of which may be left out.
#[derive(Clone, Debug)]
pub struct LeaveOut {
    whole: Series,
    /// Number of columns of the basis that stay.
    before: usize,
    columns: Vec<Column>,
    /// Part that each further column of the basis explains.
    explained: Vec<f64>,
}

/// Column as components along the columns of the basis after those that stay.
#[derive(Clone, Debug)]
struct Column {
    group: usize,
    /// Length of the whole column.
    length: f64,
    shares: Vec<f64>,
}

/// Group, given some others.
#[derive(Clone, Debug)]
pub struct Beside {
    /// Improvement by the group.
    pub gain: Gain,
    /// Columns of the basis without it.
    pub rank: usize,
    /// Residual sum of squares without it.
    pub squares: f64,
    /// Independent part of each of its columns, by column of the basis; dependent columns are omitted.
    own: Vec<Vec<f64>>,
}

impl LeaveOut {
    /// Adds groups of columns to a series after its existing columns, which stay.
    #[must_use]
    pub fn new(mut whole: Series, groups: &[Vec<Vec<f64>>]) -> LeaveOut {
        let before = whole.rank();
        let (mut columns, mut explained) = (Vec::new(), Vec::new());
        for (group, own) in groups.iter().enumerate() {
            for column in own {
                let (by_this, mut shares) = whole.take_by_shares(column);
                explained.extend(by_this);
                let length = dot(&shares, &shares).sqrt();
                columns.push(Column { group, length, shares: shares.split_off(before) });
            }
        }
        columns.iter_mut().for_each(|column| column.shares.resize(explained.len(), 0.0));
        LeaveOut { whole, before, columns, explained }
    }

    /// Returns the regression with all groups.
    #[must_use]
    pub fn whole(&self) -> &Series {
        &self.whole
    }

    /// Returns the residuals with some groups only, whitened.
    #[must_use]
    pub fn left(&self, some: &[usize]) -> Vec<f64> {
        let basis = self.basis(some);
        let mut rest = self.explained.clone();
        take_out_all(&mut rest, &basis);
        let mut left = self.whole.left().to_vec();
        self.add(&rest, &mut left);
        left
    }

    /// Returns a group, given some others.
    #[must_use]
    pub fn beside(&self, group: usize, others: &[usize]) -> Beside {
        let basis = self.basis(others);
        let mut rest = self.explained.clone();
        take_out_all(&mut rest, &basis);
        let columns = || self.columns.iter().filter(|column| column.group == group);
        let mut with = basis.clone();
        let mut squares = 0.0;
        for column in columns() {
            if let Some((direction, _)) = direction(column, &with) {
                squares += dot(&direction, &rest).powi(2);
                with.push(direction);
            }
        }
        let own = columns().filter_map(|column| direction(column, &basis)).map(|(mut direction, length)| {
            direction.iter_mut().for_each(|share| *share *= length);
            direction
        });
        Beside {
            gain: Gain { squares, rank: with.len() - basis.len() },
            rank: self.before + basis.len(),
            squares: self.whole.squares() + dot(&rest, &rest),
            own: own.collect(),
        }
    }

    /// Returns the independent part of each column of a group, by row, whitened.
    pub fn own<'b>(&'b self, beside: &'b Beside) -> impl Iterator<Item = Vec<f64>> + 'b {
        beside.own.iter().map(|shares| {
            let mut rows = vec![0.0; self.whole.left().len()];
            self.add(shares, &mut rows);
            rows
        })
    }

    fn add(&self, shares: &[f64], to: &mut [f64]) {
        let behind = self.whole.basis().get(self.before..).unwrap_or_default();
        behind.iter().zip(shares).filter(|(_, share)| **share != 0.0).for_each(|(own, share)| own.add(*share, to));
    }

    /// Returns an orthonormal basis of some groups.
    fn basis(&self, some: &[usize]) -> Vec<Vec<f64>> {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for column in self.columns.iter().filter(|column| some.contains(&column.group)) {
            basis.extend(direction(column, &basis).map(|(direction, _)| direction));
        }
        basis
    }
}

/// Returns the part of a column perpendicular to a basis, normalized to unit length, and its length.
fn direction(column: &Column, basis: &[Vec<f64>]) -> Option<(Vec<f64>, f64)> {
    let mut direction = column.shares.clone();
    let mut own = 0.0;
    // Twice if little remains, to remove the rounding errors of the first pass.
    for _ in 0..2 {
        take_out_all(&mut direction, basis);
        own = dot(&direction, &direction).sqrt();
        if own > CLEAR * column.length {
            break;
        }
    }
    if !(own > 0.0 && own >= DEPENDENT * column.length) {
        return None;
    }
    direction.iter_mut().for_each(|share| *share /= own);
    Some((direction, own))
}

fn take_out_all(from: &mut [f64], basis: &[Vec<f64>]) {
    for other in basis {
        let amount = dot(from, other);
        from.iter_mut().zip(other).for_each(|(value, part)| *value -= amount * part);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(rows: usize, turns: f64) -> Vec<f64> {
        (0..rows).map(|row| (row as f64 * turns).sin()).collect()
    }

    #[test]
    fn what_is_left_out_was_never_there() {
        let rows = 90;
        let number: Vec<usize> = (0..rows).map(|row| row / 30).collect();
        let weights: Vec<f64> = (0..rows).map(|row| if row % 17 == 3 { 0.0 } else { 1.0 + (row % 5) as f64 }).collect();
        let values: Vec<f64> = (0..rows).map(|row| ((row * 7919) % 101) as f64 / 50.0 - 1.0).collect();
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<f64>>();
        let [one, two, three] = [wave(rows, 0.31), wave(rows, 0.83), wave(rows, 1.7)];
        // The third group has one independent column and one that is the sum of the first two; the fourth is a copy of the second.
        let groups = vec![
            vec![one.clone()],
            vec![two.clone()],
            vec![three.clone(), sum(&one, &two)],
            vec![two.clone()],
            vec![(0..rows).map(|row| f64::from(u8::from((30..60).contains(&row)))).collect(), wave(rows, 0.05)],
        ];
        let start = |others: &[usize]| {
            let mut series = Series::new(&number, &weights, 0.4);
            series.take(&vec![1.0; rows]);
            others.iter().flat_map(|&other| &groups[other]).for_each(|column| {
                series.take(column);
            });
            series.set_values(&values);
            series
        };
        let all = LeaveOut::new(start(&[]), &groups);
        for (group, others) in [
            (0, vec![1, 2, 3, 4]),
            (2, vec![0, 1, 3, 4]),
            (2, vec![0, 4]),
            (1, vec![0, 4]),
            (1, vec![0, 3]),
            (3, vec![]),
            (4, vec![0, 1, 2]),
        ] {
            let plain = start(&others);
            let gain = plain.gain(&groups[group]);
            let beside = all.beside(group, &others);
            assert_eq!((beside.gain.rank, beside.rank), (gain.rank, plain.rank()), "{group} beside {others:?}");
            assert!((beside.gain.squares - gain.squares).abs() < 1e-9 * plain.squares(), "{group} beside {others:?}");
            assert!((beside.squares - plain.squares()).abs() < 1e-9 * plain.squares());
            let left = all.left(&others);
            assert!(left.iter().zip(plain.left()).all(|(a, b)| (a - b).abs() < 1e-9));
            // Dependent columns are missing among the independent parts.
            let mut own = all.own(&beside);
            for column in &groups[group] {
                let mut plain = plain.clone();
                plain.set_values(column);
                if plain.squares() > 1e-9 {
                    let own = own.next().unwrap();
                    assert!(own.iter().zip(plain.left()).all(|(a, b)| (a - b).abs() < 1e-9), "{group}");
                }
            }
            assert!(own.next().is_none());
        }
    }
}
