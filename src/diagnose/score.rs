//! What every candidate would gain, without projecting its columns anew in every step.
//!
//! A column is a weight of the row times a factor of the reading. Products of columns with a direction are therefore sums over rows: the factors
//! are put together once for all columns that come in at the same place, and the weights once for all places. What a column has of its own
//! falls with every direction that is taken by the square of its share in it, and so does the matrix of products of a candidate's columns.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use super::cause::{Candidate, Weight};
use super::scene::{NO_ROW, Scene, Through};
use crate::numeric::sums::{dot, dot_of_three};
use crate::numeric::{Gain, Series};

/// A column of which less than this share of its square is left says nothing of its own.
const DEPENDENT: f64 = 1e-11;
/// Shares of the work.
const WORKERS: usize = 2;

/// A column: pairs of a place where it comes in and a table of weights.
type Column = Vec<(usize, usize)>;

/// Candidates taken apart into places and weights.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    places: Vec<Through>,
    weights: Vec<Vec<f64>>,
    columns: Vec<Vec<Column>>,
}

impl Layout {
    /// Takes candidates apart; weights that are shared are computed once.
    pub(super) fn new(scene: &Scene<'_>, candidates: &[Candidate]) -> Layout {
        let mut places = Vec::new();
        let mut place_numbers: HashMap<Through, usize> = HashMap::new();
        let mut closures: Vec<&Weight> = Vec::new();
        let mut weight_numbers: HashMap<usize, usize> = HashMap::new();
        let mut columns = Vec::new();
        for candidate in candidates {
            let mut column = |parts: &'_ Vec<(Through, Weight)>| -> Column {
                let mut part = |through: &Through, weight: &Weight| {
                    let place = *place_numbers.entry(*through).or_insert_with(|| {
                        places.push(*through);
                        places.len() - 1
                    });
                    (place, weight.key())
                };
                parts.iter().map(|(through, weight)| part(through, weight)).collect()
            };
            let mut own: Vec<Column> = candidate.columns.iter().map(&mut column).collect();
            let all = candidate.columns.iter().flatten().map(|(_, weight)| weight);
            for ((_, key), weight) in own.iter_mut().flatten().zip(all) {
                *key = *weight_numbers.entry(*key).or_insert_with(|| {
                    closures.push(weight);
                    closures.len() - 1
                });
            }
            columns.push(own);
        }
        let tables = |part: &[&Weight]| -> Vec<Vec<f64>> {
            part.iter().map(|weight| scene.rows.iter().map(|row| weight.of(row)).collect()).collect()
        };
        let share = closures.len().div_ceil(WORKERS).max(1);
        let weights = std::thread::scope(|scope| {
            let workers: Vec<_> = closures.chunks(share).map(|part| scope.spawn(move || tables(part))).collect();
            workers.into_iter().flat_map(|worker| worker.join().unwrap_or_default()).collect()
        });
        Layout { places, weights, columns }
    }

    /// How many candidates it has.
    pub(super) fn count(&self) -> usize {
        self.columns.len()
    }
}

/// Of a candidate: products of its columns with each other as far as they are their own, the same at first, and with what is left.
#[derive(Clone, Debug, Default)]
struct Own {
    products: Vec<f64>,
    squares: Vec<f64>,
}

/// The state of all candidates beside a basis.
#[derive(Debug)]
pub(super) struct Scores<'l> {
    layout: &'l Layout,
    factors: Vec<Arc<Vec<f64>>>,
    rows: Vec<usize>,
    row_count: usize,
    own: Vec<Own>,
    seen: usize,
}

