//! Axes of a table of targets: the one that moved, and positions of the others.

use ncfix_base::geometry::Axis;

use super::StatedFacts;
use crate::grid::{GridHeading, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::shown;
use crate::row_fact::{ColumnValues, RowFact, row_fact};
use crate::unit::ReadingUnit;
use crate::words;

/// Distance of two positions of an axis that did not move, mm or degrees.
const STILL: f64 = 0.01;

/// The axis in a column such as `Linear axis`, if it is the same in all rows; gives the column.
///
/// # Errors
/// If a line before the table states another axis.
pub(super) fn named(
    inquiry: &mut Inquiry<'_>,
    table: &GridTable,
    headings: &[GridHeading],
    facts: &mut StatedFacts,
) -> Result<Option<usize>, ImportStop> {
    let Some(column) = headings.iter().position(|heading| row_fact(&heading.words) == Some(RowFact::Axis)) else {
        return Ok(None);
    };
    let values = ColumnValues::of(table, column);
    let Some((axis, line)) = values.only(table).and_then(|(text, line)| Some((words::axis(text)?, line))) else {
        return Ok(None);
    };
    if let Some((_, at)) = facts.axis.filter(|(stated, _)| *stated != axis) {
        let message = format!("the column of the axis says {axis}, and line {at} another axis");
        return Err(inquiry.refused(message, "correct the column, or the line", line));
    }
    facts.axis = Some((axis, line));
    Ok(Some(column))
}

/// The column of positions that are the targets, if no other column has targets. The positions of all other axes must be the same in all rows.
///
/// # Errors
/// If several axes moved, or if `--at` states another position.
pub(super) fn moved(
    inquiry: &mut Inquiry<'_>,
    table: &GridTable,
    (headings, positions): (&[GridHeading], &[(usize, Axis)]),
    has_target: bool,
    facts: &mut StatedFacts,
) -> Result<Option<usize>, ImportStop> {
    let line = table.heading_line;
    let mut spans = Vec::new();
    for (column, axis) in positions {
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        for row in &table.rows {
            if let Some(value) = table.value(row, *column)? {
                [low, high] = [low.min(value), high.max(value)];
            }
        }
        spans.push((*column, *axis, [low, high]));
    }
    let is_moved = |[low, high]: [f64; 2]| high - low > STILL;
    let said = inquiry.answers();
    let stated = facts.axis.map(|(axis, _)| axis).or(said.axis).or(said.component.map(|own| own.axis));
    let of_stated = spans.iter().find(|(_, axis, _)| stated == Some(*axis));
    let first = || spans.iter().find(|(.., span)| is_moved(*span));
    // Beside a column of targets, the axis that moved may have a column of its own.
    let own = match (of_stated, has_target) {
        (Some(own), _) => Some(own),
        (None, true) => first().filter(|_| stated.is_none()),
        (None, false) => first().or(spans.first()),
    };
    let own = own.copied();
    if let Some((_, axis, _)) = own {
        let (stated, at) = *facts.axis.get_or_insert((axis, line));
        if stated != axis {
            let message = format!("line {at} names the axis {stated}, and the positions are those of {axis}");
            return Err(inquiry.refused(message, "correct the line, or the heading", line));
        }
    }
    for (column, axis, span) in spans {
        if own.is_some_and(|(chosen, ..)| chosen == column) {
            continue;
        }
        if is_moved(span) {
            let message = format!(
                "{axis} is not at one place: its column goes from {} to {}, and the readings are those of one axis",
                shown(span[0]),
                shown(span[1])
            );
            let help = "save the rows of each line in a file of their own, and import all files; readings of a diagonal need --as displacements";
            return Err(inquiry.refused(message, help, line));
        }
        let unit = headings.get(column).and_then(|heading| heading.unit);
        let value = match unit {
            Some(unit @ ReadingUnit::Length(..)) if !axis.is_rotary() => unit.inner(span[0]),
            _ => span[0],
        };
        if value.is_finite() {
            inquiry.state_position(axis, value, line)?;
        }
    }
    Ok(own.filter(|_| !has_target).map(|(column, ..)| column))
}
