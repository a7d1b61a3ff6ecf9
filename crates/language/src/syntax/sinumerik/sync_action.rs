//! Synchronized actions: `[ID=n] [WHEN condition] DO actions`, parsed only as far as needed to locate their parts.

use super::block::{Draft, Parser};
use super::token::{Input, Parsed, blanks, fault, identifier, is_name_byte};
use super::tree::Body;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Keywords that define the evaluation of the condition.
const SCANS: [&[u8]; 4] = [b"WHEN", b"WHENEVER", b"EVERY", b"FROM"];

impl Parser {
    /// Production `synchronised`: a synchronized action from its first word to the comment.
    ///
    /// Its parts are located by their keywords outside brackets and strings, with a scanner: they are not words of this language.
    pub(super) fn synchronised<'a>(&mut self, input: Input<'a>, draft: &mut Draft) -> Parsed<'a, Body> {
        let (body, comment) = self.without_comment(input)?;
        if let Some(comment) = comment {
            self.comment(comment, draft);
        }
        let base = self.offset(input);
        // The rest of the line including its comment, which determines positions.
        let full = |rest: Input<'a>| &input[body.len() - rest.len()..];
        let span = |from: Input<'a>, length: usize| {
            let start = base + body.len() - from.len();
            Span::new(start, start + from[..length].trim_ascii_end().len())
        };
        let mut rest = body;
        let mut id = None;
        let mut condition = None;
        loop {
            rest = blanks(rest);
            let Ok((behind, word)) = identifier(rest) else {
                return fault(
                    Code::UNEXPECTED,
                    full(rest),
                    1,
                    "ID, WHEN, WHENEVER, EVERY, FROM or DO was expected here",
                );
            };
            let upper = word.to_ascii_uppercase();
            let value = blanks(behind);
            if matches!(upper.as_slice(), b"ID" | b"IDS") && id.is_none() && condition.is_none() {
                if value.first() != Some(&b'=') {
                    return fault(
                        Code::MISSING_VALUE,
                        rest,
                        word.len(),
                        "the number of the synchronized action is missing",
                    );
                }
                let start = blanks(&value[1..]);
                let end = self.keyword_at(start, &[b"WHEN", b"WHENEVER", b"EVERY", b"FROM", b"DO"]);
                let Some(end) = end.filter(|&end| end > 0) else {
                    return fault(
                        Code::UNEXPECTED,
                        full(start),
                        1,
                        "a number and then WHEN … DO or DO were expected here",
                    );
                };
                id = Some(span(start, end));
                rest = &start[end..];
            } else if SCANS.contains(&upper.as_slice()) && condition.is_none() {
                let Some(end) = self.keyword_at(value, &[b"DO"]).filter(|&end| end > 0) else {
                    return fault(
                        Code::UNEXPECTED,
                        rest,
                        word.len(),
                        "a condition and DO were expected after this word",
                    );
                };
                condition = Some(span(value, end));
                rest = &value[end..];
            } else if upper == b"DO" {
                if value.is_empty() {
                    return fault(Code::UNEXPECTED, full(rest), word.len(), "an action was expected after DO");
                }
                let whole = span(body, body.len());
                let actions = span(value, value.len());
                let none = Span::new(base, base);
                let body =
                    Body::Synchronised { whole, id: id.unwrap_or(none), condition: condition.unwrap_or(none), actions };
                return Ok((&input[input.len()..], body));
            } else {
                return fault(
                    Code::UNEXPECTED,
                    rest,
                    word.len(),
                    "WHEN, WHENEVER, EVERY, FROM or DO was expected here",
                );
            }
        }
    }

    /// The text before the comment, and the comment. Brackets and quotation marks must be closed.
    fn without_comment<'a>(
        &self,
        input: Input<'a>,
    ) -> Result<(Input<'a>, Option<Input<'a>>), nom::Err<super::token::Fault>> {
        let mut open = Vec::new();
        let mut quote = None;
        let mut end = input.len();
        for (at, &byte) in input.iter().enumerate() {
            match (byte, quote) {
                (b'"', Some(_)) => quote = None,
                (_, Some(_)) => {}
                (b'"', None) => quote = Some(at),
                (b'(' | b'[', None) => open.push(at),
                (b')' | b']', None) => {
                    let closed = open.pop();
                    if closed.is_none() {
                        let message = "this bracket closes nothing";
                        return fault(Code::UNEXPECTED, &input[at..], 1, message).map(|(rest, ())| (rest, None));
                    }
                }
                (b';', None) => {
                    end = at;
                    break;
                }
                _ => {}
            }
        }
        if let Some(&at) = quote.as_ref().or(open.last()) {
            let message = "this is not closed in the block";
            return fault(Code::UNCLOSED, &input[at..], 1, message).map(|(rest, ())| (rest, None));
        }
        Ok((&input[..end], (end < input.len()).then_some(&input[end..])))
    }

    /// The position at which one of the words begins outside brackets and quotation marks.
    fn keyword_at(&self, input: Input<'_>, words: &[&[u8]]) -> Option<usize> {
        let (mut depth, mut quoted, mut at) = (0_u32, false, 0);
        while let Some(&byte) = input.get(at) {
            match byte {
                b'"' => quoted = !quoted,
                _ if quoted => {}
                b'(' | b'[' => depth += 1,
                b')' | b']' => depth = depth.saturating_sub(1),
                _ if is_name_byte(byte) || byte == b'$' => {
                    let length = input[at..].iter().take_while(|&&b| is_name_byte(b) || b == b'$').count();
                    let word = &input[at..at + length];
                    if depth == 0 && words.iter().any(|known| known.eq_ignore_ascii_case(word)) {
                        return Some(at);
                    }
                    at += length - 1;
                }
                _ => {}
            }
            at += 1;
        }
        None
    }
}
