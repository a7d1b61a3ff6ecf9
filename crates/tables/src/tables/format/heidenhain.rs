//! Compensation value tables of HEIDENHAIN controls: a `.COM` file for each basic axis, and the `.CMA` file that assigns them.
//!
//! A `.COM` table has the position of the basic axis (AXISPOS, from the machine datum), and a column for each corrected axis, named after it. Another
//! column BACKLASH has values for the negative direction of travel if they differ. The `.CMA` table has a column for each basic axis with the names
//! of their `.COM` files, and `*` under ACTIVE in the active row. The axis of a column of the `.COM` is a function of the axis of the column of the
//! `.CMA`. (HEIDENHAIN, Technical Manual MANUALplus 620, 6.10.3 "Nonlinear axis error compensation", p. 716 and 718; TNC 407, p. 153 to 156.) The
//! manuals do not specify whether a value is added or subtracted, nor whether BACKLASH contains values or differences: here it contains values, and
//! all are added. Rotary axes have positions from 0 to 360 degrees. Units are mm and degrees.

use std::fmt::Write as _;
use std::sync::LazyLock;

use super::limits::{FormatLimits, Holds};
use super::plain::{find, inputs, name_points, points_of, sum, weigh};
use super::{Format, Written, rounded};
use crate::tables::{Lookup, Nodes, Sense, Tables, Wiring};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::pattern::{RegexSet, patterns};

mod reader;

/// Decimals of values and positions: the spacings of a TNC 407 are multiples of 0.0001 mm.
const DECIMALS: usize = 4;
/// A turn, degrees.
const TURN: f64 = 360.0;
/// Width of a column.
const WIDTH: usize = 13;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "heidenhain",
    title: "HEIDENHAIN .COM/.CMA",
    sign: "assumed: values are added to the set-point, and BACKLASH holds those of the negative direction; the manuals state neither, try one large value",
    holds: &[Holds::Own, Holds::Cross, Holds::Senses, Holds::Repetition],
    // 256 points per table (TNC 407, module 9095, error 3); the largest value is not documented.
    limits: FormatLimits { tables: 0, points: 256, value_mm: 0.0, resolution_mm: 1e-4, further: "" },
    round,
    faults,
    write,
    read: reader::read,
    numbers: super::without_numbers,
    beside: &[],
    sum_limit: None,
    has_axis_numbers: false,
    is_mine,
};

/// `true` if the points of a table are one turn of a rotary axis.
fn is_turn(axis: Axis, points: &[f64]) -> bool {
    axis.is_rotary() && points.first() == Some(&0.0) && points.last() == Some(&TURN)
}

/// The order of columns: the basic axis, then the others.
fn columns(input: Axis) -> impl Iterator<Item = Axis> {
    std::iter::once(input).chain(AXES.into_iter().filter(move |&axis| axis != input))
}

/// `true` if positions are outside 0 to 360 degrees.
fn leaves_turn(one: &Lookup) -> bool {
    let [start, end] = one.nodes.range();
    start < 0.0 || end > TURN
}

/// Shifts a table of a rotary axis of at most a turn to the positions from 0 to 360 degrees, which the control looks up.
fn wrap(one: &mut Lookup) {
    let Nodes::At(before) = &one.nodes else { return };
    let [start, end] = one.nodes.range();
    if before.is_empty() || end - start > TURN + 1e-9 {
        return;
    }
    let mut points: Vec<f64> = before.iter().map(|point| rounded(point.rem_euclid(TURN), DECIMALS)).collect();
    points.extend([0.0, TURN]);
    points.sort_by(f64::total_cmp);
    points.dedup();
    let value = |&point: &f64| {
        let turns = [point, point - TURN, point + TURN];
        let within = turns.into_iter().find(|at| (start..=end).contains(at));
        // Outside the table the nearer end value applies.
        let off = |at: &f64| (start - at).max(at - end);
        let nearest = turns.into_iter().min_by(|one, other| off(one).total_cmp(&off(other)));
        one.value(within.or(nearest).unwrap_or(point))
    };
    let values = points.iter().map(value).collect();
    one.values = values;
    one.nodes = Nodes::At(points);
}

