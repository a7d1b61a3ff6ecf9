//! Parameters of subprograms, and the statements that call other programs.

use super::block::{Draft, Parser};
use super::definition::DefinitionType;
use super::expression::keyword;
use super::jump::JumpTarget;
use super::token::{Input, Parsed, blanks, fault, identifier, is_blank};
use super::tree::{ArgumentRange, Body, ExprId};
use crate::syntax::names::NameId;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// A parameter of `PROC`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its declaration.
    pub span: Span,
    /// `VAR`: the caller's variable itself.
    pub by_reference: bool,
    /// Type.
    pub kind: DefinitionType,
    /// Length of a STRING.
    pub length: Option<ExprId>,
    /// Name.
    pub name: NameId,
    /// Number of indices, 0 for a single value.
    pub dimensions: u8,
    /// What it holds where the caller gives nothing.
    pub default: Option<ExprId>,
}

/// A statement that calls another program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CallStatement {
    /// From the keyword to the end of the name.
    pub span: Span,
    /// Which statement.
    pub kind: CallKind,
    /// Which program; `None` for the running one, or where MCALL ends a modal call.
    pub callee: Option<Callee>,
    /// `(…)` behind the name.
    pub arguments: Option<ArgumentRange>,
    /// `P`: how many times.
    pub repeats: Option<ExprId>,
    /// `BLOCK from TO to`.
    pub part: Option<(JumpTarget, JumpTarget)>,
}

/// The statements that call other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CallKind {
    /// `MCALL`: behind each block that moves.
    Modal,
    /// `CALL`, `PCALL`, `EXTCALL`: now.
    Now,
    /// `CALLPATH`: no call, a folder to search.
    Path,
}

/// Which program is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Callee {
    /// By its name.
    Name(NameId),
    /// By a path as written, up to the name.
    Path(Span),
    /// By a computed name.
    Computed(ExprId),
}

impl Parser {
    /// `MCALL [NAME [(…)]]`, `CALL …`, `PCALL …`, `EXTCALL …`, `CALLPATH(…)`; `word` is the keyword, `rest` what follows it.
    pub(super) fn call_statement<'a>(&mut self, input: Input<'a>, word: &[u8], rest: Input<'a>) -> Parsed<'a, Body> {
        let kind = match word {
            b"MCALL" => CallKind::Modal,
            b"CALLPATH" => CallKind::Path,
            _ => CallKind::Now,
        };
        let at = blanks(rest);
        let (mut rest, callee) = match word {
            b"MCALL" if matches!(at.first(), None | Some(b';')) => (at, None),
            b"CALL" if keyword("BLOCK", at).is_some() => (at, None),
            b"CALLPATH" if at.starts_with(b"()") => (&at[2..], None),
            b"MCALL" => self.name_of_program(at)?,
            b"PCALL" if at.first() != Some(&b'"') => self.path_of_program(at)?,
            _ => self.expression(at).map(|(rest, id)| (rest, Some(Callee::Computed(id))))?,
        };
        let span = Span::new(self.offset(input), self.offset(rest));
        let mut arguments = None;
        if blanks(rest).first() == Some(&b'(') && matches!(word, b"MCALL" | b"PCALL") {
            let (behind, range) = self.arguments(blanks(rest), b')')?;
            (rest, arguments) = (behind, Some(range));
        }
        let mut part = None;
        if let (b"CALL", Some(behind)) = (word, keyword("BLOCK", blanks(rest))) {
            let (behind, first) = self.jump_target(blanks(behind))?;
            let Some(behind) = keyword("TO", blanks(behind)) else {
                return fault(Code::UNEXPECTED, blanks(behind), 1, "TO was expected behind the first label of BLOCK");
            };
            let (behind, last) = self.jump_target(blanks(behind))?;
            (rest, part) = (behind, Some((first, last)));
        }
        let (rest, repeats) = self.count(rest)?;
        let place = u32::try_from(self.program.calls.len()).unwrap_or(u32::MAX);
        self.program.calls.push(CallStatement { span, kind, callee, arguments, repeats, part });
        Ok((rest, Body::Call(place)))
    }

