//! The matrix of LinuxCNC's `matrixkins`: motors of X, Y, Z = C times the commands, as lines of a HAL file.
//!
//! `setp matrixkins.C_xy 0.0001` adds 0.0001 times the command of Y to the motor of X: scales and squareness errors of three linear axes (LinuxCNC
//! manual page matrixkins(9), "Kinematics model" and "Configuration files"). The INI file selects it with `KINEMATICS=matrixkins`.

use std::fmt::Write as _;
use std::sync::LazyLock;

use super::limits::{FormatLimits, Holds};
use super::scan::{Report, ScannedLine, cells, lines, shown};
use super::{Format, Written, rounded};
use crate::tables::{Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::pattern::{RegexSet, patterns};
use ncfix_base::source::Source;

/// Decimals of the factors: a nanometer in a meter.
const DECIMALS: usize = 9;
/// The letters of rows and columns.
const LETTERS: [char; 3] = ['x', 'y', 'z'];
/// Prefix of its parameter names.
const PREFIX: &str = "matrixkins.C_";

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "matrixkins",
    title: "LinuxCNC matrixkins",
    sign: "motors are the matrix times the commands",
    holds: &[Holds::Matrix],
    // Nine numbers of double precision.
    limits: FormatLimits { tables: 1, points: 0, value_mm: 0.0, resolution_mm: 1e-6, further: "" },
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

fn round(tables: &mut Tables) {
    for value in tables.matrix.iter_mut().flatten().flatten() {
        *value = rounded(*value, DECIMALS);
    }
}

/// Checks that the matrix is invertible: the control needs the inverse for the displayed positions.
fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let Some([[a, b, c], [d, e, f], [g, h, i]]) = tables.matrix else { return Vec::new() };
    let determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
    if determinant.abs() < 1e-6 { vec!["the matrix has no inverse".to_owned()] } else { Vec::new() }
}

fn write(tables: &Tables, _: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::new();
    for note in notes {
        let _ = writeln!(text, "# {note}");
    }
    for (row, to) in tables.matrix.iter().flatten().zip(LETTERS) {
        for (value, from) in row.iter().zip(LETTERS) {
            let _ = writeln!(text, "setp {PREFIX}{to}{from} {value}");
        }
    }
    vec![Written { suffix: String::new(), text }]
}

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    static MARK: LazyLock<RegexSet> = LazyLock::new(|| patterns([r"(?-i)matrixkins\.C_"]));
    MARK.is_match(bytes)
}

/// The indices of `xy` in the matrix.
fn place(name: &str) -> Option<[usize; 2]> {
    let mut letters = name.chars().map(|letter| LETTERS.iter().position(|&one| one == letter));
    match (letters.next(), letters.next(), letters.next()) {
        (Some(Some(row)), Some(Some(column)), None) => Some([row, column]),
        _ => None,
    }
}

/// Other lines of a HAL file are ignored: it loads and connects much besides tables.
fn read(source: &Source, _: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut report = Report::new(source);
    let mut matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut count = 0_usize;
    for line in lines(source) {
        if report.is_hopeless() {
            break;
        }
        if let Some(([row, column], value)) = parameter(&line, &mut report) {
            // The last one is used, as in the control.
            matrix[row][column] = value;
            count += 1;
        }
    }
    if report.has_fault() {
        return report.findings;
    }
    if count == 0 {
        report.empty("the file has no matrix", "it has lines such as setp matrixkins.C_xy 0.0001");
    } else if tables.matrix.is_some() {
        report.empty("a matrix has already been read", "the control has only one");
    } else {
        tables.matrix = Some(matrix);
    }
    report.findings
}

/// A line that sets a parameter of the matrix.
fn parameter(line: &ScannedLine<'_>, report: &mut Report<'_>) -> Option<([usize; 2], f64)> {
    let text = line.before('#').trim();
    let mut words = cells(text);
    if words.next() != Some("setp") {
        return None;
    }
    let name = words.next()?;
    let Some(place) = place(name.strip_prefix(PREFIX)?) else {
        let help = "rows and columns are x, y and z: matrixkins.C_xy";
        report.fault(line, name, format!("'{}' is not an element of the matrix", shown(name)), help);
        return None;
    };
    let (Some(value), None) = (words.next(), words.next()) else {
        report.fault(
            line,
            text,
            format!("'{}' is not a single value", shown(text)),
            "write setp matrixkins.C_xy 0.0001",
        );
        return None;
    };
    Some((place, report.number(line, value)?))
}
