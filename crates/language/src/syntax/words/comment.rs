//! Comments, and those of RS274/NGC that do something.

use super::parser::Parser;
use super::token::{Input, Parsed, blanks, fault};
use super::tree::{Comment, CommentKind};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;

/// How active comments begin, and whether a comma follows.
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

impl Parser {
    /// `(…)` or `;…`
    pub(super) fn comment<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let (rest, inner) = if input.first() == Some(&b';') {
            (&input[input.len()..], &input[1..])
        } else {
            let Some(length) = input.iter().position(|&byte| byte == b')') else {
                return fault(Code::UNCLOSED, input, 1, "this comment is not closed in the block");
            };
            let inner = &input[1..length];
            if let Some(open) = inner.iter().position(|&byte| byte == b'(') {
                let left = &input[1 + open..];
                return fault(Code::UNEXPECTED, left, 1, "a comment must not hold another one");
            }
            (&input[length + 1..], inner)
        };
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
            let begins = |word: &str| text.get(..word.len()).is_some_and(|t| t.eq_ignore_ascii_case(word.as_bytes()));
            if let Some(&(word, kind)) = ACTIVE.iter().find(|(word, _)| begins(word)) {
                comment.kind = kind;
                comment.text = Span::new(inner_end - text.len() + word.len(), inner_end);
            }
        }
        self.program.comments.push(comment);
        Ok((rest, ()))
    }
}
