//! The part that a single cause of the machine explains. A fault of the data is reported only if no cause explains it equally well.

use super::readings::WeighedReadings;
use crate::diagnose::scene::{Scene, Through};
use crate::measure::data::DataSet;
use ncfix_machine::machine::Machine;
use ncfix_model::name::{DIRECTIONS, ErrorName};

/// Maximum number of rows of a measurement.
pub(super) const ROWS: usize = 300;
/// Upper limit of a residual, in σ, as a few readings may be outliers.
pub(super) const MOST: f64 = 5.0;

/// Residuals of all measurements in sequence, in units of the uncertainty.
#[derive(Debug)]
pub(super) struct SingleResiduals {
    pub(super) values: Vec<f64>,
    pub(super) squares: f64,
    /// The same values without the limit, and the limit.
    raw: Vec<f64>,
    most: f64,
}

/// At most this number of rows, evenly selected.
pub(super) fn thinned(data: &DataSet, most: usize) -> DataSet {
    let count = data.observations.len();
    let mut out = data.clone();
    if count > most {
        let rows = || (0..most).map(|k| k * count / most);
        out.observations = rows().filter_map(|row| data.observations.get(row).copied()).collect();
        for (driver, all) in out.drivers.iter_mut().zip(&data.drivers) {
            driver.values = rows().map(|row| all.values.get(row).copied().unwrap_or(f64::NAN)).collect();
        }
    }
    out
}

/// Residuals of measurements for a machine with the known errors, each limited to `most`, in σ.
pub(super) fn left(machine: &Machine, scene: &Scene<'_>, sets: &[DataSet], most: f64) -> Option<SingleResiduals> {
    let own = Scene::new(machine, &scene.errors, sets).ok()?;
    let raw: Vec<f64> =
        (0..sets.len()).filter_map(|set| WeighedReadings::new(&own, set)).flat_map(|one| one.left()).collect();
    let values: Vec<f64> = raw.iter().map(|left| left.clamp(-most, most)).collect();
    let squares = values.iter().map(|left| left * left).sum();
    Some(SingleResiduals { values, squares, raw, most })
}

/// Sum of squared residuals with the best single cause: an error of one axis that is constant, linear, quadratic or reverses with the direction.
pub(super) fn by_one_cause(machine: &Machine, sets: &[DataSet], as_is: &SingleResiduals) -> f64 {
    let Ok(scene) = Scene::new(machine, &ncfix_model::ErrorModel::default(), sets) else { return 0.0 };
    let readings: Vec<WeighedReadings> = (0..sets.len()).filter_map(|set| WeighedReadings::new(&scene, set)).collect();
    let mut least = as_is.squares;
    for axis in machine.axes.iter().flatten().map(|data| data.axis) {
        let at = |row: usize| scene.rows.get(row).map_or(0.0, |row| row.position[axis]);
        let ends =
            (0..scene.rows.len()).map(at).fold([f64::MAX, f64::MIN], |ends, at| [ends[0].min(at), ends[1].max(at)]);
        let (middle, half) = (f64::midpoint(ends[0], ends[1]), ((ends[1] - ends[0]) / 2.0).max(f64::MIN_POSITIVE));
        for direction in DIRECTIONS {
            let factors = scene.factors(Through::Component(ErrorName::motion(direction, axis)));
            for shape in 0..4 {
                let weight = |row: usize| {
                    let along = (at(row) - middle) / half;
                    match shape {
                        0 => 1.0,
                        1 => along,
                        2 => along * along,
                        _ => scene.rows.get(row).map_or(0.0, |row| row.sense_of(axis)),
                    }
                };
                let column: Vec<f64> = factors
                    .iter()
                    .zip(&scene.items)
                    .map(|(factor, item)| if *factor == 0.0 { 0.0 } else { factor * weight(item.row) })
                    .collect();
                let does: Vec<f64> = readings.iter().flat_map(|one| one.column(&column)).collect();
                let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                let squares = sum(&does, &does);
                if squares > 0.0 {
                    least = least.min(as_is.squares - sum(&does, &as_is.values).powi(2) / squares);
                    // A large error exceeds the limit at its ends, so its own residual is limited.
                    let amount = sum(&does, &as_is.raw) / squares;
                    let left = as_is
                        .raw
                        .iter()
                        .zip(&does)
                        .map(|(raw, does)| (raw - amount * does).clamp(-as_is.most, as_is.most));
                    least = least.min(left.map(|left| left * left).sum());
                }
            }
        }
    }
    least
}
