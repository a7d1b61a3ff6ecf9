//! One measurement: readings, the set-ups in which they were taken, and what is unknown of these.

use std::collections::HashMap;

use crate::csv::{Row, Table};
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::geometry::{AxisVector, Vector};
use crate::machine::Machine;
use crate::machine::file::{MachineFile, Section};
use crate::model::ErrorName;
use crate::source::Source;
use crate::units::{mm_from_um, rad_from_urad};

use super::kind::{self, KINDS, Kind};
use super::reading::{Reading, Readings};

/// A measurement.
#[derive(Clone, Debug)]
pub struct DataSet {
    /// The name of its files without ending.
    pub name: String,
    /// What was measured.
    pub kind: &'static Kind,
    /// Standard uncertainty of a reading of a length, mm; `None` where it is to be estimated.
    pub sigma: Option<f64>,
    /// The same of an angle, rad.
    pub sigma_rad: Option<f64>,
    /// What is unknown of every set-up.
    pub free: Vec<Free>,
    /// Mountings of the instrument.
    pub setups: Vec<Setup>,
    /// Names of balls of unknown place.
    pub targets: Vec<String>,
    /// Known distances between them.
    pub lengths: Vec<KnownLength>,
    /// Where balls nominally are in the workpiece frame, mm, as far as the description says: what a simulation needs.
    pub balls: Vec<(String, Vector)>,
    /// Whether it is the plan of a measurement, without readings yet.
    pub is_plan: bool,
    /// Readings in the order of the file.
    pub observations: Vec<Observation>,
}

/// What may be unknown of a set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Free {
    /// Place of the table ball of a ball-bar.
    Centre,
    /// Length of a ball-bar.
    Length,
    /// A shift of all readings.
    Offset,
    /// A small rotation of an artefact.
    Rotation,
    /// The tool vector.
    Tool,
}

/// A mounting.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Its label; empty where there is one without.
    pub label: String,
    /// Position (as in the flat stream: command plus tool vector) at which the balls of a ball-bar would coincide, mm.
    pub centre_mm: Vector,
    /// Nominal length of the ball-bar, mm.
    pub length_mm: f64,
}

/// A distance between two balls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownLength {
    /// Their numbers.
    pub between: [usize; 2],
    /// Calibrated value, mm.
    pub value_mm: f64,
    /// Its standard uncertainty, mm, where it is known.
    pub sigma_mm: Option<f64>,
}

/// A row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Where the axes stood.
    pub reading: Reading,
    /// Number of its set-up.
    pub setup: usize,
    /// What was read: deviations along X, Y, Z, or one value; mm, or rad where an angle was read. `None` for an empty cell.
    pub values: [Option<f64>; 3],
    /// The ball that was probed.
    pub target: Option<usize>,
    /// The component that was measured.
    pub component: Option<ErrorName>,
    /// By how much the spindle was turned, rad: an offset of the stylus turns with it.
    pub spindle_rad: f64,
    /// The row in its file.
    pub place: Place,
}

/// Reads a pair of files. All findings are reported in one run; there is data only where none of them is an error.
#[must_use]
pub fn load(name: &str, table: &Source, description: &Source, machine: &Machine) -> (Option<DataSet>, Vec<Diagnostic>) {
    load_as(name, table, description, machine, false)
}

/// Reads the plan of a measurement: a pair of files whose columns of readings are empty or not there yet. Every reading counts as 0.
#[must_use]
pub fn load_plan(
    name: &str,
    table: &Source,
    description: &Source,
    machine: &Machine,
) -> (Option<DataSet>, Vec<Diagnostic>) {
    load_as(name, table, description, machine, true)
}

fn load_as(
    name: &str,
    table: &Source,
    description: &Source,
    machine: &Machine,
    is_plan: bool,
) -> (Option<DataSet>, Vec<Diagnostic>) {
    let (description, mut findings) = read_description(name, description);
    let (rows, found) = Table::read(table);
    findings.extend(found);
    let (Some(mut data), Some(rows)) = (description, rows) else { return (None, findings) };
    data.is_plan = is_plan;
    match Readings::new(&rows, machine) {
        Err(found) => findings.extend(found),
        Ok(readings) => read_rows(&rows, readings, &mut data, &mut findings),
    }
    if findings.is_empty() {
        (data.kind.check)(&data, &rows, &mut findings);
    }
    let sound = !findings.iter().any(Diagnostic::is_error);
    (sound.then_some(data), findings)
}

