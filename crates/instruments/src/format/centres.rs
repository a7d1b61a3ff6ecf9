//! Centers of balls: one row for each ball and pose of the rotary axes, as a cycle that follows a ball (chase the ball) prints them.
//!
//! The control has fitted the touches already, so a row is a reading of `probe`: the axis positions at which the tip would coincide with the ball. Without a
//! column that names the ball, all rows are those of one.

use std::collections::BTreeSet;

use ncfix_base::geometry::Axis;

use super::nominal_actual::position_unit;
use super::{InstrumentFormat, axis_columns};
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::unit::ReadingUnit;
use crate::words::{self, ColumnRole};

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "ball-centres",
    title: "centers of balls: x, y, z and rotary axes, one row for each ball and pose",
    needs: "at unit tool",
    recognize: |text| u8::from(grid::table(text).is_ok_and(|table| is_list(&table))) * 3,
    read,
};

/// Name of the ball if no column has one.
const ONLY: &str = "b1";

/// Fewest rows of a list.
const FEWEST: usize = 3;

/// Largest distance of two centers of one ball at one pose, mm: a ball that was probed again, not another one.
const AGAIN_MM: f64 = 1.0;

/// Columns of the table.
struct CentreColumns {
    /// Name of the ball.
    ball: Option<usize>,
    /// Number of a repetition.
    run: Option<usize>,
    /// X, Y and Z of the center.
    linear: [usize; 3],
    /// Rotary axes.
    rotary: Vec<(usize, Axis)>,
}

/// Linear axis whose measured center a heading names: `xm`, `x measured`, `center x`.
fn measured(words: &str) -> Option<usize> {
    const MARKS: &[&str] =
        &["m", "c", "center", "centre", "measured", "meas", "actual", "mittelpunkt", "gemessen", "ist", "mesuré"];
    let parts: Vec<&str> = words.split([' ', '_', '-', '.', ':']).filter(|part| !part.is_empty()).collect();
    let letter = |text: &str| ["x", "y", "z"].iter().position(|own| *own == text);
    match parts[..] {
        [one] if one.len() == 2 && one.is_ascii() => letter(&one[..1])
            .filter(|_| MARKS.contains(&&one[1..]))
            .or(letter(&one[1..]).filter(|_| MARKS.contains(&&one[..1]))),
        [first, second] => {
            letter(first).filter(|_| MARKS.contains(&second)).or(letter(second).filter(|_| MARKS.contains(&first)))
        }
        _ => None,
    }
}

/// Columns of the table; those of a measured center come before those of a position.
fn columns(table: &GridTable) -> Option<CentreColumns> {
    let axes = axis_columns(table);
    let role = |wanted: ColumnRole| table.headings.iter().position(|heading| words::role(&heading.words) == wanted);
    let of = |k: usize, axis: Axis| {
        let own = table.headings.iter().position(|heading| measured(&heading.words) == Some(k));
        own.or(axes.iter().find(|(_, own)| *own == axis).map(|(index, _)| *index))
    };
    Some(CentreColumns {
        ball: role(ColumnRole::Name),
        run: role(ColumnRole::Run),
        linear: [of(0, Axis::X)?, of(1, Axis::Y)?, of(2, Axis::Z)?],
        rotary: axes.into_iter().filter(|(_, axis)| axis.is_rotary()).collect(),
    })
}

/// Texts of the cells of a column.
fn cells(table: &GridTable, column: usize) -> Vec<&str> {
    table.rows.iter().map(|row| row.cells.get(column).map_or("", |cell| cell.text.as_str())).collect()
}

/// True if all cells of a column differ.
fn is_numbering(table: &GridTable, column: usize) -> bool {
    let all = cells(table, column);
    all.iter().collect::<BTreeSet<_>>().len() == all.len()
}

/// True if every ball has one row at each pose in a row, so that no row is a touch. Rotary axes make the list one of centers: without them, it may be that of
/// any points.
fn is_list(table: &GridTable) -> bool {
    let Some(columns) = columns(table).filter(|columns| !columns.rotary.is_empty()) else { return false };
    // Displacements have columns of their own, features have nominal values beside the actual ones.
    let is_other = |words: &str| {
        ["dx", "dy", "dz"].contains(&words)
            || matches!(words::role(words), ColumnRole::Deviation | ColumnRole::Correction | ColumnRole::Series(..))
            || ["nom", "nominal", "soll", "target"].iter().any(|own| words.split([' ', '_']).any(|part| part == *own))
    };
    if table.rows.len() < FEWEST || table.headings.iter().any(|heading| is_other(&heading.words)) {
        return false;
    }
    !repeats(table, &columns)
}

