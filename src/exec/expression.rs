//! Evaluation of expressions.

use super::fault::{Fault, fault};
use super::modal::Modal;
use super::value::Value;
use super::variables::Variables;
use crate::diagnostic::Code;
use crate::machine::Machine;
use crate::syntax::{ExprId, NameId, Node, Operator, Program, UnaryOperator};

/// What an expression may look at.
#[derive(Clone, Copy)]
pub(super) struct Scope<'a> {
    pub(super) program: &'a Program,
    pub(super) variables: &'a Variables,
    /// State of the channel, for system variables.
    #[expect(dead_code, reason = "system variables look at it")]
    pub(super) modal: &'a Modal,
    #[expect(dead_code, reason = "system variables look at it")]
    pub(super) machine: &'a Machine,
}

impl Scope<'_> {
    /// The value of an expression.
    pub(super) fn value(&self, id: ExprId) -> Result<Value, Fault> {
        let expr = self.program.expr(id);
        let wrong = |message: &str| fault(Code::NOT_COMPUTABLE, expr.span, message, "check the operands");
        let value = match expr.node {
            Node::Real(value) => Value::Real(value),
            Node::Integer(value) => Value::Int(value),
            Node::Boolean(value) => Value::Bool(value),
            Node::Text(span) => Value::Text(self.program.source.slice(span).to_vec()),
            Node::Parameter(index) => Value::Real(self.variables.parameter(i64::from(index), expr.span)?),
            Node::ParameterAt(index) => Value::Real(self.variables.parameter(self.whole(index)?, expr.span)?),
            Node::Name(name) => self.named(name, id)?,
            Node::Indexed(name, _) => {
                let text = self.program.names.text(name);
                return Err(fault(
                    Code::NOT_SUPPORTED,
                    expr.span,
                    format!(
                        "{text}[…]: {} are not supported yet",
                        if text.starts_with('$') { "system variables" } else { "arrays" }
                    ),
                    "use a plain variable or an R parameter",
                ));
            }
            Node::Call(name, range) => {
                let mut arguments = Vec::new();
                for argument in self.program.arguments_of(range) {
                    match argument {
                        Some(argument) => arguments.push(self.value(*argument)?),
                        None => return Err(wrong("an argument is missing")),
                    }
                }
                self.function(self.program.names.text(name), &arguments, id)?
            }
            Node::Unary(operator, inner) => {
                let inner = self.value(inner)?;
                let value = match (operator, &inner) {
                    (UnaryOperator::Plus, Value::Text(_)) | (UnaryOperator::Minus, Value::Text(_)) => None,
                    (UnaryOperator::Plus, _) => Some(inner),
                    (UnaryOperator::Minus, Value::Int(value)) => value.checked_neg().map(Value::Int),
                    (UnaryOperator::Minus, _) => inner.number().map(|value| Value::Real(-value)),
                    (UnaryOperator::Not, _) => inner.truth().map(|value| Value::Bool(!value)),
                    (UnaryOperator::ToText, _) => Some(Value::Text(inner.text())),
                    (UnaryOperator::BitNot, _) => inner.whole().map(|value| Value::Int(!value)),
                };
                value.ok_or_else(|| self.type_fault(id))?
            }
            Node::Binary(operator, left, right) => self.binary(operator, left, right, id)?,
        };
        match value {
            Value::Real(number) if !number.is_finite() => Err(wrong("the result is no finite number")),
            other => Ok(other),
        }
    }

    /// The value as a number.
    pub(super) fn number(&self, id: ExprId) -> Result<f64, Fault> {
        self.value(id)?.number().ok_or_else(|| self.type_fault(id))
    }

    /// The value as a truth.
    pub(super) fn truth(&self, id: ExprId) -> Result<bool, Fault> {
        self.value(id)?.truth().ok_or_else(|| self.type_fault(id))
    }

    /// The value as a whole number.
    pub(super) fn whole(&self, id: ExprId) -> Result<i64, Fault> {
        self.value(id)?.whole().ok_or_else(|| self.type_fault(id))
    }

    fn type_fault(&self, id: ExprId) -> Fault {
        let span = self.program.expr(id).span;
        fault(
            Code::TYPE_MISMATCH,
            span,
            "this value has the wrong type here",
            "use a number where a number is needed, a string where a string is",
        )
    }

    fn named(&self, name: NameId, id: ExprId) -> Result<Value, Fault> {
        if let Some(value) = self.variables.get(name) {
            return Ok(value.clone());
        }
        let text = self.program.names.text(name);
        let span = self.program.expr(id).span;
        if text == "$PI" {
            return Ok(Value::Real(std::f64::consts::PI));
        }
        if text.starts_with('$') {
            return Err(fault(
                Code::NOT_SUPPORTED,
                span,
                format!("system variable {text} is not supported yet"),
                "replace it by its value or an R parameter",
            ));
        }
        Err(fault(
            Code::UNDEFINED_VARIABLE,
            span,
            format!("{text} is not defined"),
            "define it with DEF at the start of this program",
        ))
    }

    fn binary(&self, operator: Operator, left: ExprId, right: ExprId, id: ExprId) -> Result<Value, Fault> {
        let (a, b) = (self.value(left)?, self.value(right)?);
        let span = self.program.expr(id).span;
        let numbers = || Some((a.number()?, b.number()?));
        let wholes = || Some((a.whole()?, b.whole()?));
        let truths = || Some((a.truth()?, b.truth()?));
        let arithmetic = |on_int: fn(i64, i64) -> Option<i64>, on_real: fn(f64, f64) -> f64| match (&a, &b) {
            (Value::Int(a), Value::Int(b)) => on_int(*a, *b).map(Value::Int).or(Some(Value::Real(f64::INFINITY))),
            _ => numbers().map(|(a, b)| Value::Real(on_real(a, b))),
        };
        let compare = |holds: fn(f64, f64) -> bool| numbers().map(|(a, b)| Value::Bool(holds(a, b)));
        let value = match operator {
            Operator::Multiply => arithmetic(i64::checked_mul, |a, b| a * b),
            Operator::Add => arithmetic(i64::checked_add, |a, b| a + b),
            Operator::Subtract => arithmetic(i64::checked_sub, |a, b| a - b),
            Operator::Divide => match numbers() {
                Some((_, 0.0)) => {
                    return Err(fault(Code::NOT_COMPUTABLE, span, "division by zero", "check the divisor"));
                }
                Some((a, b)) => Some(Value::Real(a / b)),
                None => None,
            },
            Operator::Div | Operator::Mod => match wholes() {
                Some((_, 0)) => {
                    return Err(fault(Code::NOT_COMPUTABLE, span, "division by zero", "check the divisor"));
                }
                Some((a, b)) if operator == Operator::Div => a.checked_div(b).map(Value::Int),
                // The sign of the remainder follows the dividend.
                Some((a, b)) => a.checked_rem(b).map(Value::Int),
                None => None,
            },
            Operator::BitAnd => wholes().map(|(a, b)| Value::Int(a & b)),
            Operator::BitXor => wholes().map(|(a, b)| Value::Int(a ^ b)),
            Operator::BitOr => wholes().map(|(a, b)| Value::Int(a | b)),
            Operator::And => truths().map(|(a, b)| Value::Bool(a && b)),
            Operator::Xor => truths().map(|(a, b)| Value::Bool(a != b)),
            Operator::Or => truths().map(|(a, b)| Value::Bool(a || b)),
            Operator::Concatenate => Some(Value::Text([a.text(), b.text()].concat())),
            Operator::Equal => a.equals(&b).map(Value::Bool),
            Operator::NotEqual => a.equals(&b).map(|equal| Value::Bool(!equal)),
            Operator::Greater => compare(|a, b| a > b),
            Operator::Less => compare(|a, b| a < b),
            Operator::GreaterEqual => a.equals(&b).and_then(|same| numbers().map(|(a, b)| Value::Bool(same || a > b))),
            Operator::LessEqual => a.equals(&b).and_then(|same| numbers().map(|(a, b)| Value::Bool(same || a < b))),
            Operator::Chain => {
                return Err(fault(
                    Code::NOT_SUPPORTED,
                    span,
                    "chains of frames are not supported yet",
                    "use TRANS and ATRANS",
                ));
            }
        };
        value.ok_or_else(|| self.type_fault(id))
    }

    fn function(&self, name: &str, arguments: &[Value], id: ExprId) -> Result<Value, Fault> {
        let span = self.program.expr(id).span;
        let Some(&(_, count, function)) = FUNCTIONS.iter().find(|(known, ..)| *known == name) else {
            return Err(fault(
                Code::NOT_SUPPORTED,
                span,
                format!("function {name}( ) is not supported yet"),
                "replace it by arithmetic or a value",
            ));
        };
        if arguments.len() != count {
            let message =
                format!("{name} takes {count} argument{}, not {}", if count == 1 { "" } else { "s" }, arguments.len());
            return Err(fault(Code::BAD_EXPRESSION, span, message, "give it the arguments it takes"));
        }
        let numbers: Option<Vec<f64>> = arguments.iter().map(Value::number).collect();
        let numbers = numbers.ok_or_else(|| self.type_fault(id))?;
        let result = function(&numbers);
        if !result.is_finite() {
            return Err(fault(Code::NOT_COMPUTABLE, span, format!("{name} has no value here"), "check its argument"));
        }
        let whole = matches!(name, "TRUNC" | "ROUND" | "ROUNDUP") && result.abs() < 9e15;
        Ok(if whole { Value::Int(result as i64) } else { Value::Real(result) })
    }
}

