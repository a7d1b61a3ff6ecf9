//! Bytes of a file and places in them.
//!
//! Part programs are bytes, not text: comments are in UTF-8, Latin-1 or GBK, and paper-tape leaders contain NULs. Nothing here decodes them. A [`Span`] is a
//! range of byte offsets, and text is recovered by slicing.

use std::ops::Range;
use std::sync::Arc;

/// Identifies one of the files of a run (the program, its subprograms, the machine file) in diagnostics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u16);

/// Range of byte offsets in one file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// Offset of the first byte.
    pub start: u32,
    /// Offset after the last byte.
    pub end: u32,
}

impl Span {
    /// Creates the span from `start` to before `end`.
    #[must_use]
    pub fn new(start: usize, end: usize) -> Self {
        Span { start: clamp(start), end: clamp(end) }
    }

    /// Returns the span as an index range.
    #[must_use]
    pub fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }

    /// Returns the smallest span that contains both.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        Span { start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// Converts an offset to 32 bits; [`Source::new`] refuses larger files, so nothing is lost.
fn clamp(offset: usize) -> u32 {
    u32::try_from(offset).unwrap_or(u32::MAX)
}

/// Maximum file size in bytes: offsets are stored in 32 bits.
pub const MAX_BYTES: usize = u32::MAX as usize - 1;

/// File: its name as shown to the user and its bytes, cheap to clone.
#[derive(Clone, Debug)]
pub struct Source {
    id: FileId,
    name: Arc<str>,
    bytes: Arc<Vec<u8>>,
    line_end: u8,
    /// Lines expanded by macros: for spans, these bytes come after those of the file.
    tail: Arc<Tail>,
}

/// Expanded lines.
#[derive(Debug, Default)]
struct Tail {
    bytes: Vec<u8>,
    /// Offset of each expanded line in the tail, and the original line.
    lines: Vec<(u32, Span)>,
}

/// Gap between file and tail; spans of diagnostics may extend this far beyond the file.
const TAIL_GAP: usize = 64;

impl Source {
    /// Wraps bytes that were read from the file `name`.
    ///
    /// # Errors
    /// Returns the bytes if there are more than [`MAX_BYTES`] of them.
    pub fn new(id: FileId, name: &str, bytes: Vec<u8>) -> Result<Self, Vec<u8>> {
        if bytes.len() > MAX_BYTES {
            return Err(bytes);
        }
        // Old files end their lines with a single carriage return.
        let line_end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
        Ok(Source { id, name: name.into(), bytes: Arc::new(bytes), line_end, tail: Arc::default() })
    }

    /// Returns the offset at which the tail begins.
    #[must_use]
    pub fn tail_start(&self) -> usize {
        self.bytes.len() + TAIL_GAP
    }

    /// Adds a tail of expanded lines: their bytes, the offset of each in them, and the original line.
    #[must_use]
    pub fn with_tail(self, bytes: Vec<u8>, lines: Vec<(u32, Span)>) -> Self {
        Source { tail: Arc::new(Tail { bytes, lines }), ..self }
    }

    /// Converts a span to a place in the file: a part of an expanded line becomes its original line.
    #[must_use]
    pub fn in_file(&self, span: Span) -> Span {
        let Some(offset) = (span.start as usize).checked_sub(self.tail_start()) else { return span };
        let next = self.tail.lines.partition_point(|(start, _)| *start as usize <= offset);
        next.checked_sub(1).and_then(|index| self.tail.lines.get(index)).map_or(span, |(_, line)| *line)
    }

    /// Returns the identifier of this file.
    #[must_use]
    pub fn id(&self) -> FileId {
        self.id
    }

    /// Returns the name to show in diagnostics.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns all bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the byte that ends a line: a line feed, or a carriage return in a file without line feeds.
    #[must_use]
    pub fn line_end(&self) -> u8 {
        self.line_end
    }

    /// Returns the bytes of a span; empty if the span lies outside.
    #[must_use]
    pub fn slice(&self, span: Span) -> &[u8] {
        if let Some(start) = (span.start as usize).checked_sub(self.tail_start()) {
            let end = (span.end as usize).saturating_sub(self.tail_start());
            return self.tail.bytes.get(start..end).unwrap_or_default();
        }
        self.bytes.get(span.range()).unwrap_or_default()
    }

    /// Returns line and column, both from 1, of a byte offset. Columns count bytes, tabs as one.
    ///
    /// It reads all bytes before the offset; meant for diagnostics, not for every block.
    #[must_use]
    pub fn line_column(&self, offset: u32) -> (usize, usize) {
        let before = &self.bytes[..(offset as usize).min(self.bytes.len())];
        let line_start = before.iter().rposition(|&b| b == self.line_end).map_or(0, |i| i + 1);
        let line = before[..line_start].iter().filter(|&&b| b == self.line_end).count() + 1;
        (line, before.len() - line_start + 1)
    }

    /// Returns the line that contains `offset`, without its line end, and the offset at which it starts.
    #[must_use]
    pub fn line_at(&self, offset: u32) -> (&[u8], u32) {
        let at = (offset as usize).min(self.bytes.len());
        let start = self.bytes[..at].iter().rposition(|&b| b == self.line_end).map_or(0, |i| i + 1);
        let end = self.bytes[at..].iter().position(|&b| b == self.line_end).map_or(self.bytes.len(), |i| at + i);
        let line = &self.bytes[start..end];
        (line.strip_suffix(b"\r").unwrap_or(line), clamp(start))
    }
}

/// True if a character makes text appear different from its content: a control character of terminals, or one that changes the text direction. Tabs and line
/// ends are not deceptive.
#[must_use]
pub fn is_deceptive(character: char) -> bool {
    let is_turn =
        matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    is_turn || character.is_control() && !matches!(character, '\t' | '\n' | '\r')
}

/// Returns text from a file in a form that is safe to show: [`is_deceptive`] characters become `?`.
#[must_use]
pub fn shown(text: &str) -> String {
    text.chars().map(|character| if is_deceptive(character) || character == '\r' { '?' } else { character }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_and_column_count_from_one_and_stop_at_crlf() {
        let source = Source::new(FileId(0), "a", b"N10\r\nN20 G2\r\n".to_vec()).unwrap();
        assert_eq!(source.line_column(0), (1, 1));
        assert_eq!(source.line_column(9), (2, 5));
        assert_eq!(source.line_at(9), (&b"N20 G2"[..], 5));
        assert_eq!(source.slice(Span::new(9, 11)), b"G2");
    }
}
