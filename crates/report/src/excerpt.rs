//! Source line of a diagnostic as text: bytes of any encoding become characters, and offsets become columns.

use ncfix_base::diagnostic::Place;
use ncfix_base::source::{Source, Span, is_deceptive};

/// Lines with more bytes than this are not drawn; only their place is shown. No part program has such lines.
const LONGEST_DRAWN_LINE: usize = 8192;

/// Place in a file, prepared for display. Line and columns count from 1, columns in characters, a tab as one.
pub(super) struct Excerpt {
    /// Line.
    pub(super) line: usize,
    /// Column of the first character.
    pub(super) column: usize,
    /// Text of the line, and the range of bytes concerned (in this text, not in the file); `None` for overlong lines.
    pub(super) text: Option<(String, std::ops::Range<usize>)>,
}

impl Excerpt {
    /// Creates the excerpt for a place in `source`; the span is cut at the end of its first line.
    pub(super) fn new(source: &Source, place: Place) -> Excerpt {
        let Span { start, end } = place.span;
        let (line, _) = source.line_column(start);
        let (bytes, line_start) = source.line_at(start);
        let from = (start.saturating_sub(line_start) as usize).min(bytes.len());
        let to = (end.saturating_sub(line_start) as usize).clamp(from, bytes.len());
        if bytes.len() > LONGEST_DRAWN_LINE {
            return Excerpt { line, column: from + 1, text: None };
        }
        let mut text = String::with_capacity(bytes.len());
        let is_utf8 = std::str::from_utf8(bytes).is_ok();
        decode(&mut text, &bytes[..from], is_utf8);
        let column = text.chars().count() + 1;
        let first = text.len();
        decode(&mut text, &bytes[from..to], is_utf8);
        let last = text.len();
        decode(&mut text, &bytes[to..], is_utf8);
        Excerpt { line, column, text: Some((text, first..last)) }
    }
}

/// Appends bytes as characters. A line that is not UTF-8 is shown byte by byte as Latin-1. Letters in a GBK comment are then wrong, but every byte is one
/// column, so the caret below the line points at the right place.
fn decode(text: &mut String, bytes: &[u8], is_utf8: bool) {
    if is_utf8 {
        let shown = String::from_utf8_lossy(bytes);
        text.extend(
            shown.chars().map(|c| if c >= '\u{7f}' && is_deceptive(c) { char::REPLACEMENT_CHARACTER } else { c }),
        );
    } else {
        text.extend(bytes.iter().map(|&byte| match char::from(byte) {
            // The C1 control characters would be commands to some terminals.
            '\u{80}'..='\u{9f}' => char::REPLACEMENT_CHARACTER,
            character => character,
        }));
    }
}

/// Returns text from a file in a form that is safe to print: control characters, which a terminal would obey, become `?`.
pub(super) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || is_deceptive(c) { '?' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::FileId;

    fn excerpt(bytes: &[u8], start: usize, end: usize) -> Excerpt {
        let source = Source::new(FileId(0), "p.mpf", bytes.to_vec()).unwrap();
        Excerpt::new(&source, Place { file: FileId(0), span: Span::new(start, end) })
    }

    #[test]
    fn utf8_counts_characters() {
        // 'ü' has two bytes, so X (byte 10) is character 10, counted from 1.
        let shown = excerpt("MSG(\"ü\") X".as_bytes(), 10, 11);
        assert_eq!((shown.line, shown.column), (1, 10));
        let (text, range) = shown.text.unwrap();
        assert_eq!(&text[range], "X");
    }

    #[test]
    fn other_encodings_count_bytes() {
        let shown = excerpt(b"N1\r\nMSG(\"\xfc\x95\") X9\r\n", 14, 16);
        assert_eq!((shown.line, shown.column), (2, 11));
        let (text, range) = shown.text.unwrap();
        assert_eq!(text, "MSG(\"ü\u{fffd}\") X9");
        assert_eq!(&text[range], "X9");
    }

    #[test]
    fn a_span_ends_with_its_line_and_the_file() {
        let (text, range) = excerpt(b"N10 X1\nN20 X2\n", 4, 12).text.unwrap();
        assert_eq!(&text[range], "X1");
        let shown = excerpt(b"N10 X1", 99, 120);
        assert_eq!((shown.line, shown.column), (1, 7));
    }

    #[test]
    fn an_overlong_line_only_has_a_place() {
        let shown = excerpt(&[b'X'; 10_000], 9_000, 9_001);
        assert_eq!((shown.line, shown.column), (1, 9_001));
        assert!(shown.text.is_none());
    }

    #[test]
    fn escape_sequences_are_disarmed() {
        assert_eq!(printable("a\u{1b}[31mb\u{7}"), "a?[31mb?");
    }
}
