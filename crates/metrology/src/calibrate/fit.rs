//! Gauss–Newton over all parameters and unknowns at once.
//!
//! The derivatives are those of the nominal machine: errors of 1e-4 change them by 1e-4 of themselves, which does not slow the iteration. Residuals
//! come from the full kinematics each time, so that the converged result is exact. Steps between the first and the last one use the normal equations
//! and stored derivatives; the first step determines the identifiability, the last the uncertainties.

use nalgebra::DMatrix;

use crate::measure::data::DataSet;
use ncfix_base::numeric::{BorderedSystem, Normal, NormalStep, Solution};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::column::Column;
use super::design::{Design, EquationOrigin, ReadingEquation, tie_sigma};
use super::effect::Parameter;
use super::fault::{FitError, Unsettled};
use super::identify::{Identified, judge};
use super::mean_line::MeanLine;
use super::noise::{NoiseGroups, group_of};
use super::robust::TUKEY_VARIANCE;
use super::row_store::RowStore;
use super::words;

/// Maximum number of iterations.
const MAX_ROUNDS: usize = 60;
/// Number of initial iterations with weights that cannot lock on to a wrong start.
const EARLY_ROUNDS: usize = 4;
/// Number of such iterations with nonlinear parameters.
const CURVED_ROUNDS: usize = 16;
/// Step in standard uncertainties below which the fit has converged.
const SETTLED: f64 = 1e-3;
/// Step in standard uncertainties that is accepted after the last iteration, for oscillating weights.
const NEARLY_SETTLED: f64 = 0.05;
/// Maximum number of derivatives stored between iterations (256 MB).
const KEPT_FACTORS: usize = 1 << 25;
/// Uncertainty of the row that holds an unknown, mm or rad; no other row affects it.
const HELD: f64 = 1e-3;
/// Relative singular value that counts as zero within rounding.
const ARITHMETIC: f64 = 1e-12;
/// If a fit does not converge, its message names the data set with the largest ratio of residuals to stated uncertainty, if this ratio is larger.
const STRANGE: f64 = 3.0;
/// The message also names it if more than one in this number of its readings was rejected.
const SHARE: usize = 5;
/// Weight below which a row is rejected.
const REJECTED: f64 = 0.01;

/// Options of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// `true` to reduce the weight of rows that do not fit.
    pub robust: bool,
}

/// Result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The error model with the parameters.
    pub errors: ErrorModel,
    /// Parameters of the machine, then unknowns of the measurements.
    pub estimates: Vec<Estimate>,
    /// Standard uncertainty of a length reading of each measurement, mm: as described, or estimated if there is no description or the residuals are
    /// larger.
    pub sigmas: Vec<f64>,
    /// Standard uncertainty of an angle reading of each measurement, rad.
    pub angle_sigmas: Vec<f64>,
    /// Residuals of all readings, mm or rad: measurement, row, residual, weight.
    pub residuals: Vec<(usize, usize, f64, f64)>,
    /// Residuals of all known distances, mm: measurement, index of the distance, residual, standard uncertainty.
    pub ties: Vec<(usize, usize, f64, f64)>,
    /// Condition number of columns of unit length with equally accurate readings: largest to smallest singular value.
    pub condition: f64,
    /// Degrees of freedom: equations minus unknowns.
    pub freedom: usize,
    /// Number of iterations.
    pub rounds: usize,
    /// Factor L of the covariance L·Lᵀ of the parameters of the machine: a row for each, mm, rad, per power. Set-up unknowns are free in it.
    pub factor: Vec<Vec<f64>>,
    /// Mean lines of the axes to which the fit is referred. Their slopes are the last estimates, and have the last rows of the factor.
    pub mean_lines: Vec<MeanLine>,
}

impl Fit {
    /// Rejected readings: measurement and row, each once.
    #[must_use]
    pub fn rejected(&self) -> Vec<(usize, usize)> {
        let small = self.residuals.iter().filter(|(.., weight)| *weight < REJECTED);
        let mut rows: Vec<(usize, usize)> = small.map(|&(set, row, ..)| (set, row)).collect();
        rows.dedup();
        rows
    }
}

