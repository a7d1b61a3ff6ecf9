//! The key of a value of an axis in results: the letter and the unit.

use std::fmt;

use serde::{Serialize, Serializer};

use super::axes::Axis;
use crate::units::{um_from_mm, urad_from_rad};

/// The axis and the unit of a value in results: `X_mm` and `C_deg` of positions, `X_um` and `C_urad` of deviations. Keys are in the order of their letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct AxisKey {
    letter: char,
    unit: AxisUnit,
}

/// What a value of an axis is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum AxisUnit {
    Mm,
    Deg,
    Um,
    Urad,
}

impl AxisKey {
    /// Of a position: mm, or degrees.
    #[must_use]
    pub fn of_position(axis: Axis) -> AxisKey {
        AxisKey::new(axis, [AxisUnit::Mm, AxisUnit::Deg])
    }

    /// Of a deviation or a correction: µm, or µrad.
    #[must_use]
    pub fn of_deviation(axis: Axis) -> AxisKey {
        AxisKey::new(axis, [AxisUnit::Um, AxisUnit::Urad])
    }

    fn new(axis: Axis, [linear, rotary]: [AxisUnit; 2]) -> AxisKey {
        let unit = if axis.is_rotary() { rotary } else { linear };
        AxisKey { letter: char::from(axis.letter()), unit }
    }

    /// The letter of the axis.
    #[must_use]
    pub fn letter(self) -> char {
        self.letter
    }

    /// Whether the value is an angle.
    #[must_use]
    pub fn is_rotary(self) -> bool {
        matches!(self.unit, AxisUnit::Deg | AxisUnit::Urad)
    }

    /// The unit as people write it: `mm`, `°`, `µm`, `µrad`.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self.unit {
            AxisUnit::Mm => "mm",
            AxisUnit::Deg => "°",
            AxisUnit::Um => "µm",
            AxisUnit::Urad => "µrad",
        }
    }

    /// The unit behind a number in a list of axes, where a length in mm has none: ` µm`, `°`.
    #[must_use]
    pub fn suffix(self) -> &'static str {
        match self.unit {
            AxisUnit::Mm => "",
            AxisUnit::Deg => "°",
            AxisUnit::Um => " µm",
            AxisUnit::Urad => " µrad",
        }
    }

    /// A value in mm or rad in the unit of the key.
    #[must_use]
    pub fn shown(self, value: f64) -> f64 {
        match self.unit {
            AxisUnit::Mm => value,
            AxisUnit::Deg => value.to_degrees(),
            AxisUnit::Um => um_from_mm(value),
            AxisUnit::Urad => urad_from_rad(value),
        }
    }
}

impl fmt::Display for AxisKey {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = match self.unit {
            AxisUnit::Mm => "mm",
            AxisUnit::Deg => "deg",
            AxisUnit::Um => "um",
            AxisUnit::Urad => "urad",
        };
        write!(out, "{}_{unit}", self.letter)
    }
}

impl Serialize for AxisKey {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.collect_str(self)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for AxisKey {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        String::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        String::json_schema(generator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_has_the_unit_of_its_axis() {
        let keys = [AxisKey::of_position(Axis::X), AxisKey::of_position(Axis::C), AxisKey::of_deviation(Axis::Z)];
        assert_eq!(keys.map(|key| key.to_string()), ["X_mm", "C_deg", "Z_um"]);
        assert_eq!(keys.map(AxisKey::sign), ["mm", "°", "µm"]);
        let turn = AxisKey::of_deviation(Axis::B);
        assert_eq!((turn.to_string(), turn.sign(), turn.shown(2e-6).round()), ("B_urad".to_owned(), "µrad", 2.0));
    }

    #[test]
    fn keys_are_in_the_order_of_letters() {
        let mut keys = [Axis::X, Axis::C, Axis::A, Axis::Y].map(AxisKey::of_deviation);
        keys.sort();
        assert_eq!(keys.map(AxisKey::letter), ['A', 'C', 'X', 'Y']);
    }
}
