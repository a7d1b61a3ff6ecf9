//! M codes.

use super::channel::Cycles;
use super::channel::IsoAtHand;
use super::forbidden;
use super::modal::Modal;
use super::modes;
use super::setup;
use super::state;
use super::text;
use crate::exec::core::head::{self, HeadBlock};
use crate::exec::core::motion_sink::MotionSink;
use ncfix_dialect::Language;
use std::fmt::Write as _;

use super::channel::Channel;
use super::codes::Group;
use super::gathered::Gathered;
use super::measure::whole;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::Span;
use ncfix_dialect::CodeEffect;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, Word, WordValue};

/// Letters that M codes of LinuxCNC take: number, letters.
const RS274_WORDS: &[(u32, &[u8])] = &[
    (19, b"RQP$"),
    (50, b"P"),
    (51, b"P$"),
    (52, b"P"),
    (53, b"P"),
    (61, b"Q"),
    (62, b"P"),
    (63, b"P"),
    (64, b"P"),
    (65, b"P"),
    (66, b"PELQ"),
    (67, b"EQ"),
    (68, b"EQ"),
];

/// Largest number of an M code with one meaning on all controls; the machine builder assigns the others.
pub(super) const LAST_STANDARD_M: u32 = 30;

/// The modal group of the M codes of the user.
const USER_GROUP: u8 = 10;

/// The modal group of an M code of LinuxCNC; a block may have one of each group.
fn rs274_group(number: u32) -> Option<u8> {
    Some(match number {
        0 | 1 | 2 | 30 | 60 | 98 | 99 => 4,
        62..=68 => 5,
        6 | 61 => 6,
        3 | 4 | 5 | 19 | 70..=73 => 7,
        7..=9 => 8,
        48..=53 => 9,
        100..=199 => USER_GROUP,
        _ => return None,
    })
}

/// `true` if only the machine builder knows the words of an M code.
pub(super) fn is_of_builder(channel: &Channel<'_>, number: u32) -> bool {
    let is_standard = match channel.is_rs274() {
        true => rs274_group(number).is_some(),
        false => {
            let has_output = matches!(number, 59 | 69) && channel.settings.machine.control.iso.is_haas();
            number <= LAST_STANDARD_M || has_output || refused(number, Span::default()).is_err()
        }
    };
    !is_standard && channel.settings.machine.head_of_word(number).is_none()
}

/// `true` if an M code names one input or output by P or, for an analog one, by E.
fn has_address(gathered: &Gathered, number: u32) -> bool {
    let names = |letter| gathered.raw(letter).is_some();
    match number {
        62..=65 => names(b'P'),
        66 => names(b'P') != names(b'E'),
        _ => names(b'E'),
    }
}

/// The word of an M code.
pub(super) fn word(number: u32) -> Word {
    Word { letter: b'M', extension: None, value: WordValue::Number(f64::from(number)) }
}

/// Rejects M codes that call programs or change the flow, according to the code table; most others belong to the machine builder and are passed
/// through.
fn refused(number: u32, span: Span) -> Result<(), Fault> {
    let codes = ncfix_dialect::find("fanuc").map(ncfix_dialect::Dialect::codes);
    match codes.and_then(|codes| codes.m(number as usize)).filter(|entry| entry.effect == CodeEffect::Refuse) {
        Some(entry) => {
            let message = format!("{} ({}) is not supported", entry.name, entry.meaning);
            Err(fault(Code::NOT_SUPPORTED, span, message, "write the moves that it causes in its place"))
        }
        None => Ok(()),
    }
}

/// Changes the head, if an M word of the block selects another one. The head has moved, so the position is unknown afterwards.
pub(super) fn select_head(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if channel.settings.machine.heads.is_empty() || gathered.m_codes.is_empty() {
        return Ok(());
    }
    // G28 and G30 move even without axis words.
    let is_reference = matches!(gathered.code(Group::Action), Some(280 | 300));
    let block = HeadBlock {
        setup: &channel.standing.setup,
        head: channel.modal.tool.head,
        compensates: channel.modal.contour.compensates(),
        moves: !gathered.axes.is_empty() || gathered.has_any(b"IJKR@^") || is_reference,
    };
    let words = gathered.m_codes.iter().copied();
    let Some(head) = head::selected(channel.settings.machine, words, block)? else { return Ok(()) };
    channel.modal.tool.head = head;
    channel.outlet.kinematics = None;
    let lost = channel.modal.forget(AxisSet::ALL);
    channel.outlet.push(Kind::Lost(lost));
    setup::refresh_setup(channel);
    Ok(())
}

