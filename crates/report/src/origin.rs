//! Origins of the values of a machine: for people, and as JSON.

use std::fmt::Write as _;

use serde::Serialize;

/// Maximum width of a value in characters; longer ones, such as error tables, are shortened.
const WIDEST_VALUE: usize = 32;

/// Value and its origin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OriginRow {
    /// Keys from the top of the file: `axis.X.travel_mm`.
    pub path: String,
    /// Value as written, with the unit of the key.
    pub value: String,
    /// `file:line`; only the file if the line is unknown; or `default`.
    pub origin: String,
}

/// File, and how it was found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OriginFile {
    /// Kind of the file.
    pub what: OriginFileKind,
    /// Path.
    pub file: String,
    /// Source of its path: an option, a variable, a place.
    pub found: String,
}

/// Kind of a file with values of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum OriginFileKind {
    /// Machine file.
    #[serde(rename = "machine file")]
    Machine,
    /// Set-up file.
    #[serde(rename = "set-up file")]
    SetUp,
    /// Compensation tables that are active in the control.
    #[serde(rename = "tables")]
    Tables,
}

impl OriginFileKind {
    /// Returns its name as in JSON.
    fn word(self) -> &'static str {
        match self {
            OriginFileKind::Machine => "machine file",
            OriginFileKind::SetUp => "set-up file",
            OriginFileKind::Tables => "tables",
        }
    }
}

/// All values of a machine.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Origins {
    /// Files in the order in which they were applied.
    pub files: Vec<OriginFile>,
    /// Resulting values.
    pub values: Vec<OriginRow>,
}

impl Origins {
    /// Returns the page.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        for OriginFile { what, file, found } in &self.files {
            let _ = writeln!(out, "{:<13}{file} ({found})", what.word());
        }
        let width = |of: fn(&OriginRow) -> usize| self.values.iter().map(of).max().unwrap_or(0);
        let path = width(|row| row.path.chars().count());
        let value = width(|row| row.value.chars().count()).min(WIDEST_VALUE);
        let mut before = "";
        for row in &self.values {
            let section = row.path.split(['.', '[']).next().unwrap_or_default();
            if section != before {
                out.push('\n');
                before = section;
            }
            let _ = writeln!(out, "{:<path$}  {:<value$}  {}", row.path, shortened(&row.value), row.origin);
        }
        out
    }
}

/// Shortens a value to fit its column.
fn shortened(value: &str) -> String {
    if value.chars().count() <= WIDEST_VALUE {
        return value.to_owned();
    }
    value.chars().take(WIDEST_VALUE - 2).chain(" …".chars()).collect()
}
