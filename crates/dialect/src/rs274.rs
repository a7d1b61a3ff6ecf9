//! The RS274/NGC dialect of LinuxCNC: its code table and file marks.

use std::sync::LazyLock;

use super::{CodeTable, Dialect, Language, begins, behind_number};

static CODES: LazyLock<CodeTable> =
    LazyLock::new(|| CodeTable::from_tsv(include_str!("../../../grammars/rs274-codes.tsv")));

pub(super) const RS274: Dialect = Dialect {
    language: Language::Rs274,
    name: "rs274",
    title: "RS274/NGC (LinuxCNC)",
    extensions: &["ngc"],
    tells,
    is_executable: true,
    codes: || &CODES,
};

/// O-words, named parameters, active comments.
fn tells(line: &[u8]) -> bool {
    const O_WORDS: &[&str] = &["sub", "endsub", "call", "return", "if", "while", "do", "repeat", "else", "end"];
    if begins(line, "o<") || begins(line, "(debug,") || begins(line, "(print,") || begins(line, "(logopen,") {
        return true;
    }
    if let Some(rest) = behind_number(line, b'O') {
        return O_WORDS.iter().any(|word| begins(rest, word));
    }
    !line.starts_with(b"(") && !line.starts_with(b";") && line.windows(2).any(|two| two == b"#<")
}
