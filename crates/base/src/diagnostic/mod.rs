//! Diagnostics as plain data: what was found, where, and what to do. `report` draws them.

pub mod character;
mod codes;

pub use codes::{CODES, Code, CodeRow};

use serde::Serialize;

use crate::source::{FileId, Span};

/// Severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The run continues; the user should know.
    Warning,
    /// Nothing is written.
    Error,
}

impl Severity {
    /// Returns the word shown to the user and in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

impl std::fmt::Display for Severity {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.pad(self.word())
    }
}

/// Place in one of the files of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Place {
    /// File.
    pub file: FileId,
    /// Bytes concerned.
    pub span: Span,
}

/// Diagnostic, without color, file name or source text.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Stable code, see [`CODES`].
    pub code: Code,
    /// Place; `None` if it does not belong to a place in a file.
    pub place: Option<Place>,
    /// Message with numbers and units: one sentence, lower case, no full stop.
    pub message: String,
    /// Advice: one sentence in the same style.
    pub help: String,
    /// Variables without a value that are involved, if any.
    pub unset: Option<Box<Unset>>,
}

/// Variables without a value that a diagnostic involves; further diagnostics about them would only be consequences.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unset {
    /// Variable that is read.
    pub read: Option<String>,
    /// Variables that therefore get no value.
    pub left: Vec<String>,
}

impl Diagnostic {
    /// Creates a diagnostic at a place.
    #[must_use]
    pub fn at(code: Code, place: Place, message: impl Into<String>, help: impl Into<String>) -> Self {
        Diagnostic { place: Some(place), ..Diagnostic::nowhere(code, message, help) }
    }

    /// Creates a diagnostic without a place in a file.
    #[must_use]
    pub fn nowhere(code: Code, message: impl Into<String>, help: impl Into<String>) -> Self {
        let (message, help) = (readable(message.into()), help.into());
        Diagnostic { code, place: None, message, help, unset: None }
    }

    /// Returns its severity, which follows from the code.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.code.severity()
    }

    /// True if it prevents output.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity() == Severity::Error
    }
}

/// Numbers with more digits are shown by their power of ten: 309 digits are not readable.
const MOST_DIGITS: usize = 24;

/// Returns a message with its longest numbers as powers of ten: `1.000e308`.
fn readable(message: String) -> String {
    let is_digit = |byte: u8| byte.is_ascii_digit() || byte == b'.';
    let is_long = message.as_bytes().windows(MOST_DIGITS + 1).any(|bytes| bytes.iter().all(|&byte| is_digit(byte)));
    if !is_long {
        return message;
    }
    let mut shown = String::new();
    let mut rest = message.as_str();
    while !rest.is_empty() {
        let end = rest.bytes().position(|byte| !is_digit(byte)).unwrap_or(rest.len());
        let (digits, behind) = rest.split_at(end);
        match digits.parse::<f64>() {
            Ok(value) if digits.len() > MOST_DIGITS && value.is_finite() => shown.push_str(&format!("{value:.3e}")),
            _ if digits.len() > MOST_DIGITS => shown.push_str(&format!("{}…", &digits[..MOST_DIGITS])),
            _ => shown.push_str(digits),
        }
        let next = behind.bytes().position(is_digit).unwrap_or(behind.len());
        shown.push_str(&behind[..next]);
        rest = &behind[next..];
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_in_messages_are_powers_of_ten() {
        let shown = |message: String| Diagnostic::nowhere(Code::BAD_WORD_VALUE, message, "").message;
        assert_eq!(shown("X would move to -12.5, and 3 more…".into()), "X would move to -12.5, and 3 more…");
        assert_eq!(
            shown(format!("start radius {:.4} mm, end 5.25 mm", 1e308)),
            "start radius 1.000e308 mm, end 5.25 mm"
        );
        // The nearest representable number is 2024 of the smallest steps: 9.99989e-321.
        assert_eq!(shown(format!("P{} µm", 1e-320)), "P1.000e-320 µm");
        assert_eq!(shown("9".repeat(400)), format!("{}…", "9".repeat(24)));
    }
}
