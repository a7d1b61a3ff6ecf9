//! Link errors with their intervals, from a fit together with the smooth motion errors of the same run.
//!
//! On a short path a smooth motion error acts almost like a link error, and only their sum is known. Links, set-up and smooth functions are therefore fitted
//! together, each with the size that it usually has on a machine ([`assumptions`]). The sum comes from the readings, and the usual sizes divide it. The
//! covariance of the links then contains all that a motion error may take from them.
//!
//! A machine may be better or worse than usual. The sizes are multiplied by common factors, one for links and one for motion errors, and every pair of
//! factors counts by the probability of the readings (Bishop 2006, Pattern Recognition and Machine Learning, section 3.4). The variance of the noise is that
//! of the residual, inflated by its autocorrelation ([`inflation`]), so that neighbors count as one reading.
//!
//! [`assumptions`]: crate::diagnose::explain::assumptions

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::diagnose::explain::assumptions::Family;
use crate::measure::trace::TraceUnknown;
use ncfix_base::geometry::{Axis, Vector};
use ncfix_model::name::{Carrier, DIRECTIONS, ErrorKind, ErrorName};
use ncfix_model::parameter::ComponentTerm;
use ncfix_model::{Model, ParameterName};

use super::basis::Basis;
use super::poses::RunPoses;
use super::quasi_static::{LinkPart, SmoothMotion, effect, of_setup};
use super::signal::{SIGMAS_95, inflation};

/// Largest width of the 95 % interval of a determined link, as a share of the usual size of such an error.
pub const DETERMINED_SHARE: f64 = 1.0;
/// Maximum number of samples: neighbors are similar, and more of them add no information.
const SAMPLES: usize = 2_000;
/// Factors of the usual sizes of links, up to those of a machine that was never aligned. The sizes are limits of acceptance: no machine is presumed better.
const LINK_SCALES: [f64; 3] = [1.0, 2.0, 4.0];
/// Factors of the usual sizes of motion errors. Precision machines keep a quarter of the limits of ISO 10791-2, worn ones several times as much.
const MOTION_SCALES: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
/// Standard deviation of the unknowns of the set-up, mm: beyond the range of the probes of an R-test, so that the readings alone decide.
const SETUP_MM: f64 = 10.0;
/// Least standard deviation of a reading, mm: the last digit of a table in micrometers.
const LEAST_SIGMA_MM: f64 = 1e-6;

/// A link error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkError {
    /// Its name.
    pub name: ParameterName,
    /// Value relative to the machine file, mm or rad.
    pub value: f64,
    /// Half width of its 95 % interval, mm or rad, with all that a smooth motion error may take from it.
    pub uncertainty_95: f64,
    /// Usual size of such an error, as a standard deviation, mm or rad.
    pub usual_size: f64,
    /// `true` if this path separates it from the other links.
    pub is_told: bool,
    /// `true` if its 95 % interval is narrower than [`DETERMINED_SHARE`] of its usual size.
    pub is_determined: bool,
}

impl LinkError {
    /// `true` if it is determined and its interval excludes zero: only then does the machine file lack it.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.is_determined && self.value.abs() > self.uncertainty_95
    }
}

/// The links with their covariance, mm and rad.
#[derive(Clone, Debug)]
pub(super) struct JointFit {
    pub(super) links: Vec<LinkError>,
    pub(super) covariance: DMatrix<f64>,
}

/// The readings of one direction: products of its columns.
struct Along {
    /// Variance of a reading, mm².
    variance: f64,
    /// Links and set-up with each other, smooth functions with these.
    inner: DMatrix<f64>,
    mixed: DMatrix<f64>,
    /// Links and set-up, and smooth functions, with the readings.
    inner_values: DVector<f64>,
    smooth_values: DVector<f64>,
    squares: f64,
    /// Usual variances of the smooth functions, mm².
    usual: DVector<f64>,
}

