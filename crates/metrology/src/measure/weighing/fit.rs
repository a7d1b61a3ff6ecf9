//! Least squares with an offset and, if times are known, a drift for each run.
//!
//! Offset and drift of a run are projected out first (Frisch and Waugh), so that the normal equations have the size of the common unknowns, for any
//! number of runs.

use ncfix_base::geometry::{Matrix, Vector};

/// Maximum number of common unknowns.
pub(super) const UNKNOWNS: usize = 3;

/// Minimum variation of time for a drift, s.
const LEAST_TIME_S: f64 = 1e-3;

/// One equation: a reading.
#[derive(Clone, Debug)]
pub(super) struct WeighingEquation {
    /// Its coefficients of the unknowns.
    pub(super) columns: [f64; UNKNOWNS],
    /// The reading.
    pub(super) value: f64,
    /// Index of the run.
    pub(super) run: usize,
    /// Time, s.
    pub(super) time_s: Option<f64>,
    /// `true` if it is used.
    pub(super) is_used: bool,
}

/// A least-squares solution.
#[derive(Clone, Debug)]
pub(super) struct WeighingFit {
    /// The unknowns; 0 beyond their number.
    pub(super) unknowns: Vector,
    /// (XᵀX)⁻¹; their covariance at unit noise.
    pub(super) cofactors: Matrix,
    /// Sum of the squared residuals.
    pub(super) squares: f64,
    /// Sum of the squares of the readings, without offsets and drifts.
    pub(super) size: f64,
    /// Degrees of freedom: equations minus unknowns, offsets and drifts.
    pub(super) freedom: usize,
    /// Residual of every line; 0 for unused lines.
    pub(super) residuals: Vec<f64>,
    projected: Vec<Vector>,
    runs: Runs,
}

/// Means of the runs.
#[derive(Clone, Debug, Default)]
struct Runs {
    runs: Vec<Run>,
    /// The run of every line and its time relative to the mean; `None` for unused lines.
    lines: Vec<Option<(usize, f64)>>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Run {
    count: f64,
    mean_time_s: f64,
    /// Σ (t − t̄)²; 0 without a drift.
    time_squares: f64,
}

impl Runs {
    fn of(lines: &[WeighingEquation]) -> Runs {
        let number = lines.iter().map(|line| line.run + 1).max().unwrap_or_default();
        let mut runs = vec![Run::default(); number];
        let used = || lines.iter().filter(|line| line.is_used);
        let time = |line: &WeighingEquation| line.time_s.unwrap_or_default();
        for line in used() {
            runs[line.run].count += 1.0;
            runs[line.run].mean_time_s += time(line);
        }
        runs.iter_mut().filter(|run| run.count > 0.0).for_each(|run| run.mean_time_s /= run.count);
        for line in used() {
            let run = &mut runs[line.run];
            run.time_squares += (time(line) - run.mean_time_s).powi(2);
        }
        for run in runs.iter_mut().filter(|run| run.time_squares < LEAST_TIME_S * LEAST_TIME_S) {
            run.time_squares = 0.0;
        }
        let place = |line: &WeighingEquation| line.is_used.then(|| (line.run, time(line) - runs[line.run].mean_time_s));
        let lines = lines.iter().map(place).collect();
        Runs { runs, lines }
    }

    /// Number of offsets and drifts.
    fn unknowns(&self) -> usize {
        let of = |run: &Run| usize::from(run.count > 0.0) + usize::from(run.time_squares > 0.0);
        self.runs.iter().map(of).sum()
    }

    /// Projects offsets and drifts out of a column, only offsets without `with_drift`; 0 for unused lines.
    fn project(&self, values: impl Fn(usize) -> f64, with_drift: bool) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.runs.len()];
        for (index, &(run, time)) in self.used() {
            sums[run].0 += values(index);
            sums[run].1 += values(index) * time;
        }
        let rest = |(index, place): (usize, &Option<(usize, f64)>)| {
            let Some((run, time)) = *place else { return 0.0 };
            let Run { count, time_squares, .. } = self.runs[run];
            let drift = if with_drift && time_squares > 0.0 { sums[run].1 / time_squares * time } else { 0.0 };
            values(index) - sums[run].0 / count - drift
        };
        self.lines.iter().enumerate().map(rest).collect()
    }

    fn used(&self) -> impl Iterator<Item = (usize, &(usize, f64))> {
        self.lines.iter().enumerate().filter_map(|(index, place)| Some((index, place.as_ref()?)))
    }
}

