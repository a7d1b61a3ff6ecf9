//! The dialect of Fanuc and the controls that follow it: its code table and file marks.

use std::sync::LazyLock;

use super::{CodeTable, Dialect, Language, begins, behind_number};

static CODES: LazyLock<CodeTable> =
    LazyLock::new(|| CodeTable::from_tsv(include_str!("../../../grammars/fanuc-codes.tsv")));

pub(super) const FANUC: Dialect = Dialect {
    language: Language::Fanuc,
    name: "fanuc",
    title: "Fanuc and its kin",
    extensions: &["eia", "fan"],
    tells,
    is_executable: true,
    codes: || &CODES,
};

/// `O1234 (NAME)`, `%O1234`, `:1234`, a control statement of a custom macro.
fn tells(line: &[u8]) -> bool {
    let line = line.strip_prefix(b"%").unwrap_or(line).trim_ascii_start();
    if let Some(rest) = behind_number(line, b'O').or_else(|| behind_number(line, b':')) {
        // `:10 G0 X1` is a main block of other controls.
        return line.first() != Some(&b':') || matches!(rest, [] | [b'(', ..]);
    }
    let line = behind_number(line, b'N').unwrap_or(line);
    let dense = |word: &str| begins(line, word) && line[word.len()..].trim_ascii_start().first() == Some(&b'[');
    (dense("IF") || dense("WHILE")) && line.contains(&b'#')
}
