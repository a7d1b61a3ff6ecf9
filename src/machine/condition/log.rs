//! The log of a machine: readings with time stamps, a table of text with a line of column names.
//!
//! ```text
//! t_s,T_head_C,T_column_C,load_N,load_z_mm
//! 0,21.4,20.9,0,0
//! 60,21.9,,1700,-280
//! ```
//!
//! | column | meaning |
//! | --- | --- |
//! | `t_s` | time; it does not go back |
//! | `T_head_C` | temperature of the sensor `T_head`, as the machine file calls it: the name of the column without `_C` |
//! | `load_N`, `load_x_mm`, `load_y_mm`, `load_z_mm` | weight on the table and its place, from this row on |
//!
//! Other columns are for others. An empty cell is no reading: temperatures are linear between the readings that there are, a load stays.

use crate::csv::{DecimalSign, Row, Table};
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::Vector;
use crate::source::Source;

use super::file::PLAUSIBLE_C;
use super::{Condition, Load, Trace};

/// More findings than this help nobody.
const MOST_FINDINGS: usize = 50;

/// What a column holds.
#[derive(Clone, Debug, PartialEq)]
enum Column {
    Time,
    Sensor(String),
    Force,
    /// x, y or z of the place of the load.
    LoadPlace(usize),
    Other,
}

impl Column {
    fn of(name: &str) -> Column {
        match name {
            "t_s" => Column::Time,
            "load_N" => Column::Force,
            "load_x_mm" => Column::LoadPlace(0),
            "load_y_mm" => Column::LoadPlace(1),
            "load_z_mm" => Column::LoadPlace(2),
            other => match other.strip_suffix("_C") {
                Some(sensor) if !sensor.is_empty() => Column::Sensor(sensor.to_owned()),
                _ => Column::Other,
            },
        }
    }
}

/// Whether a file looks like a log and not like a state file, whose first line is a comment, a section or a key with its value.
#[must_use]
pub fn is_log(source: &Source) -> bool {
    let bytes = source.bytes();
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let first = bytes.split(|&byte| byte == b'\n' || byte == b'\r').next().unwrap_or_default();
    let is_separator_line = first.to_ascii_lowercase().starts_with(b"sep=");
    !first.is_empty()
        && !first.starts_with(b"#")
        && !first.starts_with(b"[")
        && (is_separator_line || !first.contains(&b'='))
}

/// Reads a log; the condition is that of its last row. All findings are reported in one run; there is a condition only where none of them
/// is an error.
#[must_use]
pub fn load(source: &Source) -> (Option<Condition>, Vec<Diagnostic>) {
    let (table, mut findings) = Table::read(source);
    let Some(table) = table else { return (None, findings) };
    let columns: Vec<Column> = table.names().iter().map(|name| Column::of(name)).collect();
    check_columns(&table, &columns, &mut findings);
    let numbers: Vec<usize> =
        (0..columns.len()).filter(|&column| columns.get(column) != Some(&Column::Other)).collect();
    let sign = match table.decimal_sign(&numbers) {
        Ok(sign) => sign,
        Err(finding) => {
            findings.push(finding);
            return (None, findings);
        }
    };
    let mut readings = Readings::new(columns, sign);
    for row in table.rows() {
        readings.read_row(&row, &mut findings);
        if findings.len() >= MOST_FINDINGS {
            break;
        }
    }
    if readings.time_s.is_none() && findings.is_empty() {
        let help = "add at least one row of readings";
        findings.push(Diagnostic::at(Code::DATA_NO_TABLE, table.header_place(None), "the log has no rows", help));
    }
    let sound = !findings.iter().any(Diagnostic::is_error);
    (sound.then(|| readings.condition()), findings)
}

