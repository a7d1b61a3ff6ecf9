//! Error functions for the volumetric compensation of ISG kernels and Beckhoff TwinCAT (TF5280): a table of named columns.
//!
//! A header of names, rows of numbers; `//` begins a remark, `#` ends a block, and the next line is a new header. A block of component errors has the
//! axis as its first column (`X EXX EYX EZX EAX EBX ECX`); position errors (`A0Z`, constant) are a block of one row. Values are mm and rad, positions
//! mm and degrees. They are ERRORS in the sense of ISO 230-1; the control applies them in the chain of its list (`chain`, `workpiece_axes`) and
//! corrects the tip position. (Beckhoff Information System, TF5280, "ISG CSV format", "Units of measure", "List of parameters supported".) `negate`
//! of the list inverts the sign: try one large value on the machine.

mod plane;

use std::fmt::Write as _;

use super::limits::{FormatLimits, Holds};
use super::scan::{MOST_POINTS, Report, ScannedLine, cells, lines, shown};
use super::{Format, Written, rounded};
use crate::tables::{AxisErrors, ErrorTables, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::source::{Source, Span};
use ncfix_model::ErrorName;
use ncfix_model::name::{DIRECTIONS, ErrorKind};

/// Decimals of positions and displacements: a nanometer.
const DECIMALS: usize = 6;
/// Decimals of rotations, rad: a nanometer in a meter.
const ANGLE_DECIMALS: usize = 9;
/// Maximum number of columns of a block; the manual names fewer parameters.
const MOST_COLUMNS: usize = 200;
/// The supported axes.
const AXES: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "isg",
    title: "ISG/TwinCAT volumetric compensation",
    sign: "values are errors of the moving body as in ISO 230-1, mm and rad; the control's list can turn their sign (negate): try one large value",
    holds: &[Holds::Errors, Holds::Locations],
    // Six axes; the number of rows is max_records of the control's list, set by its builder.
    limits: FormatLimits { tables: 6, points: 0, value_mm: 0.0, resolution_mm: 1e-6, further: "" },
    round,
    faults,
    write,
    read,
    numbers: super::without_numbers,
    beside: &[],
    sum_limit: None,
    has_axis_numbers: false,
    is_mine,
};

/// The decimals of an error.
pub(super) fn decimals(index: usize) -> usize {
    if index < 3 { DECIMALS } else { ANGLE_DECIMALS }
}

pub(super) fn round(tables: &mut Tables) {
    let Some(errors) = &mut tables.errors else { return };
    for one in &mut errors.axes {
        one.positions.iter_mut().for_each(|position| *position = rounded(*position, DECIMALS));
        for row in &mut one.values {
            row.iter_mut().enumerate().for_each(|(index, value)| *value = rounded(*value, decimals(index)));
        }
    }
    for (name, value) in &mut errors.location {
        *value = rounded(*value, decimals(name.direction.index()));
    }
}

pub(super) fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let Some(errors) = &tables.errors else { return Vec::new() };
    let mut faults = Vec::new();
    for one in errors.axes.iter().filter(|one| !AXES.contains(&one.axis)) {
        faults.push(format!("there are no names for errors of {}", one.axis));
    }
    for (index, (name, _)) in errors.location.iter().enumerate() {
        if name.kind != ErrorKind::Location || !name.axis().is_some_and(|axis| AXES.contains(&axis)) {
            faults.push(format!("there is no name for {name}"));
        }
        if errors.location.iter().take(index).any(|(other, _)| other == name) {
            faults.push(format!("{name} is given twice"));
        }
    }
    faults
}

fn write(tables: &Tables, _: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::new();
    for note in notes {
        let _ = writeln!(text, "// {note}");
    }
    let mut blocks = Vec::new();
    let Some(errors) = &tables.errors else { return vec![Written { suffix: String::new(), text }] };
    if !errors.location.is_empty() {
        let names: Vec<String> = errors.location.iter().map(|(name, _)| short_name(*name)).collect();
        let values: Vec<String> = errors.location.iter().map(|(_, value)| value.to_string()).collect();
        blocks.push(format!("{}\n{}\n", names.join("\t"), values.join("\t")));
    }
    for one in &errors.axes {
        let names = DIRECTIONS.map(|direction| ErrorName::motion(direction, one.axis).to_string());
        let mut block = format!("{}\t{}\n", one.axis, names.join("\t"));
        for (position, row) in one.positions.iter().zip(&one.values) {
            let _ = writeln!(block, "{position}\t{}", row.map(|value| value.to_string()).join("\t"));
        }
        blocks.push(block);
    }
    text.push_str(&blocks.join("#\n"));
    vec![Written { suffix: String::new(), text }]
}

