//! `DEF` blocks: modifiers, types, arrays, initial values.

use super::block::Parser;
use super::token::{Input, Parsed, blanks, fault, identifier};
use super::tree::{ArgumentRange, Body, ExprId, Node};
use crate::syntax::names::NameId;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::{WordPlace, words};

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are the types' names")]
pub enum DefinitionType {
    Int,
    Real,
    Bool,
    Char,
    String,
    Axis,
    Frame,
}

/// A variable of a DEF block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Definition {
    /// Name and initial value.
    pub span: Span,
    /// Type.
    pub kind: DefinitionType,
    /// Name.
    pub name: NameId,
    /// `n` of `STRING[n]`.
    pub length: Option<ExprId>,
    /// Lengths of an array; none for a single value.
    pub dimensions: ArgumentRange,
    /// Whether all programs see it (`DEF CHAN`, `DEF NCK`).
    pub is_global: bool,
    /// Initial value; a list is a call of `SET` or `REP`.
    pub value: Option<ExprId>,
}

impl Parser {
    /// `DEF {modifier} TYPE {modifier} name [= value] {, name [= value]}`
    pub(super) fn define<'a>(&mut self, input: Input<'a>, rest: Input<'a>) -> Parsed<'a, Body> {
        let start = self.program.definitions.next();
        let mut rest = blanks(rest);
        let mut is_global = false;
        let kind = loop {
            rest = self.modifiers(rest)?;
            let Ok((behind, word)) = identifier(rest) else {
                return fault(
                    Code::UNEXPECTED,
                    input,
                    3,
                    "a type was expected behind DEF: INT, REAL, BOOL, CHAR, STRING, AXIS or FRAME",
                );
            };
            rest = blanks(behind);
            match DefinitionType::from_word(word) {
                Some(kind) => break kind,
                None if word.eq_ignore_ascii_case(b"CHAN") || word.eq_ignore_ascii_case(b"NCK") => is_global = true,
                None => {}
            }
        };
        let mut length = None;
        if kind == DefinitionType::String && rest.first() == Some(&b'[') {
            let (behind, range) = self.arguments(rest, b']')?;
            length = self.program.arguments_of(range).first().copied().flatten();
            rest = blanks(behind);
        }
        rest = self.modifiers(rest)?;
        loop {
            let at = blanks(rest);
            let Ok((behind, name)) = identifier(at) else {
                return fault(Code::UNEXPECTED, at, 1, "the name of a variable was expected here");
            };
            let id = self.intern(name);
            let mut next = blanks(behind);
            let mut dimensions = ArgumentRange::default();
            if next.first() == Some(&b'[') {
                let (behind, range) = self.arguments(next, b']')?;
                dimensions = range;
                next = blanks(behind);
            }
            next = self.modifiers(next)?;
            let mut value = None;
            if next.first() == Some(&b'=') {
                let is_array = dimensions != ArgumentRange::default();
                let (behind, id) = if is_array { self.value_list(&next[1..])? } else { self.expression(&next[1..])? };
                value = Some(id);
                next = blanks(behind);
            }
            let span = Span::new(self.offset(at), self.offset(at) + name.len());
            self.program.definitions.push(Definition { span, kind, name: id, length, dimensions, is_global, value });
            rest = next;
            match rest.first() {
                Some(b',') => rest = &rest[1..],
                _ => break,
            }
        }
        let count = u16::try_from(self.program.definitions.next() - start).unwrap_or(u16::MAX);
        Ok((rest, Body::Define { start: u32::try_from(start).unwrap_or(u32::MAX), count }))
    }

    /// Skips modifiers, with the numbers that belong to them.
    fn modifiers<'a>(&mut self, input: Input<'a>) -> Skipped<'a> {
        let mut rest = blanks(input);
        while let Ok((behind, word)) = identifier(rest) {
            let upper = String::from_utf8_lossy(word).to_ascii_uppercase();
            let Some(row) = words().find(&upper, WordPlace::Definition) else { break };
            let behind = if row.arguments == "-" { behind } else { self.expression(behind)?.0 };
            rest = blanks(behind);
        }
        Ok(rest)
    }

    /// `(1,2,3)`, `SET(1,2)`, `REP(0)` or one expression.
    pub(super) fn value_list<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let at = blanks(input);
        if at.first() == Some(&b'(') {
            let (rest, range) = self.arguments(at, b')')?;
            let set = self.intern(b"SET");
            return Ok((rest, self.push_between(at, rest, Node::Call(set, range))));
        }
        self.expression(at)
    }
}

/// The rest of the line, or a fault.
type Skipped<'a> = Result<Input<'a>, nom::Err<super::token::Fault>>;

impl DefinitionType {
    /// The type that a word names.
    pub(super) fn from_word(word: &[u8]) -> Option<DefinitionType> {
        Some(match word.to_ascii_uppercase().as_slice() {
            b"INT" => DefinitionType::Int,
            b"REAL" => DefinitionType::Real,
            b"BOOL" => DefinitionType::Bool,
            b"CHAR" => DefinitionType::Char,
            b"STRING" => DefinitionType::String,
            b"AXIS" => DefinitionType::Axis,
            b"FRAME" => DefinitionType::Frame,
            _ => return None,
        })
    }
}
