//! Axis words with the names of the machine file: `X1=10`.

use super::gatherer::Gatherer;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::Word;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;

impl Gatherer<'_> {
    /// The axis for a letter with a number.
    pub(super) fn numbered_axis(&self, letter: u8, extension: u32) -> Option<Axis> {
        let machine = self.scope.machine;
        if machine.axes.iter().flatten().all(|data| data.name.is_none()) {
            return None;
        }
        machine.axis_named(&format!("{}{extension}", char::from(letter)))
    }

    /// The error for a letter with a number that names no axis.
    pub(super) fn unnamed_axis(&self, letter: u8, extension: u32, word: &Word) -> Fault {
        let letter = char::from(letter);
        if !"XYZUVWABC".contains(letter) {
            return self.unsupported(word);
        }
        let message = format!("{letter}{extension} is not an axis of the machine file");
        let help = format!("add name = \"{letter}{extension}\" to the section [axis.…] of this axis");
        fault(Code::NOT_SUPPORTED, word.span, message, help)
    }
}
