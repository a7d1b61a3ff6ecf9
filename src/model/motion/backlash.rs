//! Backlash: half the value in the sense of the last motion, e = +b/2 behind a positive one, −b/2 behind a negative one, 0 before any.
//!
//! The reversal value of ISO 230-2 as a deviation of the actual position; position errors are taken as the mean of both senses.

use super::{Entry, Function};

/// Backlash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backlash {
    /// b: value behind a positive motion minus value behind a negative one, mm or rad.
    pub value: f64,
}

impl Backlash {
    /// The value for a sense of the last motion, −1, 0 or 1; mm or rad.
    #[must_use]
    pub fn value(&self, sense: i8) -> f64 {
        0.5 * self.value * f64::from(sense.signum())
    }
}

/// Reads `value_um` or `value_urad`.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<Function> {
    Some(Function::Backlash(Backlash { value: entry.deviation("value")? }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_it_follows_the_sense() {
        let backlash = Backlash { value: 6e-3 };
        assert_eq!([backlash.value(1), backlash.value(-1), backlash.value(0)], [3e-3, -3e-3, 0.0]);
    }
}