/// Links and set-up at one pair of factors, with the logarithm of the probability of the readings.
struct Trial {
    log_probability: f64,
    values: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// The slowest run with its first fit.
pub(super) struct SlowRun<'a> {
    pub(super) model: &'a Model,
    pub(super) axes: &'a [Axis],
    pub(super) tool_mm: &'a Vector,
    pub(super) poses: &'a RunPoses,
    pub(super) links: &'a LinkPart,
    pub(super) motion: &'a SmoothMotion,
    /// Residual without links, set-up and motion, by sample, mm.
    pub(super) left: &'a [Option<Vector>],
}

/// Fits links, set-up and smooth functions together; `None` without readings.
#[must_use]
pub(super) fn joint(run: &SlowRun<'_>, free: &[TraceUnknown]) -> Option<JointFit> {
    let names: Vec<ParameterName> = run.links.links.iter().map(|link| link.name).collect();
    let basis = run.motion.basis();
    let columns = names.len() + 3 * free.len();
    let there: Vec<usize> = (0..run.poses.count()).filter(|&number| run.left[number].is_some()).collect();
    let used: Vec<usize> = there.iter().copied().step_by(there.len().div_ceil(SAMPLES).max(1)).collect();
    if used.len() <= 1 + basis.len() {
        return None;
    }
    let smooth = smooth_rows(basis, run.poses, &used);
    let gram = smooth.transpose() * &smooth;
    let sizes = usual_motion(run, basis, &used);
    let along: Vec<Along> = (0..3)
        .map(|direction| {
            let mut inner = DMatrix::zeros(used.len(), columns);
            for (row, &number) in used.iter().enumerate() {
                for (column, &name) in names.iter().enumerate() {
                    inner[(row, column)] = effect(run.model, name, run.tool_mm, run.poses, number)[direction];
                }
                for (place, unknown) in free.iter().enumerate() {
                    for k in 0..3 {
                        inner[(row, names.len() + 3 * place + k)] = of_setup(*unknown, k, run.poses, number)[direction];
                    }
                }
            }
            let values = DVector::from_iterator(
                used.len(),
                used.iter().map(|&number| run.left[number].map_or(0.0, |left| left[direction])),
            );
            let residuals: Vec<f64> = used.iter().map(|&number| residual(run, number)[direction]).collect();
            let freedom = used.len().saturating_sub(1 + basis.len()).max(1) as f64;
            let spread = residuals.iter().map(|value| value * value).sum::<f64>() / freedom;
            Along {
                variance: (spread * inflation(&residuals)).max(LEAST_SIGMA_MM * LEAST_SIGMA_MM),
                inner_values: inner.transpose() * &values,
                smooth_values: smooth.transpose() * &values,
                squares: values.norm_squared(),
                mixed: smooth.transpose() * &inner,
                inner: inner.transpose() * inner,
                usual: sizes.column(direction).into_owned(),
            }
        })
        .collect();
    let sizes: Vec<f64> = names.iter().map(|name| usual_size(name, basis)).collect();
    let mut trials = Vec::new();
    for motion_scale in MOTION_SCALES {
        let Some(reduced) = Reduced::new(&along, &gram, motion_scale) else { continue };
        trials.extend(LINK_SCALES.iter().filter_map(|scale| reduced.trial(&sizes, columns, *scale)));
    }
    let (values, covariance) = mean(&trials)?;
    let links = run.links.links.iter().zip(&sizes).enumerate().map(|(k, (link, &usual_size))| {
        let uncertainty_95 = SIGMAS_95 * covariance[(k, k)].max(0.0).sqrt();
        LinkError {
            name: link.name,
            value: values[k],
            uncertainty_95,
            usual_size,
            is_told: link.is_separate,
            is_determined: link.is_separate && 2.0 * uncertainty_95 < DETERMINED_SHARE * usual_size,
        }
    });
    let count = names.len();
    Some(JointFit { links: links.collect(), covariance: covariance.view((0, 0), (count, count)).into_owned() })
}

/// Residual of the first fit, mm.
fn residual(run: &SlowRun<'_>, number: usize) -> Vector {
    let fitted = run.links.at(run.model, run.tool_mm, run.poses, number)
        + run.links.setup_at(run.poses, number)
        + run.motion.at(&run.poses.encoder[number], run.poses.share[number]);
    run.left[number].map_or_else(Vector::zeros, |left| left - fitted)
}

