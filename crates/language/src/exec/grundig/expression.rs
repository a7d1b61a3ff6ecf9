//! Values of expressions, and the E parameters that they read.

use crate::exec::core::assumed_values::AssumedValues;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::options::Options;
use crate::syntax::words::{ExprId, Function, Node, Operator, Program, UnaryOperator};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_base::units::sin_deg;
use ncfix_machine::machine::{Machine, Setting};

/// E parameters: E0 to E1999.
const PARAMETERS: usize = 2000;
/// Relative difference below which comparisons find values equal.
const SAME: f64 = 1e-12;

/// The E parameters, common to all programs and macros. They keep their values between programs, so one that is not assigned has no known value.
#[derive(Debug)]
pub(super) struct Parameters {
    /// `None` for a value of an earlier program.
    values: Vec<Option<f64>>,
    /// True if such a value is an error, false if 0 takes its place.
    strict: bool,
    /// Values of earlier programs that were read as 0.
    pub(super) assumed: AssumedValues,
}

impl Parameters {
    /// Parameters with the values of the machine file.
    pub(super) fn new(machine: &Machine, options: &Options) -> Parameters {
        let mut values = vec![None; PARAMETERS];
        let of_control = machine.parameters.iter().map(|(&number, &value)| (usize::try_from(number).ok(), value));
        let of_file = machine.system.iter().filter_map(|(key, setting)| {
            let value = match setting {
                Setting::Whole(value) => *value as f64,
                Setting::Number(value) => *value,
                _ => return None,
            };
            Some((key.strip_prefix('E')?.parse::<usize>().ok(), value))
        });
        for (number, value) in of_control.chain(of_file) {
            if let Some(place) = number.and_then(|number| values.get_mut(number)) {
                *place = Some(value);
            }
        }
        Parameters { values, strict: options.strict, assumed: AssumedValues::new(options.tells_assumed) }
    }

    pub(super) fn get(&self, number: usize, span: Span) -> Result<f64, Fault> {
        let value = self.values.get(number).ok_or_else(|| no_parameter(number, span))?;
        if value.is_none() && self.strict {
            let message = format!("E{number} keeps its value between programs, and this program has not set it");
            let help = format!(
                "set it in the program, add \"E{number}\" = … to [system] of the machine file, or give the parameters (%PA) that the control has saved with --setup"
            );
            return Err(fault(Code::NO_SYSTEM_VALUE, span, message, help).of_variable(format!("E{number}")));
        }
        if value.is_none() {
            self.assumed.note(number as i64, span);
        }
        Ok(value.unwrap_or(0.0))
    }

    pub(super) fn set(&mut self, number: usize, value: f64, span: Span) -> Result<(), Fault> {
        let place = self.values.get_mut(number).ok_or_else(|| no_parameter(number, span))?;
        *place = Some(value);
        Ok(())
    }
}

fn no_parameter(number: usize, span: Span) -> Fault {
    fault(Code::BAD_INDEX, span, format!("there is no parameter E{number}"), "use E0 to E1999")
}

/// Maximum number of operators in an expression.
const MAX_DEPTH: u32 = 500;

/// Data that an expression can access.
#[derive(Clone, Copy)]
pub(super) struct Scope<'a> {
    pub(super) program: &'a Program,
    pub(super) parameters: &'a Parameters,
}

