//! Parameters of subprograms: evaluates arguments, binds them, and returns VAR parameters to the caller.

use super::argument::{Argument, Reference};
use super::assign;
use super::cells::Cells;
use super::channel::Channel;
use super::level::Loaded;
use super::scope::scope_of;
use super::variables::List;
use super::variables::Variables;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{ArgumentRange, ExprId, Node, Parameter};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// The cycle of free positions.
const FREE_POSITIONS: &str = "CYCLE802";

/// Evaluates the arguments of a call. `called` is the program with its parameters, `span` is that of the call.
pub(super) fn evaluate(
    caller: &Loaded,
    channel: &Channel<'_>,
    called: (&Loaded, &[Parameter]),
    arguments: Option<ArgumentRange>,
    span: Span,
) -> Result<Vec<Argument>, Fault> {
    let (program, parameters) = called;
    let given = arguments.map_or(&[][..], |range| caller.program.arguments_of(range));
    let short = short_positions(caller, channel, program, given);
    let given = short.as_deref().unwrap_or(given);
    if given.len() > parameters.len() && !(parameters.is_empty() && given == [None]) {
        let message = match parameters.len() {
            0 => "this program takes no arguments".to_owned(),
            1 => format!("this program takes 1 argument, not {}", given.len()),
            count => format!("this program takes {count} arguments, not {}", given.len()),
        };
        return Err(fault(Code::BAD_ARGUMENTS, span, message, "give the arguments of its PROC block"));
    }
    let mut out = Vec::with_capacity(parameters.len());
    for (index, parameter) in parameters.iter().enumerate() {
        out.push(match given.get(index).copied().flatten() {
            Some(id) => one(caller, channel, program, parameter, id)?,
            None if parameter.by_reference && !given.is_empty() => {
                let message = format!("{} needs a variable", program.program.names.text(parameter.name));
                return Err(fault(Code::BAD_ARGUMENTS, span, message, "a VAR parameter cannot be omitted"));
            }
            None => Argument::default(),
        });
    }
    Ok(out)
}

/// CYCLE802 of Operate has two arguments less: the 23rd is then a number, _DMODE, and not the text _HIDE.
fn short_positions(
    caller: &Loaded,
    channel: &Channel<'_>,
    called: &Loaded,
    given: &[Option<ExprId>],
) -> Option<Vec<Option<ExprId>>> {
    const SHORT: usize = 23;
    let (last, others) = given.split_last().filter(|_| given.len() == SHORT)?;
    let is_free = called.own.built_in.is_some_and(|name| name.eq_ignore_ascii_case(FREE_POSITIONS));
    let value = scope_of(caller, channel).value((*last)?).ok().filter(|_| is_free)?;
    value.number()?;
    let mut all = others.to_vec();
    all.extend([None, None, *last]);
    Some(all)
}

fn one(
    caller: &Loaded,
    channel: &Channel<'_>,
    called: &Loaded,
    parameter: &Parameter,
    id: ExprId,
) -> Result<Argument, Fault> {
    let expr = *caller.program.expr(id);
    let text = called.program.names.text(parameter.name);
    let refuse = |message: String, help: &str| Err(fault(Code::BAD_ARGUMENTS, expr.span, message, help));
    let variable = match expr.node {
        Node::Name(name) => channel.variables.cells(name, caller.program.names.text(name)).map(|cells| (name, cells)),
        _ => None,
    };
    if parameter.dimensions > 0 {
        let fits =
            |cells: &Cells| cells.dimensions() == usize::from(parameter.dimensions) && cells.kind() == parameter.kind;
        let Some((name, cells)) = variable.filter(|(_, cells)| fits(cells)) else {
            let count = parameter.dimensions;
            let message = format!("{text} is an array of {count} dimension{}", if count == 1 { "" } else { "s" });
            return refuse(message, "give an array of the same type and number of dimensions");
        };
        let reference = parameter.by_reference.then_some(Reference::Name(name));
        return Ok(Argument { cells: Some(cells.clone()), reference });
    }
    let scope = scope_of(caller, channel);
    let reference = match expr.node {
        _ if !parameter.by_reference => None,
        Node::Parameter(index) => Some(Reference::Parameter(i64::from(index))),
        Node::ParameterAt(index) => Some(Reference::Parameter(scope.whole(index)?)),
        Node::Name(name) if variable.is_some() => Some(Reference::Name(name)),
        Node::Indexed(name, range) if channel.variables.has(name, caller.program.names.text(name)) => {
            Some(Reference::Element(name, scope.indices(range, id)?))
        }
        _ => {
            // An undefined name is reported as such.
            scope.value(id)?;
            return refuse(format!("{text} is a VAR parameter"), "give a variable or an R parameter");
        }
    };
    let mut cells = cells_of(called, channel, parameter)?;
    cells.set(&[], scope.value(id)?, (text, expr.span))?;
    Ok(Argument { cells: Some(cells), reference })
}

