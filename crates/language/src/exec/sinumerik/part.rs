//! Repetition of program parts: REPEAT and REPEATB with labels.

use std::ops::Range;

use super::channel::Channel;
use super::jump::place_of;
use super::level::Loaded;
use super::place::Place;
use super::scope::scope_of;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::Repetition;
use ncfix_base::diagnostic::Code;

/// Label that ends the part of `REPEAT label`, before the block of the REPEAT.
const END_LABEL: &str = "ENDLABEL";

/// The first and last block of a repetition.
pub(super) fn blocks_of(
    loaded: &mut Loaded,
    channel: &Channel<'_>,
    place: usize,
    index: usize,
    section: Range<usize>,
) -> Result<(usize, usize), Fault> {
    if let Some(known) = loaded.own.parts[place] {
        return Ok(known);
    }
    let repetition = loaded.program.repetitions[place];
    let found = search(loaded, channel, &repetition, index, section)?;
    let Some(found) = found else {
        let shown = String::from_utf8_lossy(loaded.program.source.slice(repetition.span)).into_owned();
        let message = format!("{shown}: the program part does not exist");
        let help = "REPEAT searches its label above itself, and must not be between its two labels";
        return Err(fault(Code::NO_TARGET, repetition.span, message, help));
    };
    loaded.own.parts[place] = Some(found);
    Ok(found)
}

fn search(
    loaded: &Loaded,
    channel: &Channel<'_>,
    repetition: &Repetition,
    index: usize,
    section: Range<usize>,
) -> Result<Option<(usize, usize)>, Fault> {
    let blocks = &loaded.program.blocks;
    let Some(first) = place_of(loaded, channel, repetition.first)? else { return Ok(None) };
    let hits = |place: Place, at: &usize| place.is_at(&blocks[*at]);
    let above = (section.start..index).rev().find(|at| hits(first, at));
    if repetition.one_block {
        let found = above.or_else(|| (index + 1..section.end).find(|at| hits(first, at)));
        return Ok(found.map(|at| (at, at)));
    }
    let Some(last) = repetition.last else {
        let end = loaded.program.names.find(END_LABEL);
        return Ok(above.map(|start| {
            let labelled = (start..index).find(|&at| end.is_some() && blocks[at].label == end);
            (start, labelled.unwrap_or(index - 1))
        }));
    };
    let Some(last) = place_of(loaded, channel, last)? else { return Ok(None) };
    let pair = |start: usize, end: usize| (start..end).find(|at| hits(last, at)).map(|stop| (start, stop));
    Ok(above.and_then(|start| pair(start, index)).or_else(|| {
        let start = (index + 1..section.end).find(|at| hits(first, at))?;
        pair(start, section.end)
    }))
}

/// Number of repetitions of a part; 1 without P.
pub(super) fn passes(loaded: &Loaded, channel: &Channel<'_>, repetition: &Repetition) -> Result<u32, Fault> {
    let Some(count) = repetition.count else { return Ok(1) };
    let value = scope_of(loaded, channel).number(count)?;
    count_of(value).ok_or_else(|| {
        let span = loaded.program.expr(count).span;
        fault(Code::BAD_WORD_VALUE, span, format!("P{value} is not possible"), COUNT_HELP)
    })
}

/// Maximum number of repetitions, the limit of the control's INT.
const MAX_COUNT: i32 = 2_147_483_647;
/// Help for the permitted number of repetitions.
pub(super) const COUNT_HELP: &str = "P is a whole number from 0 to 2147483647";

/// A number of repetitions.
pub(super) fn count_of(value: f64) -> Option<u32> {
    (value >= 0.0 && value <= f64::from(MAX_COUNT) && value.fract() == 0.0).then_some(value as u32)
}
