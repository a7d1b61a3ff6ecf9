//! Faults of the data, between the machine and the file: one module each, and their registry ([`Checks`]), which a caller can extend.
//!
//! Faults are searched before causes: otherwise a wrong factor, a stuck sensor or a pulse would be explained by a cause that is not present. Each
//! check reports the fault, its rows and the evidence; [`Then`] defines the consequence for the search. An effect of the machine repeats when axes
//! stand, move or warm up as before, but a fault does not. This separates them.

mod axes;
mod cells;
mod chain;
mod clock;
mod compensated;
mod constant;
mod dead;
mod display;
mod drifting;
mod exchanged;
mod exchanged_positions;
mod fading;
mod fahrenheit;
mod first_cycle;
mod glitch;
mod missing;
mod offset;
mod order;
mod outlier;
mod pulse;
mod quantised;
mod readings;
mod regression;
mod reversed_run;
mod sharp;
mod simplest;
mod single;
mod step;
mod stuck;
mod switched;
mod trail;
mod unit;
mod visits;

use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::fmt;

use serde::{Serialize, Serializer};

use super::scene::{Scene, Through};
use crate::measure::data::DataSet;
use cells::Sensor;
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::condition::change_readings;
use trail::Trail;

/// A kind of fault, and the function that searches for it.
#[derive(Debug)]
pub struct DefectCheck {
    /// Its name.
    pub name: &'static str,
    /// Its origin.
    pub made_by: &'static str,
    /// Its evidence.
    pub shown_by: &'static str,
    /// The source of this knowledge.
    pub source: &'static str,
    /// Searches for it and pushes each fault with its rows and its consequence. Faults from earlier checks are excluded from its view
    /// ([`View::sets`]).
    pub look: fn(&View<'_, '_>, &mut Vec<DataDefect>),
}

/// The kinds of faults to search for, in order: [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
pub type Checks = Register<&'static DefectCheck>;

impl Registered for &'static DefectCheck {
    const KIND: &'static str = "data check";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        FAULTS.iter().map(|&check| Box::new(check)).collect()
    }
}

/// Built-in checks in order; later checks do not use data that earlier ones exclude.
pub const FAULTS: &[&DefectCheck] = &[
    &dead::CHECK,
    &glitch::CHECK,
    &stuck::CHECK,
    &fahrenheit::CHECK,
    &exchanged::CHECK,
    &reversed_run::CHECK,
    &offset::CHECK,
    &clock::CHECK,
    &constant::CHECK,
    &unit::CHECK,
    &chain::CHECK,
    &axes::CHECK,
    &compensated::CHECK,
    &quantised::CHECK,
    &order::CHECK,
    &outlier::CHECK,
    &pulse::CHECK,
    &first_cycle::CHECK,
    &step::CHECK,
];

/// Consequence of a fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Then {
    /// The file does not describe the measurement; it cannot be used.
    Refuse,
    /// The rows are excluded.
    WithoutRows,
    /// These single readings are excluded: row and value, in order.
    WithoutReadings(Vec<(usize, usize)>),
    /// These sensors are not used.
    WithoutSensors(Vec<String>),
    /// Sensors have no readings in some rows, and are used in the others.
    WithoutTemperatures(MissingTemperatures),
    /// The readings of a sensor are converted to °C.
    InFahrenheit(String),
    /// A log with another clock is shifted in time.
    ShiftLog(ShiftedLog),
    /// Readings from the first row on get a zero of their own.
    OwnZero,
    /// The fault is only reported.
    Nothing,
    /// The uncertainty of the readings is increased by this, mm or rad, as a root of the sum of squares.
    MoreNoise(f64),
}

/// Rows in which sensors have no readings.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingTemperatures {
    /// Their columns.
    pub sensors: Vec<String>,
    /// Ranges of rows without their readings: first and last.
    pub pieces: Vec<[usize; 2]>,
    /// The ranges that are too long to be bridged. Their rows are excluded, because causes must be compared in rows with all temperatures.
    pub uncounted: Vec<[usize; 2]>,
}

/// A log whose clock differs from that of the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct ShiftedLog {
    /// Its columns.
    pub columns: Vec<String>,
    /// Its times minus those of the readings, s: positive if its clock is ahead.
    pub by_s: f64,
    /// Ranges of rows that the shifted log does not contain: first and last. They are excluded.
    pub uncounted: Vec<[usize; 2]>,
}

/// Kind of a fault. Results contain its word ([`DefectKind::word`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum DefectKind {
    /// Columns of positions are exchanged or reversed.
    Axes,
    /// Readings belong to other positions than the file states.
    Positions,
    /// A log has another clock than the readings.
    Clock,
    /// A table of the control was active.
    Compensated,
    /// The first cycle differs from the others.
    FirstCycle,
    /// Rows are not in the order in which they were taken.
    Order,
    /// Single readings are far from the others.
    #[default]
    Outlier,
    /// Rows of a short disturbance.
    Pulse,
    /// Readings in coarse steps.
    Quantised,
    /// A constant reading.
    Reading,
    /// A sensor.
    Sensor,
    /// The zero moved.
    Step,
    /// The machine file has another order of the axes than the machine.
    Topology,
    /// Readings are in another unit.
    Unit,
    /// The kind of a custom check, by its name.
    Own(&'static str),
}

