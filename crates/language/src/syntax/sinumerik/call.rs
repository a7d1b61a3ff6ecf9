//! Parameters of subprograms, and the statements that call other programs.

use nom::Parser as _;
use nom::bytes::complete::{tag, take_while1};
use nom::combinator::{cond, map, opt, peek, value};
use nom::sequence::{preceded, terminated};

use super::block::Parser;
use super::definition::DefinitionType;
use super::jump::JumpTarget;
use super::token::{
    Input, Parsed, behind_blanks, blank, blanks, byte, fault, identifier, is_blank, is_end, keyword, one, required,
};
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
    /// Value if the caller passes none.
    pub default: Option<ExprId>,
}

/// A statement that calls another program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CallStatement {
    /// From the keyword to the end of the name.
    pub span: Span,
    /// Kind of the statement.
    pub kind: CallKind,
    /// The called program; `None` for the running one, or if MCALL ends a modal call.
    pub callee: Option<Callee>,
    /// `(…)` after the name.
    pub arguments: Option<ArgumentRange>,
    /// `P`: number of repetitions.
    pub repeats: Option<ExprId>,
    /// `BLOCK from TO to`.
    pub part: Option<(JumpTarget, JumpTarget)>,
}

/// The statements that call other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CallKind {
    /// `MCALL`: after each block with motion.
    Modal,
    /// `CALL`, `PCALL`, `EXTCALL`: immediately.
    Now,
    /// `CALLPATH`: adds a folder to the search, without a call.
    Path,
}

