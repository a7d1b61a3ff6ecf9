//! Lines of a saved file with their places, and numbers in them.

use std::borrow::Cow;

use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};

/// Line of a file.
#[derive(Clone, Debug)]
pub(super) struct SavedLine<'a> {
    /// Its text without the line end.
    pub(super) text: Cow<'a, str>,
    place: Place,
}

/// Unit of lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SavedUnit {
    Millimeter,
    Inch,
}

/// Returns the lines of a file that are not empty.
pub(super) fn lines(source: &Source) -> Vec<SavedLine<'_>> {
    let (mut start, mut out) = (0, Vec::new());
    for line in source.bytes().split(|&byte| byte == source.line_end()) {
        let text = String::from_utf8_lossy(line.trim_ascii_end());
        if !text.trim().is_empty() {
            let span = Span::new(start, start + line.trim_ascii_end().len());
            out.push(SavedLine { text, place: Place { file: source.id(), span } });
        }
        start += line.len() + 1;
    }
    out
}

impl SavedLine<'_> {
    /// Returns an error at this line.
    pub(super) fn fault(&self, message: impl Into<String>, help: impl Into<String>) -> Diagnostic {
        Diagnostic::at(Code::BAD_VALUE, self.place, message, help)
    }

    /// Returns a diagnostic at this line.
    pub(super) fn report(&self, code: Code, message: impl Into<String>, help: impl Into<String>) -> Diagnostic {
        Diagnostic::at(code, self.place, message, help)
    }
}

impl SavedUnit {
    /// Returns a length in mm.
    pub(super) fn mm(self, value: f64) -> f64 {
        /// Millimeters of an inch.
        const INCH_MM: f64 = 25.4;
        match self {
            SavedUnit::Millimeter => value,
            // Removes the noise of the product: no control has more decimals.
            SavedUnit::Inch => (value * INCH_MM * 1e9).round() / 1e9,
        }
    }

    /// Returns the unit that the machine file states for saved files.
    pub(super) fn stated(machine: &Machine) -> Option<SavedUnit> {
        machine.control.saved_inch.map(|is_inch| if is_inch { SavedUnit::Inch } else { SavedUnit::Millimeter })
    }

    /// Returns the unit that the machine file states, or an error: a file without it may be in mm or in inches.
    pub(super) fn required(machine: &Machine, line: &SavedLine<'_>) -> Result<SavedUnit, Diagnostic> {
        SavedUnit::stated(machine).ok_or_else(|| {
            line.fault(
                "the file does not state the unit of its lengths",
                "add saved_unit = \"mm\" or saved_unit = \"inch\" to [control] of the machine file, or give --saved-unit to ncfix machine new",
            )
        })
    }
}

/// A finite number.
pub(super) fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && value.abs() < 1e9)
}

/// Letters with the texts of their numbers: `T1 P2 Z+1.25`. `None` if the line has anything else.
pub(super) fn words(text: &str) -> Option<Vec<(u8, &str)>> {
    let (bytes, mut at, mut out) = (text.as_bytes(), 0, Vec::new());
    while let Some(&byte) = bytes.get(at) {
        at += 1;
        if byte.is_ascii_whitespace() {
            continue;
        }
        if !byte.is_ascii_alphabetic() {
            return None;
        }
        let skipped = bytes.get(at..)?.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let start = at + skipped;
        let length =
            bytes.get(start..)?.iter().take_while(|byte| byte.is_ascii_digit() || b"+-.".contains(byte)).count();
        out.push((byte.to_ascii_uppercase(), text.get(start..start + length).filter(|number| !number.is_empty())?));
        at = start + length;
    }
    Some(out)
}
