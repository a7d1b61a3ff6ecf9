//! Blocks: splits the file into lines, parts and words, and continues after unreadable text.

use nom::Parser as _;
use nom::combinator::{map, opt, peek};
use nom::multi::many0_count;
use nom::sequence::{preceded, terminated};

use super::header;
use super::token::{
    Fault, Input, Parsed, behind_blanks, blank, blanks, byte, fault, find_byte, is_blank, no_match, one, small_number,
};
use super::tree::{Block, Body, InnerSkip, PartKind, Program, Slice};
use crate::syntax::firmware;
use crate::syntax::look_alike;
use crate::syntax::names::{NameId, Names};
use crate::syntax::paged_store::PagedStore;
use crate::syntax::{MAX_FINDINGS, too_many_parts};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_dialect::{Dialect, Language};

/// Maximum length of a block; controls accept a few hundred characters.
const MAX_BLOCK_BYTES: usize = 4096;

/// Maximum number of comment lines before the number of a Grundig program.
const MOST_HEADER_LINES: usize = 1000;

/// State of the parser: the growing tree, and the end of the current line.
pub(super) struct Parser {
    pub(super) program: Program,
    pub(super) language: Language,
    findings: Vec<Diagnostic>,
    pub(super) line_end: usize,
    pub(super) depth: u32,
    /// `true` while the part has no block, so that a line with only a number is its header.
    pub(super) is_fresh: bool,
    has_too_many_parts: bool,
}

/// A program without content.
pub(super) fn empty(source: Source, dialect: &'static Dialect) -> Program {
    Program {
        source,
        dialect,
        parts: Vec::new(),
        blocks: PagedStore::default(),
        words: PagedStore::default(),
        exprs: PagedStore::default(),
        arguments: PagedStore::default(),
        comments: PagedStore::default(),
        names: Names::default(),
        has_tape_marks: false,
        targets: Vec::new(),
        subs: Vec::new(),
        pages: None,
    }
}

impl Parser {
    pub(super) fn new(source: Source, dialect: &'static Dialect) -> Parser {
        let program = empty(source, dialect);
        Parser {
            program,
            language: dialect.language,
            findings: Vec::new(),
            line_end: 0,
            depth: 0,
            is_fresh: true,
            has_too_many_parts: false,
        }
    }

    pub(super) fn finish(self) -> (Program, Vec<Diagnostic>) {
        (self.program, self.findings)
    }

    /// `true` if blanks are ignored, even between the digits of a number.
    pub(super) fn is_spaced(&self) -> bool {
        self.language != Language::Grundig
    }

    /// Productions `file` (rs274, grundig) and `part` (grundig): reads all lines.
    pub(super) fn run(&mut self) {
        let (start, end) = self.tape();
        self.open_part(PartKind::Program, None);
        self.read(start, end);
        self.close_part();
    }

    /// Offset of the first line and the number of lines before it, and the offset at which the tape ends.
    pub(super) fn tape(&self) -> ((usize, u32), usize) {
        let source = &self.program.source;
        let bytes = source.bytes();
        let (mut start, end) = header::tape(bytes, source.line_end(), self.language);
        if bytes.starts_with(b"\xef\xbb\xbf") {
            start = start.max(3);
        }
        let before = bytes[..start].iter().filter(|&&byte| byte == source.line_end()).count();
        ((start, u32::try_from(before).unwrap_or(u32::MAX)), end)
    }

    /// Reads whole lines from an offset up to another one. `line` is the number of lines before it. Returns the start of the next line and its
    /// number.
    pub(super) fn read(&mut self, (mut start, mut line): (usize, u32), until: usize) -> (usize, u32) {
        let source = self.program.source.clone();
        let bytes = source.bytes();
        let line_end = source.line_end();
        while start < until && !self.is_hopeless() {
            let length = find_byte(&bytes[start..], line_end);
            let next = length.map_or(bytes.len(), |length| start + length + 1);
            let mut end = length.map_or(bytes.len(), |length| start + length);
            while end > start && is_blank(bytes[end - 1]) {
                end -= 1;
            }
            line += 1;
            self.line_end = end;
            let text = blanks(&bytes[start..end]);
            if !text.is_empty() {
                self.read_line(text, line);
            }
            start = next;
        }
        if self.is_hopeless() { (source.bytes().len(), line) } else { (start, line) }
    }

    /// `true` if the file is not a program, so that the rest of it is skipped.
    fn is_hopeless(&self) -> bool {
        self.has_too_many_parts || self.findings.len() > MAX_FINDINGS
    }

