//! Prepared rows for the selection: candidates and value after projection of the columns that are always in; neighbors are adjacent.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};

use super::lagged::NoiseGroup;
use super::{REPEATED, Rows};

/// A column is dependent on those before it if less than this share of it remains; as [`crate::numeric::RANK_LIMIT`].
const LEAST_LEFT: f64 = crate::numeric::RANK_LIMIT;

/// Data rows, one per column: columns that are always in, identifiable candidates, value.
#[derive(Clone, Debug)]
pub(super) struct PreparedRows {
    pub(super) rows: DMatrix<f64>,
    /// Number of columns that are always in.
    pub(super) always: usize,
    /// Identifiable candidates, by their numbers among all candidates.
    pub(super) told: Vec<usize>,
    /// Candidates that are not identifiable.
    pub(super) not_identified: Vec<usize>,
    /// Length of each identifiable candidate before normalization.
    pub(super) lengths: Vec<f64>,
    pub(super) groups: Vec<NoiseGroup>,
    /// True for rows that begin a series.
    pub(super) begins: Vec<bool>,
    /// Noise group of each row.
    pub(super) noise: Vec<usize>,
    /// Original index of each row.
    pub(super) order: Vec<usize>,
    /// Differences of each row from the mean of its repeats, in a matrix of one row; zero without repeats.
    pub(super) repeats: DMatrix<f64>,
    /// For each noise group, the mean number of repeats of a row; `None` if too few rows are repeated.
    pub(super) repeated: Vec<Option<f64>>,
    /// Place of each row; `None` for a row that nothing repeats.
    pub(super) place: Vec<Option<usize>>,
}

impl PreparedRows {
    /// Prepares the rows; `None` if numbers are not finite or counts disagree.
    pub(super) fn new(rows: &Rows) -> Option<PreparedRows> {
        let (count, width) = rows.factors.shape();
        let agree = [
            rows.values.len(),
            rows.series.len(),
            rows.noise.len(),
            rows.cluster.len(),
            rows.run.len(),
            rows.place.len(),
            rows.side.len(),
        ];
        let candidates = width.checked_sub(rows.always)?;
        if agree.iter().any(|&length| length != count) || rows.handicaps.len() != candidates {
            return None;
        }
        if !rows.factors.iter().chain(rows.values.iter()).all(|value| value.is_finite()) {
            return None;
        }
        let order = order(rows);
        let sorted = rows.factors.select_rows(&order);
        let base = directions(&sorted, rows.always);
        let mut others = DMatrix::zeros(count, candidates + 1);
        others.columns_mut(0, candidates).copy_from(&sorted.columns(rows.always, candidates));
        others.set_column(candidates, &DVector::from_iterator(count, order.iter().map(|&row| rows.values[row])));
        drop(sorted);
        let before: Vec<f64> = others.column_iter().map(|column| column.norm()).collect();
        if base.ncols() > 0 {
            let across = base.transpose();
            for _ in 0..2 {
                let along = &across * &others;
                others.gemm(-1.0, &base, &along, 1.0);
            }
        }
        let (mut told, mut not_identified, mut lengths) = (Vec::new(), Vec::new(), Vec::new());
        for (candidate, &before) in before.iter().enumerate().take(candidates) {
            let left = others.column(candidate).norm();
            if left > LEAST_LEFT * before && left > f64::MIN_POSITIVE {
                others.column_mut(candidate).scale_mut(1.0 / left);
                told.push(candidate);
                lengths.push(left);
            } else {
                not_identified.push(candidate);
            }
        }
        let kept: Vec<usize> = told.iter().copied().chain([candidates]).collect();
        let mut all = DMatrix::zeros(base.ncols() + kept.len(), count);
        all.rows_mut(0, base.ncols()).copy_from(&base.transpose());
        for (place, &column) in kept.iter().enumerate() {
            all.row_mut(base.ncols() + place).copy_from(&others.column(column).transpose());
        }
        let (groups, begins) = grouped(rows, &order);
        let noise = order.iter().map(|&row| rows.noise[row]).collect();
        let (repeats, repeated) = repeats(rows, &order, &groups);
        let place = order.iter().map(|&row| rows.place[row]).collect();
        Some(PreparedRows {
            rows: all,
            always: base.ncols(),
            told,
            not_identified,
            lengths,
            groups,
            begins,
            noise,
            order,
            repeats,
            repeated,
            place,
        })
    }

    pub(super) fn width(&self) -> usize {
        self.rows.nrows()
    }

