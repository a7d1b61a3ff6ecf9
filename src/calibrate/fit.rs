//! Gauss–Newton over all parameters and unknowns at once.
//!
//! The factors are those of the nominal machine: errors of 1e-4 change them by 1e-4 of themselves, which costs the iteration nothing. Residuals
//! come from the full kinematics each time, so that what it converges to is exact.

use crate::machine::Machine;
use crate::measure::data::DataSet;
use crate::model::ErrorModel;
use crate::model::parameter::ParameterName;
use crate::numeric::{Solution, System};

use super::column::Column;
use super::design::{Design, Line};
use super::robust::{spread, weight};
use super::words;

/// Rounds at most.
const MAX_ROUNDS: usize = 30;
/// Rounds with weights that cannot lock on to a wrong start.
const EARLY_ROUNDS: usize = 4;
/// Steps below this share of their uncertainty say nothing.
const SETTLED: f64 = 1e-3;
/// Steps that are still like this after the last round are good enough: weights that go to and fro.
const NEARLY_SETTLED: f64 = 0.05;
/// How much the uncertainty of readings may still change.
const SAME_SIGMA: f64 = 1e-3;
/// Share of the equations that is not used up, at least.
const LEAST_FREEDOM: f64 = 0.05;
/// Uncertainty of a reading before the residuals say more, mm and rad.
const FIRST_SIGMA: f64 = 1e-3;
/// No spread is less than this, mm or rad: data without noise.
const LEAST_SIGMA: f64 = 1e-9;

/// How to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Whether rows that do not fit are weighted down.
    pub robust: bool,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The error model with the parameters.
    pub errors: ErrorModel,
    /// Parameters of the machine, then unknowns of the measurements.
    pub estimates: Vec<Estimate>,
    /// Standard uncertainty of a reading of each measurement, mm or rad: as described, or estimated.
    pub sigmas: Vec<f64>,
    /// What is left of every reading, mm or rad: measurement, row, residual, weight.
    pub residuals: Vec<(usize, usize, f64, f64)>,
    /// Largest by smallest singular value.
    pub condition: f64,
    /// Equations less unknowns.
    pub freedom: usize,
    /// Rounds.
    pub rounds: usize,
}

/// One number that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// What it is.
    pub column: Column,
    /// mm, rad, per power.
    pub value: f64,
    /// Standard uncertainty.
    pub sigma: f64,
    /// How much its variance grows because the others are free.
    pub inflation: f64,
    /// By how much it moves the tip, root of the mean square over the readings, mm; 0 for unknowns of a measurement.
    pub effect_mm: f64,
}

/// Why there is no result.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// Less equations than unknowns.
    TooFew {
        /// Equations.
        equations: usize,
        /// Unknowns.
        unknowns: usize,
    },
    /// The data cannot tell these combinations, each a sentence.
    NotTold(Vec<String>),
    /// It did not settle.
    NotSettled,
}

