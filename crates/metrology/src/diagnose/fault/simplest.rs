//! Residual of a measurement by the number of usual errors of a machine that are fitted to it, each chosen as the best next one.
//!
//! A column with the wrong sign is a simpler explanation than errors of the machine only if the readings need fewer errors with the other sign. Without
//! this comparison, equal errors of two scales beside a bar of known length look like a wrong sign: the sign mends their common part by chance.

use super::readings::WeighedReadings;
use super::single::{ROWS, thinned};
use crate::diagnose::scene::{Scene, Through};
use crate::measure::data::DataSet;
use ncfix_base::geometry::Axis;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;
use ncfix_model::name::{DIRECTIONS, ErrorName};

/// Maximum number of fitted errors.
const TERMS: usize = 8;
/// Number of errors less that the other assignment must need.
const FEWER: usize = 2;
/// Share of the squares of an effect below which the chosen errors already contain it.
const CONTAINED: f64 = 1e-6;
/// Upper limit of a squared residual, as some readings may be outliers.
const MOST: f64 = 25.0;

/// Thresholds of a comparison, as in the check that uses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thresholds {
    /// Mean squared residual of readings that fit.
    pub(super) fits: f64,
    /// Residuals within this factor are equal.
    pub(super) tie: f64,
    /// Ratio of a clearly worse residual.
    pub(super) worse: f64,
}

/// True if the second measurement needs clearly fewer errors of the machine than the first one. Both hold the same readings with another assignment.
pub(super) fn needs_fewer(
    machine: &Machine,
    errors: &ErrorModel,
    [given, other]: [&DataSet; 2],
    limits: Thresholds,
) -> bool {
    let (Some(given), Some(other)) = (by_terms(machine, errors, given), by_terms(machine, errors, other)) else {
        return false;
    };
    let least = other.iter().copied().fold(f64::INFINITY, f64::min);
    let good = (limits.tie * least).max(limits.fits);
    let Some(terms) = other.iter().position(|left| *left <= good) else { return false };
    let with_more = given.get(terms + FEWER - 1).or(given.last());
    with_more.is_some_and(|left| *left > limits.worse * other[terms].max(least))
}

/// Mean squared residual, in squares of the uncertainty, with 0, 1, 2 … fitted errors.
fn by_terms(machine: &Machine, errors: &ErrorModel, data: &DataSet) -> Option<Vec<f64>> {
    let sets = [thinned(data, ROWS)];
    let scene = Scene::new(machine, errors, &sets).ok()?;
    let readings = WeighedReadings::new(&scene, 0)?;
    let mut left = readings.left();
    let mut columns: Vec<Vec<f64>> = effects(machine, &scene).iter().map(|one| readings.column(one)).collect();
    let mut whole: Vec<f64> = columns.iter().map(|column| dot(column, column)).collect();
    let mut out = Vec::with_capacity(TERMS + 1);
    for terms in 0..=TERMS {
        let squares: f64 = left.iter().map(|left| (left * left).min(MOST)).sum();
        out.push(readings.freedom_beside(terms) * squares / left.len().max(1) as f64);
        let gain = |k: usize| {
            let own = dot(&columns[k], &columns[k]);
            if own > CONTAINED * whole[k] { dot(&columns[k], &left).powi(2) / own } else { 0.0 }
        };
        let best = (0..columns.len()).map(|k| (k, gain(k))).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((best, _)) = best.filter(|(_, gain)| *gain > 0.0) else { break };
        let chosen = columns.swap_remove(best);
        whole.swap_remove(best);
        take(&chosen, &mut left);
        columns.iter_mut().for_each(|column| take(&chosen, column));
    }
    Some(out)
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

/// Removes the part along a column.
fn take(column: &[f64], from: &mut [f64]) {
    let amount = dot(column, from) / dot(column, column);
    from.iter_mut().zip(column).for_each(|(from, column)| *from -= amount * column);
}

/// Effects of the usual errors on all readings: squareness and offsets; errors of each axis that are constant, linear, quadratic or reverse with its
/// direction; a common error of the readings, as of the length of a bar.
fn effects(machine: &Machine, scene: &Scene<'_>) -> Vec<Vec<f64>> {
    let mut out = vec![scene.factors(Through::Reading(false))];
    for axis in machine.axes.iter().flatten().map(|data| data.axis) {
        let shapes = shapes(scene, axis);
        for direction in DIRECTIONS {
            out.push(scene.factors(Through::Component(ErrorName::location(direction, axis))));
            let factors = scene.factors(Through::Component(ErrorName::motion(direction, axis)));
            if factors.iter().all(|factor| *factor == 0.0) {
                continue;
            }
            let times = |shape: &Vec<f64>| {
                let of = scene.items.iter().zip(&factors);
                of.map(|(item, factor)| factor * shape.get(item.row).copied().unwrap_or(0.0)).collect()
            };
            out.extend(shapes.iter().map(times));
        }
    }
    out.retain(|column| column.iter().any(|effect| *effect != 0.0));
    out
}

/// Constant, linear and quadratic over the positions of an axis, and its direction of motion, by row.
fn shapes(scene: &Scene<'_>, axis: Axis) -> [Vec<f64>; 4] {
    let at: Vec<f64> = scene.rows.iter().map(|row| row.position[axis]).collect();
    let [low, high] = at.iter().fold([f64::MAX, f64::MIN], |ends, at| [ends[0].min(*at), ends[1].max(*at)]);
    let (middle, half) = (f64::midpoint(low, high), ((high - low) / 2.0).max(f64::MIN_POSITIVE));
    let along: Vec<f64> = at.iter().map(|at| (at - middle) / half).collect();
    let bent = along.iter().map(|at| at * at).collect();
    let senses = scene.rows.iter().map(|row| row.sense_of(axis)).collect();
    [vec![1.0; at.len()], along, bent, senses]
}
