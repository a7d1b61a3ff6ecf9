//! Programs of the Sinumerik: named variables, expressions, statements, sections of an archive.

mod block;
mod call;
mod definition;
mod expression;
mod jump;
mod macros;
mod pages;
mod section;
mod statement;
mod structure;
mod sync_action;
mod token;
mod tree;

pub use super::names::{NameId, Names};
pub use call::{CallKind, CallStatement, Callee, Parameter};
pub use definition::{Definition, DefinitionType};
pub use jump::{Jump, JumpTarget, Repetition, Search};
pub use macros::Macros;
pub use tree::{
    Address, ArgumentRange, Block, BlockNumber, Body, DimensionFunction, Expr, ExprId, Node, Operator, Program,
    Section, UnaryOperator, Value, Word,
};

use super::{LARGE_BYTES, PAGE_BYTES, checked, nothing_done};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::Source;
use ncfix_dialect::Dialect;

/// Parses a program. Never fails: unreadable text is reported and skipped, and parsing continues in the next block.
#[must_use]
pub fn parse(source: &Source, dialect: &'static Dialect) -> (Program, Vec<Diagnostic>) {
    parse_with(source, dialect, &Macros::default())
}

/// Parses a program with these macros in addition to its own.
#[must_use]
pub fn parse_with(source: &Source, dialect: &'static Dialect, macros: &Macros) -> (Program, Vec<Diagnostic>) {
    if source.bytes().len() >= LARGE_BYTES
        && let Some((program, findings)) = pages::parse(source, dialect, macros, PAGE_BYTES)
    {
        return (program, checked(findings, source, dialect));
    }
    whole(source, dialect, macros)
}

/// Parses a program of any size by pages of `page_bytes`; `None` if it must be kept as a whole.
#[must_use]
pub fn parse_by_pages(source: &Source, dialect: &'static Dialect, page_bytes: usize) -> Option<Program> {
    pages::parse(source, dialect, &Macros::default(), page_bytes).map(|(program, _)| program)
}

/// Parses a program and keeps the whole tree.
fn whole(source: &Source, dialect: &'static Dialect, macros: &Macros) -> (Program, Vec<Diagnostic>) {
    let mut parser = block::Parser::new(source.clone(), dialect, macros.clone());
    parser.run();
    let (mut program, mut findings) = parser.finish();
    structure::connect(&mut program, &mut findings);
    let is_empty = program.blocks.iter().all(|block| matches!(block.body, Body::Empty | Body::Faulty));
    if is_empty && findings.is_empty() {
        findings.push(nothing_done(source));
    }
    (program, checked(findings, source, dialect))
}
