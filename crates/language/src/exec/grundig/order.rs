//! Executes the words of one block in a fixed order.

use super::auxiliary;
use super::channel::Channel;
use super::contour_words;
use super::frames;
use super::gathered::Gathered;
use super::machining;
use super::modes;
use super::motion;
use super::target;
use super::tilt;
use super::tip;
use super::tool;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::CodeTable;
use ncfix_machine::snc::Kind;

/// G codes that determine the use of a block's words, in addition to the cycles; one per block.
const ACTIONS: &[u16] = &[4, 7, 9, 11, 61, 62, 74, 77, 78, 79, 149, 150, 174];

/// Executes a block's words.
pub(super) fn execute(
    channel: &mut Channel<'_>,
    gathered: &mut Gathered,
    comment: Option<Vec<u8>>,
) -> Result<(), Fault> {
    channel.block.has_moved = false;
    channel.block.before.clear();
    channel.block.cycle_steps = 0;
    if gathered.codes.is_empty() && gathered.functions.is_empty() {
        if gathered.peek(b'T', None).is_some() {
            // A tool that is prepared: it is changed in a separate block.
            tool::tool(channel, gathered)?;
        }
        auxiliary::feed_and_speed(&mut channel.modal, &mut channel.block, &mut channel.outlet, gathered)?;
        channel.comment(comment);
        motion::motion_words(channel, gathered)?;
        return gathered.check_all_used();
    }
    check_codes(channel.codes, gathered)?;
    modes::passed_codes(channel.codes, &mut channel.modal, &mut channel.outlet, gathered);
    modes::modal_codes(channel, gathered)?;
    frames::frame_codes(channel, gathered)?;
    tool::tool(channel, gathered)?;
    tip::check(channel, gathered)?;
    let ends_tip = gathered.codes.iter().any(|code| code.number == 40);
    tool::compensation_codes(channel.settings.strict, &mut channel.modal, gathered)?;
    tip::switch(channel, gathered, ends_tip)?;
    check_supported(channel.codes, gathered)?;
    auxiliary::feed_and_speed(&mut channel.modal, &mut channel.block, &mut channel.outlet, gathered)?;
    let may_change_head = !channel.settings.machine.heads.is_empty();
    let functions = gathered.functions.iter().filter(|_| may_change_head);
    let words: Vec<(u32, Span)> = functions.map(|code| (u32::from(code.number), code.span)).collect();
    let behind = auxiliary::functions(
        &channel.settings,
        &mut channel.block,
        &mut channel.spindle,
        &mut channel.outlet,
        gathered,
    )?;
    auxiliary::select_head(channel, &words, gathered)?;
    channel.comment(comment);
    if let Some(span) = gathered.take_code(4) {
        auxiliary::dwell(&mut channel.outlet, gathered, span)?;
    } else if let Some(span) = gathered.take_code(149) {
        frames::table_access(channel, gathered, false, span)?;
    } else if let Some(span) = gathered.take_code(150) {
        frames::table_access(channel, gathered, true, span)?;
    } else if let Some(span) = gathered.take_code(74) {
        modes::reference(channel.codes, &mut channel.modal, &mut channel.outlet, gathered, span)?;
    } else if let Some(span) = gathered.take_code(174) {
        modes::withdraw(channel.codes, &mut channel.modal, &mut channel.outlet, gathered, span)?;
    } else if let Some(span) = gathered.take_code(7) {
        tilt::plane(channel, gathered, span)?;
    } else if let Some(span) = gathered.take_code(78) {
        target::define_point(channel, gathered, span)?;
    } else if let Some(span) = gathered.take_code(9) {
        target::set_pole(&mut channel.modal, gathered, span)?;
    } else if let Some(span) = gathered.take_code(11) {
        contour_words::two_lines(channel, gathered, span)?;
    } else if !machining::cycle_codes(channel, gathered)? {
        for (number, retracts) in [(61, false), (62, true)] {
            if let Some(span) = gathered.take_code(number) {
                contour_words::soft_words(
                    &channel.modal,
                    &mut channel.block,
                    &mut channel.outlet,
                    gathered,
                    retracts,
                    span,
                )?;
            }
        }
        motion::motion_words(channel, gathered)?;
    }
    if !behind.is_empty() {
        channel.outlet.push(Kind::After(behind));
    }
    if let Some(code) = gathered.codes.first() {
        let message = format!("G{} together with another code that uses the words of the block", code.number);
        return Err(fault(Code::NOT_SUPPORTED, code.span, message, "write each in its own block"));
    }
    gathered.check_all_used()
}

/// Codes of five-axis programs that change the meaning of all following positions: tilted plane, tool direction, tool center point control.
const FIVE_AXES: [u16; 3] = [7, 8, 141];

/// `true` if no position after the block has a known meaning.
pub(super) fn ends_meaning(gathered: &Gathered) -> bool {
    gathered.codes.iter().any(|code| FIVE_AXES.contains(&code.number))
}

/// Reports an unsupported code before its words are interpreted by the active motion.
pub(super) fn check_supported(codes: &'static CodeTable, gathered: &Gathered) -> Result<(), Fault> {
    let is_left = |number: u16| !ACTIONS.contains(&number) && super::cycles::find(number).is_none();
    let Some(code) = gathered.codes.iter().find(|code| is_left(code.number)) else { return Ok(()) };
    let known = codes.g(usize::from(code.number)).map_or("unknown code", |entry| entry.meaning);
    let message = format!("G{} ({known}) is not supported", code.number);
    let help = if FIVE_AXES.contains(&code.number) {
        "the meaning of all positions after it depends on it, so the program is read up to here; post-process it for axis positions without a tilted plane"
    } else {
        "remove it and program its effect directly"
    };
    Err(fault(Code::NOT_SUPPORTED, code.span, message, help))
}

/// Reports two codes of one exclusive group in a block.
pub(super) fn check_codes(codes: &'static CodeTable, gathered: &Gathered) -> Result<(), Fault> {
    if gathered.codes.len() < 2 {
        return Ok(());
    }
    let group = |number: u16| codes.g(usize::from(number)).map_or(0, |entry| entry.group);
    for (index, code) in gathered.codes.iter().enumerate() {
        let own = group(code.number);
        let clash = gathered
            .codes
            .iter()
            .take(index)
            .find(|other| other.number == code.number || (own != 0 && group(other.number) == own));
        if let Some(other) = clash {
            let message = format!("G{} and G{} in one block", other.number, code.number);
            return Err(fault(Code::DOUBLE_WORD, code.span, message, "keep one of them"));
        }
    }
    Ok(())
}

/// Emits what is held back.
pub(super) fn finish(channel: &mut Channel<'_>, has_errors: bool) {
    contour_words::end_open(&mut channel.open, &mut channel.outlet);
    contour_words::end_soft(&mut channel.block, &mut channel.outlet);
    channel.outlet.end(has_errors);
}