    /// Reports the first program beyond the maximum number.
    pub(super) fn give_up_at_part(&mut self) {
        if !std::mem::replace(&mut self.has_too_many_parts, true) {
            let header = Span::new(self.line_end.saturating_sub(1), self.line_end);
            self.findings.push(too_many_parts(&self.program.source, header));
        }
    }

    /// `true` if the part begins with too many comment lines to be followed by a header.
    fn is_late(&self) -> bool {
        let start = self.program.parts.last().map_or(0, |part| part.blocks.start);
        self.program.blocks.next() - start >= MOST_HEADER_LINES
    }

    /// The offset in the file of the first byte of `input`.
    pub(super) fn offset(&self, input: Input<'_>) -> usize {
        self.line_end - input.len()
    }

    /// The id of a name; blanks in it are ignored.
    pub(super) fn intern(&mut self, name: &[u8]) -> NameId {
        if name.iter().any(|&byte| is_blank(byte)) {
            let dense: Vec<u8> = name.iter().copied().filter(|&byte| !is_blank(byte)).collect();
            return self.program.names.intern(&dense);
        }
        self.program.names.intern(name)
    }

    pub(super) fn report(&mut self, fault: &Fault) {
        let start = self.line_end - fault.left.min(self.line_end);
        let end = (start + fault.length.max(1)).min(self.line_end.max(start + 1));
        let place = Place { file: self.program.source.id(), span: Span::new(start, end) };
        let typed = look_alike::help_in(self.program.source.bytes(), start, self.line_end);
        let of_firmware = || {
            let has_axes = self.language != Language::Grundig;
            has_axes.then(|| firmware::help_in(self.program.source.bytes(), start, self.line_end)).flatten()
        };
        let help = typed.or_else(of_firmware).unwrap_or_else(|| help_for(fault.code));
        self.findings.push(Diagnostic::at(fault.code, place, fault.message, help));
    }

