//! Arithmetic of the macro languages: results of functions and operators, and undefined cases.

use crate::syntax::words::{Function, Operator};
use ncfix_base::units::sin_deg;
use ncfix_dialect::Language;

/// Tolerance of EQ and NE in RS274/NGC, as in LinuxCNC; its other comparisons have no tolerance.
const EQUAL: f64 = 1e-4;
/// Range of the integers in Fanuc's bitwise logic.
const BITS: f64 = 2_147_483_647.0;
/// The largest number of eight binary-coded decimal digits.
const MOST_DECIMAL: f64 = 99_999_999.0;

/// Settings of the arithmetic.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arithmetic {
    /// Language of the rules.
    pub(super) language: Language,
    /// `true` if Fanuc's angles of ATAN and ASIN are between −180° and 180° (parameter 6004#0), otherwise from 0°.
    pub(super) signed_angles: bool,
}

/// Reason of an undefined value.
pub(super) type NoValue = &'static str;

const NO_DIVISOR: NoValue = "division by zero";

fn cos_deg(degrees: f64) -> f64 {
    sin_deg(degrees + 90.0)
}

impl Arithmetic {
    fn is_fanuc(self) -> bool {
        self.language != Language::Rs274
    }

    /// An angle of a function whose range is a setting.
    fn angle(self, degrees: f64) -> f64 {
        if self.is_fanuc() && !self.signed_angles && degrees < 0.0 { degrees + 360.0 } else { degrees }
    }

    /// The value of a function with one or two arguments.
    pub(super) fn call(self, function: Function, a: f64, b: Option<f64>) -> Result<f64, NoValue> {
        let value = match (function, b) {
            (Function::Sin, _) => sin_deg(a),
            (Function::Cos, _) => cos_deg(a),
            (Function::Tan, _) if cos_deg(a) == 0.0 => return Err("TAN has no value at 90 degrees"),
            (Function::Tan, _) => sin_deg(a) / cos_deg(a),
            (Function::Asin | Function::Acos, _) if a.abs() > 1.0 => {
                return Err("the value of ASIN and ACOS lies between -1 and 1");
            }
            (Function::Asin, _) => self.angle(a.asin().to_degrees()),
            (Function::Acos, _) => a.acos().to_degrees(),
            (Function::Atan, Some(b)) if self.is_fanuc() && a == 0.0 && b == 0.0 => {
                return Err("ATAN of 0 and 0 has no value");
            }
            (Function::Atan, Some(b)) => self.angle(a.atan2(b).to_degrees()),
            (Function::Atan, None) => a.atan().to_degrees(),
            (Function::Sqrt, _) if a < 0.0 => return Err("SQRT of a negative value"),
            (Function::Sqrt, _) => a.sqrt(),
            (Function::Abs, _) => a.abs(),
            (Function::Round, _) => a.round(),
            (Function::Fix, _) if self.is_fanuc() => a.trunc(),
            (Function::Fix, _) => a.floor(),
            (Function::Fup, _) if self.is_fanuc() => a.abs().ceil().copysign(a),
            (Function::Fup, _) => a.ceil(),
            (Function::Int, _) => a.trunc(),
            (Function::Ln, _) if a <= 0.0 => return Err("LN of a value that is not positive"),
            (Function::Ln, _) => a.ln(),
            (Function::Exp, _) => a.exp(),
            (Function::Pow, Some(b)) => return power(a, b),
            (Function::Bin, _) => return from_decimal(a),
            (Function::Bcd, _) => return to_decimal(a),
            (Function::Deg, _) => a.to_degrees(),
            (Function::Rad, _) => a.to_radians(),
            (Function::Pow | Function::Adp | Function::Prm | Function::Exists, _) => {
                return Err("this function has no value here");
            }
        };
        finite(value)
    }

    /// The value of an operator; comparisons return 1 or 0.
    pub(super) fn binary(self, operator: Operator, a: f64, b: f64) -> Result<f64, NoValue> {
        let value = match operator {
            Operator::Power => return power(a, b),
            Operator::Multiply => a * b,
            Operator::Divide | Operator::Mod if b == 0.0 => return Err(NO_DIVISOR),
            Operator::Divide => a / b,
            Operator::Mod if self.is_fanuc() => return modulo(a.round(), b.round()),
            // Never negative, for any signs.
            Operator::Mod => {
                let rest = a % b;
                if rest < 0.0 { rest + b.abs() } else { rest }
            }
            Operator::Add => a + b,
            Operator::Subtract => a - b,
            Operator::And => return self.logic(a, b, |a, b| a & b),
            Operator::Or => return self.logic(a, b, |a, b| a | b),
            Operator::Xor => return self.logic(a, b, |a, b| a ^ b),
            Operator::Equal => truth(self.equal(a, b)),
            Operator::NotEqual => truth(!self.equal(a, b)),
            Operator::Greater => truth(a > b),
            Operator::GreaterEqual => truth(a >= b),
            Operator::Less => truth(a < b),
            Operator::LessEqual => truth(a <= b),
        };
        finite(value)
    }

    fn equal(self, a: f64, b: f64) -> bool {
        if self.is_fanuc() { a == b } else { (a - b).abs() < EQUAL }
    }

    /// Fanuc's logic is bitwise on integers, that of RS274/NGC is logical.
    fn logic(self, a: f64, b: f64, on_bits: fn(i64, i64) -> i64) -> Result<f64, NoValue> {
        if !self.is_fanuc() {
            return Ok(on_bits(i64::from(a != 0.0), i64::from(b != 0.0)) as f64);
        }
        let (a, b) = (a.round(), b.round());
        if a.abs() > BITS || b.abs() > BITS {
            return Err("AND, OR and XOR work on whole numbers of 32 bits");
        }
        Ok(on_bits(a as i64, b as i64) as f64)
    }
}

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

fn finite(value: f64) -> Result<f64, NoValue> {
    if value.is_finite() { Ok(value) } else { Err("the result is not finite") }
}

/// The remainder with the sign of the dividend.
fn modulo(a: f64, b: f64) -> Result<f64, NoValue> {
    if b == 0.0 { Err(NO_DIVISOR) } else { finite(a % b) }
}

fn power(a: f64, b: f64) -> Result<f64, NoValue> {
    if a < 0.0 && b.fract() != 0.0 {
        return Err("a negative value cannot be raised to a fractional power");
    }
    finite(a.powf(b))
}

/// `BIN[…]`: the digits are the hexadecimal digits of the value.
fn from_decimal(value: f64) -> Result<f64, NoValue> {
    let mut rest = whole(value, f64::from(u32::MAX))?;
    let (mut out, mut weight) = (0, 1);
    while rest > 0 {
        let digit = rest % 16;
        if digit > 9 {
            return Err("this value is not binary-coded decimal");
        }
        out += digit * weight;
        weight *= 10;
        rest /= 16;
    }
    Ok(out as f64)
}

/// `BCD[…]`
fn to_decimal(value: f64) -> Result<f64, NoValue> {
    let mut rest = whole(value, MOST_DECIMAL)?;
    let (mut out, mut weight) = (0, 1);
    while rest > 0 {
        out += (rest % 10) * weight;
        weight *= 16;
        rest /= 10;
    }
    Ok(out as f64)
}

fn whole(value: f64, most: f64) -> Result<u64, NoValue> {
    let value = value.round();
    if (0.0..=most).contains(&value) { Ok(value as u64) } else { Err("BIN and BCD take eight digits and no sign") }
}
