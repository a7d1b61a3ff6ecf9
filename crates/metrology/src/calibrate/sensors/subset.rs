//! The best subset of each size, by exact search.
//!
//! The task is to find the columns, of a given number, with the smallest residual sum of squares. The tree of all subsets is visited in a fixed
//! order. A taken column is swept out of the rest (Schur complement), and the last two of a subset are evaluated as pairs without another step. The
//! joint residual of all columns from one on is a bound for every subset of them (leaps and bounds: Furnival and Wilson, Technometrics 16, 1974): if
//! it is no better than the best subset so far, the rest is skipped. The most important columns come first, so that the bounds rise fast, and a
//! stepwise search with swaps gives the initial best.

use nalgebra::{DMatrix, DVector};

/// Squared residual of a unit column below which it depends on others.
const INDEPENDENT: f64 = 1e-9;
/// Minimum number of columns for bounds: computing them costs as much as evaluating all triples.
const LEAST_FOR_BOUNDS: usize = 4;

/// Products of unit columns with each other and with the values.
#[derive(Clone, Debug)]
pub struct Products {
    /// Columns times columns.
    pub columns: DMatrix<f64>,
    /// Columns times values.
    pub values: DVector<f64>,
    /// Values times values.
    pub total: f64,
}

/// A subset.
#[derive(Clone, Debug, PartialEq)]
pub struct Subset {
    /// Indices of its columns, ascending.
    pub members: Vec<usize>,
    /// Its residual sum of squares.
    pub squares: f64,
    /// `true` if no other subset of this size has a smaller residual; `false` if the search was cut short.
    pub is_exact: bool,
}

impl Products {
    /// The products of some columns only.
    #[must_use]
    pub fn of(&self, members: &[usize]) -> Products {
        let columns = DMatrix::from_fn(members.len(), members.len(), |i, j| self.columns[(members[i], members[j])]);
        let values = DVector::from_fn(members.len(), |i, _| self.values[members[i]]);
        Products { columns, values, total: self.total }
    }

    /// Residual sum of squares of some columns; dependent ones have no effect.
    #[must_use]
    pub fn squares(&self, members: &[usize]) -> f64 {
        let mut rest = Rest::of(self, members);
        let mut squares = self.total;
        while rest.width > 0 {
            squares -= rest.gain(0);
            rest = rest.without(0);
        }
        squares.max(0.0)
    }

    /// The number of independent columns.
    #[must_use]
    pub fn rank(&self) -> usize {
        let mut rest = Rest::of(self, &(0..self.values.len()).collect::<Vec<_>>());
        let mut rank = 0;
        while rest.width > 0 {
            rank += usize::from(rest.at(0, 0) > INDEPENDENT);
            rest = rest.without(0);
        }
        rank
    }

    /// The best subset of each size up to `most`, within the limit `work` (multiplications); impossible sizes are left out.
    #[must_use]
    pub fn best(&self, most: usize, work: u64) -> Vec<Subset> {
        let order = self.order();
        let (mut first, mut left) = (Vec::new(), work);
        let mut out = Vec::new();
        for size in 1..=most.min(self.rank()) {
            first = self.stepped(first);
            out.extend(self.search(&order, &first, size, &mut left));
        }
        out
    }

    /// The best subset of one size; `None` if the columns do not allow it.
    #[must_use]
    pub fn best_of(&self, size: usize, work: u64) -> Option<Subset> {
        if size == 0 || size > self.rank() {
            return None;
        }
        let first = (0..size).fold(Vec::new(), |first, _| self.stepped(first));
        self.search(&self.order(), &first, size, &mut work.clone())
    }

    fn search(&self, order: &[usize], first: &[usize], size: usize, left: &mut u64) -> Option<Subset> {
        if first.len() != size {
            return None;
        }
        let mut search =
            Search { best: self.squares(first), members: first.to_vec(), taken: Vec::new(), order, left: *left };
        search.walk(&Rest::of(self, order), self.total, size);
        *left = search.left;
        let mut members = search.members;
        members.sort_unstable();
        Some(Subset { squares: self.squares(&members), members, is_exact: *left > 0 })
    }

    /// Adds the best further column, and then swaps as long as it helps.
    fn stepped(&self, mut members: Vec<usize>) -> Vec<usize> {
        let count = self.values.len();
        let best_for = |members: &mut Vec<usize>, place: usize| {
            let mut best = (self.squares(members), members.get(place).copied());
            for column in (0..count).filter(|column| !members.contains(column)).collect::<Vec<_>>() {
                if let Some(member) = members.get_mut(place) {
                    *member = column;
                }
                let squares = self.squares(members);
                if squares < best.0 * (1.0 - 1e-12) {
                    best = (squares, Some(column));
                }
            }
            if let (Some(member), Some(column)) = (members.get_mut(place), best.1) {
                *member = column;
            }
        };
        let Some(free) = (0..count).find(|column| !members.contains(column)) else { return members };
        members.push(free);
        let last = members.len() - 1;
        best_for(&mut members, last);
        // Each swap reduces the residual; few iterations are nearly optimal, and the search completes the rest.
        for _ in 0..10 {
            let before = members.clone();
            for place in 0..members.len() {
                best_for(&mut members, place);
            }
            if members == before {
                break;
            }
        }
        members
    }