/// A location error without its E: `A0Z`.
pub(super) fn short_name(name: ErrorName) -> String {
    let text = name.to_string();
    text.strip_prefix('E').map_or(text.clone(), str::to_owned)
}

/// Content of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Column {
    /// Positions of an axis.
    Argument(Axis),
    Error(ErrorName),
    /// A kinematic parameter, which is taken from the machine file.
    Other,
}

/// The error of a name in upper case: `EXX`, or `A0Z` without its E.
pub(super) fn error_of(upper: &str) -> Option<ErrorName> {
    let error = upper.parse::<ErrorName>().or_else(|_| format!("E{upper}").parse::<ErrorName>()).ok();
    error.filter(|name| name.axis().is_some_and(|axis| AXES.contains(&axis)) && upper.len() == 3)
}

/// The column of a name in a header.
fn column(name: &str) -> Option<Column> {
    let upper = name.to_ascii_uppercase();
    if let [letter] = upper.as_bytes() {
        return Axis::from_letter(*letter).filter(|axis| AXES.contains(axis)).map(Column::Argument);
    }
    let known = error_of(&upper);
    let is_letter = |c: char| c.is_ascii_uppercase() || c == '0';
    let is_other = upper.len() == 3 && ["P", "N", "V", "ID", "LN"].iter().any(|head| upper.starts_with(head));
    known.map(Column::Error).or((is_other && upper.chars().all(is_letter)).then_some(Column::Other))
}

/// The mark is a header of names of errors: it is read as the header of a block is, not matched as text.
fn is_mine(_: &str, bytes: &[u8]) -> bool {
    let rows = bytes.split(|&byte| byte == b'\n' || byte == b'\r').map(|line| line.trim_ascii());
    let head = rows.into_iter().find(|line| !line.is_empty() && !line.starts_with(b"//") && !line.starts_with(b"#"));
    let Some(head) = head.and_then(|line| std::str::from_utf8(line).ok()) else { return false };
    let columns: Vec<_> = cells(head).take(MOST_COLUMNS).map(column).collect();
    let is_error = |column: &Option<Column>| matches!(column, Some(Column::Error(_)));
    columns.iter().all(Option::is_some) && columns.iter().any(is_error)
}

/// A header with its rows.
struct Block {
    columns: Vec<Column>,
    rows: Vec<Vec<f64>>,
    span: Span,
}

fn read(source: &Source, _: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut report = Report::new(source);
    let mut blocks: Vec<Block> = Vec::new();
    let mut needs_header = true;
    for line in lines(source) {
        let text = line.text.split("//").next().unwrap_or_default().trim();
        if report.is_hopeless() {
            break;
        }
        if text.starts_with('#') {
            needs_header = true;
        } else if !text.is_empty() && needs_header {
            // Rows after an invalid header have no meaning.
            let Some(columns) = header(&line, text, &mut report) else { break };
            blocks.push(Block { columns, rows: Vec::new(), span: line.span(text) });
            needs_header = false;
        } else if let (false, Some(block)) = (text.is_empty(), blocks.last_mut()) {
            record(&line, text, block, &mut report);
        }
    }
    if blocks.is_empty() && !report.has_fault() {
        report.empty("the file has no error table", "a table begins with a header of names: X EXX EYX EZX EAX EBX ECX");
    }
    let mut errors = tables.errors.clone().unwrap_or_default();
    for block in &blocks {
        take(block, &mut errors, &mut report);
    }
    if !report.has_fault() {
        tables.errors = Some(errors);
    }
    report.findings
}

fn header(line: &ScannedLine<'_>, text: &str, report: &mut Report<'_>) -> Option<Vec<Column>> {
    let mut columns = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for name in cells(text).take(MOST_COLUMNS) {
        let Some(column) = column(name) else {
            let help = "a header has names of axes and errors: X EXX EYX EZX EAX EBX ECX";
            report.fault(line, name, format!("'{}' is not the name of an error", shown(name)), help);
            return None;
        };
        if names.contains(&name.to_ascii_uppercase()) {
            report.fault(line, name, format!("{} is given twice", shown(name)), "write each name once in a header");
            return None;
        }
        if column == Column::Other {
            let message = format!("{} is not read: the kinematics are those of the machine file", shown(name));
            report.unused(line, name, message, "check that both describe the same machine");
        }
        names.push(name.to_ascii_uppercase());
        columns.push(column);
    }
    Some(columns)
}

