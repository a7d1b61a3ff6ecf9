//! Calls of programs that the control runs by itself: they are passed through with evaluated values.

use super::text;
use std::fmt::Write as _;

use super::arguments::letter_of;
use super::call::{Call, CallKind, Callee};
use super::level::Interpreter;
use crate::exec::core::fault::{Fault, at};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_machine::snc::{FeedUnit, Kind};

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
            return Err(at(call.span, Code::NOT_SUPPORTED, message, "remove the code from control.macro_codes"));
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
            for (_, value) in &call.arguments {
                let _ = write!(text, " [{value}]");
            }
            return Ok(text);
        }
        for &(number, value) in &call.arguments {
            let Some(letter) = letter_of(number) else {
                let message =
                    format!("argument #{number} cannot be passed on to a program that the control itself executes");
                return Err(at(call.span, Code::NOT_SUPPORTED, message, "pass it with its own letter"));
            };
            text::append(self.channel.language, &mut text, letter, value);
        }
        Ok(text)
    }
}