impl Scope<'_> {
    /// The value of an expression.
    pub(super) fn number(&self, id: ExprId) -> Result<f64, Fault> {
        self.number_at(id, 0)
    }

    fn number_at(&self, id: ExprId, depth: u32) -> Result<f64, Fault> {
        let expr = self.program.expr(id);
        if depth > MAX_DEPTH {
            let message = format!("more than {MAX_DEPTH} operators in one expression");
            return Err(fault(Code::TOO_DEEP, expr.span, message, "split it over several blocks"));
        }
        let depth = depth + 1;
        let value = match expr.node {
            Node::Number(value) => value,
            Node::Parameter(number) => self.parameters.get(number as usize, expr.span)?,
            Node::ParameterAt(inner) => {
                let number = self.number_at(inner, depth)?;
                if number.fract() != 0.0 || !(0.0..=1e6).contains(&number) {
                    return Err(fault(
                        Code::BAD_INDEX,
                        expr.span,
                        format!("E{number} is not a valid parameter"),
                        "check it",
                    ));
                }
                self.parameters.get(number as usize, expr.span)?
            }
            Node::Unary(operator, inner) => {
                let value = self.number_at(inner, depth)?;
                match operator {
                    UnaryOperator::Plus => value,
                    UnaryOperator::Minus => -value,
                    UnaryOperator::Not => truth(value == 0.0),
                }
            }
            Node::Binary(operator, left, right) => {
                binary(operator, self.number_at(left, depth)?, self.number_at(right, depth)?, expr.span)?
            }
            Node::Call(function, inner, second) => {
                let value = self.number_at(inner, depth)?;
                let second = second.map(|id| self.number_at(id, depth)).transpose()?;
                call(function, value, second, expr.span)?
            }
            Node::Named(_) => {
                return Err(fault(Code::UNDEFINED_VARIABLE, expr.span, "not a parameter of this language", "use E0 …"));
            }
        };
        if value.is_finite() { Ok(value) } else { Err(no_value(expr.span)) }
    }
}

fn binary(operator: Operator, left: f64, right: f64, span: Span) -> Result<f64, Fault> {
    let same = (left - right).abs() <= SAME * left.abs().max(right.abs());
    Ok(match operator {
        Operator::Add => left + right,
        Operator::Subtract => left - right,
        Operator::Multiply => left * right,
        Operator::Divide if right == 0.0 => {
            return Err(fault(Code::NOT_COMPUTABLE, span, "a division by 0", "check the divisor"));
        }
        Operator::Divide => left / right,
        Operator::Power => left.powf(right),
        Operator::Equal => truth(same),
        Operator::NotEqual => truth(!same),
        Operator::Greater => truth(left > right && !same),
        Operator::GreaterEqual => truth(left > right || same),
        Operator::Less => truth(left < right && !same),
        Operator::LessEqual => truth(left < right || same),
        Operator::And => truth(left != 0.0 && right != 0.0),
        Operator::Or => truth(left != 0.0 || right != 0.0),
        Operator::Xor => truth((left != 0.0) != (right != 0.0)),
        Operator::Mod => return Err(bad_value(span, "MOD is not an operator of this language", "use int()")),
    })
}

fn call(function: Function, value: f64, second: Option<f64>, span: Span) -> Result<f64, Fault> {
    Ok(match function {
        Function::Sin => sin_deg(value),
        Function::Cos => sin_deg(value + 90.0),
        Function::Tan if sin_deg(value + 90.0) == 0.0 => return Err(no_value(span)),
        Function::Tan => sin_deg(value) / sin_deg(value + 90.0),
        Function::Asin => value.asin().to_degrees(),
        Function::Acos => value.acos().to_degrees(),
        Function::Atan => match second {
            None => value.atan().to_degrees(),
            Some(second) => value.atan2(second).to_degrees(),
        },
        Function::Sqrt if value < 0.0 => return Err(no_value(span)),
        Function::Sqrt => value.sqrt(),
        Function::Abs => value.abs(),
        Function::Int => value.trunc(),
        Function::Round => value.round(),
        Function::Exp => value.exp(),
        Function::Ln => value.ln(),
        Function::Deg => value.to_degrees(),
        Function::Rad => value.to_radians(),
        _ => return Err(bad_value(span, "this is not a function of this language", "use sin, cos, sqrt, int …")),
    })
}

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

fn no_value(span: Span) -> Fault {
    fault(Code::NOT_COMPUTABLE, span, "this expression has no value", "check what it is computed from")
}
