//! Temperatures: displacement of the tool relative to the workpiece, thermal expansion of scales, angles between axes that change.
//!
//! A body follows a temperature sensor with a time constant; the tested ones grow by about a factor of two.
//!
//! Temperatures are those in the conditions of the rows, as in the model: a body is in equilibrium when its clock begins, and a drift is relative to
//! the zero setting of the instrument at the first row of a set-up in a run. So a cause predicts the same after it is written to the machine file.

use std::collections::HashMap;
use std::sync::Arc;

use super::{Candidate, Cause, Correctable, EffectKind, Values, Weight, own, tip};
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::{Scene, Through};
use crate::measure::data::DataSet;
use ncfix_machine::machine::Condition;
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(super) const DRIFT: Cause = Cause {
    name: "drift with a temperature",
    effect: EffectKind::ThermalDrift,
    made_by: "thermal expansion of spindle, head and column",
    shown_by: "readings of one pose while the spindle runs, with temperatures",
    separate_by: "a cooling run with the spindle off, or random spindle speeds",
    correctable: Correctable::Live,
    propose: drift,
};

pub(in crate::diagnose) const ON: Cause = Cause {
    name: "drift with a temperature that continues from run to run",
    effect: EffectKind::ThermalDrift,
    made_by: "thermal expansion of spindle, head and column, with an instrument not zeroed for each run",
    shown_by: "readings of one pose in several runs that begin at different temperatures",
    separate_by: "zero the instrument at the beginning of each run",
    correctable: Correctable::Live,
    propose: |_, _| {},
};

pub(super) const EXPANSION: Cause = Cause {
    name: "thermal expansion of a scale",
    effect: EffectKind::ThermalExpansion,
    made_by: "thermal expansion of scale, screw, table and workpiece",
    shown_by: "a line measured at two temperatures",
    separate_by: "the same line at another temperature",
    correctable: Correctable::Live,
    propose: expansion,
};

pub(super) const SQUARENESS: Cause = Cause {
    name: "squareness with a temperature",
    effect: EffectKind::ThermalSquareness,
    made_by: "a frame that is warmer on one side",
    shown_by: "a plate measured at two temperatures",
    separate_by: "sensors on both sides of the frame",
    correctable: Correctable::Live,
    propose: squareness,
};

/// Tested time constants, s; 0 is the sensor itself.
const LAGS_S: [f64; 8] = [0.0, 60.0, 180.0, 420.0, 900.0, 1800.0, 3600.0, 7200.0];

/// Maximum number of sensors whose pairs are tested.
const GRADIENTS: usize = 10;

/// A sensor with a lag: rise of a body that follows it, K, by measurement and row, above its reference and since the zero setting of the instrument.
struct Sensor {
    name: String,
    lag_s: f64,
    rise: Values,
    since_zero: Values,
}

fn weight(values: &Values, of: impl Fn(&SceneRow) -> f64 + Send + Sync + 'static) -> Weight {
    let values = Arc::clone(values);
    Weight::new(move |row| values.get(row.set).and_then(|own| own.get(row.number)).map_or(0.0, |value| value * of(row)))
}

impl Sensor {
    fn weight(&self, of: impl Fn(&SceneRow) -> f64 + Send + Sync + 'static) -> Weight {
        weight(&self.rise, of)
    }
}

/// All sensors of a scene, each with every lag that the times allow.
fn sensors(scene: &Scene<'_>) -> Vec<Sensor> {
    let mut names: Vec<&str> = scene
        .sets
        .iter()
        .flat_map(|set| &set.drivers)
        .map(|driver| driver.name.as_str())
        .filter(|name| name.starts_with("T_") && name.ends_with("_C"))
        .collect();
    names.sort_unstable();
    names.dedup();
    names.into_iter().flat_map(|name| LAGS_S.into_iter().filter_map(|lag_s| sensor(scene, name, lag_s))).collect()
}

