//! What the names of a program mean, resolved once when it is loaded.

use super::address::{Named, named};
use crate::dialect::{CodeEntry, Dialect};
use crate::syntax::Program;

/// What a name in word position is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Meaning {
    /// A row of the code table.
    Code(&'static CodeEntry),
    /// An address with a value: `CR=`, `TURN=` …
    Address(Named),
    /// `MSG(…)`
    Message,
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
    "AP",
    "RP",
    "AR",
    "RND",
    "RNDM",
    "CHF",
    "CHR",
    "FRC",
    "FRCM",
    "ANG",
    "DISC",
    "DISR",
    "DISCL",
    "DISRP",
    "FAD",
    "OFFN",
    "TOFFL",
    "TOFF",
    "TOFFR",
    "POS",
    "POSA",
    "POSP",
    "SPOS",
    "SPOSA",
    "FA",
    "FL",
    "FB",
    "FGROUP",
    "FGREF",
    "ACC",
    "VELOLIM",
    "ADIS",
    "ADISPOS",
    "CTOL",
    "OTOL",
    "STOLF",
    "LIMS",
    "RPL",
    "AX",
    "PO",
    "PL",
    "PW",
    "SD",
    "LEAD",
    "TILT",
    "THETA",
    "SETAL",
    "WAITM",
    "WAITE",
    "WAITMC",
    "INIT",
    "START",
    "GEOAX",
    "PRESETON",
    "TCARR",
    "EXECSTRING",
    "CYCLE832",
    "MEAS",
    "MEAW",
    "FXS",
    "WRITE",
    "READ",
    "DELETE",
    "GETT",
    "SETMS",
    "COUPON",
    "COUPOF",
    "TRAILON",
    "TRAILOF",
    "LEADON",
    "LEADOF",
    "DL",
    "ISD",
    "IPOBRKA",
    "BLSYNC",
    "NEWCONF",
    "STRLEN",
    "SET",
    "REP",
    "ORIRESET",
    "RELEASE",
    "GET",
    "GETD",
    "DISABLE",
    "ENABLE",
    "SPI",
    "MIRRORAX",
];

/// Cycles of the control.
const CYCLES: &[&str] = &["CYCLE", "HOLES", "POCKET", "SLOT", "LONGHOLE", "E_", "F_"];

/// The meaning of every name, by [`crate::syntax::NameId::index`].
pub(super) fn resolve(program: &Program, dialect: &'static Dialect) -> Vec<Meaning> {
    program
        .names
        .iter()
        .map(|name| match name {
            "MSG" => Meaning::Message,
            "RET" => Meaning::Return,
            _ => match dialect.codes().word(name) {
                Some(entry) => Meaning::Code(entry),
                None => match named(name) {
                    Some(address) => Meaning::Address(address),
                    None if UNSUPPORTED.contains(&name) => Meaning::Unsupported,
                    None if name.starts_with('$') => Meaning::System,
                    None => Meaning::Free,
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
