//! Faults of the data, which a diagnosis looks for first: reports them, refuses files that say something else than what was measured, and
//! takes out what is at fault.
//!
//! In data held out rows stay in whatever is found: they are the judge, and nobody shall choose what it sees. What its sensors say at fault is no
//! reading of them, though, and a file in another unit or with other axes judges nothing: it is refused as well.

use serde::Serialize;

use super::measurement::{Measurement, data_of};
use crate::diagnose::Scene;
use crate::diagnose::fault::{Checks, DefectKind, Fault, Then, find_with, mend_sensors};
use crate::measure::data::DataSet;
use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::Source;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// A fault of the data.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DataFault {
    /// `outlier`, `sensor` …
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub kind: DefectKind,
    /// The measurement, sensor or column.
    pub name: String,
    /// What is wrong with it.
    pub what: String,
    /// Rows from 1: the first and the last, of outliers each.
    pub rows: Vec<usize>,
    /// The measurement.
    pub file: String,
    /// Why this is thought.
    pub evidence: String,
    /// What was left out for it.
    pub excluded: String,
    /// Whether [`Self::rows`] are a first and a last row, and not rows one by one.
    #[serde(skip)]
    pub is_range: bool,
}

/// Looks for faults in measurements of which the first `used` are used and the others held out, and takes sensors out that have one; rows of the
/// former are excluded from a scene with [`crate::diagnose::fault::exclude`] by what comes back.
pub(super) fn look(
    of: (&Machine, &ErrorModel, &Checks),
    all: &mut [Measurement],
    used: usize,
    findings: &mut Vec<Diagnostic>,
    report: &mut Vec<DataFault>,
) -> Vec<Fault> {
    let (own, held_out) = all.split_at_mut(used.min(all.len()));
    let faults = look_in(of, (own, false), findings, report);
    look_in(of, (held_out, true), findings, report);
    faults
}

fn look_in(
    (machine, errors, checks): (&Machine, &ErrorModel, &Checks),
    (measurements, is_held_out): (&mut [Measurement], bool),
    findings: &mut Vec<Diagnostic>,
    report: &mut Vec<DataFault>,
) -> Vec<Fault> {
    let mut sets = data_of(measurements);
    // Where readings cannot even tell the set-ups, who goes on says so.
    let mut faults = Scene::new(machine, errors, &sets).map_or_else(|_| Vec::new(), |scene| find_with(checks, &scene));
    // Rows that judge stay in: then the sensor says nothing.
    for fault in faults
        .iter_mut()
        .filter(|fault| is_held_out && fault.kind == DefectKind::Sensor && fault.then == Then::WithoutRows)
    {
        fault.then = Then::WithoutSensors(vec![fault.name.clone()]);
    }
    for fault in &faults {
        let Some(one) = measurements.get(fault.set) else { continue };
        report.push(reported(fault, &one.data, is_held_out));
        let place = place(fault, &one.sources[0]);
        findings.push(finding(fault, &one.data, is_held_out, place));
    }
    mend_sensors(&mut sets, &faults);
    measurements.iter_mut().zip(sets).for_each(|(one, set)| one.data = set);
    faults
}

/// Whether nothing can be made of the measurement. An old model looks like a table that is active: in data held out both are for the reader.
fn is_refused(fault: &Fault, is_held_out: bool) -> bool {
    fault.then == Then::Refuse
        && !(is_held_out && [DefectKind::Compensated, DefectKind::Topology].contains(&fault.kind))
}

/// What the search goes without.
fn excluded(fault: &Fault, is_held_out: bool) -> String {
    match &fault.then {
        _ if is_refused(fault, is_held_out) => "the whole file".into(),
        Then::WithoutSensors(names) => format!("what {} says, as a cause", names.join(" and ")),
        Then::InFahrenheit(name) => format!("nothing; {name} counts in °C"),
        _ if is_held_out => "nothing: the file is held out, and judges as it is".into(),
        Then::Refuse => "the whole file".into(),
        Then::WithoutRows => "these rows".into(),
        Then::WithoutReadings(readings) if is_range(fault) => format!("{} readings in these rows", readings.len()),
        Then::WithoutReadings(readings) => format!("{} single readings", readings.len()),
        Then::OwnZero => "nothing; the rows behind the step have a zero of their own".into(),
        Then::Nothing => "nothing".into(),
        Then::MoreNoise(_) => "nothing; the readings count with more noise".into(),
    }
}

