//! Control flow: the effect of a block on the order of execution.

use super::control::System;
use super::order;
use crate::exec::core::motion_sink::MotionSink;
use std::ops::Range;

use super::assign::{assign_value, assignments, define};
use super::channel::Channel;
use super::gathered::Gathered;
use super::jump::jumps;
use super::level::{Action, CallForm, Level, Loaded, ReturnTarget};
use super::scope::{gatherer, scope_of};
use super::value::{Value as ExecValue, is_same};
use super::{part, refusals, sync_action};
use crate::exec::core::fault::{Fault, at};
use crate::exec::core::level::RepeatedSection;
use crate::syntax::sinumerik::{ArgumentRange, Block, Body};
use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, Word as AuxWord, WordValue};

/// Executes one block.
#[expect(clippy::too_many_arguments, reason = "the parts of one execution, borrowed apart")]
pub(super) fn block(
    loaded: &mut Loaded,
    level: &mut Level,
    channel: &mut Channel<'_>,
    block: &Block,
    index: usize,
    section: Range<usize>,
    comment: Option<Vec<u8>>,
    machine: &Machine,
) -> Result<Action, Fault> {
    let partner = block.partner().unwrap_or(index);
    if !matches!(block.body, Body::Words) {
        let is_bare = matches!(block.body, Body::Empty) && comment.is_none() && block.label.is_none();
        channel.comment(comment);
        if is_bare && block.number.is_some() {
            channel.push(Kind::Empty);
        }
    } else {
        return words(loaded, channel, block, comment, machine);
    }
    let scope = scope_of(loaded, channel);
    Ok(match block.body {
        Body::Empty | Body::Words | Body::Faulty | Body::EndIf | Body::Loop | Body::Repeat => Action::Next,
        Body::If(condition) if scope.truth(condition)? => Action::Next,
        // The partner of IF is its ELSE or ENDIF; execution continues after both.
        Body::If(_) => Action::Jump(partner + 1),
        Body::Else => Action::Jump(partner + 1),
        Body::EndLoop => Action::Jump(partner + 1),
        Body::While(condition) if scope.truth(condition)? => Action::Next,
        Body::While(_) => Action::Jump(partner + 1),
        // Without its WHILE the program is faulty; continuing finds further errors, a jump to itself would not.
        Body::EndWhile => Action::Jump(block.partner().unwrap_or(index + 1)),
        Body::Until(condition) if scope.truth(condition)? => Action::Next,
        Body::Until(_) => Action::Jump(partner + 1),
        Body::For { variable, from, to } => {
            // If its values are not available, the loop ends with its first pass, without further diagnostics.
            level.own.for_ends.insert(index, f64::NAN);
            let (from, to) = (scope.value(from)?, scope.number(to)?);
            level.own.for_ends.insert(index, to);
            assign_value(loaded, channel, variable, from, block.span)?;
            // The stored value of the variable: INT has rounded it.
            let start = scope_of(loaded, channel).number(variable)?;
            if reaches(start, to) { Action::Next } else { Action::Jump(partner + 1) }
        }
        Body::EndFor => return end_for(loaded, level, channel, block, partner),
        Body::Jumps { start, count } => return jumps(loaded, channel, index, section, start, count),
        Body::Define { .. } if !level.own.defined.insert(index) => Action::Next,
        Body::Define { start, count } => {
            for place in start as usize..start as usize + usize::from(count) {
                let definition = loaded.program.definitions[place];
                // A failed definition does not affect the others of its block.
                if let Err(found) = define(loaded, channel, &definition) {
                    let name = loaded.program.names.text(definition.name);
                    channel.outlet.warnings.push(found.leaves_unset(name));
                }
            }
            Action::Next
        }
        Body::Proc { .. } | Body::Declaration => Action::Next,
        Body::Call(place) => Action::Call(CallForm::Statement(place)),
        Body::RepeatPart(place) => {
            let passes = part::passes(loaded, channel, &loaded.program.repetitions[place as usize])?;
            let (first, last) = part::blocks_of(loaded, channel, place as usize, index, section)?;
            Action::Repeat(RepeatedSection { first, last, passes: u64::from(passes), pass: () })
        }
        Body::Synchronised { whole, id, condition, actions } => {
            sync_action::execute(loaded, channel, [whole, id, condition, actions])?;
            Action::Next
        }
        Body::Unsupported(span) => {
            let shown = String::from_utf8_lossy(loaded.program.source.slice(span)).to_ascii_uppercase();
            return Err(refusals::refusal(&shown, &shown, span));
        }
    })
}

