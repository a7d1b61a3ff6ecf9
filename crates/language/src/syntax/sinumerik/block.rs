//! Blocks: splits the file into lines, sections and words, and continues after unreadable text.

use nom::Parser as _;
use nom::combinator::{map, not, opt, peek};
use nom::sequence::{preceded, terminated};

use super::macros::{Macros, definition};
use super::section::empty;
use super::token::{
    Fault, Input, Parsed, behind_blanks, blank, blanks, byte, digits, fault, find_byte, identifier, is_blank, is_end,
    number, one, required, small_number,
};
use super::tree::{Address, Block, BlockNumber, Body, Program, Value, Word};
use crate::syntax::look_alike;
use crate::syntax::names::NameId;
use crate::syntax::{MAX_FINDINGS, too_many_parts};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_dialect::Dialect;

/// Maximum length of a block; controls accept 512 characters.
const MAX_BLOCK_BYTES: usize = 4096;

/// State of the parser: the growing tree, and the end of the current line.
pub(super) struct Parser {
    pub(super) program: Program,
    findings: Vec<Diagnostic>,
    pub(super) line_end: usize,
    pub(super) macros: Macros,
    /// Macros of definition files, which outlive their section.
    pub(super) shared: Macros,
    /// Expanded lines, see [`Source::with_tail`].
    pub(super) tail: Vec<u8>,
    pub(super) expanded: Vec<(u32, Span)>,
    pub(super) depth: u32,
    /// Number of operators of the current expression so far.
    pub(super) operators: u32,
    has_too_many_parts: bool,
}

/// A block under construction.
pub(super) struct Draft {
    pub(super) block: Block,
}

impl Parser {
    pub(super) fn new(source: Source, dialect: &'static Dialect, macros: Macros) -> Parser {
        let shared = macros.clone();
        Parser {
            program: empty(source, dialect),
            findings: Vec::new(),
            line_end: 0,
            macros,
            shared,
            tail: Vec::new(),
            expanded: Vec::new(),
            depth: 0,
            operators: 0,
            has_too_many_parts: false,
        }
    }

    pub(super) fn finish(mut self) -> (Program, Vec<Diagnostic>) {
        if !self.expanded.is_empty() {
            self.program.source = self.program.source.with_tail(self.tail, self.expanded);
        }
        (self.program, self.findings)
    }

    /// Production `file`: reads all lines.
    pub(super) fn run(&mut self) {
        let length = self.program.source.bytes().len();
        self.read((self.start(), 0), length);
        self.end();
    }

