//! Faults of the data: what went wrong between the machine and the file. One file each, and the register of them ([`Checks`]),
//! which a caller extends.
//!
//! They are looked for before causes are: a factor, a sensor that stays or rows of a pulse would be explained by something that is not there. Each
//! check says what it found, in which rows, and why; what the search for causes then goes without follows from [`Then`]. An effect of the machine
//! repeats where axes stand, move or warm up as before, a fault does not: that is how they are told apart.

mod axes;
mod cells;
mod chain;
mod compensated;
mod constant;
mod dead;
mod drifting;
mod exchanged;
mod exchanged_positions;
mod fading;
mod fahrenheit;
mod first_cycle;
mod missing;
mod offset;
mod order;
mod outlier;
mod pulse;
pub(in crate::diagnose) mod quantised;
mod readings;
mod sharp;
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

/// A kind of fault, and the function that looks for it.
#[derive(Debug)]
pub struct DefectCheck {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub made_by: &'static str,
    /// What shows it.
    pub shown_by: &'static str,
    /// Where this is known from.
    pub source: &'static str,
    /// Looks for it and pushes what it finds, each with the rows and what follows. Faults of the checks before it are left out of what it sees
    /// ([`View::sets`]).
    pub look: fn(&View<'_, '_>, &mut Vec<DataDefect>),
}

/// The kinds of faults that are looked for, in their order: [`Register::default`](ncfix_base::register::Register::default) are those that are built in.
pub type Checks = Register<&'static DefectCheck>;

impl Registered for &'static DefectCheck {
    const KIND: &'static str = "kind of fault of the data";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        FAULTS.iter().map(|&check| Box::new(check)).collect()
    }
}

/// Those that are built in, in the order in which they are looked for: what one finds the next ones do without.
pub const FAULTS: &[&DefectCheck] = &[
    &dead::CHECK,
    &stuck::CHECK,
    &fahrenheit::CHECK,
    &exchanged::CHECK,
    &offset::CHECK,
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

/// What follows from a fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Then {
    /// The file says something else than what was measured: nothing is to be found in it.
    Refuse,
    /// The rows do not count.
    WithoutRows,
    /// These single readings do not count: row and value, in order.
    WithoutReadings(Vec<(usize, usize)>),
    /// Sensors of which nothing is made.
    WithoutSensors(Vec<String>),
    /// Sensors say nothing in some rows, and else remain in use.
    WithoutTemperatures(MissingTemperatures),
    /// What a sensor says is converted to °C.
    InFahrenheit(String),
    /// Readings from the first row on have a zero of their own.
    OwnZero,
    /// The reader is told, that is all.
    Nothing,
    /// Readings have this much more uncertainty, mm or rad.
    MoreNoise(f64),
}

/// Rows in which sensors say nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingTemperatures {
    /// Their columns.
    pub sensors: Vec<String>,
    /// Pieces of rows without their readings: first and last.
    pub pieces: Vec<[usize; 2]>,
    /// Those of the pieces that are too long to be bridged: their rows do not count, since causes must be compared where all sensors are known.
    pub uncounted: Vec<[usize; 2]>,
}

/// What is wrong with data. Results have it as its word ([`DefectKind::word`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum DefectKind {
    /// Columns of positions are exchanged or reversed.
    Axes,
    /// Readings are of other positions than the file says.
    Positions,
    /// A table of the control was active.
    Compensated,
    /// The first cycle is not like the others.
    FirstCycle,
    /// Rows are in another order than they were taken in.
    Order,
    /// Single readings are far from the others.
    #[default]
    Outlier,
    /// Rows of a short disturbance.
    Pulse,
    /// Readings in coarse steps.
    Quantised,
    /// A reading that stays.
    Reading,
    /// A sensor.
    Sensor,
    /// The zero moved.
    Step,
    /// The axes of the machine carry one another in another order than its file says.
    Topology,
    /// Readings are in another unit.
    Unit,
    /// A kind of a check that a caller brings: its word.
    Own(&'static str),
}

impl DefectKind {
    /// Its word in results.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            DefectKind::Axes | DefectKind::Positions => "axes",
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

/// A fault that was found.
#[derive(Clone, Debug)]
pub struct DataDefect {
    /// What kind of fault it is.
    pub kind: DefectKind,
    /// Number of the measurement.
    pub set: usize,
    /// Column, sensor, component or measurement.
    pub name: String,
    /// What is wrong with it.
    pub what: String,
    /// First and last row, from 0.
    pub rows: [usize; 2],
    /// Why this is thought, with numbers.
    pub evidence: String,
    /// What to do.
    pub then: Then,
}

/// What checks look at.
#[derive(Debug)]
pub struct View<'s, 'a> {
    scene: &'s Scene<'a>,
    /// By measurement.
    sensors: Vec<Vec<Sensor>>,
    /// Readings against their repetitions, by measurement.
    trails: Vec<Trail>,
    /// Measurements that are not to be read on.
    refused: BTreeSet<usize>,
    /// Rows that do not count since temperatures are missing: number of the measurement, first and last.
    gone: Vec<(usize, [usize; 2])>,
    tips: OnceCell<[Vec<f64>; 3]>,
}

impl<'s, 'a> View<'s, 'a> {
    /// Without trails, and with nothing refused yet.
    fn new(scene: &'s Scene<'a>, sensors: Vec<Vec<Sensor>>) -> View<'s, 'a> {
        View { scene, sensors, trails: Vec::new(), refused: BTreeSet::new(), gone: Vec::new(), tips: OnceCell::new() }
    }

    /// What a displacement of the tool along each direction of F does to every reading.
    fn tips(&self) -> &[Vec<f64>; 3] {
        self.tips.get_or_init(|| [0, 1, 2].map(|k| self.scene.factors(Through::Tip(k))))
    }

    /// All readings, and what a model without causes leaves of them.
    #[must_use]
    pub fn scene(&self) -> &'s Scene<'a> {
        self.scene
    }

    /// Measurements that are looked at for anything about their readings, with their numbers: those that no check has refused.
    pub fn sets(&self) -> impl Iterator<Item = (usize, &DataSet)> {
        self.scene.sets.iter().enumerate().filter(|(set, _)| !self.refused.contains(set))
    }
}

/// Finds faults.
#[must_use]
pub fn find(scene: &Scene<'_>) -> Vec<DataDefect> {
    find_with(&Checks::default(), scene)
}

/// Finds faults of these kinds.
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
                // Of another machine nothing else can be said.
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

/// Takes the sensors out of measurements in which they are at fault, or out of the rows in which they say nothing, and converts those in °F.
pub fn mend_sensors(sets: &mut [DataSet], faults: &[DataDefect]) {
    for fault in faults {
        let Some(set) = sets.get_mut(fault.set) else { continue };
        match &fault.then {
            Then::WithoutSensors(names) => set.drivers.retain(|driver| !names.contains(&driver.name)),
            Then::WithoutTemperatures(missing) => missing::forget(set, missing),
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

/// Makes a scene do without the rows that are at fault.
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
            Then::WithoutTemperatures(missing) => {
                let is_in = |row: usize| missing.uncounted.iter().any(|[first, last]| (*first..=*last).contains(&row));
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

/// The middle of some values; 0 of none.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Standard deviation of normal values by the middle of their absolute values.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    /// Median of the absolute values of normal noise, in standard deviations.
    const MEDIAN: f64 = 0.674_489_750_196_081_7;
    median(values.filter(|value| value.is_finite()).map(f64::abs).collect()) / MEDIAN
}

#[cfg(test)]
mod plants;
