//! Uncertainty of readings: as described if the residuals agree, otherwise from the residuals.
//!
//! Lengths and angles of a measurement are separate groups: each has its spread, and its share of the absorbed unknowns.
//!
//! A spread from few residuals is itself uncertain, so uncertainties that follow from it are widened by Student's t: two of them are a 95 % interval. The median
//! of a few residuals is no spread at all. They count with equal weights, and none of them is rejected.

use crate::measure::data::DataSet;
use crate::measure::display;
use ncfix_base::numeric::student;

use super::design::ReadingEquation;
use super::robust::{spread, tempered, weight};

/// Initial uncertainty of a length reading, mm.
pub(super) const FIRST_SIGMA: f64 = 1e-3;
/// Initial uncertainty of an angle reading, rad.
pub(super) const FIRST_ANGLE_SIGMA: f64 = 1e-6;
/// Minimum spread relative to the initial one, for data without noise.
const LEAST_SIGMA: f64 = 1e-6;
/// Minimum share of unabsorbed readings.
const LEAST_FREEDOM: f64 = 0.05;
/// Residuals agree with the description up to this many standard deviations of their own spread.
const AGREES: f64 = 3.0;
/// Degrees of freedom below which the spread is the root mean square of all residuals. With 9 (11 readings of a line), a normal data set in some hundred has
/// weights that lock on to a part of the readings: its uncertainty is then several times too small.
const FEW: f64 = 10.0;
/// Degrees of freedom from which Student's t is that of a normal distribution to 1.3 %.
const MANY: f64 = 100.0;
/// Standard deviations of a normal distribution around 95 % of it.
const NORMAL_95: f64 = 1.959_963_984_540_054;
/// Relative change at which the noise has converged.
const SAME_SIGMA: f64 = 1e-3;

/// The groups of all measurements: lengths of the first one, its angles, lengths of the second one, …
#[derive(Clone, Debug)]
pub(super) struct NoiseGroups(Vec<Group>);

#[derive(Clone, Copy, Debug)]
struct Group {
    given: Option<f64>,
    /// Noise of the steps of the display: if most readings are one number, the median of the residuals is no spread.
    of_steps: f64,
    /// The spread for the robust weights.
    scale: f64,
    sigma: f64,
    /// Factor of the uncertainties that follow from a spread of few residuals.
    widening: f64,
    /// True if all readings count with equal weights.
    is_even: bool,
}

/// The group of an equation.
pub(super) fn group_of(line: &ReadingEquation) -> usize {
    2 * line.set + usize::from(line.is_angle)
}

impl NoiseGroups {
    pub(super) fn new(data: &[DataSet]) -> NoiseGroups {
        let group = |set: &DataSet, is_angle: bool| {
            let (given, first) = if is_angle { (set.sigma_rad, FIRST_ANGLE_SIGMA) } else { (set.sigma, FIRST_SIGMA) };
            let sigma = given.unwrap_or(first);
            Group {
                given,
                of_steps: display::noise_of(set, is_angle),
                scale: sigma,
                sigma,
                widening: 1.0,
                is_even: false,
            }
        };
        NoiseGroups(data.iter().flat_map(|set| [group(set, false), group(set, true)]).collect())
    }

    pub(super) fn groups(&self) -> usize {
        self.0.len()
    }

    /// Standard uncertainty of the readings of a group.
    pub(super) fn sigma(&self, group: usize) -> f64 {
        self.0.get(group).map_or(FIRST_SIGMA, |group| group.sigma)
    }

    /// Standard uncertainty of the readings of a group in the covariance: two of those that follow from it are a 95 % interval.
    pub(super) fn widened(&self, group: usize) -> f64 {
        self.0.get(group).map_or(FIRST_SIGMA, |group| group.sigma * group.widening)
    }

    /// Spread of the residuals of a group, or the described one if larger.
    pub(super) fn scale(&self, group: usize) -> f64 {
        self.0.get(group).map_or(FIRST_SIGMA, |group| group.scale)
    }

    /// The weight of a reading by its residual.
    pub(super) fn weight(&self, line: &ReadingEquation, is_early: bool) -> f64 {
        let group = self.0.get(group_of(line)).filter(|group| !group.is_even);
        group.map_or(1.0, |group| weight(line.residual / group.scale, is_early))
    }

    /// Updates the noise from residuals; `used` is the number of unknowns absorbed by each group. Returns `true` if it is unchanged.
    pub(super) fn update(&mut self, lines: &[ReadingEquation], used: &[f64], robust: bool) -> bool {
        let mut residuals: Vec<Vec<f64>> = vec![Vec::new(); self.0.len()];
        for line in lines.iter().filter(|line| line.row().is_some()) {
            if let Some(own) = residuals.get_mut(group_of(line)) {
                own.push(line.residual);
            }
        }
        let mut is_same = true;
        for (number, ((group, own), used)) in self.0.iter_mut().zip(&residuals).zip(used).enumerate() {
            let least = LEAST_SIGMA * if number % 2 == 0 { FIRST_SIGMA } else { FIRST_ANGLE_SIGMA };
            let count = own.len() as f64;
            if count == 0.0 {
                continue;
            }
            // Unknowns that follow the noise make residuals smaller than the noise.
            let freedom = (1.0 - used / count).max(LEAST_FREEDOM);
            group.is_even = group.given.is_none() && count * freedom < FEW;
            let (scale, found) = if robust && !group.is_even {
                let scale = spread(own.iter().copied()) / freedom.sqrt();
                let scale = scale.max(group.given.unwrap_or(0.0)).max(group.of_steps).max(least);
                (scale, tempered(own, scale) / freedom.sqrt())
            } else {
                let found = (own.iter().map(|residual| residual * residual).sum::<f64>() / count / freedom).sqrt();
                (found.max(least), found.max(group.of_steps))
            };
            let agrees = 1.0 + AGREES / (2.0 * count * freedom).sqrt();
            let (sigma, widening) = match group.given {
                Some(given) if found <= agrees * given => (given, 1.0),
                _ if count * freedom >= MANY => (found.max(least), 1.0),
                _ => (found.max(least), student::limit(0.05, count * freedom) / NORMAL_95),
            };
            group.widening = widening;
            is_same &= (sigma - group.sigma).abs() <= SAME_SIGMA * sigma;
            (group.scale, group.sigma) = (scale, sigma);
        }
        is_same
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::design::EquationOrigin;

    /// The uncertainty of eight readings, half of which are absorbed, described as 1 µm, for this residual spread except for rounding.
    fn sigma(found: f64) -> f64 {
        let group = Group { given: Some(1e-3), of_steps: 0.0, scale: 1e-3, sigma: 1e-3, widening: 1.0, is_even: false };
        let mut noise = NoiseGroups(vec![group; 2]);
        let residual = found * 0.5_f64.sqrt();
        let line = |row| ReadingEquation { residual, set: 0, origin: EquationOrigin::Row(row), is_angle: false };
        noise.update(&(0..8).map(line).collect::<Vec<_>>(), &[4.0, 0.0], false);
        noise.sigma(0)
    }

    #[test]
    fn residuals_agree_with_what_is_described_up_to_their_own_spread() {
        // Four degrees of freedom determine a standard deviation to 1/√8: three of these are 1.06 of it.
        assert_eq!(sigma(2e-3), 1e-3);
        assert!((sigma(2.1e-3) - 2.1e-3).abs() < 1e-12);
    }
}
