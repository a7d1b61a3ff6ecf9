//! Dialect RS274/NGC of LinuxCNC: its code table and file marks.

use std::sync::LazyLock;

use super::{BlockEnds, CodeTable, Dialect, Language};

static CODES: LazyLock<CodeTable> =
    LazyLock::new(|| CodeTable::from_tsv(include_str!(concat!(env!("NCFIX_GRAMMARS"), "/rs274-codes.tsv"))));

pub(super) const RS274: Dialect = Dialect {
    language: Language::Rs274,
    name: "rs274",
    title: "RS274/NGC (LinuxCNC)",
    extensions: &["ngc", "gcode"],
    mark: MARK,
    first_mark: None,
    is_executable: true,
    block_ends: BlockEnds { exact: "G61.1", running: "G61", once: None, group: &["G61", "G61.1", "G64"] },
    codes: || &CODES,
};

/// `o<name> call`, `o100 sub`; active comments, `(debug, #1)`; named parameters outside comments, `x#<depth>`. A line with an O-number is recognized only by
/// its O-word.
const MARK: &str = r"^(?:o<|\((?:debug|print|logopen),|o\s*[0-9]+\s*(?:sub|endsub|call|return|if|while|do|repeat|else|end)|#<|(?:[^(;o]|o\s*[^0-9\s]).*#<|o\s*#<)";