impl DefectKind {
    /// Its word in results.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            DefectKind::Axes | DefectKind::Positions => "axes",
            DefectKind::Clock => "clock",
            DefectKind::Compensated => "compensated",
            DefectKind::FirstCycle => "first-cycle",
            DefectKind::Order => "order",
            DefectKind::Outlier => "outlier",
            DefectKind::Pulse => "pulse",
            DefectKind::Quantised => "quantised",
            DefectKind::Reading => "reading",
            DefectKind::Sensor => "sensor",
            DefectKind::Step => "step",
            DefectKind::Topology => "topology",
            DefectKind::Unit => "unit",
            DefectKind::Own(word) => word,
        }
    }
}

impl fmt::Display for DefectKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(self.word())
    }
}

impl Serialize for DefectKind {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.serialize_str(self.word())
    }
}

/// A detected fault.
#[derive(Clone, Debug)]
pub struct DataDefect {
    /// Its kind.
    pub kind: DefectKind,
    /// Index of the measurement.
    pub set: usize,
    /// Column, sensor, component or measurement.
    pub name: String,
    /// Description of the fault.
    pub what: String,
    /// First and last row, from 0.
    pub rows: [usize; 2],
    /// The evidence, with numbers.
    pub evidence: String,
    /// The consequence.
    pub then: Then,
}

/// The data that checks use.
#[derive(Debug)]
pub struct View<'s, 'a> {
    scene: &'s Scene<'a>,
    /// By measurement.
    sensors: Vec<Vec<Sensor>>,
    /// Readings relative to their repetitions, by measurement.
    trails: Vec<Trail>,
    /// Indices of refused measurements, which later checks skip.
    refused: BTreeSet<usize>,
    /// Rows that are excluded because temperatures are missing: index of the measurement, first and last row.
    gone: Vec<(usize, [usize; 2])>,
    tips: OnceCell<[Vec<f64>; 3]>,
}

impl<'s, 'a> View<'s, 'a> {
    /// A view without the readings relative to their repetitions (`trails`), in which no measurement is refused.
    fn new(scene: &'s Scene<'a>, sensors: Vec<Vec<Sensor>>) -> View<'s, 'a> {
        View { scene, sensors, trails: Vec::new(), refused: BTreeSet::new(), gone: Vec::new(), tips: OnceCell::new() }
    }

    /// The effect of a displacement of the tool along each direction of F on every reading.
    fn tips(&self) -> &[Vec<f64>; 3] {
        self.tips.get_or_init(|| [0, 1, 2].map(|k| self.scene.factors(Through::Tip(k))))
    }

    /// All readings, and their residuals for a model without causes.
    #[must_use]
    pub fn scene(&self) -> &'s Scene<'a> {
        self.scene
    }

    /// Measurements whose readings are checked, with their indices: those that no check has refused.
    pub fn sets(&self) -> impl Iterator<Item = (usize, &DataSet)> {
        self.scene.sets.iter().enumerate().filter(|(set, _)| !self.refused.contains(set))
    }
}

/// Finds faults with the built-in checks.
#[must_use]
pub fn find(scene: &Scene<'_>) -> Vec<DataDefect> {
    find_with(&Checks::default(), scene)
}