    /// The offset of the first line.
    pub(super) fn start(&self) -> usize {
        if self.program.source.bytes().starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }
    }

    /// Reads whole lines from an offset up to another one. `line` is the number of lines before it. Returns the start of the next line and its
    /// number.
    pub(super) fn read(&mut self, (mut start, mut line): (usize, u32), until: usize) -> (usize, u32) {
        let source = self.program.source.clone();
        let bytes = source.bytes();
        let line_end = source.line_end();
        while start < until.min(bytes.len()) && !self.is_hopeless() {
            let length = find_byte(&bytes[start..], line_end);
            let next = length.map_or(bytes.len(), |length| start + length + 1);
            let mut end = length.map_or(bytes.len(), |length| start + length);
            while end > start && is_blank(bytes[end - 1]) {
                end -= 1;
            }
            line += 1;
            self.line_end = end;
            self.read_line(&bytes[start..end], line);
            start = next;
        }
        if self.is_hopeless() { (bytes.len(), line) } else { (start, line) }
    }

    /// `true` if the file is not a program, so that the rest of it is skipped.
    fn is_hopeless(&self) -> bool {
        self.has_too_many_parts || self.findings.len() > MAX_FINDINGS
    }

    /// Reports the first program beyond the maximum number.
    pub(super) fn give_up_at_section(&mut self, header: Span) {
        if !std::mem::replace(&mut self.has_too_many_parts, true) {
            self.findings.push(too_many_parts(&self.program.source, header));
        }
    }

    /// Ends the file.
    pub(super) fn end(&mut self) {
        self.close_section();
        // Anything before the first header without effect is a leader.
        self.program.sections.retain(|section| !(section.blocks.is_empty() && section.headers.is_empty()));
    }

    /// `true` if no macro was expanded.
    pub(super) fn is_unexpanded(&self) -> bool {
        self.expanded.is_empty()
    }

    /// The offset in the file of the first byte of `input`.
    pub(super) fn offset(&self, input: Input<'_>) -> usize {
        self.line_end - input.len()
    }

    pub(super) fn intern(&mut self, name: &[u8]) -> NameId {
        self.program.names.intern(name)
    }

    fn report(&mut self, fault: &Fault) {
        let start = self.line_end - fault.left.min(self.line_end);
        let end = (start + fault.length.max(1)).min(self.line_end.max(start + 1));
        let place = Place { file: self.program.source.id(), span: Span::new(start, end) };
        let typed = look_alike::help_in(self.program.source.bytes(), start, self.line_end);
        let help = typed.unwrap_or_else(|| help_for(fault.code));
        self.findings.push(Diagnostic::at(fault.code, place, fault.message, help));
    }

    fn read_line(&mut self, text: &[u8], line: u32) {
        let text = blanks(text);
        if text.first() == Some(&b'%') {
            self.open_section(text);
            return;
        }
        let is_path = text.len() >= 6 && text[..6].eq_ignore_ascii_case(b";$PATH");
        let start = self.offset(text);
        if is_path && self.section_is_fresh() {
            let span = Span::new(start, self.line_end);
            if let Some(section) = self.program.sections.last_mut() {
                section.headers.push(span);
            }
            return;
        }
        if text.is_empty() {
            return;
        }
        let block = Block {
            span: Span::new(start, self.line_end),
            line,
            skip: None,
            number: None,
            label: None,
            body: Body::Empty,
            first_word: u32::try_from(self.program.words.next()).unwrap_or(u32::MAX),
            word_count: 0,
            has_names: false,
            comment: Span::new(self.line_end, self.line_end),
            partner: u32::MAX,
        };
        let mut draft = Draft { block };
        let found = match self.macros.expand(text) {
            None => self.bounded_block(text, &mut draft),
            Some(expanded) => self.expanded_block(expanded, block.span, &mut draft),
        };
        if let Err(fault) = found {
            self.report(&fault);
            // A control statement followed by other text still opens or closes its structure.
            if matches!(draft.block.body, Body::Empty | Body::Words) {
                draft.block.body = Body::Faulty;
            }
        }
        if matches!(draft.block.body, Body::Declaration)
            && let Some((name, text)) = definition(text)
        {
            self.macros.define(name, text);
        }
        let count = self.program.words.next() - draft.block.first_word as usize;
        draft.block.word_count = u16::try_from(count).unwrap_or(u16::MAX);
        self.program.blocks.push(draft.block);
    }

    pub(super) fn bounded_block(&mut self, text: Input<'_>, draft: &mut Draft) -> Result<(), Fault> {
        if text.len() > MAX_BLOCK_BYTES {
            let message = "this block has more than 4096 bytes";
            return Err(Fault { code: Code::BLOCK_TOO_LONG, left: text.len(), length: 40, message });
        }
        match self.block(text, draft) {
            Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) => Err(fault),
            _ => Ok(()),
        }
    }

    /// Production `block`: number, skip, label, then a statement or words.
    fn block<'a>(&mut self, mut input: Input<'a>, draft: &mut Draft) -> Parsed<'a, ()> {
        loop {
            input = blanks(input);
            input = match input.first() {
                Some(b'/') if draft.block.skip.is_none() => {
                    let (rest, level) = skip(input)?;
                    draft.block.skip = Some(level);
                    rest
                }
                Some(b'N' | b'n' | b':') if draft.block.number.is_none() => match block_number(input) {
                    Ok((rest, number)) => {
                        draft.block.number = Some(number);
                        rest
                    }
                    // The beginning of a word.
                    Err(nom::Err::Error(_)) => break,
                    Err(fault) => return Err(fault),
                },
                _ => break,
            };
        }
        if is_end(input, b";") {
            return self.end_of_statement(input, draft);
        }
        if starts_name(input)
            && let Ok((rest, name)) = label(input)
        {
            draft.block.label = Some(self.intern(name));
            input = rest;
        }
        if starts_name(input) {
            match self.statement(input, draft) {
                Err(nom::Err::Error(_)) => {}
                found => {
                    let (rest, body) = found?;
                    draft.block.body = body;
                    return self.end_of_statement(rest, draft);
                }
            }
        }
        self.words(input, draft)
    }

    /// Accepts only a comment after a statement.
    fn end_of_statement<'a>(&mut self, input: Input<'a>, draft: &mut Draft) -> Parsed<'a, ()> {
        let rest = blanks(input);
        match rest.first() {
            None => Ok((rest, ())),
            Some(b';') => {
                self.comment(rest, draft);
                Ok((rest, ()))
            }
            Some(_) => fault(
                Code::MUST_STAND_ALONE,
                rest,
                rest.len(),
                "this follows a statement that must be alone in its block",
            ),
        }
    }

    /// Production `comment`: from its `;` to the end of the line.
    pub(super) fn comment(&mut self, input: Input<'_>, draft: &mut Draft) {
        draft.block.comment = Span::new(self.offset(input), self.line_end);
    }

    /// Production `words`.
    fn words<'a>(&mut self, mut input: Input<'a>, draft: &mut Draft) -> Parsed<'a, ()> {
        loop {
            input = blanks(input);
            if is_end(input, b";") {
                return self.end_of_statement(input, draft);
            }
            draft.block.body = Body::Words;
            let (rest, word) = self.word(input, draft)?;
            self.program.words.push(word);
            input = rest;
        }
    }

    /// Production `word`.
    fn word<'a>(&mut self, input: Input<'a>, draft: &mut Draft) -> Parsed<'a, Word> {
        let start = self.offset(input);
        if !input[0].is_ascii_alphabetic() || starts_name(input) {
            return self.named_word(input, draft);
        }
        let letter = input[0].to_ascii_uppercase();
        if matches!(letter, b'L' | b'M') && is_call_with_arguments(input) {
            return self.named_word(input, draft);
        }
        let rest = blanks(&input[1..]);
        let (rest, address, value) = match rest.first() {
            Some(b'0'..=b'9' | b'.' | b'-' | b'+') => {
                let is_signed = matches!(rest[0], b'-' | b'+');
                let (behind, number) = number(if is_signed { blanks(&rest[1..]) } else { rest })?;
                if !is_signed && number.is_integer && is_assigned(behind) {
                    let (behind, extension) = terminated(small_number, assignment_sign).parse(rest)?;
                    draft.block.has_names |= letter == b'R';
                    let (behind, value) = self.assigned_value(behind)?;
                    (behind, Address::Extended(letter, extension), value)
                } else {
                    let value = if rest[0] == b'-' { -number.value } else { number.value };
                    (behind, Address::Letter(letter), Value::Number(value, number.is_integer))
                }
            }
            Some(b'=') => {
                let (behind, value) = preceded(byte(b'='), |input| self.assigned_value(input)).parse(rest)?;
                (behind, Address::Letter(letter), value)
            }
            Some(b'[') => return self.named_word(input, draft),
            Some(b':') => {
                return fault(Code::UNEXPECTED, input, 2, "a label begins with two letters or underscores");
            }
            _ => {
                return fault(
                    Code::MISSING_VALUE,
                    input,
                    1,
                    "this address has no value; a value that is not a number needs '='",
                );
            }
        };
        if rest.first() == Some(&b':') {
            let length = input.len() - rest.len() + 1;
            return fault(Code::UNEXPECTED, input, length, "a label begins with two letters or underscores");
        }
        Ok((rest, Word { span: Span::new(start, self.offset(rest)), address, value }))
    }

    /// A word with a name, of production `word`: `NAME`, `NAME=…`, `NAME[…]=…`, `NAME(…)`, `R[…]=…`, `$P_…=…`.
    ///
    /// Productions `assignment`, `call` and `return`: a variable and a subprogram are words like any other here.
    fn named_word<'a>(&mut self, input: Input<'a>, draft: &mut Draft) -> Parsed<'a, Word> {
        let start = self.offset(input);
        let message = "no word of this language begins like this";
        let (rest, name) = required(identifier, Code::UNEXPECTED, 1, message)(input)?;
        draft.block.has_names = true;
        let behind = blanks(rest);
        let (rest, address, value) = match behind.first() {
            Some(b'=') => {
                let address = Address::Name(self.intern(name));
                let (rest, value) = preceded(byte(b'='), |input| self.assigned_value(input)).parse(behind)?;
                (rest, address, value)
            }
            Some(b'(') => {
                let address = Address::Name(self.intern(name));
                let (rest, value) = map(|input| self.arguments(input, b')'), Value::Arguments).parse(behind)?;
                (rest, address, value)
            }
            Some(b'[') => {
                let (rest, left) = self.left_side(input)?;
                let Ok((value, _)) = behind_blanks(byte(b'=')).parse(rest) else {
                    let message = "this needs '=' and a value after its index";
                    return fault(Code::MISSING_VALUE, input, name.len(), message);
                };
                let (rest, value) = self.assigned_value(value)?;
                (rest, Address::Indexed(left), value)
            }
            _ => (rest, Address::Name(self.intern(name)), Value::None),
        };
        Ok((rest, Word { span: Span::new(start, self.offset(rest)), address, value }))
    }
}

