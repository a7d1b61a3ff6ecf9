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
//! Cells are separated by commas, by semicolons or tabs (then decimals may have a comma), texts may be in quotation marks.

use crate::diagnostic::{Code, Diagnostic, Place};
use crate::geometry::Vector;
use crate::source::{Source, Span};

use super::file::PLAUSIBLE_C;
use super::{Condition, Load, Trace};

/// More findings than this help nobody.
const MOST_FINDINGS: usize = 50;

/// No message shows more of a cell.
const LONGEST_SHOWN: usize = 40;

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

/// Reads a log; the condition is that of its last row. All findings are reported in one run; there is a condition only where none of them
/// is an error.
#[must_use]
pub fn load(source: &Source) -> (Option<Condition>, Vec<Diagnostic>) {
    let mut reader = Reader { source, separator: b',', findings: Vec::new() };
    let condition = reader.read();
    let sound = !reader.findings.iter().any(Diagnostic::is_error);
    (condition.filter(|_| sound), reader.findings)
}

/// Whether a file looks like a log and not like a state file, whose first line is a comment, a section or a key with its value.
#[must_use]
pub fn is_log(source: &Source) -> bool {
    let mut lines = Lines { bytes: source.bytes(), at: 0, line_end: source.line_end() };
    let first = lines.next().map(|line| source.slice(line)).unwrap_or_default();
    let first = first.trim_ascii_start();
    !first.is_empty() && !first.starts_with(b"#") && !first.starts_with(b"[") && !first.contains(&b'=')
}

struct Reader<'a> {
    source: &'a Source,
    separator: u8,
    findings: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn read(&mut self) -> Option<Condition> {
        let bytes = self.source.bytes();
        let mut lines = Lines { bytes, at: 0, line_end: self.source.line_end() };
        if bytes.starts_with(b"\xef\xbb\xbf") {
            lines.at = 3;
        }
        if let Some(at) = bytes.iter().position(|&byte| byte == 0) {
            let message = "this is no text of single bytes; it looks like UTF-16 or a workbook";
            self.report(Code::BAD_VALUE, Span::new(at, at + 1), message, "save it as CSV in UTF-8");
            return None;
        }
        let Some(header) = lines.next() else {
            self.report(Code::MISSING_KEY, Span::default(), "the log is empty", "begin it with a line of column names");
            return None;
        };
        let has = |byte: u8| self.source.slice(header).contains(&byte);
        self.separator = if has(b';') {
            b';'
        } else if has(b'\t') {
            b'\t'
        } else {
            b','
        };
        let columns = self.read_header(header);
        if !self.findings.is_empty() {
            return None;
        }
        let mut table = Readings::new(columns);
        let mut cells = Vec::new();
        for line in lines {
            self.split(line, &mut cells);
            if cells.iter().any(|cell| !self.source.slice(*cell).is_empty()) {
                self.read_row(line, &cells, &mut table);
            }
            if self.findings.len() >= MOST_FINDINGS {
                break;
            }
        }
        if table.time_s.is_none() && self.findings.is_empty() {
            self.report(Code::MISSING_KEY, header, "the log has no rows", "add at least one row of readings");
        }
        Some(table.condition())
    }

    fn read_header(&mut self, header: Span) -> Vec<Column> {
        let mut cells = Vec::new();
        self.split(header, &mut cells);
        let mut columns: Vec<Column> = Vec::new();
        for cell in cells {
            let name = String::from_utf8_lossy(self.source.slice(cell)).into_owned();
            let column = match name.as_str() {
                "t_s" => Column::Time,
                "load_N" => Column::Force,
                "load_x_mm" => Column::LoadPlace(0),
                "load_y_mm" => Column::LoadPlace(1),
                "load_z_mm" => Column::LoadPlace(2),
                other => match other.strip_suffix("_C") {
                    Some(sensor) if !sensor.is_empty() => Column::Sensor(sensor.to_owned()),
                    _ => Column::Other,
                },
            };
            if column != Column::Other && columns.contains(&column) {
                let help = "rename or remove one of them";
                self.report(Code::BAD_VALUE, cell, format!("the column {name} is there twice"), help);
            }
            columns.push(column);
        }
        if !columns.contains(&Column::Time) {
            let help = "add a column t_s with the time of each row in s";
            self.report(Code::MISSING_KEY, header, "the log has no column t_s", help);
        }
        let has_force = columns.contains(&Column::Force);
        if !has_force && columns.iter().any(|column| matches!(column, Column::LoadPlace(_))) {
            let help = "add a column load_N with the weight, or remove the place";
            self.report(Code::MISSING_KEY, header, "the log has the place of a load but not load_N", help);
        } else if !has_force && !columns.iter().any(|column| matches!(column, Column::Sensor(_))) {
            let help =
                "name the columns of temperatures like their sensors with _C behind, T_head_C for the sensor T_head";
            self.report(Code::MISSING_KEY, header, "the log has no column of a temperature or a load", help);
        }
        columns
    }

    fn read_row(&mut self, line: Span, cells: &[Span], table: &mut Readings) {
        let surplus = cells.get(table.columns.len()..).unwrap_or_default();
        if cells.len() < table.columns.len() || surplus.iter().any(|cell| !self.source.slice(*cell).is_empty()) {
            let message = format!("this row has {} cells, the header {}", cells.len(), table.columns.len());
            self.report(Code::BAD_VALUE, line, message, "give every row a cell for each column, empty without reading");
            return;
        }
        let Some(time_s) = self.read_time(line, cells, table) else { return };
        let mut is_load_stated = false;
        for (index, &cell) in cells.iter().enumerate().take(table.columns.len()) {
            let (column, trace) = (&table.columns[index], &mut table.traces[index]);
            if matches!(column, Column::Time | Column::Other) || self.source.slice(cell).is_empty() {
                continue;
            }
            let Some(value) = self.number(cell) else { continue };
            match column {
                Column::Sensor(_) => {
                    let [low, high] = PLAUSIBLE_C;
                    if (low..=high).contains(&value) {
                        trace.add(time_s, value);
                    } else {
                        let message = format!("{value} °C is no temperature of a machine");
                        let help = "leave the cell empty where a sensor has no reading; temperatures are -30 to 150 °C";
                        self.report(Code::BAD_VALUE, cell, message, help);
                    }
                }
                Column::Force if value < 0.0 => {
                    let help = "write the weight in N, 0 for an empty table";
                    self.report(Code::BAD_VALUE, cell, format!("{value} N is no weight"), help);
                }
                Column::Force => {
                    is_load_stated = true;
                    table.load.force_n = value;
                }
                Column::LoadPlace(axis) => {
                    is_load_stated = true;
                    table.load.position_mm[*axis] = value;
                }
                Column::Time | Column::Other => {}
            }
        }
        table.note_load(time_s, is_load_stated);
    }

    /// The time of a row that is not before the last one.
    fn read_time(&mut self, line: Span, cells: &[Span], table: &mut Readings) -> Option<f64> {
        let column = table.columns.iter().position(|column| *column == Column::Time)?;
        let &cell = cells.get(column)?;
        if self.source.slice(cell).is_empty() {
            self.report(Code::BAD_VALUE, line, "this row has no time", "write its time in s into the column t_s");
            return None;
        }
        let time_s = self.number(cell)?;
        if let Some(last_s) = table.time_s.filter(|&last_s| time_s < last_s) {
            let message = format!("the time goes back from {last_s} s to {time_s} s");
            self.report(Code::BAD_TABLE, cell, message, "sort the rows by time, and keep logs of different runs apart");
            return None;
        }
        table.time_s = Some(time_s);
        Some(time_s)
    }

    fn number(&mut self, cell: Span) -> Option<f64> {
        let text = self.source.slice(cell);
        let plain = match text.iter().position(|&byte| byte == b',') {
            Some(at) if self.separator != b',' => {
                let mut point = text.to_vec();
                point[at] = b'.';
                parse(&point)
            }
            _ => parse(text),
        };
        if plain.is_none() {
            let text = String::from_utf8_lossy(text);
            let shown: String = text.chars().take(LONGEST_SHOWN).collect();
            let message = format!("'{shown}' is no number");
            self.report(
                Code::BAD_VALUE,
                cell,
                message,
                "write a plain number, or leave the cell empty without reading",
            );
        }
        plain
    }

    /// The contents of the cells of a line.
    fn split(&self, line: Span, cells: &mut Vec<Span>) {
        cells.clear();
        let (bytes, base) = (self.source.slice(line), line.start as usize);
        let mut start = 0;
        let mut is_quoted = false;
        for (at, &byte) in bytes.iter().enumerate() {
            if byte == b'"' {
                is_quoted = !is_quoted;
            } else if byte == self.separator && !is_quoted {
                cells.push(trimmed(bytes, start, at, base));
                start = at + 1;
            }
        }
        cells.push(trimmed(bytes, start, bytes.len(), base));
    }

    fn report(&mut self, code: Code, span: Span, message: impl Into<String>, help: &str) {
        self.findings.push(Diagnostic::at(code, Place { file: self.source.id(), span }, message, help));
    }
}