impl WeighingFit {
    /// Solves for the first `count` unknowns; `None` if the equations do not determine them.
    pub(super) fn new(lines: &[WeighingEquation], count: usize) -> Option<WeighingFit> {
        let runs = Runs::of(lines);
        let columns: Vec<Vec<f64>> =
            (0..count.min(UNKNOWNS)).map(|column| runs.project(|index| lines[index].columns[column], true)).collect();
        let values = runs.project(|index| lines[index].value, true);
        let row = |index: usize| Vector::from_fn(|column, _| columns.get(column).map_or(0.0, |column| column[index]));
        let projected: Vec<Vector> = (0..lines.len()).map(row).collect();
        // Columns of equal length give the most accurate inverse.
        let mut scale = Vector::repeat(1.0);
        for (column, scale) in columns.iter().zip(scale.iter_mut()) {
            *scale = squares(column).sqrt();
        }
        let mut normal = Matrix::identity();
        let mut right = Vector::zeros();
        for i in 0..columns.len() {
            right[i] = dot(&columns[i], &values) / scale[i];
            for j in 0..columns.len() {
                normal[(i, j)] = dot(&columns[i], &columns[j]) / (scale[i] * scale[j]);
            }
        }
        let inverse = normal.try_inverse()?;
        let unknowns = (inverse * right).component_div(&scale);
        let cofactors = Matrix::from_fn(|i, j| inverse[(i, j)] / (scale[i] * scale[j]));
        let is_finite = unknowns.iter().chain(cofactors.iter()).all(|value| value.is_finite());
        let residuals: Vec<f64> =
            values.iter().zip(&projected).map(|(value, row)| value - row.dot(&unknowns)).collect();
        let equations = runs.used().count();
        let freedom = equations.checked_sub(runs.unknowns() + columns.len())?;
        let (size, squares) = (squares(&values), squares(&residuals));
        is_finite.then_some(WeighingFit { unknowns, cofactors, squares, size, freedom, residuals, projected, runs })
    }

    /// An element of the hat matrix: the influence of the reading `other` on the fitted value of `one`.
    pub(super) fn hat(&self, one: usize, other: usize) -> f64 {
        let (Some((run, time)), Some((other_run, other_time))) = (self.runs.lines[one], self.runs.lines[other]) else {
            return 0.0;
        };
        let shared = self.projected[one].dot(&(self.cofactors * self.projected[other]));
        if run != other_run {
            return shared;
        }
        let Run { count, time_squares, .. } = self.runs.runs[run];
        shared + 1.0 / count + if time_squares > 0.0 { time * other_time / time_squares } else { 0.0 }
    }
}

/// The share of a column's variation that offsets, drifts and the other columns cannot reproduce.
pub(super) fn unlike_share(lines: &[WeighingEquation], count: usize, column: usize) -> f64 {
    let runs = Runs::of(lines);
    let project = |column: usize, with_drift: bool| runs.project(|index| lines[index].columns[column], with_drift);
    let whole = squares(&project(column, false));
    let mut rest = project(column, true);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for other in (0..count.min(UNKNOWNS)).filter(|&other| other != column) {
        let mut direction = project(other, true);
        let length = squares(&direction);
        basis.iter().for_each(|base| take_out(&mut direction, base));
        // The remainder of a column that depends on earlier ones is rounding noise.
        if squares(&direction) > 1e-12 * length {
            basis.push(direction);
        }
    }
    basis.iter().for_each(|base| take_out(&mut rest, base));
    // Rounding leaves a remainder of a constant column.
    let size: f64 = lines.iter().map(|line| line.columns[column].powi(2)).sum();
    if whole > 1e-20 * size { (squares(&rest) / whole).sqrt() } else { 0.0 }
}

/// Regression coefficient of a column on the first column: Σ x₀ x / Σ x₀².
pub(super) fn likeness(lines: &[WeighingEquation], column: usize) -> f64 {
    let runs = Runs::of(lines);
    let [first, other] = [0, column].map(|column| runs.project(|index| lines[index].columns[column], true));
    let whole = squares(&first);
    if whole > 0.0 { dot(&first, &other) / whole } else { 0.0 }
}

fn take_out(values: &mut [f64], base: &[f64]) {
    let factor = dot(values, base) / squares(base);
    values.iter_mut().zip(base).for_each(|(value, base)| *value -= factor * base);
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

fn squares(values: &[f64]) -> f64 {
    dot(values, values)
}
