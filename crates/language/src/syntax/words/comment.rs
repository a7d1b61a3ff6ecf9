//! Comments, including the active comments of RS274/NGC.

use nom::Parser as _;
use nom::branch::alt;
use nom::bytes::complete::{tag_no_case, take_till};
use nom::combinator::rest as rest_of_line;
use nom::sequence::{delimited, preceded};

use super::parser::Parser;
use super::token::{Fault, Input, Parsed, blanks, byte, fault, required};
use super::tree::{Comment, CommentKind};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;

/// Prefixes of active comments, each including its comma if it has one.
const ACTIVE: &[(&str, CommentKind)] = &[
    ("MSG,", CommentKind::Message),
    ("DEBUG,", CommentKind::Debug),
    ("PRINT,", CommentKind::Print),
    ("LOG,", CommentKind::Log),
    ("LOGOPEN,", CommentKind::Log),
    ("LOGAPPEND,", CommentKind::Log),
    ("LOGCLOSE", CommentKind::Log),
    ("PROBEOPEN", CommentKind::Probe),
    ("PROBECLOSE", CommentKind::Probe),
];

/// Production `comment` (fanuc, rs274, grundig): `(…)` or `;…`, the text within.
fn comment(input: Input<'_>, language: Language) -> Parsed<'_, &[u8]> {
    alt((preceded(byte(b';'), rest_of_line), |input| in_brackets(input, language))).parse(input)
}

fn in_brackets(input: Input<'_>, language: Language) -> Parsed<'_, &[u8]> {
    let brackets = delimited(byte(b'('), take_till(|byte| byte == b')'), byte(b')'));
    let (rest, inner) = required(brackets, Code::UNCLOSED, 1, "this comment is not closed in the block")(input)?;
    let Some(open) = inner.iter().position(|&byte| byte == b'(') else { return Ok((rest, inner)) };
    match nested_end(input).filter(|&end| language == Language::Fanuc && has_no_word(&input[inner.len() + 2..end])) {
        Some(end) => Ok((&input[end + 1..], &input[1..end])),
        None => fault(Code::UNEXPECTED, &input[1 + open..], 1, "a comment must not contain another one"),
    }
}

/// Production `inner` (fanuc): the offset of the parenthesis that closes the first one.
fn nested_end(input: Input<'_>) -> Option<usize> {
    let mut depth = 0_usize;
    input.iter().position(|byte| {
        match byte {
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0
    })
}

/// `true` if a text has no word with a value. A control that ends the comment at the first closing parenthesis then stops at the rest, and no other
/// motion can result.
fn has_no_word(text: &[u8]) -> bool {
    let begins_value = |byte: u8| byte.is_ascii_digit() || b"+-.#[=".contains(&byte);
    let mut last = b' ';
    !text.iter().filter(|byte| !byte.is_ascii_whitespace()).any(|&byte| {
        let is_word = byte == b'#' || last.is_ascii_alphabetic() && begins_value(byte);
        last = byte;
        is_word
    })
}

impl Parser {
    /// A comment, which is stored.
    pub(super) fn comment<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let (rest, inner) = comment(input, self.language)?;
        let start = self.offset(input);
        let inner_start = start + 1;
        let inner_end = inner_start + inner.len();
        let mut comment = Comment {
            span: Span::new(start, self.offset(rest)),
            text: Span::new(inner_start, inner_end),
            kind: CommentKind::Plain,
        };
        if self.language == Language::Rs274 && input.first() == Some(&b'(') {
            let text = blanks(inner);
            let behind = |word: &'static str| tag_no_case::<_, _, Fault>(word)(text).ok().map(|(behind, _)| behind);
            if let Some((behind, kind)) = ACTIVE.iter().find_map(|&(word, kind)| Some((behind(word)?, kind))) {
                comment.kind = kind;
                comment.text = Span::new(inner_end - behind.len(), inner_end);
            }
        }
        self.program.comments.push(comment);
        Ok((rest, ()))
    }
}
