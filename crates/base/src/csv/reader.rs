//! Splits the bytes of a table into cells.

use std::collections::HashSet;

use crate::diagnostic::{Code, Diagnostic, Place};
use crate::source::{Source, Span};

use super::{DecimalSign, Table, parse_number};

/// Maximum number of diagnostics; more are of no use.
const MOST_FINDINGS: usize = 100;
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Reader over the bytes of a file.
pub(super) struct Reader<'a> {
    source: &'a Source,
    bytes: &'a [u8],
    at: usize,
    separator: u8,
    findings: Vec<Diagnostic>,
}

impl<'a> Reader<'a> {
    /// Returns the table in a file, or diagnostics.
    pub(super) fn read(source: &'a Source) -> (Option<Table>, Vec<Diagnostic>) {
        let mut reader = match Reader::new(source) {
            Ok(reader) => reader,
            Err(fault) => return (None, vec![fault]),
        };
        match reader.table() {
            Ok(table) => (Some(table).filter(|_| reader.findings.is_empty()), reader.findings),
            Err(fault) => {
                reader.findings.push(fault);
                (None, reader.findings)
            }
        }
    }

    fn new(source: &'a Source) -> Result<Reader<'a>, Diagnostic> {
        let bytes = source.bytes();
        let mut reader = Reader { source, bytes, at: 0, separator: b',', findings: Vec::new() };
        let is_wide = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
        if let Some(at) = bytes.iter().position(|&byte| byte == 0).or(is_wide.then_some(0)) {
            let message = "the file is not UTF-8 text; it looks like UTF-16 or a workbook";
            return Err(reader.fault(at, at + 1, message, "save it as CSV in UTF-8"));
        }
        if bytes.starts_with(BYTE_ORDER_MARK) {
            reader.at = BYTE_ORDER_MARK.len();
        }
        Ok(reader)
    }

    fn fault(&self, start: usize, end: usize, message: impl Into<String>, help: &str) -> Diagnostic {
        let place = Place { file: self.source.id(), span: Span::new(start, end) };
        Diagnostic::at(Code::DATA_NO_TABLE, place, message, help)
    }

    /// Reads header and rows.
    fn table(&mut self) -> Result<Table, Diagnostic> {
        self.skip_blank();
        let stated = self.stated_separator();
        self.skip_blank();
        self.separator = stated.unwrap_or_else(|| self.likely_separator());
        let start = self.at;
        let mut header = Vec::new();
        if !self.row(&mut header)? {
            return Err(self.fault(
                0,
                self.bytes.len().min(1),
                "the table is empty",
                "begin with a line of column names",
            ));
        }
        let is_number = |span: &Span| {
            let text = self.source.slice(*span);
            [DecimalSign::Point, DecimalSign::Comma].iter().any(|&sign| parse_number(text, sign).is_some())
        };
        if header.iter().any(is_number) {
            let message = "the first line contains numbers; the column names are missing";
            return Err(self.fault(start, self.at, message, "begin with a line of column names such as X,Y,Z"));
        }
        let names: Vec<String> =
            header.iter().map(|&span| String::from_utf8_lossy(self.source.slice(span)).replace("\"\"", "\"")).collect();
        let mut seen = HashSet::new();
        for (name, span) in names.iter().zip(&header) {
            if !name.is_empty() && !seen.insert(name) {
                let place = Place { file: self.source.id(), span: *span };
                let message = format!("the column {name} is given twice");
                self.findings.push(Diagnostic::at(Code::DATA_COLUMN, place, message, "rename or remove one of them"));
            }
        }
        let mut cells = Vec::new();
        loop {
            let (start, first) = (self.at, cells.len());
            if !self.row(&mut cells)? {
                break;
            }
            let count = cells.len() - first;
            if cells.get(first..).unwrap_or_default().iter().all(|span| span.start == span.end) {
                // Spreadsheets leave rows that contain only separators.
                cells.truncate(first);
            } else if count != names.len() {
                cells.truncate(first);
                let message = format!("this row has {count} cells, the header has {}", names.len());
                let help =
                    "give every row one cell per column; put text that contains the separator in quotation marks";
                let end = self.row_end(start);
                self.findings.push(self.fault(start, end, message, help));
                if self.findings.len() >= MOST_FINDINGS {
                    break;
                }
            }
        }
        Ok(Table { source: self.source.clone(), names, header, cells, separator: self.separator })
    }

    fn is_line_end(&self, at: usize) -> bool {
        match self.bytes.get(at) {
            None | Some(b'\n') => true,
            Some(b'\r') => self.source.line_end() == b'\r' || self.bytes.get(at + 1) == Some(&b'\n'),
            Some(_) => false,
        }
    }

    /// Returns the end of the line of a row, for drawing it.
    fn row_end(&self, start: usize) -> usize {
        (start..self.bytes.len()).find(|&at| self.is_line_end(at)).unwrap_or(self.bytes.len())
    }

    fn step_over_line_end(&mut self) {
        if self.bytes.get(self.at) == Some(&b'\r') && self.bytes.get(self.at + 1) == Some(&b'\n') {
            self.at += 1;
        }
        self.at = (self.at + 1).min(self.bytes.len());
    }

    /// Skips blank lines.
    fn skip_blank(&mut self) {
        let mut at = self.at;
        while self.bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
            at += 1;
            if self.is_line_end(at - 1) {
                self.at = at;
            }
        }
        if at == self.bytes.len() {
            self.at = at;
        }
    }

