//! Evaluation of expressions.

use super::control::System;
use super::functions::{NoValue, evaluate, is_frame_function};
use super::modal::Modal;
use super::value::{Value, is_int};
use super::variables::Variables;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{ExprId, Node, Operator, Program, UnaryOperator};
use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::Machine;

/// Data that an expression can access.
#[derive(Clone, Copy)]
pub(super) struct Scope<'a> {
    pub(super) program: &'a Program,
    pub(super) variables: &'a Variables,
    /// State of the channel, for system variables.
    pub(super) modal: &'a Modal,
    pub(super) machine: &'a Machine,
    pub(super) system: &'a System,
}

impl Scope<'_> {
    /// The value of an expression.
    pub(super) fn value(&self, id: ExprId) -> Result<Value, Fault> {
        let expr = self.program.expr(id);
        let wrong = |message: &str| fault(Code::NOT_COMPUTABLE, expr.span, message, "check the operands");
        let value = match expr.node {
            Node::Real(value) => Value::Real(value),
            // A literal beyond INT is a REAL.
            Node::Integer(value) if !is_int(value) => Value::Real(value as f64),
            Node::Integer(value) => Value::Int(value),
            Node::Boolean(value) => Value::Bool(value),
            Node::Text(span) => Value::Text(self.program.source.slice(span).to_vec()),
            Node::Parameter(index) => Value::Real(self.variables.parameter(i64::from(index), expr.span)?),
            Node::ParameterAt(index) => Value::Real(self.variables.parameter(self.whole(index)?, expr.span)?),
            Node::Name(name) => self.named(name, id)?,
            Node::Indexed(name, range) => self.indexed(name, range, id)?,
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
                    (UnaryOperator::Plus, _) => inner.number().is_some().then_some(inner),
                    (UnaryOperator::Minus, Value::Int(value)) => value.checked_neg().map(Value::Int),
                    (UnaryOperator::Minus, _) => inner.number().map(|value| Value::Real(-value)),
                    (UnaryOperator::Not, _) => inner.truth().map(|value| Value::Bool(!value)),
                    (UnaryOperator::ToText, Value::Frame(_)) => None,
                    (UnaryOperator::ToText, _) => Some(Value::Text(inner.text())),
                    (UnaryOperator::BitNot, _) => match inner.whole().map(|value| Value::int(Some(!value))) {
                        Some(None) => return Err(self.overflow(id)),
                        found => found.flatten(),
                    },
                };
                value.ok_or_else(|| self.type_fault(id))?
            }
            Node::Binary(operator, left, right) => self.binary(operator, left, right, id)?,
        };
        match value {
            Value::Real(number) if !number.is_finite() => Err(wrong("the result is not finite")),
            other => Ok(other),
        }
    }

    /// The value as a number.
    pub(super) fn number(&self, id: ExprId) -> Result<f64, Fault> {
        self.value(id)?.number().ok_or_else(|| self.type_fault(id))
    }

    /// The value as a truth value.
    pub(super) fn truth(&self, id: ExprId) -> Result<bool, Fault> {
        self.value(id)?.truth().ok_or_else(|| self.type_fault(id))
    }

    /// The value as a whole number.
    pub(super) fn whole(&self, id: ExprId) -> Result<i64, Fault> {
        let value = self.value(id)?;
        value.whole().ok_or_else(|| self.no_int(&[(&value, id)], id))
    }

    /// The error for the first of these values that is not an INT; if it is not a number, its type is wrong.
    fn no_int(&self, values: &[(&Value, ExprId)], whole: ExprId) -> Fault {
        let is_int = |value: &Value| value.whole().is_some_and(is_int);
        let found = values.iter().find(|(value, _)| !is_int(value));
        match found.and_then(|(value, id)| Some((value.number()?, id))) {
            Some((number, id)) => fault(
                Code::TYPE_MISMATCH,
                self.program.expr(*id).span,
                format!("a whole number (INT) is required here, and this is {number}"),
                "round it with ROUND or TRUNC; DIV, MOD, bit operators and indices take whole numbers, / divides REAL",
            ),
            None => self.type_fault(whole),
        }
    }

    pub(super) fn type_fault(&self, id: ExprId) -> Fault {
        let span = self.program.expr(id).span;
        fault(Code::TYPE_MISMATCH, span, "this value has the wrong type here", "use a value of the required type")
    }

    /// The error for a result beyond the type INT.
    fn overflow(&self, id: ExprId) -> Fault {
        fault(
            Code::NOT_COMPUTABLE,
            self.program.expr(id).span,
            "the result exceeds the type INT (maximum 2147483647): the control would raise an alarm",
            "write one of the operands as REAL, such as 1000.0, or use R parameters",
        )
    }

    fn binary(&self, operator: Operator, left: ExprId, right: ExprId, id: ExprId) -> Result<Value, Fault> {
        let (a, b) = (self.value(left)?, self.value(right)?);
        let span = self.program.expr(id).span;
        let numbers = || Some((a.number()?, b.number()?));
        // Operands of INT; a REAL beyond INT is not one.
        let wholes = || Some((a.whole().filter(|a| is_int(*a))?, b.whole().filter(|b| is_int(*b))?));
        let truths = || Some((a.truth()?, b.truth()?));
        let int = |value: Option<i64>| Value::int(value).ok_or_else(|| self.overflow(id));
        let arithmetic = |on_int: fn(i64, i64) -> Option<i64>, on_real: fn(f64, f64) -> f64| match (&a, &b) {
            (Value::Int(a), Value::Int(b)) => int(on_int(*a, *b)).map(Some),
            _ => Ok(numbers().map(|(a, b)| Value::Real(on_real(a, b)))),
        };
        let is_relative = self.machine.control.relative_comparison;
        let value = match operator {
            Operator::Multiply => arithmetic(i64::checked_mul, |a, b| a * b)?,
            Operator::Add => arithmetic(i64::checked_add, |a, b| a + b)?,
            Operator::Subtract => arithmetic(i64::checked_sub, |a, b| a - b)?,
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
                Some((a, b)) if operator == Operator::Div => Some(int(a.checked_div(b))?),
                // The sign of the remainder is that of the dividend.
                Some((a, b)) => Some(int(a.checked_rem(b))?),
                None => None,
            },
            Operator::BitAnd => wholes().map(|(a, b)| int(Some(a & b))).transpose()?,
            Operator::BitXor => wholes().map(|(a, b)| int(Some(a ^ b))).transpose()?,
            Operator::BitOr => wholes().map(|(a, b)| int(Some(a | b))).transpose()?,
            Operator::And => truths().map(|(a, b)| Value::Bool(a && b)),
            Operator::Xor => truths().map(|(a, b)| Value::Bool(a != b)),
            Operator::Or => truths().map(|(a, b)| Value::Bool(a || b)),
            Operator::Concatenate if matches!(a, Value::Frame(_)) || matches!(b, Value::Frame(_)) => None,
            Operator::Concatenate => Some(Value::Text([a.text(), b.text()].concat())),
            Operator::Equal => a.equals(&b).map(Value::Bool),
            Operator::NotEqual => a.equals(&b).map(|equal| Value::Bool(!equal)),
            Operator::Greater => a.exceeds(&b, is_relative).map(Value::Bool),
            Operator::Less => b.exceeds(&a, is_relative).map(Value::Bool),
            Operator::GreaterEqual => b.exceeds(&a, true).map(|less| Value::Bool(!less)),
            Operator::LessEqual => a.exceeds(&b, true).map(|greater| Value::Bool(!greater)),
            Operator::Chain => match (&a, &b) {
                (Value::Frame(a), Value::Frame(b)) => return self.chain(a, b, span),
                _ => None,
            },
        };
        let takes_int =
            matches!(operator, Operator::Div | Operator::Mod | Operator::BitAnd | Operator::BitXor | Operator::BitOr);
        value.ok_or_else(|| if takes_int { self.no_int(&[(&a, left), (&b, right)], id) } else { self.type_fault(id) })
    }

    fn function(&self, name: &str, arguments: &[Value], id: ExprId) -> Result<Value, Fault> {
        let span = self.program.expr(id).span;
        if is_frame_function(name) {
            return self.frame_function(name, arguments, id);
        }
        if let Some(value) = self.channel_function(name, arguments, id)? {
            return Ok(value);
        }
        evaluate(name, arguments).map_err(|found| match found {
            NoValue::Unknown => {
                let shown: Vec<String> =
                    arguments.iter().map(|value| String::from_utf8_lossy(&value.text()).into_owned()).collect();
                let help = format!(
                    "replace it by a value, or give its value as \"{name}({})\" = … in [system] of the machine file",
                    shown.join(",")
                );
                fault(Code::NOT_SUPPORTED, span, format!("function {name}( ) is not supported yet"), help)
            }
            NoValue::Count(count) => self.argument_count(name, count, arguments.len(), id),
            NoValue::Type => self.type_fault(id),
            NoValue::Undefined(help) => fault(Code::NOT_COMPUTABLE, span, format!("{name} has no value here"), help),
        })
    }

    pub(super) fn argument_count(&self, name: &str, count: &str, given: usize, id: ExprId) -> Fault {
        let message = format!("{name} takes {count}, not {given}");
        fault(Code::BAD_EXPRESSION, self.program.expr(id).span, message, "give it the required arguments")
    }
}
