//! Leadscrew compensation of ISG kernels and Beckhoff TwinCAT: a list of compensation values (`kw.ssfk.*`) for each axis.
//!
//! A line has a name and a value: the position of each point (`setpoint`), and a value for each direction (`pos`, `neg`) in 0.1 µm or 0.0001°. With
//! `bilateral 0` only `pos` is read, and applies in both directions. A value is measured position minus setpoint, so the correction added to a
//! command is the negated value. (Beckhoff Information System, TF5200, Axis compensation: "Leadscrew error compensation", "Example of a compensation
//! value list", P-COMP-00017 to P-COMP-00025.)

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::LazyLock;

use super::limits::{FormatLimits, Holds};
use super::plain::{find, inputs, name_points, points_of, sum, weigh};
use super::scan::{MOST_POINTS, Report, ScannedLine, lines, shown};
use super::{Format, Written, naming, rounded};
use crate::tables::{Lookup, Nodes, Sense, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::pattern::{RegexSet, patterns};
use ncfix_base::source::{Source, Span};

/// Units of a list per millimeter or degree.
const PER_UNIT: f64 = 10_000.0;
/// Decimals of values and positions.
const DECIMALS: usize = 4;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "ssfk",
    title: "ISG/TwinCAT kw.ssfk",
    sign: "values are measured minus programmed position; the control adds their negatives",
    holds: &[Holds::Own, Holds::Senses, Holds::Repetition],
    // 1500 entries unless P-COMP-00059 allows more; values have 32 bits (16 in old ones, 3.2767 mm).
    limits: FormatLimits { tables: 0, points: 1500, value_mm: 3.2767, resolution_mm: 1e-4, further: "" },
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
    if tables.lookups.iter().any(|one| one.factor.is_some()) {
        return;
    }
    tables.lookups.iter_mut().for_each(|one| name_points(one, DECIMALS));
    let mut summed = Vec::new();
    for input in inputs(tables) {
        let group: Vec<&Lookup> = tables.lookups.iter().filter(|one| one.input == input).collect();
        let are_alike = group.windows(2).all(|pair| {
            pair[0].modulo == pair[1].modulo && (!pair[0].modulo || pair[0].nodes.range() == pair[1].nodes.range())
        });
        if group.iter().any(|one| one.output != input) || !are_alike {
            summed.extend(group.into_iter().cloned());
        } else {
            // Within the same turn the values of periodic tables are those of their points.
            let modulo = group.iter().any(|one| one.modulo);
            let plain: Vec<Lookup> = group.into_iter().map(|one| Lookup { modulo: false, ..one.clone() }).collect();
            let group: Vec<&Lookup> = plain.iter().collect();
            summed.extend(sum(&group, &points_of(&plain), DECIMALS).into_iter().map(|one| Lookup { modulo, ..one }));
        }
    }
    tables.lookups = summed;
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let mut faults = Vec::new();
    for input in inputs(tables) {
        let group: Vec<&Lookup> = tables.lookups.iter().filter(|one| one.input == input).collect();
        let is_pair = match group[..] {
            [one] => one.sense == Sense::Both,
            [up, down] => {
                let senses = (up.sense, down.sense) == (Sense::Positive, Sense::Negative);
                senses && up.nodes == down.nodes && up.modulo == down.modulo
            }
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

/// A whole number of units.
fn units(value: f64) -> f64 {
    rounded(value * PER_UNIT, 0)
}

fn write(tables: &Tables, wiring: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut files = Vec::new();
    for axis in inputs(tables) {
        let up = find(tables, axis, axis, Sense::Positive);
        let down = find(tables, axis, axis, Sense::Negative);
        let (Some(up), Some(down)) = (up, down) else { continue };
        let mut text = notes.iter().fold(String::new(), |text, note| text + "# " + note + "\n");
        let number = wiring.axes().position(|one| one == axis).map_or(0, |index| index + 1);
        let start = units(up.nodes.position(0));
        let is_bilateral = u8::from(up.sense != Sense::Both);
        let _ = writeln!(text, "kopf.log_achs_nr {number}\nkopf.log_achs_name {axis}");
        let _ =
            writeln!(text, "kw.ssfk.interval 0\nkw.ssfk.kw_startpos {start}\nkw.ssfk.kw_nr_max {}", up.values.len());
        let _ =
            writeln!(text, "kw.ssfk.unit 1\nkw.ssfk.bilateral {is_bilateral}\nkw.ssfk.modulo {}", u8::from(up.modulo));
        for (i, (forward, reverse)) in up.values.iter().zip(&down.values).enumerate() {
            let _ = writeln!(text, "kw.ssfk.table[{i}].setpoint {}", units(up.nodes.position(i)));
            let _ = writeln!(text, "kw.ssfk.table[{i}].pos {}", 0.0 - units(*forward));
            let _ = writeln!(text, "kw.ssfk.table[{i}].neg {}", 0.0 - units(*reverse));
        }
        files.push(Written { suffix: format!("-{}.lis", axis.to_string().to_ascii_lowercase()), text });
    }
    files
}

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    static MARK: LazyLock<RegexSet> = LazyLock::new(|| patterns([r"(?-i)kw\.ssfk\."]));
    MARK.is_match(bytes)
}

/// A list as far as read, in its units.
#[derive(Default)]
struct List {
    axis: Option<Axis>,
    interval: f64,
    start: f64,
    count: usize,
    is_in_increments: bool,
    bilateral: bool,
    modulo: bool,
    /// Setpoint, value upwards, value downwards.
    points: BTreeMap<usize, [Option<f64>; 3]>,
}

fn read(source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut report = Report::new(source);
    let mut list = List::default();
    for line in lines(source) {
        let text = line.before('#').trim();
        if report.is_hopeless() {
            break;
        }
        let (name, value) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        match name.strip_prefix("kw.ssfk.") {
            Some(field) => entry(&mut list, &line, field, value.trim(), &mut report),
            None if name == "kopf.log_achs_name" => {
                list.axis = naming::axis(wiring, value);
            }
            None if text.is_empty() || name.starts_with("kopf.") => {}
            None => report.unused(
                &line,
                text,
                format!("'{}' is not about leadscrews and is ignored", shown(text)),
                "check that nothing is missing",
            ),
        }
    }
    list.axis = list.axis.or_else(|| naming::axis(wiring, source.name()));
    if list.points.is_empty() && !report.has_fault() {
        report.empty("the file has no leadscrew list", "a list has lines such as kw.ssfk.table[0].pos 24");
    }
    if list.is_in_increments {
        report.empty("the list is in increments", "write it in 0.1 µm and 0.0001°, with kw.ssfk.unit 1");
    }
    if !report.has_fault() {
        finish(&list, tables, &mut report);
    }
    report.findings
}

fn entry(list: &mut List, line: &ScannedLine<'_>, field: &str, value: &str, report: &mut Report<'_>) {
    let Some(number) = report.number(line, value) else { return };
    match field {
        "interval" => list.interval = number,
        "kw_startpos" => list.start = number,
        "kw_nr_max" => list.count = number.clamp(0.0, 1e9) as usize,
        "unit" => list.is_in_increments = number == 0.0,
        "bilateral" => list.bilateral = number != 0.0,
        "modulo" => list.modulo = number != 0.0,
        _ => {
            let parts = field.strip_prefix("table[").and_then(|rest| rest.split_once("]."));
            let column = parts.and_then(|(_, name)| ["setpoint", "pos", "neg"].iter().position(|&one| one == name));
            let index = parts.and_then(|(index, _)| index.parse::<usize>().ok()).filter(|&index| index < MOST_POINTS);
            match (index, column) {
                (Some(index), Some(column)) => {
                    let cell = &mut list.points.entry(index).or_default()[column];
                    if cell.replace(number).is_some_and(|before| before != number) {
                        let message = format!("kw.ssfk.{} is given twice, with different values", shown(field));
                        report.fault(line, field, message, super::TWICE);
                    }
                }
                (None, Some(_)) => {
                    let help = format!("number the entries from 0 to {}", MOST_POINTS - 1);
                    report.fault(line, field, format!("'{}' is not an entry of the table", shown(field)), &help);
                }
                _ => report.unused(
                    line,
                    field,
                    format!("kw.ssfk.{} is not known and is ignored", shown(field)),
                    "look up its effect",
                ),
            }
        }
    }
}

fn finish(list: &List, tables: &mut Tables, report: &mut Report<'_>) {
    let Some(axis) = list.axis else {
        report
            .empty("the axis of the list is not known", "write kopf.log_achs_name X, or name the file after it, x.lis");
        return;
    };
    if tables.lookups.iter().any(|one| one.input == axis && one.output == axis) {
        report.empty(&format!("{axis} has a table already"), "an axis has one list");
        return;
    }
    let mut positions = Vec::new();
    let mut values = [Vec::new(), Vec::new()];
    let mut missing = 0;
    for index in 0..list.count.min(MOST_POINTS) {
        let [setpoint, up, down] = list.points.get(&index).copied().unwrap_or_default();
        let even = (list.interval > 0.0).then_some(list.start + list.interval * index as f64);
        positions.extend(even.or(setpoint).map(|position| position / PER_UNIT));
        missing += usize::from(up.is_none() || (list.bilateral && down.is_none()));
        let up = 0.0 - up.unwrap_or(0.0) / PER_UNIT;
        values[0].push(up);
        values[1].push(if list.bilateral { 0.0 - down.unwrap_or(0.0) / PER_UNIT } else { up });
    }
    if positions.len() != list.count || positions.is_empty() || positions.windows(2).any(|pair| pair[0] >= pair[1]) {
        report.empty(
            "the number of positions is not kw_nr_max, or they do not increase",
            "give every entry its setpoint, or an interval",
        );
        return;
    }
    let surplus = list.points.range(list.count..).count();
    if surplus > 0 {
        let message = format!("{surplus} entries are beyond kw_nr_max {} and are not used", list.count);
        report.unused_at(Span::new(0, 1), message, "check that kw.ssfk.kw_nr_max is the number of entries");
    }
    if missing > 0 {
        report.empty(&format!("{missing} entries have no value"), "write every value, including 0");
        return;
    }
    let [up, down] = values;
    let table = |sense: Sense, values: Vec<f64>| {
        let nodes = Nodes::At(positions.clone());
        Lookup { sense, modulo: list.modulo, ..Lookup::added(axis, axis, nodes, values) }
    };
    if up == down {
        tables.lookups.push(table(Sense::Both, up));
    } else {
        tables.lookups.push(table(Sense::Positive, up));
        tables.lookups.push(table(Sense::Negative, down));
    }
}