/// A temperature column followed with a lag, s; `None` for a lag without times.
fn sensor(scene: &Scene<'_>, column: &str, lag_s: f64) -> Option<Sensor> {
    let name = column.strip_suffix("_C")?;
    let of_set = |set: &DataSet| -> Option<[Vec<f64>; 2]> {
        if !set.drivers.iter().any(|driver| driver.name == column) {
            return Some(Default::default());
        }
        if lag_s > 0.0 && set.observations.iter().any(|one| one.t_s.is_none()) {
            return None;
        }
        let rises_k = |all: &[&Condition]| scene.machine.rises_k(all, name, lag_s);
        let zeros: Vec<Option<&Condition>> = set.conditions.iter().map(Condition::zero).collect();
        let mut of_zeros = rises_k(&zeros.iter().copied().flatten().collect::<Vec<_>>()).into_iter();
        let at_zeros = zeros.iter().map(|zero| match zero {
            Some(_) => of_zeros.next().flatten().unwrap_or(f64::NAN),
            None => 0.0,
        });
        let rises = rises_k(&set.conditions.iter().collect::<Vec<_>>());
        let rises = rises.into_iter().map(|rise| rise.unwrap_or(f64::NAN));
        let own: Vec<[f64; 2]> = rises.zip(at_zeros).map(|(rise, at_zero)| [rise, rise - at_zero]).collect();
        let at = |k: usize| {
            let of = |one: &crate::measure::data::Observation| own.get(one.condition).map_or(f64::NAN, |both| both[k]);
            set.observations.iter().map(of).collect()
        };
        Some([at(0), at(1)])
    };
    let all: Option<Vec<[Vec<f64>; 2]>> = scene.sets.iter().map(of_set).collect();
    let (rise, since_zero) = all?.into_iter().map(|[rise, since_zero]| (rise, since_zero)).unzip();
    Some(Sensor { name: column.to_owned(), lag_s, rise: Arc::new(rise), since_zero: Arc::new(since_zero) })
}

/// Rise of a temperature column at each row, K, by measurement: above its reference, and since the zero setting of the instrument; followed with a
/// time constant, s. `None` for a lag without times.
pub(in crate::diagnose) fn rises(scene: &Scene<'_>, column: &str, lag_s: f64) -> Option<[Values; 2]> {
    sensor(scene, column, lag_s).map(|sensor| [sensor.rise, sensor.since_zero])
}

/// True if a set-up has several runs. Then the instrument may or may not have been set to zero for each run.
fn has_runs(scene: &Scene<'_>) -> bool {
    let mut runs: HashMap<(usize, usize), usize> = HashMap::new();
    scene.rows.iter().any(|row| *runs.entry((row.set, row.setup)).or_insert(row.run) != row.run)
}

/// Range of time constants around `lag_s`, s: the neighbors of a tested value, or a factor of two around a refined one.
pub(in crate::diagnose) fn around(lag_s: f64) -> Option<[f64; 2]> {
    if lag_s > 0.0 && !LAGS_S.contains(&lag_s) {
        return Some([lag_s / 2.0, 2.0 * lag_s]);
    }
    let place = LAGS_S.iter().position(|own| *own == lag_s).filter(|place| *place > 0)?;
    let below = LAGS_S.get(place - 1).copied().filter(|lag| *lag > 0.0).unwrap_or(lag_s / 3.0);
    Some([below, LAGS_S.get(place + 1).copied().unwrap_or(2.0 * lag_s)])
}

