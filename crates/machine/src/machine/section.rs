//! Reads one table of a document and reports faults instead of failing.
//!
//! Each value that is missing, of the wrong type or not finite becomes a diagnostic at its place. The requested keys are the known ones, and
//! [`Section::finish`] reports all others.

use std::collections::HashSet;

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::Vector;
use ncfix_base::source::FileId;

use super::document::{TomlEntry, TomlItem, TomlTable, TomlValue};
use super::range::{NumberRange, most_in_list, range_of};
use ncfix_base::source::is_deceptive;

/// Maximum number of unknown keys that are reported for one table; a file with more is not a machine file.
const MOST_UNKNOWN: usize = 1000;

/// Reads one table and collects its faults.
#[derive(Debug)]
pub struct Section<'a> {
    file: FileId,
    title: String,
    table: &'a TomlTable,
    asked: Vec<String>,
    findings: Vec<Diagnostic>,
}

impl<'a> Section<'a> {
    pub(super) fn new(file: FileId, title: String, table: &'a TomlTable) -> Section<'a> {
        Section { file, title, table, asked: Vec::new(), findings: Vec::new() }
    }

    /// Returns the name of the section in messages: `[axis.X]`.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Returns the place of the section header.
    #[must_use]
    pub fn place(&self) -> Place {
        Place { file: self.file, span: self.table.span }
    }

    /// Returns the place of the value of a key; that of the header if the key is missing.
    #[must_use]
    pub fn place_of(&self, key: &str) -> Place {
        let span = self.table.entry(key).map_or(self.table.span, |entry| entry.item.span);
        Place { file: self.file, span }
    }

    /// Returns the place of a key; that of the header if the key is missing.
    #[must_use]
    pub fn place_of_key(&self, key: &str) -> Place {
        let span = self.table.entry(key).map_or(self.table.span, |entry| entry.key_span);
        Place { file: self.file, span }
    }

    /// Returns the place of one item of a list; that of the list or the header if it is missing.
    #[must_use]
    pub fn place_of_item(&self, key: &str, index: usize) -> Place {
        let mut place = self.place_of(key);
        if let Some(TomlEntry { item: TomlItem { value: TomlValue::Items(items), .. }, .. }) = self.table.entry(key)
            && let Some(item) = items.get(index)
        {
            place.span = item.span;
        }
        place
    }

    /// Returns all keys, in the order of the file.
    pub fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.table.entries.iter().map(|entry| entry.key.as_str())
    }

