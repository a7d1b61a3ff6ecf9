//! Programs of the word languages: letters with values, as used by Grundig, Fanuc and RS274/NGC.
//!
//! One tree and one parser for all of them; differences depend on [`ncfix_dialect::Language`]. A file is a list of parts (programs, macros, tables),
//! a part a list of blocks, a block a list of words or one statement.

mod comment;
mod expression;
mod header;
mod node;
mod pages;
mod parser;
mod statement;
mod structure;
mod token;
mod tree;
mod word;

pub use crate::syntax::names::{NameId, Names};
pub use node::{Expr, ExprId, Function, Node, Operator, UnaryOperator};
pub use tree::{
    Address, Block, Body, Comment, CommentKind, InnerSkip, Label, Part, PartKind, Program, Slice, Value, Word,
};

use super::{LARGE_BYTES, PAGE_BYTES, checked, nothing_done};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::Source;
use ncfix_dialect::Dialect;

/// Parses a program. Never fails: unreadable text is reported and skipped, and parsing continues in the next block.
#[must_use]
pub fn parse(source: &Source, dialect: &'static Dialect) -> (Program, Vec<Diagnostic>) {
    let source = without_parity(source);
    if source.bytes().len() >= LARGE_BYTES
        && let Some((program, findings)) = pages::parse(&source, dialect, PAGE_BYTES)
    {
        return (program, checked(findings, &source, dialect));
    }
    whole(&source, dialect)
}

/// Parses a program of any size by pages of `page_bytes`; `None` if it must be kept as a whole.
#[must_use]
pub fn parse_by_pages(source: &Source, dialect: &'static Dialect, page_bytes: usize) -> Option<Program> {
    pages::parse(&without_parity(source), dialect, page_bytes).map(|(program, _)| program)
}

/// Parses a program and keeps the whole tree.
fn whole(source: &Source, dialect: &'static Dialect) -> (Program, Vec<Diagnostic>) {
    let mut parser = parser::Parser::new(source.clone(), dialect);
    parser.run();
    let (mut program, mut findings) = parser.finish();
    structure::list_targets(&mut program);
    structure::connect(&mut program, &mut findings);
    let is_empty = program.blocks.iter().all(|block| matches!(block.body, Body::Empty | Body::Faulty));
    if is_empty && findings.is_empty() {
        findings.push(nothing_done(source));
    }
    (program, checked(findings, source, dialect))
}

/// The file with seven-bit bytes, if a serial line has added parity bits.
fn without_parity(source: &Source) -> Source {
    if !header::has_parity(source.bytes()) {
        return source.clone();
    }
    let bytes = source.bytes().iter().map(|byte| byte & 0x7f).collect();
    Source::new(source.id(), source.name(), bytes).unwrap_or_else(|_| source.clone())
}
