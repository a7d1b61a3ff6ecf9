//! Text tables: rows of cells after a header. Every cell has a place in its file, so diagnostics have line and column, and a copy of the table changes only
//! the intended cells.
//!
//! Separators are commas, semicolons (as written by spreadsheets if the comma is the decimal sign) or tabs; cells may be quoted (RFC 4180). The reader is
//! part of this crate because it must return the bytes of every cell. It decodes nothing, so unused cells may be in any encoding that preserves ASCII.

mod reader;

use std::io::{self, Write};

use crate::diagnostic::{Code, Diagnostic, Place};
use crate::source::{Source, Span};

use reader::Reader;

/// Table: a header and rows of equal width.
#[derive(Clone, Debug)]
pub struct Table {
    source: Source,
    names: Vec<String>,
    header: Vec<Span>,
    /// Contents of the cells, row by row.
    cells: Vec<Span>,
    separator: u8,
}

/// Decimal sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecimalSign {
    /// `1.5`
    Point,
    /// `1,5`
    Comma,
}

/// Row of a table.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    table: &'a Table,
    cells: &'a [Span],
}

impl Table {
    /// Reads a table. If there is none, at least one diagnostic is an error.
    #[must_use]
    pub fn read(source: &Source) -> (Option<Table>, Vec<Diagnostic>) {
        Reader::read(source)
    }

    /// Returns the names of the columns, in order.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the index of the column with this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Returns the place of a column name; the whole header if the column does not exist.
    #[must_use]
    pub fn header_place(&self, column: Option<usize>) -> Place {
        let all = || {
            let first = self.header.first().copied().unwrap_or_default();
            self.header.last().map_or(first, |&last| first.to(last))
        };
        let span = column.and_then(|column| self.header.get(column)).copied().unwrap_or_else(all);
        Place { file: self.source.id(), span }
    }

    /// Returns the rows, in order, without empty ones.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        let cells = self.cells.chunks_exact(self.names.len().max(1));
        cells.map(|cells| Row { table: self, cells })
    }

    /// Returns the line of a place in the table, from 1.
    #[must_use]
    pub fn line_of(&self, place: Place) -> usize {
        self.source.line_column(place.span.start).0
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.cells.len() / self.names.len().max(1)
    }

    /// Returns the separator of the cells.
    #[must_use]
    pub fn separator(&self) -> u8 {
        self.separator
    }

    /// Returns the place after the last cell of a row, given that cell; another cell may be added there.
    #[must_use]
    pub fn place_behind(&self, last: Place) -> Place {
        let bytes = self.source.bytes();
        let range = last.span.range();
        let is_quoted = range.start.checked_sub(1).is_some_and(|before| bytes.get(before) == Some(&b'"'))
            && bytes.get(range.end) == Some(&b'"');
        let end = range.end + usize::from(is_quoted);
        Place { file: last.file, span: Span::new(end, end) }
    }

    /// Returns the decimal sign of the numbers in some columns. If no number has decimals, it is the comma in tables with semicolons, as this is why they use
    /// semicolons.
    ///
    /// # Errors
    /// A diagnostic if both signs occur: one of them would be a thousands separator, and it is not known which.
    pub fn decimal_sign(&self, columns: &[usize]) -> Result<DecimalSign, Diagnostic> {
        let mut found: Option<(DecimalSign, Place)> = None;
        for row in self.rows() {
            for &column in columns {
                let text = row.text(column);
                let sign = match (text.contains(&b'.'), text.contains(&b',')) {
                    (true, false) => DecimalSign::Point,
                    (false, true) => DecimalSign::Comma,
                    // With both signs it is not a number in either notation, which is reported when it is read.
                    _ => continue,
                };
                match found {
                    None => found = Some((sign, row.place(column))),
                    Some((other, place)) if other != sign => {
                        let (line, _) = self.source.line_column(place.span.start);
                        let message = format!(
                            "'{}' has a different decimal sign from '{}' in line {line}",
                            shown(text),
                            shown(self.source.slice(place.span))
                        );
                        let help = "write all numbers with the same decimal sign and without thousands separators";
                        return Err(Diagnostic::at(Code::DATA_CELL, row.place(column), message, help));
                    }
                    Some(_) => {}
                }
            }
        }
        let usual = if self.separator == b';' { DecimalSign::Comma } else { DecimalSign::Point };
        Ok(found.map_or(usual, |(sign, _)| sign))
    }

    /// Returns a byte-by-byte copy of the table in which single cells may be replaced.
    pub fn copy<W: Write>(&self, out: W) -> Copy<'_, W> {
        Copy { bytes: self.source.bytes(), done: 0, out }
    }
}