/// A function of the language: name, number of arguments, value. Angles in degrees.
type Function = (&'static str, usize, fn(&[f64]) -> f64);

const FUNCTIONS: &[Function] = &[
    ("SIN", 1, |a| sin_deg(a[0])),
    ("COS", 1, |a| sin_deg(90.0 - a[0])),
    ("TAN", 1, |a| sin_deg(a[0]) / sin_deg(90.0 - a[0])),
    ("ASIN", 1, |a| a[0].asin().to_degrees()),
    ("ACOS", 1, |a| a[0].acos().to_degrees()),
    ("ATAN2", 2, |a| a[0].atan2(a[1]).to_degrees()),
    ("SQRT", 1, |a| a[0].sqrt()),
    ("ABS", 1, |a| a[0].abs()),
    ("POT", 1, |a| a[0] * a[0]),
    ("TRUNC", 1, |a| a[0].trunc()),
    ("ROUND", 1, |a| (a[0] + 0.5).floor()),
    ("ROUNDUP", 1, |a| a[0].ceil()),
    ("LN", 1, |a| a[0].ln()),
    ("EXP", 1, |a| a[0].exp()),
    ("MINVAL", 2, |a| a[0].min(a[1])),
    ("MAXVAL", 2, |a| a[0].max(a[1])),
    ("BOUND", 3, |a| a[2].max(a[0]).min(a[1])),
];

/// Whether a name is a function, and so no variable.
pub(super) fn is_function(name: &str) -> bool {
    FUNCTIONS.iter().any(|(known, ..)| *known == name)
}

/// Sine of degrees, exact at multiples of 90 and 30: a bolt circle's zero must be zero.
fn sin_deg(degrees: f64) -> f64 {
    let turn = degrees.rem_euclid(360.0);
    let (sign, half) = if turn >= 180.0 { (-1.0, turn - 180.0) } else { (1.0, turn) };
    let quarter = if half > 90.0 { 180.0 - half } else { half };
    let value = match quarter {
        0.0 => 0.0,
        30.0 => 0.5,
        90.0 => 1.0,
        _ if quarter > 45.0 => (90.0 - quarter).to_radians().cos(),
        _ => quarter.to_radians().sin(),
    };
    sign * value
}
