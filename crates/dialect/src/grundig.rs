//! Dialect of Grundig and Philips CNC432/532 and Heidenhain MillPlus: its code table and file marks.

use std::sync::LazyLock;

use super::{BlockEnds, CodeTable, Dialect, Language};

static CODES: LazyLock<CodeTable> =
    LazyLock::new(|| CodeTable::from_tsv(include_str!(concat!(env!("NCFIX_GRAMMARS"), "/grundig-codes.tsv"))));

pub(super) const GRUNDIG: Dialect = Dialect {
    language: Language::Grundig,
    name: "grundig",
    title: "Grundig / Philips / Heidenhain MillPlus",
    extensions: &["pm", "mm"],
    mark: MARK,
    first_mark: Some(FIRST_MARK),
    is_executable: true,
    block_ends: BlockEnds::NONE,
    codes: || &CODES,
};

/// `%PM` and the other memories; a value after `=` that begins with an E parameter, `N20 X=E1+3`: no other language has
/// parameters of this name.
const MARK: &str = r"^(?:%\s*(?:PM|MM|TM|ZO|ZE|PO|PA|PL|MC)(?:[^A-Z_]|$)|N\s*[0-9]+.*=E[0-9])";
/// `N9001 (NAME)`: further down, other languages have such block numbers.
const FIRST_MARK: &str = r"^N9[0-9]{3,}\s*(?:\(|$)";
