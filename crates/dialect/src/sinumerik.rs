//! Dialect of Sinumerik 840D / 828D: its code table and file marks.

use std::sync::LazyLock;

use super::{BlockEnds, CodeTable, Dialect, Language};

static CODES: LazyLock<CodeTable> =
    LazyLock::new(|| CodeTable::from_tsv(include_str!(concat!(env!("NCFIX_GRAMMARS"), "/sinumerik-codes.tsv"))));

pub(super) const SINUMERIK: Dialect = Dialect {
    language: Language::Sinumerik,
    name: "sinumerik",
    title: "Siemens Sinumerik 840D / 828D",
    extensions: &["mpf", "spf", "arc"],
    mark: MARK,
    first_mark: None,
    is_executable: true,
    block_ends: BlockEnds {
        exact: "G60",
        running: "G64",
        once: Some("G9"),
        group: &["G60", "G64", "G641", "G642", "G643", "G644", "G645"],
    },
    codes: || &CODES,
};

/// `%_N_FLANGE_MPF`, `;$PATH=/_N_MPF_DIR`: headers of programs.
const MARK: &str = r"^(?:%_N_|;\$PATH)";
