//! The parameters of the machine by each file alone: its normal equations, without the unknowns of its set-ups, and its own noise.
//!
//! The noise is that of the residuals of a fit of the file alone. The residuals of a common fit of files that contradict each other contain the contradiction.

use nalgebra::{DMatrix, DVector};

use crate::measure::certificate::{changed, changes};
use crate::measure::data::DataSet;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::column::Column;
use super::design::{Design, EquationOrigin, ReadingEquation, tie_sigma};
use super::effect::Parameter;
use super::fit::{Fit, FitOptions};
use super::noise::{NoiseGroups, group_of};

/// Number of alternations between the noise of a file and its own fit.
const ROUNDS: usize = 10;
/// Number of the first ones, whose weights cannot lock on to a wrong start.
const EARLY: usize = 4;
/// Maximum number of derivatives of a file (32 MB); larger files are not examined.
const MOST_FACTORS: usize = 1 << 22;
/// Share of the squares of a column that is added to them: directions without effect stay at zero.
const RIDGE: f64 = 1e-11;
/// Degrees of freedom of a noise that the description states.
const DESCRIBED: f64 = 1e6;
/// Largest autocorrelation of neighboring residuals that counts.
const MOST_CORRELATED: f64 = 0.95;

/// The normal equations of a file for the parameters of the machine. Unknowns are changes from the common fit.
#[derive(Clone, Debug)]
pub(super) struct ReducedFile {
    /// Information about the parameters, per squared unit.
    pub(super) normal: DMatrix<f64>,
    /// Right sides: of the readings, then of their change by one standard uncertainty of each certificate.
    pub(super) sides: DMatrix<f64>,
    /// Degrees of freedom of the noise.
    pub(super) freedom: f64,
}

/// Each file of a common fit; `None` if a file is too large.
pub(super) fn by_file(
    machine: &Machine,
    fit: &Fit,
    parameters: &[Parameter],
    data: &[DataSet],
    options: FitOptions,
) -> Option<Vec<ReducedFile>> {
    let certified = changes(machine, data);
    let of_file = |number: usize| {
        let set = data.get(number..=number)?;
        let values = fit.estimates.iter().filter(|one| match one.column {
            Column::Unknown(own, _) => own == number,
            _ => true,
        });
        let values: Vec<f64> = values.map(|one| one.value).collect();
        let moved: Option<Vec<Vec<DataSet>>> =
            certified.iter().map(|changes| Some(changed(set, changes.get(number..=number)?))).collect();
        OwnEquations::new(machine, &fit.errors, parameters, set, &values, &moved?)?.reduced(options)
    };
    (0..data.len()).map(of_file).collect()
}

/// The equations of one file.
struct OwnEquations<'a> {
    set: &'a [DataSet],
    /// Number of parameters of the machine, which are the first columns.
    parameters: usize,
    lines: Vec<ReadingEquation>,
    factors: DMatrix<f64>,
    /// Residuals of the common fit, then their changes by certificates: a column each.
    sides: DMatrix<f64>,
}

