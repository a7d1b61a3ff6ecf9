//! Reads `.COM` tables. `.CMA` tables only name files; the basic axis of a `.COM` follows from its own name.

use crate::tables::format::naming;
use crate::tables::format::scan::{MOST_POINTS, Report, ScannedLine, lines, shown};
use crate::tables::{Lookup, Nodes, Sense, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::source::Source;
use ncfix_base::units::MM_PER_INCH;

/// Maximum number of columns that are read.
const MOST_COLUMNS: usize = 64;

/// A column and its start in the line.
struct Column {
    name: String,
    start: usize,
    /// Positions and values of the non-empty rows.
    points: Vec<(f64, f64)>,
}

struct Reader<'a> {
    report: Report<'a>,
    /// The name after BEGIN.
    name: String,
    is_inch: bool,
    columns: Vec<Column>,
    /// Number of rows so far, and the last position.
    rows: usize,
    last: f64,
    is_remark: bool,
    is_assignment: bool,
    has_ended: bool,
}

pub(super) fn read(source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut reader = Reader {
        report: Report::new(source),
        name: String::new(),
        is_inch: false,
        columns: Vec::new(),
        rows: 0,
        last: f64::NEG_INFINITY,
        is_remark: false,
        is_assignment: false,
        has_ended: false,
    };
    for line in lines(source) {
        reader.line(&line);
        if reader.has_ended || reader.is_assignment || reader.report.is_hopeless() {
            break;
        }
    }
    reader.finish(source, wiring, tables)
}

