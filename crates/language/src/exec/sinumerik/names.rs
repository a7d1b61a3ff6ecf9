//! Meanings of the names of a program, resolved once at loading.

use super::address::Named;
use crate::syntax::sinumerik::Program;
use ncfix_dialect::{CodeEntry, Dialect, Treatment, WordEntry, WordPlace, words};
use ncfix_machine::machine::Control;

/// Meaning of a name as a word.
#[derive(Clone, Copy, Debug)]
pub(super) enum Meaning {
    /// A row of the code table.
    Code(&'static CodeEntry),
    /// An address with a value: `CR=`, `TURN=` …
    Address(Named),
    /// A word that is passed through.
    Kept(&'static WordEntry),
    /// A program that the control runs by itself, according to the machine file.
    Opaque {
        /// `true` if it moves axes.
        moves: bool,
    },
    /// `MSG(…)`
    Message,
    /// `SETAL(…)` in a built-in cycle.
    Alarm,
    /// `RET`
    Return,
    /// Known, but not executed.
    Unsupported,
    /// A system variable.
    System,
    /// A variable or a subprogram.
    Free,
}

/// Cycles of the control.
const CYCLES: &[&str] = &["CYCLE", "HOLES", "POCKET", "SLOT", "LONGHOLE", "E_", "F_"];

/// The meaning of every name, by [`crate::syntax::sinumerik::NameId::index`].
pub(super) fn resolve(program: &Program, dialect: &'static Dialect, control: &Control) -> Vec<Meaning> {
    program
        .names
        .iter()
        .map(|name| {
            let row = words().find(name, WordPlace::Block);
            match row.map(|row| row.treatment) {
                Some(Treatment::Message) => return Meaning::Message,
                Some(Treatment::Return) => return Meaning::Return,
                _ => {}
            }
            if let Some(entry) = dialect.codes().word(name) {
                return Meaning::Code(entry);
            }
            if let Some(address) =
                row.filter(|row| row.treatment == Treatment::Read).and_then(|row| Named::of(row.name))
            {
                return Meaning::Address(address);
            }
            // Passed on as a program, such a word would move other axes than those that are corrected.
            if let Some(row) = row.filter(|row| row.treatment == Treatment::Refuse) {
                return Meaning::Kept(row);
            }
            if let Some(moves) = opaque_moves(control, name) {
                return Meaning::Opaque { moves };
            }
            match row {
                Some(row) => match row.treatment {
                    Treatment::Letter => Meaning::Free,
                    Treatment::Axis | Treatment::Later => Meaning::Unsupported,
                    _ => Meaning::Kept(row),
                },
                None if name.starts_with('$') => Meaning::System,
                None => Meaning::Free,
            }
        })
        .collect()
}

/// Returns whether a program that only the control executes moves axes; `None` if its calls are not passed on.
///
/// CYCLE800 never is such a program: passed on, it would turn the coordinates of all moves that follow, and those would be corrected for other positions.
pub(super) fn opaque_moves(control: &Control, name: &str) -> Option<bool> {
    control.opaque_moves(name).filter(|_| name != "CYCLE800")
}

/// `true` if a name is an address letter that may have an index in brackets: `S[2]=500`.
pub(super) fn is_indexed_letter(name: &str) -> bool {
    words().find(name, WordPlace::Block).is_some_and(|row| row.treatment == Treatment::Letter)
}

/// `true` if a name belongs to a cycle of the control.
pub(super) fn is_cycle(name: &str) -> bool {
    CYCLES.iter().any(|prefix| {
        name.strip_prefix(prefix).is_some_and(|rest| prefix.ends_with('_') || rest.bytes().all(|b| b.is_ascii_digit()))
    })
}