/// The candidate with another time constant, s; `None` if it has no time constant.
pub(in crate::diagnose) fn with_lag(scene: &Scene<'_>, one: &Candidate, lag_s: f64) -> Option<Candidate> {
    let sensor = sensor(scene, one.sensor.as_deref()?, lag_s)?;
    let (through, _) = one.columns.first()?.first()?;
    let even = || sensor.weight(|_| 1.0);
    let weights = match (one.cause.effect, through) {
        (EffectKind::ThermalDrift, _) if one.cause.name == ON.name => vec![even()],
        (EffectKind::ThermalDrift, _) => vec![weight(&sensor.since_zero, |_| 1.0)],
        (EffectKind::ThermalSquareness, _) if one.drivers.len() == 1 => vec![even()],
        (EffectKind::ThermalExpansion, Through::Component(name)) => {
            let axis = name.axis()?;
            vec![sensor.weight(move |row| row.position[axis]), even()]
        }
        _ => return None,
    };
    let columns = weights.into_iter().take(one.columns.len()).map(|weight| vec![(*through, weight)]).collect();
    Some(Candidate { columns, constant: Some((lag_s, "s")), ..one.clone() })
}

fn named(mut one: Candidate, sensor: &Sensor, drivers: &[String]) -> Candidate {
    one.drivers = std::iter::once(sensor.name.clone()).chain(drivers.iter().cloned()).collect();
    one.constant = (sensor.lag_s > 0.0).then_some((sensor.lag_s, "s"));
    one.sensor = Some(sensor.name.clone());
    one
}

fn drift(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let has_runs = has_runs(scene);
    for sensor in sensors(scene) {
        let of_cause = [(&DRIFT, &sensor.since_zero), (&ON, &sensor.rise)];
        for (cause, values) in of_cause.into_iter().take(if has_runs { 2 } else { 1 }) {
            let weight = weight(values, |_| 1.0);
            for direction in 0..3 {
                let one = Candidate::one(cause, tip(direction), Through::Tip(direction), weight.clone());
                out.push(named(one, &sensor, &[]));
            }
        }
    }
}

fn expansion(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes: Vec<_> = super::linear(scene).filter(|&axis| super::range(scene, axis).is_some()).collect();
    if axes.is_empty() {
        return;
    }
    for sensor in sensors(scene) {
        for &axis in &axes {
            let through = Through::Component(own(axis));
            let one = Candidate::one(&EXPANSION, own(axis), through, sensor.weight(move |row| row.position[axis]));
            let one = named(one, &sensor, &[axis.to_string()]);
            let mut fixed = one.clone();
            // The position of its fixed point is unknown.
            fixed.columns.push(vec![(through, sensor.weight(|_| 1.0))]);
            out.push(one);
            out.push(fixed);
        }
    }
}

/// Proposes nothing for readings at one position: they show no angles.
fn squareness(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes: Vec<_> = super::linear(scene).collect();
    if axes.iter().filter(|&&axis| super::range(scene, axis).is_some()).count() < 2 {
        return;
    }
    let sensors = sensors(scene);
    let names = || {
        axes.iter().flat_map(|&axis| {
            let rotations = DIRECTIONS.into_iter().filter(|direction| direction.is_rotation());
            rotations.map(move |direction| ErrorName::location(direction, axis))
        })
    };
    for sensor in &sensors {
        let weight = sensor.weight(|_| 1.0);
        for name in names() {
            out.push(named(Candidate::one(&SQUARENESS, name, Through::Component(name), weight.clone()), sensor, &[]));
        }
    }
    // A gradient: two sensors without lag.
    let plain: Vec<&Sensor> = sensors.iter().filter(|sensor| sensor.lag_s == 0.0).take(GRADIENTS).collect();
    for (place, one) in plain.iter().enumerate() {
        for other in plain.iter().skip(place + 1) {
            let values = Arc::clone(&other.rise);
            let at = move |row: &SceneRow| {
                values.get(row.set).and_then(|own| own.get(row.number)).copied().unwrap_or(f64::NAN)
            };
            let values = Arc::clone(&one.rise);
            let weight = Weight::new(move |row| {
                let own = values.get(row.set).and_then(|own| own.get(row.number)).copied().unwrap_or(f64::NAN);
                own - at(row)
            });
            for name in names() {
                let candidate = Candidate::one(&SQUARENESS, name, Through::Component(name), weight.clone());
                out.push(named(candidate, one, std::slice::from_ref(&other.name)));
            }
        }
    }
}
