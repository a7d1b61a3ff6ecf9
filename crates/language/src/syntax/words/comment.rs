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
fn comment(input: Input<'_>) -> Parsed<'_, &[u8]> {
    alt((preceded(byte(b';'), rest_of_line), in_brackets)).parse(input)
}

fn in_brackets(input: Input<'_>) -> Parsed<'_, &[u8]> {
    let brackets = delimited(byte(b'('), take_till(|byte| byte == b')'), byte(b')'));
    let (rest, inner) = required(brackets, Code::UNCLOSED, 1, "this comment is not closed in the block")(input)?;
    match inner.iter().position(|&byte| byte == b'(') {
        Some(open) => fault(Code::UNEXPECTED, &input[1 + open..], 1, "a comment must not contain another one"),
        None => Ok((rest, inner)),
    }
}

impl Parser {
    /// A comment, which is stored.
    pub(super) fn comment<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let (rest, inner) = comment(input)?;
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
