//! `DEF` blocks: modifiers, types, arrays, initial values.

use nom::Parser as _;
use nom::combinator::{cond, map_opt, opt};
use nom::multi::many0_count;
use nom::sequence::{preceded, terminated};

use super::block::Parser;
use super::token::{Input, Parsed, blank, blanks, byte, fault, identifier, required};
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
    /// Lengths of an array; empty for a single value.
    pub dimensions: ArgumentRange,
    /// `true` if all programs see it (`DEF CHAN`, `DEF NCK`).
    pub is_global: bool,
    /// Initial value; a list is a call of `SET` or `REP`.
    pub value: Option<ExprId>,
}

impl Parser {
    /// Production `def`: `DEF {modifier} TYPE {modifier} name [= value] {, name [= value]}`
    pub(super) fn define<'a>(&mut self, input: Input<'a>, rest: Input<'a>) -> Parsed<'a, Body> {
        const MESSAGE: &str = "a type was expected after DEF: INT, REAL, BOOL, CHAR, STRING, AXIS or FRAME";
        let start = self.program.definitions.next();
        let mut rest = blanks(rest);
        let mut is_global = false;
        let kind = loop {
            rest = self.modifiers(rest)?.0;
            let Ok((behind, word)) = terminated(identifier, blank).parse(rest) else {
                return fault(Code::UNEXPECTED, input, 3, MESSAGE);
            };
            rest = behind;
            match DefinitionType::from_word(word) {
                Some(kind) => break kind,
                None => is_global |= word.eq_ignore_ascii_case(b"CHAN") || word.eq_ignore_ascii_case(b"NCK"),
            }
        };
        let (behind, length) = self.string_length(rest, kind)?;
        let (mut rest, ()) = self.modifiers(behind)?;
        loop {
            rest = self.declarator(rest, (kind, length, is_global))?.0;
            match byte(b',')(rest) {
                Ok((behind, _)) => rest = behind,
                Err(_) => break,
            }
        }
        let count = u16::try_from(self.program.definitions.next() - start).unwrap_or(u16::MAX);
        Ok((rest, Body::Define { start: u32::try_from(start).unwrap_or(u32::MAX), count }))
    }

    /// Production `declarator`: a name, its dimensions and its initial value.
    fn declarator<'a>(
        &mut self,
        input: Input<'a>,
        (kind, length, is_global): (DefinitionType, Option<ExprId>, bool),
    ) -> Parsed<'a, ()> {
        let at = blanks(input);
        let message = "the name of a variable was expected here";
        let (rest, name) = terminated(required(identifier, Code::UNEXPECTED, 1, message), blank).parse(at)?;
        let id = self.intern(name);
        let (rest, dimensions) = self.index(rest)?;
        let dimensions = dimensions.unwrap_or_default();
        let (rest, ()) = self.modifiers(rest)?;
        let is_array = dimensions != ArgumentRange::default();
        let initial = |input| if is_array { self.value_list(input) } else { self.expression(input) };
        let (rest, value) = opt(terminated(preceded(byte(b'='), initial), blank)).parse(rest)?;
        let span = Span::new(self.offset(at), self.offset(at) + name.len());
        self.program.definitions.push(Definition { span, kind, name: id, length, dimensions, is_global, value });
        Ok((rest, ()))
    }

    /// Skips modifiers, with the numbers that belong to them.
    fn modifiers<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let modifiers = many0_count(preceded(blank, |input| self.modifier(input)));
        terminated(modifiers, blank).map(|_| ()).parse(input)
    }

    /// Production `modifier` except CHAN and NCK: access rights, physical unit, limits with a value, and others. They have no effect on the value.
    fn modifier<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let row =
            |word: &[u8]| words().find(&String::from_utf8_lossy(word).to_ascii_uppercase(), WordPlace::Definition);
        let (rest, row) = map_opt(identifier, row).parse(input)?;
        cond(row.arguments != "-", |input| self.expression(input)).map(|_| ()).parse(rest)
    }

    /// Production `list`: `(1,2,3)`, `SET(1,2)`, `REP(0)` or one expression.
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

impl DefinitionType {
    /// Production `type`.
    pub(super) fn parse(input: Input<'_>) -> Parsed<'_, DefinitionType> {
        map_opt(identifier, DefinitionType::from_word).parse(input)
    }

    /// Converts a type name to a type.
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
