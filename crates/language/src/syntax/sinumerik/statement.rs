//! Statements that need a block of their own: control structures, jumps, DEF, PROC.

use super::block::{Draft, Parser};
use super::expression::{keyword, target_number};
use super::jump::{Jump, JumpTarget, Repetition, Search};
use super::macros::definition;
use super::token::{Input, Parsed, blanks, fault, identifier};
use super::tree::{BlockNumber, Body, ExprId};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::{WordPlace, words};

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
                Some(_) => self.repetition(input, rest, false),
            }),
            b"REPEATB" => Some(self.repetition(input, rest, true)),
            b"CASE" => Some(self.case(rest)),
            word @ (b"MCALL" | b"CALL" | b"PCALL" | b"EXTCALL" | b"CALLPATH") => {
                Some(self.call_statement(input, word, rest))
            }
            b"DEFINE" if definition(input).is_none() => {
                Some(fault(Code::UNEXPECTED, input, 6, "a macro is written DEFINE NAME AS and its text"))
            }
            b"DEFINE" | b"REDEF" | b"EXTERN" => {
                Some(self.skipped(rest, draft).map(|(rest, ())| (rest, Body::Declaration)))
            }
            b"GOTO" | b"GOTOF" | b"GOTOB" | b"GOTOC" | b"GOTOS" => Some(self.jumps(input, None)),
            b"DEF" => Some(self.define(input, rest)),
            b"ID" | b"IDS" | b"WHEN" | b"WHENEVER" | b"EVERY" | b"FROM" | b"DO" => {
                Some(self.synchronised(input, draft))
            }
            b"PROC" => Some(self.proc(rest, draft)),
            // Known and not executed yet; the rest of the block is not read.
            upper => {
                let row = words().find(std::str::from_utf8(upper).ok()?, WordPlace::Statement);
                row.is_some().then(|| self.unsupported(input, rest, draft))
            }
        }
    }

    /// Takes the rest of the block as it is; the execution will say that it is not supported.
    fn unsupported<'a>(&mut self, input: Input<'a>, rest: Input<'a>, draft: &mut Draft) -> Parsed<'a, Body> {
        let span = Span::new(self.offset(input), self.offset(rest));
        self.skipped(rest, draft).map(|(rest, ())| (rest, Body::Unsupported(span)))
    }

    /// The rest of the block, of which only the comment is kept.
    fn skipped<'a>(&mut self, rest: Input<'a>, draft: &mut Draft) -> Parsed<'a, ()> {
        let mut in_text = false;
        let comment = rest.iter().position(|&byte| {
            in_text ^= byte == b'"';
            byte == b';' && !in_text
        });
        let end = &rest[comment.unwrap_or(rest.len())..];
        if comment.is_some() {
            self.comment(end, draft);
        }
        Ok((&rest[rest.len()..], ()))
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
        let (rest, target) =
            if search == Search::Start { (rest, JumpTarget::Start) } else { self.jump_target(blanks(rest))? };
        let span = Span::new(self.offset(input), self.offset(rest));
        self.program.jumps.push(Jump { span, condition, search, target });
        Ok((rest, ()))
    }

    /// A label, a block number, or an expression that makes one of them.
    pub(super) fn jump_target<'a>(&mut self, at: Input<'a>) -> Parsed<'a, JumpTarget> {
        if let Some((rest, main, number)) = target_number(at) {
            return Ok((rest, JumpTarget::Number(BlockNumber { main, number })));
        }
        match identifier(at) {
            Ok((rest, name)) if !blanks(rest).starts_with(b"<<") && !rest.starts_with(b"[") => {
                Ok((rest, JumpTarget::Label(self.intern(name))))
            }
            Err(_) if !at.first().is_some_and(|&byte| matches!(byte, b'"' | b'(' | b'<')) => {
                fault(Code::UNEXPECTED, at, 1, "a label or block number was expected here")
            }
            _ => self.expression(at).map(|(rest, id)| (rest, JumpTarget::Computed(id))),
        }
    }

    /// `CASE expression OF {constant GOTOx target} [DEFAULT GOTOx target]`: jumps, each with its comparison.
    fn case<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Body> {
        let start = self.program.jumps.len();
        let (rest, selector) = self.expression(input)?;
        let Some(mut rest) = keyword("OF", blanks(rest)) else {
            return fault(Code::UNEXPECTED, blanks(rest), 1, "OF was expected behind the expression of CASE");
        };
        loop {
            rest = blanks(rest);
            let mut condition = None;
            match keyword("DEFAULT", rest) {
                Some(behind) => rest = behind,
                None if matches!(rest.first(), None | Some(b';')) => break,
                None => {
                    let (behind, constant) = self.expression(rest)?;
                    condition = Some(self.comparison(selector, constant));
                    rest = behind;
                }
            }
            rest = self.jump(blanks(rest), condition)?.0;
        }
        let count = u16::try_from(self.program.jumps.len() - start).unwrap_or(u16::MAX);
        Ok((rest, Body::Jumps { start: u32::try_from(start).unwrap_or(u32::MAX), count }))
    }

    /// `REPEAT label [label] [P=n]`, `REPEATB label [P=n]`
    fn repetition<'a>(&mut self, input: Input<'a>, rest: Input<'a>, one_block: bool) -> Parsed<'a, Body> {
        let (mut rest, first) = self.jump_target(blanks(rest))?;
        let (mut behind, mut count) = self.count(rest)?;
        let mut last = None;
        if count.is_none() && !one_block && !matches!(blanks(rest).first(), None | Some(b';')) {
            let (next, target) = self.jump_target(blanks(rest))?;
            (rest, last) = (next, Some(target));
            (behind, count) = self.count(rest)?;
        }
        let span = Span::new(self.offset(input), self.offset(rest));
        let place = u32::try_from(self.program.repetitions.len()).unwrap_or(u32::MAX);
        self.program.repetitions.push(Repetition { span, first, last, one_block, count });
        Ok((behind, Body::RepeatPart(place)))
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
}

fn starts_jump(input: Input<'_>) -> bool {
    ["GOTOF", "GOTOB", "GOTOC", "GOTOS", "GOTO"].iter().any(|word| keyword(word, input).is_some())
}
