//! Statements: the control statements of Fanuc's custom macros and the O-words of RS274/NGC.

use super::node::{ExprId, Node};
use super::parser::Parser;
use super::token::{Input, Parsed, angled, blanks, fault, keyword, one_of, small_number};
use super::tree::{Block, Body, Label, Slice};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Statements of Fanuc that print or name something.
const PRINTING: &[&str] = &["BPRNT", "DPRNT", "POPEN", "PCLOS", "SETVN"];

/// What stands behind the label of an O-word; longer words before those that they begin with.
#[derive(Clone, Copy)]
enum OWord {
    Sub,
    EndSub,
    Call,
    Return,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    Repeat,
    EndRepeat,
    Break,
    Continue,
}

const O_WORDS: &[(&str, OWord)] = &[
    ("SUB", OWord::Sub),
    ("ENDSUB", OWord::EndSub),
    ("CALL", OWord::Call),
    ("RETURN", OWord::Return),
    ("IF", OWord::If),
    ("ELSEIF", OWord::ElseIf),
    ("ELSE", OWord::Else),
    ("ENDIF", OWord::EndIf),
    ("WHILE", OWord::While),
    ("ENDWHILE", OWord::EndWhile),
    ("DO", OWord::Do),
    ("REPEAT", OWord::Repeat),
    ("ENDREPEAT", OWord::EndRepeat),
    ("BREAK", OWord::Break),
    ("CONTINUE", OWord::Continue),
];