/// Converts tables of one basic axis to common points, one for each corrected axis.
fn round(tables: &mut Tables) {
    weigh(tables);
    if tables.lookups.iter().any(|one| one.factor.is_some()) {
        return;
    }
    tables.lookups.iter_mut().for_each(|one| name_points(one, DECIMALS));
    let mut summed = Vec::new();
    for input in inputs(tables) {
        let mut group: Vec<Lookup> = tables.lookups.iter().filter(|one| one.input == input).cloned().collect();
        if group.iter().any(|one| input.is_rotary() && leaves_turn(one)) {
            group.iter_mut().for_each(wrap);
        }
        let points = points_of(&group);
        if group.iter().any(|one| one.modulo) && !is_turn(input, &points) {
            summed.append(&mut group);
            continue;
        }
        // A table within one turn is not periodic.
        group.iter_mut().for_each(|one| one.modulo = false);
        for output in columns(input) {
            let of_output: Vec<&Lookup> = group.iter().filter(|one| one.output == output).collect();
            let modulo = is_turn(input, &points);
            summed.extend(sum(&of_output, &points, DECIMALS).into_iter().map(|one| Lookup { modulo, ..one }));
        }
    }
    tables.lookups = summed;
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let mut faults = Vec::new();
    for input in inputs(tables) {
        let group: Vec<&Lookup> = tables.lookups.iter().filter(|one| one.input == input).collect();
        if group.windows(2).any(|pair| pair[0].nodes != pair[1].nodes) {
            faults.push(format!("the tables over {input} have different points"));
        }
        let points = points_of(group.iter().copied());
        if group.iter().any(|one| one.modulo) && !is_turn(input, &points) {
            faults.push(format!("the table over {input} repeats, which only a turn from 0 to 360 degrees can"));
        }
        if input.is_rotary() && points.iter().any(|point| !(0.0..=360.0).contains(point)) {
            faults.push(format!(
                "the table over {input} is longer than the turn from 0 to 360 degrees: choose one with --range {input}=0..360"
            ));
        }
        for output in columns(input) {
            let senses: Vec<Sense> = group.iter().filter(|one| one.output == output).map(|one| one.sense).collect();
            match senses[..] {
                [] | [Sense::Both] => {}
                [Sense::Positive, Sense::Negative] if input == output => {}
                [Sense::Positive, Sense::Negative] => {
                    faults.push(format!(
                        "{output} over {input} depends on the direction of motion, and BACKLASH is for {input} itself"
                    ));
                }
                _ => faults.push(format!("{output} over {input} is not one table, or one for each direction")),
            }
        }
    }
    faults
}

fn write(tables: &Tables, _: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut files: Vec<Written> = inputs(tables).into_iter().map(|input| com(tables, input)).collect();
    files.push(cma(tables));
    // A table of the control has no place for remarks.
    let text = notes.iter().fold(String::new(), |text, note| text + "; " + note + "\n");
    if !text.is_empty() {
        files.push(Written { suffix: "-notes.txt".to_owned(), text });
    }
    files
}

/// The name of a table in the control.
fn table_name(input: Axis) -> String {
    format!("AXIS_{input}")
}

/// The table of a basic axis.
fn com(tables: &Tables, input: Axis) -> Written {
    let mut columns_of: Vec<(String, &Lookup)> = Vec::new();
    if let Some(down) = tables.lookups.iter().find(|one| one.input == input && one.sense == Sense::Negative) {
        columns_of.push(("BACKLASH".to_owned(), down));
    }
    for output in columns(input) {
        columns_of.extend(find(tables, input, output, Sense::Positive).map(|one| (output.to_string(), one)));
    }
    let mut text = format!("BEGIN {:<8}.COM MM\n{:<6}{:<WIDTH$}", table_name(input), "NR", "AXISPOS");
    for (name, _) in &columns_of {
        let _ = write!(text, "{name:<WIDTH$}");
    }
    let points = columns_of.first().map_or(0, |(_, one)| one.values.len());
    for index in 0..points {
        let position = columns_of.first().map_or(0.0, |(_, one)| one.nodes.position(index));
        let _ = write!(text, "\n{index:<6}{position:<WIDTH$}");
        for (_, one) in &columns_of {
            let _ = write!(text, "{:<WIDTH$}", one.values.get(index).copied().unwrap_or(0.0));
        }
    }
    text.push_str("\n[END]\n");
    Written { suffix: format!("-{}.com", input.to_string().to_ascii_lowercase()), text }
}

/// The assignment of tables to basic axes, with one active row.
fn cma(tables: &Tables) -> Written {
    let mut head = format!("{:<6}", "NR");
    let mut row = format!("{:<6}", 0);
    for input in inputs(tables) {
        let _ = write!(head, "{:<WIDTH$}", input.to_string());
        let _ = write!(row, "{:<WIDTH$}", table_name(input) + ".COM");
    }
    let text = format!("BEGIN CONFIG  .CMA\n{head}ACTIVE\n{row}*\n[END]\n");
    Written { suffix: "-config.cma".to_owned(), text }
}

/// Bytes in which the mark of a file must stand: its first line and the header of its columns.
const HEAD: usize = 400;

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    static MARK: LazyLock<RegexSet> = LazyLock::new(|| patterns([r"AXISPOS|^[ \t\n\r\x0c]*BEGIN .*\.(?:CMA|COM)"]));
    MARK.is_match(bytes.get(..bytes.len().min(HEAD)).unwrap_or_default())
}