    fn read_line(&mut self, line_text: &[u8], line: u32) {
        let mut text = self.header(line_text);
        if text.len() < line_text.len() {
            text = self.title(blanks(text));
            self.end_header(text);
        } else if text.first() != Some(&b'(') || self.is_late() {
            self.is_fresh = false;
        }
        if text.is_empty() {
            return;
        }
        let start = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let mut block = Block {
            span: Span::new(self.offset(text), self.line_end),
            line,
            skip: None,
            number: None,
            body: Body::Empty,
            label: None,
            inner_skip: None,
            words: Slice { start: start(self.program.words.next()), count: 0 },
            comments: Slice { start: start(self.program.comments.next()), count: 0 },
            partner: u32::MAX,
        };
        if let Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) = self.block(text, &mut block) {
            self.report(&fault);
            // A control statement followed by other text still opens or closes its structure.
            if matches!(block.body, Body::Empty | Body::Words) {
                block.body = Body::Faulty;
            }
        }
        let count = |start: u32, end: usize| u16::try_from(end - start as usize).unwrap_or(u16::MAX);
        block.words.count = count(block.words.start, self.program.words.next());
        block.comments.count = count(block.comments.start, self.program.comments.next());
        self.program.blocks.push(block);
    }

    /// Production `block` (fanuc, rs274, grundig): skip level and number, then a statement or words.
    fn block<'a>(&mut self, mut input: Input<'a>, block: &mut Block) -> Parsed<'a, ()> {
        if input.len() > MAX_BLOCK_BYTES {
            return fault(Code::BLOCK_TOO_LONG, input, 40, "this block has more than 4096 bytes");
        }
        loop {
            input = blanks(input);
            input = match input.first() {
                Some(b'/') if block.skip.is_none() => {
                    let (rest, level) = self.skip(input)?;
                    block.skip = Some(level);
                    rest
                }
                Some(b'N' | b'n') if block.number.is_none() => match self.number(input) {
                    Ok((rest, number)) => {
                        block.number = Some(number);
                        rest
                    }
                    // The beginning of a word.
                    Err(nom::Err::Error(_)) => break,
                    Err(fault) => return Err(fault),
                },
                _ => break,
            };
        }
        let rest = match input.first() {
            None => return Ok((input, ())),
            // The end of a tape after a block number.
            Some(b'%') if self.is_spaced() && block.number.is_some() => {
                self.program.has_tape_marks = true;
                return Ok((input, ()));
            }
            Some(b'O' | b'o') if self.language == Language::Rs274 => self.o_word(input, block)?.0,
            Some(first) if first.is_ascii_alphabetic() && self.is_macro_statement(input) => {
                self.macro_statement(input, block)?.0
            }
            _ => return self.words(input, block),
        };
        self.end_of_statement(rest)
    }

    /// Production `skip` (fanuc, grundig): `/` with its level; level 0 if not written. RS274/NGC has no levels.
    fn skip<'a>(&self, input: Input<'a>) -> Parsed<'a, u8> {
        let level = opt(one(|byte| byte.is_ascii_digit() && self.language != Language::Rs274));
        map(preceded(byte(b'/'), level), |digit| digit.map_or(0, |digit| digit - b'0')).parse(input)
    }

    /// Production `number` (fanuc, rs274, grundig): `N10`, and `N10.5` of RS274/NGC. `N1=` with an index is a word.
    fn number<'a>(&self, input: Input<'a>) -> Parsed<'a, u32> {
        let start = (one(|byte| byte.eq_ignore_ascii_case(&b'N')), blank, peek(one(|byte| byte.is_ascii_digit())));
        let (rest, number) = preceded(start, |input| small_number(input, self.is_spaced())).parse(input)?;
        match (blanks(rest).first(), self.language) {
            (Some(b'='), Language::Grundig) => no_match(input),
            (Some(b'.'), Language::Rs274) => {
                let is_digit = peek(behind_blanks(one(|byte| byte.is_ascii_digit())));
                let decimals = preceded((is_digit, blank), |input| small_number(input, true));
                let (rest, _) = (behind_blanks(byte(b'.')), opt(decimals)).parse(rest)?;
                Ok((rest, number))
            }
            (Some(b'.'), _) => {
                let length = input.len() - rest.len() + 1;
                fault(Code::BAD_NUMBER, input, length, "a block number has no decimal point")
            }
            _ => Ok((rest, number)),
        }
    }

    /// `true` for a macro statement: a word never begins with two adjacent letters.
    fn is_macro_statement(&self, input: Input<'_>) -> bool {
        self.language == Language::Fanuc && blanks(&input[1..]).first().is_some_and(u8::is_ascii_alphabetic)
    }

    /// Accepts only comments after a statement.
    fn end_of_statement<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let is_comment = peek(one(|byte| byte == b'(' || byte == b';'));
        let comments = many0_count(preceded((blank, is_comment), |input| self.comment(input)));
        let (rest, _) = terminated(comments, blank).parse(input)?;
        if rest.is_empty() {
            return Ok((rest, ()));
        }
        fault(Code::MUST_STAND_ALONE, rest, rest.len(), "this follows a statement that must be alone in its block")
    }

    /// Words and comments up to the end of the line.
    pub(super) fn words<'a>(&mut self, mut input: Input<'a>, block: &mut Block) -> Parsed<'a, ()> {
        loop {
            input = blanks(input);
            let Some(&first) = input.first() else { return Ok((input, ())) };
            input = self.item(input, first, block)?.0;
        }
    }

    /// A word, a comment, or a `/` before words that are skipped.
    #[inline]
    fn item<'a>(&mut self, input: Input<'a>, first: u8, block: &mut Block) -> Parsed<'a, ()> {
        match first {
            b'(' | b';' => self.comment(input),
            b'/' if self.language == Language::Fanuc && block.inner_skip.is_none() => {
                let (rest, level) = self.skip(input)?;
                let words_before = self.program.words.next() - block.words.start as usize;
                let words_before = u16::try_from(words_before).unwrap_or(u16::MAX);
                block.inner_skip = Some(InnerSkip { level, words_before });
                Ok((rest, ()))
            }
            _ => {
                if block.body == Body::Empty {
                    block.body = Body::Words;
                }
                let (rest, word) = self.word(input, first)?;
                self.program.words.push(word);
                Ok((rest, ()))
            }
        }
    }
}

fn help_for(code: Code) -> &'static str {
    match code {
        Code::BAD_NUMBER => "write digits with one decimal point at most",
        Code::EXPONENT => "write the number out, without an exponent; if E is a word, put a blank before it",
        Code::MISSING_VALUE => "give the address a value, for example X10",
        Code::BAD_EXPRESSION => "complete or correct the expression",
        Code::UNCLOSED => "close it before the end of the block",
        Code::TOO_DEEP => "split the expression over several blocks",
        Code::MUST_STAND_ALONE => "move it to its own block",
        Code::BLOCK_TOO_LONG => "check that the file is a part program and still has its line ends",
        _ => "correct the block, or check --dialect",
    }
}
