//! Lines of a table file with their places, for readers of formats that are one statement or row a line.

use crate::diagnostic::{Code, Diagnostic, Place};
use crate::source::{Source, Span};

/// Findings of one file at most; more say the same.
const MOST_FINDINGS: usize = 50;

/// A line of a file without its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'a> {
    /// What stands in it; bytes that are not UTF-8 make it end there.
    pub(super) text: &'a str,
    start: usize,
}

impl<'a> Line<'a> {
    /// The place of a part of the line.
    pub(super) fn span(&self, part: &str) -> Span {
        let from = part.as_ptr() as usize;
        let offset = from.saturating_sub(self.text.as_ptr() as usize).min(self.text.len());
        let start = self.start + offset;
        Span::new(start, start + part.len().max(1))
    }

    /// The line without what follows a comment sign.
    pub(super) fn before(&self, comment: char) -> &'a str {
        self.text.split(comment).next().unwrap_or_default()
    }
}

/// The lines of a file.
pub(super) fn lines(source: &Source) -> impl Iterator<Item = Line<'_>> {
    let mut start = 0;
    source.bytes().split(|&byte| byte == b'\n').map(move |bytes| {
        let at = start;
        start += bytes.len() + 1;
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(fault) => std::str::from_utf8(&bytes[..fault.valid_up_to()]).unwrap_or_default(),
        };
        Line { text: text.trim_end_matches('\r'), start: at }
    })
}

/// The findings of a reader, with the file that they are in.
pub(super) struct Report<'a> {
    source: &'a Source,
    pub(super) findings: Vec<Diagnostic>,
}

impl<'a> Report<'a> {
    pub(super) fn new(source: &'a Source) -> Report<'a> {
        Report { source, findings: Vec::new() }
    }

    fn add(&mut self, code: Code, span: Span, message: String, help: &str) {
        if self.findings.len() < MOST_FINDINGS {
            let place = Place { file: self.source.id(), span };
            self.findings.push(Diagnostic::at(code, place, message, help));
        }
    }

    /// What makes the file no table.
    pub(super) fn fault(&mut self, line: &Line<'_>, part: &str, message: impl Into<String>, help: &str) {
        self.add(Code::BAD_TABLES, line.span(part), message.into(), help);
    }

    /// What is left out.
    pub(super) fn unused(&mut self, line: &Line<'_>, part: &str, message: impl Into<String>, help: &str) {
        self.add(Code::UNUSED_TABLE, line.span(part), message.into(), help);
    }

    /// A fault of the file as a whole.
    pub(super) fn fault_at(&mut self, span: Span, message: impl Into<String>, help: &str) {
        self.add(Code::BAD_TABLES, span, message.into(), help);
    }

    /// What is left out of the file as a whole.
    pub(super) fn unused_at(&mut self, span: Span, message: impl Into<String>, help: &str) {
        self.add(Code::UNUSED_TABLE, span, message.into(), help);
    }

    /// A finite number.
    pub(super) fn number(&mut self, line: &Line<'_>, part: &str) -> Option<f64> {
        let value = part.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        if value.is_none() {
            self.fault(line, part, format!("'{}' is no number", part.trim()), "write a decimal number");
        }
        value
    }
}
