//! Values of variables and expressions, with Sinumerik's conversions.

use crate::syntax::DefinitionType;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Int(i64),
    Real(f64),
    Bool(bool),
    /// Bytes as in the source.
    Text(Vec<u8>),
}

/// Two reals are equal when they differ by less than this share of the larger one: `10*0.1==1` holds on the control.
const RELATIVE_EQUALITY: f64 = 1e-12;

impl Value {
    /// The value as a number; BOOL counts 0 or 1, a text is none.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Value::Int(value) => Some(*value as f64),
            Value::Real(value) => Some(*value),
            Value::Bool(value) => Some(f64::from(u8::from(*value))),
            Value::Text(_) => None,
        }
    }

    /// The value as a truth; numbers are true unless 0, a text is none.
    pub(super) fn truth(&self) -> Option<bool> {
        match self {
            Value::Bool(value) => Some(*value),
            other => other.number().map(|value| value != 0.0),
        }
    }

    /// The value as a whole number, for DIV, MOD, bit operators and indices: a real must be whole.
    pub(super) fn whole(&self) -> Option<i64> {
        match self {
            Value::Int(value) => Some(*value),
            Value::Bool(value) => Some(i64::from(*value)),
            Value::Real(value) if value.fract() == 0.0 && value.abs() < 9e15 => Some(*value as i64),
            _ => None,
        }
    }

    /// The text that `<<` makes of it.
    pub(super) fn text(&self) -> Vec<u8> {
        match self {
            Value::Int(value) => value.to_string().into_bytes(),
            Value::Real(value) => value.to_string().into_bytes(),
            Value::Bool(value) => i64::from(*value).to_string().into_bytes(),
            Value::Text(text) => text.clone(),
        }
    }

    /// Equality as `==` means it.
    pub(super) fn equals(&self, other: &Value) -> Option<bool> {
        if let (Value::Text(a), Value::Text(b)) = (self, other) {
            return Some(a == b);
        }
        let (a, b) = (self.number()?, other.number()?);
        Some(a == b || (a - b).abs() <= RELATIVE_EQUALITY * a.abs().max(b.abs()))
    }

    /// The value as a variable of this type holds it; `None` where it cannot. A real becomes an integer rounded half up.
    pub(super) fn converted(self, kind: DefinitionType) -> Option<Value> {
        match (kind, &self) {
            (DefinitionType::Real, _) => self.number().map(Value::Real),
            (DefinitionType::Int, Value::Real(value)) => {
                let rounded = (value + 0.5).floor();
                (rounded.abs() < 9e15).then_some(Value::Int(rounded as i64))
            }
            (DefinitionType::Int, _) => self.whole().map(Value::Int),
            (DefinitionType::Bool, _) => self.truth().map(Value::Bool),
            (DefinitionType::Char, Value::Text(text)) => match text[..] {
                [byte] => Some(Value::Int(i64::from(byte))),
                _ => None,
            },
            (DefinitionType::Char, _) => self.whole().filter(|value| (0..256).contains(value)).map(Value::Int),
            (DefinitionType::String, Value::Text(_)) => Some(self),
            _ => None,
        }
    }

    /// What a variable of this type holds before anything is assigned; `None` for types that are not executed yet.
    pub(super) fn initial(kind: DefinitionType) -> Option<Value> {
        match kind {
            DefinitionType::Int | DefinitionType::Char => Some(Value::Int(0)),
            DefinitionType::Real => Some(Value::Real(0.0)),
            DefinitionType::Bool => Some(Value::Bool(false)),
            DefinitionType::String => Some(Value::Text(Vec::new())),
            DefinitionType::Axis | DefinitionType::Frame => None,
        }
    }
}
