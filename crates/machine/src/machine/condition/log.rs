//! Machine log: readings with time stamps, a text table with a header line.
//!
//! ```text
//! t_s,T_head_C,T_column_C,load_N,load_z_mm
//! 0,21.4,20.9,0,0
//! 60,21.9,,1700,-280
//! ```
//!
//! The columns are those of [`super::columns`]; `t_s` never decreases.
//!
//! Other columns are ignored. An empty cell is not a reading: temperatures are interpolated linearly between the existing readings, a load stays.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::pattern::{RegexSet, patterns};
use ncfix_base::source::Source;

use super::columns::{ConditionColumn, NO_LOAD, OfDead, check_load, read_cell};
use super::file::READABLE_C;
use super::{Condition, ConditionLog, Load};

/// Maximum number of diagnostics; more are of no use.
const MOST_FINDINGS: usize = 50;

/// True if a file looks like a log and not like a state file, whose first line is a comment, a section or a key with its value.
#[must_use]
pub fn is_log(source: &Source) -> bool {
    static LOG: LazyLock<RegexSet> =
        LazyLock::new(|| patterns([r"^[ \t\n\r\x0c]*(?:sep=|[^#\[= \t\n\r\x0c][^=\r\n]*(?:[\r\n]|$))"]));
    let bytes = source.bytes();
    LOG.is_match(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

/// Reads a log and reports all diagnostics in one run. The condition is that of the last row; it is `None` if any diagnostic is an error.
#[must_use]
pub fn load(source: &Source) -> (Option<Condition>, Vec<Diagnostic>) {
    load_as(source, OfDead::Refused)
}

/// Reads a log in which sensors may be dead in some rows. These rows are ignored for the sensor, with a warning.
#[must_use]
pub fn load_with_dead(source: &Source) -> (Option<Condition>, Vec<Diagnostic>) {
    load_as(source, OfDead::Empty)
}

fn load_as(source: &Source, of_dead: OfDead) -> (Option<Condition>, Vec<Diagnostic>) {
    let (table, mut findings) = Table::read(source);
    let Some(table) = table else { return (None, findings) };
    let columns = ConditionColumn::all(&table);
    check_columns(&table, &columns, &mut findings);
    let numbers: Vec<usize> =
        (0..columns.len()).filter(|&column| columns.get(column) != Some(&ConditionColumn::Other)).collect();
    let sign = match table.decimal_sign(&numbers) {
        Ok(sign) => sign,
        Err(finding) => {
            findings.push(finding);
            return (None, findings);
        }
    };
    let mut readings = Readings::new(columns, sign, of_dead);
    for row in table.rows() {
        readings.read_row(&row, &mut findings);
        if findings.len() >= MOST_FINDINGS {
            break;
        }
    }
    readings.tell_dead(&mut findings);
    if readings.time_s.is_none() && findings.is_empty() {
        let help = "add at least one row of readings";
        findings.push(Diagnostic::at(Code::DATA_NO_TABLE, table.header_place(None), "the log has no rows", help));
    }
    let sound = !findings.iter().any(Diagnostic::is_error);
    (sound.then(|| readings.condition()), findings)
}

fn check_columns(table: &Table, columns: &[ConditionColumn], findings: &mut Vec<Diagnostic>) {
    let mut report = |message: &str, help: &str| {
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), message, help));
    };
    if !columns.contains(&ConditionColumn::Time) {
        report("the log has no column t_s", "add a column t_s with the time of each row in s");
    }
    let says_something = |column: &ConditionColumn| {
        matches!(column, ConditionColumn::Sensor(_) | ConditionColumn::Force | ConditionColumn::LoadPlace(_))
    };
    if !columns.iter().any(says_something) {
        let help = "name each temperature column after its sensor with the ending _C: T_head_C for the sensor T_head";
        report("the log has no temperature column and no load column", help);
    }
    check_load(table, columns, findings);
}

/// Readings so far.
struct Readings {
    columns: Vec<ConditionColumn>,
    sign: DecimalSign,
    /// Readings by column.
    traces: Vec<ConditionLog>,
    time_s: Option<f64>,
    /// Last load.
    load: Load,
    loads: Vec<(f64, Load)>,
    of_dead: OfDead,
    /// Dead sensors by column: first place, value there, and number of rows.
    dead: BTreeMap<usize, (Place, String, usize)>,
}

impl Readings {
    fn new(columns: Vec<ConditionColumn>, sign: DecimalSign, of_dead: OfDead) -> Readings {
        let traces = vec![ConditionLog::default(); columns.len()];
        let dead = BTreeMap::new();
        Readings { columns, sign, traces, time_s: None, load: NO_LOAD, loads: Vec::new(), of_dead, dead }
    }

    /// Reports the dead sensors.
    fn tell_dead(&self, findings: &mut Vec<Diagnostic>) {
        for (column, (place, value, rows)) in &self.dead {
            let Some(ConditionColumn::Sensor(sensor)) = self.columns.get(*column) else { continue };
            let message =
                format!("{sensor} is dead: {value} °C is not a temperature that a sensor can have (in {rows} rows)");
            let help = "its readings in these rows are ignored; check its plug and cable";
            findings.push(Diagnostic::at(Code::FAULTY_DATA, *place, message, help));
        }
    }

    fn read_row(&mut self, row: &Row<'_>, findings: &mut Vec<Diagnostic>) {
        let time_s = match self.read_time(row) {
            Ok(time_s) => time_s,
            Err(finding) => return findings.extend(finding),
        };
        let last = self.load;
        for (index, (column, trace)) in self.columns.iter().zip(&mut self.traces).enumerate() {
            match read_cell(row, index, column, self.sign, &mut self.load, (self.of_dead, READABLE_C)) {
                Ok(Some(value)) if matches!(column, ConditionColumn::Sensor(_)) => trace.add(time_s, value),
                Ok(None) if matches!(column, ConditionColumn::Sensor(_)) && !row.text(index).is_empty() => {
                    let value = String::from_utf8_lossy(row.text(index)).into_owned();
                    let dead = self.dead.entry(index).or_insert((row.place(index), value, 0));
                    dead.2 += 1;
                }
                Ok(_) => {}
                Err(finding) => findings.push(finding),
            }
        }
        if self.load != last {
            self.loads.push((time_s, self.load));
        }
    }

    /// Reads the time of a row, which must not be earlier than the last one.
    fn read_time(&mut self, row: &Row<'_>) -> Result<f64, Option<Diagnostic>> {
        let column = self.columns.iter().position(|column| *column == ConditionColumn::Time).ok_or(None)?;
        let time_s = row.number(column, self.sign)?;
        if let Some(last_s) = self.time_s.filter(|&last_s| time_s < last_s) {
            let message = format!("the time decreases from {last_s} s to {time_s} s");
            let help = "sort the rows by time, and use a separate log for each run";
            return Err(Some(Diagnostic::at(Code::DATA_CELL, row.place(column), message, help)));
        }
        self.time_s = Some(time_s);
        Ok(time_s)
    }

    fn condition(self) -> Condition {
        let mut condition = Condition::default();
        for (column, trace) in self.columns.iter().zip(self.traces) {
            if let ConditionColumn::Sensor(sensor) = column
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
