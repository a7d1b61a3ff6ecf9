//! The Sinumerik 840D / 828D dialect: its code table and file marks.

use std::sync::LazyLock;

use super::{CodeTable, Dialect, Language, begins};

static CODES: LazyLock<CodeTable> =
    LazyLock::new(|| CodeTable::from_tsv(include_str!("../../../grammars/sinumerik-codes.tsv")));

pub(super) const SINUMERIK: Dialect = Dialect {
    language: Language::Sinumerik,
    name: "sinumerik",
    title: "Siemens Sinumerik 840D / 828D",
    extensions: &["mpf", "spf", "arc"],
    tells: |line| begins(line, "%_N_") || begins(line, ";$PATH"),
    is_executable: true,
    codes: || &CODES,
};
