//! Findings as plain data: what was found, where, and what to do. Drawing them is the business of `report`.

pub mod character;
mod codes;

pub use codes::{CODES, Code, CodeRow};

use serde::Serialize;

use crate::source::{FileId, Span};

/// How much a finding weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The run goes on; the person should know.
    Warning,
    /// Nothing is written.
    Error,
}

impl Severity {
    /// The word shown to the user and in JSON.
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

/// A place in one of the files of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Place {
    /// The file.
    pub file: FileId,
    /// The bytes in question.
    pub span: Span,
}

/// One finding. No color, no file name, no source text in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Stable code, see [`CODES`].
    pub code: Code,
    /// Where; `None` where a finding has no place in a file.
    pub place: Option<Place>,
    /// What was found, with numbers and units: one sentence, lower case, no full stop.
    pub message: String,
    /// What to do about it: one sentence in the same manner.
    pub help: String,
    /// Where it has to do with variables without a value.
    pub unset: Option<Box<Unset>>,
}

/// Variables without a value that a finding has to do with: others about them would only follow from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unset {
    /// The one that is read.
    pub read: Option<String>,
    /// Those that get none because of this.
    pub left: Vec<String>,
}

impl Diagnostic {
    /// A finding at a place.
    #[must_use]
    pub fn at(code: Code, place: Place, message: impl Into<String>, help: impl Into<String>) -> Self {
        Diagnostic { place: Some(place), ..Diagnostic::nowhere(code, message, help) }
    }

    /// A finding that has no place in a file.
    #[must_use]
    pub fn nowhere(code: Code, message: impl Into<String>, help: impl Into<String>) -> Self {
        let (message, help) = (readable(message.into()), help.into());
        Diagnostic { code, place: None, message, help, unset: None }
    }

    /// Its weight, which follows from the code.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.code.severity()
    }

    /// Whether it forbids output.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity() == Severity::Error
    }
}

/// Numbers with more digits are shown by their power of ten: nobody counts 309 of them.
const MOST_DIGITS: usize = 24;

/// A message with its longest numbers as powers of ten: `1.000e308`.
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
        // The nearest number that there is has 2024 of the smallest steps: 9.99989e-321.
        assert_eq!(shown(format!("P{} µm", 1e-320)), "P1.000e-320 µm");
        assert_eq!(shown("9".repeat(400)), format!("{}…", "9".repeat(24)));
    }
}
