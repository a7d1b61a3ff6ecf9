//! Cross-validation of the terms on rows to which they were not fitted, block by block.
//!
//! The columns that are always in are fitted to all rows with and without the terms, so only the terms are compared. These columns could not predict a set-up
//! that is missing from the training rows.

use std::collections::HashMap;

use nalgebra::DMatrix;

use super::lagged::add_products;
use super::prepared::{PreparedRows, numbers};
use super::sweep::Swept;
use super::{Gain, Rows};

/// Minimum number of runs of a cluster that form folds by themselves.
const ENOUGH_RUNS: usize = 3;
/// Maximum number of folds.
const MOST_FOLDS: usize = 10;
/// Minimum number of pieces into which few runs are divided, if there are enough rows, and maximum number.
const PIECES: (usize, usize) = (5, 10);
/// Minimum length of a piece in rows, and in correlation lengths.
const LEAST_PIECE: f64 = 4.0;
const LEAST_TIMES: f64 = 2.0;

/// Folds and blocks of the rows in their original order; `None` if a row is never held out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Blocks {
    fold: Vec<Option<usize>>,
    block: Vec<usize>,
    folds: usize,
    blocks: usize,
}

impl Blocks {
    /// Forms blocks. Whole runs are held out if a cluster has three of them, otherwise contiguous pieces of runs that are longer than the correlation length.
    pub(super) fn new(rows: &Rows, correlation: &HashMap<usize, f64>) -> Blocks {
        let count = rows.values.len();
        let mut runs: HashMap<usize, Vec<usize>> = HashMap::new();
        let mut members: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
        for row in 0..count {
            let Some(cluster) = rows.cluster[row] else { continue };
            let own = runs.entry(cluster).or_default();
            if !own.contains(&rows.run[row]) {
                own.push(rows.run[row]);
            }
            members.entry((cluster, rows.run[row])).or_default().push(row);
        }
        let mut fold = vec![None; count];
        let mut label = vec![(0, 0, 0); count];
        for (&(cluster, run), own) in &members {
            let all = runs.get(&cluster).map_or(&[][..], Vec::as_slice);
            let number = all.iter().position(|known| *known == run).unwrap_or(0);
            if all.len() >= ENOUGH_RUNS {
                for &row in own {
                    fold[row] = Some(number % all.len().min(MOST_FOLDS));
                    label[row] = (cluster, run, 0);
                }
                continue;
            }
            let series = numbers(own.iter().map(|&row| rows.series[row])).1.max(1);
            let rho = own.iter().filter_map(|&row| correlation.get(&rows.noise[row])).copied().fold(0.0, f64::max);
            let length = LEAST_PIECE.max(LEAST_TIMES * (1.0 + rho) / (1.0 - rho));
            let pieces = ((own.len() / series) as f64 / length) as usize;
            let pieces = pieces.clamp(PIECES.0, PIECES.1).min(own.len());
            for (place, &row) in own.iter().enumerate() {
                let piece = place * pieces / own.len();
                fold[row] = Some((piece + number) % PIECES.0);
                label[row] = (cluster, run, piece);
            }
        }
        let folds = fold.iter().flatten().max().map_or(0, |most| most + 1);
        let (block, blocks) = numbers(label.into_iter().zip(&fold).map(|(label, fold)| (label, fold.is_some())));
        Blocks { fold, block, folds, blocks }
    }
}

/// Products of the training rows of each fold.
#[derive(Debug)]
pub(super) struct Folds<'a> {
    prepared: &'a PreparedRows,
    blocks: Blocks,
    training: Vec<DMatrix<f64>>,
    rows: Vec<usize>,
}

