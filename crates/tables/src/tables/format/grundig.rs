//! Error functions of linear axes for a Grundig control: `S1 P-100 T1=10 T2=6 T3=-6 R1=-1 R2=0 R3=3` (Spaan 1995, chapter 6, Table 6.1).
//!
//! S1, S2, S3 are X, Y, Z; P is the position of a point from the machine reference point, mm. T1 to T3 are the translation errors along X, Y, Z in
//! µm, R1 to R3 the rotation errors about them in arc seconds. They are ERRORS of the moving body: the control applies them in the kinematics of its
//! machine constants. It evaluates the table at 200 intervals between the software limit switches and adds the correction. The sign convention
//! (errors or their negatives) is not documented there: try one large value on the machine.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::limits::{FormatLimits, Holds};
use super::scan::{MOST_POINTS, Report, ScannedLine, cells, lines, shown};
use super::{Format, Written, rounded};
use crate::tables::{AxisErrors, ErrorTables, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, LINEAR_AXES};
use ncfix_base::source::Source;

/// Millimeters of a unit of T.
const UM: f64 = 1e-3;
/// Radians of a unit of R.
const ARCSEC: f64 = PI / 648_000.0;
/// The units of T1 T2 T3 R1 R2 R3, mm and rad.
const UNITS: [f64; 6] = [UM, UM, UM, ARCSEC, ARCSEC, ARCSEC];
/// Addresses of the values.
const ADDRESSES: [&str; 6] = ["T1", "T2", "T3", "R1", "R2", "R3"];
/// Decimals of positions, mm.
const POSITION_DECIMALS: usize = 3;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "grundig",
    title: "Grundig S P T R",
    sign: "values are errors of the moving body, not corrections; try one large value on the machine",
    holds: &[Holds::Errors],
    // Table 6.1 has whole µm and arc seconds and the three linear axes; it gives no limit for points or values.
    limits: FormatLimits { tables: 3, points: 0, value_mm: 0.0, resolution_mm: UM, further: "" },
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
    for one in tables.errors.iter_mut().flat_map(|errors| &mut errors.axes) {
        one.positions.iter_mut().for_each(|position| *position = rounded(*position, POSITION_DECIMALS));
        for row in &mut one.values {
            row.iter_mut().zip(UNITS).for_each(|(value, unit)| *value = rounded(*value / unit, 0) * unit);
        }
    }
}

/// The number of an axis.
fn number(axis: Axis) -> Option<usize> {
    LINEAR_AXES[..3].iter().position(|&one| one == axis).map(|index| index + 1)
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let axes = tables.errors.iter().flat_map(|errors| &errors.axes);
    let others = axes.filter(|one| number(one.axis).is_none());
    others.map(|one| format!("the table has S1, S2, S3 for X, Y, Z and no letter for {}", one.axis)).collect()
}

fn write(tables: &Tables, _: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::new();
    for note in notes {
        let _ = writeln!(text, "({})", note.replace(['(', ')'], " "));
    }
    for one in tables.errors.iter().flat_map(|errors| &errors.axes) {
        let Some(s) = number(one.axis) else { continue };
        for (position, row) in one.positions.iter().zip(&one.values) {
            let _ = write!(text, "S{s} P{position}");
            for ((value, unit), address) in row.iter().zip(UNITS).zip(ADDRESSES) {
                let _ = write!(text, " {address}={}", rounded(value / unit, 0));
            }
            text.push('\n');
        }
    }
    vec![Written { suffix: String::new(), text }]
}

/// `true` if the first row that is not a remark begins with S and P and has a T or an R. Its cells are read as those of any row, not matched as text.
fn is_mine(_: &str, bytes: &[u8]) -> bool {
    let rows = bytes.split(|&byte| byte == b'\n' || byte == b'\r').map(|line| line.trim_ascii());
    let first = rows.into_iter().find(|line| !line.is_empty() && !line.starts_with(b"("));
    let words: Vec<&str> = first
        .and_then(|line| std::str::from_utf8(line).ok())
        .map(|line| cells(line).take(3).collect())
        .unwrap_or_default();
    let begins = |index: usize, letters: [char; 2]| {
        words.get(index).is_some_and(|word| word.to_ascii_uppercase().starts_with(letters))
    };
    begins(0, ['S', 'S']) && begins(1, ['P', 'P']) && begins(2, ['T', 'R'])
}

