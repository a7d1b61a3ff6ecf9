//! Columns of a table that already have the name of a column of a measurement: time, temperatures, load, other drivers. They go into the imported table.

use std::collections::HashMap;

use crate::grid::{self, GridTable};
use crate::inquiry::Inquiry;
use crate::readings::{ImportedKind, ImportedReadings};

/// Names of single columns.
const NAMES: &[&str] = &["t_s", "feed_mm_min", "load_N", "load_x_mm", "load_y_mm", "load_z_mm"];
/// Ends of the names of drivers: their units.
const UNITS: &[&str] = &["_C", "_pct", "_hPa", "_bar", "_rpm", "_W", "_A", "_V", "_N"];

/// True for the name of a column that a measurement may have besides positions and readings.
#[must_use]
pub(crate) fn is_driver(name: &str) -> bool {
    let is_word = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= 40;
    // A name is more than its unit: in `dx_A`, A is a letter of the file.
    let has_unit = UNITS.iter().any(|unit| name.strip_suffix(unit).is_some_and(|rest| rest.len() > 1));
    NAMES.contains(&name) || (is_word && has_unit)
}

/// Drivers of a table, with their columns; the options may rename them.
fn drivers(inquiry: &Inquiry<'_>, table: &GridTable) -> Vec<(usize, String)> {
    let names: Vec<String> = if inquiry.answers.columns.len() == table.width() {
        inquiry.answers.columns.clone()
    } else {
        table.headings.iter().map(|heading| heading.written.clone()).collect()
    };
    names.into_iter().enumerate().filter(|(_, name)| is_driver(name)).collect()
}

/// Adds the drivers of the table to its readings. A line of the table that has several readings was not taken at one time, so its drivers belong to none of
/// them.
pub(crate) fn keep(inquiry: &mut Inquiry<'_>, readings: &mut ImportedReadings) {
    if readings.kind == ImportedKind::BallBar {
        return;
    }
    let Ok(table) = grid::table(inquiry.text) else { return };
    let drivers = drivers(inquiry, &table);
    if drivers.is_empty() {
        return;
    }
    let mut lines: Vec<(usize, &str)> = readings.rows.iter().map(|row| (row.line, row.label.as_str())).collect();
    lines.sort_unstable();
    let is_wide = lines.windows(2).any(|pair| pair[0] == pair[1]);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drivers_have_the_names_of_a_measurement() {
        for name in ["t_s", "T_bed_C", "T_nose_2_C", "load_N", "feed_mm_min", "humidity_pct", "spindle_rpm"] {
            assert!(is_driver(name), "{name}");
        }
        for name in ["T bed", "Humidity", "X", "_C", "dx_um", "T_C_", "°C", "No", "a,b_C"] {
            assert!(!is_driver(name), "{name}");
        }
    }
}