fn smooth_rows(basis: &Basis, poses: &RunPoses, used: &[usize]) -> DMatrix<f64> {
    let mut rows = DMatrix::zeros(used.len(), 1 + basis.len());
    for (row, &number) in used.iter().enumerate() {
        let mut own = vec![1.0];
        basis.push(&poses.encoder[number], poses.share[number], &mut own);
        own.iter().enumerate().for_each(|(column, value)| rows[(row, column)] = *value);
    }
    rows
}

/// Usual variances of the coefficients of the smooth functions, mm², by direction: those of the motion errors of every axis, through the chain.
///
/// The share of a degree n falls as 1/n², as in the profile of a guideway, the sum of independent slopes. The constant counts as the first degree. Over its
/// range, Pₙ² has the mean 1/(2n + 1).
fn usual_motion(run: &SlowRun<'_>, basis: &Basis, used: &[usize]) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(1 + basis.len(), 3);
    let terms = basis.terms();
    let by_axis: Vec<(Axis, Vector)> = run.axes.iter().map(|&axis| (axis, usual_squares(run, axis, used))).collect();
    let whole = 1.0 + (1..=basis.degree()).map(|degree| (degree as f64).powi(-2)).sum::<f64>();
    for direction in 0..3 {
        let moving = |axis: Axis| terms.iter().any(|term| term.0.is_none_or(|own| own == axis));
        let constant = by_axis.iter().map(|(axis, squares)| {
            // An axis that does not move contributes a constant, the error at its position.
            squares[direction] / if moving(*axis) { whole } else { 1.0 }
        });
        out[(0, direction)] = constant.sum();
        for (row, &(axis, degree)) in terms.iter().enumerate() {
            let squares: f64 = by_axis
                .iter()
                .filter(|(own, _)| axis.is_none_or(|axis| axis == *own))
                .map(|(_, squares)| squares[direction])
                .sum();
            let degree = degree as f64;
            out[(1 + row, direction)] = squares * (2.0 * degree + 1.0) / (degree * degree * whole);
        }
    }
    out
}

/// Mean squares of the effect on the tool of the usual motion errors of an axis, along X, Y, Z, mm².
fn usual_squares(run: &SlowRun<'_>, axis: Axis, used: &[usize]) -> Vector {
    let mut out = Vector::zeros();
    for direction in DIRECTIONS {
        let size = match (direction.is_rotation(), axis.is_rotary()) {
            (true, _) => Family::Angle,
            (false, true) => Family::Rotary,
            (false, false) => Family::Straightness,
        }
        .size(0.0);
        let name = ErrorName::motion(direction, axis);
        // Arms change little along a path.
        let few = used.iter().step_by(used.len().div_ceil(100).max(1));
        let count = few.clone().count().max(1) as f64;
        for &number in few {
            let effect = run.poses.effect(run.model, name, run.tool_mm, number) * size;
            out += effect.component_mul(&effect) / count;
        }
    }
    out
}

/// Usual size of a link error, as a standard deviation, mm or rad by the power of its parameter.
fn usual_size(name: &ParameterName, basis: &Basis) -> f64 {
    let component = name.component;
    let is_rotation = component.direction.is_rotation();
    let is_of_line = matches!(component.carrier, Carrier::Axis(axis) if !axis.is_rotary());
    let family = match (component.kind, name.term, is_rotation) {
        (ErrorKind::Location, _, true) if is_of_line => Family::Squareness,
        (ErrorKind::Location, _, true) => Family::Tilt,
        (ErrorKind::Location, _, false) => Family::Offset,
        (ErrorKind::Motion, ComponentTerm::Backlash, true) => Family::AngularPlay,
        (ErrorKind::Motion, ComponentTerm::Backlash, false) => Family::Backlash,
        (ErrorKind::Motion, _, true) => Family::Angle,
        (ErrorKind::Motion, _, false) => Family::Straightness,
    };
    let reach = component.axis().and_then(|axis| basis.half_range(axis)).unwrap_or(1.0);
    family.size(0.0) / reach.powi(i32::from(name.degree()))
}