impl<'a> OwnEquations<'a> {
    fn new(
        machine: &Machine,
        errors: &ErrorModel,
        parameters: &[Parameter],
        set: &'a [DataSet],
        values: &[f64],
        moved: &[Vec<DataSet>],
    ) -> Option<OwnEquations<'a>> {
        let design = Design::new(machine, set, parameters);
        let width = design.columns.len();
        let rows: usize = set.iter().map(|set| 3 * set.observations.len()).sum();
        if values.len() != width || rows.saturating_mul(width) > MOST_FACTORS {
            return None;
        }
        let (mut lines, mut factors) = (Vec::new(), Vec::new());
        design.walk(errors, values, true, |line, own| {
            lines.push(line);
            factors.extend_from_slice(own);
        });
        let mut sides = DMatrix::zeros(lines.len(), 1 + moved.len());
        lines.iter().enumerate().for_each(|(row, line)| sides[(row, 0)] = line.residual);
        for (number, set) in moved.iter().enumerate() {
            let mut row = 0;
            Design::new(machine, set, parameters).walk(errors, values, false, |line, _| {
                if let Some(before) = lines.get(row) {
                    sides[(row, 1 + number)] = line.residual - before.residual;
                }
                row += 1;
            });
        }
        let factors = DMatrix::from_row_slice(lines.len(), width, &factors);
        Some(OwnEquations { set, parameters: parameters.len(), lines, factors, sides })
    }

    /// The equations multiplied by the roots of these weights.
    fn weighted(&self, matrix: &DMatrix<f64>, roots: &[f64]) -> DMatrix<f64> {
        let mut out = matrix.clone();
        out.row_iter_mut().zip(roots).for_each(|(mut row, root)| row *= *root);
        out
    }

    /// Square roots of the weights for a noise.
    fn roots(&self, noise: &NoiseGroups, left: &[f64], is_early: bool, robust: bool) -> Vec<f64> {
        let root = |(line, left): (&ReadingEquation, &f64)| match line.origin {
            EquationOrigin::Tie(tie) => 1.0 / tie_sigma(self.set, line.set, tie),
            EquationOrigin::Row(_) => {
                let own = ReadingEquation { residual: *left, ..*line };
                let weight = if robust { noise.weight(&own, is_early) } else { 1.0 };
                weight.sqrt() / noise.sigma(group_of(line))
            }
        };
        self.lines.iter().zip(left).map(root).collect()
    }

    /// The equations without the unknowns of the set-ups, with the noise of a fit of this file alone.
    fn reduced(&self, options: FitOptions) -> Option<ReducedFile> {
        let mut noise = NoiseGroups::new(self.set);
        let mut used = vec![0.0; noise.groups()];
        let mut left: Vec<f64> = self.lines.iter().map(|line| line.residual).collect();
        let mut roots: Vec<f64> = self.roots(&noise, &left, true, false);
        for round in 0..ROUNDS {
            let factors = self.weighted(&self.factors, &roots);
            let side = self.weighted(&self.sides.columns(0, 1).into_owned(), &roots);
            let inverse = inverse_of(&(factors.transpose() * &factors))?;
            let unknowns: DVector<f64> = (&inverse * (factors.transpose() * side)).column(0).into_owned();
            let predicted = &self.factors * unknowns;
            left = self.lines.iter().zip(predicted.iter()).map(|(line, own)| line.residual - own).collect();
            let spread = &factors * &inverse;
            used.fill(0.0);
            for (row, line) in self.lines.iter().enumerate().filter(|(_, line)| line.row().is_some()) {
                used[group_of(line)] += factors.row(row).dot(&spread.row(row));
            }
            let own = |(line, left): (&ReadingEquation, &f64)| ReadingEquation { residual: *left, ..*line };
            let own: Vec<ReadingEquation> = self.lines.iter().zip(&left).map(own).collect();
            noise.update(&own, &used, options.robust);
            roots = self.roots(&noise, &left, round < EARLY, options.robust);
        }
        let growth: Vec<f64> = (0..noise.groups()).map(|group| self.growth(group, &left)).collect();
        for (line, root) in self.lines.iter().zip(&mut roots).filter(|(line, _)| line.row().is_some()) {
            *root /= growth.get(group_of(line)).copied().unwrap_or(1.0).sqrt();
        }
        let factors = self.weighted(&self.factors, &roots);
        let sides = factors.transpose() * self.weighted(&self.sides, &roots);
        let normal = factors.transpose() * &factors;
        let freedom = (0..noise.groups()).map(|group| self.freedom(group, &noise, &used) / growth[group]);
        let (normal, sides) = eliminated(&normal, &sides, self.parameters)?;
        Some(ReducedFile { normal, sides, freedom: freedom.fold(DESCRIBED, f64::min) })
    }

    /// Degrees of freedom of the noise of a group of readings.
    fn freedom(&self, group: usize, noise: &NoiseGroups, used: &[f64]) -> f64 {
        let count = self.lines.iter().filter(|line| line.row().is_some() && group_of(line) == group).count();
        let given = self.set.first().and_then(|set| if group == 0 { set.sigma } else { set.sigma_rad });
        if count == 0 || given == Some(noise.sigma(group)) {
            return DESCRIBED;
        }
        (count as f64 - used.get(group).copied().unwrap_or(0.0)).max(0.0)
    }

    /// Factor of the variances because neighboring residuals are similar: (1 + ρ)/(1 − ρ), with ρ of values that follow one another (Bayley & Hammersley,
    /// Supplement to the Journal of the Royal Statistical Society 8, 1946, for a process of the first order).
    fn growth(&self, group: usize, left: &[f64]) -> f64 {
        let (mut products, mut squares, mut count) = (0.0, 0.0, 0.0_f64);
        // The values of a row are different quantities.
        let (mut before, mut own): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut row = None;
        for (line, left) in self.lines.iter().zip(left).filter(|(line, _)| group_of(line) == group) {
            if line.row().is_none() {
                continue;
            }
            if row != line.row() {
                before = std::mem::take(&mut own);
                row = line.row();
            }
            products += before.get(own.len()).map_or(0.0, |before| before * left);
            squares += left * left;
            count += 1.0;
            own.push(*left);
        }
        let correlation = if squares > 0.0 { products / squares } else { 0.0 };
        // Twice its standard deviation in readings without any.
        if correlation * count.sqrt() <= 2.0 {
            return 1.0;
        }
        let correlation = correlation.min(MOST_CORRELATED);
        (1.0 + correlation) / (1.0 - correlation)
    }
}

