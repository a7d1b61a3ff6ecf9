//! Assignments: R parameters, variables, and whatever else may stand left of an equals sign.

use super::channel::Channel;
use super::fault::Fault;
use super::value::Value as ExecValue;
use super::{Loaded, at, scope_of};
use crate::diagnostic::Code;
use crate::source::Span;
use crate::syntax::{Address, Block, ExprId, NameId, Node, Value, Word};

/// Carries out the assignments of a block, from left to right, before its words take effect.
pub(super) fn assignments(loaded: &Loaded, channel: &mut Channel<'_>, block: &Block) -> Result<(), Fault> {
    for word in loaded.program.words_of(block) {
        let Word { address, value: Value::Expr(id), span } = *word else {
            if let Address::Extended(b'R', _) | Address::Indexed(_) = word.address {
                return Err(at(
                    word.span,
                    Code::NOT_SUPPORTED,
                    "this assignment is not supported yet",
                    "assign a plain expression",
                ));
            }
            continue;
        };
        match address {
            Address::Extended(b'R', index) => {
                let value = scope_of(loaded, channel).number(id)?;
                channel.variables.set_parameter(i64::from(index), value, span)?;
            }
            Address::Name(name) if channel.variables.has(name) => {
                let value = scope_of(loaded, channel).value(id)?;
                assign_name(loaded, channel, name, value, span)?;
            }
            Address::Indexed(left) => {
                let value = scope_of(loaded, channel).value(id)?;
                assign(loaded, channel, left, value, span)?;
            }
            _ => {}
        }
    }
    Ok(())
}

pub(super) fn assign_name(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    name: NameId,
    value: ExecValue,
    span: Span,
) -> Result<(), Fault> {
    let text = loaded.program.names.text(name);
    if channel.variables.assign(name, text, value, span)? {
        return Ok(());
    }
    Err(at(
        span,
        Code::UNDEFINED_VARIABLE,
        format!("{text} is not defined"),
        "define it with DEF at the start of this program",
    ))
}

/// Assigns to the left side of an assignment: an R parameter or a variable.
pub(super) fn assign(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    left: ExprId,
    value: ExecValue,
    span: Span,
) -> Result<(), Fault> {
    let scope = scope_of(loaded, channel);
    let number = |value: &ExecValue| {
        value.number().ok_or_else(|| at(span, Code::TYPE_MISMATCH, "an R parameter holds a number", "assign a number"))
    };
    match loaded.program.expr(left).node {
        Node::Parameter(index) => channel.variables.set_parameter(i64::from(index), number(&value)?, span),
        Node::ParameterAt(index) => {
            let index = scope.whole(index)?;
            channel.variables.set_parameter(index, number(&value)?, span)
        }
        Node::Name(name) => assign_name(loaded, channel, name, value, span),
        _ => {
            let shown =
                String::from_utf8_lossy(loaded.program.source.slice(loaded.program.expr(left).span)).into_owned();
            Err(at(
                span,
                Code::NOT_SUPPORTED,
                format!("assigning {shown} is not supported yet"),
                "use a plain variable or an R parameter",
            ))
        }
    }
}
