//! Axes that the machine file names as passed on: the control moves them, and ncfix corrects no position of them.
//!
//! Such an axis moves at rapid in a block of its own. With others it would share a feed, and a move that is divided would move it in its first piece.

use super::channel::Channel;
use super::codes::Group;
use super::gathered::Gathered;
use super::measure;
use super::text;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;
use ncfix_machine::machine::Control;
use ncfix_machine::snc::Kind;

/// Words of an axis in a block that has another meaning than a rapid move.
const HELP: &str = "move it with G0 under G90 in a block of its own, with no other axis";

/// The axes of a block that are passed on.
pub(super) fn passed_on(control: &Control, gathered: &Gathered) -> AxisSet {
    if control.passed_on_axes.is_empty() || gathered.code(Group::Action).is_some() {
        return AxisSet::EMPTY;
    }
    gathered.axes.iter().filter(|axis| control.passes_axis(&axis.to_string())).collect()
}

/// Passes on a rapid move of such axes; `false` for a block without them. `code` is the motion of the block.
pub(super) fn pass_on(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<bool, Fault> {
    let control = &channel.settings.machine.control;
    let passed = passed_on(control, gathered);
    let Some(first) = passed.iter().next() else { return Ok(false) };
    let span = gathered.span_of(first.letter());
    let refused = |message: String| Err(fault(Code::NOT_SUPPORTED, span, message, HELP));
    if let Some(other) = gathered.axes.difference(passed).iter().next() {
        return refused(format!("{first} is passed on, and this block moves {other} too"));
    }
    if code != 0 || gathered.has_any(b"@^IJKR") {
        return refused(format!("{first} is passed on, and this block is not a rapid move"));
    }
    if channel.modal.modes.incremental {
        return refused(format!("{first} is passed on, and its word is incremental (G91)"));
    }
    let mut line = "G0".to_owned();
    for axis in passed.iter() {
        if axis.is_rotary() {
            let (machine, language) = (channel.settings.machine, channel.language);
            let angle_rad = measure::angle(machine, language, &mut channel.warned, gathered, axis.letter())?;
            text::append(language, &mut line, axis.letter(), angle_rad.unwrap_or(0.0).to_degrees());
        } else {
            let mm = measure::length(channel, gathered, axis.letter())?.unwrap_or(0.0);
            text::append_length(channel.settings.machine, channel.language, &mut line, axis.letter(), mm);
        }
    }
    channel.push(Kind::Verbatim(line.into_bytes()));
    Ok(true)
}