/// Inverse of normal equations. Directions without effect have a large variance.
pub(super) fn inverse_of(normal: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scales: Vec<f64> = (0..normal.nrows()).map(|k| scale_of(normal[(k, k)])).collect();
    let scaled = DMatrix::from_fn(normal.nrows(), normal.ncols(), |row, column| {
        normal[(row, column)] * scales[row] * scales[column] + if row == column { RIDGE } else { 0.0 }
    });
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(normal.nrows(), normal.ncols(), |row, column| {
        inverse[(row, column)] * scales[row] * scales[column]
    }))
}

fn scale_of(square: f64) -> f64 {
    if square > 0.0 { 1.0 / square.sqrt() } else { 1.0 }
}

/// The normal equations of the first `count` unknowns, if all others are free.
fn eliminated(normal: &DMatrix<f64>, sides: &DMatrix<f64>, count: usize) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let others = normal.nrows().checked_sub(count)?;
    let own = normal.view((0, 0), (count, count)).into_owned();
    let own_sides = sides.rows(0, count).into_owned();
    if others == 0 {
        return Some((own, own_sides));
    }
    let across = normal.view((0, count), (count, others)).into_owned();
    let by_others = &across * inverse_of(&normal.view((count, count), (others, others)).into_owned())?;
    Some((own - &by_others * across.transpose(), own_sides - by_others * sides.rows(count, others)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_unknowns_leave_what_the_readings_say_beside_them() {
        // y = a·x + b at x = −1, 0, 2 has 14/3 about the mean of x: Σ(x − 1/3)². With y = 3·x + 7, the side is 3 · 14/3.
        let rows = [[-1.0, 1.0], [0.0, 1.0], [2.0, 1.0]];
        let factors = DMatrix::from_fn(3, 2, |row, column| rows[row][column]);
        let readings = DMatrix::from_fn(3, 1, |row, _| 3.0 * rows[row][0] + 7.0);
        let (normal, sides) = (factors.transpose() * &factors, factors.transpose() * readings);
        let (normal, sides) = eliminated(&normal, &sides, 1).unwrap();
        assert!((normal[(0, 0)] - 14.0 / 3.0).abs() < 1e-9 && (sides[(0, 0)] - 14.0).abs() < 1e-9);
    }
}
