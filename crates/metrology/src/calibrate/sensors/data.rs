//! Records of drift: a log of temperatures with displacements in it.
//!
//! A table with `t_s`, `T_NAME_C` for every sensor and `dx_um`, `dy_um`, `dz_um` (any of them): displacement of the tool relative to the workpiece
//! along F's directions. Columns with axis letters (mm, deg) give the measuring position; the axis with varying positions is the one over which the
//! drift is given. One table is one run, whose drift is relative to its first reading. Temperatures may be in a separate log with the same clock. An
//! empty cell is not a reading.

use ncfix_base::csv::{DecimalSign, Table};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::source::Source;
use ncfix_machine::machine::condition::log;
use ncfix_machine::machine::{Condition, Machine};

/// Maximum number of measuring positions; more indicate a moving axis.
const MOST_POSITIONS: usize = 20;
/// Maximum number of sensors; an exact search through more would take too long.
const MOST_SENSORS: usize = 64;
/// Maximum number of diagnostics.
const MOST_FINDINGS: usize = 50;
const COLUMNS: [&str; 3] = ["dx_um", "dy_um", "dz_um"];

/// One run.
#[derive(Clone, Debug)]
pub struct SensorRun {
    /// Name of its file.
    pub name: String,
    /// Time of every row, s, not decreasing.
    pub times_s: Vec<f64>,
    /// Displacement of every row along X, Y and Z, µm.
    pub drift_um: Vec<[Option<f64>; 3]>,
    /// Positions of the axes with a column, mm or degrees.
    pub positions: Vec<(Axis, Vec<f64>)>,
    /// Temperatures.
    pub condition: Condition,
    /// The header, for diagnostics.
    pub place: Place,
    /// Warnings that do not prevent its use.
    pub warnings: Vec<Diagnostic>,
}

impl SensorRun {
    /// Position of an axis in a row.
    #[must_use]
    pub fn position(&self, axis: Axis, row: usize) -> Option<f64> {
        self.positions.iter().find(|(known, _)| *known == axis).and_then(|(_, values)| values.get(row).copied())
    }
}

