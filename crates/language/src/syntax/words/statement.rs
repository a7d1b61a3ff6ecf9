//! Statements: the control statements of Fanuc's custom macros and the O-words of RS274/NGC.

use nom::Parser as _;
use nom::combinator::{map, opt, peek, rest as rest_of_line, value};
use nom::sequence::{preceded, terminated};

use super::node::{ExprId, Node};
use super::parser::Parser;
use super::token::{
    Input, Parsed, angled, behind_blanks, blank, blanks, byte, fault, is_end, keyword, one_of, required, small_number,
};
use super::tree::{Block, Body, Label, Slice};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Keywords after the label of an O-word; longer keywords stand before their prefixes.
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

/// Keywords that begin a control statement of a custom macro.
#[derive(Clone, Copy)]
enum ControlWord {
    If,
    Goto,
    While,
    Do,
    EndIf,
    End,
    Else,
    Printing,
}

/// The keywords; ENDIF stands before its prefix END.
const CONTROLS: &[(&str, ControlWord)] = &[
    ("IF", ControlWord::If),
    // A Fanuc takes the first two letters of these words too.
    ("GOTO", ControlWord::Goto),
    ("GO", ControlWord::Goto),
    ("WHILE", ControlWord::While),
    ("WH", ControlWord::While),
    ("DO", ControlWord::Do),
    ("ENDIF", ControlWord::EndIf),
    ("END", ControlWord::End),
    ("ELSE", ControlWord::Else),
    // These print or name something.
    ("BPRNT", ControlWord::Printing),
    ("DPRNT", ControlWord::Printing),
    ("POPEN", ControlWord::Printing),
    ("PCLOS", ControlWord::Printing),
    ("SETVN", ControlWord::Printing),
];

