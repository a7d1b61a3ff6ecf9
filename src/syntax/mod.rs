//! What was written: a syntax tree whose nodes carry spans, and the parser that never fails.
//!
//! A program is a list of sections (the files of an archive), a section a list of blocks, a block a list of words or one
//! statement. The tree says nothing of what a code means. Nodes live in flat arenas and refer to each other by number, so
//! that a block of plain words costs no allocation of its own.

mod block;
mod call;
mod definition;
mod expression;
mod jump;
mod macros;
mod names;
mod statement;
mod structure;
mod sync_action;
mod token;
mod tree;

pub use call::{CallKind, CallStatement, Callee, Parameter};
pub use jump::{Jump, JumpTarget, Repetition, Search};
pub use macros::Macros;
pub use names::{NameId, Names};
pub use tree::{
    Address, ArgumentRange, Block, BlockNumber, Body, Definition, DefinitionType, DimensionFunction, Expr, ExprId,
    Node, Operator, Program, Section, UnaryOperator, Value, Word,
};

use crate::diagnostic::{Code, Diagnostic, Place};
use crate::dialect::Dialect;
use crate::source::{Source, Span};

/// At most this many findings are kept of one file; a file with more is no part program.
const MAX_FINDINGS: usize = 1000;

/// Parses a program. Never fails: what cannot be read is reported and left out, and parsing goes on in the next block.
#[must_use]
pub fn parse(source: &Source, dialect: &'static Dialect) -> (Program, Vec<Diagnostic>) {
    parse_with(source, dialect, &Macros::default())
}

/// Parses a program in which these macros hold, beside its own.
#[must_use]
pub fn parse_with(source: &Source, dialect: &'static Dialect, macros: &Macros) -> (Program, Vec<Diagnostic>) {
    let mut parser = block::Parser::new(source.clone(), dialect, macros.clone());
    parser.run();
    let (mut program, mut findings) = parser.finish();
    structure::connect(&mut program, &mut findings);
    if program.blocks.iter().all(|block| matches!(block.body, Body::Empty | Body::Faulty)) {
        let place = Place { file: source.id(), span: Span::new(0, source.bytes().len().min(1)) };
        if findings.is_empty() {
            findings.push(Diagnostic::at(
                Code::NOT_A_PROGRAM,
                place,
                "the file has no block that does anything",
                "check that this is the part program and not an empty or truncated copy",
            ));
        }
    }
    if findings.len() > MAX_FINDINGS {
        findings.truncate(MAX_FINDINGS);
        findings.insert(
            0,
            Diagnostic::at(
                Code::NOT_A_PROGRAM,
                Place { file: source.id(), span: Span::new(0, source.bytes().len().min(1)) },
                format!("more than {MAX_FINDINGS} blocks cannot be read; the file is no {} program", dialect.title),
                "check --dialect and that the file is a part program",
            ),
        );
    }
    (program, findings)
}
