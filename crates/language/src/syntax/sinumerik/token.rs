//! The smallest elements: nom parsers over bytes for blanks, numbers, identifiers and strings.
//!
//! Inputs are the rest of one line; the number of remaining bytes determines a position.

use nom::Parser;
use nom::bytes::complete::{tag_no_case, take_till, take_while1};
use nom::combinator::{not, peek};
use nom::sequence::{delimited, preceded, terminated};

use ncfix_base::diagnostic::Code;

pub(super) use crate::syntax::token::{
    EXACT_POWERS, Fault, Input, Parsed, behind_blanks, blank, blanks, byte, fault, find_byte, is_blank, is_end,
    no_match, one, required,
};

/// A letter, digit or underscore.
pub(super) fn is_name_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// An identifier: letters, digits, underscores, and `$` before system variables.
pub(super) fn identifier(input: Input<'_>) -> Parsed<'_, &[u8]> {
    let start = one(|byte| byte.is_ascii_alphabetic() || byte == b'_' || byte == b'$');
    preceded(peek(start), take_while1(|byte| is_name_byte(byte) || byte == b'$')).parse(input)
}

/// A keyword in any case, not followed by further characters of a name.
pub(super) fn keyword<'a>(word: &'static str) -> impl Fn(Input<'a>) -> Parsed<'a, ()> {
    move |input| terminated(tag_no_case(word), not(one(is_name_byte))).map(|_| ()).parse(input)
}

/// Digits.
pub(super) fn digits(input: Input<'_>) -> Parsed<'_, &[u8]> {
    take_while1(|byte: u8| byte.is_ascii_digit())(input)
}

/// Digits as a number below 2³².
pub(super) fn small_number(input: Input<'_>) -> Parsed<'_, u32> {
    let (rest, text) = digits(input)?;
    let value = text.iter().try_fold(0_u32, |value, digit| value.checked_mul(10)?.checked_add(u32::from(digit - b'0')));
    match value {
        Some(value) => Ok((rest, value)),
        None => fault(Code::BAD_NUMBER, input, text.len(), "this number is too large here"),
    }
}

/// The bytes between quotation marks.
pub(super) fn string(input: Input<'_>) -> Parsed<'_, &[u8]> {
    let quoted = delimited(byte(b'"'), take_till(|byte| byte == b'"'), byte(b'"'));
    required(quoted, Code::UNCLOSED, 1, "this quotation mark is not closed in the block")(input)
}

/// A number as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) value: f64,
    /// Written without decimal point and exponent.
    pub(super) is_integer: bool,
}

/// Integers below 2⁵³ are exact as doubles.
const EXACT_MANTISSA: u64 = 1 << 53;

/// Production `number_value` without its sign: `10`, `10.`, `.5`, `1.5EX-3`: correctly rounded.
///
/// If mantissa and power of ten are both exact doubles, one multiplication or division rounds correctly (Clinger 1990). All other cases use the
/// standard library.
pub(super) fn number(input: Input<'_>) -> Parsed<'_, Number> {
    let mut mantissa: u64 = 0;
    let mut exponent: i32 = 0;
    let mut at = 0;
    let mut point = None;
    let mut digit_count = 0;
    while let Some(&byte) = input.get(at) {
        if byte.is_ascii_digit() {
            // Above 2⁵³ the exact path is not used, so a wrapped value has no effect.
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
            digit_count += 1;
        } else if byte == b'.' && point.is_none() {
            point = Some(at);
        } else {
            break;
        }
        at += 1;
    }
    if digit_count == 0 {
        return fault(Code::BAD_NUMBER, input, at.max(1), "a number was expected here");
    }
    let decimals = point.map_or(0, |point| at - point - 1);
    exponent -= i32::try_from(decimals).unwrap_or(i32::MAX);
    let digits_end = at;
    let has_exponent = matches!(input.get(at..at + 2), Some(mark) if mark.eq_ignore_ascii_case(b"EX"));
    let mut written_exponent = 0;
    if has_exponent {
        at += 2;
        let negative = match input.get(at) {
            Some(b'-') => {
                at += 1;
                true
            }
            Some(b'+') => {
                at += 1;
                false
            }
            _ => false,
        };
        let (rest, text) = match digits(&input[at..]) {
            Ok(parsed) => parsed,
            Err(_) => return fault(Code::BAD_NUMBER, input, at, "the exponent after EX has no digits"),
        };
        // Four digits suffice to decide between zero and overflow.
        let magnitude = text.iter().fold(0_i32, |value, digit| (value * 10 + i32::from(digit - b'0')).min(9999));
        written_exponent = if negative { -magnitude } else { magnitude };
        exponent = exponent.saturating_add(written_exponent);
        at = input.len() - rest.len();
    }
    if input.get(at) == Some(&b'.') {
        return fault(Code::BAD_NUMBER, input, at + 1, "this number has two decimal points");
    }
    let value = if digit_count <= 15 && mantissa < EXACT_MANTISSA && exponent.unsigned_abs() < 23 {
        let power = EXACT_POWERS[exponent.unsigned_abs() as usize];
        if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power }
    } else {
        slow_value(&input[..digits_end], written_exponent)
    };
    if !value.is_finite() {
        return fault(Code::BAD_NUMBER, input, at, "this number is too large");
    }
    Ok((&input[at..], Number { value, is_integer: point.is_none() && !has_exponent }))
}

/// The general case, by the standard library's correctly rounded conversion.
fn slow_value(digits: &[u8], exponent: i32) -> f64 {
    let mut text: String = digits.iter().map(|&byte| char::from(byte)).collect();
    text.push_str(&format!("e{exponent}"));
    text.parse().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_of_the_reference_are_read() {
        for (text, value, is_integer) in [
            ("10", 10.0, true),
            ("10.", 10.0, false),
            (".5", 0.5, false),
            ("1.874EX8", 1.874e8, false),
            ("0.1EX-5", 0.1e-5, false),
            ("30.4ex-4", 30.4e-4, false),
            ("007", 7.0, true),
            ("123456789012345678901", 123456789012345678901.0, true),
        ] {
            let (rest, number) = number(text.as_bytes()).unwrap();
            assert!(rest.is_empty(), "{text}");
            assert_eq!((number.value, number.is_integer), (value, is_integer), "{text}");
        }
    }

    #[test]
    fn a_plain_e_is_no_exponent_and_bad_numbers_are_refused() {
        assert_eq!(number(b"2E3").unwrap().0, b"E3");
        assert!(number(b".").is_err());
        assert!(number(b"1.2.3").is_err());
        assert!(number(b"1EX").is_err());
        assert!(number(b"1EX999").is_err());
    }

    proptest! {
        #[test]
        fn numbers_agree_with_the_standard_library(mantissa in any::<u64>(), decimals in 0_usize..25) {
            let digits = format!("{mantissa:025}");
            let text = format!("{}.{}", &digits[..25 - decimals], &digits[25 - decimals..]);
            let expected: f64 = text.parse().unwrap();
            prop_assert_eq!(number(text.as_bytes()).unwrap().1.value, expected);
            let short = format!("{}.{:03}", mantissa % 100_000, mantissa % 1000);
            prop_assert_eq!(number(short.as_bytes()).unwrap().1.value, short.parse::<f64>().unwrap());
        }
    }
}
