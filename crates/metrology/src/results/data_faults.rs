//! Faults of the data, the first step of a diagnosis: reports them, rejects files that do not describe their measurement, and excludes faulty data.
//!
//! Rows of held-out data always stay: they are the independent test and must not be selected. However, the readings of a faulty sensor are dropped,
//! rows without temperatures are left out, and a file in another unit or with other axes is rejected, because it tests nothing.

use serde::Serialize;

use super::measurement::{Measurement, data_of};
use crate::diagnose::Scene;
use crate::diagnose::fault::{Checks, DataDefect, DefectKind, Then, find_with, mend_sensors};
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
    /// Its description.
    pub what: String,
    /// Rows from 1: the first and the last, or each row of outliers.
    pub rows: Vec<usize>,
    /// The measurement.
    pub file: String,
    /// Evidence.
    pub evidence: String,
    /// Data excluded because of it.
    pub excluded: String,
    /// True if [`Self::rows`] are a first and a last row, and not individual rows.
    #[serde(skip)]
    pub is_range: bool,
}

/// Searches measurements for faults, of which the first `used` are used and the others held out, and removes faulty sensors. The returned faults
/// serve to exclude rows of the used ones from a scene with [`crate::diagnose::fault::exclude`].
pub(super) fn look(
    of: (&Machine, &ErrorModel, &Checks),
    all: &mut [Measurement],
    used: usize,
    findings: &mut Vec<Diagnostic>,
    report: &mut Vec<DataFault>,
) -> Vec<DataDefect> {
    let (own, held_out) = all.split_at_mut(used.min(all.len()));
    let used = own.len();
    let mut faults = look_in(of, (own, false), findings, report);
    let of_held_out = look_in(of, (held_out, true), findings, report);
    // Rows without temperatures test no cause that needs them. Their readings were not used to find these rows, so this is not a selection.
    let missing =
        of_held_out.into_iter().filter(|fault| matches!(fault.then, Then::WithoutTemperatures(_) | Then::ShiftLog(_)));
    faults.extend(missing.map(|fault| DataDefect { set: used + fault.set, ..fault }));
    faults
}

fn look_in(
    (machine, errors, checks): (&Machine, &ErrorModel, &Checks),
    (measurements, is_held_out): (&mut [Measurement], bool),
    findings: &mut Vec<Diagnostic>,
    report: &mut Vec<DataFault>,
) -> Vec<DataDefect> {
    let mut sets = data_of(measurements);
    // If the readings do not even determine the set-ups, a later step reports it.
    let mut faults = Scene::new(machine, errors, &sets).map_or_else(|_| Vec::new(), |scene| find_with(checks, &scene));
    // Held-out rows stay; only the sensor is dropped.
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

/// `true` if the measurement is unusable. An outdated model resembles an active table, so in held-out data both are left to the user.
fn is_refused(fault: &DataDefect, is_held_out: bool) -> bool {
    fault.then == Then::Refuse
        && !(is_held_out && [DefectKind::Compensated, DefectKind::Topology].contains(&fault.kind))
}

/// Data that the search excludes.
fn excluded(fault: &DataDefect, is_held_out: bool) -> String {
    match &fault.then {
        _ if is_refused(fault, is_held_out) => "the whole file".into(),
        Then::WithoutSensors(names) => format!("the effect of {}, as a cause", names.join(" and ")),
        Then::InFahrenheit(name) => format!("nothing; {name} counts in °C"),
        Then::WithoutTemperatures(missing) if missing.uncounted.is_empty() => {
            "these values of the sensor, which its neighbors bridge".into()
        }
        Then::WithoutTemperatures(_) => "these rows".into(),
        Then::ShiftLog(log) if log.uncounted.is_empty() => "nothing; the log is shifted".into(),
        Then::ShiftLog(_) => "the rows outside the shifted log".into(),
        _ if is_held_out => "nothing: the file is held out and used unchanged".into(),
        Then::Refuse => "the whole file".into(),
        Then::WithoutRows => "these rows".into(),
        Then::WithoutReadings(readings) if is_range(fault) => format!("{} readings in these rows", readings.len()),
        Then::WithoutReadings(readings) if readings.len() == 1 => "1 single reading".into(),
        Then::WithoutReadings(readings) => format!("{} single readings", readings.len()),
        Then::OwnZero => "nothing; the rows after the step have their own zero".into(),
        Then::Nothing => "nothing".into(),
        Then::MoreNoise(_) => "no reading; ncfix assumes a larger noise".into(),
    }
}

/// Outliers are single readings; all other faults affect ranges of rows.
fn is_range(fault: &DataDefect) -> bool {
    fault.kind != DefectKind::Outlier
}

fn reported(fault: &DataDefect, set: &DataSet, is_held_out: bool) -> DataFault {
    let rows = match &fault.then {
        // Single readings are not a range.
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

/// The first row, in the faulty column if there is one.
fn place(fault: &DataDefect, source: &Source) -> Option<Place> {
    let table = Table::read(source).0?;
    let first = match &fault.then {
        Then::WithoutTemperatures(missing) => missing.sensors.first().map(String::as_str),
        Then::WithoutSensors(names) => names.first().map(String::as_str),
        _ => fault.name.split(' ').next(),
    };
    let column = first.and_then(|name| table.column(name));
    let whole = [Then::Refuse].contains(&fault.then) || matches!(fault.then, Then::MoreNoise(_) | Then::Nothing);
    if whole {
        return Some(table.header_place(column));
    }
    Some(table.rows().nth(fault.rows[0])?.place(column.unwrap_or(0)))
}

fn finding(fault: &DataDefect, set: &DataSet, is_held_out: bool, place: Option<Place>) -> Diagnostic {
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
            "convert the column to the unit in its name, and check sigma_um (or sigma_urad) in the description".into()
        }
        DefectKind::Positions => {
            "check the unit of the readings, the columns of positions, and centre_mm and length_mm in the description".into()
        }
        DefectKind::Axes => "exchange or turn the columns, or check how the instrument was mounted; then diagnose again".into(),
        DefectKind::Topology => {
            "check topology and direction of the axes in the machine file; its errors act differently on another machine"
                .into()
        }
        DefectKind::Compensated if is_refused => {
            "if a table of the control was active, name it in active_tables of the machine file, or measure with the table switched off; if the error was repaired, remove it from the machine file"
                .into()
        }
        DefectKind::Sensor if matches!(fault.then, Then::InFahrenheit(_)) => {
            "converted for this diagnosis; convert the column, (°F − 32) / 1.8, for all users of the file".into()
        }
        DefectKind::Compensated => "check whether a table of the control was active; if not, the model no longer fits the machine".into(),
        DefectKind::Order => "give the rows in the order of measurement, or the directions of motion in columns X_dir …".into(),
        _ => format!("excluded: {}", excluded(fault, is_held_out)),
    };
    let code = if is_refused { Code::DATA_FAULT } else { Code::FAULTY_DATA };
    match place {
        Some(place) => Diagnostic::at(code, place, message, help),
        None => Diagnostic::nowhere(code, message, help),
    }
}
