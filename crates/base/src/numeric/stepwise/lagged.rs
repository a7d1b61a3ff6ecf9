//! Rows with autocorrelated noise: products of columns for any autocorrelation, and its estimate from the rows.
//!
//! The model is a first-order autoregression within each series. A row minus ρ times the one before it, divided by √(1 − ρ²), has independent noise; the
//! first row of a series stays. The products of such rows are a sum of three matrices with factors that depend only on ρ, so another ρ needs no new pass over
//! the rows. ρ maximizes the restricted likelihood (Patterson & Thompson 1971), which does not mistake the degrees of freedom used by the columns for a lack
//! of autocorrelation.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DMatrixView};

use crate::numeric::peak;

/// Number of columns (rows of the data) that are multiplied at once.
const BLOCK: usize = 512;
/// Maximum autocorrelation. Negative values are not assumed either: they would make slow effects look more significant than they are.
pub(super) const MOST: f64 = 0.99;
/// Maximum number of evaluations for one autocorrelation.
const TRIALS: usize = 24;
/// Iterations over the noise groups.
const ROUNDS: usize = 2;
/// Tolerance of the optimum, in the logarithm of 1 − ρ.
const CLOSE: f64 = 1e-5;

/// Range of the rows of one noise group, and the rows of it that begin a series; groups are stored one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct NoiseGroup {
    pub(super) from: usize,
    pub(super) until: usize,
    /// Rows that begin a series, including the first one of the group.
    pub(super) begins: Vec<usize>,
}

#[derive(Clone, Debug)]
struct Products {
    own: DMatrix<f64>,
    inner: DMatrix<f64>,
    lag: DMatrix<f64>,
    /// Number of rows that follow another in their series.
    follow: usize,
    /// Number of rows.
    rows: usize,
}

impl Products {
    /// Adds the products at an autocorrelation.
    fn add_to(&self, out: &mut DMatrix<f64>, rho: f64) {
        if self.follow == 0 {
            *out += &self.own;
            return;
        }
        let scale = 1.0 / (1.0 - rho * rho);
        for (((to, own), inner), lag) in out.iter_mut().zip(self.own.iter()).zip(self.inner.iter()).zip(self.lag.iter())
        {
            *to += (own + rho * (rho * inner - lag)) * scale;
        }
    }
}

/// Products of all columns, by noise group.
#[derive(Clone, Debug)]
pub(super) struct Lagged {
    groups: Vec<Products>,
    rows: usize,
}

/// Adds the products of columns of two matrices.
pub(super) fn add_products(to: &mut DMatrix<f64>, one: DMatrixView<'_, f64>, other: DMatrixView<'_, f64>, sign: f64) {
    let mut from = 0;
    while from < one.ncols() {
        let count = BLOCK.min(one.ncols() - from);
        to.gemm(sign, &one.columns(from, count), &other.columns(from, count).transpose(), 1.0);
        from += count;
    }
}

impl Lagged {
    /// Computes the products. `rows` has one row of the data in each column.
    pub(super) fn new(rows: &DMatrix<f64>, groups: &[NoiseGroup]) -> Lagged {
        let width = rows.nrows();
        let products = |group: &NoiseGroup| {
            let count = group.until - group.from;
            let mut own = DMatrix::zeros(width, width);
            let all = rows.columns(group.from, count);
            add_products(&mut own, all.as_view(), all.as_view(), 1.0);
            let follow = count - group.begins.len().min(count);
            let (mut inner, mut lag) = (DMatrix::zeros(0, 0), DMatrix::zeros(0, 0));
            if follow > 0 {
                let first = rows.select_columns(&group.begins);
                let ends = group.begins.iter().skip(1).chain([&group.until]);
                let last = rows.select_columns(&ends.map(|next| next - 1).collect::<Vec<usize>>());
                inner = own.clone();
                add_products(&mut inner, first.as_view(), first.as_view(), -1.0);
                add_products(&mut inner, last.as_view(), last.as_view(), -1.0);
                let mut half = DMatrix::zeros(width, width);
                let (before, behind) = (rows.columns(group.from, count - 1), rows.columns(group.from + 1, count - 1));
                add_products(&mut half, before.as_view(), behind.as_view(), 1.0);
                // Borders between one series and the next.
                let borders = group.begins.len() - 1;
                add_products(&mut half, last.columns(0, borders).as_view(), first.columns(1, borders).as_view(), -1.0);
                lag = half.transpose() + &half;
            }
            Products { own, inner, lag, follow, rows: count }
        };
        Lagged { groups: groups.iter().map(products).collect(), rows: rows.ncols() }
    }

    /// Returns the products at these autocorrelations.
    pub(super) fn gram(&self, correlation: &[f64]) -> DMatrix<f64> {
        let width = self.groups.first().map_or(0, |group| group.own.nrows());
        let mut out = DMatrix::zeros(width, width);
        self.groups.iter().zip(correlation).for_each(|(group, &rho)| group.add_to(&mut out, rho));
        out
    }

