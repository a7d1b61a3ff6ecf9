//! Table over two axes: bilinear between its points, constant outside, like control tables with two inputs.
//!
//! The error of one axis depends on the position of another: for example the roll of a knee on the position of the table on it (Spaan, ch. 4). In a cell with
//! the shares u of its own axis and v of the other axis
//! e = (1−u)(1−v) e₀₀ + u(1−v) e₁₀ + (1−u) v e₀₁ + u v e₁₁.

use super::entry::position_key_of;
use super::table::Cell;
use super::{Entry, EntryFunction};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;

/// Points of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorGrid {
    /// Own commands, strictly increasing, mm or rad.
    pub positions: Vec<f64>,
    /// Other axis.
    pub with: Axis,
    /// Commands of the other axis, strictly increasing, mm or rad.
    pub with_positions: Vec<f64>,
    /// Deviations, mm or rad: one row per own command, one value per command of the other axis.
    pub values: Vec<Vec<f64>>,
}

impl ErrorGrid {
    /// Returns the value at the commands of its own and of the other axis, mm or rad.
    #[must_use]
    pub fn value(&self, own: f64, other: f64) -> f64 {
        let across = Cell::around(&self.with_positions, other);
        Cell::around(&self.positions, own).blend(|row| {
            across.blend(|column| self.values.get(row).and_then(|row| row.get(column)).copied().unwrap_or_default())
        })
    }

    /// Returns the kinks along its own and the other axis; none along an axis on which it does not depend.
    pub(super) fn knots(&self) -> [&[f64]; 2] {
        [&self.positions, &self.with_positions].map(|positions| if positions.len() > 1 { positions } else { &[][..] })
    }
}

/// Example entry.
pub(super) const EXAMPLE: &str = "component = \"EAY\"\nkind = \"grid\"\npositions_mm = [0, 250, 500]\n\
    with = \"X\"\nwith_positions_mm = [0, 700]\nvalues_urad = [[0, 2], [6, 3], [4, -1]]\n";

/// Reads `positions_mm` or `positions_deg`, `with`, `with_positions_mm` or `with_positions_deg`, and the rows of `values_um` or `values_urad`.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<EntryFunction> {
    let values_key = entry.deviation_key("values");
    let positions = entry.positions("positions");
    let values = entry.deviation_rows("values");
    let Some(with) = entry.other_axis("with") else {
        // Its unit follows from the axis. If the axis is unknown, the key is not checked.
        ["with_positions_mm", "with_positions_deg"].into_iter().for_each(|key| entry.section.accept(key));
        return None;
    };
    let with_positions = entry.positions_of("with_positions", Some(with));
    let (positions, with_positions, values) = (positions?, with_positions?, values?);
    let fault = if positions.is_empty() || positions.len() != values.len() {
        Some((entry.section.place_of(&values_key), format!("{} rows for {} positions", values.len(), positions.len())))
    } else {
        let uneven = values.iter().enumerate().find(|(_, row)| row.is_empty() || row.len() != with_positions.len());
        uneven.map(|(index, row)| {
            let message = format!("{} values for {} positions of {with}", row.len(), with_positions.len());
            (entry.section.place_of_item(&values_key, index), message)
        })
    };
    if let Some((place, message)) = fault {
        let help = "give one row for every own position, and in it one value for every position of the other axis";
        entry.section.report(Code::BAD_TABLE, place, message, help);
        return None;
    }
    entry.demand_increase(&entry.position_key("positions"), &positions)?;
    entry.demand_increase(&position_key_of("with_positions", Some(with)), &with_positions)?;
    Some(EntryFunction::Grid(ErrorGrid { positions, with, with_positions, values }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_inside_and_constant_outside() {
        let grid = ErrorGrid {
            positions: vec![0.0, 100.0, 300.0],
            with: Axis::X,
            with_positions: vec![-50.0, 50.0],
            values: vec![vec![0.0, 4.0], vec![8.0, 2.0], vec![1.0, 1.0]],
        };
        for (own, other, value) in [
            (0.0, -50.0, 0.0),
            (100.0, 50.0, 2.0),
            // u = 1/4, v = 3/4: 1/16 of 8, 9/16 of 4 and 3/16 of 2.
            (25.0, 25.0, 0.5 + 2.25 + 0.375),
            (200.0, 0.0, 3.0),
            (-10.0, 0.0, 2.0),
            (400.0, 900.0, 1.0),
            (50.0, -60.0, 4.0),
        ] {
            assert!((grid.value(own, other) - value).abs() < 1e-12, "{own} {other}");
        }
    }

    #[test]
    fn one_row_depends_on_the_other_axis_alone() {
        let grid = ErrorGrid {
            positions: vec![7.0],
            with: Axis::Z,
            with_positions: vec![0.0, 10.0],
            values: vec![vec![0.0, 5.0]],
        };
        assert_eq!([grid.value(-3.0, 2.0), grid.value(90.0, 2.0)], [1.0; 2]);
        assert_eq!(grid.knots(), [&[][..], &[0.0, 10.0]]);
    }
}