/// Digits with sign, point and exponent; nothing else that the language takes for a number.
fn parse(text: &[u8]) -> Option<f64> {
    let is_fit = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E');
    let text = std::str::from_utf8(text).ok().filter(|text| text.bytes().all(|byte| is_fit(&byte)))?;
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// The cell between two offsets of a line without spaces and quotation marks around it.
fn trimmed(bytes: &[u8], mut start: usize, mut end: usize, base: usize) -> Span {
    let is_space = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_whitespace);
    while start < end && is_space(start) {
        start += 1;
    }
    while start < end && is_space(end - 1) {
        end -= 1;
    }
    if end >= start + 2 && bytes.get(start) == Some(&b'"') && bytes.get(end - 1) == Some(&b'"') {
        (start, end) = (start + 1, end - 1);
    }
    Span::new(base + start, base + end)
}

/// Lines that are not blank, without what ends them.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line_end: u8,
}

impl Iterator for Lines<'_> {
    type Item = Span;

    fn next(&mut self) -> Option<Span> {
        loop {
            let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
            let start = self.at;
            let length = rest.iter().position(|&byte| byte == self.line_end).unwrap_or(rest.len());
            self.at += length + 1;
            let line = rest.get(..length).unwrap_or_default();
            if !line.iter().all(u8::is_ascii_whitespace) {
                return Some(Span::new(start, start + line.strip_suffix(b"\r").unwrap_or(line).len()));
            }
        }
    }
}

/// What was read so far.
struct Readings {
    columns: Vec<Column>,
    /// By column.
    traces: Vec<Trace>,
    time_s: Option<f64>,
    /// The last load.
    load: Load,
    loads: Vec<(f64, Load)>,
}

impl Readings {
    fn new(columns: Vec<Column>) -> Readings {
        let traces = vec![Trace::default(); columns.len()];
        let load = Load { force_n: 0.0, position_mm: Vector::zeros() };
        Readings { columns, traces, time_s: None, load, loads: Vec::new() }
    }

    /// Keeps the load where it changes.
    fn note_load(&mut self, time_s: f64, is_stated: bool) {
        if is_stated && self.loads.last().is_none_or(|&(_, last)| last != self.load) {
            self.loads.push((time_s, self.load));
        }
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
