//! Gains of all candidates, without a new projection of their columns in every step.
//!
//! A column is a weight of the row times a factor of the reading. So its product with a direction is a sum over rows: factors are combined once for all
//! columns that act at the same point, and weights once for all points. The own part of a column decreases with every direction by the square of its share,
//! and so does the matrix of products of the columns of a candidate.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;

use super::cause::{Candidate, Weight};
use super::known::KnownTables;
use super::path::PathParts;
use super::scene::{NO_ROW, Scene, Through};
use ncfix_base::numeric::sums::{dot, dot_of_three};
use ncfix_base::numeric::{Gain, Series, in_parts};

/// A column with less than this share of its square remaining is dependent.
const DEPENDENT: f64 = 1e-11;

/// Shares of the pairs in a direction.
const HALVES: usize = 2;

/// Number of rows that are processed at once: the tables of weights exceed the processor cache.
const BLOCK: usize = 512;
/// Number of directions that are processed at once.
const AT_ONCE: usize = 4;

/// A column, as indices of pairs of a table of weights and a point where it acts.
type Column = Vec<usize>;

/// Candidates, decomposed into points and weights.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    places: Vec<Through>,
    weights: Vec<Arc<Vec<f64>>>,
    /// Index of each weight and point by its key.
    numbers: HashMap<usize, usize>,
    /// Pairs of weight and point: several candidates share columns.
    pub(super) pairs: Vec<(usize, usize)>,
    pub(super) columns: Vec<Vec<Column>>,
    /// Readings along paths.
    along: PathParts,
}

impl Layout {
    /// Decomposes candidates. Shared weights are computed once, cached ones not at all.
    pub(super) fn new(scene: &Scene<'_>, candidates: &[Candidate], known: &KnownTables) -> Layout {
        let mut places = Vec::new();
        let mut place_numbers: HashMap<Through, usize> = HashMap::new();
        let mut closures: Vec<&Weight> = Vec::new();
        let mut weight_numbers: HashMap<usize, usize> = HashMap::new();
        // Ordered by weight, then by point: a table is read once for all points.
        let mut pair_numbers: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let parts = candidates.iter().flat_map(|one| one.columns.iter().flatten());
        let of_parts: Vec<(usize, usize)> = parts
            .map(|(through, weight)| {
                let place = *place_numbers.entry(*through).or_insert_with(|| {
                    places.push(*through);
                    places.len() - 1
                });
                let weight = *weight_numbers.entry(weight.key()).or_insert_with(|| {
                    closures.push(weight);
                    closures.len() - 1
                });
                pair_numbers.insert((weight, place), 0);
                (weight, place)
            })
            .collect();
        pair_numbers.values_mut().enumerate().for_each(|(place, number)| *number = place);
        let mut of_parts = of_parts.iter().map(|pair| pair_numbers.get(pair).copied().unwrap_or(0));
        let mut of_column = |column: &Vec<(Through, Weight)>| of_parts.by_ref().take(column.len()).collect();
        let columns = candidates.iter().map(|one| one.columns.iter().map(&mut of_column).collect()).collect();
        let table = |weight: &&Weight| {
            let of_rows = || Arc::new(scene.rows.iter().map(|row| weight.of(row)).collect());
            known.get(weight).unwrap_or_else(of_rows)
        };
        let weights = in_parts(&closures, &table);
        let pairs: Vec<(usize, usize)> = pair_numbers.into_keys().collect();
        let along = scene.path_parts(&pairs, &places, &closures);
        Layout { places, weights, numbers: weight_numbers, pairs, columns, along }
    }

    /// Returns a weight by row, if it is one of those of its candidates, which have the same lifetime.
    pub(super) fn table(&self, weight: &Weight) -> Option<&Arc<Vec<f64>>> {
        self.weights.get(*self.numbers.get(&weight.key())?)
    }

    /// Returns these weights for some rows and their readings, in ascending order.
    pub(super) fn part(&self, rows: &[usize], items: &[usize]) -> Layout {
        let some = |table: &Arc<Vec<f64>>| {
            Arc::new(rows.iter().map(|&row| table.get(row).copied().unwrap_or(0.0)).collect::<Vec<f64>>())
        };
        let number = |item: usize| items.binary_search(&item).ok();
        let renumbered = |values: &Vec<(usize, f64)>| -> Vec<(usize, f64)> {
            values.iter().filter_map(|&(item, value)| Some((number(item)?, value))).collect()
        };
        let along = self.along.iter().map(|(&pair, values)| (pair, renumbered(values))).collect();
        Layout { weights: in_parts(&self.weights, &some), along, ..self.clone() }
    }

    /// The readings along paths on which a pair acts, with its values.
    fn along(&self, pair: (usize, usize)) -> &[(usize, f64)] {
        self.along.get(&pair).map_or(&[], Vec::as_slice)
    }

    /// Number of candidates.
    pub(super) fn count(&self) -> usize {
        self.columns.len()
    }
}

/// State of a candidate: products of its columns after projection (initially without projection), and their products with the residual.
#[derive(Clone, Debug, Default)]
pub(super) struct OwnProducts {
    products: Vec<f64>,
    squares: Vec<f64>,
    /// Columns of the basis of this state, if it differs from that of the whole state.
    pub(super) seen: Option<usize>,
}