fn read_description(name: &str, source: &Source) -> (Option<DataSet>, Vec<Diagnostic>) {
    let file = match MachineFile::parse(source) {
        Ok(file) => file,
        Err(findings) => return (None, findings),
    };
    let mut findings = Vec::new();
    let mut root = file.root();
    let mut data = None;
    if let Some(mut section) = root.required("measurement", "a section [measurement] with kind", Section::section) {
        data = read_measurement(name, &mut section);
        section.finish(&mut findings);
    }
    let mut setups = Vec::new();
    if let Some(mut section) = root.section("setup") {
        let labels: Vec<&str> = section.keys().collect();
        for label in labels {
            if let Some(mut one) = section.section(label) {
                let centre_mm = one.vector("centre_mm").unwrap_or_default();
                let length_mm = one.number_where("length_mm", "a length above 0", |mm| mm > 0.0).unwrap_or(0.0);
                setups.push(Setup { label: label.to_owned(), centre_mm, length_mm });
                one.finish(&mut findings);
            }
        }
        section.finish(&mut findings);
    }
    let mut lengths = Vec::new();
    for mut section in root.sections("length") {
        let from = section.required("from", "\"b1\"", Section::text);
        let to = section.required("to", "\"b2\"", Section::text);
        let value_mm = section.required("value_mm", "500.012", |section, key| {
            section.number_where(key, "a length above 0", |mm| mm > 0.0)
        });
        if let (Some(from), Some(to), Some(value_mm)) = (from, to, value_mm) {
            let sigma_mm = section.number_where("sigma_um", "a number above 0", |um| um > 0.0).map(mm_from_um);
            lengths.push((from.to_owned(), to.to_owned(), value_mm, sigma_mm));
        }
        section.finish(&mut findings);
    }
    let balls = root.section("ball").map_or_else(Vec::new, |section| read_balls(section, &mut findings));
    root.finish(&mut findings);
    let data = data.map(|mut data: DataSet| {
        data.setups = setups;
        data.balls = balls;
        for (from, to, value_mm, sigma_mm) in lengths {
            let between = [from, to].map(|label| number_of(&mut data.targets, &label));
            data.lengths.push(KnownLength { between, value_mm, sigma_mm });
        }
        data
    });
    (data, findings)
}