/// Reads a run; temperatures come from `temperatures` if given, otherwise from the table itself.
///
/// # Errors
/// Diagnostics for cells that are not numbers, missing columns and contradictory readings.
pub fn read(
    source: &Source,
    temperatures: Option<&Condition>,
    machine: &Machine,
) -> Result<SensorRun, Vec<Diagnostic>> {
    let (table, mut findings) = Table::read(source);
    let Some(table) = table else { return Err(findings) };
    let condition = match temperatures {
        Some(condition) => Some(condition.clone()),
        None => {
            let (condition, found) = log::load_with_dead(source);
            findings.extend(found);
            condition
        }
    };
    let place = table.header_place(None);
    let drift = COLUMNS.map(|name| table.column(name));
    let time = table.column("t_s");
    let (Some(time), true) = (time, drift.iter().any(Option::is_some)) else {
        let missing = if time.is_none() { "t_s" } else { "dx_um, dy_um or dz_um" };
        let help = format!("add {missing}: t_s is the time in s, dx_um … the displacement of the tool in µm");
        findings.push(Diagnostic::at(Code::DATA_COLUMN, place, format!("there is no column {missing}"), help));
        return Err(findings);
    };
    let axes: Vec<(Axis, usize)> =
        AXES.into_iter().filter_map(|axis| Some((axis, table.column(&axis.to_string())?))).collect();
    for &(axis, column) in axes.iter().filter(|(axis, _)| machine.axis(*axis).is_none()) {
        let message = format!("the machine {} has no axis {axis}", machine.name);
        let help = "check --machine, or rename the column if it is something else";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(Some(column)), message, help));
    }
    let numbers: Vec<usize> =
        [time].into_iter().chain(drift.into_iter().flatten()).chain(axes.iter().map(|&(_, column)| column)).collect();
    let sign = table.decimal_sign(&numbers).unwrap_or_else(|finding| {
        findings.push(finding);
        DecimalSign::Point
    });
    let mut run = SensorRun {
        name: source.name().to_owned(),
        times_s: Vec::new(),
        drift_um: Vec::new(),
        positions: axes.iter().map(|&(axis, _)| (axis, Vec::new())).collect(),
        condition: condition.unwrap_or_default(),
        warnings: Vec::new(),
        place,
    };
    for row in table.rows() {
        let mut number = |column: usize| match row.number(column, sign) {
            Ok(value) => Some(value),
            Err(finding) => {
                // The log has already reported it.
                if column != time || temperatures.is_some() {
                    findings.push(finding);
                }
                None
            }
        };
        let time_s = number(time);
        let values = drift.map(|column| column.filter(|&column| !row.text(column).is_empty()).and_then(&mut number));
        let positions: Vec<Option<f64>> = axes.iter().map(|&(_, column)| number(column)).collect();
        if findings.iter().filter(|finding| finding.is_error()).count() >= MOST_FINDINGS {
            break;
        }
        let (Some(time_s), false) = (time_s, positions.contains(&None)) else { continue };
        if run.times_s.last().is_some_and(|&last_s| time_s < last_s) {
            if temperatures.is_some() {
                let message = format!("the time decreases to {time_s} s");
                let help = "sort the rows by time, and give every run its own table";
                findings.push(Diagnostic::at(Code::DATA_CELL, row.place(time), message, help));
            }
            continue;
        }
        run.times_s.push(time_s);
        run.drift_um.push(values);
        for ((_, values), position) in run.positions.iter_mut().zip(positions) {
            values.extend(position);
        }
    }
    if !run.condition.has_temperatures() && !findings.iter().any(Diagnostic::is_error) {
        let help = "name each temperature column after its sensor with the ending _C: T_head_C for T_head";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, place, "there is no temperature column", help));
    }
    let sensors = run.condition.sensors().count();
    if sensors > MOST_SENSORS {
        let message = format!("there are {sensors} sensors; the search allows at most {MOST_SENSORS}");
        let help = "remove columns of sensors that are far from heat sources, or read the same as others";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, place, message, help));
    }
    if findings.iter().any(Diagnostic::is_error) {
        return Err(findings);
    }
    run.warnings = findings;
    Ok(run)
}

/// The axis over which the drift was measured, with its positions in ascending order; `None` for a single position.
///
/// # Errors
/// A diagnostic if several axes have moved, or one continuously.
pub fn over(runs: &[SensorRun]) -> Result<Option<(Axis, Vec<f64>)>, Diagnostic> {
    let mut found: Option<(Axis, Vec<f64>)> = None;
    for axis in AXES {
        let mut values: Vec<f64> = Vec::new();
        for (_, positions) in runs.iter().flat_map(|run| &run.positions).filter(|(known, _)| *known == axis) {
            values.extend(positions);
        }
        values.sort_by(f64::total_cmp);
        values.dedup();
        let Some(first) = runs.iter().find(|run| run.positions.iter().any(|(known, _)| *known == axis)) else {
            continue;
        };
        if values.len() < 2 {
            continue;
        }
        let fault = |place, message: String, help: &str| Err(Diagnostic::at(Code::DATA_COLUMN, place, message, help));
        if let Some((other, _)) = found {
            let help =
                "a drift is given over one axis; remove the column of the other one if the drift does not depend on it";
            return fault(
                first.place,
                format!("the drift was measured at several positions of {other} and of {axis}"),
                help,
            );
        }
        if values.len() > MOST_POSITIONS {
            let help = "write the commanded positions, at most 20 different ones; a drift is measured at rest";
            return fault(first.place, format!("the drift was measured at {} positions of {axis}", values.len()), help);
        }
        if let Some(run) = runs.iter().find(|run| run.positions.iter().all(|(known, _)| *known != axis)) {
            let help = "every run needs the column of an axis whose position changes in any run";
            return fault(run.place, format!("{} has no column {axis}", run.name), help);
        }
        found = Some((axis, values));
    }
    Ok(found)
}
