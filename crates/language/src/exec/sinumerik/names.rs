//! What the names of a program mean, resolved once when it is loaded.

use super::address::{Named, named};
use super::kept::{Row, row};
use crate::syntax::sinumerik::Program;
use ncfix_dialect::{CodeEntry, Dialect};
use ncfix_machine::machine::Control;

/// What a name in word position is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Meaning {
    /// A row of the code table.
    Code(&'static CodeEntry),
    /// An address with a value: `CR=`, `TURN=` …
    Address(Named),
    /// A word that is passed on.
    Kept(&'static Row),
    /// A program that the machine file says the control runs by itself.
    Opaque {
        /// Whether it moves axes.
        moves: bool,
    },
    /// `MSG(…)`
    Message,
    /// `SETAL(…)` in a built-in cycle.
    Alarm,
    /// `RET`
    Return,
    /// Known, not executed yet.
    Unsupported,
    /// A system variable.
    System,
    /// A variable or a subprogram.
    Free,
}

/// Addresses and words that change positions or feeds and are not executed yet.
const UNSUPPORTED: &[&str] = &[
    "TOFFL", "TOFF", "POS", "POSA", "POSP", "AX", "THETA", "TCARR", "DL", "ISD", "STRLEN", "SET", "REP", "ORIRESET",
    "SPI", "MIRRORAX",
];

/// Cycles of the control.
const CYCLES: &[&str] = &["CYCLE", "HOLES", "POCKET", "SLOT", "LONGHOLE", "E_", "F_"];

/// The meaning of every name, by [`crate::syntax::sinumerik::NameId::index`].
pub(super) fn resolve(program: &Program, dialect: &'static Dialect, control: &Control) -> Vec<Meaning> {
    program
        .names
        .iter()
        .map(|name| match name {
            "MSG" => Meaning::Message,
            "RET" => Meaning::Return,
            _ => match dialect.codes().word(name) {
                Some(entry) => Meaning::Code(entry),
                None => match (named(name), control.opaque_moves(name), row(name)) {
                    (Some(address), ..) => Meaning::Address(address),
                    (_, Some(moves), _) => Meaning::Opaque { moves },
                    (_, _, Some(row)) => Meaning::Kept(row),
                    _ if UNSUPPORTED.contains(&name) => Meaning::Unsupported,
                    _ if name.starts_with('$') => Meaning::System,
                    _ => Meaning::Free,
                },
            },
        })
        .collect()
}

/// Whether a name belongs to a cycle of the control.
pub(super) fn is_cycle(name: &str) -> bool {
    CYCLES.iter().any(|prefix| {
        name.strip_prefix(prefix).is_some_and(|rest| prefix.ends_with('_') || rest.bytes().all(|b| b.is_ascii_digit()))
    })
}