fn words(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    block: &Block,
    comment: Option<Vec<u8>>,
    machine: &Machine,
) -> Result<Action, Fault> {
    if block.has_names {
        assignments(loaded, channel, block)?;
    }
    let mut gathered = Gathered::new();
    gatherer(loaded, channel, machine).gather(block, &mut gathered)?;
    note_looks(&channel.system, &mut channel.outlet);
    if let Some(call) = gathered.call.take() {
        channel.comment(comment);
        return Ok(Action::Call(CallForm::Word(call)));
    }
    let end = gathered.program_end;
    let target = gathered.is_return.then(|| return_target(loaded, channel, gathered.return_arguments)).transpose()?;
    order::execute(channel, &mut gathered, comment, block.span)?;
    Ok(match end {
        Some(number) => Action::End(Some(number)),
        None => target.map_or(Action::Next, Action::Return),
    })
}

/// `true` if a FOR loop has a pass with this value: up to its end, with equality as in `<=`.
fn reaches(value: f64, end: f64) -> bool {
    value <= end || is_same(value, end)
}

fn end_for(
    loaded: &Loaded,
    level: &Level,
    channel: &mut Channel<'_>,
    block: &Block,
    start: usize,
) -> Result<Action, Fault> {
    let Body::For { variable, .. } = loaded.program.blocks[start].body else { return Ok(Action::Next) };
    let Some(&end) = level.own.for_ends.get(&start) else {
        let message = "a jump into this FOR loop, whose end value is unknown";
        return Err(at(block.span, Code::SKIPPED_INTO, message, "jump to the FOR block instead"));
    };
    let scope = scope_of(loaded, channel);
    let next = match scope.value(variable)? {
        ExecValue::Int(value) => ExecValue::Int(value.saturating_add(1)),
        other => ExecValue::Real(other.number().unwrap_or(f64::NAN) + 1.0),
    };
    let goes_on = next.number().is_some_and(|value| reaches(value, end));
    assign_value(loaded, channel, variable, next, block.span)?;
    Ok(if goes_on { Action::Jump(start + 1) } else { Action::Next })
}

/// The arguments of `RET(target, after, levels)`.
fn return_target(
    loaded: &Loaded,
    channel: &Channel<'_>,
    arguments: Option<ArgumentRange>,
) -> Result<ReturnTarget, Fault> {
    let mut out = ReturnTarget { place: Vec::new(), behind: false, levels: 1 };
    let Some(arguments) = arguments else { return Ok(out) };
    let scope = scope_of(loaded, channel);
    for (index, id) in loaded.program.arguments_of(arguments).iter().enumerate() {
        let Some(id) = *id else { continue };
        let span = loaded.program.expr(id).span;
        match index {
            0 => out.place = scope.value(id)?.text(),
            1 => out.behind = scope.truth(id)?,
            2 => {
                let levels = u32::try_from(scope.whole(id)?).ok().filter(|levels| (1..=100).contains(levels));
                let help = "give the number of program levels to go back";
                out.levels =
                    levels.ok_or_else(|| at(span, Code::BAD_WORD_VALUE, "RET goes back at least one level", help))?;
            }
            _ if scope.truth(id)? => {
                let message = "RET to the start of the main program is not supported yet";
                return Err(at(span, Code::NOT_SUPPORTED, message, "write a label there"));
            }
            _ => {}
        }
    }
    Ok(out)
}

/// Main-run variables read by the block end the look-ahead of the preceding blocks.
pub(super) fn note_looks(system: &System, outlet: &mut MotionSink<'_>) {
    if let Some(name) = system.looked() {
        outlet.stop_look_ahead(name);
    }
}

/// Emits the word that ends the run.
pub(super) fn push_end(channel: &mut Channel<'_>, number: u32) {
    let value = WordValue::Number(f64::from(number));
    channel.push(Kind::After(vec![AuxWord { letter: b'M', extension: None, value }]));
}