    /// True if the key exists.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.table.entry(key).is_some()
    }

    /// Adds a diagnostic.
    pub fn report(&mut self, code: Code, place: Place, message: impl Into<String>, help: impl Into<String>) {
        self.findings.push(Diagnostic::at(code, place, message, help));
    }

    /// Adds the diagnostics of a subsection.
    pub fn add(&mut self, findings: Vec<Diagnostic>) {
        self.findings.extend(findings);
    }

    /// Marks a key as known without reading it, because it was reported already or another reader uses it.
    pub fn accept(&mut self, key: &str) {
        self.asked.push(key.to_owned());
    }

    /// Reads a required value; reports `E0403` if it is missing. `example` is shown as a valid value.
    pub fn required<T>(
        &mut self,
        key: &str,
        example: &str,
        read: impl FnOnce(&mut Self, &str) -> Option<T>,
    ) -> Option<T> {
        if self.has(key) {
            return read(self, key);
        }
        self.accept(key);
        let message = format!("{} has no {key}", self.title);
        let help = if example.starts_with("a section ") {
            format!("write {example}")
        } else if example.starts_with(&format!("[{key}.")) {
            format!("add a section {example}")
        } else {
            format!("write for example `{key} = {example}`")
        };
        self.report(Code::MISSING_KEY, self.place(), message, help);
        None
    }

    /// Reads a finite number.
    pub fn number(&mut self, key: &str) -> Option<f64> {
        self.value(key, "a finite number", TomlItem::number).filter(|&value| self.is_in_range(key, &[value]))
    }

    /// Reads a number of a key without a unit in its name, in the range of the keys that end with `unit`, such as `_urad`.
    pub fn number_in(&mut self, key: &str, unit: &str) -> Option<f64> {
        let found = self.value(key, "a finite number", TomlItem::number);
        found.filter(|&value| self.is_within(&range_of(unit), key, &[value]))
    }

    /// Reads a number that must satisfy a condition.
    pub fn number_where(&mut self, key: &str, expected: &str, allowed: impl Fn(f64) -> bool) -> Option<f64> {
        let found = self.value(key, expected, |item| item.number().filter(|&value| allowed(value)));
        found.filter(|&value| self.is_in_range(key, &[value]))
    }

    /// Reads a whole number from 0 to 2³² − 1.
    pub fn integer(&mut self, key: &str) -> Option<u32> {
        let found = self.value(key, "a whole number that is not negative", |item| match item.value {
            TomlValue::Number { value, whole: true } if (0.0..=f64::from(u32::MAX)).contains(&value) => {
                Some(value as u32)
            }
            _ => None,
        });
        found.filter(|&value| self.is_in_range(key, &[f64::from(value)]))
    }

    /// Reads `true` or `false`.
    pub fn boolean(&mut self, key: &str) -> Option<bool> {
        self.value(key, "true or false", |item| match item.value {
            TomlValue::Boolean(value) => Some(value),
            _ => None,
        })
    }

    /// Reads a text for people; control characters are refused.
    pub fn text(&mut self, key: &str) -> Option<&'a str> {
        let text = self.text_of_bytes(key)?;
        self.is_readable(key, text).then_some(text)
    }

    /// Reads a text whose characters are bytes for a control; any character is allowed.
    pub fn text_of_bytes(&mut self, key: &str) -> Option<&'a str> {
        self.value(key, "a text in quotation marks", |item| match &item.value {
            TomlValue::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }

    /// Reads a date: year, month and day.
    pub fn date(&mut self, key: &str) -> Option<&'a str> {
        self.value(key, "a date such as \"2026-11-27\"", |item| match &item.value {
            TomlValue::Text(text) if is_date(text) => Some(text.as_str()),
            _ => None,
        })
    }

    /// Reads a list of finite numbers.
    pub fn numbers(&mut self, key: &str) -> Option<Vec<f64>> {
        let numbers: Vec<f64> = self.value(key, "a list of finite numbers", |item| match &item.value {
            TomlValue::Items(items) => items.iter().map(TomlItem::number).collect(),
            _ => None,
        })?;
        self.is_in_range(key, &numbers).then_some(numbers)
    }

    /// Reads a list of lists of finite numbers.
    pub fn rows(&mut self, key: &str) -> Option<Vec<Vec<f64>>> {
        let rows: Vec<Vec<f64>> = self.value(key, "a list of lists of finite numbers", |item| match &item.value {
            TomlValue::Items(items) => items
                .iter()
                .map(|item| match &item.value {
                    TomlValue::Items(items) => items.iter().map(TomlItem::number).collect(),
                    _ => None,
                })
                .collect(),
            _ => None,
        })?;
        rows.iter().all(|row| self.is_in_range(key, row)).then_some(rows)
    }

    /// Reads a list of texts.
    pub fn texts(&mut self, key: &str) -> Option<Vec<String>> {
        let texts: Vec<String> = self.value(key, "a list of texts in quotation marks", |item| match &item.value {
            TomlValue::Items(items) => items
                .iter()
                .map(|item| match &item.value {
                    TomlValue::Text(text) => Some(text.clone()),
                    _ => None,
                })
                .collect(),
            _ => None,
        })?;
        texts.iter().all(|text| self.is_readable(key, text)).then_some(texts)
    }

    /// Reads a list of three finite numbers.
    pub fn vector(&mut self, key: &str) -> Option<Vector> {
        let vector = self.value(key, "a list of three finite numbers", |item| match &item.value {
            TomlValue::Items(items) => match items.as_slice() {
                [x, y, z] => Some(Vector::new(x.number()?, y.number()?, z.number()?)),
                _ => None,
            },
            _ => None,
        })?;
        self.is_in_range(key, vector.as_slice()).then_some(vector)
    }

    /// Reads a number, which becomes the first of three, or a list of three numbers.
    pub fn number_or_three(&mut self, key: &str) -> Option<[f64; 3]> {
        let three = self.value(key, "a finite number, or a list of three", |item| match &item.value {
            TomlValue::Items(items) => match items.as_slice() {
                [first, second, third] => Some([first.number()?, second.number()?, third.number()?]),
                _ => None,
            },
            _ => item.number().map(|value| [value, 0.0, 0.0]),
        })?;
        self.is_in_range(key, &three).then_some(three)
    }

    /// Reads a subsection.
    pub fn section(&mut self, key: &str) -> Option<Section<'a>> {
        let title = self.title_of(key);
        let file = self.file;
        self.value(key, "a section", |item| match &item.value {
            TomlValue::Table(table) => Some(Section::new(file, title, table)),
            _ => None,
        })
    }

    /// Reads a list of subsections, `[[key]]` or `key = [{ … }]`; empty if there are none.
    pub fn sections(&mut self, key: &str) -> Vec<Section<'a>> {
        let title = format!("[{}]", self.title_of(key));
        let file = self.file;
        let sections = self.value(key, "a list of sections", |item| match &item.value {
            TomlValue::Items(items) => items
                .iter()
                .map(|item| match &item.value {
                    TomlValue::Table(table) => Some(Section::new(file, title.clone(), table)),
                    _ => None,
                })
                .collect(),
            _ => None,
        });
        sections.unwrap_or_default()
    }

    /// Checks range and number of the values of a key; reports the first fault.
    fn is_in_range(&mut self, key: &str, values: &[f64]) -> bool {
        self.is_within(&range_of(key), key, values)
    }

    fn is_within(&mut self, range: &NumberRange, key: &str, values: &[f64]) -> bool {
        let most = most_in_list(key);
        if values.len() > most {
            let message = format!("{key} has {} numbers, more than {most}", values.len());
            self.report(Code::OUT_OF_RANGE, self.place_of(key), message, format!("give {key} fewer numbers"));
            return false;
        }
        let Some(index) = values.iter().position(|value| !range.values().contains(value)) else { return true };
        let place = if self.is_list(key) { self.place_of_item(key, index) } else { self.place_of(key) };
        let (least, most, found) = (range.least, range.most, values[index]);
        let message = format!("{key} must be from {least} to {most}, found {found}");
        self.report(Code::OUT_OF_RANGE, place, message, format!("check the unit of {key} in {}", self.title));
        false
    }

    fn is_list(&self, key: &str) -> bool {
        matches!(self.table.entry(key), Some(TomlEntry { item: TomlItem { value: TomlValue::Items(_), .. }, .. }))
    }

    /// Checks that a text shows its true content; reports one with control characters or changes of text direction.
    fn is_readable(&mut self, key: &str, text: &str) -> bool {
        let Some(found) = text.chars().find(|&character| is_deceptive(character)) else { return true };
        let message = format!(
            "{key} contains the control character U+{:04X}, which is not displayed as written",
            u32::from(found)
        );
        let help = format!("write {key} in {} with letters, digits and signs", self.title);
        self.report(Code::DECEPTIVE_NAME, self.place_of(key), message, help);
        false
    }

    fn title_of(&self, key: &str) -> String {
        match self.title.strip_prefix('[').and_then(|title| title.strip_suffix(']')) {
            // The entry of a list has two brackets, its subsection one.
            Some(title) => format!("[{}.{key}]", title.trim_start_matches('[').trim_end_matches(']')),
            None => format!("[{key}]"),
        }
    }

    pub(super) fn value<T>(
        &mut self,
        key: &str,
        expected: &str,
        read: impl FnOnce(&'a TomlItem) -> Option<T>,
    ) -> Option<T> {
        self.accept(key);
        let item = &self.table.entry(key)?.item;
        let value = read(item);
        if value.is_none() {
            let message = format!("{key} must be {expected}, found {}", item.found());
            let place = Place { file: self.file, span: item.span };
            self.report(Code::BAD_VALUE, place, message, format!("give {key} in {} as {expected}", self.title));
        }
        value
    }

    /// Reports unknown keys and adds all diagnostics to `findings`.
    pub fn finish(mut self, findings: &mut Vec<Diagnostic>) {
        let table = self.table;
        let mut asked: HashSet<&str> = HashSet::new();
        let known: Vec<&str> = self.asked.iter().map(String::as_str).filter(|key| asked.insert(key)).collect();
        let unknown = table.entries.iter().filter(|entry| !asked.contains(entry.key.as_str()));
        for entry in unknown.take(MOST_UNKNOWN) {
            // A value without its unit is meant to act, so it is not to be removed.
            let with_unit = format!("{}_", entry.key);
            let meant = known.iter().find(|key| key.starts_with(&with_unit)).copied();
            let home = super::origin::home_of(&entry.key, &self.title);
            let help = match meant.or_else(|| nearest(&entry.key, known.iter().copied())) {
                _ if home.is_some() => format!("move it to {}", home.unwrap_or_default()),
                Some(known) => format!("did you mean `{known}`?"),
                None if known.is_empty() => "remove it".into(),
                None => format!("remove it; known here: {}", known.join(", ")),
            };
            let message = format!("unknown key {} in {}", entry.key, self.title);
            let place = Place { file: self.file, span: entry.key_span };
            self.findings.push(Diagnostic::at(Code::UNKNOWN_KEY, place, message, help));
        }
        findings.append(&mut self.findings);
    }
}

