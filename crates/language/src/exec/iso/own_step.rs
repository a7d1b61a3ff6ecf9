//! Assignments that change a value of the control by a step: `#5221=#5221+0.1`. The output keeps the step, because the value of the control may differ from
//! that of the machine file.

use super::expression::Scope;
use crate::exec::core::fault::Fault;
use crate::syntax::words::{ExprId, Node, Operator, UnaryOperator, Value, Word};

/// Deepest sum in which the variable is searched; a deeper one is written as a value.
const MOST_TERMS: u32 = 64;

/// Returns the step by which an assignment changes the variable of this number; `None` if its value does not depend on the old one, or not as a sum.
pub(super) fn of(scope: &Scope<'_, '_>, number: i64, word: &Word) -> Result<Option<f64>, Fault> {
    match word.value {
        Value::Expr(id) => step(scope, number, id, 0),
        Value::Number { .. } | Value::None => Ok(None),
    }
}

fn step(scope: &Scope<'_, '_>, number: i64, id: ExprId, depth: u32) -> Result<Option<f64>, Fault> {
    if depth > MOST_TERMS {
        return Ok(None);
    }
    Ok(match scope.program.expr(id).node {
        Node::Parameter(_) | Node::ParameterAt(_) => (scope.target_number(id)? == Some(number)).then_some(0.0),
        Node::Unary(UnaryOperator::Plus, inner) => step(scope, number, inner, depth + 1)?,
        Node::Binary(Operator::Add, left, right) if !reads(scope, right, depth + 1) => {
            match step(scope, number, left, depth + 1)? {
                Some(known) => Some(known + scope.number(right)?),
                None => None,
            }
        }
        Node::Binary(Operator::Add, left, right) if !reads(scope, left, depth + 1) => {
            match step(scope, number, right, depth + 1)? {
                Some(known) => Some(known + scope.number(left)?),
                None => None,
            }
        }
        Node::Binary(Operator::Subtract, left, right) if !reads(scope, right, depth + 1) => {
            match step(scope, number, left, depth + 1)? {
                Some(known) => Some(known - scope.number(right)?),
                None => None,
            }
        }
        _ => None,
    })
}

/// True if an expression reads data of the control, or a variable whose number is computed.
fn reads(scope: &Scope<'_, '_>, id: ExprId, depth: u32) -> bool {
    if depth > MOST_TERMS {
        return true;
    }
    match scope.program.expr(id).node {
        Node::Number(_) | Node::Named(_) => false,
        Node::Parameter(number) => number >= FIRST_OF_CONTROL,
        Node::ParameterAt(_) => true,
        Node::Unary(_, inner) => reads(scope, inner, depth + 1),
        Node::Binary(_, left, right) => reads(scope, left, depth + 1) || reads(scope, right, depth + 1),
        Node::Call(_, first, second) => {
            reads(scope, first, depth + 1) || second.is_some_and(|second| reads(scope, second, depth + 1))
        }
    }
}

/// From this number on, variables contain data of the control (Fanuc: 1000; RS274/NGC: 5061).
const FIRST_OF_CONTROL: u32 = 1000;
