//! Backlash: half the reversal value in the sense of the last motion, e = +b(q)/2 behind a positive one, −b(q)/2 behind a negative one, 0
//! before any.
//!
//! The reversal value of ISO 230-2 as a deviation of the actual position; position errors are taken as the mean of both senses. In a
//! component across the axis it is lateral play. It may change along the axis, where a screw winds up or is worn in places.

use super::table::{self, Table};
use super::{Entry, Function};

/// Backlash.
#[derive(Clone, Debug, PartialEq)]
pub struct Backlash {
    /// b along the axis: value behind a positive motion minus value behind a negative one, mm or rad.
    pub reversal: Table,
}

impl Backlash {
    /// The same everywhere, mm or rad.
    #[must_use]
    pub fn constant(reversal: f64) -> Backlash {
        Backlash { reversal: Table { positions: vec![0.0], values: vec![reversal] } }
    }

    /// The value at a command for a sense of the last motion, −1, 0 or 1; mm or rad.
    #[must_use]
    pub fn value(&self, command: f64, sense: i8) -> f64 {
        match sense.signum() {
            0 => 0.0,
            sense => 0.5 * self.reversal.value(command) * f64::from(sense),
        }
    }
}

/// An entry of this kind.
pub(super) const EXAMPLE: &str = "component = \"EXX\"\nkind = \"backlash\"\n\
    positions_mm = [0, 700]\nvalues_um = [-6.0, -4.0]\n";

/// Reads `value_um` or `value_urad`, or where it is not the same everywhere what a table has.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<Function> {
    let backlash = if entry.has_stem("positions") || entry.has_stem("values") {
        Backlash { reversal: table::read_points(entry)? }
    } else {
        Backlash::constant(entry.deviation("value")?)
    };
    Some(Function::Backlash(backlash))
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
        let reversal = Table { positions: vec![-100.0, 100.0], values: vec![2e-3, 8e-3] };
        let backlash = Backlash { reversal };
        for (command, value) in [(-200.0, 1e-3), (-100.0, 1e-3), (0.0, 2.5e-3), (50.0, 3.25e-3), (130.0, 4e-3)] {
            assert!((backlash.value(command, 1) - value).abs() < 1e-15, "{command}");
            assert!((backlash.value(command, -1) + value).abs() < 1e-15, "{command}");
        }
    }
}