    /// Returns the products of one group at an autocorrelation, and the number of its rows.
    pub(super) fn gram_of(&self, number: usize, rho: f64) -> Option<(DMatrix<f64>, usize)> {
        let group = self.groups.get(number)?;
        let mut out = DMatrix::zeros(group.own.nrows(), group.own.nrows());
        group.add_to(&mut out, rho);
        Some((out, group.rows))
    }

    /// Returns the products of some columns, the last of which is the value.
    pub(super) fn only(&self, columns: &[usize]) -> Lagged {
        let part = |matrix: &DMatrix<f64>| {
            if matrix.is_empty() { matrix.clone() } else { matrix.select_columns(columns).select_rows(columns) }
        };
        let groups = self.groups.iter().map(|group| Products {
            own: part(&group.own),
            inner: part(&group.inner),
            lag: part(&group.lag),
            follow: group.follow,
            rows: group.rows,
        });
        Lagged { groups: groups.collect(), rows: self.rows }
    }

    /// Returns the products of one group alone.
    fn alone(&self, number: usize) -> Lagged {
        let groups: Vec<Products> = self.groups.get(number).into_iter().cloned().collect();
        let rows = groups.iter().map(|group| group.rows).sum();
        Lagged { groups, rows }
    }

    /// Returns the autocorrelation of each group and its variance, each from the rows of the group alone: for rows that have no columns in common.
    pub(super) fn correlations_apart(&self) -> Vec<(f64, f64)> {
        let each = (0..self.groups.len()).map(|number| {
            let (rho, variance) = self.alone(number).correlations();
            (rho.first().copied().unwrap_or(0.0), variance.first().copied().unwrap_or(0.0))
        });
        each.collect()
    }

    /// Returns −2 ln of the restricted likelihood; infinite if the columns are not independent.
    fn deviance(&self, correlation: &[f64]) -> f64 {
        let gram = self.gram(correlation);
        let count = gram.nrows().saturating_sub(1);
        let freedom = self.rows.saturating_sub(count).max(1) as f64;
        let Some(factored) = Cholesky::new(gram) else { return f64::INFINITY };
        let pivots = factored.l_dirty().diagonal();
        let volume: f64 = pivots.iter().take(count).map(|pivot| 2.0 * pivot.ln()).sum();
        let left = pivots.iter().next_back().map_or(0.0, |pivot| 2.0 * pivot.ln());
        let noise = self.groups.iter().zip(correlation);
        freedom * left + volume + noise.map(|(group, rho)| group.follow as f64 * (1.0 - rho * rho).ln()).sum::<f64>()
    }

    /// Returns the autocorrelation of each group at the maximum likelihood, and its variance.
    pub(super) fn correlations(&self) -> (Vec<f64>, Vec<f64>) {
        let mut found = vec![0.0; self.groups.len()];
        for _ in 0..ROUNDS.min(self.groups.len()) {
            for number in 0..found.len() {
                if self.groups.get(number).is_some_and(|group| group.follow > 0) {
                    let at = |rho: f64| self.deviance(&with(&found, number, rho));
                    let best = least(at);
                    found[number] = best;
                }
            }
        }
        let variances = (0..found.len()).map(|number| self.variance(&found, number)).collect();
        (found, variances)
    }

    /// Returns the variance from the curvature of the likelihood, limited to what the number of rows can support.
    fn variance(&self, found: &[f64], number: usize) -> f64 {
        let Some((group, &rho)) = self.groups.get(number).zip(found.get(number)).filter(|(group, _)| group.follow > 0)
        else {
            return 0.0;
        };
        let step = step_at(rho);
        let middle = rho.max(step).min(1.0 - 2.0 * step);
        let at = |rho: f64| self.deviance(&with(found, number, rho));
        let curvature = (at(middle - step) - 2.0 * at(middle) + at(middle + step)) / (step * step);
        let least = (1.0 - rho * rho) / group.follow as f64;
        if curvature.is_finite() && curvature > 0.0 {
            (2.0 / curvature).clamp(least, 1.0 / 3.0)
        } else {
            least.max(0.1)
        }
    }

    /// True if rows of a group follow each other.
    pub(super) fn follows(&self, number: usize) -> bool {
        self.groups.get(number).is_some_and(|group| group.follow > 0)
    }

    pub(super) fn len(&self) -> usize {
        self.groups.len()
    }
}

/// Returns the change of an autocorrelation for numerical derivatives.
pub(super) fn step_at(rho: f64) -> f64 {
    0.25 * (1.0 - rho)
}

/// Returns the autocorrelations with one of them replaced.
pub(super) fn with(correlation: &[f64], number: usize, rho: f64) -> Vec<f64> {
    correlation.iter().enumerate().map(|(k, &own)| if k == number { rho } else { own }).collect()
}

/// Returns the autocorrelation at which a function is minimal.
fn least(at: impl Fn(f64) -> f64) -> f64 {
    // In the logarithm of 1 − ρ, which is the natural scale of autocorrelations.
    let rho = |scale: f64| 1.0 - (1.0 - MOST).powf(scale);
    let (scale, most) = peak(0.0, 1.0, CLOSE, TRIALS, &|scale| -at(rho(scale)));
    if at(0.0) <= -most { 0.0 } else { rho(scale) }
}
