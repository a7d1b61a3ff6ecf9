//! Dialect of Fanuc and compatible controls: its code table and file marks.

use std::sync::LazyLock;

use super::{BlockEnds, CodeTable, Dialect, Language};

static CODES: LazyLock<CodeTable> =
    LazyLock::new(|| CodeTable::from_tsv(include_str!(concat!(env!("NCFIX_GRAMMARS"), "/fanuc-codes.tsv"))));

pub(super) const FANUC: Dialect = Dialect {
    language: Language::Fanuc,
    name: "fanuc",
    title: "Fanuc and compatible controls",
    extensions: &["eia", "fan"],
    mark: MARK,
    first_mark: None,
    is_executable: true,
    block_ends: BlockEnds {
        exact: "G61",
        running: "G64",
        once: Some("G9"),
        group: &["G61", "G61.1", "G62", "G63", "G64"],
    },
    codes: || &CODES,
};

/// `O1234 (NAME)`, `%O1234`, `:1234` (`:10 G0 X1` is a main block of other controls); also custom macros: `IF[#1EQ2]GOTO10`, `N10 WHILE [#1 LT 5] DO1`.
const MARK: &str = r"^%?\s*(?:O\s*[0-9]|:\s*[0-9]+\s*(?:\(|$)|(?:N\s*[0-9]+\s*)?(?:IF|WHILE)\s*\[.*#)";