fn check_columns(table: &Table, columns: &[Column], findings: &mut Vec<Diagnostic>) {
    let mut report = |message: &str, help: &str| {
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), message, help));
    };
    if !columns.contains(&Column::Time) {
        report("the log has no column t_s", "add a column t_s with the time of each row in s");
    }
    let has_force = columns.contains(&Column::Force);
    if !has_force && columns.iter().any(|column| matches!(column, Column::LoadPlace(_))) {
        let help = "add a column load_N with the weight, or remove the place";
        report("the log has the place of a load but not load_N", help);
    } else if !has_force && !columns.iter().any(|column| matches!(column, Column::Sensor(_))) {
        let help = "name the columns of temperatures like their sensors with _C behind, T_head_C for the sensor T_head";
        report("the log has no column of a temperature or a load", help);
    }
}

/// What was read so far.
struct Readings {
    columns: Vec<Column>,
    sign: DecimalSign,
    /// By column.
    traces: Vec<Trace>,
    time_s: Option<f64>,
    /// The last load.
    load: Load,
    loads: Vec<(f64, Load)>,
}

impl Readings {
    fn new(columns: Vec<Column>, sign: DecimalSign) -> Readings {
        let traces = vec![Trace::default(); columns.len()];
        let load = Load { force_n: 0.0, position_mm: Vector::zeros() };
        Readings { columns, sign, traces, time_s: None, load, loads: Vec::new() }
    }

    fn read_row(&mut self, row: &Row<'_>, findings: &mut Vec<Diagnostic>) {
        let time_s = match self.read_time(row) {
            Ok(time_s) => time_s,
            Err(finding) => return findings.extend(finding),
        };
        let last = self.load;
        for index in 0..self.columns.len() {
            if !row.text(index).is_empty()
                && let Err(finding) = self.read_cell(row, index, time_s)
            {
                findings.push(finding);
            }
        }
        if self.load != last {
            self.loads.push((time_s, self.load));
        }
    }

    /// The time of a row that is not before the last one.
    fn read_time(&mut self, row: &Row<'_>) -> Result<f64, Option<Diagnostic>> {
        let column = self.columns.iter().position(|column| *column == Column::Time).ok_or(None)?;
        let time_s = row.number(column, self.sign)?;
        if let Some(last_s) = self.time_s.filter(|&last_s| time_s < last_s) {
            let message = format!("the time goes back from {last_s} s to {time_s} s");
            let help = "sort the rows by time, and keep logs of different runs apart";
            return Err(Some(Diagnostic::at(Code::DATA_CELL, row.place(column), message, help)));
        }
        self.time_s = Some(time_s);
        Ok(time_s)
    }

    fn read_cell(&mut self, row: &Row<'_>, index: usize, time_s: f64) -> Result<(), Diagnostic> {
        let Some(column) = self.columns.get(index).filter(|column| !matches!(column, Column::Time | Column::Other))
        else {
            return Ok(());
        };
        let value = row.number(index, self.sign)?;
        let fault = |message: String, help: &str| Err(Diagnostic::at(Code::DATA_CELL, row.place(index), message, help));
        let [low, high] = PLAUSIBLE_C;
        match column {
            Column::Sensor(_) if !(low..=high).contains(&value) => {
                let help = "leave the cell empty where a sensor has no reading; temperatures are -30 to 150 °C";
                return fault(format!("{value} °C is no temperature of a machine"), help);
            }
            Column::Force if value < 0.0 => {
                return fault(format!("{value} N is no weight"), "write the weight in N, 0 for an empty table");
            }
            Column::Sensor(_) => self.traces.get_mut(index).into_iter().for_each(|trace| trace.add(time_s, value)),
            Column::Force => self.load.force_n = value,
            Column::LoadPlace(axis) => self.load.position_mm[*axis] = value,
            Column::Time | Column::Other => {}
        }
        Ok(())
    }

    fn condition(self) -> Condition {
        let mut condition = Condition::default();
        for (column, trace) in self.columns.iter().zip(self.traces) {
            if let Column::Sensor(sensor) = column
                && !trace.points().is_empty()
            {
                condition.set_trace(sensor, trace);
            }
        }
        for (time_s, load) in self.loads {
            condition.add_load_change(time_s, load);
        }
        condition.set_time(self.time_s.unwrap_or_default());
        condition
    }
}
