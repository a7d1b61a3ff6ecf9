//! Assignments that change data of the control by a step: `$P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+5`. The output keeps the step, because the value of the control
//! may differ from that of the machine file.

use super::channel::Channel;
use super::frame_value::frame_text;
use super::level::Loaded;
use super::scope::scope_of;
use super::value::Value as ExecValue;
use crate::exec::core::fault::Fault;
use crate::syntax::sinumerik::{ExprId, Node, Operator, Program, UnaryOperator, Value, Word};

/// Deepest sum in which the variable is searched; a deeper one is written as a value.
const MOST_TERMS: u32 = 64;

/// Returns the words that follow the old value in the output: `+5`, `:CTRANS(X,5)`. `None` if the new value does not depend on the old one, or not as a sum
/// or a chain of frames.
pub(super) fn of(loaded: &Loaded, channel: &Channel<'_>, left: ExprId, word: &Word) -> Result<Option<String>, Fault> {
    let program = &loaded.program;
    let Value::Expr(id) = word.value else { return Ok(None) };
    if !program.source.slice(program.expr(left).span).starts_with(b"$") {
        return Ok(None);
    }
    let scope = scope_of(loaded, channel);
    if let Node::Binary(Operator::Chain, outer, inner) = program.expr(id).node {
        if !is_same(program, left, outer) || reads(program, inner, 0) {
            return Ok(None);
        }
        return Ok(match scope.value(inner)? {
            ExecValue::Frame(parts) => Some(format!(":{}", frame_text(&parts))),
            _ => None,
        });
    }
    let mut terms = Vec::new();
    if !terms_of(program, left, id, &mut terms, 0) {
        return Ok(None);
    }
    let mut step = 0.0;
    for (sign, term) in terms {
        step += sign * scope.number(term)?;
    }
    let shown = String::from_utf8_lossy(&ExecValue::Real(step).text()).into_owned();
    Ok(Some(if shown.starts_with('-') { shown } else { format!("+{shown}") }))
}

/// Collects the terms beside the old value, with their signs; false if the expression is no such sum.
fn terms_of(program: &Program, left: ExprId, id: ExprId, terms: &mut Vec<(f64, ExprId)>, depth: u32) -> bool {
    if depth > MOST_TERMS {
        return false;
    }
    match program.expr(id).node {
        Node::Indexed(..) | Node::Name(_) => is_same(program, left, id),
        Node::Unary(UnaryOperator::Plus, inner) => terms_of(program, left, inner, terms, depth + 1),
        Node::Binary(operator @ (Operator::Add | Operator::Subtract), first, second) => {
            let sign = if operator == Operator::Add { 1.0 } else { -1.0 };
            if !reads(program, second, depth + 1) {
                terms.push((sign, second));
                terms_of(program, left, first, terms, depth + 1)
            } else if operator == Operator::Add && !reads(program, first, depth + 1) {
                terms.push((1.0, first));
                terms_of(program, left, second, terms, depth + 1)
            } else {
                false
            }
        }
        _ => false,
    }
}

/// True if two expressions are written alike, apart from blanks and case.
fn is_same(program: &Program, one: ExprId, other: ExprId) -> bool {
    let text = |id: ExprId| {
        let text = program.source.slice(program.expr(id).span);
        text.iter().filter(|byte| !byte.is_ascii_whitespace()).map(u8::to_ascii_uppercase)
    };
    text(one).eq(text(other))
}

/// True if an expression reads data of the control, or more than can be followed.
fn reads(program: &Program, id: ExprId, depth: u32) -> bool {
    if depth > MOST_TERMS {
        return true;
    }
    let any = |range| program.arguments_of(range).iter().flatten().any(|&id| reads(program, id, depth + 1));
    match program.expr(id).node {
        Node::Name(name) => program.names.text(name).starts_with('$'),
        Node::Indexed(name, range) => program.names.text(name).starts_with('$') || any(range),
        Node::Call(_, range) => any(range),
        Node::ParameterAt(inner) | Node::Unary(_, inner) => reads(program, inner, depth + 1),
        Node::Binary(_, left, right) => reads(program, left, depth + 1) || reads(program, right, depth + 1),
        Node::Real(_) | Node::Integer(_) | Node::Boolean(_) | Node::Text(_) | Node::Parameter(_) => false,
    }
}
