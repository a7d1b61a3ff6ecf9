//! One direction at one position: drift and temperature rises row by row, and the products for a fit.

use nalgebra::{DMatrix, DVector};

use ncfix_base::geometry::Axis;

use super::data::SensorRun;
use super::shrinkage::{Shrinkage, of_components};
use super::subset::Products;

/// Maximum number of rows of a fit: a slow process has no more information in more rows.
const MOST_ROWS: usize = 4000;
/// Minimum number of rows per run, if available.
const LEAST_ROWS: usize = 100;
/// Root mean square of readings below which a sensor counts as constant, K.
const STILL_K: f64 = 1e-6;

/// A sensor by index, and the lag with which it is followed, s.
pub(super) type LaggedSensor = (usize, f64);

/// The rows of one run.
#[derive(Clone, Debug)]
pub(super) struct RunRows<'a> {
    pub(super) run: &'a SensorRun,
    pub(super) times_s: Vec<f64>,
    /// Drift relative to the first row, µm.
    pub(super) drift_um: Vec<f64>,
}

/// Selected rows of every piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowPart {
    All,
    /// All but the last third.
    Early,
    /// The last third.
    Late,
}

/// The readings of one direction at one position of an axis.
pub(super) fn pieces<'a>(runs: &'a [SensorRun], direction: usize, at: Option<(Axis, f64)>) -> Vec<RunRows<'a>> {
    let mut out = Vec::new();
    for run in runs {
        let is_here = |row: usize| at.is_none_or(|(axis, value)| run.position(axis, row) == Some(value));
        let rows: Vec<(f64, f64)> = run
            .times_s
            .iter()
            .zip(&run.drift_um)
            .enumerate()
            .filter(|&(row, _)| is_here(row))
            .filter_map(|(_, (&time_s, drift_um))| Some((time_s, drift_um.get(direction).copied().flatten()?)))
            .collect();
        let step = rows.len().div_ceil((MOST_ROWS / runs.len().max(1)).max(LEAST_ROWS)).max(1);
        if let Some(&(_, first)) = rows.first() {
            let (times_s, drift_um) = rows.iter().step_by(step).map(|&(time_s, um)| (time_s, um - first)).unzip();
            out.push(RunRows { run, times_s, drift_um });
        }
    }
    out
}

impl RunRows<'_> {
    /// Rise of a sensor since the first row, K; zero if it has no readings.
    pub(super) fn rise_k(&self, sensor: &str, lag_s: f64) -> Vec<f64> {
        let rise = self.run.condition.trace(sensor).map(|trace| trace.lagged_at(&self.times_s, lag_s));
        let rise = rise.filter(|rise| rise.len() == self.times_s.len());
        let rise = rise.unwrap_or_else(|| vec![0.0; self.times_s.len()]);
        let first = rise.first().copied().unwrap_or_default();
        rise.into_iter().map(|value| value - first).collect()
    }

    /// A part of the values of its rows.
    pub(super) fn part<'v>(&self, values: &'v [f64], part: RowPart) -> &'v [f64] {
        let border = values.len() - values.len() / 3;
        match part {
            RowPart::All => values,
            RowPart::Early => values.get(..border).unwrap_or_default(),
            RowPart::Late => values.get(border..).unwrap_or_default(),
        }
    }
}

/// Products of all candidates, with the mean of each run removed.
#[derive(Clone, Debug)]
pub(super) struct Bank {
    pub(super) candidates: Vec<LaggedSensor>,
    /// Products of columns of unit length.
    pub(super) products: Products,
    /// Length of every column, K.
    lengths: Vec<f64>,
    pub(super) rows: usize,
    /// Number of runs, each with its own offset.
    pub(super) offsets: usize,
}

impl Bank {
    /// The products of a part of the rows; constant candidates are left out.
    pub(super) fn new(pieces: &[RunRows<'_>], sensors: &[String], candidates: &[LaggedSensor], part: RowPart) -> Bank {
        let gather = |of: &dyn Fn(&RunRows<'_>) -> Vec<f64>| -> Vec<f64> {
            let mut out = Vec::new();
            for piece in pieces {
                let values = of(piece);
                let values = piece.part(&values, part);
                let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
                out.extend(values.iter().map(|value| value - mean));
            }
            out
        };
        let values = DVector::from_vec(gather(&|piece| piece.drift_um.clone()));
        let (mut kept, mut lengths, mut columns) = (Vec::new(), Vec::new(), Vec::new());
        for &(sensor, lag_s) in candidates {
            let Some(name) = sensors.get(sensor) else { continue };
            let column = DVector::from_vec(gather(&|piece| piece.rise_k(name, lag_s)));
            let length = column.norm();
            if length > STILL_K * (values.len().max(1) as f64).sqrt() {
                kept.push((sensor, lag_s));
                lengths.push(length);
                columns.push(column / length);
            }
        }
        let matrix = if columns.is_empty() { DMatrix::zeros(values.len(), 0) } else { DMatrix::from_columns(&columns) };
        let products =
            Products { columns: matrix.tr_mul(&matrix), values: matrix.tr_mul(&values), total: values.norm_squared() };
        Bank { candidates: kept, products, lengths, rows: values.len(), offsets: pieces.len() }
    }

    /// Index of a candidate.
    pub(super) fn place(&self, candidate: LaggedSensor) -> Option<usize> {
        self.candidates.iter().position(|&known| known == candidate)
    }

    /// The fit of some candidates; `None` if they are linearly dependent.
    pub(super) fn fit(&self, members: &[usize], shrinkage: Shrinkage) -> Option<ShrunkFit> {
        let part = self.products.of(members);
        let lengths: Vec<f64> = members.iter().filter_map(|&member| self.lengths.get(member).copied()).collect();
        let (unit, effective) = match shrinkage {
            Shrinkage::Components(count) if count < members.len() => {
                let lengths = DVector::from_column_slice(&lengths);
                let (um_per_k, kept) = of_components(&part, &lengths, count);
                (um_per_k.component_mul(&lengths), kept as f64)
            }
            Shrinkage::Components(_) => ridge(&part, DVector::zeros(lengths.len()))?,
            Shrinkage::ReadingError(fault_k) => {
                let faults = lengths.iter().map(|length| self.rows as f64 * (fault_k / length).powi(2));
                ridge(&part, DVector::from_iterator(lengths.len(), faults))?
            }
        };
        // |values − columns · unit|²; only least squares has values · unit for its last term.
        let squares = part.total - 2.0 * unit.dot(&part.values) + unit.dot(&(&part.columns * &unit));
        let um_per_k = unit.iter().zip(&lengths).map(|(value, length)| value / length).collect();
        Some(ShrunkFit { um_per_k, squares: squares.max(0.0), effective })
    }
}

/// Coefficients of some candidates, with what they leave and cost.
#[derive(Clone, Debug)]
pub(super) struct ShrunkFit {
    /// Coefficients, µm/K.
    pub(super) um_per_k: Vec<f64>,
    /// Residual sum of squares of these coefficients, µm²; larger than that of least squares if they are shrunk.
    pub(super) squares: f64,
    /// Effective number of coefficients: the trace of the matrix that turns measured into fitted values.
    pub(super) effective: f64,
}

/// Coefficients of unit columns and their effective number, with `added` on the diagonal of the products.
fn ridge(part: &Products, added: DVector<f64>) -> Option<(DVector<f64>, f64)> {
    let cholesky = (&part.columns + DMatrix::from_diagonal(&added)).cholesky()?;
    Some((cholesky.solve(&part.values), cholesky.solve(&part.columns).trace()))
}
