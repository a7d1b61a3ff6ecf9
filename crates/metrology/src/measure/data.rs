//! One measurement: readings, their set-ups, and the unknowns of the set-ups.

mod approach;
mod arc;
mod bodies;
mod condition;
pub mod cycles;
mod description;
mod drivers;
mod repeats;
mod rows;
mod signs;

pub use drivers::{DataColumn, FEATURE_COLUMNS, MOVED, TIME, TURNED};

use std::sync::LazyLock;

use ncfix_base::csv::{Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::source::Source;
use ncfix_machine::machine::condition::columns::OfDead;
use ncfix_machine::machine::{Condition, Machine};
use ncfix_model::ErrorName;

use self::cycles::RepeatCycle;
use super::circles;
use super::kind::{Instrument, Instruments, location};
use super::nest::SensorNest;
use super::reading::{Reading, Readings};

/// A measurement.
#[derive(Clone, Debug)]
pub struct DataSet {
    /// The name of its files without extension.
    pub name: String,
    /// Kind of the measurement.
    pub kind: &'static Instrument,
    /// Date of the measurement, `2026-11-27`, if the description states it.
    pub date: Option<String>,
    /// Head of the machine with which it was made, if the description states it.
    pub head: Option<String>,
    /// Standard uncertainty of a length reading, mm; `None` if it is to be estimated.
    pub sigma: Option<f64>,
    /// Standard uncertainty of an angle reading, rad; `None` if it is to be estimated.
    pub sigma_rad: Option<f64>,
    /// Standard uncertainty of the scale of the instrument or of the artifact by its certificate, relative; 0 if it is not stated.
    pub scale_sigma: f64,
    /// Unknowns of every set-up.
    pub free: Vec<Free>,
    /// The response of sensors whose columns are no displacements along F.
    pub sensors: Option<SensorNest>,
    /// Data of every set-up without an entry of its own, because all use the same artifact.
    pub artefact: Setup,
    /// Mountings of the instrument.
    pub setups: Vec<Setup>,
    /// Labels of the extension rods of ball-bars: set-ups with the same rod have the same length.
    pub rods: Vec<String>,
    /// Back-and-forth cycles of readings of one component, if a drift is unknown.
    pub cycles: Vec<RepeatCycle>,
    /// Labels of the repetitions, in the order of their start; a single empty one without the column `run`.
    pub runs: Vec<String>,
    /// Names of balls of unknown position.
    pub targets: Vec<String>,
    /// Known distances between them.
    pub lengths: Vec<KnownLength>,
    /// Nominal positions of balls in the workpiece frame, mm, as far as described; needed for a simulation.
    pub balls: Vec<(String, Vector)>,
    /// `true` for the plan of a measurement, without readings.
    pub is_plan: bool,
    /// Constant positions of axes without a column, mm or rad.
    pub fixed: Vec<(Axis, f64)>,
    /// Ranges of axes over which a squareness was measured, mm; the travel for an axis without one.
    pub ranges: Vec<(Axis, [f64; 2])>,
    /// The conditions of the machine for the readings; empty for the reference state.
    pub conditions: Vec<Condition>,
    /// `false` if the description states that the rows are not in the order of the motion, as in a sorted map or report: then neither a direction nor a
    /// time follows from it.
    pub is_in_order: bool,
    /// `true` if the description states this order, or that the rows have no order.
    pub is_order_stated: bool,
    /// `true` if the description states that the unit of the readings was stated by the instrument.
    pub is_unit_stated: bool,
    /// `true` if the description states that straightnesses were read along a square, whose direction is exact.
    pub is_square_stated: bool,
    /// `true` if the table contains directions of motion, `false` if they follow from the order of its rows.
    pub has_senses: bool,
    /// Readings in the order of the file.
    pub observations: Vec<Observation>,
    /// Other numeric columns.
    pub drivers: Vec<DataColumn>,
}

impl DataSet {
    /// The condition of the machine in a row; the reference state if the table has none.
    #[must_use]
    pub fn condition(&self, observation: &Observation) -> &Condition {
        static REFERENCE: LazyLock<Condition> = LazyLock::new(Condition::default);
        self.conditions.get(observation.condition).unwrap_or(&REFERENCE)
    }

    /// Completes the conditions of the rows with another one where the table has no value.
    pub fn fill_in(&mut self, base: &Condition) {
        if self.conditions.is_empty() {
            self.conditions = vec![Condition::default()];
            self.observations.iter_mut().for_each(|row| row.condition = 0);
        }
        for condition in &mut self.conditions {
            let over = |own: &Condition| {
                let mut whole = base.clone();
                whole.lay_over(own.clone());
                if own.has_temperatures() && own.time_range_s().is_some_and(|[first, last]| first < last) {
                    whole.set_time(own.time_s());
                }
                whole
            };
            let mut whole = over(condition);
            if let Some(zero) = condition.zero() {
                whole.set_zero(over(zero));
            }
            *condition = whole;
        }
    }
}

/// Possible unknowns of a set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Free {
    /// Position of the table ball of a ball-bar.
    Centre,
    /// A drift that is linear in time within each back-and-forth cycle.
    Drift,
    /// Length of a ball-bar, for every set-up.
    Length,
    /// A shift of all readings.
    Offset,
    /// Length of a ball-bar, for every extension rod.
    Rod,
    /// Temperature of a ball-bar, for every set-up.
    RodTemperature,
    /// A small rotation of an artifact.
    Rotation,
    /// Alignment of the instrument with the axis whose straightness it measures.
    Slope,
    /// The tool vector.
    Tool,
    /// An unknown of a custom instrument, by its word.
    Own(&'static str),
}

/// A mounting.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// Its label; empty if there is a single one without label.
    pub label: String,
    /// Position (as in the flat stream: command plus tool vector) at which the balls of a ball-bar would coincide, mm.
    pub centre_mm: Vector,
    /// Nominal length of the ball-bar, mm.
    pub length_mm: f64,
    /// Standard uncertainty of this length by its certificate, mm; 0 if it is not stated.
    pub length_sigma_mm: f64,
    /// Index of its extension rod.
    pub rod: usize,
    /// Expansion of the rod or artifact per K; 0 if it counts as measured at 20 °C.
    pub expansion_per_k: f64,
    /// Its temperature, °C, unless a row states another.
    pub temperature_c: Option<f64>,
    /// The point from which an artifact expands, mm, in the workpiece frame.
    pub origin_mm: Option<Vector>,
    /// Unit vector of the line along which lengths are measured, in the workpiece frame.
    pub direction: Option<Vector>,
    /// Position of the station from which lengths are measured, as that of a tip, mm.
    pub station_mm: Option<Vector>,
}