impl<'a> Row<'a> {
    /// Returns the content of a cell without its quotation marks; empty if the column does not exist.
    #[must_use]
    pub fn text(&self, column: usize) -> &'a [u8] {
        self.cells.get(column).map_or(&[], |&span| self.table.source.slice(span))
    }

    /// Returns the index of the column with this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.table.column(name)
    }

    /// Returns the place of the table header.
    #[must_use]
    pub fn header_place(&self) -> Place {
        self.table.header_place(None)
    }

    /// Returns the place of the content of a cell.
    #[must_use]
    pub fn place(&self, column: usize) -> Place {
        let span = self.cells.get(column).copied().unwrap_or_default();
        Place { file: self.table.source.id(), span }
    }

    /// Returns the number in a cell.
    ///
    /// # Errors
    /// A diagnostic if the cell is empty or not a finite number.
    pub fn number(&self, column: usize, sign: DecimalSign) -> Result<f64, Diagnostic> {
        /// No measured value is larger in any unit, and its square is still finite.
        const MOST: f64 = 1e15;
        let text = self.text(column);
        let value = parse_number(text, sign);
        if value.is_some_and(|value| value.abs() > MOST) {
            let name = self.table.names.get(column).map_or("", String::as_str);
            let message = format!("'{}' in the column {name} is too large for a measured value", shown(text));
            let help = "correct the cell, or leave it empty if there is no reading";
            return Err(Diagnostic::at(Code::DATA_CELL, self.place(column), message, help));
        }
        value.ok_or_else(|| {
            let name = self.table.names.get(column).map_or("", String::as_str);
            let mut place = self.place(column);
            let (message, help) = if text.is_empty() {
                // An empty place could not be drawn.
                place.span.end = place.span.end.saturating_add(1);
                (format!("the cell of {name} is empty"), "write the number, or remove the row".to_owned())
            } else {
                let example = if sign == DecimalSign::Comma { "12,5" } else { "12.5" };
                (
                    format!("'{}' in the column {name} is not a number", shown(text)),
                    format!("write a plain number such as {example} (for a direction -1, 0 or 1), without unit or thousands separators"),
                )
            };
            Diagnostic::at(Code::DATA_CELL, place, message, help)
        })
    }
}

/// Copy in progress; everything that is not replaced is written unchanged.
#[derive(Debug)]
pub struct Copy<'a, W> {
    bytes: &'a [u8],
    done: usize,
    out: W,
}

impl<W: Write> Copy<'_, W> {
    /// Writes everything up to a place, and a text in its stead. Places must come in order.
    ///
    /// # Errors
    /// I/O errors of the writer.
    pub fn replace(&mut self, place: Place, text: &str) -> io::Result<()> {
        let range = place.span.range();
        self.out.write_all(self.bytes.get(self.done..range.start).unwrap_or_default())?;
        self.done = range.end;
        self.out.write_all(text.as_bytes())
    }

    /// Writes the rest.
    ///
    /// # Errors
    /// I/O errors of the writer.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.write_all(self.bytes.get(self.done..).unwrap_or_default())?;
        self.out.flush()
    }
}

/// Formats a number for a cell, with at least `decimals` decimals and at least the number of decimals in `like`.
#[must_use]
pub fn number_text(value: f64, decimals: usize, like: &[u8], sign: DecimalSign) -> String {
    // More digits than a double contains are meaningless.
    const MOST_DECIMALS: usize = 15;
    let mut parts = like.splitn(2, |byte| matches!(byte, b'.' | b','));
    let behind = parts.nth(1).unwrap_or_default();
    let digits = behind.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let decimals = decimals.max(digits).min(MOST_DECIMALS);
    let text = format!("{value:.decimals$}");
    if sign == DecimalSign::Comma { text.replace('.', ",") } else { text }
}

/// Parses digits with sign, decimals and exponent, and nothing else that a library might accept as a number.
fn parse_number(text: &[u8], sign: DecimalSign) -> Option<f64> {
    let mark = if sign == DecimalSign::Comma { b',' } else { b'.' };
    let is_fit = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'e' | b'E') || *byte == mark;
    if !text.iter().all(is_fit) {
        return None;
    }
    let plain: String = text.iter().map(|&byte| if byte == mark { '.' } else { char::from(byte) }).collect();
    plain.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Returns bytes for a message, shortened if they are long.
fn shown(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(bytes);
    let mut short: String = text.chars().take(LONGEST).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
