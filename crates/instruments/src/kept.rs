//! Columns of a table that already have the name of a column of a measurement: time, temperatures, load, other drivers. They go into the imported table.

use std::collections::HashMap;

use crate::grid::{self, GridTable};
use crate::inquiry::Inquiry;
use crate::readings::{ImportedKind, ImportedReadings};
use crate::words::is_driver;

/// Drivers of a table, with their columns; the options may rename them.
fn drivers(inquiry: &Inquiry<'_>, table: &GridTable) -> Vec<(usize, String)> {
    let names: Vec<String> = if inquiry.answers().columns.len() == table.width() {
        inquiry.answers().columns.clone()
    } else {
        table.headings.iter().map(|heading| heading.written.clone()).collect()
    };
    names.into_iter().enumerate().filter(|(_, name)| is_driver(name)).collect()
}

/// Adds the drivers of the table to its readings. A line of the table that has several readings was not taken at one time, so its drivers belong to none of
/// them.
pub(crate) fn keep(inquiry: &mut Inquiry<'_>, readings: &mut ImportedReadings) {
    let Ok(table) = grid::table(inquiry.text) else { return };
    let mut drivers = drivers(inquiry, &table);
    // The rows of a circle may be put into another order, and its times may have given the angles.
    let is_circle = readings.kind == ImportedKind::BallBar;
    drivers.retain(|(_, name)| !is_circle || name != "t_s");
    if drivers.is_empty() {
        return;
    }
    let mut lines: Vec<(usize, &str)> = readings.rows.iter().map(|row| (row.line, row.label.as_str())).collect();
    lines.sort_unstable();
    let is_wide = is_circle || lines.windows(2).any(|pair| pair[0] == pair[1]);
    let at: HashMap<usize, usize> = table.rows.iter().enumerate().map(|(index, line)| (line.number, index)).collect();
    let mut unread = Vec::new();
    for (column, name) in drivers {
        let cells: Option<Vec<Option<f64>>> = readings
            .rows
            .iter()
            .map(|row| {
                let line = at.get(&row.line).and_then(|index| table.rows.get(*index))?;
                table.value(line, column).ok()
            })
            .collect();
        match cells.filter(|_| !is_wide && !readings.extra.contains(&name)) {
            Some(cells) => {
                readings.extra.push(name);
                readings.rows.iter_mut().zip(cells).for_each(|(row, cell)| row.extra.push(cell));
            }
            None => unread.push(name),
        }
    }
    if !readings.extra.is_empty() {
        inquiry.note(format!("columns that are kept: {}", readings.extra.join(", ")), table.heading_line);
    }
    if !unread.is_empty() {
        inquiry.note(format!("columns that are not read: {}", unread.join(", ")), table.heading_line);
    }
}
