//! Backlash: half the reversal value in the direction of the last motion, e = +b(q)/2 after a positive one, −b(q)/2 after a negative one, 0 before any
//! motion.
//!
//! It is the reversal value of ISO 230-2 as a deviation of the actual position; position errors are the mean of both directions. In a component perpendicular
//! to the axis it is lateral play. It may change along the axis if a screw winds up or is worn in places.

use super::table::{self, ErrorTable};
use super::{Entry, EntryFunction};

/// Backlash.
#[derive(Clone, Debug, PartialEq)]
pub struct Backlash {
    /// b along the axis: value after a positive motion minus value after a negative one, mm or rad.
    pub reversal: ErrorTable,
}

impl Backlash {
    /// Creates a constant backlash, mm or rad.
    #[must_use]
    pub fn constant(reversal: f64) -> Backlash {
        Backlash { reversal: ErrorTable { positions: vec![0.0], values: vec![reversal] } }
    }

    /// Returns the value at a command for the direction of the last motion, −1, 0 or 1; mm or rad.
    #[must_use]
    pub fn value(&self, command: f64, sense: i8) -> f64 {
        match sense.signum() {
            0 => 0.0,
            sense => 0.5 * self.reversal.value(command) * f64::from(sense),
        }
    }
}

/// Example entry.
pub(super) const EXAMPLE: &str = "component = \"EXX\"\nkind = \"backlash\"\n\
    positions_mm = [0, 700]\nvalues_um = [-6.0, -4.0]\n";

/// Reads `value_um` or `value_urad`; if it is not constant, the keys of a table.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<EntryFunction> {
    let backlash = if entry.has_stem("positions") || entry.has_stem("values") {
        Backlash { reversal: table::read_points(entry)? }
    } else {
        Backlash::constant(entry.deviation("value")?)
    };
    Some(EntryFunction::Backlash(backlash))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_it_follows_the_sense() {
        let backlash = Backlash::constant(6e-3);
        assert_eq!([1, -1, 0].map(|sense| backlash.value(-40.0, sense)), [3e-3, -3e-3, 0.0]);
    }

    #[test]
    fn the_ends_may_differ() {
        let reversal = ErrorTable { positions: vec![-100.0, 100.0], values: vec![2e-3, 8e-3] };
        let backlash = Backlash { reversal };
        for (command, value) in [(-200.0, 1e-3), (-100.0, 1e-3), (0.0, 2.5e-3), (50.0, 3.25e-3), (130.0, 4e-3)] {
            assert!((backlash.value(command, 1) - value).abs() < 1e-15, "{command}");
            assert!((backlash.value(command, -1) + value).abs() < 1e-15, "{command}");
        }
    }
}
