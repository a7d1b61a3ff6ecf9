//! Control flow: the effect of a block on the order of execution.

use super::assign;
use super::assign::{check_beside, evaluate, is_assignment, leaves_unset};
use super::call::{Call, CallKind, Callee};
use super::channel::Channel;
use super::expression::Scope;
use super::gather::gather;
use super::gathered::Gathered;
use super::level::{Action, Level, Loaded};
use super::opaque;
use super::order;
use super::origin;
use super::passes::Passes;
use super::request::{Request, request};
use crate::exec::core::fault::{Fault, at, fault};
use crate::syntax::words::{Block, Body, ExprId, Label, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;

/// Maximum number of arguments of an O-word call.
const MAX_ARGUMENTS: usize = 30;

/// Executes a block; `index` is its index in the program.
pub(super) fn block(
    loaded: &Loaded,
    level: &Level,
    channel: &mut Channel<'_>,
    block: &Block,
    index: usize,
    words: &[Word],
) -> Result<Action, Fault> {
    let scope = Scope { program: &loaded.program, index: level.program, channel, grid: None };
    let behind = |at: usize| Action::Jump(at + 1);
    // A structure without its other end was already reported; continuing finds further errors.
    let partner = block.partner();
    let behind_partner = || partner.map_or(Action::Next, behind);
    Ok(match block.body {
        Body::Words => return execute(loaded, level, channel, block, words),
        Body::IfThen(condition) => {
            if truth(&scope, condition)? {
                return execute(loaded, level, channel, block, words);
            }
            Action::Next
        }
        Body::Empty => {
            channel.empty();
            Action::Next
        }
        Body::Faulty | Body::Do | Body::EndIf | Body::While(None) => Action::Next,
        Body::Goto(target) => jump(loaded, &scope, level, index, target)?,
        Body::IfGoto { condition, target } if truth(&scope, condition)? => jump(loaded, &scope, level, index, target)?,
        Body::IfGoto { .. } => Action::Next,
        Body::While(Some(condition)) if truth(&scope, condition)? => Action::Next,
        Body::While(Some(_)) => {
            channel.loops.continues = false;
            channel.loops.breaks |= loaded.own.has_break_behind(index, index);
            behind_partner()
        }
        Body::EndWhile | Body::EndRepeat => partner.map_or(Action::Next, Action::Jump),
        Body::DoWhile(condition) => {
            let goes_on = truth(&scope, condition)?;
            if goes_on && !channel.loops.breaks {
                behind_partner()
            } else {
                channel.loops.breaks = false;
                Action::Next
            }
        }
        Body::Repeat(count) => {
            // A larger count is ended by the limit of blocks.
            let count = scope.number(count)?.round().clamp(0.0, f64::from(u32::MAX)) as u32;
            if channel.loops.repeat((level.program, index), count) { Action::Next } else { behind_partner() }
        }
        Body::If(condition) if truth(&scope, condition)? => Action::Next,
        Body::If(_) => next_branch(&scope, block)?,
        // Reached from above: the previous branch was taken.
        Body::ElseIf(_) | Body::Else => Action::Jump(end_of_if(loaded, index)),
        Body::Break | Body::Continue => leave_pass(loaded, &mut channel.loops, block, index)?,
        // A definition has no effect where it stands.
        Body::Sub => behind_partner(),
        Body::EndSub(value) | Body::Return(value) => {
            if !level.own.is_sub() {
                let message = "this ends a subroutine, but none was called";
                return Err(at(block.span, Code::UNMATCHED_STRUCTURE, message, "M2 ends the program"));
            }
            let value = value.map(|id| scope.number(id)).transpose()?;
            channel.variables.returned = value;
            Action::Return(None)
        }
        Body::Call(arguments) => {
            let arguments = loaded.program.arguments_of(arguments);
            let name = label(&scope, block)?;
            Action::Call(Box::new(call_of_sub(&scope, name, arguments, block.span)?))
        }
        Body::Printing(span) => {
            let shown = String::from_utf8_lossy(loaded.program.source.slice(span)).into_owned();
            let message = format!("{shown} is omitted from the output: its variables are resolved");
            channel.outlet.warnings.push(fault(Code::LEFT_OUT, span, message, "the motion does not change"));
            Action::Next
        }
    })
}

/// True if a condition is true. A condition that uses data of the control is noted.
fn truth(scope: &Scope<'_, '_>, condition: ExprId) -> Result<bool, Fault> {
    if origin::of(scope, condition)?.is_some() {
        scope.channel.variables.fixed.note(scope.span(condition));
    }
    scope.truth(condition)
}

/// Executes the words of a block: assignments, calls, and the words for the channel.
fn execute(
    loaded: &Loaded,
    level: &Level,
    channel: &mut Channel<'_>,
    block: &Block,
    words: &[Word],
) -> Result<Action, Fault> {
    let requested = request(channel.settings.machine, channel.language, level, words);
    if requested.is_none() && opaque::pass_block(&loaded.program, level.program, channel, words, block.span)? {
        return Ok(Action::Next);
    }
    let has_assignments = words.iter().any(is_assignment);
    if has_assignments && channel.language == Language::Fanuc {
        check_beside(words, channel.language)?;
        for word in words.iter().filter(|word| is_assignment(word)) {
            let scope = Scope { program: &loaded.program, index: level.program, channel, grid: None };
            let assignment = evaluate(&scope, std::slice::from_ref(word));
            let assignment =
                assignment.map_err(|found| leaves_unset(&loaded.program, std::slice::from_ref(word), found))?;
            assign::assign(channel, &assignment, loaded, block)?;
        }
    }
    let mut own = Vec::new();
    let (words, requested): (&[Word], _) = match requested {
        None => (words, None),
        Some(requested) => {
            let scope = Scope { program: &loaded.program, index: level.program, channel, grid: None };
            let action = requested.read(&scope, words, block.span)?;
            own.extend(words.iter().filter(|word| !requested.takes(&loaded.program, word)).copied());
            (&own, Some((requested, action)))
        }
    };
    let is_silent = words.iter().all(is_assignment);
    let mut gathered = channel.take_gathered(block.span);
    let done = run(loaded, level, channel, block, words, &mut gathered, has_assignments, is_silent);
    channel.put_back(gathered);
    // The program ends as commanded, even if the block has an error.
    let ends = std::mem::take(&mut channel.block.ends_program);
    match done {
        Err(found) if !ends => return Err(found),
        Err(found) => channel.outlet.warnings.push(found),
        Ok(()) => {}
    }
    if ends {
        return Ok(Action::End(()));
    }
    match requested {
        Some((Request::Modal, Action::Call(call))) => {
            channel.modal_calls.push(*call);
            Ok(Action::Next)
        }
        Some((Request::EndModal, _)) => {
            channel.modal_calls.pop();
            Ok(Action::Next)
        }
        Some((_, action)) => Ok(action),
        None => Ok(Action::Next),
    }
}

#[expect(clippy::too_many_arguments, reason = "the parts of one execution, borrowed apart")]
fn run(
    loaded: &Loaded,
    level: &Level,
    channel: &mut Channel<'_>,
    block: &Block,
    words: &[Word],
    gathered: &mut Gathered,
    has_assignments: bool,
    is_silent: bool,
) -> Result<(), Fault> {
    let scope = Scope { program: &loaded.program, index: level.program, channel, grid: None };
    let found = gather(&scope, words, gathered);
    let assignments = if has_assignments && channel.language == Language::Rs274 {
        let scope = Scope { program: &loaded.program, index: level.program, channel, grid: None };
        found.and_then(|()| evaluate(&scope, words))
    } else {
        found.map(|()| Vec::new())
    };
    let assignments = assignments.map_err(|found| leaves_unset(&loaded.program, words, found))?;
    assign::assign(channel, &assignments, loaded, block)?;
    if is_silent { Ok(()) } else { order::execute(channel, gathered) }
}

/// `o100 call [1] [2]`
fn call_of_sub(scope: &Scope<'_, '_>, name: String, arguments: &[ExprId], span: Span) -> Result<Call, Fault> {
    if arguments.len() > MAX_ARGUMENTS {
        let message = format!("{} arguments; a subroutine has {MAX_ARGUMENTS}", arguments.len());
        return Err(fault(Code::BAD_ARGUMENTS, span, message, "pass the others in global parameters"));
    }
    let values = (1..).zip(arguments).map(|(number, &id)| Ok((number, scope.number(id)?, origin::of(scope, id)?)));
    let arguments = values.collect::<Result<_, Fault>>()?;
    let callee = Callee::Sub(name);
    Ok(Call { callee, kind: CallKind::Sub, repeats: 1, at_block: None, arguments, span, is_of_code: false })
}

/// `GOTO n`: the next block with this number, otherwise the first one of the program.
fn jump(loaded: &Loaded, scope: &Scope<'_, '_>, level: &Level, index: usize, target: ExprId) -> Result<Action, Fault> {
    let span = scope.span(target);
    let number = scope.whole(target)?;
    let found = u32::try_from(number).ok().and_then(|number| scope.program.find_block(level.part, number, index));
    let Some(found) = found else {
        let message = format!("block N{number} is not in this program");
        return Err(at(span, Code::NO_TARGET, message, "check the number of the block"));
    };
    check_loops(loaded, index, found, span)?;
    Ok(Action::Jump(found))
}

/// Rejects a jump into a loop.
pub(super) fn check_loops(loaded: &Loaded, from: usize, to: usize, span: Span) -> Result<(), Fault> {
    let enters = |&(start, end): &(usize, usize)| (start + 1..=end).contains(&to) && !(start..=end).contains(&from);
    if loaded.own.spans.iter().any(enters) {
        let message = "this jump leads into a loop whose DO was not executed";
        return Err(at(span, Code::SKIPPED_INTO, message, "jump to the block of the DO instead"));
    }
    Ok(())
}

/// The next branch of an IF whose condition is false.
fn next_branch(scope: &Scope<'_, '_>, block: &Block) -> Result<Action, Fault> {
    let mut next = block.partner();
    while let Some(at) = next {
        let Some(branch) = scope.program.blocks.get(at) else { break };
        match branch.body {
            Body::ElseIf(condition) if !truth(scope, condition)? => next = branch.partner().filter(|&next| next > at),
            _ => return Ok(Action::Jump(at + 1)),
        }
    }
    Ok(Action::Next)
}

/// The block after the IF of an ELSE or ELSEIF; without an IF, the next block.
fn end_of_if(loaded: &Loaded, index: usize) -> usize {
    let mut at = index;
    while let Some(block) = loaded.program.blocks.get(at)
        && matches!(block.body, Body::ElseIf(_) | Body::Else)
    {
        match block.partner().filter(|&next| next > at) {
            Some(next) => at = next,
            None => return at + 1,
        }
    }
    at
}

/// `break` and `continue`.
fn leave_pass(loaded: &Loaded, loops: &mut Passes, block: &Block, index: usize) -> Result<Action, Fault> {
    let at_index = |index: usize| loaded.program.blocks.get(index);
    let Some(partner) = block.partner() else { return Ok(Action::Next) };
    // The partner is one end of the loop, and its own partner is the other end.
    let Some(other) = at_index(partner).and_then(Block::partner) else { return Ok(Action::Next) };
    let (start, end) = (partner.min(other), partner.max(other));
    let body = at_index(start).map(|block| block.body);
    if matches!(body, Some(Body::Repeat(_))) {
        let message = "break and continue belong to while and do loops, and this is a repeat loop";
        return Err(at(block.span, Code::UNMATCHED_STRUCTURE, message, "use a while loop"));
    }
    let is_do = body == Some(Body::Do);
    if block.body == Body::Continue {
        loops.continues = is_do;
        loops.breaks |= loaded.own.has_break_behind(start, index);
        return Ok(Action::Jump(end));
    }
    loops.breaks = true;
    // The end of a `do` loop evaluates its condition.
    let again = !is_do && std::mem::take(&mut loops.continues);
    Ok(Action::Jump(if is_do || again { end } else { end + 1 }))
}

/// The label of an O-word as text, lower case.
pub(super) fn label(scope: &Scope<'_, '_>, block: &Block) -> Result<String, Fault> {
    Ok(match block.label {
        Some(Label::Number(number)) => number.to_string(),
        Some(Label::Name(name)) => scope.program.names.text(name).to_ascii_lowercase(),
        Some(Label::Computed(id)) => scope.whole(id)?.to_string(),
        None => String::new(),
    })
}