impl<'l> Scores<'l> {
    /// Nothing is taken yet.
    pub(super) fn new(
        layout: &'l Layout,
        scene: &Scene<'_>,
        factors: &HashMap<Through, Arc<Vec<f64>>>,
        series: &Series,
    ) -> Scores<'l> {
        let nothing = Arc::new(vec![0.0; scene.items.len()]);
        let factors = layout.places.iter().map(|place| Arc::clone(factors.get(place).unwrap_or(&nothing))).collect();
        let rows = scene.items.iter().map(|item| item.row).collect();
        let mut scores = Scores { layout, factors, rows, row_count: scene.rows.len(), own: Vec::new(), seen: 0 };
        // Without memory the products of columns at one place are sums over rows as well.
        let squares: Vec<Vec<f64>> = if series.memory() == 0.0 {
            let counted = |factors: &Arc<Vec<f64>>| {
                let mut sums = vec![0.0; scores.row_count];
                for ((&row, factor), weight) in scores.rows.iter().zip(factors.iter()).zip(series.weights()) {
                    if row != NO_ROW && *weight > 0.0 {
                        sums[row] += (factor * weight).powi(2);
                    }
                }
                sums
            };
            scores.factors.iter().map(counted).collect()
        } else {
            Vec::new()
        };
        let first = |columns: &Vec<Column>| scores.first(columns, series, &squares);
        scores.own = in_parts(&layout.columns, &first);
        scores
    }

    fn first(&self, columns: &[Column], series: &Series, squares: &[Vec<f64>]) -> Own {
        let count = columns.len();
        let mut products = vec![0.0; count * count];
        let place = columns.first().and_then(|column| column.first()).map_or(0, |(place, _)| *place);
        let is_simple = columns.iter().all(|column| matches!(column.as_slice(), [(own, _)] if *own == place));
        if let (true, Some(squares)) = (is_simple, squares.get(place)) {
            let table = |k: usize| columns[k].first().and_then(|(_, weight)| self.layout.weights.get(*weight));
            for k in 0..count {
                let Some(one) = table(k) else { continue };
                for l in 0..=k {
                    let Some(other) = table(l) else { continue };
                    let product = dot_of_three(one, other, squares);
                    products[k * count + l] = product;
                    products[l * count + k] = product;
                }
            }
        } else {
            let whole: Vec<Vec<f64>> = columns.iter().map(|column| series.whitened(&self.column(column))).collect();
            for k in 0..count {
                for l in 0..=k {
                    let product = dot(&whole[k], &whole[l]);
                    products[k * count + l] = product;
                    products[l * count + k] = product;
                }
            }
        }
        let squares = (0..count).map(|k| products[k * count + k]).collect();
        Own { products, squares }
    }

    fn column(&self, column: &Column) -> Vec<f64> {
        let mut out = vec![0.0; self.rows.len()];
        for (place, weight) in column {
            let (Some(factors), Some(table)) = (self.factors.get(*place), self.layout.weights.get(*weight)) else {
                continue;
            };
            for ((value, factor), &row) in out.iter_mut().zip(factors.iter()).zip(&self.rows) {
                *value += factor * table.get(row).copied().unwrap_or(0.0);
            }
        }
        out
    }

    /// Sums over the readings of each row of factor times what is at the reading, for every place; with the rows where there is any.
    fn sums(&self, at: &[f64]) -> (Vec<Vec<f64>>, Range<usize>) {
        let (mut first, mut last) = (self.row_count, 0);
        for (&row, value) in self.rows.iter().zip(at) {
            if row != NO_ROW && *value != 0.0 {
                first = first.min(row);
                last = last.max(row + 1);
            }
        }
        let span = first.min(last)..last;
        let sum = |factors: &Arc<Vec<f64>>| {
            let mut sums = vec![0.0; span.len()];
            for ((&row, factor), value) in self.rows.iter().zip(factors.iter()).zip(at) {
                if *value != 0.0
                    && let Some(sum) = row.checked_sub(span.start).and_then(|place| sums.get_mut(place))
                {
                    *sum += factor * value;
                }
            }
            sums
        };
        (self.factors.iter().map(sum).collect(), span)
    }

    fn product(&self, column: &Column, sums: &[Vec<f64>], span: &Range<usize>) -> f64 {
        let part = |(place, weight): &(usize, usize)| {
            let table = self.layout.weights.get(*weight).and_then(|table| table.get(span.clone()));
            table.zip(sums.get(*place)).map_or(0.0, |(table, sums)| dot(table, sums))
        };
        column.iter().map(part).sum()
    }

    /// What each candidate would gain beside the basis of a series, which only grows from one call to the next.
    pub(super) fn gains(&mut self, series: &Series) -> Vec<Gain> {
        for direction in series.basis().get(self.seen..).unwrap_or_default() {
            let (sums, span) = self.sums(&series.unwhitened(direction));
            let less = |(columns, own): (&Vec<Column>, &Own)| {
                let shares: Vec<f64> = columns.iter().map(|column| self.product(column, &sums, &span)).collect();
                let mut own = own.clone();
                let count = shares.len();
                for (place, product) in own.products.iter_mut().enumerate() {
                    *product -= shares[place / count] * shares[place % count];
                }
                own
            };
            let pairs: Vec<(&Vec<Column>, &Own)> = self.layout.columns.iter().zip(&self.own).collect();
            self.own = in_parts(&pairs, &|pair: &(&Vec<Column>, &Own)| less(*pair));
        }
        self.seen = series.basis().len();
        let (sums, span) = self.sums(&series.unwhitened(series.left()));
        let gain = |(columns, own): &(&Vec<Column>, &Own)| {
            let left = columns.iter().map(|column| self.product(column, &sums, &span)).collect();
            gain(own, left)
        };
        let pairs: Vec<(&Vec<Column>, &Own)> = self.layout.columns.iter().zip(&self.own).collect();
        in_parts(&pairs, &gain)
    }
}

