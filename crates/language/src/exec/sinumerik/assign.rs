//! Assignments: R parameters, variables, arrays, and other left sides.

use super::beside;
use super::channel::Channel;
use super::level::Loaded;
use super::names::Meaning;
use super::own_step;
use super::scope::scope_of;
use super::system_write::{SystemName, assign_system};
use super::value::Value as ExecValue;
use super::variables::Variables;
use super::variables::{List, Shape};
use crate::exec::core::fault::{Fault, at};
use crate::syntax::sinumerik::{Address, Block, Definition, ExprId, NameId, Node, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Treatment;

/// Executes the assignments of a block from left to right. Words that depend on them are rejected in the block.
pub(super) fn assignments(loaded: &Loaded, channel: &mut Channel<'_>, block: &Block) -> Result<(), Fault> {
    super::beside::check(loaded, channel, block)?;
    for word in loaded.program.words_of(block) {
        let span = word.span;
        match word.address {
            Address::Extended(b'R', index) => {
                let list = assigned(loaded, channel, word);
                let list = list.map_err(|found| found.leaves_unset(format!("R{index}")))?;
                channel.variables.set_parameters(i64::from(index), list, span)?;
            }
            Address::Name(name) if channel.variables.has(name, loaded.program.names.text(name)) => {
                let list = assigned(loaded, channel, word)?;
                assign_name(loaded, &mut channel.variables, name, list, span)?;
            }
            Address::Indexed(left) if beside::is_assignable(loaded, &channel.variables, left) => {
                let list = assigned(loaded, channel, word)?;
                let step = own_step::of(loaded, channel, left, word)?;
                if step.is_some() {
                    channel.variables.fixed.forget();
                }
                assign_stepped(loaded, channel, left, list, (span, step.as_deref()))?;
            }
            Address::Name(name) if loaded.program.names.text(name).starts_with('$') => {
                let list = assigned(loaded, channel, word)?;
                let name = loaded.program.names.text(name);
                assign_system(loaded, channel, SystemName { name, range: None, span, step: None }, list)?;
            }
            _ if matches!(word.value, Value::Arguments(_)) => file_result(loaded, channel, word)?,
            _ => {}
        }
    }
    Ok(())
}

/// The right side of an assignment.
pub(super) fn assigned(loaded: &Loaded, channel: &Channel<'_>, word: &Word) -> Result<List, Fault> {
    let scope = scope_of(loaded, channel);
    match word.value {
        Value::Expr(id) => scope.assigned(id),
        Value::Arguments(range) => scope.list(range).map(List::Set),
        _ => Err(at(
            word.span,
            Code::UNEXPECTED,
            "this is not an assignment",
            "write '=' and an expression after the name",
        )),
    }
}

pub(super) fn assign_name(
    loaded: &Loaded,
    variables: &mut Variables,
    name: NameId,
    list: List,
    span: Span,
) -> Result<(), Fault> {
    let text = loaded.program.names.text(name);
    if variables.assign(name, text, &[], list, span)? {
        return Ok(());
    }
    Err(at(
        span,
        Code::UNDEFINED_VARIABLE,
        format!("{text} is not defined"),
        "define it with DEF at the start of this program",
    )
    .of_variable(text))
}

/// Assigns one value to the left side of an assignment.
pub(super) fn assign_value(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    left: ExprId,
    value: ExecValue,
    span: Span,
) -> Result<(), Fault> {
    assign(loaded, channel, left, List::One(value), span)
}

/// Assigns to the left side of an assignment: an R parameter, a variable, an element.
pub(super) fn assign(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    left: ExprId,
    list: List,
    span: Span,
) -> Result<(), Fault> {
    assign_stepped(loaded, channel, left, list, (span, None))
}

/// Assigns to the left side of an assignment; `step` is what the program adds to the old value of a system variable.
fn assign_stepped(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    left: ExprId,
    list: List,
    (span, step): (Span, Option<&str>),
) -> Result<(), Fault> {
    let scope = scope_of(loaded, channel);
    match loaded.program.expr(left).node {
        Node::Parameter(index) => channel.variables.set_parameters(i64::from(index), list, span),
        Node::ParameterAt(index) => {
            let index = scope.whole(index)?;
            channel.variables.set_parameters(index, list, span)
        }
        Node::Name(name) if loaded.program.names.text(name).starts_with('$') => {
            let name = loaded.program.names.text(name);
            assign_system(loaded, channel, SystemName { name, range: None, span, step: None }, list)
        }
        Node::Name(name) => assign_name(loaded, &mut channel.variables, name, list, span),
        Node::Indexed(name, range) if channel.variables.has(name, loaded.program.names.text(name)) => {
            let text = loaded.program.names.text(name);
            if let Some((axis, component, front)) = scope.component(range)? {
                let indices = scope.first_indices(range, front, left)?;
                let old = channel.variables.cells(name, text).map(|cells| cells.get(&indices, (text, span)));
                let (Some(ExecValue::Frame(mut parts)), List::One(value)) = (old.transpose()?, list) else {
                    return Err(at(
                        span,
                        Code::TYPE_MISMATCH,
                        "this is not a component of a frame",
                        "write a FRAME variable",
                    ));
                };
                let number = value.number().ok_or_else(|| {
                    at(span, Code::TYPE_MISMATCH, "a component of a frame is a number", "assign a number")
                })?;
                scope.set_component(&mut parts, axis, component, number, span)?;
                let list = List::One(ExecValue::Frame(parts));
                return channel.variables.assign(name, text, &indices, list, span).map(|_| ());
            }
            let indices = scope.indices(range, left)?;
            channel.variables.assign(name, text, &indices, list, span).map(|_| ())
        }
        Node::Indexed(name, range) => {
            let name = loaded.program.names.text(name);
            assign_system(loaded, channel, SystemName { name, range: Some(range), span, step }, list)
        }
        _ => Err(at(span, Code::UNEXPECTED, "this cannot be assigned", "write a variable left of the equals sign")),
    }
}

/// Executes one definition of a DEF block.
pub(super) fn define(loaded: &Loaded, channel: &mut Channel<'_>, definition: &Definition) -> Result<(), Fault> {
    let scope = scope_of(loaded, channel);
    let text = loaded.program.names.text(definition.name);
    let string = definition.length.map(|id| scope.whole(id)).transpose()?;
    let mut dimensions = Vec::new();
    for length in loaded.program.arguments_of(definition.dimensions) {
        let Some(length) = length else {
            let message = format!("{text} has a dimension without a length");
            return Err(at(definition.span, Code::BAD_INDEX, message, "give the length of every dimension"));
        };
        dimensions.push(scope.whole(*length)?);
    }
    let value = definition.value.map(|id| scope.assigned(id)).transpose()?;
    let shape = Shape { kind: definition.kind, string, dimensions: &dimensions };
    if definition.is_global {
        channel.variables.define_global(text, shape, value, definition.span)
    } else {
        channel.variables.define(definition.name, text, shape, value, definition.span)
    }
}

/// The result variable of a file access, which happens on the control only: no error.
pub(super) fn file_result(loaded: &Loaded, channel: &mut Channel<'_>, word: &Word) -> Result<(), Fault> {
    let (Address::Name(name), Value::Arguments(range)) = (word.address, word.value) else { return Ok(()) };
    let Meaning::Kept(row) = loaded.own.meanings[name.index()] else { return Ok(()) };
    match loaded.program.arguments_of(range) {
        [Some(result), ..] if row.treatment == Treatment::File => {
            assign_value(loaded, channel, *result, ExecValue::Int(0), word.span)
        }
        _ => Ok(()),
    }
}
