//! Positions of the linear axes in each other's columns, or with the opposite sign: the residuals of the readings in that case.

use super::axes::ColumnMeaning;
use super::readings::{Allowance, WeighedReadings};
use super::single::thinned;
use crate::diagnose::scene::{Scene, Through};
use crate::measure::data::DataSet;
use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// Maximum number of rows used.
const ROWS: usize = 400;
/// Minimum number of positions of an axis that moves.
const PLACES: usize = 3;
/// Tolerance of the travel limits, mm.
const BEYOND_MM: f64 = 1.0;

/// Assignments of the positions, the given one first, and the residuals of each other one, by allowed terms.
pub(super) struct Turned {
    pub(super) ways: Vec<ColumnMeaning>,
    pub(super) left: Vec<[f64; 4]>,
}

/// All assignments with every axis inside its travel.
pub(super) fn turned(scene: &Scene<'_>, data: &DataSet) -> Turned {
    let linear: Vec<Axis> = AXES.into_iter().filter(|axis| !axis.is_rotary()).collect();
    let few = thinned(data, ROWS);
    // A constant column is not mistaken for a moving one.
    let moves = |axis: Axis| {
        let mut at: Vec<u64> = few.observations.iter().map(|row| row.reading.position[axis].to_bits()).collect();
        at.sort_unstable();
        at.dedup();
        at.len() >= PLACES
    };
    let there: Vec<usize> = (0..linear.len().min(3)).filter(|&k| moves(linear[k])).collect();
    let mut out = Turned { ways: ColumnMeaning::all().take(1).collect(), left: Vec::new() };
    for way in ColumnMeaning::all().skip(1).filter(|way| way.is_of(&there)) {
        let mut best: Option<[f64; 4]> = None;
        // The directions may have columns of their own, or follow from the positions.
        for with_senses in [false, true] {
            let Some(own) = read_by(&few, &way, &linear, with_senses) else { continue };
            if !is_within(scene.machine, &own) {
                continue;
            }
            let Some(left) = left(scene.machine, &scene.errors, own) else { continue };
            best = Some(best.map_or(left, |best| [0, 1, 2, 3].map(|k| best[k].min(left[k]))));
        }
        if let Some(left) = best {
            out.ways.push(way);
            out.left.push(left);
        }
    }
    out
}

/// The measurement with its positions in other columns; the directions may have columns of their own, or follow from the positions.
pub(super) fn read_in(data: &DataSet, way: &ColumnMeaning) -> Vec<DataSet> {
    let linear: Vec<Axis> = AXES.into_iter().filter(|axis| !axis.is_rotary()).collect();
    [false, true].into_iter().filter_map(|with_senses| read_by(data, way, &linear, with_senses)).collect()
}

fn read_by(data: &DataSet, way: &ColumnMeaning, linear: &[Axis], with_senses: bool) -> Option<DataSet> {
    let mut out = data.clone();
    for (to, from) in out.observations.iter_mut().zip(&data.observations) {
        for k in 0..3 {
            let (axis, of) = (*linear.get(k)?, *linear.get(way.permutation[k])?);
            to.reading.position[axis] = way.sign[k] * from.reading.position[of];
            if with_senses {
                let sense = from.reading.state.direction.get(of.slot()).copied()?;
                *to.reading.state.direction.get_mut(axis.slot())? = if way.sign[k] < 0.0 { -sense } else { sense };
            }
        }
    }
    Some(out)
}

fn is_within(machine: &Machine, data: &DataSet) -> bool {
    machine.axes.iter().flatten().filter(|one| !one.axis.is_rotary()).all(|one| {
        let [low, high] = one.travel.unwrap_or([f64::MIN, f64::MAX]);
        let mut at = data.observations.iter().map(|row| row.reading.position[one.axis]);
        at.all(|at| (low - BEYOND_MM..=high + BEYOND_MM).contains(&at))
    })
}

/// Mean squared residual, in squares of the uncertainty, by allowed terms.
fn left(machine: &Machine, errors: &ErrorModel, data: DataSet) -> Option<[f64; 4]> {
    let sets = [data];
    let scene = Scene::new(machine, errors, &sets).ok()?;
    let readings = WeighedReadings::new(&scene, 0)?;
    let tips = [0, 1, 2].map(|k| scene.factors(Through::Tip(k)));
    Some(Allowance::ALL.map(|beside| {
        let own = readings.beside(&scene, &tips, beside);
        own.map_or(f64::INFINITY, |own| own.left_with(None, 1.0))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn what_is_left_is_in_squares_of_the_uncertainty_by_degrees_of_freedom() {
        let machine = bench::machine();
        // Twice the uncertainty of 1 µm, with alternating sign.
        let um: Vec<f64> = (0..40).map(|k| if k % 2 == 0 { 2.0 } else { -2.0 }).collect();
        let found = left(&machine, &ErrorModel::default(), bench::reads_along_x(&machine, &um)).unwrap();
        assert!((found[0] - 4.0).abs() < 1e-9, "{found:?}");
        // Direction, slope and bend of X explain none of it, and each uses one of 40 degrees of freedom.
        for (left, taken) in found.iter().zip([0.0, 1.0, 2.0, 3.0]) {
            assert!((left / (4.0 * 40.0 / (40.0 - taken)) - 1.0).abs() < 0.01, "{found:?}");
        }
        // A slope over X is explained completely if slopes are allowed.
        let um: Vec<f64> = (0..40).map(|k| f64::from(k) * 0.1 - 1.95).collect();
        let found = left(&machine, &ErrorModel::default(), bench::reads_along_x(&machine, &um)).unwrap();
        assert!(found[0] > 1.0 && found[2] < 1e-9 && found[3] < 1e-9, "{found:?}");
    }
}