impl Parser {
    /// Production `control` (fanuc), if a control statement begins here. Returns the rest of the line, which must be empty except for comments, or
    /// contains the words after THEN.
    pub(super) fn macro_statement<'a>(&mut self, input: Input<'a>, block: &mut Block) -> Parsed<'a, ()> {
        let mut control = required(one_of(CONTROLS), Code::MISSING_VALUE, 1, "this address has no value");
        let (rest, control) = control(input)?;
        let (rest, body) = match control {
            ControlWord::If => return self.behind_if(rest, block),
            ControlWord::While => {
                let (rest, condition) = terminated(|input| self.condition(input), blank).parse(rest)?;
                let message = "DO with its number was expected here";
                let (rest, ()) = required(keyword("DO"), Code::UNEXPECTED, rest.len().min(2), message)(rest)?;
                return self.loop_body(rest, Body::While(Some(condition)), block);
            }
            ControlWord::Do => return self.loop_body(rest, Body::While(None), block),
            ControlWord::End => return self.loop_body(rest, Body::EndWhile, block),
            ControlWord::Goto => map(|input| self.operand(input), Body::Goto).parse(rest)?,
            ControlWord::EndIf => (rest, Body::EndIf),
            ControlWord::Else => (rest, Body::Else),
            ControlWord::Printing => {
                let (rest, text) = rest_of_line(input)?;
                (rest, Body::Printing(Span::new(self.offset(text), self.line_end)))
            }
        };
        block.body = body;
        Ok((rest, ()))
    }

    /// Productions `condition` (fanuc) and `bracket` (rs274): `[…]`
    fn condition<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ExprId> {
        let message = "a condition in [ ] was expected here";
        let opened = preceded(peek(byte(b'[')), |input| self.bracket(input, b']'));
        behind_blanks(required(opened, Code::BAD_EXPRESSION, 1, message)).parse(input)
    }

    /// The condition of IF and its continuation: `GOTO n`, `THEN GOTO n`, `THEN` and words, words alone, `THEN` alone.
    fn behind_if<'a>(&mut self, input: Input<'a>, block: &mut Block) -> Parsed<'a, ()> {
        let (input, condition) = terminated(|input| self.condition(input), blank).parse(input)?;
        let (rest, is_then) = match value(true, keyword("THEN")).parse(input) {
            Ok((rest, is_then)) => (rest, is_then),
            Err(_) => (input, false),
        };
        if let Ok((rest, ())) = keyword("GOTO")(rest).or_else(|_| keyword("GO")(rest)) {
            let (rest, target) = self.operand(rest)?;
            block.body = Body::IfGoto { condition, target };
            return Ok((rest, ()));
        }
        // Haas and others take the words of a block directly; a Fanuc stops with an alarm.
        let is_word = matches!(rest, [b'#', ..] | [b'A'..=b'Z' | b'a'..=b'z', b'0'..=b'9' | b'#' | b'[' | b'-' | b'+' | b'.', ..]);
        if !is_then && !is_word {
            return fault(Code::UNEXPECTED, input, input.len().min(4), "GOTO or THEN was expected here");
        }
        let rest = blanks(rest);
        if is_end(rest, b"(;") {
            block.body = Body::If(condition);
            return Ok((rest, ()));
        }
        block.body = Body::IfThen(condition);
        self.words(rest, block)
    }

    fn loop_body<'a>(&mut self, input: Input<'a>, body: Body, block: &mut Block) -> Parsed<'a, ()> {
        let (rest, number) = behind_blanks(loop_number).parse(input)?;
        block.label = Some(Label::Number(number));
        block.body = body;
        Ok((rest, ()))
    }

    /// Production `o_word` (rs274); the first byte of the input is the `O`.
    pub(super) fn o_word<'a>(&mut self, input: Input<'a>, block: &mut Block) -> Parsed<'a, ()> {
        let (rest, label) = terminated(|input| self.o_label(input), blank).parse(input)?;
        block.label = Some(label);
        let message = "sub, endsub, call, return, if, elseif, else, endif, while, endwhile, do, repeat, \
                       endrepeat, break or continue must follow the label";
        let (rest, word) = required(one_of(O_WORDS), Code::UNEXPECTED, rest.len().min(1), message)(rest)?;
        let (rest, body) = match word {
            OWord::Sub => (rest, Body::Sub),
            OWord::Else => (rest, Body::Else),
            OWord::EndIf => (rest, Body::EndIf),
            OWord::EndWhile => (rest, Body::EndWhile),
            OWord::Do => (rest, Body::Do),
            OWord::EndRepeat => (rest, Body::EndRepeat),
            OWord::Break => (rest, Body::Break),
            OWord::Continue => (rest, Body::Continue),
            OWord::If => map(|input| self.condition(input), Body::If).parse(rest)?,
            OWord::ElseIf => map(|input| self.condition(input), Body::ElseIf).parse(rest)?,
            // Whether it ends a loop begun with `do` is determined when both ends are connected.
            OWord::While => map(|input| self.condition(input), |condition| Body::While(Some(condition))).parse(rest)?,
            OWord::Repeat => map(|input| self.condition(input), Body::Repeat).parse(rest)?,
            OWord::EndSub => map(|input| self.optional_value(input), Body::EndSub).parse(rest)?,
            OWord::Return => map(|input| self.optional_value(input), Body::Return).parse(rest)?,
            OWord::Call => map(|input| self.call_arguments(input), Body::Call).parse(rest)?,
        };
        block.body = body;
        Ok((rest, ()))
    }

    /// Production `label` (rs274), with the `O` before it: `O100`, `o<name>`, `o#1`, `o[#1+1]`.
    fn o_label<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Label> {
        let behind = blanks(&input[1..]);
        match behind.first() {
            Some(b'0'..=b'9') => map(|input| small_number(input, true), Label::Number).parse(behind),
            Some(b'<') => map(angled, |name| Label::Name(self.intern(name))).parse(behind),
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
            _ => fault(Code::MISSING_VALUE, input, 1, "a number, a name in < > or an expression in [ ] must follow O"),
        }
    }

    fn optional_value<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Option<ExprId>> {
        opt(preceded(peek(behind_blanks(byte(b'['))), |input| self.condition(input))).parse(input)
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

/// Production `loop` (fanuc): the number of DO and END.
fn loop_number(input: Input<'_>) -> Parsed<'_, u32> {
    let (rest, number) = small_number(input, true)?;
    if !(1..=3).contains(&number) {
        return fault(Code::UNMATCHED_STRUCTURE, input, 1, "the number of a loop is 1, 2 or 3");
    }
    Ok((rest, number))
}
