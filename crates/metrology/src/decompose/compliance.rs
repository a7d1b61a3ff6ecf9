//! Compliances: the dynamic remainder explained by the accelerations of axes.
//!
//! Candidates are the components of every accelerating axis, driven by its acceleration or jerk: the effect of a body's compliance under its own
//! inertia on the tool, through the machine's chain. Accelerations are second differences of encoders over some samples, which are weighted means;
//! the residual is averaged with the same weights, so that peaks are not underestimated. Candidates are added one by one as long as they predict runs
//! to which they were not fitted: each feed is held out in turn.

use nalgebra::{DMatrix, DVector};

use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::numeric::in_parts;
use ncfix_model::Model;
use ncfix_model::name::{DIRECTIONS, ErrorName};

use super::poses::RunPoses;
use super::signal::{inflation, triangle};

/// Minimum relative reduction of the sum of squares of holdout runs for a displacement proportional to the acceleration.
const LEAST_GAIN: f64 = 0.02;
/// Minimum reduction for angles, which resemble displacements on a short path, and for jerks.
const FARFETCHED_GAIN: f64 = 0.05;
/// Minimum amount in standard uncertainties.
const LEAST_SIGMAS: f64 = 5.0;
/// Smallest largest deflection over all runs, mm: half of 0.1 µm, the finest increment of a control (IS-C). No program can use less.
const LEAST_MM: f64 = 5e-5;
/// Maximum number of selected candidates.
const MOST: usize = 12;

/// A compliance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compliance {
    /// The component; its axis is the one that accelerates.
    pub name: ErrorName,
    /// 2 for acceleration, 3 for jerk.
    pub order: u8,
    /// mm or rad per mm/s² or rad/s² (s³).
    pub value: f64,
    /// Its standard uncertainty.
    pub uncertainty: f64,
    /// Relative reduction of the RMS residual of holdout runs when it was added.
    pub gain: f64,
}

/// A run whose remainder is to be explained.
#[derive(Clone, Copy, Debug)]
pub struct Remainder<'a> {
    /// Its samples.
    pub poses: &'a RunPoses,
    /// Residual after everything else, mm.
    pub left: &'a [Option<Vector>],
    /// Index of the fold: runs of one feed have the same.
    pub fold: usize,
}

/// Result.
#[derive(Clone, Debug, Default)]
pub struct Compliances {
    /// In the order of their addition.
    pub all: Vec<Compliance>,
    /// RMS residual of every fold, averaged as accelerations are, mm: without compliances, and as predicted from the other folds.
    pub held_out: Vec<[f64; 2]>,
}

/// The sums of products of a run.
#[derive(Clone, Debug)]
struct Products {
    fold: usize,
    /// Of the columns with each other; the remainder is the last one.
    matrix: DMatrix<f64>,
    readings: f64,
    /// Effective sample size reduction due to autocorrelation.
    alike: f64,
}

