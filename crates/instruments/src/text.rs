//! Bytes of a file as text: encoding, and the place of every line.
//!
//! Spreadsheets write UTF-8 with and without a byte order mark, UTF-16 ("Unicode text") and the code page of Windows. The decoded text is the
//! source of all diagnostics, so that line and column are those that an editor shows.

use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source, Span};

use crate::workbook;

/// Largest file, bytes: a table of a million readings is smaller.
pub const MOST_BYTES: usize = 64 << 20;

/// Share of control characters above which a file is not text, as one in so much.
const CONTROL_SHARE: usize = 50;

/// Beginning of the encoding of a workbook.
const WORKBOOK: &str = "workbook";

/// Decoded file.
#[derive(Clone, Debug)]
pub struct DecodedText {
    source: Source,
    encoding: String,
    lines: Vec<Span>,
}

impl DecodedText {
    /// Decodes the bytes of a file.
    ///
    /// # Errors
    /// A diagnostic if the file is too large or is not text.
    pub fn decode(name: &str, bytes: Vec<u8>) -> Result<DecodedText, Box<Diagnostic>> {
        if bytes.len() > MOST_BYTES {
            let message = format!("{name} has {} MB, which is too large for a table of readings", bytes.len() >> 20);
            return Err(refused(message, "export only the readings that are needed"));
        }
        if bytes.starts_with(ARCHIVE) && !looks_foreign(name) {
            let (sheet, text, others) = workbook::text(&bytes, MOST_BYTES).map_err(|why| {
                let help = "turn texts into numbers in the spreadsheet program, or save the sheet with the readings as CSV (UTF-8)";
                refused(format!("{name} is {why}"), help)
            })?;
            let mut encoding = format!("{WORKBOOK}, sheet '{sheet}'");
            if !others.is_empty() {
                encoding.push_str(&format!("; sheets that are not read: {}", others.join(", ")));
            }
            return DecodedText::of_text(name, &text, &encoding);
        }
        if let Some(why) = binary(&bytes) {
            return Err(refused(format!("{name} is {why}, not text"), exported(name)));
        }
        let (encoding, start) = match Encoding::for_bom(&bytes) {
            Some(found) => found,
            None if std::str::from_utf8(&bytes).is_ok() => (UTF_8, 0),
            None => (WINDOWS_1252, 0),
        };
        let (text, _) = encoding.decode_without_bom_handling(bytes.get(start..).unwrap_or_default());
        let controls =
            text.chars().filter(|&c| c.is_control() && !matches!(c, '\t' | '\n' | '\r' | '\u{c}' | '\u{1a}')).count();
        if controls > text.chars().count() / CONTROL_SHARE {
            return Err(refused(format!("{name} is not text"), exported(name)));
        }
        DecodedText::of_text(name, &text, if start > 0 || encoding != UTF_8 { encoding.name() } else { "UTF-8" })
    }

    /// Wraps a text that is already decoded.
    ///
    /// # Errors
    /// A diagnostic if it is too large.
    pub fn of_text(name: &str, text: &str, encoding: &str) -> Result<DecodedText, Box<Diagnostic>> {
        let bytes = text.as_bytes().to_vec();
        let source = Source::new(FileId(0), name, bytes)
            .map_err(|_| refused(format!("{name} is too large"), "export only the readings that are needed"))?;
        let lines = lines(&source);
        Ok(DecodedText { source, encoding: encoding.to_owned(), lines })
    }

    /// Returns the text for diagnostics.
    #[must_use]
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Returns the name of the encoding: `UTF-8`, `windows-1252`.
    #[must_use]
    pub fn encoding(&self) -> &str {
        &self.encoding
    }

    /// Returns all lines with their numbers, from 1, and the byte at which each begins.
    pub fn lines(&self) -> impl DoubleEndedIterator<Item = (usize, &str, u32)> {
        self.lines.iter().enumerate().map(|(index, &span)| (index + 1, self.slice(span), span.start))
    }

    /// Returns a line by its number; empty if there is no such line.
    #[must_use]
    pub fn line(&self, number: usize) -> &str {
        number.checked_sub(1).and_then(|index| self.lines.get(index)).map_or("", |&span| self.slice(span))
    }

    /// Returns the place of a line.
    #[must_use]
    pub fn place(&self, number: usize) -> Place {
        let span = number.checked_sub(1).and_then(|index| self.lines.get(index)).copied().unwrap_or_default();
        Place { file: self.source.id(), span }
    }

