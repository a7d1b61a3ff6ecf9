//! Values that a program computes from zero offsets and tool values of the control: `#5221+5`, also through variables (`#100=#5221`).
//!
//! The value of the control may differ from that of the machine file. So data that is set from such a value is not written as a number: the output has the
//! same sum, which the control computes with its own value. Any other computation from such a value cannot be kept.

use super::channel::Channel;
use super::data_origin::DataOrigin;
use super::expression::Scope;
use super::zero_offset::System;
use super::{predefined, system};
use crate::exec::core::fault::Fault;
use crate::syntax::words::{ExprId, Node, Operator, UnaryOperator, Value, Word};

/// Deepest expression that is followed; a deeper one that reads data of the control counts as computed.
const MOST_TERMS: u32 = 64;

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

/// `true` if a value is that of the same place and a step.
pub(super) fn adds_to(channel: &Channel<'_>, origin: DataOrigin, place: (System, u32)) -> bool {
    let DataOrigin::Stepped { number, step } = origin else { return false };
    step != 0.0 && place_of(channel, number).flatten() == Some(place)
}

/// The place of a variable with data of the control.
fn place_of(channel: &Channel<'_>, number: u32) -> Option<Option<(System, u32)>> {
    if channel.is_rs274() {
        predefined::control_data(number)
    } else {
        system::control_data(number, channel.settings.machine.control.iso.is_haas())
    }
}

/// The origin of the value of a variable.
fn of_variable(scope: &Scope<'_, '_>, number: u32) -> Option<DataOrigin> {
    let channel = scope.channel;
    match place_of(channel, number) {
        // The program itself has set it to a number.
        Some(Some(place)) if channel.written.stated.contains(&place) => None,
        Some(_) => Some(DataOrigin::Stepped { number, step: 0.0 }),
        None => channel.variables.origin(number),
    }
}
