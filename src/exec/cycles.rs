//! The register of the control's cycles: programs of the language itself that are built in.
//!
//! A program of the same name among the user's files goes before.

/// Names, upper case, and texts of the cycles.
const CYCLES: &[(&str, &[u8])] = &[];

/// The text of a built-in cycle.
pub(super) fn source(name: &str) -> Option<&'static [u8]> {
    CYCLES.iter().find(|(known, _)| *known == name).map(|&(_, text)| text)
}