fn read(source: &Source, _: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut report = Report::new(source);
    let mut axes: Vec<AxisErrors> = Vec::new();
    for line in lines(source) {
        let text = line.before('(').trim();
        if report.is_hopeless() {
            break;
        }
        if text.is_empty() || text.starts_with('%') {
            continue;
        }
        if let Some((axis, position, values)) = row(&line, text, &mut report) {
            add(&line, &mut report, &mut axes, axis, position, values);
        }
    }
    if axes.is_empty() && !report.has_fault() {
        report
            .empty("the file has no error table", "a table has rows such as S1 P-100 T1=10 T2=6 T3=-6 R1=-1 R2=0 R3=3");
    }
    let known = tables.errors.iter().flat_map(|errors| &errors.axes);
    if let Some(one) = known.map(|one| one.axis).find(|&axis| axes.iter().any(|one| one.axis == axis)) {
        report.empty(&format!("the errors of {one} have already been read"), "name one file only");
    }
    if !report.has_fault() {
        tables.errors.get_or_insert_with(ErrorTables::default).axes.extend(axes);
    }
    report.findings
}

/// Adds a point after those of its axis.
fn add(
    line: &ScannedLine<'_>,
    report: &mut Report<'_>,
    axes: &mut Vec<AxisErrors>,
    axis: Axis,
    position: f64,
    values: [f64; 6],
) {
    let place = axes.iter().position(|one| one.axis == axis).unwrap_or_else(|| {
        axes.push(AxisErrors { axis, positions: Vec::new(), values: Vec::new() });
        axes.len() - 1
    });
    let Some(one) = axes.get_mut(place) else { return };
    if one.positions.last().is_some_and(|&last| last >= position) {
        report.fault(line, line.text, format!("the positions of {axis} do not increase"), "sort the rows by P");
    } else if one.positions.len() >= MOST_POINTS {
        report.fault(line, line.text, format!("{axis} has more than {MOST_POINTS} points"), "use fewer");
    } else {
        one.positions.push(position);
        one.values.push(values);
    }
}

/// Axis, position and values of a row.
fn row(line: &ScannedLine<'_>, text: &str, report: &mut Report<'_>) -> Option<(Axis, f64, [f64; 6])> {
    let mut axis = None;
    let mut position = None;
    let mut values = [None; 6];
    for word in cells(text) {
        let upper = word.to_ascii_uppercase();
        if let Some((address, value)) = upper.split_once('=') {
            let Some(place) = ADDRESSES.iter().position(|&one| one == address).filter(|&place| values[place].is_none())
            else {
                let help = "write each of T1 T2 T3 R1 R2 R3 once in a row";
                report.fault(
                    line,
                    word,
                    format!("'{}' is not one of the values, or is given twice", shown(word)),
                    help,
                );
                return None;
            };
            values[place] = Some(value_of(line, word, value, report)? * UNITS[place]);
        } else if let Some(value) = upper.strip_prefix('P').filter(|_| position.is_none()) {
            position = Some(value_of(line, word, value, report)?);
        } else if let Some(value) = upper.strip_prefix('S').filter(|_| axis.is_none()) {
            axis = value
                .parse::<usize>()
                .ok()
                .and_then(|s| s.checked_sub(1))
                .and_then(|s| LINEAR_AXES[..3].get(s))
                .copied();
            if axis.is_none() {
                report.fault(
                    line,
                    word,
                    format!("'{}' is not an axis", shown(word)),
                    "write S1 for X, S2 for Y, S3 for Z",
                );
                return None;
            }
        } else {
            report.fault(
                line,
                word,
                format!("'{}' is not a word of a table", shown(word)),
                "a row has S, P, T1 to T3 and R1 to R3",
            );
            return None;
        }
    }
    let (Some(axis), Some(position)) = (axis, position) else {
        report.fault(
            line,
            text,
            format!("'{}' has no axis or no position", shown(text)),
            "begin the row with S1 P-100",
        );
        return None;
    };
    for (_, address) in values.iter().zip(ADDRESSES).filter(|(value, _)| value.is_none()) {
        let message = format!("{address} has no value");
        report.fault(line, text, message, "write every value, including 0");
    }
    Some((axis, position, values.map(|value| value.unwrap_or(0.0))))
}

/// The number in a word.
fn value_of(line: &ScannedLine<'_>, word: &str, text: &str, report: &mut Report<'_>) -> Option<f64> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
    if value.is_none() {
        report.fault(line, word, format!("'{}' has no number", shown(word)), "write a decimal number");
    }
    value
}