impl Reader<'_> {
    fn line(&mut self, line: &ScannedLine<'_>) {
        let text = line.text.trim_end();
        let upper = text.trim_start().to_ascii_uppercase();
        if upper.is_empty() || upper.starts_with(';') {
            self.is_remark |= !upper.is_empty();
        } else if upper.starts_with("BEGIN ") && self.columns.is_empty() {
            self.is_assignment = upper.contains(".CMA");
            self.is_inch = upper.split_whitespace().any(|word| word == "INCH");
            let name = upper.trim_start_matches("BEGIN ").trim();
            self.name = name.split(['.', ' ']).next().unwrap_or_default().to_owned();
        } else if upper.starts_with("[END]") {
            self.has_ended = true;
        } else if self.columns.is_empty() {
            self.header(line, text);
        } else {
            self.row(line, text);
        }
    }

    fn header(&mut self, line: &ScannedLine<'_>, text: &str) {
        let names: Vec<&str> = text.split_whitespace().take(MOST_COLUMNS + 1).collect();
        let has = |wanted: &str| names.iter().any(|name| name.eq_ignore_ascii_case(wanted));
        if has("ACTIVE") && !has("AXISPOS") {
            self.is_assignment = true;
            return;
        }
        if !has("AXISPOS") || names.len() > MOST_COLUMNS {
            let help = "a table has the columns NR, AXISPOS and one for each corrected axis";
            self.report.fault(line, text, format!("'{}' has no column AXISPOS", shown(text)), help);
            return;
        }
        for name in names {
            let start = name.as_ptr() as usize - text.as_ptr() as usize;
            self.columns.push(Column { name: name.to_ascii_uppercase(), start, points: Vec::new() });
        }
    }

    fn row(&mut self, line: &ScannedLine<'_>, text: &str) {
        let Some(cells) = self.cells(line, text) else { return };
        let number = |report: &mut Report<'_>, cell: &str| match cell {
            "" => None,
            cell => report.number(line, cell),
        };
        let place = self.columns.iter().position(|column| column.name == "AXISPOS");
        let Some(position) = place.and_then(|place| cells.get(place)).and_then(|cell| number(&mut self.report, cell))
        else {
            self.report.fault(line, text, "the row has no position", "write a number under AXISPOS");
            return;
        };
        if position <= self.last {
            self.report.fault(line, text, "the positions do not increase", "sort the rows by AXISPOS");
        } else if self.rows >= MOST_POINTS {
            self.report.fault(line, text, format!("more than {MOST_POINTS} rows"), "the control allows 256");
        } else {
            self.rows += 1;
            self.last = position;
            for (column, cell) in self.columns.iter_mut().zip(cells) {
                if column.name != "NR" && column.name != "AXISPOS" {
                    column.points.extend(number(&mut self.report, cell).map(|value| (position, value)));
                }
            }
        }
    }

    /// The cells of a row: one for each column, or by position if some are empty.
    fn cells<'t>(&mut self, line: &ScannedLine<'_>, text: &'t str) -> Option<Vec<&'t str>> {
        let words: Vec<&str> = text.split_whitespace().take(self.columns.len() + 1).collect();
        if words.len() == self.columns.len() {
            return Some(words);
        }
        let ends = self.columns.iter().skip(1).map(|column| column.start).chain([text.len()]);
        let cells = self.columns.iter().zip(ends).map(|(column, end)| {
            // The last cells of a truncated row are empty.
            let end = end.min(text.len());
            let cell = if column.start >= end { Some("") } else { text.get(column.start..end) };
            cell.map(str::trim).filter(|cell| !cell.contains(char::is_whitespace))
        });
        let cells: Option<Vec<&str>> = cells.collect();
        if cells.is_none() || words.len() > self.columns.len() {
            let help = "write a number under each name, or leave it blank";
            self.report.fault(line, text, format!("'{}' does not fit the columns", shown(text)), help);
            return None;
        }
        cells
    }

    fn finish(mut self, source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
        let is_bare = self.columns.is_empty() && self.name.is_empty();
        if self.is_assignment || (is_bare && self.is_remark && !self.report.has_fault()) {
            return self.report.findings;
        }
        if self.rows == 0 && !self.report.has_fault() {
            self.report
                .empty("the file has no compensation values", "a .COM table has a column AXISPOS and rows of numbers");
        } else if !self.has_ended {
            self.report.empty("the table does not end with [END]", "check that no part of it is missing");
        }
        let input = naming::axis(wiring, &self.name).or_else(|| naming::axis(wiring, source.name()));
        let Some(input) = input else {
            self.report.empty(
                "the basic axis of the table is not known",
                "name the file after the axis as the .CMA assigns it: x.com",
            );
            return self.report.findings;
        };
        let added = self.tables(input, wiring);
        if tables.lookups.iter().any(|one| one.input == input) {
            self.report.empty(&format!("a table over {input} has already been read"), "only one can be active");
        }
        if !self.report.has_fault() {
            tables.lookups.extend(added);
        }
        self.report.findings
    }

    /// The tables of the columns.
    fn tables(&mut self, input: Axis, wiring: &Wiring) -> Vec<Lookup> {
        let mut found: Vec<(Axis, Vec<(f64, f64)>)> = Vec::new();
        let mut backlash = Vec::new();
        for column in std::mem::take(&mut self.columns) {
            match (column.name.as_str(), wiring.axis(&column.name)) {
                ("NR" | "AXISPOS", _) => {}
                ("BACKLASH", _) => backlash = column.points,
                (name, Some(axis)) if found.iter().any(|(other, _)| *other == axis) => {
                    self.report.empty(&format!("the column {name} is given twice"), "an axis has one column");
                }
                (_, Some(axis)) if !column.points.is_empty() => found.push((axis, column.points)),
                (_, Some(_)) => {}
                (name, None) => {
                    let message = format!("the column {} is not an axis and is ignored", shown(name));
                    let help = "columns C1 to C18 belong to a kinematics table, which is not read";
                    self.report.unused_at(ncfix_base::source::Span::new(0, 1), message, help);
                }
            }
        }
        let place = found.iter().position(|(axis, _)| *axis == input).or((found.len() == 1).then_some(0));
        if place.is_none() && !backlash.is_empty() {
            self.report.empty(
                "BACKLASH has no column to which it belongs",
                "a table with BACKLASH has a column of its basic axis",
            );
        }
        let mut tables = Vec::new();
        for (index, (output, points)) in found.into_iter().enumerate() {
            let has_backlash = place == Some(index) && !backlash.is_empty();
            let sense = if has_backlash { Sense::Positive } else { Sense::Both };
            tables.push(self.lookup(input, output, sense, &points));
            if has_backlash {
                tables.push(self.lookup(input, output, Sense::Negative, &backlash));
            }
        }
        tables
    }

    fn lookup(&self, input: Axis, output: Axis, sense: Sense, points: &[(f64, f64)]) -> Lookup {
        let unit = |axis: Axis| if self.is_inch && !axis.is_rotary() { MM_PER_INCH } else { 1.0 };
        let positions: Vec<f64> = points.iter().map(|(position, _)| position * unit(input)).collect();
        let values = points.iter().map(|(_, value)| value * unit(output)).collect();
        let modulo = super::is_turn(input, &positions);
        Lookup { sense, modulo, ..Lookup::added(input, output, Nodes::At(positions), values) }
    }
}
