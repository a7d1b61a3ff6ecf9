//! Jumps: finds the blocks of labels, block numbers and computed targets.

use std::ops::Range;

use super::cells::Cells;
use super::channel::Channel;
use super::level::{Action, Loaded};
use super::place::Place;
use super::scope::scope_of;
use super::value::Value;
use crate::exec::core::fault::{Fault, at};
use crate::syntax::PagedStore;
use crate::syntax::sinumerik::{Block, Jump, JumpTarget, NameId, Search};
use ncfix_base::diagnostic::Code;

/// The current meaning of a target; `None` if the program has no such label.
pub(super) fn place_of(loaded: &Loaded, channel: &Channel<'_>, target: JumpTarget) -> Result<Option<Place>, Fault> {
    match target {
        JumpTarget::Label(name) => match variable(loaded, channel, name) {
            Some(Value::Text(text)) => Ok(Place::of_text(&loaded.program, text)),
            _ => Ok(Some(Place::Label(name))),
        },
        JumpTarget::Number(number) => Ok(Some(Place::Number(number))),
        JumpTarget::Computed(id) => match scope_of(loaded, channel).value(id)? {
            Value::Text(text) => Ok(Place::of_text(&loaded.program, &text)),
            _ => {
                let span = loaded.program.expr(id).span;
                let message = "a jump target is a label or block number as a string";
                Err(at(span, Code::TYPE_MISMATCH, message, "write for example GOTOF \"LAB\"<<R1"))
            }
        },
        JumpTarget::Start => Ok(None),
    }
}

/// The variable in the place of a label.
pub(super) fn variable<'c>(loaded: &Loaded, channel: &'c Channel<'_>, name: NameId) -> Option<&'c Value> {
    channel.variables.cells(name, loaded.program.names.text(name)).and_then(Cells::first)
}

/// Executes the jumps of a block: the first with a true condition is taken.
pub(super) fn jumps(
    loaded: &mut Loaded,
    channel: &Channel<'_>,
    index: usize,
    section: Range<usize>,
    start: u32,
    count: u16,
) -> Result<Action, Fault> {
    for number in start as usize..start as usize + usize::from(count) {
        let jump = loaded.program.jumps[number];
        let taken = match jump.condition {
            Some(condition) => scope_of(loaded, channel).truth(condition)?,
            None => true,
        };
        if !taken {
            continue;
        }
        if let Some(target) = loaded.own.targets[number] {
            return Ok(Action::Goto(target));
        }
        match find(loaded, channel, number, &jump, index, section.clone())? {
            Some(target) => return Ok(Action::Goto(target)),
            None if jump.search == Search::AroundIfAny => {}
            None => {
                let shown = String::from_utf8_lossy(loaded.program.source.slice(jump.span)).into_owned();
                let message = format!("{shown}: the target does not exist");
                return Err(at(jump.span, Code::NO_TARGET, message, "check the name and the direction of the jump"));
            }
        }
    }
    Ok(Action::Next)
}

/// The block of a jump, searched once for each target.
fn find(
    loaded: &mut Loaded,
    channel: &Channel<'_>,
    number: usize,
    jump: &Jump,
    index: usize,
    section: Range<usize>,
) -> Result<Option<usize>, Fault> {
    if jump.search == Search::Start {
        return Ok(Some(section.start));
    }
    let Some(place) = place_of(loaded, channel, jump.target)? else { return Ok(None) };
    let is_fixed = match jump.target {
        JumpTarget::Label(name) => variable(loaded, channel, name).is_none(),
        JumpTarget::Number(_) => true,
        JumpTarget::Computed(_) | JumpTarget::Start => false,
    };
    if let Some(&known) = loaded.own.computed.get(&(number, place)).filter(|_| !is_fixed) {
        return Ok(Some(known));
    }
    let found = search(&loaded.program.blocks, place, jump.search, index, section);
    if let Some(found) = found {
        if is_fixed {
            loaded.own.targets[number] = Some(found);
        } else {
            loaded.own.computed.insert((number, place), found);
        }
    }
    Ok(found)
}

/// Searches a marked block from the block `index` on.
pub(super) fn search(
    blocks: &PagedStore<Block>,
    place: Place,
    search: Search,
    index: usize,
    section: Range<usize>,
) -> Option<usize> {
    let hits = |at: &usize| place.is_at(&blocks[*at]);
    let forward = || (index + 1..section.end).find(hits);
    match search {
        Search::Start => Some(section.start),
        Search::Forward => forward(),
        Search::Backward => (section.start..=index).rev().find(hits),
        Search::Around | Search::AroundIfAny => forward().or_else(|| (section.start..=index).find(hits)),
    }
}