/// True if two neighboring rows have the same ball, run and pose: these are touches.
pub(super) fn has_touches(table: &GridTable) -> bool {
    columns(table).is_some_and(|columns| repeats(table, &columns))
}

fn repeats(table: &GridTable, columns: &CentreColumns) -> bool {
    /// Largest difference of two angles of one pose, as a control prints them, degrees.
    const ONE_POSE: f64 = 0.01;
    let run = columns.run.filter(|column| !is_numbering(table, *column));
    let cell = |row: &grid::GridLine, column: usize| row.cells.get(column).map(|cell| cell.text.clone());
    let angle = |row: &grid::GridLine, column: usize| table.value(row, column).ok().flatten();
    table.rows.windows(2).any(|pair| {
        columns.ball.into_iter().chain(run).all(|key| cell(&pair[0], key) == cell(&pair[1], key))
            && columns.rotary.iter().all(|(column, _)| {
                let angles = angle(&pair[0], *column).zip(angle(&pair[1], *column));
                angles.is_some_and(|(one, other)| (one - other).abs() < ONE_POSE)
            })
    })
}

/// Asks which ball each row is of.
fn ask_ball(inquiry: &mut Inquiry<'_>, sentence: String, example: &str) {
    inquiry.ask("columns", sentence, format!("the meaning of each column, such as {example}"));
}

