//! Slopes that make straightness errors straight on average over the measured range of their axis.
//!
//! The direction of a linear axis is that of its mean line, a least-squares line (ISO 230-1). A polynomial without a linear term refers to its tangent at the
//! zero of the axis instead. Where no reading shows the direction of the axes, a rotation of all of them has no effect on the readings: it changes the slope
//! of one axis, the squareness, and the places of the set-ups together. The fit then has the frame of the tangents, and these slopes lead to that of the mean
//! lines.

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::State;
use ncfix_model::ErrorModel;
use ncfix_model::parameter::ParameterName;

/// Number of points of the line, enough for curves of degree 9.
const POINTS: u32 = 200;

/// A slope that follows from the fitted curve of a straightness.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanLine {
    /// The slope: `EYX1`.
    pub slope: ParameterName,
    /// The range of the axis over which the mean slope is zero, mm.
    pub range: [f64; 2],
    /// Columns of the fit with the parameters of the curve, each with its mean slope per unit.
    pub curve: Vec<(usize, f64)>,
    /// Columns of the fit, each with the change that has the effect of one unit of the slope on all readings.
    pub carriers: Vec<(usize, f64)>,
    /// Standard uncertainty of the direction of the axis, rad: how far the mean line over the travel may differ from that over the range.
    pub turn: f64,
}

impl MeanLine {
    /// The slope that makes the curve straight on average, rad, for the values of the columns.
    fn slope_for(&self, values: &[f64]) -> f64 {
        -self.curve.iter().map(|&(column, slope)| slope * values.get(column).copied().unwrap_or(0.0)).sum::<f64>()
    }
}

/// Refers the values of the columns of a fit to the mean lines, and appends the slopes. `errors` are those of the fit: the values refer to its slopes.
pub fn level(lines: &[MeanLine], errors: &ErrorModel, values: &mut Vec<f64>) {
    let slopes: Vec<f64> = lines.iter().map(|line| line.slope_for(values)).collect();
    for (line, slope) in lines.iter().zip(&slopes) {
        let change = slope - line.slope.get(errors);
        for &(column, share) in &line.carriers {
            values.get_mut(column).into_iter().for_each(|value| *value -= share * change);
        }
    }
    values.extend(slopes);
}

/// Refers the factor of the covariance of the parameters of a fit to the mean lines, and appends the rows of the slopes. The turn of each line is a cause of
/// its own.
pub fn level_factor(lines: &[MeanLine], factor: &mut Vec<Vec<f64>>) {
    let width = factor.iter().map(Vec::len).max().unwrap_or(0);
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut causes = width;
    for line in lines {
        let mut row = vec![0.0; width];
        for &(column, slope) in &line.curve {
            let own = factor.get(column).into_iter().flatten();
            row.iter_mut().zip(own).for_each(|(sum, part)| *sum -= slope * part);
        }
        if line.turn > 0.0 {
            row.resize(causes, 0.0);
            row.push(line.turn);
            causes += 1;
        }
        rows.push(row);
    }
    for (line, row) in lines.iter().zip(&rows) {
        for &(column, share) in &line.carriers {
            let Some(own) = factor.get_mut(column) else { continue };
            if own.len() < row.len() {
                own.resize(row.len(), 0.0);
            }
            own.iter_mut().zip(row).for_each(|(part, change)| *part -= share * change);
        }
    }
    factor.extend(rows);
}

/// Slope of the least-squares line through the curve of one unit of a parameter, over a range of its axis, per mm.
#[must_use]
pub fn mean_slope(name: &ParameterName, axis: Axis, [low, high]: [f64; 2]) -> f64 {
    let middle = f64::midpoint(low, high);
    let mut sums = [0.0; 2];
    for at in points([low, high]) {
        sums[0] += value(name, axis, at) * (at - middle);
        sums[1] += (at - middle).powi(2);
    }
    sums[0] / sums[1]
}

/// Largest slope of the curve of some parameters with their values, between neighboring points of a range, per mm.
#[must_use]
pub fn steepest(curve: &[(ParameterName, f64)], axis: Axis, range: [f64; 2]) -> f64 {
    let heights: Vec<(f64, f64)> =
        points(range).map(|at| (at, curve.iter().map(|(name, amount)| amount * value(name, axis, at)).sum())).collect();
    let slopes = heights.windows(2).map(|two| (two[1].1 - two[0].1) / (two[1].0 - two[0].0));
    slopes.fold(0.0, |most: f64, slope: f64| most.max(slope.abs()))
}

fn points([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..POINTS).map(move |k| low + (high - low) * (f64::from(k) + 0.5) / f64::from(POINTS))
}

fn value(name: &ParameterName, axis: Axis, at: f64) -> f64 {
    let mut command = AxisVector::default();
    command[axis] = at;
    name.weight(&command, &State::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(text: &str) -> ParameterName {
        text.parse().unwrap()
    }

    #[test]
    fn a_bow_far_from_the_zero_hands_its_slope_to_the_squareness() {
        // The least-squares line of x² over 100 … 500 has the slope 2 · 300, that of x³ 3 · 300² + 3/5 · 200² = 294 000.
        let range = [100.0, 500.0];
        assert!((mean_slope(&name("EYX2"), Axis::X, range) - 600.0).abs() < 1e-6);
        assert!((mean_slope(&name("EYX3"), Axis::X, range) - 294_000.0).abs() < 3.0);
        let line = MeanLine {
            slope: name("EYX1"),
            range,
            curve: vec![(1, 600.0)],
            // The effect of a slope is that of the opposite squareness, column 0, and of a shift of the ball by 250 mm per unit, column 2.
            carriers: vec![(0, -1.0), (2, 250.0)],
            turn: 0.0,
        };
        let mut values = vec![50e-6, 1e-7, 0.0];
        level(std::slice::from_ref(&line), &ErrorModel::default(), &mut values);
        // The slope is −60 µrad: the squareness of 50 µrad becomes −10 µrad, and the ball moves by 0.015 mm.
        let expected = [-10e-6, 1e-7, 0.015, -60e-6];
        assert!(values.iter().zip(expected).all(|(one, other)| (one - other).abs() < 1e-12), "{values:?}");
        // Uncertainties: 3 µrad of the squareness alone, and 1e-8 of the bow, of which −600e-8 reach the slope.
        let mut factor = vec![vec![3e-6], vec![0.0, 1e-8]];
        level_factor(std::slice::from_ref(&line), &mut factor);
        let expected = [vec![3e-6, -6e-6], vec![0.0, 1e-8], vec![0.0, -6e-6]];
        let is_near = |one: &Vec<f64>, other: &Vec<f64>| {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-15)
        };
        assert!(factor.iter().zip(&expected).all(|(one, other)| is_near(one, other)), "{factor:?}");
        // A turn of 2 µrad is a cause of its own.
        let mut factor = vec![vec![3e-6], vec![0.0, 1e-8]];
        level_factor(&[MeanLine { turn: 2e-6, ..line }], &mut factor);
        assert!(is_near(&factor[2], &vec![0.0, -6e-6, 2e-6]) && is_near(&factor[0], &vec![3e-6, -6e-6, 2e-6]));
    }

    #[test]
    fn the_steepest_place_of_a_bow_is_its_end() {
        // x² − 500 x over 0 … 500: the slope at the ends is ±500, between the last two points 2.5 mm apart 495.
        let curve = [(name("EYX2"), 1.0), (name("EYX1"), -500.0)];
        assert!((steepest(&curve, Axis::X, [0.0, 500.0]) - 495.0).abs() < 1e-6);
    }
}