impl<'a> Folds<'a> {
    pub(super) fn new(prepared: &'a PreparedRows, blocks: Blocks, correlation: &[f64]) -> Folds<'a> {
        let width = prepared.width();
        let mut held = vec![DMatrix::zeros(width, width); blocks.folds];
        let mut total = DMatrix::zeros(width, width);
        let mut counts = vec![0; blocks.folds];
        // Fold of a row; `None` if it is never held out.
        let fold_of = |place: usize| blocks.fold.get(prepared.order[place]).copied().flatten();
        let dense = numbers(prepared.noise.iter().copied()).0;
        let mut pending: Vec<Vec<usize>> = vec![Vec::new(); blocks.folds + 1];
        for place in 0..prepared.count() {
            pending[fold_of(place).unwrap_or(blocks.folds)].push(place);
        }
        for (fold, own) in pending.iter().enumerate() {
            if let Some(count) = counts.get_mut(fold) {
                *count = own.len();
            }
            let mut here = DMatrix::zeros(width, width);
            for part in own.chunks(512) {
                let mut white = prepared.rows.select_columns(part);
                for (mut column, &place) in white.column_iter_mut().zip(part) {
                    let rho = dense.get(place).and_then(|&group| correlation.get(group)).copied().unwrap_or(0.0);
                    if rho > 0.0 && !prepared.begins[place] && fold_of(place - 1) == fold_of(place) {
                        column.axpy(-rho, &prepared.rows.column(place - 1), 1.0);
                        column.scale_mut(1.0 / (1.0 - rho * rho).sqrt());
                    }
                }
                add_products(&mut here, white.as_view(), white.as_view(), 1.0);
            }
            total += &here;
            if let Some(held) = held.get_mut(fold) {
                *held = here;
            }
        }
        let training = held.into_iter().map(|held| &total - held).collect();
        let rows = counts.into_iter().map(|count| prepared.count() - count).collect();
        Folds { prepared, blocks, training, rows }
    }

    /// Returns the products and the number of training rows of each fold.
    pub(super) fn training(&self) -> impl Iterator<Item = (&DMatrix<f64>, usize)> {
        self.training.iter().zip(self.rows.iter().copied())
    }

    /// Returns terms (indices among all columns) and their coefficients from the training of a fold.
    pub(super) fn coefficients(&self, fold: usize, terms: &[usize]) -> Vec<(usize, f64)> {
        let Some(training) = self.training.get(fold) else { return Vec::new() };
        let mut columns: Vec<usize> = (0..self.prepared.always).chain(terms.iter().copied()).collect();
        columns.push(self.prepared.width() - 1);
        let mut swept = Swept::new(training.select_columns(&columns).select_rows(&columns));
        for place in 0..columns.len() - 1 {
            swept.pivot(place);
        }
        let first = self.prepared.always;
        let inside = (first..columns.len() - 1).filter(|&place| swept.is_inside(place));
        inside.map(|place| (columns[place], swept.coefficient(place))).collect()
    }

    /// Returns the squared residuals of the held-out rows, by block, with the terms of each fold.
    pub(super) fn losses(&self, of_fold: &[Vec<(usize, f64)>]) -> Vec<f64> {
        let value = self.prepared.width() - 1;
        let mut sums = vec![0.0; self.blocks.blocks];
        for (place, column) in self.prepared.rows.column_iter().enumerate() {
            let row = self.prepared.order[place];
            let Some(fold) = self.blocks.fold[row] else { continue };
            let terms = of_fold.get(fold).map_or(&[][..], Vec::as_slice);
            let said: f64 = terms.iter().map(|&(term, coefficient)| column[term] * coefficient).sum();
            sums[self.blocks.block[row]] += (column[value] - said).powi(2);
        }
        sums
    }

    /// Returns the squared residuals of the held-out rows for identical terms in all folds.
    pub(super) fn losses_of(&self, terms: &[usize]) -> Vec<f64> {
        let all: Vec<Vec<(usize, f64)>> = (0..self.training.len()).map(|fold| self.coefficients(fold, terms)).collect();
        self.losses(&all)
    }

    /// Returns the number of rows that are held out once.
    fn held(&self) -> usize {
        self.blocks.fold.iter().flatten().count()
    }

    /// Returns the reduction of the residuals from the first case to the second.
    pub(super) fn gain(&self, before: &[f64], after: &[f64]) -> Gain {
        let differences: Vec<f64> = before.iter().zip(after).map(|(before, after)| before - after).collect();
        let count = differences.len().max(1) as f64;
        let sum: f64 = differences.iter().sum();
        let spread: f64 = differences.iter().map(|one| (one - sum / count).powi(2)).sum();
        let held = self.held().max(1) as f64;
        let rms = |squares: &[f64]| (squares.iter().sum::<f64>() / held).sqrt();
        let whole = before.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        Gain {
            before: rms(before),
            after: rms(after),
            share: sum / whole,
            uncertainty: if count > 1.0 { (count / (count - 1.0) * spread).sqrt() / whole } else { f64::INFINITY },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(runs: usize, length: usize) -> Rows {
        let count = runs * length;
        Rows {
            always: 0,
            factors: DMatrix::zeros(count, 0),
            values: vec![0.0; count],
            series: (0..count).map(|row| row / length).collect(),
            noise: vec![0; count],
            cluster: vec![Some(0); count],
            run: (0..count).map(|row| row / length).collect(),
            place: Vec::new(),
            side: Vec::new(),
            handicaps: Vec::new(),
        }
    }

    #[test]
    fn runs_are_held_out_as_a_whole_where_there_are_some() {
        let blocks = Blocks::new(&rows(4, 3), &HashMap::new());
        assert_eq!(blocks.fold, [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3].map(Some));
        assert_eq!((blocks.folds, blocks.blocks), (4, 4));
    }

    #[test]
    fn one_run_is_cut_where_the_noise_has_forgotten() {
        let blocks = Blocks::new(&rows(1, 100), &HashMap::new());
        assert_eq!((blocks.folds, blocks.blocks), (5, 10));
        // Neighbors are never in the same fold.
        assert_eq!([0, 10, 49, 50, 99].map(|row| blocks.fold[row]), [0, 1, 4, 0, 4].map(Some));
        // (1 + 0.8) / (1 − 0.8) = 9 rows, twice that: five pieces of 20.
        let blocks = Blocks::new(&rows(1, 100), &HashMap::from([(0, 0.8)]));
        assert_eq!((blocks.folds, blocks.blocks), (5, 5));
    }
}