impl OwnProducts {
    /// Subtracts the shares of its columns in a direction.
    pub(super) fn leave(&mut self, shares: &[f64]) {
        let count = shares.len();
        for (place, product) in self.products.iter_mut().enumerate() {
            *product -= shares[place / count] * shares[place % count];
        }
    }
}

/// State of all candidates after a basis, and the number of its columns.
#[derive(Clone, Debug, Default)]
pub(super) struct SearchState {
    pub(super) own: Vec<OwnProducts>,
    pub(super) seen: usize,
}

/// All candidates after a basis.
#[derive(Clone, Debug)]
pub(super) struct Scores {
    pub(super) layout: Arc<Layout>,
    factors: Vec<Arc<Vec<f64>>>,
    rows: Vec<usize>,
    row_count: usize,
    pub(super) state: SearchState,
}

impl Scores {
    /// Restores a previous state.
    pub(super) fn at(
        layout: &Arc<Layout>,
        scene: &Scene<'_>,
        factors: &HashMap<Through, Arc<Vec<f64>>>,
        state: SearchState,
    ) -> Scores {
        let nothing = Arc::new(vec![0.0; scene.items.len()]);
        let factors = layout.places.iter().map(|place| Arc::clone(factors.get(place).unwrap_or(&nothing))).collect();
        let rows = scene.items.iter().map(|item| item.row).collect();
        Scores { layout: Arc::clone(layout), factors, rows, row_count: scene.rows.len(), state }
    }

    /// Starts with an empty basis.
    pub(super) fn new(
        layout: &Arc<Layout>,
        scene: &Scene<'_>,
        factors: &HashMap<Through, Arc<Vec<f64>>>,
        series: &Series,
    ) -> Scores {
        let mut scores = Scores::at(layout, scene, factors, SearchState::default());
        // Without autocorrelation, products of columns at one point are sums over rows too.
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
        scores.state.own = in_parts(&layout.columns, &first);
        scores
    }

    /// Returns the current state.
    pub(super) fn state(self) -> SearchState {
        self.state
    }