    pub(super) fn count(&self) -> usize {
        self.rows.ncols()
    }
}

/// Orders the rows by noise group, then by series, then by their original order.
fn order(rows: &Rows) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rows.series.len()).collect();
    order.sort_by_key(|&row| (rows.noise[row], rows.series[row], row));
    order
}

/// Returns orthogonal directions of the first columns, without those that depend on others.
fn directions(factors: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
    let mut found: DMatrix<f64> = DMatrix::zeros(factors.nrows(), count);
    let mut filled = 0;
    for column in factors.column_iter().take(count) {
        let before = column.norm();
        let mut own = column.into_owned();
        if filled > 0 {
            let known = found.columns(0, filled);
            for _ in 0..2 {
                let along = known.tr_mul(&own);
                own.gemv(-1.0, &known, &along, 1.0);
            }
        }
        let left = own.norm();
        if left > LEAST_LEFT * before && left > f64::MIN_POSITIVE {
            found.set_column(filled, &(own / left));
            filled += 1;
        }
    }
    found.columns(0, filled).into_owned()
}

/// Returns the noise groups and the rows that begin a series.
fn grouped(rows: &Rows, order: &[usize]) -> (Vec<NoiseGroup>, Vec<bool>) {
    let mut groups: Vec<NoiseGroup> = Vec::new();
    let mut begins = Vec::with_capacity(order.len());
    let mut last = None;
    for (place, &row) in order.iter().enumerate() {
        let own = (rows.noise[row], rows.series[row]);
        let is_new_group = last.is_none_or(|(noise, _)| noise != own.0);
        let is_new = last != Some(own);
        begins.push(is_new);
        if is_new_group {
            groups.push(NoiseGroup { from: place, until: place, begins: Vec::new() });
        }
        if let Some(group) = groups.last_mut() {
            group.until = place + 1;
            if is_new {
                group.begins.push(place);
            }
        }
        last = Some(own);
    }
    (groups, begins)
}

/// Returns the differences of rows from the mean of their repeats, and for each noise group the mean number of repeats, if enough rows have some.
fn repeats(rows: &Rows, order: &[usize], groups: &[NoiseGroup]) -> (DMatrix<f64>, Vec<Option<f64>>) {
    let mut places: HashMap<(usize, usize), (f64, usize)> = HashMap::new();
    let key = |row: usize| Some((rows.noise[row], rows.place[row]?));
    for row in 0..rows.values.len() {
        if let Some(key) = key(row) {
            let sum = places.entry(key).or_insert((0.0, 0));
            *sum = (sum.0 + rows.values[row], sum.1 + 1);
        }
    }
    let of = |row: usize| key(row).and_then(|key| places.get(&key)).copied().filter(|(_, count)| *count > 1);
    let difference = |&row: &usize| of(row).map_or(0.0, |(sum, count)| rows.values[row] - sum / count as f64);
    // A constant of one side, such as backlash, is no noise.
    let mut sides: HashMap<(usize, usize), (f64, usize)> = HashMap::new();
    for row in order.iter().filter(|&&row| of(row).is_some()) {
        let sum = sides.entry((rows.noise[*row], rows.side[*row])).or_insert((0.0, 0));
        *sum = (sum.0 + difference(row), sum.1 + 1);
    }
    let mean = |row: &usize| {
        let side = sides.get(&(rows.noise[*row], rows.side[*row])).filter(|_| of(*row).is_some());
        side.map_or(0.0, |&(sum, count)| sum / count as f64)
    };
    let differences = DMatrix::from_iterator(1, order.len(), order.iter().map(|row| difference(row) - mean(row)));
    let repeated = groups.iter().map(|group| {
        let own = order.get(group.from..group.until).unwrap_or_default();
        let counts: Vec<f64> = own.iter().filter_map(|&row| of(row)).map(|(_, count)| count as f64).collect();
        let is_enough = !counts.is_empty() && counts.len() as f64 >= REPEATED * own.len() as f64;
        is_enough.then(|| counts.iter().sum::<f64>() / counts.len() as f64)
    });
    (differences, repeated.collect())
}

/// Returns consecutive numbers for labels, in order of occurrence.
pub(super) fn numbers<T: std::hash::Hash + Eq>(labels: impl Iterator<Item = T>) -> (Vec<usize>, usize) {
    let mut known = HashMap::new();
    let found = labels
        .map(|label| {
            let next = known.len();
            *known.entry(label).or_insert(next)
        })
        .collect();
    (found, known.len())
}
