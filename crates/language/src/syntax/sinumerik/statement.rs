//! Statements that need their own block: control structures, jumps, DEF, PROC.

use std::cell::Cell;

use nom::Parser as _;
use nom::branch::alt;
use nom::bytes::complete::{tag, take_till};
use nom::combinator::{map, rest as rest_of_line, value};
use nom::sequence::preceded;

use super::block::{Draft, Parser};
use super::expression::target_number;
use super::jump::{Jump, JumpTarget, Repetition, Search};
use super::macros::definition;
use super::token::{
    Input, Parsed, behind_blanks, blank, blanks, byte, fault, identifier, is_end, keyword, no_match, required,
};
use super::tree::{Body, ExprId};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::{WordPlace, words};

impl Parser {
    /// Production `statement`, determined by its first word.
    ///
    /// Productions `loop`, `while` and `repeat`: the blocks that begin and end them; the two sides are connected later.
    pub(super) fn statement<'a>(&mut self, input: Input<'a>, draft: &mut Draft) -> Parsed<'a, Body> {
        let (rest, name) = identifier(input)?;
        match name.to_ascii_uppercase().as_slice() {
            b"ELSE" => Ok((rest, Body::Else)),
            b"ENDIF" => Ok((rest, Body::EndIf)),
            b"LOOP" => Ok((rest, Body::Loop)),
            b"ENDLOOP" => Ok((rest, Body::EndLoop)),
            b"ENDFOR" => Ok((rest, Body::EndFor)),
            b"ENDWHILE" => Ok((rest, Body::EndWhile)),
            b"IF" => self.if_statement(input, rest),
            b"WHILE" => map(|input| self.expression(input), Body::While).parse(rest),
            b"UNTIL" => map(|input| self.expression(input), Body::Until).parse(rest),
            b"FOR" => self.for_statement(rest),
            b"REPEAT" if is_end(blanks(rest), b";") => Ok((rest, Body::Repeat)),
            b"REPEAT" => self.repetition(input, rest, false),
            b"REPEATB" => self.repetition(input, rest, true),
            b"CASE" => self.case(rest),
            word @ (b"MCALL" | b"CALL" | b"PCALL" | b"EXTCALL" | b"CALLPATH") => self.call_statement(input, word, rest),
            b"DEFINE" if definition(input).is_none() => {
                fault(Code::UNEXPECTED, input, 6, "the form of a macro is DEFINE NAME AS, then its text")
            }
            b"DEFINE" | b"REDEF" | b"EXTERN" => self.declaration(rest, draft),
            b"GOTO" | b"GOTOF" | b"GOTOB" | b"GOTOC" | b"GOTOS" => self.jumps(input, None),
            b"DEF" => self.define(input, rest),
            b"ID" | b"IDS" | b"WHEN" | b"WHENEVER" | b"EVERY" | b"FROM" | b"DO" => self.synchronised(input, draft),
            b"PROC" => self.proc(rest),
            // Known but not executed; the rest of the block is not parsed.
            upper => match std::str::from_utf8(upper).ok().and_then(|word| words().find(word, WordPlace::Statement)) {
                Some(_) => self.unsupported(input, rest, draft),
                None => no_match(input),
            },
        }
    }

    /// Production `extern`: declarations, and macros, whose text [`definition`] reads.
    fn declaration<'a>(&mut self, rest: Input<'a>, draft: &mut Draft) -> Parsed<'a, Body> {
        value(Body::Declaration, |input| self.skipped(input, draft)).parse(rest)
    }

    /// Accepts the rest of the block unparsed; the execution reports it as not supported.
    fn unsupported<'a>(&mut self, input: Input<'a>, rest: Input<'a>, draft: &mut Draft) -> Parsed<'a, Body> {
        let span = Span::new(self.offset(input), self.offset(rest));
        value(Body::Unsupported(span), |input| self.skipped(input, draft)).parse(rest)
    }

    /// Skips the rest of the block except its comment.
    fn skipped<'a>(&mut self, rest: Input<'a>, draft: &mut Draft) -> Parsed<'a, ()> {
        let (comment, _) = before_comment(rest)?;
        if !comment.is_empty() {
            self.comment(comment, draft);
        }
        map(rest_of_line, |_| ()).parse(comment)
    }

    /// Production `if`: IF alone in its block, or before a jump.
    fn if_statement<'a>(&mut self, input: Input<'a>, rest: Input<'a>) -> Parsed<'a, Body> {
        let (rest, condition) = self.expression(rest)?;
        let behind = blanks(rest);
        if is_end(behind, b";") {
            return Ok((rest, Body::If(condition)));
        }
        if search(behind).is_ok() {
            return self.jumps(input, Some((rest, condition)));
        }
        fault(Code::UNEXPECTED, behind, 1, "GOTOF, GOTOB, GOTO or the end of the block was expected here")
    }

    /// Production `jumps`: `[IF condition] GOTOx target` once or more; `first` is a condition that was already read, with the text after it.
    fn jumps<'a>(&mut self, input: Input<'a>, first: Option<(Input<'a>, ExprId)>) -> Parsed<'a, Body> {
        let start = self.program.jumps.len();
        let (mut rest, mut condition) = match first {
            Some((rest, condition)) => (rest, Some(condition)),
            None => (input, None),
        };
        loop {
            rest = self.jump(blanks(rest), condition)?.0;
            let next = blanks(rest);
            if let Ok((behind, ())) = keyword("IF")(next) {
                (rest, condition) = map(|input| self.expression(input), Some).parse(behind)?;
            } else if search(next).is_ok() {
                condition = None;
            } else {
                break;
            }
        }
        let count = u16::try_from(self.program.jumps.len() - start).unwrap_or(u16::MAX);
        Ok((rest, Body::Jumps { start: u32::try_from(start).unwrap_or(u32::MAX), count }))
    }

    /// Production `goto`.
    fn jump<'a>(&mut self, input: Input<'a>, condition: Option<ExprId>) -> Parsed<'a, ()> {
        let (rest, search) = required(search, Code::UNEXPECTED, 1, "GOTOF, GOTOB or GOTO was expected here")(input)?;
        let (rest, target) = match search {
            Search::Start => (rest, JumpTarget::Start),
            _ => preceded(blank, |input| self.jump_target(input)).parse(rest)?,
        };
        let span = Span::new(self.offset(input), self.offset(rest));
        self.program.jumps.push(Jump { span, condition, search, target });
        Ok((rest, ()))
    }

    /// Production `target`: a label, a block number, or an expression for one of them.
    pub(super) fn jump_target<'a>(&mut self, at: Input<'a>) -> Parsed<'a, JumpTarget> {
        if let Ok(number) = map(target_number, JumpTarget::Number).parse(at) {
            return Ok(number);
        }
        let is_computed = |rest| alt((behind_blanks(tag("<<")), tag("["))).parse(rest).is_ok();
        match identifier(at) {
            Ok((rest, name)) if !is_computed(rest) => Ok((rest, JumpTarget::Label(self.intern(name)))),
            Err(_) if !at.first().is_some_and(|&byte| matches!(byte, b'"' | b'(' | b'<')) => {
                fault(Code::UNEXPECTED, at, 1, "a label or block number was expected here")
            }
            _ => map(|input| self.expression(input), JumpTarget::Computed).parse(at),
        }
    }

    /// Production `case`: `CASE expression OF {constant GOTOx target} [DEFAULT GOTOx target]`, as jumps with comparisons.
    fn case<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Body> {
        let start = self.program.jumps.len();
        let (rest, selector) = self.expression(input)?;
        let message = "OF was expected after the expression of CASE";
        let (mut rest, ()) = behind_blanks(required(keyword("OF"), Code::UNEXPECTED, 1, message)).parse(rest)?;
        loop {
            rest = blanks(rest);
            let mut condition = None;
            if let Ok((behind, ())) = keyword("DEFAULT")(rest) {
                rest = behind;
            } else if is_end(rest, b";") {
                break;
            } else {
                let (behind, constant) = self.expression(rest)?;
                condition = Some(self.comparison(selector, constant));
                rest = behind;
            }
            rest = self.jump(blanks(rest), condition)?.0;
        }
        let count = u16::try_from(self.program.jumps.len() - start).unwrap_or(u16::MAX);
        Ok((rest, Body::Jumps { start: u32::try_from(start).unwrap_or(u32::MAX), count }))
    }

    /// Production `part`: `REPEAT label [label] [P=n]`, `REPEATB label [P=n]`
    fn repetition<'a>(&mut self, input: Input<'a>, rest: Input<'a>, one_block: bool) -> Parsed<'a, Body> {
        let (mut rest, first) = self.jump_target(blanks(rest))?;
        let (mut behind, mut count) = self.count(rest)?;
        let mut last = None;
        if count.is_none() && !one_block && !is_end(blanks(rest), b";") {
            (rest, last) = map(|input| self.jump_target(input), Some).parse(blanks(rest))?;
            (behind, count) = self.count(rest)?;
        }
        let span = Span::new(self.offset(input), self.offset(rest));
        let place = u32::try_from(self.program.repetitions.len()).unwrap_or(u32::MAX);
        self.program.repetitions.push(Repetition { span, first, last, one_block, count });
        Ok((behind, Body::RepeatPart(place)))
    }

    /// Production `for`: `FOR variable = from TO to`
    fn for_statement<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Body> {
        let (rest, variable) = preceded(blank, |input| self.left_side(input)).parse(input)?;
        let equals = required(byte(b'='), Code::UNEXPECTED, 1, "'=' was expected after the variable of FOR");
        let (rest, from) = preceded((blank, equals), |input| self.expression(input)).parse(rest)?;
        let to = required(keyword("TO"), Code::UNEXPECTED, 1, "TO was expected after the start value of FOR");
        let (rest, to) = preceded((blank, to), |input| self.expression(input)).parse(rest)?;
        Ok((rest, Body::For { variable, from, to }))
    }
}

/// The keyword of a jump; GOTO is last, as it is a prefix of the others.
fn search(input: Input<'_>) -> Parsed<'_, Search> {
    alt((
        value(Search::Forward, keyword("GOTOF")),
        value(Search::Backward, keyword("GOTOB")),
        value(Search::AroundIfAny, keyword("GOTOC")),
        value(Search::Start, keyword("GOTOS")),
        value(Search::Around, keyword("GOTO")),
    ))
    .parse(input)
}

/// The text before the comment of a line; a `;` in a string does not begin a comment.
pub(super) fn before_comment(input: Input<'_>) -> Parsed<'_, &[u8]> {
    let in_text = Cell::new(false);
    take_till(move |byte| {
        in_text.set(in_text.get() ^ (byte == b'"'));
        byte == b';' && !in_text.get()
    })(input)
}