/// A distance between two balls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownLength {
    /// Indices of the balls.
    pub between: [usize; 2],
    /// Calibrated value, mm.
    pub value_mm: f64,
    /// Its standard uncertainty, mm, if known.
    pub sigma_mm: Option<f64>,
}

/// A row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Positions of the axes.
    pub reading: Reading,
    /// Index of its set-up.
    pub setup: usize,
    /// Index of its run.
    pub run: usize,
    /// Time, s, if the table states it.
    pub t_s: Option<f64>,
    /// Index of the condition of the machine.
    pub condition: usize,
    /// Temperature of the ball-bar or artifact, °C.
    pub temperature_c: Option<f64>,
    /// Feed, mm/min.
    pub feed: Option<f64>,
    /// The index of its back-and-forth cycle, and its relative time in the cycle, -1/2 to 1/2, for a drift.
    pub cycle: Option<(usize, f64)>,
    /// Values read: deviations along X, Y, Z, or one value; mm, or rad for an angle. `None` for an empty cell.
    pub values: [Option<f64>; 3],
    /// The ball that was probed.
    pub target: Option<usize>,
    /// The component that was measured.
    pub component: Option<ErrorName>,
    /// Angle of the spindle, rad: an offset of the stylus turns with it.
    pub spindle_rad: f64,
    /// The row in its file.
    pub place: Place,
}

impl Observation {
    /// The axis whose motion was measured, if one component was read.
    #[must_use]
    pub fn motion_axis(&self) -> Option<Axis> {
        self.component.filter(|name| !name.is_location())?.axis()
    }

    /// `true` if an angle was read.
    #[must_use]
    pub fn is_angle(&self) -> bool {
        self.component.is_some_and(|name| name.direction.is_rotation())
    }
}

/// Reads a pair of files. All diagnostics are reported in one run; there is data only if none of them is an error.
#[must_use]
pub fn load(name: &str, table: &Source, description: &Source, machine: &Machine) -> (Option<DataSet>, Vec<Diagnostic>) {
    load_with(&Instruments::default(), [table, description], name, machine, ReadAs::Readings)
}

/// Reads a pair of files in which temperature sensors may have failed in some rows. Those rows have no temperature of the sensor, but
/// [`DataSet::drivers`] contains the raw cells.
#[must_use]
pub fn load_with_dead(
    name: &str,
    table: &Source,
    description: &Source,
    machine: &Machine,
) -> (Option<DataSet>, Vec<Diagnostic>) {
    load_with(&Instruments::default(), [table, description], name, machine, ReadAs::WithDead)
}

/// Reads the plan of a measurement: a pair of files whose columns of readings are empty or missing. Every reading counts as 0.
#[must_use]
pub fn load_plan(
    name: &str,
    table: &Source,
    description: &Source,
    machine: &Machine,
) -> (Option<DataSet>, Vec<Diagnostic>) {
    load_with(&Instruments::default(), [table, description], name, machine, ReadAs::Plan)
}

