//! Calls of programs that the control runs by itself, and blocks of codes of the machine builder: they are passed through with evaluated values.

use super::text;
use std::fmt::Write as _;

use super::arguments::letter_of;
use super::assign::is_assignment;
use super::auxiliary;
use super::call::{Call, CallKind, Callee};
use super::channel::Channel;
use super::codes::group_of;
use super::cycle;
use super::data_origin::{self, DataOrigin};
use super::expression::Scope;
use super::haas_codes;
use super::level::Interpreter;
use crate::exec::core::fault::{Fault, at, fault};
use crate::syntax::words::{Address, Program, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::Span;
use ncfix_dialect::Dialect;
use ncfix_machine::snc::{FeedUnit, Kind};

/// Words that belong to a motion or to the modes of a block, whatever its M code is.
const OF_EVERY_BLOCK: &[u8] = b"XYZABCUVWIJKRFSTN";

/// The code of the machine builder that takes the words of a block, `true` if it moves axes, and `true` if it is the only code of the block.
///
/// The machine file names it in `opaque`. A G code takes all words of its block. An M code takes them if it begins the block and one of them can belong
/// to nothing else; otherwise the axis words of its block are a motion, as always.
fn code_with_words(channel: &Channel<'_>, dialect: &Dialect, words: &[Word]) -> Option<(String, bool, bool)> {
    let control = &channel.settings.machine.control;
    let is_letter =
        |word: &&Word, letters: &[u8]| matches!(word.address, Address::Letter(letter) if letters.contains(&letter));
    // Only codes that ncfix does not know: their names are compared, which the usual blocks must not pay for.
    let is_unknown = |letter: u8, value: f64| {
        if letter == b'M' {
            return auxiliary::is_of_builder(channel, value as u32);
        }
        let tenths = (value * 10.0).round() as u16;
        let is_known = group_of(tenths, channel.language).is_some()
            || dialect.codes().g_tenths(usize::from(tenths)).is_some()
            || haas_codes::code_of(tenths).is_some() && control.iso.is_haas()
            || tenths == 530;
        !is_known
    };
    let named = words.iter().enumerate().find_map(|(place, word)| {
        let (Address::Letter(letter @ (b'G' | b'M')), Value::Number { value, .. }) = (word.address, word.value) else {
            return None;
        };
        if !is_unknown(letter, value) {
            return None;
        }
        let name = format!("{}{value}", char::from(letter));
        Some((place, letter, control.opaque_moves(&name)?, name))
    });
    let (place, letter, moves, name) = named?;
    let codes = words.iter().filter(|word| is_letter(word, b"GM")).count();
    if letter == b'G' {
        return Some((name, moves, codes == 1));
    }
    let takes = place == 0
        && codes == 1
        && !cycle::is_cycle(channel.modal.modes.motion, channel.is_rs274())
        && words.iter().any(|word| !is_letter(&word, OF_EVERY_BLOCK) && !is_letter(&word, b"GM"));
    takes.then_some((name, moves, true))
}

/// Passes on a block whose words a code of the machine builder takes. Returns `true` if it did.
pub(super) fn pass_block(
    program: &Program,
    index: usize,
    channel: &mut Channel<'_>,
    words: &[Word],
    span: Span,
) -> Result<bool, Fault> {
    if !channel.settings.machine.control.has_opaque_codes() || words.iter().any(is_assignment) {
        return Ok(false);
    }
    let Some((name, moves, is_alone)) = code_with_words(channel, program.dialect, words) else { return Ok(false) };
    if !is_alone {
        let message = format!("{name} takes all words of its block, and the block has another code");
        return Err(at(span, Code::MUST_STAND_ALONE, message, &format!("give {name} its own block")));
    }
    let control = &channel.settings.machine.control;
    let is_axis = |word: &Word| matches!(word.address, Address::Letter(b'X'..=b'Z' | b'A'..=b'C' | b'U'..=b'W'));
    if channel.modal.modes.inch && control.output_inch != Some(true) && words.len() > 1 {
        let message = format!("the words of {name} are in inches, and the output is metric");
        return Err(at(span, Code::NOT_SUPPORTED, message, "program it under G21"));
    }
    if channel.standing.setup != channel.standing.shown {
        let message =
            format!("{name} would run without the shifts and rotations in force, which the output does not have");
        let help = "program it while only a settable zero offset is in force";
        return Err(at(span, Code::NOT_SUPPORTED, message, help));
    }
    if !moves && words.iter().any(is_axis) {
        let message = format!("{name} has axis words, and the machine file states that it moves no axis");
        return Err(at(span, Code::NOT_SUPPORTED, message, "set moves = true in its entry [[opaque]]"));
    }
    if moves && channel.modal.contour.compensates() {
        let message = format!("{name}, which the control itself executes, while radius compensation is on");
        let help = "program G40 with a motion in the plane before it";
        return Err(at(span, Code::BAD_COMPENSATION, message, help));
    }
    let mut passed = String::new();
    for word in words {
        match (word.address, word.value) {
            (Address::Letter(letter), Value::Expr(_)) => {
                let scope = Scope { program, index, channel, grid: None };
                if let Some(value) = scope.word(word)? {
                    text::append(channel.language, &mut passed, letter, value);
                }
            }
            (_, Value::Expr(_)) => {
                let message = format!("an expression in this word of {name} cannot be passed on");
                return Err(at(word.span, Code::NOT_SUPPORTED, message, "write its value"));
            }
            _ => {
                let written = program.source.slice(word.span).iter().filter(|byte| !byte.is_ascii_whitespace());
                passed.push(' ');
                passed.extend(written.map(|&byte| char::from(byte.to_ascii_uppercase())));
            }
        }
    }
    if moves && channel.modal.modes.feed_unit != FeedUnit::InverseTime {
        channel.outlet.feed_for_call(channel.modal.modes.feed);
    }
    channel.push(Kind::Verbatim(passed.trim_start().as_bytes().to_vec()));
    if moves {
        let lost = channel.modal.forget(AxisSet::ALL);
        channel.push(Kind::Lost(lost));
    }
    Ok(true)
}

/// True if a call of a measuring macro sets data of the control: with S a zero offset, with T a tool offset; the macros for tool setting always. Source:
/// Renishaw, Inspection Plus and tool-setting software for Fanuc and Haas, O9811 to O9899; O9832 and O9833 switch the probe on and off.
fn may_set_offsets(call: &Call) -> bool {
    let Callee::Number(number) = call.callee else { return false };
    let sets = |letter: u8| call.arguments.iter().any(|&(number, ..)| letter_of(number) == Some(letter));
    match number {
        9851..=9859 => true,
        9811..=9899 if number != 9832 && number != 9833 => sets(b'S') || sets(b'T'),
        _ => false,
    }
}

impl Interpreter<'_> {
    /// Passes a call through if the machine file names the program. Returns `true` if it did.
    pub(super) fn pass_on(&mut self, call: &Call) -> Result<bool, Fault> {
        let names = match &call.callee {
            Callee::Number(number) | Callee::Counted(number) => vec![format!("O{number:04}"), format!("O{number}")],
            Callee::Name(name) | Callee::Sub(name) => vec![name.to_ascii_uppercase()],
            Callee::Own => return Ok(false),
        };
        let control = &self.machine.control;
        let Some(moves) = names.iter().find_map(|name| control.opaque_moves(name)) else { return Ok(false) };
        if self.channel.modal.modes.inch && !call.arguments.is_empty() {
            let message = "the arguments of this call are in inches, and the output is metric";
            return Err(at(call.span, Code::NOT_SUPPORTED, message, "call it under G21"));
        }
        if self.channel.standing.setup != self.channel.standing.shown {
            let message =
                "this program would run without the shifts and rotations in force, which the output does not have";
            let help = "call it while only a settable zero offset is in force";
            return Err(at(call.span, Code::NOT_SUPPORTED, message, help));
        }
        let text = self.text_of(call)?;
        if may_set_offsets(call) {
            let message = format!(
                "{text} sets a zero offset or a tool offset to its measured value; the blocks after it are corrected for the values of the machine file"
            );
            let help = "compare the measured value with the machine file after the first run; if they differ by millimeters, enter it there and correct the program again";
            self.channel.outlet.warnings.push(fault(Code::MAY_SET_OFFSETS, call.span, message, help));
        }
        if self.channel.modal.modes.feed_unit != FeedUnit::InverseTime {
            self.channel.outlet.feed_for_call(self.channel.modal.modes.feed);
        }
        self.channel.push(Kind::Verbatim(text.into_bytes()));
        if moves && self.channel.modal.contour.compensates() {
            let message =
                "a program that the control itself executes moves the machine while radius compensation is on";
            let help = "program G40 with a motion in the plane before it";
            return Err(at(call.span, Code::BAD_COMPENSATION, message, help));
        }
        if moves {
            let lost = self.channel.modal.forget(AxisSet::ALL);
            self.channel.push(Kind::Lost(lost));
        }
        Ok(true)
    }

    /// The call in the notation of the output.
    fn text_of(&self, call: &Call) -> Result<String, Fault> {
        if call.is_of_code {
            let message = "a code that calls a program that the control itself executes cannot be passed on";
            let help = "remove the code from control.macro_codes, and name the code itself in control.opaque, for example opaque = [\"M165\"]";
            return Err(at(call.span, Code::NOT_SUPPORTED, message, help));
        }
        let mut text = match (call.kind, &call.callee) {
            (_, Callee::Sub(name)) => format!("o<{name}> call"),
            (CallKind::Macro, Callee::Number(number)) => format!("G65 P{number}"),
            (CallKind::Macro, Callee::Name(name)) => format!("G65 <{name}>"),
            (_, Callee::Number(number) | Callee::Counted(number)) => format!("M98 P{number}"),
            (_, Callee::Name(name)) => format!("M98 <{name}>"),
            (_, Callee::Own) => "M98".to_owned(),
        };
        if let Some(block) = call.at_block {
            // Writing to a string cannot fail.
            let _ = write!(text, " Q{block}");
        }
        if call.repeats != 1 {
            // Writing to a string cannot fail.
            let _ = write!(text, " L{}", call.repeats);
        }
        if call.kind == CallKind::Sub {
            for (_, value, origin) in &call.arguments {
                let sum = self.sum_of(*origin, call.span)?;
                let _ = write!(text, " [{}]", sum.unwrap_or_else(|| value.to_string()));
            }
            return Ok(text);
        }
        for &(number, value, origin) in &call.arguments {
            let Some(letter) = letter_of(number) else {
                let message =
                    format!("argument #{number} cannot be passed on to a program that the control itself executes");
                return Err(at(call.span, Code::NOT_SUPPORTED, message, "pass it with its own letter"));
            };
            match self.sum_of(origin, call.span)? {
                // Writing to a string cannot fail.
                Some(sum) => _ = write!(text, " {}[{sum}]", char::from(letter)),
                None => text::append(self.channel.language, &mut text, letter, value),
            }
        }
        Ok(text)
    }

    /// The sum of an argument that the control computes from its own data; `None` if it does not depend on them.
    fn sum_of(&self, origin: Option<DataOrigin>, span: Span) -> Result<Option<String>, Fault> {
        match origin.map(|origin| origin.text(1.0)) {
            Some(None) if self.channel.settings.strict => Err(data_origin::not_kept(span)),
            sum => Ok(sum.flatten()),
        }
    }
}
