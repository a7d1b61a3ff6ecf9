//! The delay between the clock of the instrument and that of the control.
//!
//! The readings are the encoder positions of tool and ball, plus smooth errors, and deflections proportional to accelerations. The delay is estimated
//! together with all of these: the first guess from the correlation of changes, the rest by Gauss–Newton with the slope of the readings as one more
//! column. There is one delay for all runs, because a slow run has little information; delays of single runs are for information.

use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::numeric::System;

use super::basis::{Basis, Smooth};
use super::grid::RunGrid;
use super::poses::RunPoses;
use super::signal::{inflation, triangle};

/// Largest clock difference of the first guess, s.
const MOST_S: f64 = 0.5;
/// Interval over which changes are compared, s.
const CHANGE_S: f64 = 0.03;
/// Minimum correlation for a guess.
const LEAST: f64 = 0.3;
/// Degree of the smooth errors.
const DEGREE: usize = 4;
/// Maximum number of fitted samples.
const SAMPLES: usize = 12_000;
/// Maximum Gauss–Newton steps, and their convergence limit, s.
const STEPS: usize = 12;
const CLOSE_S: f64 = 1e-7;
/// Tolerance at the ends of a recording, s.
const EDGE_S: f64 = 1e-9;

/// A delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// A reading belongs to the encoder position this much earlier, by the recorded clocks, s.
    pub delay_s: f64,
    /// Its standard uncertainty, s.
    pub uncertainty_s: f64,
    /// Delay and uncertainty of every run alone.
    pub by_run: Vec<(f64, f64)>,
}

/// Estimates the delay; `None` if readings and control do not overlap.
#[must_use]
pub fn clock(grids: &[RunGrid], poses: &[RunPoses], axes: &[Axis]) -> Option<Clock> {
    let runs: Vec<(&RunGrid, &RunPoses)> =
        grids.iter().zip(poses).filter(|(grid, _)| !grid.readings.is_empty()).collect();
    let mut delay_s = guess(&runs)?;
    let positions: Vec<_> = runs.iter().flat_map(|(_, poses)| poses.encoder.iter().copied()).collect();
    let basis = Basis::new(Smooth::Pose(DEGREE), axes, &positions);
    let mut uncertainty_s = f64::INFINITY;
    for _ in 0..STEPS {
        let [(change, uncertainty)] = *fit(&runs, &basis, axes, delay_s, false)?.first_chunk()?;
        delay_s += change.clamp(-CHANGE_S, CHANGE_S);
        uncertainty_s = uncertainty;
        if change.abs() < CLOSE_S {
            break;
        }
    }
    let alone = fit(&runs, &basis, axes, delay_s, true)?;
    let by_run = alone.into_iter().map(|(change, uncertainty)| (delay_s + change, uncertainty)).collect();
    Some(Clock { delay_s, uncertainty_s, by_run })
}

/// Reading of a sample, mm; `None` if the instrument did not record.
pub(super) fn reading(grid: &RunGrid, number: usize, delay_s: f64) -> Option<Vector> {
    let at = grid.time(number) + delay_s;
    let [x, y, z] = grid.readings.as_slice() else { return None };
    let inside = at >= x.start_s - EDGE_S && at <= x.start_s + x.duration_s() + EDGE_S;
    inside.then(|| Vector::new(x.at(at), y.at(at), z.at(at)))
}

/// The first guess, by the correlation of changes.
fn guess(runs: &[(&RunGrid, &RunPoses)]) -> Option<f64> {
    let step = runs.first()?.0.step_s;
    let most = (MOST_S / step).ceil() as i32;
    let mut best = (0.0, LEAST);
    let mut overlaps = false;
    for lag in -most..=most {
        let delay = f64::from(lag) * step;
        let (mut both, mut read, mut said) = (0.0, 0.0, 0.0);
        for (grid, poses) in runs {
            let reach = (CHANGE_S / grid.step_s).ceil() as usize;
            for number in (reach..poses.count().saturating_sub(reach)).step_by(3) {
                let ends = [number - reach, number + reach];
                let [Some(low), Some(high)] = ends.map(|k| reading(grid, k, delay)) else { continue };
                let one = high - low;
                let other = poses.nominal[1][ends[1]] - poses.nominal[1][ends[0]];
                both += one.dot(&other);
                read += one.norm_squared();
                said += other.norm_squared();
                overlaps = true;
            }
        }
        let alike = both / (read * said).sqrt();
        if alike > best.1 {
            best = (delay, alike);
        }
    }
    overlaps.then_some(best.0)
}

/// The correction of the delay, with its uncertainty, s; one for all, or one for each run.
fn fit(
    runs: &[(&RunGrid, &RunPoses)],
    basis: &Basis,
    axes: &[Axis],
    delay_s: f64,
    alone: bool,
) -> Option<Vec<(f64, f64)>> {
    let slopes = if alone { runs.len() } else { 1 };
    let first = slopes + runs.len();
    let columns = first + basis.len() + axes.len();
    let all: usize = runs.iter().map(|(_, poses)| poses.count()).sum();
    let every = all.div_ceil(SAMPLES).max(1);
    let mut sums = vec![(0.0, 0.0); slopes];
    for direction in 0..3 {
        let mut system = System::new(columns);
        let mut kept: Vec<(Vec<f64>, f64)> = Vec::new();
        for (run, (grid, poses)) in runs.iter().enumerate() {
            let signal = grid.readings.get(direction)?;
            // Accelerations are means over a reach; the compared values must be averaged equally, or the difference looks like a delay.
            let value = |number: usize| {
                reading(grid, number, delay_s).map_or(0.0, |read| read[direction] - poses.nominal[1][number][direction])
            };
            let values = triangle(&(0..poses.count()).map(value).collect::<Vec<f64>>(), poses.reach);
            let slope = |number: usize| signal.slope(grid.time(number) + delay_s);
            let changes = triangle(&(0..poses.count()).map(slope).collect::<Vec<f64>>(), poses.reach);
            for number in (poses.reach..poses.count().saturating_sub(poses.reach)).step_by(every) {
                let ends = [number - poses.reach, number + poses.reach];
                if ends.iter().any(|&end| reading(grid, end, delay_s).is_none()) {
                    continue;
                }
                let mut row = vec![0.0; first];
                row[if alone { run } else { 0 }] = -changes[number];
                row[slopes + run] = 1.0;
                basis.push(&poses.encoder[number], poses.share[number], &mut row);
                row.extend(axes.iter().map(|&axis| poses.acceleration[number][axis]));
                let value = values[number];
                system.add(&row, value, 1.0);
                kept.push((row, value));
            }
        }
        let solution = system.solve()?;
        let left: Vec<f64> = kept
            .iter()
            .map(|(row, value)| value - row.iter().zip(solution.unknowns.iter()).map(|(a, b)| a * b).sum::<f64>())
            .collect();
        let variance = solution.squares / solution.freedom.max(1) as f64 * inflation(&left);
        for (slope, (sum, weights)) in sums.iter_mut().enumerate() {
            let own = variance * solution.cofactors[(slope, slope)];
            // A direction without changes gives no information.
            if own > 0.0 && own.is_finite() {
                *sum += solution.unknowns[slope] / own;
                *weights += 1.0 / own;
            }
        }
    }
    let found = sums.into_iter().map(|(sum, weights)| {
        if weights > 0.0 { (sum / weights, weights.recip().sqrt()) } else { (0.0, f64::INFINITY) }
    });
    Some(found.collect())
}