fn gain(own: &Own, left: Vec<f64>) -> Gain {
    without_those_before(own.products.clone(), &own.squares, left)
}

/// What columns gain whose products with each other (row by row) and with what is left are these.
pub(super) fn gained(products: Vec<f64>, left: Vec<f64>) -> Gain {
    let squares: Vec<f64> = (0..left.len()).map(|k| products[k * left.len() + k]).collect();
    without_those_before(products, &squares, left)
}

/// By Cholesky's decomposition, leaving out columns that depend on those before them.
fn without_those_before(mut products: Vec<f64>, squares: &[f64], mut left: Vec<f64>) -> Gain {
    let count = left.len();
    let mut total = Gain { squares: 0.0, rank: 0 };
    for k in 0..count {
        let pivot = products[k * count + k];
        if !(pivot > DEPENDENT * squares[k] && squares[k] > 0.0) {
            continue;
        }
        total.squares += left[k] * left[k] / pivot;
        total.rank += 1;
        for l in k + 1..count {
            let factor = products[l * count + k] / pivot;
            left[l] -= factor * left[k];
            for m in k + 1..count {
                products[l * count + m] -= factor * products[k * count + m];
            }
        }
    }
    total
}

/// Works on all of them at once, in order.
pub(super) fn in_parts<T: Sync, R: Send>(all: &[T], work: &(dyn Fn(&T) -> R + Sync)) -> Vec<R> {
    let share = all.len().div_ceil(4 * WORKERS).max(1);
    let parts: Vec<&[T]> = all.chunks(share).collect();
    std::thread::scope(|scope| {
        // Parts are dealt out in turn: neighbours cost alike.
        let deal = |worker: usize| parts.iter().enumerate().skip(worker).step_by(WORKERS);
        let workers: Vec<_> = (0..WORKERS)
            .map(|worker| {
                let own: Vec<(usize, &[T])> = deal(worker).map(|(place, part)| (place, *part)).collect();
                scope.spawn(move || {
                    let one = |(place, part): (usize, &[T])| (place, part.iter().map(work).collect::<Vec<R>>());
                    own.into_iter().map(one).collect::<Vec<_>>()
                })
            })
            .collect();
        let mut done: Vec<(usize, Vec<R>)> =
            workers.into_iter().flat_map(|worker| worker.join().unwrap_or_default()).collect();
        done.sort_by_key(|(place, _)| *place);
        done.into_iter().flat_map(|(_, part)| part).collect()
    })
}
