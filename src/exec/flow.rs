//! Control flow: what a block does to the order of execution.

use std::collections::HashMap;
use std::ops::Range;

use super::assign::{assign_value, assignments, define};
use super::channel::Channel;
use super::fault::Fault;
use super::gathered::Call;
use super::value::Value as ExecValue;
use super::variables::Locals;
use super::{Loaded, at, gatherer, scope_of};
use crate::diagnostic::Code;
use crate::machine::Machine;
use crate::snc::{Kind, Word as AuxWord, WordValue};
use crate::syntax::{Block, Body, Jump, JumpTarget, Search};

/// A program level: a program that runs, and where it is.
pub(super) struct Level {
    pub(super) program: usize,
    pub(super) section: usize,
    /// The block to execute next.
    pub(super) next: usize,
    /// The call chain that led here.
    pub(super) calls: u32,
    /// How many runs of this program are left, this one included.
    pub(super) repeats: u32,
    /// Variables of the level that called this one.
    pub(super) callers_variables: Locals,
    /// End values of FOR loops by the block of the FOR.
    for_ends: HashMap<usize, f64>,
}

impl Level {
    pub(super) fn new(program: usize, section: usize, next: usize, calls: u32) -> Self {
        let (repeats, callers_variables) = (1, Locals::default());
        Level { program, section, next, calls, repeats, callers_variables, for_ends: HashMap::new() }
    }

    /// Forgets what the last run of the program left behind.
    pub(super) fn restart(&mut self) {
        self.for_ends.clear();
    }
}

/// What comes after a block.
#[derive(Debug, PartialEq)]
pub(super) enum Action {
    Next,
    Jump(usize),
    Call(Call),
    /// RET
    Return,
    /// M2, M17, M30
    End(u32),
}

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
        // The partner of IF is its ELSE or ENDIF; both are left behind.
        Body::If(_) => Action::Jump(partner + 1),
        Body::Else => Action::Jump(partner + 1),
        Body::EndLoop => Action::Jump(partner + 1),
        Body::While(condition) if scope.truth(condition)? => Action::Next,
        Body::While(_) => Action::Jump(partner + 1),
        // Without its WHILE the program is faulty; going on finds more, jumping to itself would not.
        Body::EndWhile => Action::Jump(block.partner().unwrap_or(index + 1)),
        Body::Until(condition) if scope.truth(condition)? => Action::Next,
        Body::Until(_) => Action::Jump(partner + 1),
        Body::For { variable, from, to } => {
            let (from, to) = (scope.value(from)?, scope.number(to)?);
            level.for_ends.insert(index, to);
            let start = from.number();
            assign_value(loaded, channel, variable, from, block.span)?;
            if start.is_some_and(|start| start <= to) { Action::Next } else { Action::Jump(partner + 1) }
        }
        Body::EndFor => return end_for(loaded, level, channel, block, partner),
        Body::Jumps { start, count } => return jumps(loaded, channel, index, section, start, count),
        Body::Define { start, count } => {
            for place in start as usize..start as usize + usize::from(count) {
                let definition = loaded.program.definitions[place];
                define(loaded, channel, &definition)?;
            }
            Action::Next
        }
        Body::Proc { parameters: Some(span), .. } => {
            let message = "programs with parameters are not supported yet";
            return Err(at(span, Code::NOT_SUPPORTED, message, "pass values in R parameters"));
        }
        Body::Proc { save: Some(span), .. } => {
            let message = "SAVE is not supported yet";
            return Err(at(
                span,
                Code::NOT_SUPPORTED,
                message,
                "restore the modal codes with words at the end of the program",
            ));
        }
        Body::Proc { .. } => Action::Next,
        Body::Unsupported(span) => {
            let shown = String::from_utf8_lossy(loaded.program.source.slice(span)).to_ascii_uppercase();
            let message = format!("{shown} is not supported yet");
            return Err(at(span, Code::NOT_SUPPORTED, message, "the program cannot be corrected with it"));
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
    let mut gathered = gatherer(loaded, channel, machine).gather(block)?;
    if let Some(call) = gathered.call.take() {
        channel.comment(comment);
        return Ok(Action::Call(call));
    }
    let (end, is_return) = (gathered.program_end, gathered.is_return);
    channel.execute(&mut gathered, comment, block.span)?;
    Ok(match end {
        Some(number) => Action::End(number),
        None if is_return => Action::Return,
        None => Action::Next,
    })
}

