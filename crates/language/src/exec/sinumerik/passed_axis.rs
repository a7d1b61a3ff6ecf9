//! Axes that the machine file names as passed on: the control moves them, and ncfix corrects no position of them.
//!
//! Such an axis moves at rapid in a block of its own. With others it would share a feed, and a move that is divided would move it in its first piece.

use super::channel::Channel;
use super::gathered::Gathered;
use super::gatherer::Gatherer;
use super::modal::MotionKind;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::Word;
use ncfix_base::diagnostic::Code;
use ncfix_dialect::ValueUnit;
use ncfix_machine::snc::Kind;

impl Gatherer<'_> {
    /// Takes the word of such an axis; `false` for another name.
    pub(super) fn passes_axis(&self, name: &str, word: &Word, out: &mut Gathered) -> Result<bool, Fault> {
        if !self.scope.machine.control.passes_axis(name) {
            return Ok(false);
        }
        let is_rotary = matches!(name.as_bytes().first(), Some(b'A' | b'B' | b'C'));
        out.passed_axes.push(self.text(word, if is_rotary { ValueUnit::None } else { ValueUnit::Length })?);
        out.passed_span = word.span;
        Ok(true)
    }
}

/// Passes on the rapid move of such axes.
pub(super) fn pass_on(channel: &mut Channel<'_>, gathered: &mut Gathered, moves_others: bool) -> Result<(), Fault> {
    let words = std::mem::take(&mut gathered.passed_axes);
    if words.is_empty() {
        return Ok(());
    }
    let modes = &channel.modal.modes;
    let reason = if moves_others {
        "this block moves other axes too"
    } else if modes.motion != MotionKind::Rapid {
        "this block is not a rapid move"
    } else if modes.incremental {
        "its word is incremental (G91)"
    } else if channel.system.modal_call {
        "a cycle under MCALL would run after this block"
    } else {
        let mut line = b"G0".to_vec();
        for word in words {
            line.push(b' ');
            line.extend(word);
        }
        channel.push(Kind::Verbatim(line));
        return Ok(());
    };
    let shown = words.last().map(|word| String::from_utf8_lossy(word).into_owned()).unwrap_or_default();
    let message = format!("{shown} is passed on, and {reason}");
    let help = "move it with G0 under G90 in a block of its own, with no other axis";
    Err(fault(Code::NOT_SUPPORTED, gathered.passed_span, message, help))
}