/// A statement that the readings were taken with another head than that of the machine in use.
fn other_head(data: &DataSet, machine: &Machine) -> Option<Diagnostic> {
    let stated = data.head.as_ref()?;
    let own = machine.heads.first().map(|head| head.name.as_str());
    if own == Some(stated) {
        return None;
    }
    let message = match own {
        Some(own) => format!("the readings were taken with the head {stated}, and this run is for the head {own}"),
        None => {
            format!("the readings were taken with the head {stated}, and the machine {} has no [[head]]", machine.name)
        }
    };
    let help = format!("choose it with --head {stated}, or correct head in the description");
    Some(Diagnostic::nowhere(Code::DATA_COLUMN, message, help))
}

/// Diagnostics of a table that differ in numbers alone, at most: a wrong unit is wrong in every row.
const ALIKE: usize = 5;

/// Mode of reading a pair of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadAs {
    /// As [`load`].
    Readings,
    /// As [`load_with_dead`].
    WithDead,
    /// As [`load_plan`].
    Plan,
}

/// Reads a pair of files, table and description, for one of these kinds of measurement.
#[must_use]
pub fn load_with(
    instruments: &Instruments,
    [table, description]: [&Source; 2],
    name: &str,
    machine: &Machine,
    how: ReadAs,
) -> (Option<DataSet>, Vec<Diagnostic>) {
    let (description, mut findings) = description::read(name, description, instruments);
    let (rows, found) = Table::read(table);
    findings.extend(found);
    let (Some(mut data), Some(rows)) = (description, rows) else { return (None, findings) };
    for (axis, _) in data.fixed.iter().filter(|(axis, _)| machine.axis(*axis).is_none()) {
        let message = format!("the machine {} has no axis {axis}, but [position] gives its position", machine.name);
        let help = "check --machine, or remove it from the description";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, rows.header_place(None), message, help));
    }
    if let Some(found) = other_head(&data, machine) {
        findings.push(Diagnostic { place: Some(rows.header_place(None)), ..found });
    }
    data.is_plan = how == ReadAs::Plan;
    match Readings::with(&rows, machine, &data.fixed) {
        Err(found) => findings.extend(found),
        Ok(readings) => {
            let readings = if data.is_in_order { readings } else { readings.in_no_order() };
            let sign = readings.sign();
            let of_dead = if how == ReadAs::WithDead { OfDead::Empty } else { OfDead::Refused };
            rows::read(&rows, readings, of_dead, &mut data, &mut findings);
            missing_axes(&data, &rows, machine, &mut findings);
            data.drivers = drivers::read(&rows, machine, sign, &data);
            if findings.is_empty() && !data.is_plan {
                signs::test(&mut data, &rows, sign, &mut findings);
            }
        }
    }
    let is_stated = |axis| rows.column(&format!("{axis}_dir")).is_some();
    if data.is_in_order {
        approach::turn_at_ends(&mut data, is_stated);
        arc::along_circles(machine, &mut data, is_stated);
    } else if data.free.contains(&Free::Drift) {
        let message = "a drift follows from the order of the rows, and the description states order = \"unknown\"";
        let help = "remove \"drift\" from free, or remove order if the rows are in the order of the motion";
        findings.push(Diagnostic::at(Code::DRIFT_NOT_TOLD, rows.header_place(None), message, help));
    }
    bodies::finish(&mut data, machine);
    if findings.is_empty() && data.free.contains(&Free::Drift) {
        cycles::find(&mut data, &rows, &mut findings);
    }
    if findings.is_empty() {
        (data.kind.check)(&data, &rows, &mut findings);
        location::check(&data, machine, &mut findings);
        circles::contradictions(machine, &data, &mut findings);
    }
    let sound = !findings.iter().any(Diagnostic::is_error);
    repeats::without_repeats(&mut findings, ALIKE);
    (sound.then_some(data), findings)
}

/// Reports components of axes that the machine does not have: a fit would give their readings to other errors.
fn missing_axes(data: &DataSet, rows: &Table, machine: &Machine, findings: &mut Vec<Diagnostic>) {
    let mut known: Vec<Axis> = Vec::new();
    for row in &data.observations {
        let Some((component, axis)) = row.component.and_then(|name| Some((name, name.axis()?))) else { continue };
        if machine.axis(axis).is_some() || known.contains(&axis) {
            continue;
        }
        known.push(axis);
        let message = format!("{component} is an error of {axis}, but the machine {} has no axis {axis}", machine.name);
        let help = "name the component of the axis that moved, or check --machine";
        let cell = |own: Row<'_>| own.place(rows.column("component").unwrap_or_default());
        let place = rows.rows().find(|own| own.place(0) == row.place).map_or(row.place, cell);
        findings.push(Diagnostic::at(Code::DATA_CELL, place, message, help));
    }
}

/// The content of a cell as text.
pub(super) fn text(row: &Row<'_>, column: usize) -> String {
    String::from_utf8_lossy(row.text(column)).trim().to_owned()
}

/// The index of a label; a new label is added.
pub(super) fn number_of(labels: &mut Vec<String>, label: &str) -> usize {
    labels.iter().position(|known| known == label).unwrap_or_else(|| {
        labels.push(label.to_owned());
        labels.len() - 1
    })
}
