//! Lines of text as they arrive: CSV after its header, JSON objects, `name=value`, or a single number.
//!
//! The format follows from the line itself. A reader that begins in the middle of a CSV stream has no header and does not guess the columns.

use std::time::SystemTime;

use serde_json::Value;

use ncfix_base::csv::Table;
use ncfix_base::source::{FileId, Source};

use super::monitor::{ChannelFault, SourceReport};
use super::stamp::stamp;

/// Maximum length of a reading, bytes.
pub(super) const LONGEST_LINE: usize = 1 << 16;
/// Names of the time stamp of the readings of a line.
const TIMES: [&str; 3] = ["time", "timestamp", "ts"];

/// Callback for a channel: its reading and the time when it was read.
pub(super) type Tell<'a> = dyn FnMut(usize, SourceReport, Option<SystemTime>) + 'a;

/// Reads lines.
#[derive(Clone, Debug)]
pub struct LineReader {
    /// Names of the channels in the lines.
    items: Vec<(String, usize)>,
    header: Option<String>,
    /// Column names none of which is that of a channel: a number after them belongs to another sensor, or is in another unit.
    foreign: Option<String>,
    /// True if times in the lines are used.
    has_times: bool,
}

impl LineReader {
    /// Creates a reader for lines that contain channels under these names.
    #[must_use]
    pub fn new(items: &[(String, usize)], has_times: bool) -> LineReader {
        LineReader { items: items.to_vec(), header: None, foreign: None, has_times }
    }

    /// Forgets the header: it follows again.
    pub fn forget_header(&mut self) {
        (self.header, self.foreign) = (None, None);
    }

    /// Reads a line.
    pub fn read(&mut self, bytes: &[u8], tell: &mut Tell<'_>) {
        let text = String::from_utf8_lossy(bytes);
        let line = text.trim_start_matches('\u{feff}').trim();
        if line.is_empty() || line.starts_with('#') {
        } else if bytes.len() > LONGEST_LINE {
            self.fail("a line has no end", tell);
        } else if line.starts_with('{') || line.starts_with('[') {
            match serde_json::from_str::<Value>(line) {
                Ok(object) => self.object(&object, tell),
                Err(_) => self.fail("a line begins like JSON but is not valid JSON", tell),
            }
        } else if self.header.is_none() && line.contains('=') {
            self.pairs(line, tell);
        } else if self.header.is_none() && line.parse::<f64>().is_ok() {
            self.alone(line, tell);
        } else {
            self.row(line, tell);
        }
    }

    /// Reports a line that cannot be interpreted for all channels.
    fn fail(&self, why: &str, tell: &mut Tell<'_>) {
        for (_, channel) in &self.items {
            tell(*channel, SourceReport::Nothing(ChannelFault::Invalid, why.to_owned()), None);
        }
    }

    fn stamp(&self, find: impl Fn(&str) -> Option<String>) -> Option<SystemTime> {
        TIMES.iter().filter(|_| self.has_times).find_map(|name| find(name)).and_then(|text| stamp(&text))
    }

    fn object(&self, object: &Value, tell: &mut Tell<'_>) {
        let stamp = self.stamp(|name| object.get(name).map(plain));
        for (item, channel) in &self.items {
            if let Some(value) = inside(object, item) {
                tell(*channel, told(&plain(value)), stamp);
            }
        }
    }

