//! How well a model says what was measured: measured, left, efficiency, for each measurement.
//!
//! Efficiency is δ = 1 − Σ|left| / Σ|measured| (Spaan 1995, eq. 3.6). Measured is what a machine without errors leaves, left what the model
//! leaves, both with the unknowns of the set-ups as they fit best then: they belong to neither.

use crate::machine::Machine;
use crate::measure::data::DataSet;
use crate::model::ErrorModel;

use super::fit::{Fault, Options, fit};

/// A measurement and a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// The measurement.
    pub name: String,
    /// Readings.
    pub readings: usize,
    /// Root of the mean square and largest of what was measured, mm or rad.
    pub measured: [f64; 2],
    /// The same of what is left.
    pub left: [f64; 2],
    /// Share of the sum of sizes that the model says.
    pub efficiency: f64,
}

/// Holds a model against a measurement, whether or not it was fitted to it.
///
/// # Errors
/// [`Fault`] where not even the unknowns of the set-ups can be told.
pub fn quality(machine: &Machine, errors: &ErrorModel, data: &DataSet) -> Result<Quality, Fault> {
    let set = std::slice::from_ref(data);
    let of = |errors: &ErrorModel| -> Result<Vec<f64>, Fault> {
        // Without the errors of the machine what is left is no noise that could tell which rows do not fit.
        let found = fit(machine, errors, &[], set, Options { robust: false })?;
        Ok(found.residuals.iter().map(|&(_, _, residual, _)| residual).collect())
    };
    let (measured, left) = (of(&ErrorModel::default())?, of(errors)?);
    let sum = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
    let sizes = |values: &[f64]| {
        let mean = values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64;
        [mean.sqrt(), values.iter().fold(0.0_f64, |most, value| most.max(value.abs()))]
    };
    let whole = sum(&measured);
    Ok(Quality {
        name: data.name.clone(),
        readings: measured.len(),
        measured: sizes(&measured),
        left: sizes(&left),
        efficiency: if whole > 0.0 { 1.0 - sum(&left) / whole } else { 0.0 },
    })
}
