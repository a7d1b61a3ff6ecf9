//! Values of variables and expressions, with Sinumerik's conversions.

use crate::syntax::sinumerik::DefinitionType;
use ncfix_base::geometry::{Axis, FrameParts};

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Int(i64),
    Real(f64),
    Bool(bool),
    Char(u8),
    /// Bytes of the source.
    Text(Vec<u8>),
    /// Name of an axis, upper case; empty if not assigned yet.
    Axis(String),
    Frame(Box<FrameParts>),
}

/// Relative difference up to which two reals are equal: `10*0.1==1` is true on the control (programming manual, precision of comparisons; MD10280).
const RELATIVE_EQUALITY: f64 = 1e-12;
/// The largest value of the type INT, which has 32 bits with sign; beyond it the control has an alarm.
const MOST_INT: i64 = 2_147_483_647;
/// Maximum number of decimals that `<<` writes for a REAL, to hide rounding noise.
const TEXT_DECIMALS: usize = 10;
/// Reals above this have no fraction.
const WHOLE_LIMIT: f64 = 9e15;

impl Value {
    /// The value as a number; BOOL is 0 or 1, CHAR its code; a text has none.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Value::Int(value) => Some(*value as f64),
            Value::Real(value) => Some(*value),
            Value::Bool(value) => Some(f64::from(u8::from(*value))),
            Value::Char(value) => Some(f64::from(*value)),
            Value::Text(_) | Value::Axis(_) | Value::Frame(_) => None,
        }
    }

    /// The value as a truth value; numbers are true unless 0, texts unless empty.
    pub(super) fn truth(&self) -> Option<bool> {
        match self {
            Value::Bool(value) => Some(*value),
            Value::Text(text) => Some(!text.is_empty()),
            other => other.number().map(|value| value != 0.0),
        }
    }

    /// The value as a whole number, for DIV, MOD, bit operators and indices: a real must be whole.
    pub(super) fn whole(&self) -> Option<i64> {
        match self {
            Value::Int(value) => Some(*value),
            Value::Bool(value) => Some(i64::from(*value)),
            Value::Char(value) => Some(i64::from(*value)),
            Value::Real(value) if value.fract() == 0.0 && value.abs() < WHOLE_LIMIT => Some(*value as i64),
            _ => None,
        }
    }

    /// The text that `<<` writes for it; a frame has none.
    pub(super) fn text(&self) -> Vec<u8> {
        match self {
            Value::Int(value) => value.to_string().into_bytes(),
            Value::Real(value) => real_text(*value).into_bytes(),
            Value::Bool(value) => i64::from(*value).to_string().into_bytes(),
            Value::Char(value) => vec![*value],
            Value::Text(text) => text.clone(),
            Value::Axis(name) => name.clone().into_bytes(),
            Value::Frame(_) => Vec::new(),
        }
    }

    /// Equality as defined by `==`.
    pub(super) fn equals(&self, other: &Value) -> Option<bool> {
        match (self, other) {
            (Value::Text(a), Value::Text(b)) => return Some(a == b),
            (Value::Text(a), Value::Char(b)) | (Value::Char(b), Value::Text(a)) => return Some(*a == [*b]),
            (Value::Axis(a), Value::Axis(b)) => return Some(a == b),
            (Value::Frame(a), Value::Frame(b)) => return Some(a == b),
            _ => {}
        }
        if let (Some(a), Some(b)) = (self.counted(), other.counted()) {
            return Some(a == b);
        }
        Some(is_same(self.number()?, other.number()?))
    }

    /// `true` if it is greater as defined by `>`; with `is_relative`, a value equal by `==` is not greater.
    pub(super) fn exceeds(&self, other: &Value, is_relative: bool) -> Option<bool> {
        let is_greater = self.number()? > other.number()?;
        Some(is_greater && !(is_relative && self.equals(other)?))
    }

    /// The value of a type that is compared exactly; `None` for REAL.
    fn counted(&self) -> Option<i64> {
        match self {
            Value::Int(value) => Some(*value),
            Value::Bool(value) => Some(i64::from(*value)),
            Value::Char(value) => Some(i64::from(*value)),
            _ => None,
        }
    }

    /// A result of the type INT; `None` beyond its range.
    pub(super) fn int(value: Option<i64>) -> Option<Value> {
        value.filter(|value| is_int(*value)).map(Value::Int)
    }

    /// The value converted to the type of a variable; `None` if not convertible. A real is rounded half up to an integer.
    pub(super) fn converted(self, kind: DefinitionType) -> Option<Value> {
        match (kind, &self) {
            (DefinitionType::Real, _) => self.number().map(Value::Real),
            (DefinitionType::Int, Value::Real(value)) => {
                let rounded = half_up(*value);
                Value::int((rounded.abs() < WHOLE_LIMIT).then_some(rounded as i64))
            }
            (DefinitionType::Int, _) => Value::int(self.whole()),
            (DefinitionType::Bool, _) => self.truth().map(Value::Bool),
            (DefinitionType::Char, Value::Text(text)) => match text[..] {
                [byte] => Some(Value::Char(byte)),
                _ => None,
            },
            (DefinitionType::Char, Value::Real(value)) => {
                let rounded = half_up(*value);
                (0.0..256.0).contains(&rounded).then_some(Value::Char(rounded as u8))
            }
            (DefinitionType::Char, _) => self.whole().and_then(|value| u8::try_from(value).ok()).map(Value::Char),
            (DefinitionType::String, Value::Text(_)) => Some(self),
            (DefinitionType::String, Value::Char(_) | Value::Bool(_)) => Some(Value::Text(self.text())),
            (DefinitionType::Axis, Value::Axis(_)) | (DefinitionType::Frame, Value::Frame(_)) => Some(self),
            _ => None,
        }
    }

    /// Initial value of a variable of this type.
    pub(super) fn initial(kind: DefinitionType) -> Value {
        match kind {
            DefinitionType::Int => Value::Int(0),
            DefinitionType::Char => Value::Char(0),
            DefinitionType::Real => Value::Real(0.0),
            DefinitionType::Bool => Value::Bool(false),
            DefinitionType::String => Value::Text(Vec::new()),
            DefinitionType::Axis => Value::Axis(String::new()),
            DefinitionType::Frame => Value::Frame(Box::default()),
        }
    }
}

