//! Candidates that nearly cancel each other. If two columns are nearly equal, the fit gives one a large amount and the other the opposite amount. Their sum
//! explains the small difference of the columns. Outside the measured places it can reach meters.
//!
//! This module also rejects candidates to which the readings are insensitive: to explain micrometers, they would exceed any plausible machine error.

use super::cause::{Candidate, range};
use super::row::{NOWHERE, SceneRow};
use super::scene::Through;
use super::search::Field;
use super::size::weights_at;
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::numeric::Series;

/// A candidate whose effect exceeds the residual by this factor is cancelled by others.
const CANCELS: f64 = 3.0;

/// Largest plausible machine error where the readings are insensitive, mm and rad.
const ABSURD: [f64; 2] = [1.0, 1e-2];
/// Largest RMS residual at which this limit applies, mm or rad.
const LITTLE: f64 = 0.05;
/// Maximum number of rows at which a deviation is evaluated.
const ROWS: usize = 400;
impl Field<'_, '_> {
    /// True if a candidate, in addition to the terms of `series`, exceeds any plausible machine error although the residuals are small.
    pub(super) fn is_absurd(&self, number: usize, series: &Series) -> bool {
        let most = |one: &Candidate| match one.columns.first()?.first()?.0 {
            Through::Component(name) => Some(ABSURD[usize::from(name.direction.is_rotation())]),
            Through::Tip(_) => Some(ABSURD[0]),
            Through::Reading(_) | Through::Value(_) => None,
        };
        let Some((one, most)) = self.candidates.get(number).and_then(|one| Some((one, most(one)?))) else {
            return false;
        };
        let (amounts, _) = series.amounts(&self.columns(one));
        let step = (self.scene.rows.len() / ROWS).max(1);
        let is_large = |row: &SceneRow| {
            let all = weights_at(one, row);
            all.iter().zip(&amounts).map(|(weight, amount)| weight * amount).sum::<f64>().abs() > most
        };
        // A dependence on two axes is evaluated at the ends of both: measured lines cover only its middle.
        let is_beyond = self.scene.rows.iter().step_by(step).any(is_large) || self.corners(one).iter().any(is_large);
        let squares: f64 = self.scene.items.iter().map(|item| item.left * item.left).sum();
        is_beyond && squares < LITTLE * LITTLE * self.scene.items.len() as f64
    }
}

impl Field<'_, '_> {
    /// Combinations of the measured end positions of both axes of a candidate; empty if it depends on anything else.
    fn corners(&self, one: &Candidate) -> Vec<SceneRow> {
        let axis = |driver: &String| AXES.into_iter().find(|axis| axis.to_string() == *driver);
        let axes: Option<Vec<Axis>> = one.drivers.iter().map(axis).collect();
        let (Some(axes), Some(first)) = (axes.filter(|axes| axes.len() == 2), self.scene.rows.first()) else {
            return Vec::new();
        };
        let mut out = vec![SceneRow { number: NOWHERE, ..first.clone() }];
        for axis in axes {
            let Some(ends) = range(self.scene, axis) else { return Vec::new() };
            let at = |row: &SceneRow, place: f64| {
                let mut row = row.clone();
                row.position[axis] = place;
                row
            };
            out = out.iter().flat_map(|row| ends.map(|place| at(row, place))).collect();
        }
        out
    }
}

/// Triangular factor of the regression on the columns of the candidates, in the order in which they were taken.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// Number of basis columns that precede those of the candidates.
    before: usize,
    /// Sum of squares before the first candidate.
    squares: f64,
    /// For each column: its candidate, and its shares in the basis columns after `before`.
    columns: Vec<(usize, Vec<f64>)>,
    /// Sum of squares that each column explains.
    explained: Vec<f64>,
}

impl Triangle {
    /// Starts after the columns that a series already has.
    pub(super) fn new(series: &Series) -> Triangle {
        Triangle { before: series.rank(), squares: series.squares(), columns: Vec::new(), explained: Vec::new() }
    }

    /// Adds the columns of a candidate to a series.
    pub(super) fn take(&mut self, series: &mut Series, number: usize, columns: &[Vec<f64>]) {
        for column in columns {
            if let Some((shares, explained)) = series.take_with_shares(column) {
                self.columns.push((number, shares.get(self.before..).unwrap_or_default().to_vec()));
                self.explained.push(explained);
            }
        }
    }

    /// Returns the candidate taken last whose effect on the readings, after the set-up unknowns, far exceeds the sum of squares to explain. Candidates in
    /// `kept` are skipped.
    pub(super) fn cancelled(&self, kept: &[usize]) -> Option<usize> {
        let count = self.columns.len();
        let mut amounts = self.explained.clone();
        for k in (0..count).rev() {
            let own = self.columns[k].1.get(k).copied().unwrap_or(1.0);
            amounts[k] /= own;
            for (l, share) in self.columns[k].1.iter().enumerate().take(k) {
                amounts[l] -= share * amounts[k];
            }
        }
        let mut does: Vec<(usize, Vec<f64>)> = Vec::new();
        for ((number, shares), amount) in self.columns.iter().zip(&amounts) {
            if does.last().is_none_or(|(last, _)| last != number) {
                does.push((*number, vec![0.0; count]));
            }
            if let Some((_, sums)) = does.last_mut() {
                sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += amount * share);
            }
        }
        let most = CANCELS * CANCELS * self.squares;
        let is_large = |sums: &[f64]| sums.iter().map(|sum| sum * sum).sum::<f64>() > most;
        does.iter().rev().find(|(number, sums)| !kept.contains(number) && is_large(sums)).map(|(number, _)| *number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::cause::{EffectKind, Weight};

    #[test]
    fn of_two_that_are_nearly_one_the_later_is_cancelled() {
        let rows = 40;
        let first: Vec<f64> = (0..rows).map(f64::from).collect();
        let wave: Vec<f64> = (0..rows).map(|k| (f64::from(k) * 0.9).sin()).collect();
        // The columns differ by a hundredth of the wave, so the wave needs a hundred times both.
        let nearly: Vec<f64> = first.iter().zip(&wave).map(|(a, b)| a + 0.01 * b).collect();
        let other: Vec<f64> = (0..rows).map(|k| f64::from(k % 2)).collect();
        let taken = |columns: &[&Vec<f64>]| {
            let mut series = Series::new(&[0; 40], &[1.0; 40], 0.0);
            series.set_values(&wave);
            let mut triangle = Triangle::new(&series);
            for (number, column) in columns.iter().enumerate() {
                triangle.take(&mut series, number, &[(*column).clone()]);
            }
            triangle.cancelled(&[])
        };
        assert_eq!(taken(&[&first, &nearly, &other]), Some(1));
        assert_eq!(taken(&[&first, &wave, &other]), None);
    }

    #[test]
    fn millimetres_for_readings_of_micrometres_are_absurd() {
        let machine = bench::machine();
        let found = |um: f64| {
            let sets = [bench::reads_along_x(&machine, &[um; 8])];
            let scene = bench::scene(&machine, &sets);
            // The readings show only a thousandth of it.
            let mut one = bench::candidate(EffectKind::Unknown, Through::Tip(0), |_| 1.0);
            one.columns[0].push((Through::Tip(0), Weight::new(|_| -0.999)));
            let field = Field::new(&scene, vec![one]);
            field.is_absurd(0, &field.series(&bench::even(&scene), &[], 0.0))
        };
        // 0.5 mm is plausible, 10 mm is not; with residuals of 0.1 mm the limit does not apply.
        assert_eq!([0.5, 10.0, 100.0].map(found), [false, true, false]);
    }
}
