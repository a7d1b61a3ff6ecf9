//! Table of measured deviations: linear between its points, constant outside, as controls interpolate their own tables.
//!
//! e(q) = eᵢ + (eᵢ₊₁ − eᵢ)(q − qᵢ)/(qᵢ₊₁ − qᵢ) for qᵢ ≤ q ≤ qᵢ₊₁ (Sinumerik `$AN_CEC`, ISO/TR 16907).

use super::{Entry, Function};
use crate::diagnostic::Code;

/// Points of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Commands, strictly increasing, mm or rad.
    pub positions: Vec<f64>,
    /// Deviations there, mm or rad, as many.
    pub values: Vec<f64>,
}

impl Table {
    /// The value at a command, mm or rad.
    #[must_use]
    pub fn value(&self, command: f64) -> f64 {
        let next = self.positions.partition_point(|&position| position <= command);
        match (next.checked_sub(1).and_then(|i| self.point(i)), self.point(next)) {
            (Some((left, low)), Some((right, high))) => low + (high - low) * ((command - left) / (right - left)),
            (Some((_, value)), None) | (None, Some((_, value))) => value,
            (None, None) => 0.0,
        }
    }

    fn point(&self, index: usize) -> Option<(f64, f64)> {
        Some((*self.positions.get(index)?, *self.values.get(index)?))
    }
}

/// Reads `positions_mm` or `positions_deg` and `values_um` or `values_urad`.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<Function> {
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
    Some(Function::Table(Table { positions, values }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_points_and_constant_outside() {
        let table = Table { positions: vec![0.0, 350.0, 700.0], values: vec![0.0, 4e-3, -1e-3] };
        for (command, value) in
            [(-5.0, 0.0), (0.0, 0.0), (87.5, 1e-3), (350.0, 4e-3), (490.0, 2e-3), (700.0, -1e-3), (800.0, -1e-3)]
        {
            assert!((table.value(command) - value).abs() < 1e-15, "{command}");
        }
        let constant = Table { positions: vec![5.0], values: vec![2.0] };
        assert_eq!([constant.value(4.0), constant.value(5.0), constant.value(6.0)], [2.0; 3]);
    }
}
