//! Input files of a result.

use serde::Serialize;

/// Input file of a result.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InputFile {
    /// File name.
    pub file: String,
    /// Role: `machine`, `readings`, `description`, `readings, held out` …
    pub role: &'static str,
    /// First digits of the SHA-256 of the length and the bytes of the file, as in the head of a machine file.
    pub hash: String,
}
