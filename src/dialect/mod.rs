//! Dialects as values: a code table, file extensions and switches. No parser functions, no execution.

mod code;
mod sinumerik;

pub use code::{CodeEntry, CodeTable, Effect};

use std::sync::LazyLock;

/// The language of a dialect: what its parser and its execution ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// Sinumerik.
    Sinumerik,
    /// Grundig, Philips, MillPlus.
    Grundig,
    /// Fanuc with custom macros.
    Fanuc,
    /// RS274/NGC.
    Rs274,
}

/// A control's language.
pub struct Dialect {
    /// Which language it is.
    pub language: Language,
    /// The name used on the command line and in machine files.
    pub name: &'static str,
    /// What people call it.
    pub title: &'static str,
    /// File extensions, lower case.
    pub extensions: &'static [&'static str],
    /// Texts at the start of a line that give the dialect away.
    pub tells: &'static [&'static str],
    /// Whether programs of this dialect can be executed yet.
    pub is_executable: bool,
    codes: &'static LazyLock<CodeTable>,
}

impl Dialect {
    /// G codes and words without a value.
    #[must_use]
    pub fn codes(&self) -> &'static CodeTable {
        self.codes
    }
}

impl std::fmt::Debug for Dialect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

static NO_CODES: LazyLock<CodeTable> = LazyLock::new(CodeTable::default);

/// The register of dialects.
pub static DIALECTS: &[Dialect] = &[
    sinumerik::SINUMERIK,
    Dialect {
        language: Language::Grundig,
        name: "grundig",
        title: "Grundig / Philips / Heidenhain MillPlus",
        extensions: &["pm", "mm"],
        tells: &["%PM", "%MM"],
        is_executable: false,
        codes: &NO_CODES,
    },
    Dialect {
        language: Language::Fanuc,
        name: "fanuc",
        title: "Fanuc and its kin",
        extensions: &["eia", "fan"],
        tells: &["O0", "O1", "O2", "O3", "O4", "O5", "O6", "O7", "O8", "O9"],
        is_executable: false,
        codes: &NO_CODES,
    },
    Dialect {
        language: Language::Rs274,
        name: "rs274",
        title: "RS274/NGC (LinuxCNC)",
        extensions: &["ngc"],
        tells: &["O<", "o<", "#<"],
        is_executable: false,
        codes: &NO_CODES,
    },
];

/// The Sinumerik dialect.
#[must_use]
pub fn sinumerik() -> &'static Dialect {
    &DIALECTS[0]
}

/// The dialect of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Dialect> {
    DIALECTS.iter().find(|dialect| dialect.name.eq_ignore_ascii_case(name))
}

/// Guesses from the file's name, then from its first kilobytes.
#[must_use]
pub fn guess(file_name: &str, bytes: &[u8]) -> Option<&'static Dialect> {
    let extension = file_name.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
    let by_name = extension.and_then(|e| DIALECTS.iter().find(|dialect| dialect.extensions.contains(&e.as_str())));
    by_name.or_else(|| {
        let head = &bytes[..bytes.len().min(8192)];
        head.split(|&b| b == b'\n').find_map(|line| {
            let line = line.trim_ascii_start();
            DIALECTS.iter().find(|dialect| dialect.tells.iter().any(|tell| line.starts_with(tell.as_bytes())))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_goes_before_content() {
        assert_eq!(guess("a.MPF", b"").map(|d| d.name), Some("sinumerik"));
        assert_eq!(guess("a.nc", b"%\r\nO1234 (X)\r\n").map(|d| d.name), Some("fanuc"));
        assert_eq!(guess("a.nc", b"\n%_N_X_MPF\n").map(|d| d.name), Some("sinumerik"));
        assert_eq!(guess("a.nc", b"%PM9001\n").map(|d| d.name), Some("grundig"));
        assert!(guess("a.nc", b"G0 X1").is_none());
    }
}
