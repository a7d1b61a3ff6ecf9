//! Comments: the marks of added lines, and texts that cannot end a comment early.

use crate::path::{CONTINUES, CONTINUES_ON_THE_SPOT, ON_THE_SPOT, Piece};

/// The comment of an added piece; `None` for a piece that the source has.
pub(super) fn mark_of(piece: &Piece) -> Option<&'static str> {
    match (piece.take_up, piece.first) {
        (true, true) => Some(ON_THE_SPOT),
        (true, false) => Some(CONTINUES_ON_THE_SPOT),
        (false, false) => Some(CONTINUES),
        (false, true) => None,
    }
}

/// Converts a comment of the source, `( … )` or `; …`, or a text into a comment in parentheses: plain ASCII without inner parentheses.
pub(super) fn in_parentheses(comment: &[u8]) -> Vec<u8> {
    let text = comment.trim_ascii();
    let text = match text.strip_prefix(b"(") {
        Some(text) => text.strip_suffix(b")").unwrap_or(text),
        None => text.strip_prefix(b";").unwrap_or(text).trim_ascii(),
    };
    let mut out = Vec::with_capacity(text.len() + 2);
    out.push(b'(');
    // Each non-ASCII byte becomes one character, as the encoding of the source is unknown.
    out.extend(text.iter().map(|&byte| match byte {
        b'(' | b')' | b'\t' => b' ',
        b' '..=b'~' => byte,
        _ => b'_',
    }));
    out.push(b')');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_in_parentheses_ends_where_it_should() {
        for (source, comment) in [
            ("(FACE MILL)", "(FACE MILL)"),
            ("; roughing ", "(roughing)"),
            ("(A (B) C)", "(A  B  C)"),
            ("(A) (B)", "(A   B)"),
            ("(open", "(open)"),
            ("plain", "(plain)"),
            ("(\u{d8} 10)", "(__ 10)"),
            ("()", "()"),
        ] {
            assert_eq!(String::from_utf8(in_parentheses(source.as_bytes())).unwrap(), comment, "{source}");
        }
    }
}