    /// Reads the separator of a line `sep=;`, as used by spreadsheets, and skips that line.
    fn stated_separator(&mut self) -> Option<u8> {
        let rest = self.bytes.get(self.at..)?;
        let [b's' | b'S', b'e' | b'E', b'p' | b'P', b'=', separator @ (b';' | b',' | b'\t'), ..] = *rest else {
            return None;
        };
        let end = self.at + 5;
        self.is_line_end(end).then(|| {
            self.at = end;
            self.step_over_line_end();
            separator
        })
    }

    /// Guesses the separator from the header.
    fn likely_separator(&self) -> u8 {
        // A quotation mark within a cell is part of it, such as the sign for inches.
        let (mut is_quoted, mut begins_cell) = (false, true);
        let mut seen = [false; 2];
        let mut at = self.at;
        while is_quoted || !self.is_line_end(at) {
            match self.bytes.get(at) {
                None => break,
                Some(b'"') if is_quoted && self.bytes.get(at + 1) == Some(&b'"') => at += 1,
                Some(b'"') if is_quoted => is_quoted = false,
                Some(b'"') if begins_cell => (is_quoted, begins_cell) = (true, false),
                Some(_) if is_quoted => {}
                Some(separator @ (b';' | b'\t' | b',')) => {
                    begins_cell = true;
                    match separator {
                        b';' => seen[0] = true,
                        b'\t' => seen[1] = true,
                        _ => {}
                    }
                }
                Some(b' ') => {}
                Some(_) => begins_cell = false,
            }
            at += 1;
        }
        match seen {
            [true, _] => b';',
            [false, true] => b'\t',
            _ => b',',
        }
    }

    fn is_space(&self, at: usize) -> bool {
        self.bytes.get(at).is_some_and(|&byte| byte != self.separator && (byte == b' ' || byte == b'\t'))
    }

    fn skip_spaces(&mut self) {
        while self.is_space(self.at) {
            self.at += 1;
        }
    }

    /// Adds the cells of the next row; returns `false` at the end of the file.
    fn row(&mut self, cells: &mut Vec<Span>) -> Result<bool, Diagnostic> {
        self.skip_blank();
        if self.at >= self.bytes.len() {
            return Ok(false);
        }
        loop {
            cells.push(self.cell()?);
            if self.bytes.get(self.at) == Some(&self.separator) {
                self.at += 1;
            } else {
                self.step_over_line_end();
                return Ok(true);
            }
        }
    }

    /// Returns the content of the next cell and stops at its terminator.
    fn cell(&mut self) -> Result<Span, Diagnostic> {
        self.skip_spaces();
        if self.bytes.get(self.at) == Some(&b'"') {
            return self.quoted();
        }
        let start = self.at;
        while !self.is_line_end(self.at) && self.bytes.get(self.at) != Some(&self.separator) {
            self.at += 1;
        }
        let mut end = self.at;
        while end > start && self.is_space(end - 1) {
            end -= 1;
        }
        Ok(Span::new(start, end))
    }

    fn quoted(&mut self) -> Result<Span, Diagnostic> {
        let start = self.at + 1;
        self.at = start;
        loop {
            match (self.bytes.get(self.at), self.bytes.get(self.at + 1)) {
                (None, _) => {
                    let message = "this quotation mark is not closed";
                    return Err(self.fault(
                        start - 1,
                        start,
                        message,
                        "close it; write a quotation mark inside a text twice",
                    ));
                }
                (Some(b'"'), Some(b'"')) => self.at += 2,
                (Some(b'"'), _) => break,
                _ => self.at += 1,
            }
        }
        let content = Span::new(start, self.at);
        self.at += 1;
        self.skip_spaces();
        if self.is_line_end(self.at) || self.bytes.get(self.at) == Some(&self.separator) {
            return Ok(content);
        }
        let message = "unexpected text between a closing quotation mark and the next separator";
        Err(self.fault(self.at, self.at + 1, message, "write a quotation mark inside a text twice"))
    }
}