/// Production `skip`: `/` with its level; level 0 if not written.
fn skip(input: Input<'_>) -> Parsed<'_, u8> {
    let level = opt(one(|byte| byte.is_ascii_digit()));
    map(preceded(byte(b'/'), level), |digit| digit.map_or(0, |digit| digit - b'0')).parse(input)
}

/// Production `number`: `N10`, `:10`.
fn block_number(input: Input<'_>) -> Parsed<'_, BlockNumber> {
    let start = terminated(one(|byte| matches!(byte, b'N' | b'n' | b':')), peek(one(|byte| byte.is_ascii_digit())));
    map((start, small_number), |(first, number)| BlockNumber { main: first == b':', number }).parse(input)
}

/// Production `label`: a name and `:`.
fn label(input: Input<'_>) -> Parsed<'_, &[u8]> {
    terminated(identifier, (blank, byte(b':'), not(byte(b'=')), blank)).parse(input)
}

/// `true` if the `=` of an assignment follows, not of a comparison.
fn is_assigned(input: Input<'_>) -> bool {
    blanks(input).first() == Some(&b'=') && assignment_sign(input).is_ok()
}

fn assignment_sign(input: Input<'_>) -> Parsed<'_, ()> {
    (blank, byte(b'='), not(byte(b'='))).map(|_| ()).parse(input)
}

/// Two or more letters or underscores, or a `$`: a name, not an address letter.
fn starts_name(input: Input<'_>) -> bool {
    match *input {
        [b'$' | b'_', ..] => true,
        [first, second, ..] => first.is_ascii_alphabetic() && (second.is_ascii_alphabetic() || second == b'_'),
        _ => false,
    }
}

/// `L140(1)`: the name of a subprogram, not an address with a number.
fn is_call_with_arguments(input: Input<'_>) -> bool {
    (one(|_| true), digits, blank, byte(b'(')).parse(input).is_ok()
}

fn help_for(code: Code) -> &'static str {
    match code {
        Code::BAD_NUMBER => "write digits with one decimal point at most; an exponent is written EX",
        Code::MISSING_VALUE => "give the address a value, for example X10 or X=R1",
        Code::BAD_EXPRESSION => "complete or correct the expression",
        Code::UNCLOSED => "close it before the end of the block",
        Code::TOO_DEEP => "split the expression over several blocks",
        Code::MUST_STAND_ALONE => "move it to its own block",
        Code::BLOCK_TOO_LONG => "check that the file is a part program and still has its line ends",
        _ => "correct the block, or check --dialect",
    }
}