/// Executes the M codes of a block that act before the motion, and keeps the others for later.
pub(super) fn m_codes(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if gathered.m_codes.is_empty() {
        return Ok(());
    }
    if !channel.is_rs274() {
        for &(number, span) in &gathered.m_codes {
            refused(number, span)?;
            fanuc_m(channel, number, span)?;
            // M59 and M69 of a Haas set and clear the output of P (mill operator's manual).
            let has_output = matches!(number, 59 | 69) && channel.settings.machine.control.iso.is_haas();
            if has_output && let Some(value) = gathered.raw(b'P') {
                channel.block.before.push(Word { letter: b'P', extension: None, value: WordValue::Number(value) });
            }
        }
        return Ok(());
    }
    let mut groups = 0_u16;
    for &(number, span) in &gathered.m_codes {
        let is_of_head = channel.settings.machine.head_of_word(number).is_some();
        let is_known = || is_of_head || channel.settings.machine.control.opaque_moves(&format!("M{number}")).is_some();
        let Some(group) = rs274_group(number).or_else(|| is_known().then_some(USER_GROUP)) else {
            let help = format!(
                "check the number; if the control executes it, name it in the machine file: control.opaque = [\"M{number}\"]"
            );
            return Err(bad_value(span, format!("M{number} is unknown"), &help));
        };
        // M7 and M8 are compatible.
        let is_double = groups & 1 << group != 0 && group != 8;
        groups |= 1 << group;
        if is_double {
            let message = "two M codes of one group in one block";
            return Err(fault(Code::DOUBLE_WORD, span, message, "remove one of them"));
        }
    }
    for group in [5, 6, 7, 8, 9, USER_GROUP, 4] {
        let is_of = |(number, _): &&(u32, Span)| rs274_group(*number).unwrap_or(USER_GROUP) == group;
        for &(number, span) in gathered.m_codes.iter().filter(is_of) {
            rs274_m(channel, gathered, number, span)?;
        }
    }
    Ok(())
}

fn fanuc_m(channel: &mut Channel<'_>, number: u32, span: Span) -> Result<(), Fault> {
    match number {
        // The flow handles calls and returns.
        98 | 99 => {}
        97 => {
            let message = "M97 ends the interrupt of a macro, which is not supported";
            return Err(fault(
                Code::NOT_SUPPORTED,
                span,
                message,
                "leave out M96 and M97; on a Haas M97 P100 calls N100",
            ));
        }
        2 | 30 => {
            channel.block.ends_program = true;
            channel.block.after.push(word(number));
        }
        0 | 1 | 5 | 9 => {
            note_spindle(&mut channel.modal, &mut channel.cycles, number);
            channel.block.after.push(word(number));
        }
        6 => {
            if channel.modal.contour.compensates() {
                let message = "a tool change (M6) while radius compensation is on";
                let help = "program G40 with a motion in the plane before it";
                return Err(fault(Code::BAD_COMPENSATION, span, message, help));
            }
            channel.block.before.push(word(number));
            change_tool(channel.language, channel.settings.machine, &mut channel.modal);
        }
        // No axis may move between it and the cycle, before which it is written with its speed.
        29 if !channel.settings.strict || channel.settings.keeps_tapping => {
            channel.cycles.is_rigid = true;
            channel.block.before.retain(|word| word.letter != b'S');
        }
        _ => {
            note_spindle(&mut channel.modal, &mut channel.cycles, number);
            channel.block.before.push(word(number));
        }
    }
    Ok(())
}

/// Makes the axes unknown that M functions move according to the machine file.
pub(super) fn lose_by_functions(modal: &mut Modal, outlet: &mut MotionSink<'_>, gathered: &Gathered) {
    if gathered.m_codes.iter().any(|&(number, _)| outlet.function_moves(f64::from(number))) {
        let lost = modal.forget(AxisSet::ALL);
        outlet.push(Kind::Lost(lost));
    }
}

/// Puts the selected tool into the spindle; a tool change may have moved the axes.
fn change_tool(language: Language, machine: &Machine, modal: &mut Modal) {
    modal.tool.change();
    if machine.control.tool_change_moves() {
        modal.position.forget_by_change();
    }
    if language == Language::Rs274 {
        modal.spindle = 5;
    }
}

/// LinuxCNC reads the machine position after M6 and M61. After G40 the tool is beside the contour until a motion has left it, and axes that this
/// motion does not name then stay there.
fn look_where_axes_are(modal: &mut Modal, outlet: &mut MotionSink<'_>, gathered: &Gathered) {
    if modal.contour.compensates() || gathered.has_any(b"XYZABC") {
        return;
    }
    if let Some(place) = outlet.settle() {
        modal.position.command = place;
    }
}

fn note_spindle(modal: &mut Modal, cycles: &mut Cycles, number: u32) {
    match number {
        3 => modal.spindle = 3,
        4 => modal.spindle = 4,
        5 | 19 => modal.spindle = 5,
        7 => modal.coolant[0] = true,
        8 => modal.coolant[1] = true,
        9 => modal.coolant = [false; 2],
        29 => cycles.is_rigid = true,
        _ => {}
    }
}