/// The called program.
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
    /// Production `statement_call`: `MCALL [NAME [(…)]]`, `CALL …`, `PCALL …`, `EXTCALL …`, `CALLPATH(…)`; `word` is the keyword, `rest` the text
    /// after it.
    pub(super) fn call_statement<'a>(&mut self, input: Input<'a>, word: &[u8], rest: Input<'a>) -> Parsed<'a, Body> {
        let kind = match word {
            b"MCALL" => CallKind::Modal,
            b"CALLPATH" => CallKind::Path,
            _ => CallKind::Now,
        };
        let at = blanks(rest);
        let (mut rest, callee) = match word {
            b"MCALL" if is_end(at, b";") => (at, None),
            b"CALL" if keyword("BLOCK")(at).is_ok() => (at, None),
            b"CALLPATH" if at.starts_with(b"()") => value(None, tag("()")).parse(at)?,
            b"MCALL" => self.name_of_program(at)?,
            b"PCALL" if at.first() != Some(&b'"') => self.path_of_program(at)?,
            _ => map(|input| self.expression(input), |id| Some(Callee::Computed(id))).parse(at)?,
        };
        let span = Span::new(self.offset(input), self.offset(rest));
        let mut arguments = None;
        if blanks(rest).first() == Some(&b'(') && matches!(word, b"MCALL" | b"PCALL") {
            (rest, arguments) = map(|input| self.arguments(input, b')'), Some).parse(blanks(rest))?;
        }
        let mut part = None;
        if word == b"CALL"
            && let Ok((behind, ())) = behind_blanks(keyword("BLOCK")).parse(rest)
        {
            let message = "TO was expected after the first label of BLOCK";
            let to = (blank, required(keyword("TO"), Code::UNEXPECTED, 1, message), blank);
            let (behind, first) = preceded(blank, terminated(|input| self.jump_target(input), to)).parse(behind)?;
            let (behind, last) = self.jump_target(behind)?;
            (rest, part) = (behind, Some((first, last)));
        }
        let (rest, repeats) = self.count(rest)?;
        let place = u32::try_from(self.program.calls.len()).unwrap_or(u32::MAX);
        self.program.calls.push(CallStatement { span, kind, callee, arguments, repeats, part });
        Ok((rest, Body::Call(place)))
    }

    /// `NAME`, `L10`
    fn name_of_program<'a>(&mut self, at: Input<'a>) -> Parsed<'a, Option<Callee>> {
        let name = required(identifier, Code::UNEXPECTED, 1, "the name of a program was expected here");
        map(name, |name| Some(Callee::Name(self.intern(name)))).parse(at)
    }

    /// Production `path`: `/_N_WKS_DIR/_N_X_WPD/NAME`, everything up to a blank or bracket.
    fn path_of_program<'a>(&mut self, at: Input<'a>) -> Parsed<'a, Option<Callee>> {
        let path = take_while1(|byte| !is_blank(byte) && !b"(;".contains(&byte));
        let (rest, path) = required(path, Code::UNEXPECTED, 1, "the path of a program was expected here")(at)?;
        let start = self.offset(at);
        Ok((rest, Some(Callee::Path(Span::new(start, start + path.len())))))
    }

    /// Production `count`: `P3`, `P 3`, `P=…`, the number of repetitions.
    pub(super) fn count<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Option<ExprId>> {
        let letter = (blank, one(|byte| byte.eq_ignore_ascii_case(&b'P')), blank);
        let start = (letter, peek(one(|byte| byte == b'=' || byte.is_ascii_digit())), opt(byte(b'=')));
        opt(preceded(start, |input| self.expression(input))).parse(input)
    }

    /// Production `proc`: `PROC NAME[(parameters)] {attributes}`
    pub(super) fn proc<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Body> {
        let message = "the name of the program was expected after PROC";
        let name = (blank, required(identifier, Code::UNEXPECTED, 1, message), blank);
        let (mut rest, name) = map(name, |(_, name, _)| self.intern(name)).parse(input)?;
        let first = self.program.parameters.len();
        if rest.first() == Some(&b'(') {
            let open = rest;
            rest = blanks(&rest[1..]);
            while rest.first() != Some(&b')') {
                rest = blanks(self.parameter(rest)?.0);
                match rest.first() {
                    Some(b',') => rest = blanks(&rest[1..]),
                    Some(b')') => {}
                    Some(_) => return fault(Code::UNEXPECTED, rest, 1, "',' or ')' was expected after the parameter"),
                    None => return fault(Code::UNCLOSED, open, 1, "this bracket is not closed in the block"),
                }
            }
            rest = &rest[1..];
        }
        let mut save = false;
        loop {
            rest = blanks(rest);
            if is_end(rest, b";") {
                break;
            }
            let message = "an attribute such as SAVE or DISPLOF was expected here";
            let (behind, word) = required(identifier, Code::UNEXPECTED, 1, message)(rest)?;
            save |= word.eq_ignore_ascii_case(b"SAVE");
            rest = behind;
        }
        let count = u16::try_from(self.program.parameters.len() - first).unwrap_or(u16::MAX);
        let start = u32::try_from(first).unwrap_or(u32::MAX);
        Ok((rest, Body::Proc { name, start, count, save }))
    }

    /// Production `parameter`: `[VAR] TYPE[length] NAME[dimensions] [= default]`
    fn parameter<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let (at, by_reference) = terminated(opt(keyword("VAR")), blank).parse(input)?;
        let message = "a type was expected here: INT, REAL, BOOL, CHAR, STRING, AXIS or FRAME";
        let kind = required(DefinitionType::parse, Code::UNEXPECTED, 1, message);
        let (rest, kind) = terminated(kind, blank).parse(at)?;
        let (rest, length) = self.string_length(rest, kind)?;
        let message = "the name of a parameter was expected here";
        let name = terminated(required(identifier, Code::UNEXPECTED, 1, message), blank);
        let (rest, name) = map(name, |name| self.intern(name)).parse(rest)?;
        let (rest, range) = self.index(rest)?;
        let dimensions = range.map_or(0, |range| self.program.arguments_of(range).len().max(1));
        let dimensions = u8::try_from(dimensions).unwrap_or(u8::MAX);
        let (rest, default) = opt(preceded(byte(b'='), |input| self.expression(input))).parse(rest)?;
        let span = Span::new(self.offset(input), self.offset(rest));
        let by_reference = by_reference.is_some();
        let parameter = Parameter { span, by_reference, kind, length, name, dimensions, default };
        self.program.parameters.push(parameter);
        Ok((rest, ()))
    }

    /// `[5]` after STRING, and blanks.
    pub(super) fn string_length<'a>(&mut self, input: Input<'a>, kind: DefinitionType) -> Parsed<'a, Option<ExprId>> {
        let (rest, range) = cond(kind == DefinitionType::String, |input| self.index(input)).parse(input)?;
        let first = range.flatten().and_then(|range| self.program.arguments_of(range).first().copied().flatten());
        Ok((rest, first))
    }

    /// `[…]` if one begins here, and blanks.
    pub(super) fn index<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Option<ArgumentRange>> {
        let arguments = preceded(peek(byte(b'[')), |input| self.arguments(input, b']'));
        opt(terminated(arguments, blank)).parse(input)
    }
}
