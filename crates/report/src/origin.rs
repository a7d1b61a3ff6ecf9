//! Where the values of a machine come from: for people, and as JSON.

use std::fmt::Write as _;

use serde::Serialize;

/// Columns of a value; longer ones, such as tables of errors, are cut.
const WIDEST_VALUE: usize = 32;

/// A value and its origin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OriginRow {
    /// Keys from the top of the file: `axis.X.travel_mm`.
    pub path: String,
    /// As it is written, units as in the key.
    pub value: String,
    /// `file:line`, the file alone where the line cannot be told, or `default`.
    pub origin: String,
}

/// A file and how it was found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OriginFile {
    /// What it is.
    pub what: OriginFileKind,
    /// Its path.
    pub file: String,
    /// How it was found: an option, a variable, a place.
    pub found: String,
}

/// What a file with values of a machine is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum OriginFileKind {
    /// The machine file.
    #[serde(rename = "machine file")]
    Machine,
    /// A set-up file.
    #[serde(rename = "set-up file")]
    SetUp,
    /// Compensation tables that are active in the control.
    #[serde(rename = "tables")]
    Tables,
}

impl OriginFileKind {
    /// As JSON has it.
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
    /// The files, in the order in which they were laid over each other.
    pub files: Vec<OriginFile>,
    /// The values that hold in the end.
    pub values: Vec<OriginRow>,
}

impl Origins {
    /// The page.
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

/// A value that fits its column.
fn shortened(value: &str) -> String {
    if value.chars().count() <= WIDEST_VALUE {
        return value.to_owned();
    }
    value.chars().take(WIDEST_VALUE - 2).chain(" …".chars()).collect()
}