/// Determines compliances.
#[must_use]
pub fn compliances(model: &Model, axes: &[Axis], tool_mm: &Vector, runs: &[Remainder<'_>]) -> Compliances {
    let moving = axes.iter().copied().filter(|&axis| runs.iter().any(|run| run.poses.accelerate(axis)));
    let candidates: Vec<(ErrorName, u8)> = moving
        .flat_map(|axis| DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)))
        .flat_map(|name| [(name, 2), (name, 3)])
        .collect();
    let products = in_parts(runs, &|run| products(model, &candidates, tool_mm, run));
    let folds = runs.iter().map(|run| run.fold + 1).max().unwrap_or(0);
    if folds < 2 || candidates.is_empty() {
        return Compliances::default();
    }
    let search = Search { products: &products, last: candidates.len(), folds };
    let mut chosen: Vec<usize> = Vec::new();
    let mut gains: Vec<f64> = Vec::new();
    let mut now: f64 = search.left_out(&chosen).map_or(0.0, |parts| parts.iter().sum());
    while chosen.len() < MOST && now > 0.0 {
        let with = |candidate: usize| {
            let mut trial = chosen.clone();
            trial.push(candidate);
            let left: f64 = search.left_out(&trial)?.iter().sum();
            let far = candidates[candidate].0.direction.is_rotation() || candidates[candidate].1 == 3;
            let gain = 1.0 - left / now;
            (gain > if far { FARFETCHED_GAIN } else { LEAST_GAIN }).then_some((candidate, left, gain, far))
        };
        let mut better: Vec<_> = (0..candidates.len()).filter(|k| !chosen.contains(k)).filter_map(with).collect();
        // The usual candidate has priority if it explains almost as much.
        better.sort_by(|a, b| b.2.total_cmp(&a.2));
        let most = better.first().map_or(0.0, |best| best.2);
        let usual = better.iter().position(|one| !one.3 && one.2 > 0.9 * most).unwrap_or(0);
        let Some(&(candidate, left, _, _)) = better.get(usual) else { break };
        chosen.push(candidate);
        gains.push(1.0 - (left / now).sqrt());
        now = left;
    }
    // Candidates that are redundant or due to noise are removed again.
    loop {
        let Some((values, errors)) = search.solve(&chosen, None) else { return Compliances::default() };
        let weakest = (0..chosen.len())
            .map(|k| (k, values[k].abs() / errors[k]))
            .filter(|(_, sigmas)| *sigmas < LEAST_SIGMAS)
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((place, _)) = weakest {
            chosen.remove(place);
            gains.remove(place);
            continue;
        }
        let largest = |k: usize| {
            let one =
                |run: &Remainder<'_>, number| effect(model, candidates[chosen[k]], tool_mm, run.poses, number).norm();
            let of_run = |run: &Remainder<'_>| (0..run.poses.count()).map(|at| one(run, at)).fold(0.0, f64::max);
            values[k].abs() * runs.iter().map(of_run).fold(0.0, f64::max)
        };
        if let Some(place) = (0..chosen.len()).find(|&k| largest(k) < LEAST_MM) {
            chosen.remove(place);
            gains.remove(place);
            continue;
        }
        let all = chosen.iter().enumerate().map(|(k, &candidate)| {
            let (name, order) = candidates[candidate];
            Compliance { name, order, value: values[k], uncertainty: errors[k], gain: gains[k] }
        });
        let all: Vec<Compliance> = all.collect();
        return Compliances { held_out: search.held_out(&chosen), all };
    }
}

/// Effect of a unit acceleration (or jerk) of a candidate's axis at a sample, times the rate there, mm.
fn effect(model: &Model, (name, order): (ErrorName, u8), tool_mm: &Vector, poses: &RunPoses, number: usize) -> Vector {
    let rates = if order == 2 { &poses.acceleration } else { &poses.jerk };
    let rate = name.axis().map_or(0.0, |axis| rates[number][axis]);
    poses.effect(model, name, tool_mm, number) * rate
}

/// Effect of compliances at a sample, mm; averaged over the reach of the poses.
#[must_use]
pub fn deflection(model: &Model, all: &[Compliance], tool_mm: &Vector, poses: &RunPoses, number: usize) -> Vector {
    all.iter().map(|one| effect(model, (one.name, one.order), tool_mm, poses, number) * one.value).sum()
}

fn products(model: &Model, candidates: &[(ErrorName, u8)], tool_mm: &Vector, run: &Remainder<'_>) -> Products {
    let (poses, reach) = (run.poses, run.poses.reach);
    let columns = candidates.len() + 1;
    let smooth: Vec<Vec<f64>> = (0..3)
        .map(|k| {
            let values: Vec<f64> = run.left.iter().map(|left| left.map_or(0.0, |left| left[k])).collect();
            triangle(&values, reach)
        })
        .collect();
    let is_there = |k: usize| run.left.get(k).is_some_and(Option::is_some);
    let inside = reach..poses.count().saturating_sub(reach);
    let used: Vec<usize> = inside.filter(|&k| is_there(k - reach) && is_there(k) && is_there(k + reach)).collect();
    let mut matrix = DMatrix::zeros(columns, columns);
    let mut alike = 1.0_f64;
    for (direction, own) in smooth.iter().enumerate() {
        let mut rows = DMatrix::zeros(columns, used.len());
        for (place, &number) in used.iter().enumerate() {
            rows[(columns - 1, place)] = own[number];
        }
        for (column, &candidate) in candidates.iter().enumerate() {
            for (place, &number) in used.iter().enumerate() {
                rows[(column, place)] = effect(model, candidate, tool_mm, poses, number)[direction];
            }
        }
        // A run has its own thermal offset.
        for mut row in rows.row_iter_mut() {
            let mean = row.mean();
            row.add_scalar_mut(-mean);
        }
        matrix += &rows * rows.transpose();
        alike = alike.max(inflation(own));
    }
    Products { fold: run.fold, matrix, readings: 3.0 * used.len() as f64, alike }
}

