//! The dialect of Grundig and Philips CNC432/532 and Heidenhain MillPlus: its code table and file marks.

use std::sync::LazyLock;

use super::{CodeTable, Dialect, Language, begins, behind_number};

static CODES: LazyLock<CodeTable> =
    LazyLock::new(|| CodeTable::from_tsv(include_str!("../../../grammars/grundig-codes.tsv")));

pub(super) const GRUNDIG: Dialect = Dialect {
    language: Language::Grundig,
    name: "grundig",
    title: "Grundig / Philips / Heidenhain MillPlus",
    extensions: &["pm", "mm"],
    tells,
    is_executable: true,
    codes: || &CODES,
};

/// `%PM` and the other memories, a first line such as `N9001 (NAME)`, a value behind `=` that begins with an E parameter.
fn tells(line: &[u8]) -> bool {
    const MEMORIES: &[&str] = &["PM", "MM", "TM", "ZO", "ZE", "PO", "PA", "PL", "MC"];
    if let [b'%', rest @ ..] = line {
        let rest = rest.trim_ascii_start();
        let behind = rest.get(2).copied().unwrap_or(b' ');
        return MEMORIES.iter().any(|name| begins(rest, name)) && !behind.is_ascii_alphabetic() && behind != b'_';
    }
    let is_number = matches!(line, [b'N' | b'n', b'9', b'0'..=b'9', b'0'..=b'9', b'0'..=b'9', ..]);
    if is_number && matches!(behind_number(line, b'N'), Some([] | [b'(', ..])) {
        return true;
    }
    // X=E1, E3=E1+5: no other language has parameters of this name.
    let numbered = behind_number(line, b'N').unwrap_or_default();
    numbered.windows(3).any(|three| matches!(three, [b'=', b'E' | b'e', b'0'..=b'9']))
}
