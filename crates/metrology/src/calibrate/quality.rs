//! Agreement of a model with measurements: measured values, residuals, efficiency, for each measurement.
//!
//! Efficiency is δ = 1 − Σ|residual| / Σ|measured| (Spaan 1995, eq. 3.6). Measured values are the residuals of an error-free machine, residuals those
//! of the model, both with the best fit of the set-up unknowns, which belong to neither.

use crate::measure::data::DataSet;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::effect::Parameter;
use super::fault::FitError;
use super::fit::{FitOptions, fit};

/// A measurement and a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// The measurement.
    pub name: String,
    /// Number of readings.
    pub readings: usize,
    /// Root mean square and largest measured value, mm or rad.
    pub measured: [f64; 2],
    /// Root mean square and largest residual, mm or rad.
    pub left: [f64; 2],
    /// Standard deviation of the residuals about their mean; `None` for a single reading.
    pub left_sigma: Option<f64>,
    /// Sums of the magnitudes of measured values, and of residuals.
    pub sums: [f64; 2],
    /// Explained share of the sum of magnitudes.
    pub efficiency: f64,
    /// Individual readings, in the order of the rows.
    pub lines: Vec<ComparedReading>,
}

/// A reading and a model, mm or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparedReading {
    /// The row.
    pub row: usize,
    /// Index of the value in its row, from 0.
    pub index: usize,
    /// Residual of an error-free machine.
    pub measured: f64,
    /// Residual of the model.
    pub left: f64,
}

impl Quality {
    /// The statistics of readings.
    #[must_use]
    pub fn of(name: String, lines: Vec<ComparedReading>) -> Quality {
        let count = lines.len().max(1) as f64;
        let sizes = |of: fn(&ComparedReading) -> f64| {
            let mean = lines.iter().map(|line| of(line).powi(2)).sum::<f64>() / count;
            [mean.sqrt(), lines.iter().fold(0.0_f64, |most, line| most.max(of(line).abs()))]
        };
        let sum = |of: fn(&ComparedReading) -> f64| lines.iter().map(|line| of(line).abs()).sum::<f64>();
        let (measured, left) = (sizes(|line| line.measured), sizes(|line| line.left));
        let sums = [sum(|line| line.measured), sum(|line| line.left)];
        let mean = lines.iter().map(|line| line.left).sum::<f64>() / count;
        let squares = lines.iter().map(|line| (line.left - mean).powi(2)).sum::<f64>();
        Quality {
            name,
            readings: lines.len(),
            measured,
            left,
            left_sigma: (lines.len() > 1).then(|| (squares / (count - 1.0)).sqrt()),
            sums,
            efficiency: if sums[0] > 0.0 { 1.0 - sums[1] / sums[0] } else { 0.0 },
            lines,
        }
    }

    /// Some of the readings.
    #[must_use]
    pub fn part(&self, name: String, keep: impl Fn(&ComparedReading) -> bool) -> Quality {
        Quality::of(name, self.lines.iter().copied().filter(|line| keep(line)).collect())
    }
}

/// Compares a model with a measurement, fitted or not.
///
/// # Errors
/// [`FitError`] if not even the set-up unknowns are identifiable.
pub fn quality(machine: &Machine, errors: &ErrorModel, data: &DataSet) -> Result<Quality, FitError> {
    let set = std::slice::from_ref(data);
    let of = |errors: &ErrorModel| -> Result<Vec<(usize, f64)>, FitError> {
        // Without the errors of the machine, residuals are not noise and cannot reveal outliers.
        let found = fit::<Parameter>(machine, errors, &[], set, FitOptions { robust: false })?;
        Ok(found.residuals.iter().map(|&(_, row, residual, _)| (row, residual)).collect())
    };
    let (measured, left) = (of(&ErrorModel::default())?, of(errors)?);
    let mut lines: Vec<ComparedReading> = Vec::with_capacity(left.len());
    for ((row, measured), (_, left)) in measured.into_iter().zip(left) {
        let index = lines.last().filter(|last| last.row == row).map_or(0, |last| last.index + 1);
        lines.push(ComparedReading { row, index, measured, left });
    }
    Ok(Quality::of(data.name.clone(), lines))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_of_the_definition() {
        let line = |index, measured, left| ComparedReading { row: 0, index, measured, left };
        let found = Quality::of("a".into(), vec![line(0, 3.0, 1.0), line(1, -4.0, -0.5), line(2, 0.0, 0.5)]);
        // √(25/3); 1 − 2/7; mean 1/3, squares 4/9 + 25/36 + 1/36 = 7/6 over 2.
        assert!((found.measured[0] - (25.0_f64 / 3.0).sqrt()).abs() < 1e-15 && found.measured[1] == 4.0);
        assert!((found.left[0] - 0.5_f64.sqrt()).abs() < 1e-15 && found.left[1] == 1.0);
        assert!((found.efficiency - 5.0 / 7.0).abs() < 1e-15);
        assert!((found.left_sigma.unwrap() - (7.0_f64 / 12.0).sqrt()).abs() < 1e-15);
        let part = found.part("b".into(), |line| line.index == 1);
        assert_eq!((part.readings, part.left_sigma, part.efficiency), (1, None, 0.875));
    }

    #[test]
    fn readings_of_a_row_are_numbered_within_it() {
        let machine = crate::calibrate::bench::machine();
        let rows = "X,Y,Z,dx_um,dy_um\n0,0,0,1,2\n9,0,0,3,\n18,0,0,4,5\n";
        let data = crate::calibrate::bench::table(&machine, rows, "[measurement]\nkind = \"displacement\"\n");
        let found = quality(&machine, &ErrorModel::default(), &data).unwrap();
        let lines: Vec<(usize, usize, f64)> =
            found.lines.iter().map(|line| (line.row, line.index, (line.measured * 1e3).round())).collect();
        assert_eq!(lines, [(0, 0, 1.0), (0, 1, 2.0), (1, 0, 3.0), (2, 0, 4.0), (2, 1, 5.0)]);
    }
}