    /// Returns the name of a cell or of a row of a workbook, such as `C4`; `None` for a text.
    #[must_use]
    pub fn cell(&self, place: Place) -> Option<String> {
        if !self.encoding.starts_with(WORKBOOK) {
            return None;
        }
        let row = self.lines.partition_point(|line| line.start <= place.span.start).checked_sub(1)?;
        let line = *self.lines.get(row)?;
        if place.span == line {
            return Some(format!("row {}", row + 1));
        }
        let before = Span { start: line.start, end: place.span.start };
        let column = self.slice(before).matches('\t').count();
        Some(format!("cell {}", workbook::name_of([u32::try_from(row).ok()?, u32::try_from(column).ok()?])))
    }

    fn slice(&self, span: Span) -> &str {
        std::str::from_utf8(self.source.slice(span)).unwrap_or_default()
    }
}

/// Spans of the lines, without their ends.
fn lines(source: &Source) -> Vec<Span> {
    let end = source.line_end();
    let mut found = Vec::new();
    let mut start = 0;
    for line in source.bytes().split(|&byte| byte == end) {
        let length = line.strip_suffix(b"\r").unwrap_or(line).len();
        found.push(Span::new(start, start + length));
        start += line.len() + 1;
    }
    found
}

/// First bytes of an archive, which a workbook is.
const ARCHIVE: &[u8] = b"PK\x03\x04";

/// True for archives that are documents of other programs, by extension.
fn looks_foreign(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    [".ods", ".docx", ".zip"].iter().any(|ending| name.ends_with(ending))
}

/// Kind of a binary file, by its first bytes.
fn binary(bytes: &[u8]) -> Option<&'static str> {
    const MARKS: &[(&[u8], &str)] = &[
        (ARCHIVE, "a compressed archive"),
        (b"\xd0\xcf\x11\xe0", "an old document of an office program"),
        (b"%PDF", "a PDF document"),
        (b"\x89PNG", "a picture"),
        (b"SQLite format 3", "a database"),
        (b"\x1f\x8b", "a compressed file"),
    ];
    if let Some((_, name)) = MARKS.iter().find(|(mark, _)| bytes.starts_with(mark)) {
        return Some(name);
    }
    let is_utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
    (!is_utf16 && bytes.contains(&0)).then_some("binary")
}

/// Vendor files that are not text, by extension, with the export to use instead.
const EXPORTS: &[(&str, &str)] = &[
    ("xls", "save the sheet as CSV (UTF-8)"),
    ("ods", "save the sheet as CSV (UTF-8)"),
    ("pdf", "export the table as CSV or text; a PDF contains only its picture"),
    ("rtx", "the recording of a dynamic test: export it as CSV from the laser software"),
    ("b5r", "open the result in the ball-bar software and export it as text or CSV (angle and deviation)"),
    ("b5p", "this is a test template: export the result of a test as text or CSV"),
    ("b5h", "this is a history: export the result of one test as text or CSV"),
    ("b20", "open the result in the ball-bar software and export it as text or CSV (angle and deviation)"),
    ("qif", "export the report as CSV with nominal and actual values"),
    ("pcd", "export the points as text"),
];

/// Advice for a file that is not text.
fn exported(name: &str) -> String {
    let ending = name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    let known = EXPORTS.iter().find(|(own, _)| *own == ending);
    known
        .map_or("export the readings as text or CSV from the software of the instrument", |(_, advice)| advice)
        .to_owned()
}

fn refused(message: String, help: impl Into<String>) -> Box<Diagnostic> {
    Box::new(Diagnostic::nowhere(Code::IMPORT_FORMAT, message, help))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16(text: &str) -> Vec<u8> {
        [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect()
    }

    #[test]
    fn encodings_of_spreadsheets_give_one_text() {
        let text = "Ziel;Abw. µm\r\n0;1,5";
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
        for bytes in [text.as_bytes().to_vec(), latin, marked, utf16(text)] {
            let read = DecodedText::decode("a.csv", bytes).unwrap();
            assert_eq!(read.line(1), "Ziel;Abw. µm");
            assert_eq!(read.line(2), "0;1,5");
        }
    }

    #[test]
    fn binary_files_are_refused_with_the_export_to_use() {
        let found = DecodedText::decode("test.b5r", vec![1, 2, 0, 3]).unwrap_err();
        assert_eq!(found.code, Code::IMPORT_FORMAT);
        assert!(found.help.contains("ball-bar software"), "{}", found.help);
        assert!(DecodedText::decode("a.pdf", b"%PDF-1.7".to_vec()).unwrap_err().help.contains("picture"));
    }
}