fn record(line: &ScannedLine<'_>, text: &str, block: &mut Block, report: &mut Report<'_>) {
    let parts: Vec<&str> = cells(text).take(MOST_COLUMNS + 1).collect();
    if parts.len() != block.columns.len() {
        let message = format!("the row has {} values, but the header has {}", parts.len(), block.columns.len());
        report.fault(line, text, message, "write a number for each name, with a decimal point");
        return;
    }
    if block.rows.len() >= MOST_POINTS {
        report.fault(line, text, format!("more than {MOST_POINTS} rows"), "use fewer points");
        return;
    }
    let values: Option<Vec<f64>> = parts.into_iter().map(|part| report.number(line, part)).collect();
    block.rows.extend(values);
}

/// Adds a block to the errors.
fn take(block: &Block, errors: &mut ErrorTables, report: &mut Report<'_>) {
    let mut arguments = Vec::new();
    for (index, column) in block.columns.iter().enumerate() {
        if let Column::Argument(axis) = column {
            arguments.push((index, *axis));
        }
    }
    match arguments[..] {
        [] => constants(block, errors, report),
        [(index, axis)] => functions(block, index, axis, errors, report),
        [first, second] => match plane::blocks(block, [first, second]) {
            Ok(blocks) => blocks.iter().for_each(|one| take(one, errors, report)),
            Err(message) => report.fault_at(block.span, message, plane::HELP),
        },
        _ => {
            let help = "write errors of one axis over that axis";
            report.fault_at(block.span, "errors that depend on three axes are not supported", help);
        }
    }
}

/// Constant errors: one row.
fn constants(block: &Block, errors: &mut ErrorTables, report: &mut Report<'_>) {
    let [row] = &block.rows[..] else {
        let message = format!("errors that depend on no axis have {} rows", block.rows.len());
        report.fault_at(block.span, message, "write one row, or the axis as the first column");
        return;
    };
    for (column, value) in block.columns.iter().zip(row) {
        let Column::Error(name) = column else { continue };
        if name.kind == ErrorKind::Motion {
            report.fault_at(
                block.span,
                format!("{name} has no axis on which it depends"),
                "write the axis as the first column",
            );
        } else if errors.location.iter().any(|(other, _)| other == name) {
            report.fault_at(block.span, format!("{} is given twice", short_name(*name)), "write it once");
        } else {
            errors.location.push((*name, *value));
        }
    }
}

/// Errors as functions of an axis position.
fn functions(block: &Block, index: usize, axis: Axis, errors: &mut ErrorTables, report: &mut Report<'_>) {
    let positions: Vec<f64> = block.rows.iter().filter_map(|row| row.get(index)).copied().collect();
    if positions.is_empty() || positions.windows(2).any(|pair| pair[0] >= pair[1]) {
        report.fault_at(block.span, format!("the positions of {axis} do not increase"), "sort the rows by position");
        return;
    }
    let place = errors.axes.iter().position(|one| one.axis == axis).unwrap_or_else(|| {
        errors.axes.push(AxisErrors { axis, positions: positions.clone(), values: vec![[0.0; 6]; positions.len()] });
        errors.axes.len() - 1
    });
    let Some(one) = errors.axes.get_mut(place) else { return };
    if one.positions != positions {
        report.fault_at(
            block.span,
            format!("{axis} has a second block at other positions"),
            "write its errors at the same positions",
        );
        return;
    }
    for (place, column) in block.columns.iter().enumerate() {
        let Column::Error(name) = column else { continue };
        if name.kind == ErrorKind::Location || name.axis() != Some(axis) {
            let message = format!("{name} does not depend on {axis} in this model");
            report.fault_at(
                block.span,
                message,
                "write errors of one axis over that axis, location errors in a separate row",
            );
            continue;
        }
        for (values, row) in one.values.iter_mut().zip(&block.rows) {
            values[name.direction.index()] = row.get(place).copied().unwrap_or(0.0);
        }
    }
}