/// The readings with the smooth functions taken out, at one factor of their usual sizes.
struct Reduced {
    inner: DMatrix<f64>,
    values: DVector<f64>,
    squares: f64,
    log_determinant: f64,
}

impl Reduced {
    fn new(along: &[Along], gram: &DMatrix<f64>, scale: f64) -> Option<Reduced> {
        let columns = along.first()?.inner.ncols();
        let mut out = Reduced {
            inner: DMatrix::zeros(columns, columns),
            values: DVector::zeros(columns),
            squares: 0.0,
            log_determinant: 0.0,
        };
        for own in along {
            // Without arms a rotation has no effect: its function stays near zero instead of having no size.
            let usual = own.usual.map(|variance| (variance * scale * scale).max(LEAST_SIGMA_MM * LEAST_SIGMA_MM));
            // In units of the usual sizes: well conditioned.
            let unit = usual.map(f64::sqrt);
            let matrix = DMatrix::from_fn(gram.nrows(), gram.ncols(), |row, column| {
                let same = if row == column { 1.0 } else { 0.0 };
                same + gram[(row, column)] * unit[row] * unit[column] / own.variance
            });
            let root = matrix.cholesky()?;
            let mixed = DMatrix::from_diagonal(&unit) * &own.mixed;
            let smooth_values = own.smooth_values.component_mul(&unit);
            let solved = root.solve(&mixed);
            out.inner += (&own.inner - mixed.transpose() * &solved / own.variance) / own.variance;
            out.values += (&own.inner_values - solved.transpose() * &smooth_values / own.variance) / own.variance;
            let explained = smooth_values.dot(&root.solve(&smooth_values));
            out.squares += (own.squares - explained / own.variance) / own.variance;
            out.log_determinant += log_determinant(&root);
        }
        Some(out)
    }

    /// Links and set-up at one factor of the usual sizes of links.
    fn trial(&self, sizes: &[f64], columns: usize, scale: f64) -> Option<Trial> {
        let unit = DVector::from_fn(columns, |k, _| sizes.get(k).map_or(SETUP_MM, |size| size * scale));
        let matrix = DMatrix::from_fn(columns, columns, |row, column| {
            let same = if row == column { 1.0 } else { 0.0 };
            same + self.inner[(row, column)] * unit[row] * unit[column]
        });
        let root = matrix.cholesky()?;
        let right = self.values.component_mul(&unit);
        let solved = root.solve(&right);
        let log_probability =
            -0.5 * (self.log_determinant + log_determinant(&root) + self.squares - right.dot(&solved));
        let diagonal = DMatrix::from_diagonal(&unit);
        let covariance = &diagonal * root.inverse() * &diagonal;
        log_probability.is_finite().then(|| Trial { log_probability, values: solved.component_mul(&unit), covariance })
    }
}

fn log_determinant(root: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * root.l_dirty().diagonal().iter().map(|value| value.ln()).sum::<f64>()
}

/// Mean and covariance over all trials, each by its probability; `None` without trials.
fn mean(trials: &[Trial]) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let most = trials.iter().map(|trial| trial.log_probability).fold(f64::NEG_INFINITY, f64::max);
    let first = trials.first()?;
    let weights: Vec<f64> = trials.iter().map(|trial| (trial.log_probability - most).exp()).collect();
    let whole: f64 = weights.iter().sum();
    let mut values = DVector::zeros(first.values.len());
    for (trial, weight) in trials.iter().zip(&weights) {
        values += &trial.values * (weight / whole);
    }
    let mut covariance = DMatrix::zeros(first.values.len(), first.values.len());
    for (trial, weight) in trials.iter().zip(&weights) {
        let off = &trial.values - &values;
        covariance += (&trial.covariance + &off * off.transpose()) * (weight / whole);
    }
    Some((values, covariance))
}
