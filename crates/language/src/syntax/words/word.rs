//! Words: an address and its value, in the notation of each language.

use nom::Parser as _;
use nom::branch::alt;
use nom::bytes::complete::take_while1;
use nom::combinator::{map, not, opt, peek, recognize, success, value};
use nom::sequence::{preceded, terminated};

use super::node::Node;
use super::parser::Parser;
use super::token::{
    Input, Parsed, angled, behind_blanks, blank, blanks, byte, fault, number, one, required, small_number,
};
use super::tree::{Address, Value, Word};
use crate::syntax::firmware;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;

impl Parser {
    /// Production `word` (fanuc, rs274, grundig).
    pub(super) fn word<'a>(&mut self, input: Input<'a>, first: u8) -> Parsed<'a, Word> {
        if !first.is_ascii_alphabetic() {
            return self.special_word(input, first);
        }
        let letter = first.to_ascii_uppercase();
        let behind = blanks(&input[1..]);
        match behind.first() {
            Some(b'0'..=b'9' | b'.') => {
                let (rest, number) = number(behind, self.is_spaced())?;
                if !matches!(letter, b'G' | b'M' | b'N' | b'O' | b'T') && !self.calls_macro(rest) {
                    self.no_exponent(behind, rest)?;
                }
                if self.language == Language::Grundig
                    && !number.has_point
                    && let [b'=', value @ ..] = blanks(rest)
                {
                    return self.indexed_word(input, behind, letter, value);
                }
                let value = Value::Number { value: number.value, has_point: number.has_point, digits: number.digits };
                Ok((rest, self.word_between(input, rest, Address::Letter(letter), value)))
            }
            Some(b'=') if self.language == Language::Grundig => {
                let (rest, value) = self.assigned_value(&behind[1..])?;
                Ok((rest, self.word_between(input, rest, Address::Letter(letter), value)))
            }
            Some(_) => {
                let (rest, value) = self.value(input, behind)?;
                Ok((rest, self.word_between(input, rest, Address::Letter(letter), value)))
            }
            None => fault(Code::MISSING_VALUE, input, 1, "this address has no value"),
        }
    }

    /// `X1=…`: `index` begins with the digits, `value` is the text after the equals sign.
    fn indexed_word<'a>(
        &mut self,
        input: Input<'a>,
        index: Input<'a>,
        letter: u8,
        value: Input<'a>,
    ) -> Parsed<'a, Word> {
        let (_, number) = small_number(index, false)?;
        let Ok(number) = u16::try_from(number) else {
            return fault(Code::BAD_NUMBER, index, 1, "the index of an address has at most four digits");
        };
        let (rest, value) = self.assigned_value(value)?;
        Ok((rest, self.word_between(input, rest, Address::Indexed(letter, number), value)))
    }

    /// Production `value` (grundig), after `=`: a plain number, or an expression.
    fn assigned_value<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Value> {
        let input = blanks(input);
        let no_operator = not(behind_blanks(|input| self.operator(input)));
        let alone = terminated(|input| self.signed_number(input), no_operator).parse(input);
        if let Ok((rest, value)) = alone {
            return Ok((rest, value));
        }
        if input.is_empty() {
            return fault(Code::MISSING_VALUE, input, 1, "a value is missing after '='");
        }
        let (rest, id) = self.expression(input)?;
        Ok((rest, Value::Expr(id)))
    }

    /// Rejects text like an exponent directly after a number, which begins at `from`: E, an optional sign, digits and no decimal point. No word
    /// language has exponents, so the control would read E as a separate word. On a Grundig, E is a parameter.
    #[inline]
    pub(super) fn no_exponent<'a>(&self, from: Input<'a>, rest: Input<'a>) -> Parsed<'a, ()> {
        match rest.first() {
            Some(b'E' | b'e') if self.language != Language::Grundig => no_digits_behind(from, rest),
            _ => Ok((rest, ())),
        }
    }

    /// `true` if the block calls a macro of a Fanuc before `rest`, so that an E with digits is an argument: `G65 P2 V0.2E41`. With a sign, it more likely is
    /// an exponent of the program that wrote the text.
    fn calls_macro(&self, rest: Input<'_>) -> bool {
        let [b'E' | b'e', b'0'..=b'9', ..] = rest else { return false };
        let bytes = self.program.source.bytes();
        let before = bytes.get(..self.offset(rest)).unwrap_or_default();
        let start = before.iter().rposition(|&byte| matches!(byte, b'\n' | b'\r')).map_or(0, |at| at + 1);
        let mut found = before.get(start..).unwrap_or_default().windows(3);
        self.language == Language::Fanuc
            && found.any(|text| text.eq_ignore_ascii_case(b"G65") || text.eq_ignore_ascii_case(b"G66"))
    }

    /// A number with an optional sign.
    fn signed_number<'a>(&self, input: Input<'a>) -> Parsed<'a, Value> {
        let (behind, sign) = alt((terminated(sign, blank), success(1.0))).parse(input)?;
        let (rest, number) = number(behind, self.is_spaced())?;
        if !self.calls_macro(rest) {
            self.no_exponent(behind, rest)?;
        }
        let value = sign * number.value;
        Ok((rest, Value::Number { value, has_point: number.has_point, digits: number.digits }))
    }

    /// Production `value` (fanuc, rs274): the value directly after a letter, which is the first byte of `input`, if it does not begin with a digit.
    fn value<'a>(&mut self, input: Input<'a>, behind: Input<'a>) -> Parsed<'a, Value> {
        let is_iso = self.language != Language::Grundig;
        match behind.first() {
            Some(b'+' | b'-') => match blanks(&behind[1..]).first() {
                Some(b'0'..=b'9' | b'.') => return self.signed_number(behind),
                Some(b'#' | b'[') if is_iso => {}
                Some(byte)
                    if self.language == Language::Rs274 && (byte.is_ascii_alphabetic() || b"+-".contains(byte)) => {}
                _ => return fault(Code::MISSING_VALUE, input, 2, "no value follows this sign"),
            },
            Some(b'#' | b'[') if is_iso => {}
            Some(byte) if self.language == Language::Rs274 && byte.is_ascii_alphabetic() => {}
            _ => {
                let message = match self.language {
                    Language::Grundig => "this address has no value; a value that is not a number needs '='",
                    _ => "this address has no value",
                };
                return fault(Code::MISSING_VALUE, input, 1, message);
            }
        }
        let (rest, id) = self.operand(behind)?;
        Ok((rest, Value::Expr(id)))
    }

    /// Words that do not begin with a letter: `#1=…`, `,C5`, `<NAME>`, `@10`, `^45`, `$1`.
    fn special_word<'a>(&mut self, input: Input<'a>, first: u8) -> Parsed<'a, Word> {
        match (first, self.language) {
            (b'#', Language::Fanuc | Language::Rs274) => self.assignment(input),
            (b',', Language::Fanuc) => {
                let letter = one(|byte| matches!(byte.to_ascii_uppercase(), b'A' | b'C' | b'R'));
                let behind_comma =
                    map(preceded((byte(b','), blank), peek(letter)), |letter| letter.to_ascii_uppercase());
                let message = "C, R or A with its value must follow a comma";
                let (behind, letter) = required(behind_comma, Code::UNEXPECTED, 2, message)(input)?;
                let (rest, word) = self.word(behind, letter)?;
                Ok((rest, self.word_between(input, rest, Address::Comma(letter), word.value)))
            }
            (b'<', Language::Fanuc) => {
                let (rest, name) = angled(input)?;
                let address = Address::Name(self.intern(name));
                Ok((rest, self.word_between(input, rest, address, Value::None)))
            }
            (b'$' | b'{', Language::Rs274) if firmware::is_command(input) => {
                fault(Code::UNEXPECTED, input, input.len(), firmware::COMMAND)
            }
            (b'@' | b'^' | b'$', Language::Rs274) => {
                let behind = blanks(&input[1..]);
                let (rest, value) = match behind.first() {
                    Some(b'0'..=b'9' | b'.') => self.signed_number(behind)?,
                    _ => self.value(input, behind)?,
                };
                Ok((rest, self.word_between(input, rest, Address::Letter(first), value)))
            }
            _ => fault(Code::UNEXPECTED, input, 1, "no word of this language begins like this"),
        }
    }

    /// Production `assignment` (fanuc, rs274): `#1=…`, `#[…]=…`, `#<name>=…`
    fn assignment<'a>(&mut self, input: Input<'a>) -> Parsed<'a, Word> {
        let (rest, variable) = self.parameter(input)?;
        let Ok((behind, _)) = behind_blanks(byte(b'=')).parse(rest) else {
            return fault(
                Code::MISSING_VALUE,
                input,
                input.len() - rest.len(),
                "a variable alone has no effect; '=' is missing",
            );
        };
        if self.program.expr(variable).node == Node::Parameter(0) && self.language == Language::Fanuc {
            return fault(Code::UNEXPECTED, input, 2, "#0 is always empty and cannot be assigned");
        }
        let (rest, id) = self.expression(behind)?;
        Ok((rest, self.word_between(input, rest, Address::Variable(variable), Value::Expr(id))))
    }

    fn word_between(&self, from: Input<'_>, to: Input<'_>, address: Address, value: Value) -> Word {
        Word { span: Span::new(self.offset(from), self.offset(to)), address, value }
    }
}

/// Refuses an exponent at the letter with which `rest` begins.
fn no_digits_behind<'a>(from: Input<'a>, rest: Input<'a>) -> Parsed<'a, ()> {
    let digits = take_while1(|byte: u8| byte.is_ascii_digit());
    let exponent = (one(|_| true), opt(sign), digits, not(byte(b'.')));
    match recognize(exponent).parse(rest) {
        Ok((_, exponent)) => {
            let length = from.len() - rest.len() + exponent.len();
            fault(Code::EXPONENT, from, length, "this number contains a letter")
        }
        Err(_) => Ok((rest, ())),
    }
}

/// The sign of a number.
fn sign(input: Input<'_>) -> Parsed<'_, f64> {
    alt((value(-1.0, byte(b'-')), value(1.0, byte(b'+')))).parse(input)
}
