//! Common elements of all parsers: their input, their error type, blanks, and combinators.
//!
//! Inputs are the rest of one line; the number of remaining bytes determines a position. A parser that does not match returns an error, after which
//! alternatives are tried. A failure is final and is reported.

use nom::bytes::complete::{take_while, take_while1};
use nom::error::{ErrorKind, ParseError};
use nom::sequence::preceded;
use nom::{IResult, Parser};

use ncfix_base::diagnostic::Code;

/// The rest of a line.
pub(super) type Input<'a> = &'a [u8];
/// Result of a parser.
pub(super) type Parsed<'a, T> = IResult<Input<'a>, T, Fault>;

/// Reason of a parser failure.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    pub(super) code: Code,
    /// Number of bytes of the line that remain at the position of the error.
    pub(super) left: usize,
    /// Number of affected bytes; at least 1 is shown.
    pub(super) length: usize,
    pub(super) message: &'static str,
}

impl ParseError<Input<'_>> for Fault {
    fn from_error_kind(input: Input<'_>, _kind: ErrorKind) -> Self {
        Fault { code: Code::UNEXPECTED, left: input.len(), length: 1, message: "this cannot be read" }
    }

    fn append(_input: Input<'_>, _kind: ErrorKind, other: Self) -> Self {
        other
    }
}

/// A failure without alternatives.
pub(super) fn fault<'a, T>(code: Code, at: Input<'a>, length: usize, message: &'static str) -> Parsed<'a, T> {
    Err(nom::Err::Failure(Fault { code, left: at.len(), length, message }))
}

/// Blanks, tabs, and the NULs and control bytes of paper tapes.
pub(super) fn is_blank(byte: u8) -> bool {
    byte <= b' ' || byte == 0x7f
}

/// Skips blanks.
pub(super) fn blanks(input: Input<'_>) -> Input<'_> {
    match input.first() {
        Some(&byte) if is_blank(byte) => skip_blanks(input),
        _ => input,
    }
}

/// A parser for any number of blanks, including none.
#[inline]
pub(super) fn blank(input: Input<'_>) -> Parsed<'_, ()> {
    Ok((blanks(input), ()))
}

/// A parser preceded by blanks.
#[inline]
pub(super) fn behind_blanks<'a, T>(
    parser: impl Parser<Input<'a>, Output = T, Error = Fault>,
) -> impl Parser<Input<'a>, Output = T, Error = Fault> {
    preceded(blank, parser)
}

/// One byte.
#[inline]
pub(super) fn byte<'a>(wanted: u8) -> impl Fn(Input<'a>) -> Parsed<'a, u8> {
    one(move |found| found == wanted)
}

/// One byte that satisfies a condition.
#[inline]
pub(super) fn one<'a>(is_wanted: impl Fn(u8) -> bool) -> impl Fn(Input<'a>) -> Parsed<'a, u8> {
    move |input| match input.split_first() {
        Some((&found, rest)) if is_wanted(found) => Ok((rest, found)),
        _ => no_match(input),
    }
}

/// The result of a parser that does not match.
#[inline]
pub(super) fn no_match<T>(input: Input<'_>) -> Parsed<'_, T> {
    Err(nom::Err::Error(Fault::from_error_kind(input, ErrorKind::Verify)))
}

/// A parser without alternatives: if it does not match, this failure is final. It is located at the start of the parser.
pub(super) fn required<'a, T>(
    mut parser: impl Parser<Input<'a>, Output = T, Error = Fault>,
    code: Code,
    length: usize,
    message: &'static str,
) -> impl FnMut(Input<'a>) -> Parsed<'a, T> {
    move |input| match parser.parse(input) {
        Err(nom::Err::Error(_)) => fault(code, input, length, message),
        found => found,
    }
}

/// `true` at the end of a line, or at its comment.
#[inline]
pub(super) fn is_end(input: Input<'_>, comments: &[u8]) -> bool {
    input.first().is_none_or(|byte| comments.contains(byte))
}

/// Letters, at least one.
pub(super) fn letters(input: Input<'_>) -> Parsed<'_, &[u8]> {
    take_while1(|byte: u8| byte.is_ascii_alphabetic())(input)
}

fn skip_blanks(input: Input<'_>) -> Input<'_> {
    take_while::<_, _, Fault>(is_blank)(input).map_or(input, |(rest, _)| rest)
}

/// Powers of ten that a double holds exactly.
pub(super) const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// The first position of a byte. It compares eight bytes at a time, as line searches dominate the parser's time.
pub(super) fn find_byte(bytes: &[u8], wanted: u8) -> Option<usize> {
    const LOW: u64 = 0x0101_0101_0101_0101;
    const HIGH: u64 = 0x8080_8080_8080_8080;
    let pattern = LOW * u64::from(wanted);
    let (words, _) = bytes.as_chunks::<8>();
    // A byte becomes zero if it is the wanted one; only then a borrow can set its eighth bit first.
    let has = |word: &[u8; 8]| {
        let different = u64::from_le_bytes(*word) ^ pattern;
        different.wrapping_sub(LOW) & !different & HIGH
    };
    let skipped = words.iter().take_while(|word| has(word) == 0).count() * 8;
    bytes[skipped..].iter().position(|&byte| byte == wanted).map(|place| skipped + place)
}

#[cfg(test)]
mod tests {
    use super::find_byte;

    #[test]
    fn bytes_are_found_at_any_place() {
        for length in 0..40 {
            let mut bytes = vec![0x8b; length];
            assert_eq!(find_byte(&bytes, b'\n'), None);
            for place in (0..length).rev() {
                bytes[place] = b'\n';
                assert_eq!(find_byte(&bytes, b'\n'), Some(place));
            }
        }
    }
}