/// `true` if two reals are equal as defined by `==`.
pub(super) fn is_same(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= RELATIVE_EQUALITY * a.abs().max(b.abs())
}

/// `true` if a whole number is within the type INT.
pub(super) fn is_int(value: i64) -> bool {
    (-MOST_INT..=MOST_INT).contains(&value)
}

/// The nearest whole number, a fraction of 0.5 rounded up.
pub(super) fn half_up(value: f64) -> f64 {
    let below = value.floor();
    if value - below >= 0.5 { below + 1.0 } else { below }
}

/// A real without trailing zeros; very large and very small values have the exponent notation of the language.
fn real_text(value: f64) -> String {
    if value != 0.0 && !(1e-6..1e15).contains(&value.abs()) {
        return format!("{value:e}").replace('e', "EX");
    }
    let text = format!("{value:.TEXT_DECIMALS$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// `true` if a name that is not a variable has the form of an axis or spindle: `X`, `X1`, `AX3`, `SPI1`, `S1`.
pub(super) fn is_axis_name(name: &str) -> bool {
    let bytes = name.as_bytes();
    let has_number = |prefix: usize| {
        bytes.len() > prefix && bytes.len() <= prefix + 2 && bytes[prefix..].iter().all(u8::is_ascii_digit)
    };
    match bytes {
        [letter] => Axis::from_letter(*letter).is_some() || *letter == b'S',
        [b'A', b'X', ..] => has_number(2),
        [b'S', b'P', b'I', ..] => has_number(3),
        [letter, ..] => (Axis::from_letter(*letter).is_some() || *letter == b'S') && has_number(1),
        [] => false,
    }
}

/// The axis of an axis name: its letter, its machine name (`X1`), or its number on the machine (`AX1`, in the order of `axes`).
pub(super) fn axis_of(name: &str, axes: impl Iterator<Item = Axis>) -> Option<Axis> {
    if let Some(number) = name.strip_prefix("AX") {
        let number: usize = number.parse().ok()?;
        return axes.into_iter().nth(number.checked_sub(1)?);
    }
    match name.as_bytes() {
        [letter] | [letter, b'1'] => Axis::from_letter(*letter),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reals_become_texts_without_noise() {
        for (value, text) in [
            (10.0, "10"),
            (0.1 + 0.2, "0.3"),
            (-0.0, "0"),
            (-12.5, "-12.5"),
            (1e20, "1EX20"),
            (2.5e-8, "2.5EX-8"),
            (100.0, "100"),
        ] {
            assert_eq!(real_text(value), text);
        }
    }

    #[test]
    fn axis_names_are_known() {
        for name in ["X", "C", "X1", "AX12", "SPI1", "S"] {
            assert!(is_axis_name(name), "{name}");
        }
        for name in ["", "T", "AX", "X123", "AXIS", "Q1"] {
            assert!(!is_axis_name(name), "{name}");
        }
        let axes = || [Axis::X, Axis::Y, Axis::Z, Axis::B].into_iter();
        assert_eq!(axis_of("AX4", axes()), Some(Axis::B));
        assert_eq!(axis_of("AX0", axes()), None);
        assert_eq!(axis_of("Y1", axes()), Some(Axis::Y));
        assert_eq!(axis_of("SPI1", axes()), None);
    }
}
