//! Macros: `DEFINE NAME AS …` replaces a name by any text, here and in definition files.

use std::collections::HashMap;
use std::sync::Arc;

use nom::Parser as _;
use nom::combinator::{opt, verify};
use nom::sequence::{delimited, preceded};

use super::block::{Draft, Parser};
use super::statement::before_comment;
use super::token::{Fault, Input, blank, digits, identifier, is_blank, is_name_byte, one};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Maximum bytes of an expanded line.
const MAX_LINE: usize = 4096;
/// Maximum nesting of macros.
const MAX_DEPTH: usize = 16;
/// Maximum replacements in one line.
const MAX_REPLACEMENTS: u32 = 1000;

/// Maximum bytes of all lines with macros together.
const MAX_TAIL_BYTES: usize = 1 << 24;

/// Macros by name, upper case.
#[derive(Clone, Debug, Default)]
pub struct Macros {
    texts: Arc<HashMap<Vec<u8>, Vec<u8>>>,
}

impl Macros {
    /// `true` if there are no macros.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.texts.is_empty()
    }

    /// Adds the macros of a definition file.
    pub fn read(&mut self, bytes: &[u8]) {
        for line in bytes.split(|&byte| byte == b'\n' || byte == b'\r') {
            if let Some((name, text)) = definition(line) {
                self.define(name, text);
            }
        }
    }

    pub(super) fn define(&mut self, name: &[u8], text: &[u8]) {
        Arc::make_mut(&mut self.texts).insert(name.to_ascii_uppercase(), text.to_vec());
    }

    /// The line with its macros replaced; `None` if it contains none.
    pub(super) fn expand(&self, line: &[u8]) -> Option<Result<Vec<u8>, Fault>> {
        if self.texts.is_empty() || definition(line).is_some() {
            return None;
        }
        let mut work = Expansion { macros: self, out: Vec::new(), active: Vec::new(), replaced: 0 };
        let result = work.run(line);
        if work.replaced == 0 {
            return None;
        }
        let too_long = |()| Fault {
            code: Code::BLOCK_TOO_LONG,
            left: line.len(),
            length: line.len(),
            message: "the macros of this block make it longer than 4096 bytes, or are nested too deeply",
        };
        Some(result.map_err(too_long).map(|()| work.out))
    }
}

impl Parser {
    /// Parses a block after macro expansion: its text is appended to the tail of the source.
    pub(super) fn expanded_block(
        &mut self,
        expanded: Result<Vec<u8>, Fault>,
        line: Span,
        draft: &mut Draft,
    ) -> Result<(), Fault> {
        let expanded = expanded?;
        let start = self.program.source.tail_start() + self.tail.len();
        let line_end = start + expanded.len();
        let offset = u32::try_from(self.tail.len())
            .ok()
            .filter(|_| self.tail.len() + expanded.len() <= MAX_TAIL_BYTES && u32::try_from(line_end).is_ok());
        let Some(offset) = offset else {
            let message = "the macros of the program make it too long";
            return Err(Fault { code: Code::BLOCK_TOO_LONG, left: 0, length: 1, message });
        };
        self.tail.extend_from_slice(&expanded);
        self.expanded.push((offset, line));
        let own_end = std::mem::replace(&mut self.line_end, line_end);
        draft.block.comment = Span::new(line_end, line_end);
        let result = self.bounded_block(&expanded, draft);
        self.line_end = own_end;
        result.map_err(|fault| Fault { left: line.range().len(), length: line.range().len(), ..fault })
    }
}

/// Production `macro`: name and text of a line `[N10] DEFINE NAME AS text [; comment]`.
pub(super) fn definition(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let number = opt((one(|byte| byte.eq_ignore_ascii_case(&b'N')), digits, blank));
    let name = delimited((whole("DEFINE"), blank), identifier, (blank, whole("AS"), blank));
    let (_, (name, text)) = preceded((blank, number), (name, before_comment)).parse(line).ok()?;
    let length = text.len() - text.iter().rev().take_while(|&&byte| is_blank(byte)).count();
    Some((name, &text[..length]))
}

/// Matches an identifier equal to this word.
fn whole<'a>(word: &'static str) -> impl nom::Parser<Input<'a>, Output = &'a [u8], Error = Fault> {
    verify(identifier, move |name: &[u8]| name.eq_ignore_ascii_case(word.as_bytes()))
}

/// A line during expansion.
struct Expansion<'m> {
    macros: &'m Macros,
    out: Vec<u8>,
    /// Macros under expansion: they are not expanded again in their text, so `DEFINE M6 AS M6 M8` terminates.
    active: Vec<&'m [u8]>,
    replaced: u32,
}

