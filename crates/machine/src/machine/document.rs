//! TOML document that records the place of every key and value.
//!
//! The tables of the TOML crate are copied once, so that no other code depends on it. [`Section`] reads them.

use std::borrow::Cow;

use toml::de::{DeTable, DeValue};

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source, Span};

use super::section::Section;

/// Maximum number of diagnostics about the TOML syntax; a fault early in a file causes many others.
const MAX_SYNTAX_FINDINGS: usize = 10;
/// Maximum number of syntax faults that are considered: locating each costs a search for its line.
const MOST_SYNTAX_FAULTS: usize = 1000;

/// Parsed document.
#[derive(Clone, Debug)]
pub struct Document {
    file: FileId,
    pub(super) root: TomlTable,
}

/// Table with its entries in the order of the file.
#[derive(Clone, Debug)]
pub(super) struct TomlTable {
    pub(super) span: Span,
    pub(super) entries: Vec<TomlEntry>,
}

#[derive(Clone, Debug)]
pub(super) struct TomlEntry {
    pub(super) key: String,
    pub(super) key_span: Span,
    pub(super) item: TomlItem,
}

#[derive(Clone, Debug)]
pub(super) struct TomlItem {
    pub(super) value: TomlValue,
    pub(super) span: Span,
}

#[derive(Clone, Debug)]
pub(super) enum TomlValue {
    Text(String),
    Number { value: f64, whole: bool },
    Boolean(bool),
    Items(Vec<TomlItem>),
    Table(TomlTable),
    Date,
}

impl Document {
    /// Parses TOML 1.0.
    ///
    /// # Errors
    /// Violations of the TOML syntax, at most one diagnostic per line; `E0401` also if the bytes are not UTF-8.
    pub fn parse(source: &Source) -> Result<Document, Vec<Diagnostic>> {
        let place = |span| Place { file: source.id(), span };
        let text = std::str::from_utf8(source.bytes()).map_err(|fault| {
            let at = fault.valid_up_to();
            let help = "save the file as UTF-8; comments in another encoding are not allowed in TOML";
            vec![Diagnostic::at(Code::BAD_TOML, place(Span::new(at, at + 1)), "a byte that is not UTF-8", help)]
        })?;
        if let Some(at) = text.bytes().position(|byte| byte == 0) {
            // A file of zeros, as left by a crash, would produce a fault for each.
            let help = "restore the file; a full disk or a crash can leave zero bytes";
            let message = "a zero byte, which no text file has";
            return Err(vec![Diagnostic::at(Code::BAD_TOML, place(Span::new(at, at + 1)), message, help)]);
        }
        let (root, faults) = DeTable::parse_recoverable(text);
        if faults.is_empty() {
            return Ok(Document { file: source.id(), root: TomlTable::of(root.get_ref(), Span::default()) });
        }
        let mut findings: Vec<Diagnostic> = faults
            .iter()
            .take(MOST_SYNTAX_FAULTS)
            .map(|fault| {
                let help = "write one `key = value` a line, text in quotation marks, lists in [ ]; see toml.io";
                let span = fault.span().map_or(Span::default(), span_of);
                Diagnostic::at(Code::BAD_TOML, place(span), fault.message(), help)
            })
            .collect();
        findings.sort_by_key(|finding| finding.place);
        findings.dedup_by_key(|finding| finding.place.map(|place| source.line_at(place.span.start).1));
        findings.truncate(MAX_SYNTAX_FINDINGS);
        Err(findings)
    }

    /// Returns the top level.
    #[must_use]
    pub fn root(&self) -> Section<'_> {
        Section::new(self.file, "the file".into(), &self.root)
    }
}

impl TomlTable {
    fn of(table: &DeTable<'_>, span: Span) -> TomlTable {
        let mut entries: Vec<TomlEntry> = table
            .iter()
            .map(|(key, item)| TomlEntry {
                key: key.get_ref().to_string(),
                key_span: span_of(key.span()),
                item: TomlItem::of(item.get_ref(), span_of(item.span())),
            })
            .collect();
        entries.sort_by_key(|entry| entry.key_span);
        TomlTable { span, entries }
    }

    pub(super) fn entry(&self, key: &str) -> Option<&TomlEntry> {
        self.entries.iter().find(|entry| entry.key == key)
    }
}

impl TomlItem {
    fn of(value: &DeValue<'_>, span: Span) -> TomlItem {
        let value = match value {
            DeValue::String(text) => TomlValue::Text(text.to_string()),
            DeValue::Integer(integer) if integer.radix() == 10 => {
                TomlValue::Number { value: integer.as_str().parse().unwrap_or(f64::NAN), whole: true }
            }
            DeValue::Integer(integer) => {
                let value =
                    i64::from_str_radix(integer.as_str(), integer.radix()).map_or(f64::NAN, |value| value as f64);
                TomlValue::Number { value, whole: true }
            }
            DeValue::Float(float) => {
                TomlValue::Number { value: float.as_str().parse().unwrap_or(f64::NAN), whole: false }
            }
            DeValue::Boolean(boolean) => TomlValue::Boolean(*boolean),
            DeValue::Datetime(_) => TomlValue::Date,
            DeValue::Array(items) => {
                TomlValue::Items(items.iter().map(|item| TomlItem::of(item.get_ref(), span_of(item.span()))).collect())
            }
            DeValue::Table(table) => TomlValue::Table(TomlTable::of(table, span)),
        };
        TomlItem { value, span }
    }

    pub(super) fn found(&self) -> Cow<'static, str> {
        /// Numbers up to this are written without an exponent.
        const PLAIN: f64 = 1e15;
        Cow::Borrowed(match self.value {
            TomlValue::Text(_) => "a text",
            TomlValue::Number { value, .. } if !value.is_finite() => "a number that is not finite",
            TomlValue::Number { value, .. } if value.abs() <= PLAIN => return Cow::Owned(value.to_string()),
            TomlValue::Number { value, .. } => return Cow::Owned(format!("{value:e}")),
            TomlValue::Boolean(_) => "true or false",
            TomlValue::Items(_) => "a list",
            TomlValue::Table(_) => "a section",
            TomlValue::Date => "a date",
        })
    }

    pub(super) fn number(&self) -> Option<f64> {
        match self.value {
            TomlValue::Number { value, .. } if value.is_finite() => Some(value),
            _ => None,
        }
    }
}

fn span_of(range: std::ops::Range<usize>) -> Span {
    Span::new(range.start, range.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(text: &str) -> Result<Document, Vec<Diagnostic>> {
        Document::parse(&Source::new(FileId(3), "m.toml", text.as_bytes().to_vec()).unwrap())
    }

    #[test]
    fn broken_text_is_reported_once_a_line_and_never_read() {
        let findings = document("a = [1,\nb = 2 3\nc = \n").unwrap_err();
        assert!(findings.iter().all(|finding| finding.code == Code::BAD_TOML));
        assert!((1..=3).contains(&findings.len()), "{findings:?}");
        let bytes = Source::new(FileId(0), "m.toml", b"a = 1 # \xe4\n".to_vec()).unwrap();
        assert_eq!(Document::parse(&bytes).unwrap_err()[0].place.unwrap().span, Span::new(8, 9));
        assert!(document(&format!("x = {}", "[".repeat(100_000))).is_err());
        assert!(document(&format!("{} = 1", vec!["a"; 100_000].join("."))).is_err());
    }
}
