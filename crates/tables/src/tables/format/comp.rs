//! Leadscrew compensation of LinuxCNC: a `COMP_FILE` for each joint, three numbers a line.
//!
//! Nominal position, forward and reverse value, at most 256 lines. With `COMP_FILE_TYPE = 1` the values are trims, added to the command of the joint
//! while it moves up or down. With type 0 they are positions, and the trim is nominal minus position. Between lines the value is linear, outside the
//! end values apply, at rest the last direction applies, and BACKLASH is ignored. (LinuxCNC, INI configuration, "\[JOINT] section"; usrmotLoadComp
//! and compute_screw_comp in its sources; the examples of the manual have the opposite sign.) The control stops reading at the first line that is not
//! a triplet, so everything else comes after them. Units are those of the joint, here mm and degrees.

use std::fmt::Write as _;

use super::limits::{FormatLimits, Holds};
use super::plain::{find, inputs, name_points, points_of, sum, weigh};
use super::scan::{MOST_POINTS, Report, lines};
use super::{Format, Written, naming, rounded};
use crate::tables::{Lookup, Nodes, Sense, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::source::Source;

/// Decimals of values and positions: a nanometer.
const DECIMALS: usize = 6;
/// Mark of the file type after the triplets of our files.
const TYPE_MARK: &str = "# COMP_FILE_TYPE =";
/// Mark of the axis.
const AXIS_MARK: &str = "# axis ";

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "comp",
    title: "LinuxCNC COMP_FILE",
    sign: "values are added to the command of the joint: COMP_FILE_TYPE = 1",
    holds: &[Holds::Own, Holds::Senses],
    // 256 triplets per joint (INI configuration); a joint has one file for both directions; values are single precision.
    limits: FormatLimits { tables: 0, points: 256, value_mm: 0.0, resolution_mm: 1e-6, further: "" },
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
    weigh(tables);
    tables.lookups.iter_mut().for_each(|one| name_points(one, DECIMALS));
    let mut summed = Vec::new();
    for input in inputs(tables) {
        let group: Vec<&Lookup> = tables.lookups.iter().filter(|one| one.input == input).collect();
        if group.iter().any(|one| one.modulo || one.factor.is_some() || one.output != input) {
            // Not supported by the format: kept for the check to report it.
            summed.extend(group.into_iter().cloned());
        } else {
            summed.extend(sum(&group, &points_of(group.iter().copied()), DECIMALS));
        }
    }
    if tables.lookups.iter().all(|one| one.factor.is_none()) {
        tables.lookups = summed;
    }
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let mut faults = Vec::new();
    for input in inputs(tables) {
        let group: Vec<&Lookup> = tables.lookups.iter().filter(|one| one.input == input).collect();
        if group.iter().any(|one| one.modulo) {
            faults.push(format!("the table of {input} repeats, and a COMP_FILE does not"));
        }
        let is_pair = match group[..] {
            [one] => one.sense == Sense::Both,
            [up, down] => up.sense == Sense::Positive && down.sense == Sense::Negative && up.nodes == down.nodes,
            _ => false,
        };
        if !is_pair {
            faults.push(format!(
                "{input} must have one table for both directions, or one for each direction with the same points"
            ));
        }
    }
    faults
}

fn write(tables: &Tables, _: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut files = Vec::new();
    for axis in inputs(tables) {
        let up = find(tables, axis, axis, Sense::Positive);
        let down = find(tables, axis, axis, Sense::Negative);
        let (Some(up), Some(down)) = (up, down) else { continue };
        let mut text = String::new();
        for (index, (forward, reverse)) in up.values.iter().zip(&down.values).enumerate() {
            let _ = writeln!(text, "{} {forward} {reverse}", rounded(up.nodes.position(index), DECIMALS));
        }
        let _ = writeln!(text, "{AXIS_MARK}{axis}\n{TYPE_MARK} 1");
        for note in notes {
            let _ = writeln!(text, "# {note}");
        }
        files.push(Written { suffix: format!("-{}.comp", axis.to_string().to_ascii_lowercase()), text });
    }
    files
}

/// Three numbers at the beginning of a line.
fn triplet(text: &str) -> Option<[f64; 3]> {
    let mut numbers = text.split_whitespace().map(|part| part.parse::<f64>().ok().filter(|value| value.is_finite()));
    Some([numbers.next()??, numbers.next()??, numbers.next()??])
}