/// Readings that are far out are single ones, all others those of some rows.
fn is_range(fault: &Fault) -> bool {
    fault.kind != DefectKind::Outlier
}

fn reported(fault: &Fault, set: &DataSet, is_held_out: bool) -> DataFault {
    let rows = match &fault.then {
        // Single readings are no range.
        Then::WithoutReadings(readings) if !is_range(fault) => {
            let mut rows: Vec<usize> = readings.iter().map(|(row, _)| row + 1).collect();
            rows.dedup();
            rows
        }
        _ => fault.rows.map(|row| row + 1).to_vec(),
    };
    DataFault {
        kind: fault.kind,
        name: fault.name.clone(),
        what: fault.what.clone(),
        rows,
        file: set.name.clone(),
        evidence: fault.evidence.clone(),
        excluded: excluded(fault, is_held_out),
        is_range: is_range(fault),
    }
}

/// The first row, in the column that is at fault where there is one.
fn place(fault: &Fault, source: &Source) -> Option<Place> {
    let table = Table::read(source).0?;
    let column = fault.name.split(' ').next().and_then(|name| table.column(name));
    let whole = [Then::Refuse].contains(&fault.then) || matches!(fault.then, Then::MoreNoise(_) | Then::Nothing);
    if whole {
        return Some(table.header_place(column));
    }
    Some(table.rows().nth(fault.rows[0])?.place(column.unwrap_or(0)))
}

fn finding(fault: &Fault, set: &DataSet, is_held_out: bool, place: Option<Place>) -> Diagnostic {
    let name = if fault.name == set.name { String::new() } else { format!(" {}", fault.name) };
    let of = if is_held_out { "held out, " } else { "" };
    let rows = match &fault.then {
        Then::Refuse | Then::Nothing | Then::MoreNoise(_) => String::new(),
        Then::WithoutReadings(_) if !is_range(fault) => String::new(),
        _ => format!(" in rows {} to {}", fault.rows[0] + 1, fault.rows[1] + 1),
    };
    let message = format!("{of}{}{name}: {}{rows}: {}", set.name, fault.what, fault.evidence);
    let is_refused = is_refused(fault, is_held_out);
    let help = match fault.kind {
        DefectKind::Unit => {
            "convert the column to the unit that its name says, and check sigma_um (or sigma_urad) in the description".into()
        }
        DefectKind::Positions => {
            "check the unit of the readings, the columns of positions, and centre_mm and length_mm in the description".into()
        }
        DefectKind::Axes => "exchange or turn the columns, or check how the instrument was mounted; then diagnose again".into(),
        DefectKind::Topology => {
            "check topology and direction of the axes in the machine file; errors that it knows act elsewhere on another machine"
                .into()
        }
        DefectKind::Compensated if is_refused => {
            "measure with the table of the control switched off, or give with --machine what the control does not take out"
                .into()
        }
        DefectKind::Sensor if matches!(fault.then, Then::InFahrenheit(_)) => {
            "converted for this diagnosis; convert the column, (°F − 32) / 1.8, for all that reads it".into()
        }
        DefectKind::Compensated => "check whether a table of the control was active; if not, the model has expired".into(),
        DefectKind::Order => "give the rows in the order in which they were taken, or the senses of motion in columns X_dir …".into(),
        _ => format!("left out: {}", excluded(fault, is_held_out)),
    };
    let code = if is_refused { Code::DATA_FAULT } else { Code::FAULTY_DATA };
    match place {
        Some(place) => Diagnostic::at(code, place, message, help),
        None => Diagnostic::nowhere(code, message, help),
    }
}