/// The cells of a scalar parameter, with its initial value.
fn cells_of(called: &Loaded, channel: &Channel<'_>, parameter: &Parameter) -> Result<Cells, Fault> {
    let length = parameter.length.map(|id| scope_of(called, channel).whole(id)).transpose()?;
    let text = called.program.names.text(parameter.name);
    Cells::new(parameter.kind, length, &[], 1, (text, parameter.span))
}

/// Defines the parameters as variables of the new program level.
pub(super) fn bind(
    called: &Loaded,
    channel: &mut Channel<'_>,
    parameters: &[Parameter],
    arguments: &[Argument],
) -> Result<(), Fault> {
    for (index, parameter) in parameters.iter().enumerate() {
        let text = called.program.names.text(parameter.name);
        let cells = match arguments.get(index).and_then(|argument| argument.cells.clone()) {
            Some(cells) => cells,
            None if parameter.dimensions > 0 => {
                let message = format!("the array {text} was not given");
                let help = "an array parameter cannot be omitted";
                return Err(fault(Code::BAD_ARGUMENTS, parameter.span, message, help));
            }
            None => {
                let mut cells = cells_of(called, channel, parameter)?;
                if let Some(default) = parameter.default {
                    cells.set(&[], scope_of(called, channel).value(default)?, (text, parameter.span))?;
                }
                cells
            }
        };
        channel.variables.define_cells(parameter.name, text, cells, parameter.span)?;
    }
    let bits = arguments.iter().take(64).enumerate();
    channel.variables.set_given(bits.fold(0, |bits, (k, argument)| bits | u64::from(argument.cells.is_some()) << k));
    Ok(())
}

/// Takes the values of the VAR parameters from the ending level.
pub(super) fn results(called: &Loaded, variables: &Variables, parameters: &[Parameter], arguments: &mut [Argument]) {
    for (parameter, argument) in parameters.iter().zip(arguments) {
        if argument.reference.is_some() {
            let text = called.program.names.text(parameter.name);
            argument.cells = variables.cells(parameter.name, text).cloned();
        }
    }
}

/// Assigns the results to the caller's variables, which are restored.
pub(super) fn give_back(
    caller: &Loaded,
    channel: &mut Channel<'_>,
    arguments: &[Argument],
    span: Span,
) -> Result<(), Fault> {
    for argument in arguments {
        let (Some(reference), Some(cells)) = (&argument.reference, &argument.cells) else { continue };
        let names = &caller.program.names;
        if let (Reference::Name(name), true) = (reference, cells.is_array()) {
            channel.variables.replace_cells(*name, names.text(*name), cells.clone());
            continue;
        }
        let Some(list) = cells.first().cloned().map(List::One) else { continue };
        match reference {
            Reference::Parameter(index) => channel.variables.set_parameters(*index, list, span)?,
            Reference::Name(name) => assign::assign_name(caller, &mut channel.variables, *name, list, span)?,
            Reference::Element(name, indices) => {
                channel.variables.assign(*name, names.text(*name), indices, list, span)?;
            }
        }
    }
    Ok(())
}