    fn pairs(&self, line: &str, tell: &mut Tell<'_>) {
        let is_between = |character: char| character.is_whitespace() || matches!(character, ',' | ';');
        let pairs: Vec<(&str, &str)> = line.split(is_between).filter_map(|word| word.split_once('=')).collect();
        let find = |name: &str| pairs.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned());
        let is_twice = |name: &str| pairs.iter().filter(|(known, _)| *known == name).count() > 1;
        let stamp = self.stamp(find);
        for (item, channel) in &self.items {
            if is_twice(item) {
                let why = format!("a line has two values of {item}");
                tell(*channel, SourceReport::Nothing(ChannelFault::Invalid, why), stamp);
            } else if let Some(value) = find(item) {
                tell(*channel, told(&value), stamp);
            }
        }
    }

    /// Reads a single number, which is that of the only channel.
    fn alone(&self, line: &str, tell: &mut Tell<'_>) {
        if let Some(names) = &self.foreign {
            return self.fail(&format!("no column of '{names}' has the name of the channel: state it with item"), tell);
        }
        match self.items.as_slice() {
            [(_, channel)] => tell(*channel, told(line), None),
            _ => self.fail("a single number, and several possible channels", tell),
        }
    }

    fn row(&mut self, line: &str, tell: &mut Tell<'_>) {
        let is_sign = |byte: u8| matches!(byte, b',' | b';' | b'\t');
        let cells: Vec<&str> =
            line.split(|character: char| u8::try_from(character).is_ok_and(is_sign)).map(str::trim).collect();
        let is_known = |cell: &&str| self.items.iter().any(|(item, _)| is_column_of(cell.trim_matches('"'), item));
        if cells.iter().any(is_known) {
            self.header = Some(line.to_owned());
            return;
        }
        let Some(header) = &self.header else {
            if cells.iter().all(|cell| is_name(cell)) {
                self.foreign = Some(shortened(line));
            }
            return self.fail("there are no column names, or none of them is the name of a channel", tell);
        };
        let text = format!("{header}\n{line}\n").into_bytes();
        let table = Source::new(FileId(0), "row", text).ok().and_then(|source| Table::read(&source).0);
        let Some(row) = table.as_ref().and_then(|table| table.rows().next().map(|row| (table, row))) else {
            return self.fail("a row and the line of names have different numbers of columns", tell);
        };
        let (table, row) = row;
        let cell = |column: usize| String::from_utf8_lossy(row.text(column)).into_owned();
        let stamp = self.stamp(|name| table.column(name).map(cell));
        for (item, channel) in &self.items {
            let column = table.names().iter().position(|name| is_column_of(name, item));
            let Some(text) = column.map(cell).filter(|text| !text.trim().is_empty()) else { continue };
            // If commas do not separate cells, they are decimal separators.
            let is_comma = table.separator() != b',' && !text.contains('.');
            tell(*channel, told(&if is_comma { text.replace(',', ".") } else { text }), stamp);
        }
    }
}

/// True if a cell is a column name, such as `T_head_F` or `"bed (F)"`, and not a sentence such as `sensor 3 is ready`.
fn is_name(cell: &str) -> bool {
    let cell = cell.trim_matches('"');
    cell.starts_with(char::is_alphabetic) && cell.split_whitespace().count() <= 2 && !cell.ends_with(['.', ':', '!'])
}

/// True if a column belongs to an item: by its name, or with the suffix `_C` as in logs.
fn is_column_of(name: &str, item: &str) -> bool {
    name == item || name.strip_suffix("_C") == Some(item)
}

/// Finds a value in an object by its key, or by keys separated by dots.
pub(super) fn inside<'v>(object: &'v Value, item: &str) -> Option<&'v Value> {
    object.get(item).or_else(|| {
        item.split('.').try_fold(object, |value, key| match value {
            Value::Array(items) => items.get(key.parse::<usize>().ok()?),
            _ => value.get(key),
        })
    })
}

/// Returns a text without its quotation marks, any other value as JSON.
pub(super) fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// Interprets a text as the value of a channel.
pub(super) fn told(text: &str) -> SourceReport {
    let text = text.trim().trim_matches('"');
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => SourceReport::Value(value),
        _ => SourceReport::Nothing(ChannelFault::Invalid, format!("'{}' is not a number", shortened(text))),
    }
}

/// Returns the first 40 characters of a text.
pub(super) fn shortened(text: &str) -> String {
    let clean: String =
        text.chars().map(|character| if character.is_control() { ' ' } else { character }).take(41).collect();
    if clean.chars().count() > 40 { clean.chars().take(40).chain(['…']).collect() } else { clean }
}

/// Collects whole lines from bytes as they arrive.
#[derive(Debug, Default)]
pub(super) struct Splitter(Vec<u8>);

impl Splitter {
    /// Takes bytes; bytes after the last line end wait for more.
    pub(super) fn take(&mut self, bytes: &[u8], each: &mut dyn FnMut(&[u8])) {
        for part in bytes.split_inclusive(|&byte| byte == b'\n') {
            // One byte more than the maximum shows that the line was too long.
            let room = (LONGEST_LINE + 1).saturating_sub(self.0.len());
            self.0.extend(part.iter().take(room));
            if part.ends_with(b"\n") {
                each(&self.0);
                self.0.clear();
            }
        }
    }

    /// Discards the waiting bytes.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}
