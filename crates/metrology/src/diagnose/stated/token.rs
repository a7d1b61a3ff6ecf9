//! Words, numbers and signs of a stated hypothesis, with their byte positions.

use ncfix_base::source::Span;

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token<'t> {
    /// A name: `EXX`, `T_head_C`, `lag`.
    Word(&'t str),
    /// A number without its sign.
    Number(f64),
    /// Any other character: `~`, `*`, `(`.
    Sign(char),
}

/// A token with its position.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TermPiece<'t> {
    pub(super) token: Token<'t>,
    pub(super) span: Span,
}

/// Splits a line into tokens; `offset` is the position of its first byte in the file.
pub(super) fn tokens(line: &str, offset: usize) -> Vec<TermPiece<'_>> {
    let mut out = Vec::new();
    let mut at = 0;
    while let Some(first) = line.get(at..).and_then(|rest| rest.chars().next()) {
        let rest = line.get(at..).unwrap_or_default();
        let is_number =
            first.is_ascii_digit() || (first == '.' && rest.as_bytes().get(1).is_some_and(u8::is_ascii_digit));
        let (token, length) = if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        } else if is_number {
            let length = number_length(rest.as_bytes());
            let text = rest.get(..length).unwrap_or_default();
            (Token::Number(text.parse().unwrap_or(f64::NAN)), length)
        } else if first.is_alphabetic() || first == '_' {
            let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
            (Token::Word(rest.get(..length).unwrap_or_default()), length)
        } else {
            (Token::Sign(first), first.len_utf8())
        };
        out.push(TermPiece { token, span: Span::new(offset + at, offset + at + length) });
        at += length;
    }
    out
}

/// Length of the number at the start: digits, a point, and an exponent only if digits follow it, so that a unit after the number is not part of it.
fn number_length(bytes: &[u8]) -> usize {
    let digits = |from: usize| bytes.iter().skip(from).take_while(|byte| byte.is_ascii_digit()).count();
    let mut length = digits(0);
    if bytes.get(length) == Some(&b'.') {
        length += 1 + digits(length + 1);
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
        let exponent = digits(length + 1 + sign);
        if exponent > 0 {
            length += 1 + sign + exponent;
        }
    }
    length
}