impl Parser {
    /// A control statement of a custom macro, where one begins here: what is left of the line, which must be empty but for
    /// comments, or holds the words behind THEN.
    pub(super) fn macro_statement<'a>(&mut self, input: Input<'a>, block: &mut Block) -> Parsed<'a, ()> {
        if let Some(rest) = keyword("IF", input) {
            let (rest, condition) = self.condition(rest)?;
            return self.behind_if(rest, condition, block);
        }
        if let Some(rest) = keyword("GOTO", input) {
            let (rest, target) = self.operand(rest)?;
            block.body = Body::Goto(target);
            return Ok((rest, ()));
        }
        if let Some(rest) = keyword("WHILE", input) {
            let (rest, condition) = self.condition(rest)?;
            let rest = blanks(rest);
            let Some(rest) = keyword("DO", rest) else {
                return fault(Code::UNEXPECTED, rest, rest.len().min(2), "DO with its number was expected here");
            };
            return self.loop_number(rest, Body::While(Some(condition)), block);
        }
        if let Some(rest) = keyword("DO", input) {
            return self.loop_number(rest, Body::While(None), block);
        }
        if let Some(rest) = keyword("ENDIF", input) {
            block.body = Body::EndIf;
            return Ok((rest, ()));
        }
        if let Some(rest) = keyword("END", input) {
            return self.loop_number(rest, Body::EndWhile, block);
        }
        if let Some(rest) = keyword("ELSE", input) {
            block.body = Body::Else;
            return Ok((rest, ()));
        }
        if PRINTING.iter().any(|word| keyword(word, input).is_some()) {
            let start = self.offset(input);
            block.body = Body::Printing(Span::new(start, self.line_end));
            return Ok((&input[input.len()..], ()));
        }
        fault(Code::MISSING_VALUE, input, 1, "this address has no value")
    }

    /// `[…]`
    fn condition<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let input = blanks(input);
        match input.first() {
            Some(b'[') => self.bracket(input, b']'),
            _ => fault(Code::BAD_EXPRESSION, input, 1, "a condition in [ ] was expected here"),
        }
    }

    fn behind_if<'a>(&mut self, input: Input<'a>, condition: ExprId, block: &mut Block) -> Parsed<'a, ()> {
        let input = blanks(input);
        if let Some(rest) = keyword("GOTO", input) {
            let (rest, target) = self.operand(rest)?;
            block.body = Body::IfGoto { condition, target };
            return Ok((rest, ()));
        }
        let Some(rest) = keyword("THEN", input) else {
            return fault(Code::UNEXPECTED, input, input.len().min(4), "GOTO or THEN was expected here");
        };
        if let Some(rest) = keyword("GOTO", rest) {
            let (rest, target) = self.operand(rest)?;
            block.body = Body::IfGoto { condition, target };
            return Ok((rest, ()));
        }
        let rest = blanks(rest);
        if matches!(rest.first(), None | Some(b'(' | b';')) {
            block.body = Body::If(condition);
            return Ok((rest, ()));
        }
        block.body = Body::IfThen(condition);
        self.words(rest, block)
    }

    fn loop_number<'a>(&mut self, input: Input<'a>, body: Body, block: &mut Block) -> Parsed<'a, ()> {
        let input = blanks(input);
        let (rest, number) = small_number(input, true)?;
        if !(1..=3).contains(&number) {
            return fault(Code::UNMATCHED_STRUCTURE, input, 1, "the number of a loop is 1, 2 or 3");
        }
        block.label = Some(Label::Number(number));
        block.body = body;
        Ok((rest, ()))
    }

    /// An O-word; the first byte of the input is the `O`.
    pub(super) fn o_word<'a>(&mut self, input: Input<'a>, block: &mut Block) -> Parsed<'a, ()> {
        let (rest, label) = self.o_label(input)?;
        block.label = Some(label);
        let rest = blanks(rest);
        let Some((rest, word)) = one_of(O_WORDS, rest) else {
            let message = "behind the label stands sub, endsub, call, return, if, elseif, else, endif, while, endwhile, do, \
                           repeat, endrepeat, break or continue";
            return fault(Code::UNEXPECTED, rest, rest.len().min(1), message);
        };
        let (rest, body) = match word {
            OWord::Sub => (rest, Body::Sub),
            OWord::Else => (rest, Body::Else),
            OWord::EndIf => (rest, Body::EndIf),
            OWord::EndWhile => (rest, Body::EndWhile),
            OWord::Do => (rest, Body::Do),
            OWord::EndRepeat => (rest, Body::EndRepeat),
            OWord::Break => (rest, Body::Break),
            OWord::Continue => (rest, Body::Continue),
            OWord::If => self.condition(rest).map(|(rest, condition)| (rest, Body::If(condition)))?,
            OWord::ElseIf => self.condition(rest).map(|(rest, condition)| (rest, Body::ElseIf(condition)))?,
            // Whether it ends a loop begun with `do` shows when the two sides are connected.
            OWord::While => self.condition(rest).map(|(rest, condition)| (rest, Body::While(Some(condition))))?,
            OWord::Repeat => self.condition(rest).map(|(rest, count)| (rest, Body::Repeat(count)))?,
            OWord::EndSub => self.optional_value(rest).map(|(rest, value)| (rest, Body::EndSub(value)))?,
            OWord::Return => self.optional_value(rest).map(|(rest, value)| (rest, Body::Return(value)))?,
            OWord::Call => self.call_arguments(rest).map(|(rest, arguments)| (rest, Body::Call(arguments)))?,
        };
        block.body = body;
        Ok((rest, ()))
    }

    /// `O100`, `o<name>`, `o#1`, `o[#1+1]`.
    fn o_label<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Label> {
        let behind = blanks(&input[1..]);
        match behind.first() {
            Some(b'0'..=b'9') => {
                let (rest, number) = small_number(behind, true)?;
                Ok((rest, Label::Number(number)))
            }
            Some(b'<') => {
                let (rest, name) = angled(behind)?;
                Ok((rest, Label::Name(self.intern(name))))
            }
            Some(b'#' | b'[') => {
                let (rest, id) = self.operand(behind)?;
                // o[100] is o100.
                let label = match self.program.expr(id).node {
                    Node::Number(value) if value.fract() == 0.0 && (0.0..1e9).contains(&value) => {
                        Label::Number(value as u32)
                    }
                    _ => Label::Computed(id),
                };
                Ok((rest, label))
            }
            _ => {
                fault(Code::MISSING_VALUE, input, 1, "behind O stands a number, a name in < > or an expression in [ ]")
            }
        }
    }

    fn optional_value<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Option<ExprId>> {
        match blanks(input).first() {
            Some(b'[') => self.condition(input).map(|(rest, id)| (rest, Some(id))),
            _ => Ok((input, None)),
        }
    }

    fn call_arguments<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Slice> {
        let start = u32::try_from(self.program.arguments.next()).unwrap_or(u32::MAX);
        let (mut rest, mut count) = (input, 0);
        loop {
            rest = blanks(rest);
            match rest.first() {
                Some(b'[') => {
                    let (behind, id) = self.condition(rest)?;
                    self.program.arguments.push(id);
                    (rest, count) = (behind, count + 1);
                }
                Some(b'(') => rest = self.comment(rest)?.0,
                _ => return Ok((rest, Slice { start, count })),
            }
        }
    }
}