/// Finds faults with these checks.
#[must_use]
pub fn find_with(checks: &Checks, scene: &Scene<'_>) -> Vec<DataDefect> {
    let mut view = View::new(scene, scene.sets.iter().map(cells::sensors).collect());
    view.trails = (0..scene.sets.len()).map(|set| Trail::new(scene, set)).collect();
    let mut all = Vec::new();
    for check in checks.iter() {
        let mut found = Vec::new();
        (check.look)(&view, &mut found);
        for fault in &found {
            match &fault.then {
                // With another machine nothing else can be checked.
                Then::Refuse if fault.kind == DefectKind::Topology => view.refused.extend(0..scene.sets.len()),
                Then::Refuse => {
                    view.refused.insert(fault.set);
                }
                Then::WithoutSensors(names) => {
                    let own = view.sensors.get_mut(fault.set).into_iter().flatten();
                    own.filter(|sensor| names.contains(&sensor.name)).for_each(|sensor| sensor.forget(fault.rows));
                }
                Then::WithoutTemperatures(missing) => {
                    let own = view.sensors.get_mut(fault.set).into_iter().flatten();
                    for sensor in own.filter(|sensor| missing.sensors.contains(&sensor.name)) {
                        missing.pieces.iter().for_each(|piece| sensor.forget(*piece));
                    }
                    view.gone.extend(missing.uncounted.iter().map(|rows| (fault.set, *rows)));
                    let trail = view.trails.get_mut(fault.set);
                    trail.into_iter().for_each(|trail| missing.uncounted.iter().for_each(|rows| trail.forget(*rows)));
                }
                Then::InFahrenheit(name) => {
                    let own = view.sensors.get_mut(fault.set).into_iter().flatten();
                    let values = own.filter(|sensor| sensor.name == *name).flat_map(|sensor| &mut sensor.values);
                    values.for_each(|value| *value = fahrenheit::celsius(*value));
                }
                Then::ShiftLog(log) => {
                    view.gone.extend(log.uncounted.iter().map(|rows| (fault.set, *rows)));
                    let trail = view.trails.get_mut(fault.set);
                    trail.into_iter().for_each(|trail| log.uncounted.iter().for_each(|rows| trail.forget(*rows)));
                }
                Then::WithoutRows => {
                    let own = view.sensors.get_mut(fault.set).into_iter().flatten();
                    own.filter(|sensor| sensor.name == fault.name).for_each(|sensor| sensor.forget(fault.rows));
                    view.trails.get_mut(fault.set).into_iter().for_each(|trail| trail.forget(fault.rows));
                }
                Then::WithoutReadings(readings) => {
                    view.trails.get_mut(fault.set).into_iter().for_each(|trail| trail.forget_readings(readings));
                }
                Then::OwnZero | Then::MoreNoise(_) | Then::Nothing => {}
            }
        }
        all.extend(found);
    }
    all
}

/// Removes faulty sensors from measurements or from some of their rows, converts those in °F, and shifts logs with another clock.
pub fn mend_sensors(sets: &mut [DataSet], faults: &[DataDefect]) {
    for fault in faults {
        let Some(set) = sets.get_mut(fault.set) else { continue };
        match &fault.then {
            Then::WithoutSensors(names) => set.drivers.retain(|driver| !names.contains(&driver.name)),
            Then::WithoutTemperatures(missing) => missing::forget(set, missing),
            Then::ShiftLog(log) => clock::shift(set, log),
            Then::InFahrenheit(name) => {
                let own = set.drivers.iter_mut().filter(|driver| driver.name == *name);
                let values = own.flat_map(|driver| &mut driver.values);
                values.for_each(|value| *value = fahrenheit::celsius(*value));
                let sensor = name.strip_suffix("_C").unwrap_or(name);
                change_readings(&mut set.conditions, sensor, &fahrenheit::celsius);
            }
            _ => {}
        }
    }
}

/// Excludes the faulty rows and readings from a scene.
pub fn exclude(scene: &mut Scene<'_>, faults: &[DataDefect]) {
    for fault in faults {
        let [first, last] = fault.rows;
        let rows = &scene.rows;
        let at = |item: &super::scene::SceneReading| {
            rows.get(item.row).filter(|row| row.set == fault.set).map_or(usize::MAX, |row| row.number)
        };
        match &fault.then {
            Then::WithoutRows => {
                let inside = scene.items.iter_mut().filter(|item| (first..=last).contains(&at(item)));
                inside.for_each(|item| item.sigma = f64::INFINITY);
            }
            Then::WithoutTemperatures(MissingTemperatures { uncounted, .. })
            | Then::ShiftLog(ShiftedLog { uncounted, .. }) => {
                let is_in = |row: usize| uncounted.iter().any(|[first, last]| (*first..=*last).contains(&row));
                let inside = scene.items.iter_mut().filter(|item| is_in(at(item)));
                inside.for_each(|item| item.sigma = f64::INFINITY);
            }
            Then::WithoutReadings(readings) => {
                let named =
                    scene.items.iter_mut().filter(|item| readings.binary_search(&(at(item), item.value)).is_ok());
                named.for_each(|item| item.sigma = f64::INFINITY);
            }
            Then::MoreNoise(more) => {
                let own = scene.items.iter_mut().filter(|item| at(item) != usize::MAX);
                own.for_each(|item| item.sigma = item.sigma.hypot(*more));
            }
            Then::OwnZero => {
                let Some(trail) = scene.sets.get(fault.set).map(trail::channels) else { continue };
                let count = trail.iter().max().map_or(1, |most| most + 1);
                for item in scene.items.iter_mut().filter(|item| (first..=last).contains(&at(item))) {
                    let own = trail.get(at(item)).copied().unwrap_or(0);
                    item.by_unknown.push((scene.unknowns + 3 * own + item.value, 1.0));
                }
                scene.unknowns += 3 * count;
            }
            Then::Refuse | Then::WithoutSensors(_) | Then::InFahrenheit(_) | Then::Nothing => {}
        }
    }
}

/// Median of values; 0 if there are no values.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Standard deviation of normally distributed values, from the median of their absolute values.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    median(values.filter(|value| value.is_finite()).map(f64::abs).collect()) / super::noise::MEDIAN
}

#[cfg(test)]
mod plants;
