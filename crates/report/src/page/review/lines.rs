//! Program lines as templates and numbers: many lines differ only in their numbers, and a corrected program differs little from its original.

use std::collections::HashMap;

use super::packed::Packed;

/// Placeholder of a number in a template; the next character encodes the number of decimals.
const SLOT: char = '\u{1}';
/// Character of a number without a decimal point; a point without decimals is the next character, and so on.
const NO_POINT: u8 = 0x30;
/// Limits of decimals and value; numbers beyond them stay text.
const MOST_DECIMALS: usize = 6;
const MOST: i64 = 1 << 53;
/// Number of letters, plus one for numbers without a letter.
const LETTERS: usize = 27;

/// Number in a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Number {
    letter: usize,
    value: i64,
    /// Number of decimals; `None` without a decimal point.
    decimals: Option<usize>,
}

/// Texts of a review.
#[derive(Clone, Debug, Default)]
pub(super) struct Texts {
    templates: HashMap<String, i64>,
    /// Templates in the order of their numbers.
    all: Vec<String>,
    /// Maximum number of decimals of each letter, over all files.
    scales: [usize; LETTERS],
}

/// Program as text.
pub(super) struct PackedText<'a> {
    /// Decoded text: UTF-8 if valid, else Latin-1.
    text: std::borrow::Cow<'a, str>,
    end: char,
}

impl<'a> PackedText<'a> {
    pub(super) fn new(bytes: &'a [u8], line_end: u8) -> PackedText<'a> {
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text.into(),
            Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect::<String>().into(),
        };
        PackedText { text, end: char::from(line_end) }
    }

    /// Returns the lines without their line ends; no empty line after the last line end.
    pub(super) fn lines(&self) -> impl Iterator<Item = &str> {
        let text = self.text.strip_suffix(self.end).unwrap_or(&self.text);
        let is_any = !self.text.is_empty();
        text.split(self.end).filter(move |_| is_any).map(|line| line.trim_end_matches('\r'))
    }
}

impl Texts {
    /// Notes the number of decimals of the numbers.
    pub(super) fn learn(&mut self, text: &PackedText<'_>) {
        let (mut template, mut numbers) = (String::new(), Vec::new());
        for line in text.lines() {
            take_apart(line, &mut template, &mut numbers);
            for number in &numbers {
                let scale = &mut self.scales[number.letter];
                *scale = (*scale).max(number.decimals.unwrap_or(0));
            }
        }
    }

    /// Packs a text. Numbers of the corrected program are stored as differences from the `original`: from the last number of the same letter up to the line
    /// from which a line originates.
    pub(super) fn put(
        &mut self,
        name: &str,
        text: &PackedText<'_>,
        original: Option<(&PackedText<'_>, &[i64])>,
        packed: &mut Packed,
    ) {
        let mut of_lines = Vec::new();
        let mut of_letters: [Vec<i64>; LETTERS] = std::array::from_fn(|_| Vec::new());
        let (mut template, mut numbers) = (String::new(), Vec::new());
        let mut base = original.map(|(text, pairs)| (Base::new(text), pairs));
        for (place, line) in text.lines().enumerate() {
            take_apart(line, &mut template, &mut numbers);
            of_lines.push(self.number_of(&template));
            let known = match &mut base {
                Some((base, pairs)) => base.up_to(pairs.get(place).copied().unwrap_or(0), &self.scales),
                None => [0; LETTERS],
            };
            for number in &numbers {
                let value = scaled(number, &self.scales) - known[number.letter];
                of_letters[number.letter].push(value);
            }
        }
        packed.put(format!("text.{name}.template"), &of_lines);
        for (letter, values) in of_letters.iter().enumerate().filter(|(_, values)| !values.is_empty()) {
            let name = format!("text.{name}.{}", letter_name(letter));
            if base.is_some() { packed.put_in(name, values, 1) } else { packed.put(name, values) }
        }
    }

    fn number_of(&mut self, template: &str) -> i64 {
        if let Some(known) = self.templates.get(template) {
            return *known;
        }
        let number = self.all.len() as i64;
        self.templates.insert(template.to_owned(), number);
        self.all.push(template.to_owned());
        number
    }

    /// Returns the templates by number, and the decimals by letter.
    pub(super) fn header(self) -> (Vec<String>, serde_json::Map<String, serde_json::Value>) {
        let scales = self.scales.iter().enumerate().map(|(letter, scale)| (letter_name(letter), (*scale).into()));
        (self.all, scales.collect())
    }
}

/// Last number of each letter in the lines of an original.
struct Base<'a> {
    lines: Box<dyn Iterator<Item = &'a str> + 'a>,
    line: i64,
    last: [i64; LETTERS],
    template: String,
    numbers: Vec<Number>,
}

impl<'a> Base<'a> {
    fn new(text: &'a PackedText<'_>) -> Base<'a> {
        let lines = Box::new(text.lines());
        Base { lines, line: 0, last: [0; LETTERS], template: String::new(), numbers: Vec::new() }
    }

    /// Returns the numbers up to a line; lines must not decrease.
    fn up_to(&mut self, line: i64, scales: &[usize; LETTERS]) -> [i64; LETTERS] {
        while self.line < line
            && let Some(next) = self.lines.next()
        {
            take_apart(next, &mut self.template, &mut self.numbers);
            for number in &self.numbers {
                self.last[number.letter] = scaled(number, scales);
            }
            self.line += 1;
        }
        self.last
    }
}