/// One estimated number.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The unknown.
    pub column: Column,
    /// mm, rad, per power.
    pub value: f64,
    /// Standard uncertainty; infinite for a set-up unknown without effect on the readings, which kept its start value.
    pub sigma: f64,
    /// Variance inflation factor due to the other unknowns.
    pub inflation: f64,
    /// Tip motion due to it, root mean square over the readings, mm; 0 for unknowns of a measurement.
    pub effect_mm: f64,
}

/// Fits parameters to data, starting from the model.
///
/// # Errors
/// [`FitError`].
pub fn fit<P: Clone + Into<Parameter>>(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[P],
    data: &[DataSet],
    options: FitOptions,
) -> Result<Fit, FitError> {
    let parameters: Vec<Parameter> = parameters.iter().cloned().map(Into::into).collect();
    let start = awake(machine, start, &parameters, data)?;
    let judged = judge(machine, &start, &parameters, data)?;
    fit_judged(machine, &start, &parameters, data, options, &judged)
}

/// Arms and time constants have no effect while the terms that they scale are 0. Fits those terms first.
pub(super) fn awake(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[Parameter],
    data: &[DataSet],
) -> Result<ErrorModel, FitError> {
    if !parameters.iter().any(|parameter| parameter.is_idle(start)) {
        return Ok(start.clone());
    }
    let linear: Vec<Parameter> = parameters.iter().filter(|one| one.is_linear()).cloned().collect();
    let judged = judge(machine, start, &linear, data)?;
    Ok(fit_judged(machine, start, &linear, data, FitOptions { robust: false }, &judged)?.errors)
}

/// Fits the identifiable parameters.
pub(super) fn fit_judged(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[Parameter],
    data: &[DataSet],
    options: FitOptions,
    judged: &Identified,
) -> Result<Fit, FitError> {
    let design = Design::new(machine, data, parameters);
    let mut errors = start.clone();
    let mut values = design.start(start);
    let mut rounds = Rounds::new(&design, data, options, judged);
    let mut is_last = false;
    for round in 0..MAX_ROUNDS {
        is_last |= round + 1 == MAX_ROUNDS;
        let is_same = rounds.look(&errors, &values, round, is_last);
        let solution = if is_last { Some(rounds.solved()?) } else { None };
        let step = match (rounds.step(), &solution) {
            (Some(step), _) => step,
            (None, Some(solution)) => step_of(solution),
            (None, None) => step_of(&rounds.solved()?),
        };
        for (k, (value, step)) in values.iter_mut().zip(step.unknowns.iter()).enumerate() {
            *value = design.parameters.get(k).map_or(*value + step, |parameter| parameter.stepped(*value, *step));
        }
        for (parameter, &value) in design.parameters.iter().zip(&values) {
            parameter.set(&mut errors, value);
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(FitError::NotSettled(None));
        }
        let moved = largest_step(&step);
        rounds.used = shared(step.used, &rounds.lines, rounds.noise.groups(), values.len());
        if let (true, Some(solution)) = (is_last && moved < NEARLY_SETTLED, solution) {
            return Ok(finish(rounds, errors, &values, &solution, round + 1));
        }
        is_last = moved < SETTLED && round > rounds.early() && is_same;
    }
    Err(FitError::NotSettled(rounds.unsettled()))
}

/// State between iterations.
struct Rounds<'a> {
    design: &'a Design<'a>,
    options: FitOptions,
    noise: NoiseGroups,
    /// Number of unknowns absorbed by each group of readings.
    used: Vec<f64>,
    lines: Vec<ReadingEquation>,
    weights: Vec<f64>,
    /// The derivatives of all equations; empty if there are too many.
    factors: RowStore,
    errors: ErrorModel,
    values: Vec<f64>,
    /// Identifiability, including set-up unknowns that are not identifiable, which is harmless.
    judged: &'a Identified,
}

