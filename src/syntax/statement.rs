//! Statements that need a block of their own: control structures, jumps, DEF, PROC.

use super::block::{Draft, Parser};
use super::expression::{keyword, target_number};
use super::jump::{Jump, JumpTarget, Search};
use super::token::{Input, Parsed, blanks, fault, identifier};
use super::tree::{BlockNumber, Body, ExprId};
use crate::diagnostic::Code;
use crate::source::Span;

/// Statements that are known and not executed yet; the rest of their block is not read.
const NOT_YET: &[&str] = &[
    "CASE", "CALL", "CALLPATH", "PCALL", "ISOCALL", "EXTCALL", "MCALL", "REPEATB", "EXTERN", "DEFINE", "ID", "IDS",
    "WHEN", "WHENEVER", "EVERY", "FROM", "DO", "REDEF", "PROC_DEF",
];

impl Parser {
    /// Reads a statement, or says that there is none at this place.
    pub(super) fn statement<'a>(&mut self, input: Input<'a>, draft: &mut Draft) -> Option<Parsed<'a, Body>> {
        let (rest, name) = identifier(input).ok()?;
        let simple = |body| Some(Ok((rest, body)));
        match name.to_ascii_uppercase().as_slice() {
            b"ELSE" => simple(Body::Else),
            b"ENDIF" => simple(Body::EndIf),
            b"LOOP" => simple(Body::Loop),
            b"ENDLOOP" => simple(Body::EndLoop),
            b"ENDFOR" => simple(Body::EndFor),
            b"ENDWHILE" => simple(Body::EndWhile),
            b"IF" => Some(self.if_statement(input, rest)),
            b"WHILE" => Some(self.expression(rest).map(|(rest, id)| (rest, Body::While(id)))),
            b"UNTIL" => Some(self.expression(rest).map(|(rest, id)| (rest, Body::Until(id)))),
            b"FOR" => Some(self.for_statement(rest)),
            b"REPEAT" => Some(match blanks(rest).first() {
                None | Some(b';') => Ok((rest, Body::Repeat)),
                Some(_) => self.unsupported(input, rest, draft),
            }),
            b"GOTO" | b"GOTOF" | b"GOTOB" | b"GOTOC" | b"GOTOS" => Some(self.jumps(input, None)),
            b"DEF" => Some(self.define(input, rest)),
            b"PROC" => Some(self.proc(rest, draft)),
            upper => {
                NOT_YET.iter().any(|known| known.as_bytes() == upper).then(|| self.unsupported(input, rest, draft))
            }
        }
    }

    /// Takes the rest of the block as it is; the execution will say that it is not supported.
    fn unsupported<'a>(&mut self, input: Input<'a>, rest: Input<'a>, draft: &mut Draft) -> Parsed<'a, Body> {
        let span = Span::new(self.offset(input), self.offset(rest));
        let comment = rest.iter().position(|&byte| byte == b';');
        let end = &rest[comment.unwrap_or(rest.len())..];
        if comment.is_some() {
            self.comment(end, draft);
        }
        Ok((&rest[rest.len()..], Body::Unsupported(span)))
    }

    fn if_statement<'a>(&mut self, input: Input<'a>, rest: Input<'a>) -> Parsed<'a, Body> {
        let (rest, condition) = self.expression(rest)?;
        match blanks(rest).first() {
            None | Some(b';') => Ok((rest, Body::If(condition))),
            Some(_) if starts_jump(blanks(rest)) => self.jumps(input, Some((rest, condition))),
            Some(_) => {
                fault(Code::UNEXPECTED, blanks(rest), 1, "GOTOF, GOTOB, GOTO or the end of the block was expected here")
            }
        }
    }

    /// `[IF condition] GOTOx target` once or more; a condition that was read already comes with what is behind it.
    fn jumps<'a>(&mut self, input: Input<'a>, first: Option<(Input<'a>, ExprId)>) -> Parsed<'a, Body> {
        let start = self.program.jumps.len();
        let (mut rest, mut condition) = match first {
            Some((rest, condition)) => (rest, Some(condition)),
            None => (input, None),
        };
        loop {
            rest = self.jump(blanks(rest), condition)?.0;
            let next = blanks(rest);
            if let Some(behind) = keyword("IF", next) {
                let (behind, id) = self.expression(behind)?;
                condition = Some(id);
                rest = behind;
            } else if starts_jump(next) {
                condition = None;
            } else {
                break;
            }
        }
        let count = u16::try_from(self.program.jumps.len() - start).unwrap_or(u16::MAX);
        Ok((rest, Body::Jumps { start: u32::try_from(start).unwrap_or(u32::MAX), count }))
    }

    fn jump<'a>(&mut self, input: Input<'a>, condition: Option<ExprId>) -> Parsed<'a, ()> {
        let searches = [
            ("GOTOF", Search::Forward),
            ("GOTOB", Search::Backward),
            ("GOTOC", Search::AroundIfAny),
            ("GOTOS", Search::Start),
            ("GOTO", Search::Around),
        ];
        let Some((rest, search)) = searches.iter().find_map(|&(word, search)| Some((keyword(word, input)?, search)))
        else {
            return fault(Code::UNEXPECTED, input, 1, "GOTOF, GOTOB or GOTO was expected here");
        };
        let at = blanks(rest);
        let (rest, target) = if search == Search::Start {
            (rest, JumpTarget::Start)
        } else if let Some((rest, main, number)) = target_number(at) {
            (rest, JumpTarget::Number(BlockNumber { main, number }))
        } else if at.first().is_some_and(|&byte| matches!(byte, b'"' | b'(' | b'<')) {
            let (rest, _) = self.expression(at)?;
            (rest, JumpTarget::Computed)
        } else {
            match identifier(at) {
                Ok((rest, name)) => (rest, JumpTarget::Label(self.intern(name))),
                Err(_) => {
                    return fault(Code::UNEXPECTED, at, 1, "a label or block number was expected behind the jump");
                }
            }
        };
        let span = Span::new(self.offset(input), self.offset(rest));
        self.program.jumps.push(Jump { span, condition, search, target });
        Ok((rest, ()))
    }

    /// `FOR variable = from TO to`
    fn for_statement<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Body> {
        let (rest, variable) = self.left_side(blanks(input))?;
        let rest = blanks(rest);
        if rest.first() != Some(&b'=') {
            return fault(Code::UNEXPECTED, rest, 1, "'=' was expected behind the variable of FOR");
        }
        let (rest, from) = self.expression(&rest[1..])?;
        let Some(rest) = keyword("TO", blanks(rest)) else {
            return fault(Code::UNEXPECTED, blanks(rest), 1, "TO was expected behind the start value of FOR");
        };
        let (rest, to) = self.expression(rest)?;
        Ok((rest, Body::For { variable, from, to }))
    }

    /// `PROC NAME[(parameters)] {attributes}`
    fn proc<'a>(&mut self, input: Input<'a>, draft: &mut Draft) -> Parsed<'a, Body> {
        let at = blanks(input);
        let Ok((rest, name)) = identifier(at) else {
            return fault(Code::UNEXPECTED, at, 1, "the name of the program was expected behind PROC");
        };
        let name = self.intern(name);
        let mut rest = blanks(rest);
        let mut parameters = None;
        if rest.first() == Some(&b'(') {
            let Some(length) = rest.iter().position(|&byte| byte == b')') else {
                return fault(Code::UNCLOSED, rest, 1, "this bracket is not closed in the block");
            };
            if rest[1..length].iter().any(|&byte| !byte.is_ascii_whitespace()) {
                parameters = Some(Span::new(self.offset(rest), self.offset(rest) + length + 1));
            }
            rest = &rest[length + 1..];
        }
        let mut save = None;
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
            if word.eq_ignore_ascii_case(b"SAVE") {
                save = Some(Span::new(self.offset(rest), self.offset(behind)));
            }
            rest = behind;
        }
        Ok((rest, Body::Proc { name, parameters, save }))
    }
}

fn starts_jump(input: Input<'_>) -> bool {
    ["GOTOF", "GOTOB", "GOTOC", "GOTOS", "GOTO"].iter().any(|word| keyword(word, input).is_some())
}