/// Returns a number in units of the last decimal of its letter.
fn scaled(number: &Number, scales: &[usize; LETTERS]) -> i64 {
    let more = scales[number.letter].saturating_sub(number.decimals.unwrap_or(0));
    number.value * 10_i64.pow(more as u32)
}

fn letter_name(letter: usize) -> String {
    if letter + 1 == LETTERS { "_".into() } else { char::from(b'A' + letter as u8).into() }
}

/// Splits a line so that it can be reassembled character by character.
fn take_apart(line: &str, template: &mut String, numbers: &mut Vec<Number>) {
    template.clear();
    numbers.clear();
    let bytes = line.as_bytes();
    let mut letter = LETTERS - 1;
    // Text up to here is in the template.
    let (mut done, mut at) = (0, 0);
    while let Some(&byte) = bytes.get(at) {
        let is_start = byte.is_ascii_digit() || byte == b'-' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit);
        if !is_start {
            if byte.is_ascii_alphabetic() {
                letter = usize::from(byte.to_ascii_uppercase() - b'A');
            }
            at += 1;
            continue;
        }
        let end = number_end(bytes, at);
        if let Some(number) = line.get(at..end).and_then(|text| read(text, letter)) {
            push_text(template, line.get(done..at).unwrap_or_default());
            template.push(SLOT);
            template.push(char::from(NO_POINT + number.decimals.map_or(0, |decimals| decimals as u8 + 1)));
            numbers.push(number);
            done = end;
        }
        at = end;
    }
    push_text(template, line.get(done..).unwrap_or_default());
}

/// Appends text of a line; it cannot contain a placeholder.
fn push_text(template: &mut String, text: &str) {
    template
        .extend(text.chars().map(|character| if character == SLOT { char::REPLACEMENT_CHARACTER } else { character }));
}

/// Returns the position after sign, digits, and a decimal point with digits.
fn number_end(bytes: &[u8], start: usize) -> usize {
    let digits = |from: usize| from + bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let whole = digits(start + usize::from(bytes[start] == b'-'));
    if bytes.get(whole) == Some(&b'.') { digits(whole + 1) } else { whole }
}

/// Reads a number that can be written back unchanged; `None` for `007` and `-0`, and for numbers with too many digits.
fn read(text: &str, letter: usize) -> Option<Number> {
    let (sign, bare) = text.strip_prefix('-').map_or((1, text), |bare| (-1, bare));
    let (whole, part) = bare.split_once('.').map_or((bare, None), |(whole, part)| (whole, Some(part)));
    let decimals = part.map(str::len);
    if whole.len() > 1 && whole.starts_with('0') || decimals.is_some_and(|decimals| decimals > MOST_DECIMALS) {
        return None;
    }
    let digits = format!("{whole}{}", part.unwrap_or_default());
    let value: i64 = digits.parse().ok()?;
    // With all decimals that its letter may have.
    let is_small = value < MOST / 10_i64.pow((MOST_DECIMALS - decimals.unwrap_or(0)) as u32);
    (is_small && !(value == 0 && sign < 0)).then_some(Number { letter, value: sign * value, decimals })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reassembles a line like the page.
    fn together(template: &str, numbers: &[Number]) -> String {
        let mut out = String::new();
        let mut numbers = numbers.iter();
        let mut characters = template.chars();
        while let Some(character) = characters.next() {
            if character != SLOT {
                out.push(character);
                continue;
            }
            let (number, kind) = (numbers.next().unwrap(), characters.next().unwrap() as u8 - NO_POINT);
            assert_eq!(kind, number.decimals.map_or(0, |decimals| decimals as u8 + 1));
            let decimals = number.decimals.unwrap_or(0);
            let digits = format!("{:0width$}", number.value.abs(), width = decimals + 1);
            let (whole, part) = digits.split_at(digits.len() - decimals);
            out.push_str(if number.value < 0 { "-" } else { "" });
            out.push_str(whole);
            if number.decimals.is_some() {
                out.push('.');
                out.push_str(part);
            }
        }
        out
    }

    #[test]
    fn lines_come_out_as_they_went_in() {
        for line in [
            "N120 G1 X-10.500 Y.5 Z+3 F1000.",
            "G01 M03 X-0 Y-0.000 Z-0.001 A=IC(-3)",
            "; 12345678901234567890 and 0.1234567 and 9007199254.740993",
            "R1=R2--3 X1=-4.5.6 ü-1 −2",
            "",
            "-",
            "1.",
        ] {
            let (mut template, mut numbers) = (String::new(), Vec::new());
            take_apart(line, &mut template, &mut numbers);
            assert_eq!(together(&template, &numbers), line);
        }
        let (mut template, mut numbers) = (String::new(), Vec::new());
        take_apart("N5 X-1.50", &mut template, &mut numbers);
        assert_eq!(template, "N\u{1}0 X\u{1}3");
        assert_eq!((numbers[0].value, numbers[1].value), (5, -150));
        take_apart("a\u{1}b", &mut template, &mut numbers);
        assert_eq!(template, "a\u{fffd}b");
    }

    #[test]
    fn lines_have_no_ends_and_bytes_that_are_no_utf_8_are_latin_1() {
        let lines = |bytes: &[u8]| PackedText::new(bytes, b'\n').lines().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(lines(b"a\r\n\nb"), ["a", "", "b"]);
        assert_eq!(lines(b"a\n"), ["a"]);
        assert_eq!(lines(b"\xfcber"), ["über"]);
        assert!(lines(b"").is_empty());
    }
}