struct Search<'a> {
    products: &'a [Products],
    /// Index of the remainder.
    last: usize,
    folds: usize,
}

impl Search<'_> {
    /// Amounts and standard uncertainties, from all runs except those of a fold.
    fn solve(&self, chosen: &[usize], without: Option<usize>) -> Option<(DVector<f64>, DVector<f64>)> {
        let count = chosen.len();
        let mut normal = DMatrix::<f64>::zeros(count, count);
        let mut right = DVector::<f64>::zeros(count);
        let (mut squares, mut readings, mut alike) = (0.0, 0.0, 1.0_f64);
        for own in self.products.iter().filter(|own| Some(own.fold) != without) {
            for (row, &a) in chosen.iter().enumerate() {
                right[row] += own.matrix[(a, self.last)];
                for (column, &b) in chosen.iter().enumerate() {
                    normal[(row, column)] += own.matrix[(a, b)];
                }
            }
            squares += own.matrix[(self.last, self.last)];
            readings += own.readings;
            alike = alike.max(own.alike);
        }
        // Columns of unit length: accelerations and angles have very different scales.
        let scale = DVector::from_fn(count, |k, _| normal[(k, k)].max(f64::MIN_POSITIVE).sqrt().recip());
        let scaled = DMatrix::from_fn(count, count, |a, b| normal[(a, b)] * scale[a] * scale[b]);
        let inverse = scaled.cholesky()?.inverse();
        let values = (&inverse * right.component_mul(&scale)).component_mul(&scale);
        let left = (squares - values.dot(&right)).max(0.0);
        let variance = left / (readings - count as f64).max(1.0) * alike;
        let errors = DVector::from_fn(count, |k, _| (variance * inverse[(k, k)]).sqrt() * scale[k]);
        values.iter().all(|value| value.is_finite()).then_some((values, errors))
    }

    /// Residual sums of squares of every fold, predicted from the others.
    fn left_out(&self, chosen: &[usize]) -> Option<Vec<f64>> {
        (0..self.folds)
            .map(|fold| {
                let values = if chosen.is_empty() { DVector::zeros(0) } else { self.solve(chosen, Some(fold))?.0 };
                Some(
                    self.products
                        .iter()
                        .filter(|own| own.fold == fold)
                        .map(|own| self.left(own, chosen, &values))
                        .sum(),
                )
            })
            .collect()
    }

    fn left(&self, own: &Products, chosen: &[usize], values: &DVector<f64>) -> f64 {
        let mut left = own.matrix[(self.last, self.last)];
        for (k, &a) in chosen.iter().enumerate() {
            left -= 2.0 * values[k] * own.matrix[(a, self.last)];
            left += chosen.iter().enumerate().map(|(j, &b)| values[k] * values[j] * own.matrix[(a, b)]).sum::<f64>();
        }
        left.max(0.0)
    }

    fn held_out(&self, chosen: &[usize]) -> Vec<[f64; 2]> {
        let readings: Vec<f64> = (0..self.folds)
            .map(|fold| self.products.iter().filter(|own| own.fold == fold).map(|own| own.readings).sum())
            .collect();
        let rms = |parts: Option<Vec<f64>>| -> Vec<f64> {
            let parts = parts.unwrap_or_else(|| vec![f64::NAN; self.folds]);
            parts.iter().zip(&readings).map(|(sum, count)| (3.0 * sum / count).sqrt()).collect()
        };
        let (before, after) = (rms(self.left_out(&[])), rms(self.left_out(chosen)));
        before.into_iter().zip(after).map(|(before, after)| [before, after]).collect()
    }
}