fn read_balls(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> Vec<(String, Vector)> {
    let mut balls = Vec::new();
    let labels: Vec<&str> = section.keys().collect();
    for label in labels {
        if let Some(mut one) = section.section(label) {
            let place = one.required("place_mm", "[100, 0, 50]", Section::vector);
            balls.extend(place.map(|place| (label.to_owned(), place)));
            one.finish(findings);
        }
    }
    section.finish(findings);
    balls
}

fn read_measurement(name: &str, section: &mut Section<'_>) -> Option<DataSet> {
    let kind = section.required("kind", "\"ballbar\"", Section::text).and_then(|text| {
        let kind = KINDS.iter().copied().find(|kind| kind.name == text);
        if kind.is_none() {
            let names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
            let place = section.place_of("kind");
            section.report(
                Code::BAD_VALUE,
                place,
                format!("unknown kind \"{text}\""),
                format!("write one of {}", names.join(", ")),
            );
        }
        kind
    });
    let sigma = section.number_where("sigma_um", "a number above 0", |um| um > 0.0).map(mm_from_um);
    let sigma_rad = section.number_where("sigma_urad", "a number above 0", |urad| urad > 0.0).map(rad_from_urad);
    let free = section.texts("free");
    let kind = kind?;
    let mut unknowns = Vec::new();
    for (index, word) in free.unwrap_or_default().iter().enumerate() {
        match kind.free.iter().find(|&&free| kind::word(free) == word) {
            Some(&free) => unknowns.push(free),
            None => {
                let known: Vec<&str> = kind.free.iter().map(|&free| kind::word(free)).collect();
                let place = section.place_of_item("free", index);
                let message = format!("\"{word}\" is nothing that may be unknown of a {} measurement", kind.name);
                section.report(Code::BAD_VALUE, place, message, format!("write any of {}", known.join(", ")));
            }
        }
    }
    Some(DataSet {
        name: name.to_owned(),
        kind,
        sigma,
        sigma_rad,
        free: unknowns,
        setups: Vec::new(),
        targets: Vec::new(),
        lengths: Vec::new(),
        balls: Vec::new(),
        is_plan: false,
        observations: Vec::new(),
    })
}

fn read_rows(rows: &Table, mut readings: Readings<'_>, data: &mut DataSet, findings: &mut Vec<Diagnostic>) {
    let setup_column = rows.column("setup");
    let mut seen: HashMap<(Vec<u64>, usize, usize), Place> = HashMap::new();
    let is_described = !data.setups.is_empty();
    for row in rows.rows() {
        let reading = match readings.read(&row) {
            Ok(reading) => reading,
            Err(found) => {
                findings.extend(found);
                continue;
            }
        };
        let label = setup_column.map_or(String::new(), |column| text(&row, column));
        let known = data.setups.iter().position(|setup| setup.label == label);
        let setup = match known {
            Some(setup) => setup,
            None if is_described && setup_column.is_none() && data.setups.len() == 1 => 0,
            None if is_described => {
                let place = setup_column.map_or(row.place(0), |column| row.place(column));
                let message = format!("the set-up '{label}' is not described");
                findings.push(Diagnostic::at(
                    Code::DATA_CELL,
                    place,
                    message,
                    format!("add [setup.{label}] to the description"),
                ));
                continue;
            }
            None => {
                data.setups.push(Setup { label, centre_mm: Vector::zeros(), length_mm: 0.0 });
                data.setups.len() - 1
            }
        };
        let mut observation = Observation {
            reading,
            setup,
            values: [None; 3],
            target: None,
            component: None,
            spindle_rad: 0.0,
            place: row.place(0),
        };
        match (data.kind.read)(data, &row, readings.sign(), &mut observation) {
            Ok(()) => {}
            Err(finding) => {
                findings.push(finding);
                continue;
            }
        }
        let key = (bits(&observation), setup, observation.target.unwrap_or(usize::MAX));
        // A plan may go to the same pose again.
        if let Some(first) = (!data.is_plan).then(|| seen.insert(key, observation.place)).flatten() {
            let line = row_line(rows, first);
            let message = format!("the row is the same as that in line {line}");
            let help = "take one of them out: a repetition would differ by the noise of the instrument";
            findings.push(Diagnostic::at(Code::DATA_REPEATED, observation.place, message, help));
        }
        data.observations.push(observation);
    }
    if data.observations.is_empty() && findings.is_empty() {
        let help = "write at least one reading";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, rows.header_place(None), "the table has no rows", help));
    }
}

/// Everything that a row says, to tell copies.
fn bits(observation: &Observation) -> Vec<u64> {
    let AxisVector(position) = observation.reading.position;
    let values = observation.values.map(|value| value.unwrap_or(f64::NAN));
    let senses = observation.reading.state.direction.map(f64::from);
    let tool = observation.reading.tool_mm;
    let spindle = [observation.spindle_rad];
    position
        .iter()
        .chain(&values)
        .chain(&senses)
        .chain(tool.iter())
        .chain(&spindle)
        .map(|value| value.to_bits())
        .collect()
}

fn row_line(rows: &Table, place: Place) -> usize {
    rows.line_of(place)
}

/// The content of a cell as text.
pub(super) fn text(row: &Row<'_>, column: usize) -> String {
    String::from_utf8_lossy(row.text(column)).trim().to_owned()
}

/// The number of a label, which is added where it is new.
pub(super) fn number_of(labels: &mut Vec<String>, label: &str) -> usize {
    labels.iter().position(|known| known == label).unwrap_or_else(|| {
        labels.push(label.to_owned());
        labels.len() - 1
    })
}
