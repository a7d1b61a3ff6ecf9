//! Refuses programs that do not match the machine file: those of lathes, of controls whose language is not supported, and flat streams.

use crate::disk::stated_machine::{from_head, is_flat};
use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_dialect::{Dialect, Mark};

/// The reason why a program must not be read in a dialect.
pub(crate) fn refusal(source: &Source, dialect: &Dialect, chosen: Option<&Machine>) -> Option<Diagnostic> {
    let bytes = source.bytes();
    if is_flat(bytes) {
        let message = "this is a flat stream that ncfix snc has printed, not a program of a control";
        let help = "give the program that it was printed from: its positions contain zero offset and tool already, so a control must not execute them";
        let at = bytes.len() - from_head(bytes).len();
        return Some(Diagnostic::at(Code::OTHER_CONTROL, line_at(source, at), message, help));
    }
    if let Some(found) = ncfix_dialect::foreign(bytes) {
        let message = format!("this is {}: '{}'", found.name, found.found);
        let help = "this language is not supported, and its words move the tool differently; post-process the program for the control of the machine file";
        return Some(Diagnostic::at(Code::OTHER_CONTROL, line_at(source, found.at), message, help));
    }
    let machine = chosen.map(|chosen| &chosen.machine);
    if machine.is_some_and(|machine| machine.control.iso.is_mill) {
        return None;
    }
    let axes: Vec<u8> =
        machine.map_or_else(Vec::new, |machine| machine.axis_set().iter().map(|axis| axis.letter()).collect());
    let marks = ncfix_dialect::turning(dialect.language, &axes, bytes)?;
    let first = marks.first()?;
    let named: Vec<String> = marks.iter().map(|Mark { what, line, .. }| format!("{what} (line {line})")).collect();
    let message =
        format!("this is a program for a lathe, but the machine file does not describe a lathe: {}", named.join(", "));
    let help = "on a mill its words would move the tool elsewhere; turning is not supported. If it is a program for this mill, set control.program_kind = \"mill\" in the machine file";
    Some(Diagnostic::at(Code::LATHE_PROGRAM, line_at(source, first.at), message, help))
}

/// The line that begins at a position, without its line end.
fn line_at(source: &Source, at: usize) -> Place {
    let rest = source.bytes().get(at..).unwrap_or_default();
    let length = rest.iter().take_while(|byte| !matches!(byte, b'\n' | b'\r')).count();
    Place { file: source.id(), span: Span::new(at, at + length) }
}
