//! `DEF` blocks: types, arrays, initial values.

use super::block::Parser;
use super::token::{Input, Parsed, blanks, fault, identifier};
use super::tree::{Body, Definition, DefinitionType, ExprId};
use crate::diagnostic::Code;
use crate::source::Span;

impl Parser {
    /// `DEF [modifiers] TYPE name [= value] {, name [= value]}`
    pub(super) fn define<'a>(&mut self, input: Input<'a>, rest: Input<'a>) -> Parsed<'a, Body> {
        let start = self.program.definitions.len();
        let mut rest = blanks(rest);
        let kind = loop {
            let Ok((behind, word)) = identifier(rest) else {
                return fault(
                    Code::UNEXPECTED,
                    input,
                    3,
                    "a type was expected behind DEF: INT, REAL, BOOL, CHAR, STRING, AXIS or FRAME",
                );
            };
            rest = blanks(behind);
            match word.to_ascii_uppercase().as_slice() {
                b"INT" => break DefinitionType::Int,
                b"REAL" => break DefinitionType::Real,
                b"BOOL" => break DefinitionType::Bool,
                b"CHAR" => break DefinitionType::Char,
                b"STRING" => break DefinitionType::String,
                b"AXIS" => break DefinitionType::Axis,
                b"FRAME" => break DefinitionType::Frame,
                _ => {}
            }
        };
        if kind == DefinitionType::String && rest.first() == Some(&b'[') {
            rest = blanks(self.arguments(rest, b']')?.0);
        }
        loop {
            let at = blanks(rest);
            let Ok((behind, name)) = identifier(at) else {
                return fault(Code::UNEXPECTED, at, 1, "the name of a variable was expected here");
            };
            let id = self.intern(name);
            let mut next = blanks(behind);
            let mut is_array = false;
            if next.first() == Some(&b'[') {
                is_array = true;
                next = blanks(self.arguments(next, b']')?.0);
            }
            let mut value = None;
            if next.first() == Some(&b'=') {
                let (behind, id) = if is_array { self.value_list(&next[1..])? } else { self.expression(&next[1..])? };
                value = Some(id);
                next = blanks(behind);
            }
            let span = Span::new(self.offset(at), self.offset(at) + name.len());
            self.program.definitions.push(Definition { span, kind, name: id, is_array, value });
            rest = next;
            match rest.first() {
                Some(b',') => rest = &rest[1..],
                _ => break,
            }
        }
        let count = u16::try_from(self.program.definitions.len() - start).unwrap_or(u16::MAX);
        Ok((rest, Body::Define { start: u32::try_from(start).unwrap_or(u32::MAX), count }))
    }

    /// `(1,2,3)`, `SET(1,2)`, `REP(0)` or one expression.
    fn value_list<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let at = blanks(input);
        if at.first() == Some(&b'(') {
            let (rest, _) = self.arguments(at, b')')?;
            return Ok((rest, self.nothing(at, rest)));
        }
        self.expression(at)
    }
}