/// True for a date such as `2026-11-27`.
fn is_date(text: &str) -> bool {
    let numbers: Option<Vec<u32>> = text.split('-').map(|part| part.parse().ok()).collect();
    let has_form =
        text.bytes().enumerate().all(|(at, byte)| (at == 4 || at == 7) == (byte == b'-')) && text.len() == 10;
    has_form && matches!(numbers.as_deref(), Some([_, 1..=12, 1..=31]))
}

/// Returns the candidate that begins with the word, or that differs from it only by case or by at most a third of its letters (two at most) added, removed or
/// changed.
#[must_use]
pub fn nearest<'c>(word: &str, candidates: impl Iterator<Item = &'c str>) -> Option<&'c str> {
    candidates
        .map(|candidate| (strsim::levenshtein(&word.to_lowercase(), &candidate.to_lowercase()), candidate))
        .filter(|&(distance, candidate)| {
            let begins = word.len() >= 4 && candidate.starts_with(word);
            begins || distance <= (candidate.len() / 3).min(2)
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::super::document::Document;
    use super::*;
    use ncfix_base::source::Source;

    #[test]
    fn values_are_read_and_wrong_ones_reported_at_their_place() {
        let bytes = b"[a]\nx = 1_000\ny = \"q\"\nv = [1, 2.5, 0x10]\nn = nan\nextra = 1\n".to_vec();
        let document = Document::parse(&Source::new(FileId(3), "m.toml", bytes).unwrap()).unwrap();
        let mut root = document.root();
        let mut section = root.section("a").unwrap();
        assert_eq!(section.number("x"), Some(1000.0));
        assert_eq!(section.text("y"), Some("q"));
        assert_eq!(section.vector("v"), Some(Vector::new(1.0, 2.5, 16.0)));
        assert_eq!(section.number("n"), None);
        assert_eq!(section.required("z", "1.0", Section::number), None);
        assert_eq!(section.number("w"), None);
        let mut findings = Vec::new();
        section.finish(&mut findings);
        let seen: Vec<_> = findings.iter().map(|f| (f.code.as_str(), f.place.unwrap().span.range())).collect();
        assert_eq!(seen, [("E0404", 45..48), ("E0403", 0..3), ("E0402", 49..54)]);
    }

    #[test]
    fn near_misses_are_named() {
        let known = ["travel_mm", "direction", "point_mm"];
        assert_eq!(nearest("travel_nm", known.into_iter()), Some("travel_mm"));
        assert_eq!(nearest("Direction", known.into_iter()), Some("direction"));
        assert_eq!(nearest("travel", known.into_iter()), Some("travel_mm"));
        assert_eq!(nearest("lever", known.into_iter()), None);
    }
}