impl<'m> Expansion<'m> {
    fn run(&mut self, line: &[u8]) -> Result<(), ()> {
        let mut at = 0;
        while at < line.len() {
            let length = token_length(&line[at..]);
            let token = &line[at..at + length];
            at += length;
            let found = match token[0] {
                b';' => {
                    // A comment is copied unchanged.
                    self.push(&line[at - length..])?;
                    return Ok(());
                }
                first if first.is_ascii_alphabetic() || first == b'_' => {
                    self.macros.texts.get_key_value(&token.to_ascii_uppercase())
                }
                _ => None,
            };
            match found {
                Some((name, text)) if !self.active.contains(&name.as_slice()) => {
                    self.replaced += 1;
                    if self.replaced > MAX_REPLACEMENTS || self.active.len() == MAX_DEPTH {
                        return Err(());
                    }
                    self.separate(text.first());
                    self.active.push(name);
                    self.run(text)?;
                    self.active.pop();
                    self.separate(line.get(at));
                }
                _ => self.push(token)?,
            }
        }
        Ok(())
    }

    fn push(&mut self, bytes: &[u8]) -> Result<(), ()> {
        if self.out.len() + bytes.len() > MAX_LINE {
            return Err(());
        }
        self.out.extend_from_slice(bytes);
        Ok(())
    }

    /// Inserts a blank if two words would otherwise merge.
    fn separate(&mut self, next: Option<&u8>) {
        if self.out.last().is_some_and(|&byte| is_name_byte(byte)) && next.is_some_and(|&byte| is_name_byte(byte)) {
            self.out.push(b' ');
        }
    }
}

/// Length of the next token: a name, a letter with its digits, a number, a string, or one byte.
fn token_length(input: &[u8]) -> usize {
    let while_ =
        |start: usize, fits: fn(&u8) -> bool| start + input[start..].iter().take_while(|byte| fits(byte)).count();
    let quoted = |mark: u8| {
        let rest = input[1..].iter().position(|&byte| byte == mark);
        rest.map_or(input.len(), |length| length + 2)
    };
    match *input {
        [b'"', ..] => quoted(b'"'),
        [b'\'', ..] => quoted(b'\''),
        [b'$' | b'_', ..] => while_(1, |byte| is_name_byte(*byte) || *byte == b'$'),
        [first, second, ..] if first.is_ascii_alphabetic() && (second.is_ascii_alphabetic() || second == b'_') => {
            while_(1, |byte| is_name_byte(*byte))
        }
        [first, ..] if first.is_ascii_alphabetic() => while_(1, u8::is_ascii_digit),
        [first, ..] if first.is_ascii_digit() || first == b'.' => {
            let end = while_(0, |byte| byte.is_ascii_digit() || *byte == b'.').max(1);
            match input.get(end..end + 2) {
                Some(mark) if mark.eq_ignore_ascii_case(b"EX") => end + 2,
                _ => end,
            }
        }
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expanded(definitions: &str, line: &str) -> Option<String> {
        let mut macros = Macros::default();
        macros.read(definitions.as_bytes());
        let text = macros.expand(line.as_bytes())?;
        Some(text.map_or_else(|fault| fault.message.to_owned(), |text| String::from_utf8(text).unwrap()))
    }

    #[test]
    fn whole_words_are_replaced_and_nothing_in_texts_and_comments() {
        let definitions =
            "N10 DEFINE m6 AS L6 ; change\nDEFINE COOL AS M8 M88\r\nDEFINE VERT AS _AX\nDEFINE QUOTE AS MSG(\"a;b\")";
        for (line, expected) in [
            ("N10 T1 M6", Some("N10 T1 L6")),
            ("N10G0M6COOL", Some("N10G0 L6 M8 M88")),
            ("M66 M6=1 COOLER", Some("M66 L6=1 COOLER")),
            ("MSG(\"M6\") COOL ; M6", Some("MSG(\"M6\") M8 M88 ; M6")),
            ("X=1EX6 'H6' M60", None),
            ("POS[VERT]=1", Some("POS[_AX]=1")),
            ("QUOTE", Some("MSG(\"a;b\")")),
            ("DEFINE COOL AS M6", None),
            ("$COOL=1", None),
        ] {
            assert_eq!(expanded(definitions, line).as_deref(), expected, "{line}");
        }
    }

    #[test]
    fn macros_in_macros_end() {
        assert_eq!(expanded("DEFINE M6 AS T0 M6\nDEFINE TC AS M6 D1", "TC").as_deref(), Some("T0 M6 D1"));
        assert_eq!(expanded("DEFINE AA AS BB\nDEFINE BB AS AA", "AA").as_deref(), Some("AA"));
        let mut doubling = String::from("DEFINE A_0 AS\n");
        (1..40).for_each(|k| doubling.push_str(&format!("DEFINE A_{k} AS A_{0} A_{0}\n", k - 1)));
        assert!(expanded(&doubling, "A_39").unwrap().contains("nested too deeply"));
        let mut long = String::from("DEFINE A_0 AS X1111111111\n");
        (1..14).for_each(|k| long.push_str(&format!("DEFINE A_{k} AS A_{0} A_{0}\n", k - 1)));
        assert!(expanded(&long, "A_13").unwrap().contains("longer than"));
    }
}