/// Records M48 to M53, which a restored state includes.
fn note_override(modal: &mut Modal, gathered: &Gathered, number: u32) {
    let [feed, speed, adaptive, stop] = &mut modal.overrides;
    let is_on = gathered.raw(b'P').is_none_or(|value| value != 0.0);
    match number {
        48 | 49 => (*feed, *speed) = (number == 48, number == 48),
        50 => *feed = is_on,
        51 => *speed = is_on,
        52 => *adaptive = is_on,
        53 => *stop = is_on,
        _ => {}
    }
}

fn rs274_m(channel: &mut Channel<'_>, gathered: &Gathered, number: u32, span: Span) -> Result<(), Fault> {
    match number {
        98 | 99 => {}
        2 | 30 => {
            modes::leave_exact_stops(channel, false);
            channel.block.ends_program = true;
            channel.block.after.push(word(number));
        }
        0 | 1 | 60 => channel.block.after.push(word(number)),
        6 => {
            forbidden::no_compensation(channel.language, &channel.modal, span, "M6")?;
            if channel.modal.tool.selected.is_none() {
                let message = "M6 without a tool selected with T";
                return Err(bad_value(span, message, "program T before it or in its block"));
            }
            channel.block.before.push(word(number));
            look_where_axes_are(&mut channel.modal, &mut channel.outlet, gathered);
            change_tool(channel.language, channel.settings.machine, &mut channel.modal);
        }
        61 => {
            let tool = gathered.raw(b'Q').map(|value| whole(value, gathered.span_of(b'Q'), "Q")).transpose()?;
            let Some(tool) = tool else {
                return Err(bad_value(span, "M61 needs Q with the tool", "write for example M61 Q3"));
            };
            channel.modal.tool.active = Some(tool);
            channel.modal.tool.selected = Some(tool);
            look_where_axes_are(&mut channel.modal, &mut channel.outlet, gathered);
            m_with_words(&mut channel.block, &mut channel.outlet, gathered, number, b"Q");
        }
        70 => state::save_state(&channel.modal, &mut channel.saved, false),
        73 => state::save_state(&channel.modal, &mut channel.saved, true),
        71 => state::drop_state(&mut channel.saved),
        72 => state::restore_state(channel, span)?,
        100..=199 if channel.settings.machine.head_of_word(number).is_none() => {
            let message = format!("M{number} runs a user-defined program, whose effect is not known");
            let help = "check that it moves no axis and changes no offset";
            channel.outlet.warnings.push(fault(Code::LEFT_OUT, span, message, help));
            m_with_words(&mut channel.block, &mut channel.outlet, gathered, number, b"PQ");
        }
        48..=53 | 62..=68 if channel.modal.contour.compensates() => {
            let message = format!("M{number} while radius compensation is on");
            return Err(fault(Code::BAD_COMPENSATION, span, message, "move it before G41, G42 or after G40"));
        }
        62..=68 if !has_address(gathered, number) => {
            let message = format!("M{number} does not state its input or output");
            return Err(bad_value(span, message, "write P with its number (M62 to M66), or E (M66 to M68)"));
        }
        _ => match RS274_WORDS.iter().find(|(known, _)| *known == number) {
            Some((_, letters)) => {
                note_spindle(&mut channel.modal, &mut channel.cycles, number);
                note_override(&mut channel.modal, gathered, number);
                m_with_words(&mut channel.block, &mut channel.outlet, gathered, number, letters);
            }
            None => {
                note_spindle(&mut channel.modal, &mut channel.cycles, number);
                note_override(&mut channel.modal, gathered, number);
                let spindle = gathered.raw(b'$').filter(|_| matches!(number, 3..=5));
                match spindle {
                    Some(_) => m_with_words(&mut channel.block, &mut channel.outlet, gathered, number, b"$"),
                    None => channel.block.before.push(word(number)),
                }
            }
        },
    }
    Ok(())
}

/// An M code with its own words.
fn m_with_words(block: &mut IsoAtHand, outlet: &mut MotionSink<'_>, gathered: &Gathered, number: u32, letters: &[u8]) {
    if !gathered.has_any(letters) {
        block.before.push(word(number));
        return;
    }
    let mut text = format!("M{number}");
    for &letter in letters {
        if let Some(value) = gathered.raw(letter) {
            // Writing to a string cannot fail.
            let _ = write!(text, " {}{value}", char::from(letter));
        }
    }
    outlet.push(Kind::Verbatim(text.into_bytes()));
}

/// Appends a word as written.
pub(super) fn append_plain(language: Language, text: &mut String, letter: u8, value: f64, is_unpointed: bool) {
    if is_unpointed {
        let _ = write!(text, " {}{value}", char::from(letter));
    } else {
        text::append(language, text, letter, value);
    }
}
