//! Lines of a table file with their positions, for readers of formats with one statement or row per line.

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};

/// Maximum number of errors of one file, and of warnings; further ones give no new information.
const MOST_FINDINGS: usize = 50;
/// Maximum number of points of a table that are read: more than any control holds, and a limit for a file that is not a table.
pub(super) const MOST_POINTS: usize = 10_000;
/// Maximum number of characters of a file that a message repeats.
const MOST_SHOWN: usize = 40;

/// A line of a file without its line end.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScannedLine<'a> {
    /// Its text, up to the first byte that is not UTF-8.
    pub(super) text: &'a str,
    start: usize,
}

impl<'a> ScannedLine<'a> {
    /// The span of a part of the line.
    pub(super) fn span(&self, part: &str) -> Span {
        let from = part.as_ptr() as usize;
        let offset = from.saturating_sub(self.text.as_ptr() as usize).min(self.text.len());
        let start = self.start + offset;
        Span::new(start, start + part.len().max(1))
    }

    /// The line before a comment sign.
    pub(super) fn before(&self, comment: char) -> &'a str {
        self.text.split(comment).next().unwrap_or_default()
    }
}

/// A part of a file for display in messages.
pub(super) fn shown(part: &str) -> String {
    let part = part.trim();
    match part.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}…", part.get(..end).unwrap_or_default()),
        None => part.to_owned(),
    }
}

/// The cells of a row, separated by blanks, tabs, commas and semicolons.
pub(super) fn cells(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || matches!(c, ',' | ';')).filter(|cell| !cell.is_empty())
}

/// The byte order mark of UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The lines of a file.
pub(super) fn lines(source: &Source) -> impl Iterator<Item = ScannedLine<'_>> {
    let end = source.line_end();
    let bytes = source.bytes();
    let bare = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let mut start = bytes.len() - bare.len();
    bare.split(move |&byte| byte == end).map(move |bytes| {
        let at = start;
        start += bytes.len() + 1;
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(fault) => std::str::from_utf8(&bytes[..fault.valid_up_to()]).unwrap_or_default(),
        };
        ScannedLine { text: text.trim_end_matches('\r'), start: at }
    })
}

/// The diagnostics of a reader, with their file.
pub(super) struct Report<'a> {
    source: &'a Source,
    pub(super) findings: Vec<Diagnostic>,
}

impl<'a> Report<'a> {
    pub(super) fn new(source: &'a Source) -> Report<'a> {
        Report { source, findings: Vec::new() }
    }

    fn add(&mut self, code: Code, span: Span, message: String, help: &str) {
        // Warnings must not displace an error: a file without an error counts as read.
        if self.findings.iter().filter(|finding| finding.code == code).count() < MOST_FINDINGS {
            let place = Place { file: self.source.id(), span };
            self.findings.push(Diagnostic::at(code, place, message, help));
        }
    }

    /// Reports an error that makes the file invalid.
    pub(super) fn fault(&mut self, line: &ScannedLine<'_>, part: &str, message: impl Into<String>, help: &str) {
        self.add(Code::BAD_TABLES, line.span(part), message.into(), help);
    }

    /// Reports ignored content.
    pub(super) fn unused(&mut self, line: &ScannedLine<'_>, part: &str, message: impl Into<String>, help: &str) {
        self.add(Code::UNUSED_TABLE, line.span(part), message.into(), help);
    }

    /// Reports an error of the file as a whole.
    pub(super) fn fault_at(&mut self, span: Span, message: impl Into<String>, help: &str) {
        self.add(Code::BAD_TABLES, span, message.into(), help);
    }

    /// Reports ignored content of the file as a whole.
    pub(super) fn unused_at(&mut self, span: Span, message: impl Into<String>, help: &str) {
        self.add(Code::UNUSED_TABLE, span, message.into(), help);
    }

    /// Reports a file without any relevant content.
    pub(super) fn empty(&mut self, message: &str, help: &str) {
        let span = Span::new(0, self.source.bytes().len().min(1));
        self.fault_at(span, message, help);
    }

    /// `true` if an error makes the file invalid.
    pub(super) fn has_fault(&self) -> bool {
        self.findings.iter().any(Diagnostic::is_error)
    }

    /// `true` if there are so many errors that reading on is useless.
    pub(super) fn is_hopeless(&self) -> bool {
        self.findings.len() >= MOST_FINDINGS
            && self.findings.iter().filter(|one| one.is_error()).count() >= MOST_FINDINGS
    }

    /// Parses a finite number.
    pub(super) fn number(&mut self, line: &ScannedLine<'_>, part: &str) -> Option<f64> {
        let value = part.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        if value.is_none() {
            self.fault(line, part, format!("'{}' is not a number", shown(part)), "write a decimal number");
        }
        value
    }
}
