//! Values that a program computes from zero offsets and tool values of the control: `#5221+5`, also through variables (`#100=#5221`).
//!
//! The value of the control may differ from that of the machine file. So data that is set from such a value is not written as a number: the output has the
//! same sum, which the control computes with its own value. Any other computation from such a value cannot be kept.

use super::expression::Scope;
use super::{predefined, system};
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::words::{ExprId, Node, Operator, UnaryOperator, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Deepest expression that is followed; a deeper one that reads data of the control counts as computed.
const MOST_TERMS: u32 = 64;

/// Origin of a value in data of the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum DataOrigin {
    /// The value of the variable of this number, and a step in the unit of the program.
    Stepped { number: u32, step: f64 },
    /// Computed from such a value in another way.
    Computed,
}

impl DataOrigin {
    /// Returns the sum as it is written, without brackets: `#5221+5`. The step is multiplied by a factor for the unit of the output.
    pub(super) fn text(self, factor: f64) -> Option<String> {
        let DataOrigin::Stepped { number, step } = self else { return None };
        let shown = system::decimals(step * factor);
        Some(match shown.as_str() {
            "0" => format!("#{number}"),
            shown if shown.starts_with('-') => format!("#{number}{shown}"),
            shown => format!("#{number}+{shown}"),
        })
    }
}

/// The error for a value that the output cannot keep as the control computes it.
pub(super) fn not_kept(span: Span) -> Fault {
    let message = "the new value is computed from a zero offset or a tool value of the control, and not as its value plus a number";
    let help = "write the change as a sum, such as #5221=#5221+5. or G10 L2 P1 X[#5221+5.], or write the new value as a number";
    fault(Code::NO_SYSTEM_VALUE, span, message, help)
}

/// Returns the origin of the value of a word; `None` if it does not depend on data of the control.
pub(super) fn of_word(scope: &Scope<'_, '_>, word: &Word) -> Result<Option<DataOrigin>, Fault> {
    match word.value {
        Value::Expr(id) => of(scope, id),
        Value::Number { .. } | Value::None => Ok(None),
    }
}

/// Returns the origin of an expression.
pub(super) fn of(scope: &Scope<'_, '_>, id: ExprId) -> Result<Option<DataOrigin>, Fault> {
    origin(scope, id, 0)
}

fn origin(scope: &Scope<'_, '_>, id: ExprId, depth: u32) -> Result<Option<DataOrigin>, Fault> {
    if depth > MOST_TERMS {
        return Ok(Some(DataOrigin::Computed));
    }
    let inner = |id| origin(scope, id, depth + 1);
    Ok(match scope.program.expr(id).node {
        Node::Number(_) => None,
        Node::Parameter(_) | Node::ParameterAt(_) => {
            let number = scope.target_number(id)?.and_then(|number| u32::try_from(number).ok());
            number.and_then(|number| of_variable(scope, number))
        }
        Node::Named(name) => {
            let symbol = scope.channel.variables.symbol_of(scope.index, name);
            symbol.and_then(|symbol| scope.channel.variables.origin_of_name(symbol))
        }
        Node::Unary(UnaryOperator::Plus, term) => inner(term)?,
        Node::Unary(_, term) => inner(term)?.map(|_| DataOrigin::Computed),
        Node::Binary(operator, left, right) => match (operator, inner(left)?, inner(right)?) {
            (_, None, None) => None,
            (Operator::Add, Some(DataOrigin::Stepped { number, step }), None) => {
                Some(DataOrigin::Stepped { number, step: step + scope.number(right)? })
            }
            (Operator::Subtract, Some(DataOrigin::Stepped { number, step }), None) => {
                Some(DataOrigin::Stepped { number, step: step - scope.number(right)? })
            }
            (Operator::Add, None, Some(DataOrigin::Stepped { number, step })) => {
                Some(DataOrigin::Stepped { number, step: step + scope.number(left)? })
            }
            _ => Some(DataOrigin::Computed),
        },
        Node::Call(_, first, second) => {
            let second = second.map(inner).transpose()?.flatten();
            inner(first)?.or(second).map(|_| DataOrigin::Computed)
        }
    })
}

/// The origin of the value of a variable.
fn of_variable(scope: &Scope<'_, '_>, number: u32) -> Option<DataOrigin> {
    let channel = scope.channel;
    let place = if channel.is_rs274() {
        predefined::control_data(number)
    } else {
        system::control_data(number, channel.settings.machine.control.iso.is_haas())
    };
    match place {
        // The program itself has set it to a number.
        Some(Some(place)) if channel.written.stated.contains(&place) => None,
        Some(_) => Some(DataOrigin::Stepped { number, step: 0.0 }),
        None => channel.variables.origin(number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_is_written_as_the_control_computes_it() {
        let text = |number, step| DataOrigin::Stepped { number, step }.text(1.0).unwrap();
        assert_eq!([text(5221, 5.0), text(5221, -0.25), text(5221, 0.0)], ["#5221+5", "#5221-0.25", "#5221"]);
        assert_eq!(DataOrigin::Computed.text(1.0), None);
    }
}
