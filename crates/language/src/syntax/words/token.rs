//! The smallest elements of the word languages: numbers, keywords, `<names>`.

use nom::Parser;
use nom::bytes::complete::take_till;
use nom::combinator::value;
use nom::sequence::delimited;

use ncfix_base::diagnostic::Code;

pub(super) use crate::syntax::token::{
    EXACT_POWERS, Fault, Input, Parsed, behind_blanks, blank, blanks, byte, fault, find_byte, is_blank, is_end,
    letters, no_match, one, required,
};

/// A word in any case, with blanks allowed between its letters.
pub(super) fn keyword<'a>(word: &str) -> impl Fn(Input<'a>) -> Parsed<'a, ()> {
    move |input| {
        let mut rest = input;
        for letter in word.bytes() {
            (rest, _) = behind_blanks(one(|found| found.eq_ignore_ascii_case(&letter))).parse(rest)?;
        }
        Ok((rest, ()))
    }
}

/// The value of the first of these words that matches.
pub(super) fn one_of<'a, T: Copy>(words: &[(&str, T)]) -> impl Fn(Input<'a>) -> Parsed<'a, T> {
    move |input| {
        let first = input.first().map(u8::to_ascii_uppercase);
        let mut fitting = words.iter().filter(|(word, _)| word.as_bytes().first().copied() == first);
        let found = fitting.find_map(|&(word, meaning)| value(meaning, keyword(word)).parse(input).ok());
        found.map_or_else(|| no_match(input), Ok)
    }
}

/// An unsigned number as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) value: f64,
    pub(super) has_point: bool,
    /// Number of digits before the point.
    pub(super) digits: u8,
}

/// Production `number_text` (fanuc, rs274, grundig): `10`, `10.`, `.5`, `1.25`; blanks between the digits are ignored if `spaced`.
///
/// If the digits and the power of ten are both exact doubles, one division rounds correctly (Clinger 1990). All other cases use the standard library.
pub(super) fn number(input: Input<'_>, spaced: bool) -> Parsed<'_, Number> {
    let (at, whole, mantissa) = digits(input, 0, 0, spaced);
    let has_point = input.get(at) == Some(&b'.');
    let (at, decimals, mantissa) = if has_point { digits(input, at + 1, mantissa, spaced) } else { (at, 0, mantissa) };
    if whole + decimals == 0 {
        return fault(Code::BAD_NUMBER, input, at.max(1), "a number was expected here");
    }
    if input.get(at) == Some(&b'.') {
        return fault(Code::BAD_NUMBER, input, at + 1, "this number has two decimal points");
    }
    let value = match EXACT_POWERS.get(decimals) {
        Some(power) if whole + decimals <= 15 => mantissa as f64 / power,
        _ => slow_value(&input[..at]),
    };
    if !value.is_finite() {
        return fault(Code::BAD_NUMBER, input, at, "this number is too large");
    }
    let digits = u8::try_from(whole).unwrap_or(u8::MAX);
    Ok((&input[at..], Number { value, has_point, digits }))
}

/// Reads digits from a position and appends them to a mantissa. Returns the position after them, their number, and the new mantissa. Beyond 15 digits
/// the mantissa is not used, so it may wrap.
fn digits(input: Input<'_>, from: usize, mut mantissa: u64, spaced: bool) -> (usize, usize, u64) {
    let (mut at, mut count) = (from, 0);
    loop {
        while let Some(byte @ b'0'..=b'9') = input.get(at) {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
            at += 1;
            count += 1;
        }
        if !spaced || !input.get(at).is_some_and(|&byte| is_blank(byte)) {
            return (at, count, mantissa);
        }
        let rest = blanks(&input[at..]);
        if !matches!(rest.first(), Some(b'0'..=b'9' | b'.')) {
            return (at, count, mantissa);
        }
        at = input.len() - rest.len();
        if rest.first() == Some(&b'.') {
            return (at, count, mantissa);
        }
    }
}

/// The general case, by the standard library's correctly rounded conversion.
fn slow_value(digits: &[u8]) -> f64 {
    let text: String = digits.iter().filter(|byte| !is_blank(**byte)).map(|&byte| char::from(byte)).collect();
    text.parse().unwrap_or(f64::NAN)
}

/// A number of at most nine digits.
pub(super) fn small_number(input: Input<'_>, spaced: bool) -> Parsed<'_, u32> {
    let (mut rest, mut value, mut count) = (input, 0_u32, 0);
    loop {
        let at = if spaced && count > 0 { blanks(rest) } else { rest };
        match at {
            [byte @ b'0'..=b'9', behind @ ..] => {
                value = value.saturating_mul(10).saturating_add(u32::from(byte - b'0'));
                count += 1;
                rest = behind;
            }
            _ if count == 0 => return fault(Code::BAD_NUMBER, input, 1, "a whole number was expected here"),
            _ if value > 999_999_999 => {
                return fault(Code::BAD_NUMBER, input, input.len() - rest.len(), "this number has too many digits");
            }
            _ => return Ok((rest, value)),
        }
    }
}

/// The text between `<` and `>` at the beginning of the input.
pub(super) fn angled(input: Input<'_>) -> Parsed<'_, &[u8]> {
    required(byte(b'<'), Code::UNEXPECTED, 1, "a name between < and > was expected here")(input)?;
    let between = delimited(byte(b'<'), take_till(|byte| byte == b'>'), byte(b'>'));
    let (rest, name) = required(between, Code::UNCLOSED, 1, "this < is not closed in the block")(input)?;
    if blanks(name).is_empty() {
        return fault(Code::UNEXPECTED, input, name.len() + 2, "a name between < and > has at least one character");
    }
    Ok((rest, name))
}