fn end_for(
    loaded: &Loaded,
    level: &Level,
    channel: &mut Channel<'_>,
    block: &Block,
    start: usize,
) -> Result<Action, Fault> {
    let Body::For { variable, .. } = loaded.program.blocks[start].body else { return Ok(Action::Next) };
    let Some(&end) = level.for_ends.get(&start) else {
        let message = "a jump led into this FOR loop, whose end value is unknown";
        return Err(at(block.span, Code::SKIPPED_INTO, message, "jump to the FOR block instead"));
    };
    let scope = scope_of(loaded, channel);
    let next = match scope.value(variable)? {
        ExecValue::Int(value) => ExecValue::Int(value.saturating_add(1)),
        other => ExecValue::Real(other.number().unwrap_or(f64::NAN) + 1.0),
    };
    let goes_on = next.number().is_some_and(|value| value <= end);
    assign_value(loaded, channel, variable, next, block.span)?;
    Ok(if goes_on { Action::Jump(start + 1) } else { Action::Next })
}

fn jumps(
    loaded: &mut Loaded,
    channel: &Channel<'_>,
    index: usize,
    section: Range<usize>,
    start: u32,
    count: u16,
) -> Result<Action, Fault> {
    for place in start as usize..start as usize + usize::from(count) {
        let jump = loaded.program.jumps[place];
        let taken = match jump.condition {
            Some(condition) => scope_of(loaded, channel).truth(condition)?,
            None => true,
        };
        if !taken {
            continue;
        }
        if let Some(target) = loaded.targets[place] {
            return Ok(Action::Jump(target));
        }
        match find_target(loaded, &jump, index, section.clone())? {
            Some(target) => {
                loaded.targets[place] = Some(target);
                return Ok(Action::Jump(target));
            }
            None if jump.search == Search::AroundIfAny => {}
            None => {
                let shown = String::from_utf8_lossy(loaded.program.source.slice(jump.span)).into_owned();
                let message = format!("{shown}: the target is not there");
                return Err(at(jump.span, Code::NO_TARGET, message, "check the name and the direction of the jump"));
            }
        }
    }
    Ok(Action::Next)
}

fn find_target(loaded: &Loaded, jump: &Jump, index: usize, section: Range<usize>) -> Result<Option<usize>, Fault> {
    let blocks = &loaded.program.blocks;
    let hits = |at: &usize| match jump.target {
        JumpTarget::Label(name) => blocks[*at].label == Some(name),
        JumpTarget::Number(number) => blocks[*at].number == Some(number),
        JumpTarget::Computed | JumpTarget::Start => false,
    };
    let forward = || (index + 1..section.end).find(hits);
    Ok(match (jump.target, jump.search) {
        (JumpTarget::Computed, _) => {
            let message = "jumps to a computed target are not supported yet";
            return Err(at(jump.span, Code::NOT_SUPPORTED, message, "jump to a label"));
        }
        (JumpTarget::Start, _) | (_, Search::Start) => Some(section.start),
        (_, Search::Forward) => forward(),
        (_, Search::Backward) => (section.start..=index).rev().find(hits),
        (_, Search::Around | Search::AroundIfAny) => forward().or_else(|| (section.start..=index).find(hits)),
    })
}

impl Channel<'_> {
    /// The word that ends the run.
    pub(super) fn push_end(&mut self, number: u32) {
        let value = WordValue::Number(f64::from(number));
        self.push(Kind::After(vec![AuxWord { letter: b'M', extension: None, value }]));
    }
}
