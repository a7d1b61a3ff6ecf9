//! Blocks of errors over a plane of two axes, in either order of columns and rows: errors of one axis that do not depend on the other one.

use super::{Block, Column};
use ncfix_base::geometry::Axis;

/// Help for a block that cannot be read.
pub(super) const HELP: &str = "write a row for each pair of positions, and errors that depend only on their own axis; the machine file has a motion error of kind grid for others";

/// Values that differ by less do not depend on an axis, mm or rad: a tenth of a nanometer.
const SAME: f64 = 1e-7;

/// A block for each of the two axes, with the errors of that axis.
///
/// # Errors
/// A message if a pair of positions is missing or given twice, or an error depends on both axes.
pub(super) fn blocks(block: &Block, arguments: [(usize, Axis); 2]) -> Result<Vec<Block>, String> {
    let [first, second] = arguments;
    let positions = [first, second].map(|(index, _)| {
        let mut all: Vec<f64> = block.rows.iter().filter_map(|row| row.get(index)).copied().collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    });
    let [along, across] = &positions;
    let mut grid: Vec<Option<&Vec<f64>>> = vec![None; block.rows.len().min(along.len().saturating_mul(across.len()))];
    for row in &block.rows {
        let place = |all: &[f64], index: usize| {
            let value = row.get(index).copied().unwrap_or(f64::NAN);
            all.iter().position(|one| *one == value)
        };
        let (Some(i), Some(j)) = (place(along, first.0), place(across, second.0)) else { continue };
        // A place beyond the grid means that another one has no row.
        if let Some(cell) = grid.get_mut(j * along.len() + i)
            && cell.replace(row).is_some()
        {
            return Err(format!("{} {} with {} {} is given twice", first.1, along[i], second.1, across[j]));
        }
    }
    let rows: Option<Vec<&Vec<f64>>> = grid.into_iter().collect();
    let full = along.len() * across.len();
    let Some(rows) = rows.filter(|rows| rows.len() == full && block.rows.len() == full) else {
        return Err(format!(
            "{} positions of {} with {} of {} need {full} rows, but the block has {}",
            along.len(),
            first.1,
            across.len(),
            second.1,
            block.rows.len()
        ));
    };
    let cell = |i: usize, j: usize, column: usize| {
        rows.get(j * along.len() + i).and_then(|row| row.get(column)).copied().unwrap_or_default()
    };
    let mut out = Vec::new();
    for (side, (_, axis)) in arguments.into_iter().enumerate() {
        let own = &positions[side];
        let others = positions[1 - side].len();
        let mut columns = vec![Column::Argument(axis)];
        let mut values: Vec<Vec<f64>> = own.iter().map(|position| vec![*position]).collect();
        for (index, column) in block.columns.iter().enumerate() {
            let Column::Error(name) = column else { continue };
            let of = name.axis();
            if of != Some(first.1) && of != Some(second.1) {
                return Err(format!("{name} depends on neither {} nor {}", first.1, second.1));
            }
            if of != Some(axis) {
                continue;
            }
            let at = |place: usize, other: usize| {
                if side == 0 { cell(place, other, index) } else { cell(other, place, index) }
            };
            for (place, row) in values.iter_mut().enumerate() {
                let value = at(place, 0);
                if (1..others).any(|other| (at(place, other) - value).abs() > SAME) {
                    return Err(format!("{name} depends on {} and {}", first.1, second.1));
                }
                row.push(value);
            }
            columns.push(*column);
        }
        if columns.len() > 1 {
            out.push(Block { columns, rows: values, span: block.span });
        }
    }
    Ok(out)
}