impl<'a> Rounds<'a> {
    fn new(design: &'a Design<'a>, data: &[DataSet], options: FitOptions, judged: &'a Identified) -> Rounds<'a> {
        let noise = NoiseGroups::new(data);
        let used = vec![0.0; noise.groups()];
        Rounds {
            design,
            options,
            noise,
            used,
            lines: Vec::new(),
            weights: Vec::new(),
            factors: RowStore::new(design.columns.len(), design.parameters.len()),
            errors: ErrorModel::default(),
            values: Vec::new(),
            judged,
        }
    }

    /// The measurement that deviates most from its description.
    fn unsettled(&self) -> Option<Unsettled> {
        let of = |set: usize, described: &DataSet| {
            let times = |group: usize, given: Option<f64>| given.map_or(0.0, |given| self.noise.scale(group) / given);
            let own =
                || self.lines.iter().zip(&self.weights).filter(|(line, _)| line.set == set && line.row().is_some());
            let rejected = own().filter(|&(_, &weight)| weight < REJECTED).count();
            Unsettled {
                set,
                times: f64::max(times(2 * set, described.sigma), times(2 * set + 1, described.sigma_rad)),
                rejected: [rejected, own().count()],
            }
        };
        let all = self.design.data.iter().enumerate().map(|(set, described)| of(set, described));
        let largest = all.max_by(|one, other| one.times.total_cmp(&other.times))?;
        (largest.times > STRANGE || largest.rejected[0] * SHARE > largest.rejected[1]).then_some(largest)
    }

    /// Number of iterations with preliminary weights.
    fn early(&self) -> usize {
        match (self.options.robust, self.design.is_curved()) {
            (false, _) => 1,
            (true, false) => EARLY_ROUNDS,
            // Nonlinear parameters need more iterations until the residuals are meaningful.
            (true, true) => CURVED_ROUNDS,
        }
    }

    /// Evaluates the residuals: determines noise and weights. Returns `true` if the noise is unchanged.
    fn look(&mut self, errors: &ErrorModel, values: &[f64], round: usize, is_last: bool) -> bool {
        self.errors.clone_from(errors);
        self.values = values.to_vec();
        // Directions of readings depend on the unknowns of the set-ups, which the first iterations determine.
        let with_factors = self.design.is_curved() || round < 2 || round == self.early() + 1 || is_last;
        let (lines, kept) = (&mut self.lines, &mut self.factors);
        lines.clear();
        if with_factors {
            kept.clear();
        }
        let mut fits = true;
        self.design.walk(errors, values, with_factors, |line, factors| {
            lines.push(line);
            fits &= kept.size() <= KEPT_FACTORS;
            if with_factors && fits {
                kept.push(factors);
            }
        });
        if !fits {
            self.factors = RowStore::new(self.design.columns.len(), self.design.parameters.len());
        }
        // After a first step the residuals are meaningful.
        let is_same = round > 0 && self.noise.update(&self.lines, &self.used, self.options.robust);
        let counts = self.options.robust && round > 0;
        let (noise, early) = (&self.noise, self.early().max(EARLY_ROUNDS));
        let weight = |line: &ReadingEquation| {
            if counts && line.row().is_some() { noise.weight(line, round <= early) } else { 1.0 }
        };
        self.weights = self.lines.iter().map(weight).collect();
        is_same
    }

    /// Calls `out` with every equation, its derivatives, and the square root of its weight.
    fn each(&self, mut out: impl FnMut(&ReadingEquation, &[f64], f64)) {
        let root = |line: &ReadingEquation, weight: f64| {
            let sigma = match line.origin {
                EquationOrigin::Row(_) => self.noise.widened(group_of(line)),
                EquationOrigin::Tie(tie) => tie_sigma(self.design.data, line.set, tie),
            };
            weight.sqrt() / sigma
        };
        let mut own = vec![0.0; self.design.columns.len()];
        let mut pass = |line: &ReadingEquation, factors: &[f64], weight: f64| {
            if self.judged.lost.held.is_empty() {
                return out(line, factors, weight);
            }
            own.copy_from_slice(factors);
            self.judged.lost.held.iter().for_each(|&column| own[column] = 0.0);
            out(line, &own, weight);
        };
        if self.factors.len() == self.lines.len() {
            self.factors.each(|k, factors| {
                let own = self.lines.get(k).zip(self.weights.get(k));
                own.iter().for_each(|(line, weight)| pass(line, factors, root(line, **weight)));
            });
        } else {
            let mut weights = self.weights.iter();
            self.design.walk(&self.errors, &self.values, true, |line, factors| {
                let weight = weights.next().copied().unwrap_or(0.0);
                pass(&line, factors, root(&line, weight));
            });
        }
    }

    /// Calls `out` with the row of derivatives for each held unknown.
    fn each_held(&self, mut out: impl FnMut(&[f64])) {
        let mut factors = vec![0.0; self.design.columns.len()];
        for &column in &self.judged.lost.held {
            factors.fill(0.0);
            factors[column] = 1.0;
            out(&factors);
        }
    }

    fn step(&self) -> Option<NormalStep> {
        if BorderedSystem::has_blocks(self.design.columns.len(), self.design.parameters.len()) {
            return self.step_by_blocks();
        }
        let mut normal = Normal::new(self.design.columns.len(), self.noise.groups());
        self.each(|line, factors, weight| normal.add(group_of(line), factors, line.residual, weight));
        self.each_held(|factors| normal.add(0, factors, 0.0, 1.0 / HELD));
        let mut step = normal.solve()?;
        if let Some(first) = step.used.first_mut() {
            *first -= self.judged.lost.held.len() as f64;
        }
        Some(step)
    }

    /// The step with the unknowns of many set-ups.
    fn step_by_blocks(&self) -> Option<NormalStep> {
        let solution = self.system().solve_to(ARITHMETIC)?;
        let count = self.design.columns.len();
        if solution.rank < count {
            return None;
        }
        // A group of readings absorbs w² f C fᵀ of each of its equations, with few factors that are not 0.
        let mut used = vec![0.0; self.noise.groups()];
        self.each(|line, factors, weight| {
            let places: Vec<usize> = (0..count).filter(|&k| factors[k] != 0.0).collect();
            let of_one = |k: usize| -> f64 {
                places.iter().map(|&l| solution.cofactors[(k, l)] * factors[l]).sum::<f64>() * factors[k]
            };
            if let Some(used) = used.get_mut(group_of(line)) {
                *used += weight * weight * places.iter().map(|&k| of_one(k)).sum::<f64>();
            }
        });
        Some(NormalStep { used, ..step_of(&solution) })
    }

    fn system(&self) -> BorderedSystem {
        let mut system = BorderedSystem::new(self.design.columns.len(), self.design.parameters.len());
        self.each(|line, factors, weight| system.add(factors, line.residual, weight));
        self.each_held(|factors| system.add(factors, 0.0, 1.0 / HELD));
        system
    }

    fn solved(&self) -> Result<Solution, FitError> {
        let count = self.design.columns.len();
        let system = self.system();
        // Weights vary as much as readings; identifiability was judged before.
        let solution = system.solve_to(ARITHMETIC).ok_or(FitError::NotSettled(None))?;
        if solution.rank < count {
            let lost = words::lost(&solution.null_space, &self.design.columns, self.design.data);
            return Err(FitError::NotIdentified(Box::new(lost)));
        }
        Ok(solution)
    }
}

/// The step of a solution.
fn step_of(solution: &Solution) -> NormalStep {
    NormalStep { unknowns: solution.unknowns.clone(), variances: solution.cofactors.diagonal(), used: Vec::new() }
}

/// Number of unknowns absorbed by each group; by its share of the equations if the step does not contain it.
fn shared(used: Vec<f64>, lines: &[ReadingEquation], groups: usize, count: usize) -> Vec<f64> {
    if used.len() == groups {
        return used;
    }
    let mut out = vec![0.0; groups];
    for line in lines {
        if let Some(used) = out.get_mut(group_of(line)) {
            *used += count as f64 / lines.len() as f64;
        }
    }
    out
}

/// The largest step in units of its uncertainty.
fn largest_step(step: &NormalStep) -> f64 {
    let sizes = step.unknowns.iter().zip(step.variances.iter()).filter(|(_, variance)| **variance > 0.0);
    sizes.fold(0.0, |largest, (step, variance)| f64::max(largest, step.abs() / variance.sqrt()))
}

fn finish(rounds: Rounds<'_>, errors: ErrorModel, values: &[f64], solution: &Solution, count: usize) -> Fit {
    let effects = rounds.design.effects(&errors);
    let spread = if rounds.options.robust { TUKEY_VARIANCE } else { 1.0 };
    let estimates = rounds
        .design
        .columns
        .iter()
        .zip(values)
        .enumerate()
        .map(|(k, (column, &value))| (k, column.clone(), value, rounds.judged.lost.loose.contains(&k)))
        .map(|(k, column, value, is_loose)| Estimate {
            column,
            value,
            sigma: if is_loose { f64::INFINITY } else { (solution.cofactors[(k, k)] * spread).sqrt() },
            inflation: if is_loose { f64::INFINITY } else { rounds.judged.inflation.get(k).copied().unwrap_or(1.0) },
            effect_mm: effects.get(k).map_or(0.0, |unit| unit * value.abs()),
        })
        .collect();
    let lines = rounds.lines.iter().zip(&rounds.weights);
    let residuals = lines.filter_map(|(line, &weight)| Some((line.set, line.row()?, line.residual, weight))).collect();
    let ties = rounds.lines.iter().filter_map(|line| match line.origin {
        EquationOrigin::Tie(tie) => Some((line.set, tie, line.residual, tie_sigma(rounds.design.data, line.set, tie))),
        EquationOrigin::Row(_) => None,
    });
    let ties = ties.collect();
    let (sigmas, angle_sigmas) = (0..rounds.noise.groups() / 2)
        .map(|set| (rounds.noise.sigma(2 * set), rounds.noise.sigma(2 * set + 1)))
        .unzip();
    let (condition, freedom) = (rounds.judged.condition, solution.freedom);
    let factor = factor_of(&(&solution.cofactors * spread), rounds.design.parameters.len());
    Fit {
        errors,
        estimates,
        sigmas,
        angle_sigmas,
        residuals,
        ties,
        condition,
        freedom,
        rounds: count,
        factor,
        mean_lines: Vec::new(),
    }
}

/// The lower triangular factor of the covariance of the first unknowns. Columns are scaled to unit length first, as their units differ by many powers of ten.
pub(super) fn factor_of(covariance: &DMatrix<f64>, count: usize) -> Vec<Vec<f64>> {
    let count = count.min(covariance.nrows());
    let sigmas: Vec<f64> = (0..count).map(|k| covariance[(k, k)].max(0.0).sqrt()).collect();
    let correlation = DMatrix::from_fn(count, count, |row, column| {
        let scale = sigmas[row] * sigmas[column];
        if row == column || scale == 0.0 {
            f64::from(u8::from(row == column))
        } else {
            covariance[(row, column)] / scale
        }
    });
    match correlation.cholesky() {
        Some(found) => {
            let lower = found.l();
            (0..count).map(|row| (0..=row).map(|column| sigmas[row] * lower[(row, column)]).collect()).collect()
        }
        // Rounding has made it indefinite: without correlations the interval is wider or narrower, never missing.
        None => (0..count).map(|row| (0..=row).map(|k| if k == row { sigmas[row] } else { 0.0 }).collect()).collect(),
    }
}

#[cfg(test)]
mod tests;
