//! Start and end of programs in a file: `%`, `O1234 (NAME)`, `%PM9001` and the line `N9001` after it.

use nom::Parser as _;
use nom::bytes::complete::take_while_m_n;
use nom::combinator::{map, opt, verify};
use nom::sequence::preceded;

use super::parser::Parser;
use super::token::{Input, Parsed, angled, blank, blanks, byte, is_blank, is_end, one, small_number};
use super::tree::{Part, PartKind};
use crate::syntax::{MAX_PARTS, tape};
use ncfix_base::source::Span;
use ncfix_dialect::Language;

/// Memories of the Grundig: the letters after `%`.
const MEMORIES: &[(&str, PartKind)] = &[
    ("PM", PartKind::Program),
    ("MM", PartKind::Macro),
    ("TM", PartKind::Tools),
    ("ZO", PartKind::ZeroOffsets),
    ("ZE", PartKind::ZeroOffsets),
    ("PO", PartKind::Points),
    ("PA", PartKind::Parameters),
    ("PL", PartKind::Pallets),
    ("MC", PartKind::MachineConstants),
];

/// Production `memory` (grundig): two letters that select a memory.
fn memory(input: Input<'_>) -> Parsed<'_, PartKind> {
    let kind_of = |letters: &[u8]| {
        let known = MEMORIES.iter().find(|(name, _)| letters.eq_ignore_ascii_case(name.as_bytes()));
        known.map_or(PartKind::Other, |&(_, kind)| kind)
    };
    map(take_while_m_n(2, 2, |byte: u8| byte.is_ascii_alphabetic()), kind_of).parse(input)
}

/// The letter of a block number, and blanks.
fn letter_n(input: Input<'_>) -> Parsed<'_, ()> {
    (one(|byte| byte.eq_ignore_ascii_case(&b'N')), blank).map(|_| ()).parse(input)
}

/// Production `tape` (fanuc): the relevant bytes of a tape, between its leader and its trailer.
///
/// Text before the first `%` and after the last one belongs to no program. A file with a single `%` at its end has no leader. The comments before the
/// first `%` of RS274/NGC stay.
pub(super) fn tape(bytes: &[u8], line_end: u8, language: Language) -> (usize, usize) {
    let all = (0, bytes.len());
    if language == Language::Grundig {
        return all;
    }
    // Only the first, the second and the last mark matter; a file may consist of marks only.
    let mut marks = tape::marks(bytes, line_end);
    let Some(first) = marks.next() else { return all };
    let has_leader = tape::is_leader(&bytes[..first.0], line_end, language);
    let start = if has_leader && language != Language::Rs274 { first.0 } else { 0 };
    let Some(second) = marks.next() else {
        // The mark opens the program, unless a program precedes it.
        return (start, if has_leader { bytes.len() } else { first.1 });
    };
    // RS274/NGC reads one program, from the first to the second mark.
    let end = if language == Language::Rs274 && has_leader { second } else { marks.last().unwrap_or(second) };
    (start, end.1)
}

impl Parser {
    /// Reads a line that begins or ends a program. Returns the rest of it, or all of it if it is not a header, to be read as a block.
    pub(super) fn header<'a>(&mut self, text: Input<'a>) -> Input<'a> {
        match (text.first(), self.language) {
            (Some(b'%'), Language::Grundig) => self.memory_header(text),
            (Some(b'N' | b'n'), Language::Grundig) if self.is_fresh => self.number_header(text),
            (Some(b'%'), _) => self.tape_mark(text),
            (Some(b'O' | b'o' | b':'), _) => self.program_header(text),
            (Some(b'<'), Language::Fanuc) => self.program_header(text),
            (Some(b'N' | b'n'), Language::Fanuc) => self.numbered_header(text),
            _ => text,
        }
    }

    /// Production `header` (grundig): `%PM`, `%PM9001`, `%PM N9001`, a single `%`.
    fn memory_header<'a>(&mut self, text: Input<'a>) -> Input<'a> {
        let Ok((mut rest, (_, _, kind, _, _))) = (byte(b'%'), blank, memory, blank, opt(letter_n)).parse(text) else {
            // An end mark of the transmission.
            self.open_part(PartKind::Program, None);
            self.is_fresh = true;
            return &text[text.len()..];
        };
        let number = small_number(rest, false).ok();
        self.open_part(kind, Some(text));
        self.is_fresh = true;
        if let (Some((behind, number)), Some(part)) = (number, self.program.parts.last_mut()) {
            part.number = Some(number);
            rest = blanks(behind);
            // `%PM9001 N9001`
            let second = preceded(letter_n, |input| small_number(input, false));
            if let Ok((behind, _)) = verify(second, |&second| second == number).parse(rest) {
                rest = behind;
            }
        }
        // Only a comment may follow; anything else is read as a block, which reports its errors.
        rest
    }

    /// Production `number_line` (grundig): `N9001 (NAME)` as the first line of a part, its number and only a comment.
    fn number_header<'a>(&mut self, text: Input<'a>) -> Input<'a> {
        self.is_fresh = false;
        let Ok((rest, number)) = preceded(letter_n, |input| small_number(input, false)).parse(text) else {
            return text;
        };
        let rest = blanks(rest);
        let part_number = self.program.parts.last().and_then(|part| part.number);
        if !is_end(rest, b"(") || part_number.is_some_and(|known| known != number) {
            return text;
        }
        let span = Span::new(self.offset(text), self.line_end);
        if let Some(part) = self.program.parts.last_mut() {
            part.number = Some(number);
            part.headers.push(span);
        }
        rest
    }

    /// `%` of a tape, perhaps with a program number: `%`, `%O1234`, `%100`.
    fn tape_mark<'a>(&mut self, text: Input<'a>) -> Input<'a> {
        self.program.has_tape_marks = true;
        self.open_part(PartKind::Program, None);
        let behind = blanks(&text[1..]);
        match behind.first() {
            Some(b'O' | b'o' | b':') => self.program_header(behind),
            Some(b'0'..=b'9') => {
                if let (Ok((_, number)), Some(part)) = (small_number(behind, true), self.program.parts.last_mut()) {
                    part.number = Some(number);
                    part.headers.push(Span::new(self.line_end - text.len(), self.line_end));
                }
                &text[text.len()..]
            }
            // Other text in the line of the tape mark is not a block.
            _ => &text[text.len()..],
        }
    }

    /// Productions `header` and `program` (fanuc) and `program` (rs274): `O1234 (NAME)`, `:1234`, `<NAME>`; an O-word of RS274/NGC is not a header.
    fn program_header<'a>(&mut self, text: Input<'a>) -> Input<'a> {
        if text.first() == Some(&b'<') {
            let Ok((rest, name)) = angled(text) else { return text };
            let name = self.intern(name);
            self.open_part(PartKind::Program, Some(text));
            if let Some(part) = self.program.parts.last_mut() {
                part.name = Some(name);
            }
            return rest;
        }
        let behind = blanks(&text[1..]);
        if let (Some(b'<'), Ok((rest, _))) = (behind.first(), angled(behind))
            && (self.language == Language::Fanuc || is_end(blanks(rest), b"(;"))
        {
            return self.program_header(behind);
        }
        let Ok((rest, number)) = small_number(behind, true) else { return text };
        if self.language == Language::Rs274 && !is_end(blanks(rest), b"(;") {
            return text;
        }
        self.open_part(PartKind::Program, Some(text));
        if let Some(part) = self.program.parts.last_mut() {
            part.number = Some(number);
        }
        rest
    }

    /// `N10 O1234 (NAME)`: a program number after a block number, followed only by comments.
    fn numbered_header<'a>(&mut self, text: Input<'a>) -> Input<'a> {
        let block_number = (letter_n, |input| small_number(input, true), blank);
        let program_number =
            (one(|byte| byte.eq_ignore_ascii_case(&b'O')), blank, |input| small_number(input, true), blank);
        let Ok((header, _)) = { block_number }.parse(text) else { return text };
        match { program_number }.parse(header) {
            Ok((rest, _)) if is_end(rest, b"(;") => self.program_header(header),
            _ => text,
        }
    }

    /// Stores the comment after a header as the title of the part, if nothing else follows.
    pub(super) fn title<'a>(&mut self, rest: Input<'a>) -> Input<'a> {
        let is_title =
            rest.first() == Some(&b'(') && rest.iter().position(|&byte| byte == b')') == Some(rest.len() - 1);
        let start = self.offset(rest);
        match self.program.parts.last_mut() {
            Some(part) if is_title => {
                part.title = Some(Span::new(start + 1, self.line_end - 1));
                &rest[rest.len()..]
            }
            _ => rest,
        }
    }

    /// Ends the header at a block in the same line (`O1234 G90 G0 X1`); as a part of the header it would be written twice.
    pub(super) fn end_header(&mut self, block: Input<'_>) {
        let end = self.offset(block);
        let source = self.program.source.clone();
        let header = self.program.parts.last_mut().and_then(|part| part.headers.last_mut());
        if let Some(header) = header.filter(|header| !block.is_empty() && header.end as usize == self.line_end) {
            let text = source.slice(Span::new(header.start as usize, end));
            let blank = text.iter().rev().take_while(|&&byte| is_blank(byte)).count();
            *header = Span::new(header.start as usize, end - blank);
        }
    }

    /// Ends the previous part and begins another one.
    pub(super) fn open_part(&mut self, kind: PartKind, header: Option<Input<'_>>) {
        self.close_part();
        if self.program.parts.len() >= MAX_PARTS {
            self.give_up_at_part();
            return;
        }
        let start = self.program.blocks.next();
        let headers = header.map(|text| Span::new(self.offset(text), self.line_end)).into_iter().collect();
        self.program.parts.push(Part {
            kind,
            number: None,
            name: None,
            headers,
            title: None,
            blocks: start..start,
            targets: 0..0,
        });
    }

    /// Ends the part; a part without header and blocks is dropped.
    pub(super) fn close_part(&mut self) {
        let end = self.program.blocks.next();
        if let Some(part) = self.program.parts.last_mut() {
            part.blocks.end = end;
            if part.headers.is_empty() && part.blocks.is_empty() {
                self.program.parts.pop();
            }
        }
    }
}

/// `true` if every byte has an even number of set bits and some have the eighth bit set: the parity bit of a serial line.
pub(super) fn has_parity(bytes: &[u8]) -> bool {
    let is_marked = |byte: &u8| *byte >= 0x80 && !is_blank(byte & 0x7f);
    bytes.iter().all(|byte| byte.count_ones() % 2 == 0) && bytes.iter().any(is_marked)
}
