//! Files that a result comes from.

use serde::Serialize;

/// A file that the result comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Input {
    /// Its name.
    pub file: String,
    /// What it is: `machine`, `readings`, `description`, `readings, held out` …
    pub role: &'static str,
    /// The beginning of the SHA-256 of its bytes with their length in front, as in the head of a machine file.
    pub hash: String,
}