fn read(inquiry: &mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop> {
    let mut table = grid::table(inquiry.text)?;
    let is_told = !inquiry.answers().columns.is_empty();
    table.headings = inquiry.headings(&table)?;
    let line = table.heading_line;
    let Some(mut columns) = columns(&table) else {
        return Err(inquiry.refused(
            "the table has no columns for X, Y and Z of the center",
            "name them in the headings, or with --columns: ball,A,C,X,Y,Z",
            line,
        ));
    };
    for (column, axis) in &columns.rotary {
        if inquiry.machine.axis(*axis).is_none() {
            let message = format!("the machine has no axis {axis}");
            return Err(inquiry.refused(message, "check --machine and the headings", line));
        }
        let unit = table.headings.get(*column).and_then(|heading| heading.unit);
        if let Some(unit) = unit.filter(|unit| !unit.is_angle()) {
            let message = format!("{} is no unit of {axis}", unit.sign());
            return Err(inquiry.refused(message, "correct the heading", line));
        }
    }
    if let Some(ball) = columns.ball.filter(|ball| is_numbering(&table, *ball)) {
        let name = table.headings.get(ball).map_or_else(String::new, |heading| heading.written.clone());
        if is_told {
            return Err(inquiry.refused(
                "every row is of another ball, and one row of a ball shows no error",
                "write - for this column if all rows are of one ball",
                line,
            ));
        }
        let sentence =
            format!("every row has another name in the column '{name}': is it the ball, or the number of the row?");
        ask_ball(inquiry, sentence, "-,A,C,X,Y,Z if all rows are of one ball");
    }
    if let Some(run) = columns.run.filter(|_| !is_told) {
        let name = table.headings.get(run).map_or_else(String::new, |heading| heading.written.clone());
        if is_numbering(&table, run) {
            columns.run = None;
        } else if ["no", "nr"].contains(&table.headings.get(run).map_or("", |heading| heading.words.as_str())) {
            let sentence = format!("the column '{name}' may be the number of a ball or that of a run");
            ask_ball(inquiry, sentence, "ball,A,C,X,Y,Z or run,A,C,X,Y,Z");
        }
    }
    let used = |index: usize| {
        columns.linear.contains(&index)
            || columns.rotary.iter().any(|(own, _)| *own == index)
            || [columns.ball, columns.run].contains(&Some(index))
    };
    let unread: Vec<usize> = (0..table.headings.len()).filter(|index| !used(*index)).collect();
    inquiry.unread(&table, &table.headings, &unread)?;
    let mut largest = 0.0_f64;
    for row in &table.rows {
        for column in columns.linear {
            largest = largest.max(table.needed(row, column)?.abs());
        }
    }
    let stated = inquiry.one_unit(columns.linear.iter().map(|column| table.headings.get(*column)?.unit), line)?;
    let unit = position_unit(inquiry, stated, largest)?;
    let mut axes = vec![Axis::X, Axis::Y, Axis::Z];
    axes.extend(columns.rotary.iter().map(|(_, axis)| *axis));
    let tool = inquiry.tool();
    let mut out = ImportedReadings::new(ImportedKind::Probe, axes.clone(), Vec::new());
    out.fixed = inquiry.other_positions(&axes);
    out.tool_mm = [tool[0], tool[1], tool[2]];
    out.free = Vec::new();
    out.sigma = inquiry.answer("sigma", |own| own.sigma);
    inquiry.note("the measuring point counts as known; free = [\"tool\"] makes the stylus an unknown", 0);
    let zero = [Axis::X, Axis::Y, Axis::Z].map(|axis| inquiry.given(axis).unwrap_or(0.0));
    for row in &table.rows {
        let text =
            |column: Option<usize>| column.and_then(|column| row.cells.get(column)).map(|cell| cell.text.clone());
        let mut position = Vec::new();
        for (column, zero) in columns.linear.into_iter().zip(zero) {
            position.push(unit.inner(table.needed(row, column)?) + zero);
        }
        for (column, _) in &columns.rotary {
            let value = table.needed(row, *column)?;
            let own = table.headings.get(*column).and_then(|heading| heading.unit);
            position.push(own.map_or(value, |unit: ReadingUnit| unit.inner(value).to_degrees()));
        }
        out.rows.push(ImportedRow {
            run: text(columns.run).unwrap_or_default(),
            label: text(columns.ball).filter(|name| !name.is_empty()).unwrap_or_else(|| ONLY.to_owned()),
            position,
            line: row.number,
            ..ImportedRow::default()
        });
    }
    check_poses(inquiry, &out)?;
    let balls: BTreeSet<&str> = out.rows.iter().map(|row| row.label.as_str()).collect();
    let count = balls.len();
    if columns.ball.is_none() {
        inquiry.note(format!("no column names the ball: all {} rows are of one ball, {ONLY}", out.rows.len()), line);
    } else {
        inquiry.note(format!("balls: {count}, centers: {}", out.rows.len()), line);
    }
    if zero == [0.0; 3] {
        inquiry.note("positions are machine coordinates", 0);
    }
    if let Some(first) = out.rows.first() {
        let place: Vec<String> = axes
            .iter()
            .zip(&first.position)
            .map(|(axis, value)| format!("{} {}", char::from(axis.letter()), shown(*value)))
            .collect();
        out.sign_sentence =
            format!("where the tip is in the center of the first ball, the axes are at {}", place.join(" "));
    }
    Ok(out)
}

/// Checks that a ball has one place at each pose.
///
/// # Errors
/// If two centers of it are far apart, so that they belong to two balls.
fn check_poses(inquiry: &Inquiry<'_>, readings: &ImportedReadings) -> Result<(), ImportStop> {
    let key = |row: &ImportedRow| {
        let pose: Vec<u64> = row.position.iter().skip(3).map(|value| value.to_bits()).collect();
        (row.label.clone(), pose)
    };
    let mut first: std::collections::HashMap<(String, Vec<u64>), &ImportedRow> = std::collections::HashMap::new();
    for row in &readings.rows {
        let before = *first.entry(key(row)).or_insert(row);
        let apart = row.position.iter().zip(&before.position).take(3).map(|(one, other)| (one - other).powi(2));
        let mm = apart.sum::<f64>().sqrt();
        if mm > AGAIN_MM {
            let message = format!(
                "ball {} is {} mm from its place in line {}, at the same pose",
                row.label,
                shown((mm * 1000.0).round() / 1000.0),
                before.line
            );
            let help = "name the ball of each row in a column 'ball'; touches of a ball need --as ball-touches";
            return Err(inquiry.refused(message, help, row.line));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_of_a_measured_center_are_known() {
        for (words, k) in [("xm", 0), ("y measured", 1), ("center z", 2), ("cx", 0), ("z_meas", 2), ("ym", 1)] {
            assert_eq!(measured(words), Some(k), "{words}");
        }
        for words in ["x", "dx", "xx", "x nominal", "dia", "no", "mm"] {
            assert_eq!(measured(words), None, "{words}");
        }
    }
}