/// `true` for a file whose first line is three numbers only.
/// The mark is three numbers with their signs and ranges: it is read as a row is, not matched as text.
fn is_mine(name: &str, bytes: &[u8]) -> bool {
    let first = bytes.split(|&byte| byte == b'\n').next().and_then(|line| std::str::from_utf8(line).ok());
    let is_triplet = |line: &str| line.split_whitespace().count() == 3 && triplet(line).is_some();
    name.to_ascii_lowercase().ends_with(".comp") || first.is_some_and(is_triplet)
}

fn read(source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut report = Report::new(source);
    let mut rows: Vec<[f64; 3]> = Vec::new();
    let mut is_behind = false;
    let mut lost = None;
    let mut axis = naming::axis(wiring, source.name());
    let mut is_trim = None;
    for line in lines(source) {
        if report.is_hopeless() {
            break;
        }
        match triplet(line.text) {
            Some(_) if is_behind => lost = lost.or(Some(line.span(line.text))),
            Some(row) if rows.last().is_some_and(|last| last[0] >= row[0]) => {
                report.fault(&line, line.text, "the positions do not increase", "the control refuses such a line");
            }
            Some(row) if rows.len() < MOST_POINTS => rows.push(row),
            Some(_) => {
                report.fault(&line, line.text, format!("more than {MOST_POINTS} points"), "a COMP_FILE may have 256");
                is_behind = true;
            }
            None => is_behind = true,
        }
        if let Some(name) = line.text.strip_prefix(AXIS_MARK) {
            axis = wiring.axis(name).or(axis);
        }
        match line.text.strip_prefix(TYPE_MARK).map(str::trim) {
            Some("0") => is_trim = Some(false),
            Some("1") => is_trim = Some(true),
            _ => {}
        }
    }
    if rows.is_empty() {
        report.empty(
            "the first line is not a triplet",
            "write nominal, forward and reverse from the first line on, without remarks",
        );
        return report.findings;
    }
    if let Some(span) = lost {
        let help = "the control stops at the first line that is not a triplet: write remarks after the table";
        report.unused_at(span, "the control does not read from here on", help);
    }
    if report.has_fault() {
        return report.findings;
    }
    let Some(is_trim) = is_trim.or_else(|| guess_type(&rows)) else {
        let help = format!("write {TYPE_MARK} 0 or 1 after the table, as in the INI file");
        report.empty("positions or trims: the numbers do not show which", &help);
        return report.findings;
    };
    let Some(axis) = axis else {
        report.empty(
            "the axis of the table is not known",
            "name the file after it, x.comp, or write # axis X after the table",
        );
        return report.findings;
    };
    if tables.lookups.iter().any(|one| one.input == axis && one.output == axis) {
        report.empty(&format!("{axis} has a table already"), "a joint has one COMP_FILE");
    }
    if !report.has_fault() {
        add(tables, axis, &rows, is_trim);
    }
    report.findings
}

/// `true` if the values are trims: positions are near the nominal ones, trims near 0. `None` if ambiguous.
fn guess_type(rows: &[[f64; 3]]) -> Option<bool> {
    let far = |from: fn(&[f64; 3]) -> f64| rows.iter().map(from).fold(0.0, f64::max);
    let from_nominal = far(|row| (row[1] - row[0]).abs().max((row[2] - row[0]).abs()));
    let from_zero = far(|row| row[1].abs().max(row[2].abs()));
    if from_nominal < 0.1 * from_zero {
        Some(false)
    } else if from_zero < 0.1 * from_nominal {
        Some(true)
    } else {
        None
    }
}

/// The tables of a joint.
fn add(tables: &mut Tables, axis: Axis, rows: &[[f64; 3]], is_trim: bool) {
    let positions: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let trims = |column: usize| -> Vec<f64> {
        let value = |row: &[f64; 3]| if is_trim { row[column] } else { row[0] - row[column] };
        rows.iter().map(value).collect()
    };
    let table = |sense: Sense, values: Vec<f64>| {
        let nodes = Nodes::At(positions.clone());
        Lookup { sense, ..Lookup::added(axis, axis, nodes, values) }
    };
    let (forward, reverse) = (trims(1), trims(2));
    if forward == reverse {
        tables.lookups.push(table(Sense::Both, forward));
    } else {
        tables.lookups.push(table(Sense::Positive, forward));
        tables.lookups.push(table(Sense::Negative, reverse));
    }
}