    /// Columns in search order: the reverse of stepwise elimination by least loss.
    fn order(&self) -> Vec<usize> {
        let mut kept: Vec<usize> = (0..self.values.len()).collect();
        let mut order = Vec::new();
        while !kept.is_empty() {
            let inverse = self.of(&kept).columns.cholesky().map(|factor| factor.inverse());
            let losses: Vec<f64> = match inverse {
                Some(inverse) => {
                    let solution = &inverse * self.of(&kept).values;
                    (0..kept.len()).map(|i| solution[i].powi(2) / inverse[(i, i)]).collect()
                }
                // Dependent columns lose nothing.
                None => kept.iter().map(|&column| self.values[column].powi(2)).collect(),
            };
            let least = losses.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(place, _)| place);
            order.push(kept.remove(least));
        }
        order.reverse();
        order
    }
}

/// The remainder of columns and values after eliminating the taken columns, in search order.
#[derive(Clone, Debug)]
struct Rest {
    width: usize,
    /// Row by row.
    columns: Vec<f64>,
    values: Vec<f64>,
}

impl Rest {
    fn of(products: &Products, members: &[usize]) -> Rest {
        let part = products.of(members);
        Rest {
            width: members.len(),
            columns: part.columns.as_slice().to_vec(),
            values: part.values.as_slice().to_vec(),
        }
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.columns[i * self.width + j]
    }

    /// Reduction of the sum of squares by a column.
    fn gain(&self, i: usize) -> f64 {
        let own = self.at(i, i);
        if own > INDEPENDENT { self.values[i] * self.values[i] / own } else { 0.0 }
    }

    /// The columns after a taken one.
    fn without(&self, i: usize) -> Rest {
        let width = self.width - i - 1;
        let own = self.at(i, i);
        let row = &self.columns[i * self.width..(i + 1) * self.width];
        let mut columns = Vec::with_capacity(width * width);
        let mut values = Vec::with_capacity(width);
        for j in i + 1..self.width {
            let factor = if own > INDEPENDENT { row[j] / own } else { 0.0 };
            let old = &self.columns[j * self.width + i + 1..(j + 1) * self.width];
            columns.extend(old.iter().zip(&row[i + 1..]).map(|(old, taken)| old - factor * taken));
            values.push(self.values[j] - factor * self.values[i]);
        }
        Rest { width, columns, values }
    }

    /// Joint reduction by all columns from each one on.
    fn gains_from(&self) -> Vec<f64> {
        let width = self.width;
        let (mut columns, mut values) = (self.columns.clone(), self.values.clone());
        let mut gains = vec![0.0; width + 1];
        for i in (0..width).rev() {
            let own = columns[i * width + i];
            gains[i] = gains[i + 1];
            if own <= INDEPENDENT {
                continue;
            }
            gains[i] += values[i] * values[i] / own;
            let row: Vec<f64> = columns[i * width..i * width + i].to_vec();
            for j in 0..i {
                let factor = row[j] / own;
                values[j] -= factor * values[i];
                columns[j * width..=j * width + j].iter_mut().zip(&row).for_each(|(old, taken)| *old -= factor * taken);
            }
        }
        gains
    }
}

/// A search for one size.
struct Search<'a> {
    best: f64,
    members: Vec<usize>,
    taken: Vec<usize>,
    order: &'a [usize],
    left: u64,
}

impl Search<'_> {
    /// Visits all subsets of `need` columns of the rest, in addition to the taken ones, whose residual is `squares`.
    fn walk(&mut self, rest: &Rest, squares: f64, need: usize) {
        let width = rest.width;
        if width < need || self.left == 0 {
            return;
        }
        let offset = self.order.len() - width;
        if need == 1 {
            for i in 0..width {
                self.note(squares - rest.gain(i), &[offset + i]);
            }
            return;
        }
        if need == 2 {
            self.spend(width * width / 2);
            return self.pairs(rest, squares, offset);
        }
        let gains = (need >= LEAST_FOR_BOUNDS).then(|| {
            self.spend(width * width * width / 6);
            rest.gains_from()
        });
        for i in 0..=width - need {
            if gains.as_ref().is_some_and(|gains| squares - gains[i] >= self.best * (1.0 - 1e-10)) {
                return;
            }
            self.spend((width - i) * (width - i));
            self.taken.push(offset + i);
            self.walk(&rest.without(i), squares - rest.gain(i), need - 1);
            self.taken.pop();
        }
    }

    fn pairs(&mut self, rest: &Rest, squares: f64, offset: usize) {
        let width = rest.width;
        for i in 0..width {
            let own = rest.at(i, i);
            if own <= INDEPENDENT {
                continue;
            }
            let (inverse, value) = (1.0 / own, rest.values[i]);
            let after = squares - value * value * inverse;
            let row = &rest.columns[i * width..(i + 1) * width];
            for (j, &shared) in row.iter().enumerate().skip(i + 1) {
                let factor = shared * inverse;
                let other = rest.columns[j * width + j] - factor * shared;
                let left = rest.values[j] - factor * value;
                // Equivalent to after − left²/other < best, without a division.
                if other > INDEPENDENT && (after - self.best) * other < left * left {
                    self.note(after - left * left / other, &[offset + i, offset + j]);
                }
            }
        }
    }

    fn note(&mut self, squares: f64, last: &[usize]) {
        if squares < self.best * (1.0 - 1e-10) {
            self.best = squares;
            self.members = self.taken.iter().chain(last).filter_map(|&place| self.order.get(place).copied()).collect();
        }
    }

    fn spend(&mut self, work: usize) {
        self.left = self.left.saturating_sub(work as u64);
    }
}
