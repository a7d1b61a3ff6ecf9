//! Assignments to variables.
//!
//! A Fanuc executes the assignments of a block one after the other. In RS274/NGC all values of a block, including those of its words, are computed
//! before its first assignment takes effect. The assignments take effect before all other words of the block.

use super::channel::Channel;
use super::data_origin::{self, DataOrigin};
use super::expression::{Scope, name_of, no_variable};
use super::level::Loaded;
use super::origin;
use super::predefined;
use super::system;
use super::variables::{Place, Symbol};
use crate::exec::core::fault::{Fault, at, fault};
use crate::syntax::words::{Address, Block, Node, Program, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;

/// Target of an assignment.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    Number(i64),
    Named(Symbol),
}

/// An evaluated assignment.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Assignment {
    target: Target,
    value: Option<f64>,
    /// Origin of the value in data of the control.
    origin: Option<DataOrigin>,
    span: Span,
}

/// `true` if a word is an assignment.
pub(super) fn is_assignment(word: &Word) -> bool {
    matches!(word.address, Address::Variable(_))
}

/// Evaluates the assignments among these words.
pub(super) fn evaluate(scope: &Scope<'_, '_>, words: &[Word]) -> Result<Vec<Assignment>, Fault> {
    words.iter().filter(|word| is_assignment(word)).map(|word| one(scope, word)).collect()
}

/// The error for a block whose assignments are not executed.
pub(super) fn leaves_unset(program: &Program, words: &[Word], found: Fault) -> Fault {
    let names = words.iter().filter_map(|word| match word.address {
        Address::Variable(target) => match program.expr(target).node {
            Node::Named(name) => Some(name_of(program.names.text(name))),
            Node::Parameter(number) => Some(format!("#{number}")),
            _ => None,
        },
        _ => None,
    });
    names.fold(found, |found, name| found.leaves_unset(name))
}

fn one(scope: &Scope<'_, '_>, word: &Word) -> Result<Assignment, Fault> {
    let Address::Variable(target) = word.address else {
        return Err(at(word.span, Code::BAD_EXPRESSION, "this is not an assignment", "write #1=…"));
    };
    let target = match scope.program.expr(target).node {
        Node::Named(name) => {
            let symbol = scope.channel.variables.symbol_of(scope.index, name);
            let text = scope.program.names.text(name);
            if scope.is_predefined(text) {
                let message = format!("#<{}> is read-only", text.to_ascii_lowercase());
                return Err(at(word.span, Code::BAD_WORD_VALUE, message, "use another name"));
            }
            symbol.map(Target::Named)
        }
        _ => scope.target_number(target)?.map(Target::Number),
    };
    let Some(target) = target else {
        return Err(at(word.span, Code::BAD_EXPRESSION, "nothing can be assigned to this", "write #1=…"));
    };
    let value = scope.word(word)?;
    let origin = origin::of_word(scope, word)?;
    Ok(Assignment { target, value, origin, span: word.span })
}

/// Executes assignments.
pub(super) fn assign(
    channel: &mut Channel<'_>,
    assignments: &[Assignment],
    loaded: &Loaded,
    block: &Block,
) -> Result<(), Fault> {
    for assignment in assignments {
        match assignment.target {
            Target::Named(symbol) => {
                channel.variables.set_named(symbol, assignment.value);
                channel.variables.set_origin_of_name(symbol, assignment.origin);
            }
            Target::Number(number) => assign_number(channel, number, assignment, loaded, block)?,
        }
    }
    Ok(())
}

fn assign_number(
    channel: &mut Channel<'_>,
    number: i64,
    assignment: &Assignment,
    loaded: &Loaded,
    block: &Block,
) -> Result<(), Fault> {
    let Assignment { value, origin, span, .. } = *assignment;
    let known = u32::try_from(number).unwrap_or(u32::MAX);
    match channel.variables.place(known) {
        Place::Null => Err(at(span, Code::BAD_INDEX, "#0 is always null", "assign to another variable")),
        Place::Nowhere => Err(no_variable(number, span)),
        Place::System => system::write_system(channel, known, (value, origin), span, loaded, block),
        Place::Variable if channel.language == Language::Rs274 && is_read_only(known) => {
            let message = format!("#{number} is read-only");
            Err(at(span, Code::BAD_WORD_VALUE, message, "it is a state variable of the machine"))
        }
        Place::Variable => {
            if channel.is_rs274() {
                let is_data = matches!(predefined::control_data(known), Some(Some(_)));
                if is_data && origin == Some(DataOrigin::Computed) && channel.settings.strict {
                    return Err(data_origin::not_kept(span));
                }
                let value = value.unwrap_or(0.0);
                let (machine, written) = (channel.settings.machine, &mut channel.written);
                if predefined::write_parameter(machine, written, &mut channel.outlet, known, (value, origin)) {
                    return Ok(());
                }
            }
            channel.variables.set(known, value);
            if let Some(origin) = origin {
                channel.variables.set_origin(known, origin);
            }
            Ok(())
        }
    }
}

/// `true` for parameters of RS274/NGC that contain tool data or positions.
fn is_read_only(number: u32) -> bool {
    matches!(number, 5021..=5029 | 5400..=5413 | 5420..=5428)
}

/// Rejects Fanuc assignments next to words that depend on them: whether these words use the old or the new values is not specified.
pub(super) fn check_beside(words: &[Word], language: Language) -> Result<(), Fault> {
    let depends = |word: &&Word| !is_assignment(word) && matches!(word.value, Value::Expr(_));
    match words.iter().find(depends) {
        Some(word) if language == Language::Fanuc => {
            let message =
                "it is not clear whether this word uses the variables before or after the assignments of its block";
            Err(fault(Code::BAD_EXPRESSION, word.span, message, "put the assignments into their own block"))
        }
        _ => Ok(()),
    }
}
