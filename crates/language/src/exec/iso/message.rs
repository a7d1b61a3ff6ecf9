//! Texts of `(DEBUG,…)`, `(PRINT,…)` and `(LOG,…)` of RS274/NGC: they show values, as the output has none of the variables.

use super::expression::Scope;
use crate::syntax::words::{Comment, CommentKind};
use ncfix_base::source::Span;
use ncfix_machine::snc::Kind;

/// Length at which a text is cut off, bytes, similar to LinuxCNC; values may be long.
const LONGEST: usize = 240;

impl Scope<'_, '_> {
    /// The element of a comment.
    pub(super) fn comment(&self, comment: &Comment) -> Kind {
        let source = &self.program.source;
        let opening = match comment.kind {
            CommentKind::Debug => "(DEBUG,",
            CommentKind::Print => "(PRINT,",
            CommentKind::Log if is_log_text(source.slice(comment.span)) => "(LOG,",
            _ => return Kind::Comment(source.slice(comment.span).to_vec()),
        };
        let mut text = opening.as_bytes().to_vec();
        self.show(source.slice(comment.text), comment.span, &mut text);
        text.truncate(LONGEST);
        text.push(b')');
        Kind::Comment(text)
    }

    /// Replaces `#1` and `#<name>` by values in LinuxCNC's format: six decimals, `%d` none, `%f` four, `%.2f` two.
    fn show(&self, mut text: &[u8], span: Span, out: &mut Vec<u8>) {
        let mut decimals = 6;
        while let Some((&first, rest)) = text.split_first().filter(|_| out.len() < LONGEST) {
            if first == b'%'
                && let Some((places, length)) = places(rest)
            {
                decimals = places;
                text = rest.get(length..).unwrap_or_default();
            } else if first == b'#'
                && let Some((value, length)) = self.shown(rest, span)
            {
                match value {
                    Some(value) => out.extend_from_slice(format!("{value:.decimals$}").as_bytes()),
                    None => out.push(b'?'),
                }
                text = rest.get(length..).unwrap_or_default();
            } else {
                // A single # would name a variable again.
                if first != b'#' {
                    out.push(first);
                }
                text = rest;
            }
        }
    }

    /// The value after a #, if any, and the length of its name.
    fn shown(&self, text: &[u8], span: Span) -> Option<(Option<f64>, usize)> {
        let digits = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
        if digits > 0 {
            let number = std::str::from_utf8(text.get(..digits)?).ok()?.parse().ok();
            return Some((number.and_then(|number| self.parameter(number, span).ok().flatten()), digits));
        }
        // Up to the next bracket of either kind: a text full of opening brackets must not be searched to its end from each.
        let inner = text.strip_prefix(b"<")?;
        let length = inner.iter().position(|byte| matches!(byte, b'<' | b'>'))?;
        let (name, behind) = inner.split_at_checked(length)?;
        let end = (behind.first() == Some(&b'>')).then_some(length + 1)?;
        let name = name.iter().filter(|byte| !byte.is_ascii_whitespace());
        let name = String::from_utf8(name.map(u8::to_ascii_uppercase).collect()).ok()?;
        Some((self.value_of_name(&name), end + 1))
    }
}

/// `true` if a comment writes a text into the file, not opens or closes it.
fn is_log_text(comment: &[u8]) -> bool {
    let mut bytes = comment.iter().filter(|byte| !byte.is_ascii_whitespace()).map(u8::to_ascii_uppercase);
    bytes.by_ref().take(5).eq(*b"(LOG,")
}

/// Number of decimals for `%d`, `%f` and `%.2f`, and the length of the specifier.
fn places(text: &[u8]) -> Option<(usize, usize)> {
    match text {
        [b'd', ..] => Some((0, 1)),
        [b'f', ..] => Some((4, 1)),
        [b'.', digit @ b'0'..=b'9', b'f', ..] => Some((usize::from(digit - b'0'), 3)),
        _ => None,
    }
}