    /// `NAME`, `L10`
    fn name_of_program<'a>(&mut self, at: Input<'a>) -> Parsed<'a, Option<Callee>> {
        match identifier(at) {
            Ok((rest, name)) => Ok((rest, Some(Callee::Name(self.intern(name))))),
            Err(_) => fault(Code::UNEXPECTED, at, 1, "the name of a program was expected here"),
        }
    }

    /// `/_N_WKS_DIR/_N_X_WPD/NAME`: everything up to a blank or bracket.
    fn path_of_program<'a>(&mut self, at: Input<'a>) -> Parsed<'a, Option<Callee>> {
        let length = at.iter().take_while(|&&byte| !is_blank(byte) && !b"(;".contains(&byte)).count();
        if length == 0 {
            return fault(Code::UNEXPECTED, at, 1, "the path of a program was expected here");
        }
        let start = self.offset(at);
        Ok((&at[length..], Some(Callee::Path(Span::new(start, start + length)))))
    }

    /// `P3`, `P 3`, `P=…`: how many times.
    pub(super) fn count<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Option<ExprId>> {
        let at = blanks(input);
        let Some(b'P' | b'p') = at.first() else { return Ok((input, None)) };
        let behind = blanks(&at[1..]);
        match behind.first() {
            Some(b'=') => self.expression(&behind[1..]).map(|(rest, id)| (rest, Some(id))),
            Some(byte) if byte.is_ascii_digit() => self.expression(behind).map(|(rest, id)| (rest, Some(id))),
            _ => Ok((input, None)),
        }
    }

    /// `PROC NAME[(parameters)] {attributes}`
    pub(super) fn proc<'a>(&mut self, input: Input<'a>, draft: &mut Draft) -> Parsed<'a, Body> {
        let at = blanks(input);
        let Ok((rest, name)) = identifier(at) else {
            return fault(Code::UNEXPECTED, at, 1, "the name of the program was expected behind PROC");
        };
        let name = self.intern(name);
        let first = self.program.parameters.len();
        let mut rest = blanks(rest);
        if rest.first() == Some(&b'(') {
            let open = rest;
            rest = blanks(&rest[1..]);
            while rest.first() != Some(&b')') {
                rest = blanks(self.parameter(rest)?.0);
                match rest.first() {
                    Some(b',') => rest = blanks(&rest[1..]),
                    Some(b')') => {}
                    Some(_) => return fault(Code::UNEXPECTED, rest, 1, "',' or ')' was expected behind the parameter"),
                    None => return fault(Code::UNCLOSED, open, 1, "this bracket is not closed in the block"),
                }
            }
            rest = &rest[1..];
        }
        let mut save = false;
        loop {
            rest = blanks(rest);
            match rest.first() {
                None => break,
                Some(b';') => {
                    self.comment(rest, draft);
                    rest = &rest[rest.len()..];
                    break;
                }
                Some(_) => {}
            }
            let Ok((behind, word)) = identifier(rest) else {
                return fault(Code::UNEXPECTED, rest, 1, "an attribute such as SAVE or DISPLOF was expected here");
            };
            save |= word.eq_ignore_ascii_case(b"SAVE");
            rest = behind;
        }
        let count = u16::try_from(self.program.parameters.len() - first).unwrap_or(u16::MAX);
        let start = u32::try_from(first).unwrap_or(u32::MAX);
        Ok((rest, Body::Proc { name, start, count, save }))
    }

    /// `[VAR] TYPE[length] NAME[dimensions] [= default]`
    fn parameter<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let by_reference = keyword("VAR", input).is_some();
        let at = blanks(keyword("VAR", input).unwrap_or(input));
        let kind = identifier(at).ok().and_then(|(rest, word)| Some((rest, DefinitionType::from_word(word)?)));
        let Some((rest, kind)) = kind else {
            return fault(
                Code::UNEXPECTED,
                at,
                1,
                "a type was expected here: INT, REAL, BOOL, CHAR, STRING, AXIS or FRAME",
            );
        };
        let mut rest = blanks(rest);
        let mut length = None;
        if kind == DefinitionType::String && rest.first() == Some(&b'[') {
            let (behind, range) = self.arguments(rest, b']')?;
            length = self.program.arguments_of(range).first().copied().flatten();
            rest = blanks(behind);
        }
        let Ok((behind, name)) = identifier(rest) else {
            return fault(Code::UNEXPECTED, rest, 1, "the name of a parameter was expected here");
        };
        let name = self.intern(name);
        rest = blanks(behind);
        let mut dimensions = 0;
        if rest.first() == Some(&b'[') {
            let (behind, range) = self.arguments(rest, b']')?;
            dimensions = u8::try_from(self.program.arguments_of(range).len().max(1)).unwrap_or(u8::MAX);
            rest = blanks(behind);
        }
        let mut default = None;
        if rest.first() == Some(&b'=') {
            let (behind, id) = self.expression(&rest[1..])?;
            (rest, default) = (behind, Some(id));
        }
        let span = Span::new(self.offset(input), self.offset(rest));
        let parameter = Parameter { span, by_reference, kind, length, name, dimensions, default };
        self.program.parameters.push(parameter);
        Ok((rest, ()))
    }
}