/// Fits parameters to data, from what the model says of them.
///
/// # Errors
/// [`Fault`].
pub fn fit(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[ParameterName],
    data: &[DataSet],
    options: Options,
) -> Result<Fit, Fault> {
    let design = Design::new(machine, data, parameters);
    let count = design.columns.len();
    let mut errors = start.clone();
    let mut values: Vec<f64> = parameters.iter().map(|name| name.get(start)).collect();
    values.resize(count, 0.0);
    let mut sigmas: Vec<f64> = data.iter().map(|set| set.sigma.unwrap_or(FIRST_SIGMA)).collect();
    let mut last: Option<Vec<(Line, f64)>> = None;
    for round in 0..MAX_ROUNDS {
        let mut system = System::new(count);
        let mut lines = Vec::new();
        design.walk(&errors, &values, true, |line, factors| {
            let sigma = sigma_of(&design, &line, &sigmas);
            let weight = match &last {
                // A first step brings the residuals to where they say something.
                Some(_) if options.robust && line.row.is_some() => {
                    weight(line.residual / sigma_of(&design, &line, &sigmas), round < EARLY_ROUNDS)
                }
                _ => 1.0,
            };
            system.add(factors, line.residual, weight.sqrt() / sigma);
            lines.push((line, weight));
        });
        if lines.len() < count {
            return Err(Fault::TooFew { equations: lines.len(), unknowns: count });
        }
        let solution = system.solve();
        if solution.rank < count {
            return Err(Fault::NotTold(words::lost(&solution.null_space, &design.columns, data)));
        }
        for (value, step) in values.iter_mut().zip(solution.unknowns.iter()) {
            *value += step;
        }
        for (name, &value) in parameters.iter().zip(&values) {
            name.set(&mut errors, value);
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(Fault::NotSettled);
        }
        let moved = largest_step(&solution);
        let mut found = Vec::with_capacity(lines.len());
        design.walk(&errors, &values, false, |line, _| found.push(line));
        // Unknowns that follow the noise make residuals smaller than it.
        let used: f64 = lines.iter().map(|(_, weight)| *weight).sum();
        let freedom = (1.0 - count as f64 / used.max(1.0)).max(LEAST_FREEDOM);
        let mut is_same = true;
        for (number, sigma) in sigmas.iter_mut().enumerate().filter(|&(number, _)| data[number].sigma.is_none()) {
            let own = found.iter().filter(|line| line.set == number && line.row.is_some());
            let next = (spread(own.map(|line| line.residual)) / freedom.sqrt()).max(LEAST_SIGMA);
            is_same &= (next - *sigma).abs() <= SAME_SIGMA * next;
            *sigma = next;
        }
        let early = if options.robust { EARLY_ROUNDS } else { 0 };
        let is_settled = moved < SETTLED && round > early && is_same;
        last = Some(lines);
        if is_settled || round + 1 == MAX_ROUNDS && moved < NEARLY_SETTLED {
            let weights: Vec<f64> = last.iter().flatten().map(|(_, weight)| *weight).collect();
            return Ok(finish(&design, errors, &values, &solution, sigmas, found.into_iter().zip(weights), round + 1));
        }
    }
    Err(Fault::NotSettled)
}

fn sigma_of(design: &Design<'_>, line: &Line, sigmas: &[f64]) -> f64 {
    if line.row.is_none() {
        return design.sigma(line).unwrap_or(FIRST_SIGMA);
    }
    sigmas.get(line.set).copied().unwrap_or(FIRST_SIGMA)
}

/// The largest last step in units of its uncertainty.
fn largest_step(solution: &Solution) -> f64 {
    let steps = solution
        .unknowns
        .iter()
        .zip(solution.cofactors.diagonal().iter().map(|variance| variance.sqrt()).collect::<Vec<_>>());
    steps
        .fold(0.0, |largest, (step, sigma)| if sigma > 0.0 { f64::max(largest, (step / sigma).abs()) } else { largest })
}

fn finish(
    design: &Design<'_>,
    errors: ErrorModel,
    values: &[f64],
    solution: &Solution,
    sigmas: Vec<f64>,
    lines: impl Iterator<Item = (Line, f64)>,
    rounds: usize,
) -> Fit {
    let effects = design.effects(&errors);
    let estimates = design
        .columns
        .iter()
        .enumerate()
        .map(|(k, &column)| Estimate {
            column,
            value: values.get(k).copied().unwrap_or(0.0),
            sigma: solution.cofactors[(k, k)].sqrt(),
            inflation: solution.inflation.get(k).copied().unwrap_or(1.0),
            effect_mm: effects.get(k).map_or(0.0, |unit| unit * values[k].abs()),
        })
        .collect();
    let residuals =
        lines.filter_map(|(line, weight)| line.row.map(|row| (line.set, row, line.residual, weight))).collect();
    Fit { errors, estimates, sigmas, residuals, condition: solution.condition(), freedom: solution.freedom, rounds }
}
