//! Table of measured deviations: linear between its points, constant outside, like the tables of controls.
//!
//! e(q) = eᵢ + (eᵢ₊₁ − eᵢ)(q − qᵢ)/(qᵢ₊₁ − qᵢ) for qᵢ ≤ q ≤ qᵢ₊₁ (Sinumerik `$AN_CEC`, ISO/TR 16907).

use super::{Entry, EntryFunction};
use ncfix_base::diagnostic::Code;

/// Points of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTable {
    /// Commands, strictly increasing, mm or rad.
    pub positions: Vec<f64>,
    /// Deviations at the positions, mm or rad.
    pub values: Vec<f64>,
}

impl ErrorTable {
    /// Returns the value at a command, mm or rad.
    #[must_use]
    pub fn value(&self, command: f64) -> f64 {
        let cell = Cell::around(&self.positions, command);
        cell.blend(|index| self.values.get(index).copied().unwrap_or_default())
    }

    /// Returns the kinks; none if a single point makes it constant.
    pub(super) fn knots(&self) -> &[f64] {
        if self.positions.len() > 1 { &self.positions } else { &[] }
    }
}

/// Two points of a table around a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    lower: usize,
    upper: usize,
    /// Share of the distance from the lower to the upper point, 0 … 1.
    share: f64,
}

impl Cell {
    /// Finds the cell in increasing positions; outside them both points are the outermost one.
    pub(super) fn around(positions: &[f64], command: f64) -> Cell {
        let upper = positions.partition_point(|&position| position <= command);
        let lower = upper.saturating_sub(1);
        match (positions.get(lower), positions.get(upper)) {
            (Some(&left), Some(&right)) if lower < upper => {
                Cell { lower, upper, share: (command - left) / (right - left) }
            }
            _ => Cell { lower, upper: lower, share: 0.0 },
        }
    }

    /// Interpolates between the values of the two points.
    pub(super) fn blend(&self, value: impl Fn(usize) -> f64) -> f64 {
        let low = value(self.lower);
        if self.lower == self.upper { low } else { low + (value(self.upper) - low) * self.share }
    }
}

/// Example entry.
pub(super) const EXAMPLE: &str = "component = \"EYX\"\nkind = \"table\"\n\
    positions_mm = [0, 350, 700]\nvalues_um = [0, 4, -1]\n";

/// Reads `positions_mm` or `positions_deg` and `values_um` or `values_urad`.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<EntryFunction> {
    read_points(entry).map(EntryFunction::Table)
}

/// Reads the points of a table.
pub(super) fn read_points(entry: &mut Entry<'_>) -> Option<ErrorTable> {
    let positions_key = entry.position_key("positions");
    let values_key = entry.deviation_key("values");
    let positions = entry.positions("positions");
    let values = entry.deviations("values");
    let (positions, values) = (positions?, values?);
    if positions.is_empty() || positions.len() != values.len() {
        let message = format!("{} {positions_key} and {} {values_key}", positions.len(), values.len());
        let place = entry.section.place_of(&values_key);
        entry.section.report(Code::BAD_TABLE, place, message, "give one value for every position, at least one");
        return None;
    }
    entry.demand_increase(&positions_key, &positions)?;
    Some(ErrorTable { positions, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_points_and_constant_outside() {
        let table = ErrorTable { positions: vec![0.0, 350.0, 700.0], values: vec![0.0, 4e-3, -1e-3] };
        for (command, value) in
            [(-5.0, 0.0), (0.0, 0.0), (87.5, 1e-3), (350.0, 4e-3), (490.0, 2e-3), (700.0, -1e-3), (800.0, -1e-3)]
        {
            assert!((table.value(command) - value).abs() < 1e-15, "{command}");
        }
        let constant = ErrorTable { positions: vec![5.0], values: vec![2.0] };
        assert_eq!([constant.value(4.0), constant.value(5.0), constant.value(6.0)], [2.0; 3]);
    }
}