    fn first(&self, columns: &[Column], series: &Series, squares: &[Vec<f64>]) -> OwnProducts {
        let count = columns.len();
        let mut products = vec![0.0; count * count];
        let pair = |column: &Column| column.first().and_then(|&number| self.layout.pairs.get(number)).copied();
        let place = columns.first().and_then(pair).map_or(0, |(_, place)| place);
        let is_simple =
            columns.iter().all(|column| column.len() == 1 && pair(column).is_some_and(|(_, own)| own == place));
        if let (true, Some(squares)) = (is_simple, squares.get(place)) {
            let table = |k: usize| pair(&columns[k]).and_then(|(weight, _)| self.layout.weights.get(weight));
            for k in 0..count {
                let Some(one) = table(k) else { continue };
                for l in 0..=k {
                    let Some(other) = table(l) else { continue };
                    let product =
                        dot_of_three(one, other, squares) + self.product_along([&columns[k], &columns[l]], series);
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
        OwnProducts { products, squares, seen: None }
    }

    fn column(&self, column: &Column) -> Vec<f64> {
        let mut out = vec![0.0; self.rows.len()];
        for (weight, place) in column.iter().filter_map(|&number| self.layout.pairs.get(number)) {
            let (Some(factors), Some(table)) = (self.factors.get(*place), self.layout.weights.get(*weight)) else {
                continue;
            };
            for ((value, factor), &row) in out.iter_mut().zip(factors.iter()).zip(&self.rows) {
                *value += factor * table.get(row).copied().unwrap_or(0.0);
            }
            for &(item, value) in self.layout.along((*weight, *place)) {
                out.get_mut(item).into_iter().for_each(|own| *own += value);
            }
        }
        out
    }

    /// The product of two columns of one pair each on the readings along paths.
    fn product_along(&self, columns: [&Column; 2], series: &Series) -> f64 {
        let [one, other] = columns.map(|column| {
            let pair = column.first().and_then(|&number| self.layout.pairs.get(number));
            pair.map_or(&[][..], |&pair| self.layout.along(pair))
        });
        let product = |&(item, value): &(usize, f64)| {
            let (_, beside) = other.iter().find(|(own, _)| *own == item)?;
            Some(value * beside * series.weights().get(item)?.powi(2))
        };
        one.iter().filter_map(product).sum()
    }

    /// Returns, for every point, the sums over the readings of each row of factor times value, with the rows where it is not zero.
    fn sums(&self, at: &[f64]) -> (Vec<Vec<f64>>, Range<usize>) {
        let (mut first, mut last) = (self.row_count, 0);
        let mut items = self.rows.len()..0;
        for (item, (&row, value)) in self.rows.iter().zip(at).enumerate() {
            if row != NO_ROW && *value != 0.0 {
                first = first.min(row);
                last = last.max(row + 1);
                items = items.start.min(item)..item + 1;
            }
        }
        let span = first.min(last)..last;
        // A cause of one set-up acts in a small part of the readings.
        let items = items.start.min(items.end)..items.end;
        let rows = self.rows.get(items.clone()).unwrap_or_default();
        let at = at.get(items.clone()).unwrap_or_default();
        let sum = |factors: &Arc<Vec<f64>>| {
            let mut sums = vec![0.0; span.len()];
            for ((&row, factor), value) in rows.iter().zip(factors.get(items.clone()).unwrap_or_default()).zip(at) {
                if *value != 0.0
                    && let Some(sum) = row.checked_sub(span.start).and_then(|place| sums.get_mut(place))
                {
                    *sum += factor * value;
                }
            }
            sums
        };
        (in_parts(&self.factors, &sum), span)
    }

    /// Returns the products of pairs with the values at the readings, for several vectors of values.
    pub(super) fn products(&self, all: &[Vec<f64>], pairs: &[(usize, usize)]) -> Vec<Vec<f64>> {
        let sums: Vec<(Vec<Vec<f64>>, Range<usize>)> = all.iter().map(|at| self.sums(at)).collect();
        let (first, last) = sums.iter().fold((self.row_count, 0), |(first, last), (_, span)| {
            if span.is_empty() { (first, last) } else { (first.min(span.start), last.max(span.end)) }
        });
        let of_some = |pairs: &[(usize, usize)]| -> Vec<Vec<f64>> {
            let mut out = vec![vec![0.0; pairs.len()]; all.len()];
            for start in (first..last).step_by(BLOCK) {
                let block = start..(start + BLOCK).min(last);
                for (k, (weight, place)) in pairs.iter().enumerate() {
                    let Some(table) = self.layout.weights.get(*weight) else { continue };
                    for (out, (sums, span)) in out.iter_mut().zip(&sums) {
                        let own = block.start.max(span.start)..block.end.min(span.end);
                        if own.is_empty() {
                            continue;
                        }
                        let of_sums = own.start - span.start..own.end - span.start;
                        let of_place = sums.get(*place).and_then(|sums| sums.get(of_sums));
                        if let (Some(table), Some(of_place)) = (table.get(own), of_place) {
                            out[k] += dot(table, of_place);
                        }
                    }
                }
            }
            out
        };
        // Parts contain whole stretches, so that a table is read once for all its points.
        let share = pairs.len().div_ceil(HALVES).max(1);
        let shares: Vec<_> = pairs.chunks(share).collect();
        let parts: Vec<Vec<Vec<f64>>> = in_parts(&shares, &|part| of_some(part));
        let whole = |(k, at): (usize, &Vec<f64>)| {
            let mut whole: Vec<f64> = parts.iter().filter_map(|part| part.get(k)).flatten().copied().collect();
            if !self.layout.along.is_empty() {
                for (sum, &pair) in whole.iter_mut().zip(pairs) {
                    let parts = self.layout.along(pair).iter();
                    *sum += parts.map(|&(item, value)| value * at.get(item).copied().unwrap_or(0.0)).sum::<f64>();
                }
            }
            whole
        };
        all.iter().enumerate().map(whole).collect()
    }

    /// Returns the gain of each candidate in addition to the basis of a series, which only grows between calls.
    pub(super) fn gains(&mut self, series: &Series) -> Vec<Gain> {
        let of = |products: &[f64], column: &Column| -> f64 { column.iter().filter_map(|&k| products.get(k)).sum() };
        let fresh = series.basis().get(self.state.seen..).unwrap_or_default();
        if self.layout.columns.is_empty() {
            self.state.seen = series.basis().len();
            return Vec::new();
        }
        let count = fresh.len() + 1;
        let at = |k: usize| match fresh.get(k) {
            Some(direction) => series.unwhitened(&direction.whole(self.rows.len())),
            None => series.unwhitened(series.left()),
        };
        let mut of_left = Vec::new();
        for first in (0..count).step_by(AT_ONCE) {
            let some: Vec<Vec<f64>> = (first..count.min(first + AT_ONCE)).map(at).collect();
            for (k, products) in self.products(&some, &self.layout.pairs).into_iter().enumerate() {
                if first + k == fresh.len() {
                    of_left = products;
                    break;
                }
                for (columns, own) in self.layout.columns.iter().zip(&mut self.state.own) {
                    own.leave(&columns.iter().map(|column| of(&products, column)).collect::<Vec<f64>>());
                }
            }
        }
        self.state.seen = series.basis().len();
        let candidates = self.layout.columns.iter().zip(&self.state.own);
        candidates
            .map(|(columns, own)| gain(own, columns.iter().map(|column| of(&of_left, column)).collect()))
            .collect()
    }
}

pub(super) fn gain(own: &OwnProducts, left: Vec<f64>) -> Gain {
    without_those_before(own.products.clone(), &own.squares, left)
}

/// Returns the gain of columns from their products with each other (row by row) and with the residual.
pub(super) fn gained(products: Vec<f64>, left: Vec<f64>) -> Gain {
    let squares: Vec<f64> = (0..left.len()).map(|k| products[k * left.len() + k]).collect();
    without_those_before(products, &squares, left)
}

/// Uses a Cholesky decomposition that skips dependent columns.
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
