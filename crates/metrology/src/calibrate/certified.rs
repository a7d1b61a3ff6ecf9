//! Uncertainty of parameters from certificates: an error of a stated length or scale moves all readings that rest on it together.

use nalgebra::{DMatrix, DVector};

use super::effect::Parameter;
use super::fault::FitError;
use super::fit::{Fit, FitOptions, factor_of, fit};
use crate::measure::certificate::{changed, changes};
use crate::measure::data::DataSet;
use ncfix_machine::machine::Machine;

/// Adds the contribution of each certificate to the uncertainties of a fit, and to the covariance of its parameters: the fit is repeated with the readings
/// changed by one standard uncertainty.
///
/// # Errors
/// [`FitError`] if a repeated fit fails.
pub fn add_certificates<P: Clone + Into<Parameter>>(
    machine: &Machine,
    parameters: &[P],
    data: &[DataSet],
    options: FitOptions,
    found: &mut Fit,
) -> Result<(), FitError> {
    let all = changes(machine, data);
    if all.is_empty() {
        return Ok(());
    }
    let count = found.factor.len();
    let rows = |fit: &Fit| DMatrix::from_fn(count, count, |row, k| fit.factor[row].get(k).copied().unwrap_or(0.0));
    let lower = rows(found);
    let mut covariance = &lower * lower.transpose();
    for changes in &all {
        let moved = fit(machine, &found.errors, parameters, &changed(data, changes), options)?;
        let moves: Vec<f64> = moved.estimates.iter().zip(&found.estimates).map(|(a, b)| a.value - b.value).collect();
        for (estimate, change) in found.estimates.iter_mut().zip(&moves) {
            estimate.sigma = estimate.sigma.hypot(*change);
        }
        let step = DVector::from_fn(count, |row, _| moves.get(row).copied().unwrap_or(0.0));
        covariance += &step * step.transpose();
    }
    found.factor = factor_of(&covariance, count);
    Ok(())
}
