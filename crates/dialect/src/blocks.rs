//! Blocks of word languages, read for recognition only: letters and numbers of a line, whatever its language is.
//!
//! A scanner and not a pattern: the meaning of a letter depends on the text before it, and up to a megabyte of blocks is read in this way.

/// Number of characters of a number that are considered.
const LONGEST: usize = 32;

/// Letter with its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LooseWord {
    /// Letter, upper case.
    pub(super) letter: u8,
    /// Number; `None` if it is a variable or an expression.
    pub(super) value: Option<f64>,
    /// Digits before the decimal point as written.
    pub(super) digits: usize,
    pub(super) has_point: bool,
}

/// Block of a program.
#[derive(Debug, Default)]
pub(super) struct LooseBlock {
    pub(super) words: Vec<LooseWord>,
}

impl LooseBlock {
    /// Reads a new line into this block. Lines with assignments, decisions or calls by name have no words.
    pub(super) fn read(&mut self, line: &[u8]) {
        self.words.clear();
        let mut at = 0;
        while let Some(&byte) = line.get(at) {
            match byte {
                b'(' => match line.get(at..).unwrap_or_default().iter().position(|&byte| byte == b')') {
                    Some(length) => at += length + 1,
                    None => return,
                },
                b';' => return,
                b'=' | b'"' => return self.words.clear(),
                _ if byte.is_ascii_alphabetic() => {
                    let behind = skip_blanks(line, at + 1);
                    if line.get(behind).is_some_and(u8::is_ascii_alphabetic) {
                        return self.words.clear();
                    }
                    at = self.word(byte.to_ascii_uppercase(), line, behind);
                }
                _ => at += 1,
            }
        }
    }

    /// Reads a new line whose blocks may contain names, calls and assignments. These are skipped; `X=…` is X with its number, or without a value.
    pub(super) fn read_around_names(&mut self, line: &[u8]) {
        self.words.clear();
        let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$');
        let length_of = |from: usize, takes: &dyn Fn(&u8) -> bool| {
            line.get(from..).unwrap_or_default().iter().take_while(|byte| takes(byte)).count()
        };
        let mut at = 0;
        while let Some(&byte) = line.get(at) {
            match byte {
                b'(' => at += length_of(at, &|byte| *byte != b')') + 1,
                b'"' => at += length_of(at + 1, &|byte| *byte != b'"') + 2,
                b';' => return,
                // Value of a name, or of an address with an index.
                b'=' => at += 1 + length_of(at + 1, &|byte| !byte.is_ascii_whitespace() && *byte != b'('),
                b'$' | b'_' => at += length_of(at, &is_name),
                _ if byte.is_ascii_alphabetic() => {
                    if line.get(at + 1).is_some_and(|next| next.is_ascii_alphabetic() || *next == b'_') {
                        at += length_of(at, &is_name);
                        continue;
                    }
                    let equals = skip_blanks(line, at + 1);
                    let is_assigned = line.get(equals) == Some(&b'=');
                    at = self.word(byte.to_ascii_uppercase(), line, if is_assigned { equals + 1 } else { at + 1 });
                    if line.get(skip_blanks(line, at)) == Some(&b'=') {
                        self.words.pop();
                    } else if is_assigned {
                        at += length_of(at, &|byte| !byte.is_ascii_whitespace() && *byte != b'(');
                    }
                }
                _ => at += 1,
            }
        }
    }

    /// Reads the number that begins at a position; returns the position after it.
    fn word(&mut self, letter: u8, line: &[u8], start: usize) -> usize {
        let is_part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'+' | b'-' | b' ' | b'\t');
        let length = line.get(start..).unwrap_or_default().iter().take_while(|byte| is_part(byte)).count();
        let mut text = [0; LONGEST];
        let mut used = 0;
        for &byte in
            line.get(start..start + length).unwrap_or_default().iter().filter(|byte| !byte.is_ascii_whitespace())
        {
            let Some(place) = text.get_mut(used) else { break };
            *place = byte;
            used += 1;
        }
        let text = text.get(..used).unwrap_or_default();
        let digits =
            text.iter().skip_while(|byte| !byte.is_ascii_digit()).take_while(|byte| byte.is_ascii_digit()).count();
        let has_point = text.contains(&b'.');
        let value = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
        self.words.push(LooseWord { letter, value, digits, has_point });
        start + length
    }

    /// The word of a letter.
    pub(super) fn word_of(&self, letter: u8) -> Option<LooseWord> {
        self.words.iter().find(|word| word.letter == letter).copied()
    }

    pub(super) fn has(&self, letter: u8) -> bool {
        self.word_of(letter).is_some()
    }

    pub(super) fn has_any(&self, letters: &[u8]) -> bool {
        letters.iter().any(|&letter| self.has(letter))
    }

    /// Returns the G codes in tenths.
    pub(super) fn codes(&self) -> impl Iterator<Item = u32> {
        let codes = self.words.iter().filter(|word| word.letter == b'G').filter_map(|word| word.value);
        codes.filter(|value| (0.0..1000.0).contains(value)).map(|value| (value * 10.0).round() as u32)
    }

    pub(super) fn has_code(&self, tenths: u32) -> bool {
        self.codes().any(|code| code == tenths)
    }

    pub(super) fn has_m(&self, number: f64) -> bool {
        self.words.iter().any(|word| word.letter == b'M' && word.value == Some(number))
    }
}

fn skip_blanks(line: &[u8], from: usize) -> usize {
    let blanks = line.get(from..).unwrap_or_default().iter().take_while(|byte| byte.is_ascii_whitespace()).count();
    from + blanks
}

/// Returns the lines of a text with the offset of their first byte.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut start = 0;
    bytes.split(|&byte| byte == b'\n' || byte == b'\r').map(move |line| {
        let at = start;
        start += line.len() + 1;
        (at, line)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_assignments_are_passed_over() {
        let mut block = LooseBlock::default();
        block.read_around_names(b"N10 G96S200 LIMS=2500 M4 X=R1*2 Z=IC(-3) M3=5 F=0.25 MSG(\"Y5\") T=\"Y3\" ; Y4");
        let found: Vec<(u8, Option<f64>)> = block.words.iter().map(|word| (word.letter, word.value)).collect();
        let expected = [
            (b'N', Some(10.0)),
            (b'G', Some(96.0)),
            (b'S', Some(200.0)),
            (b'M', Some(4.0)),
            (b'X', None),
            (b'Z', None),
            (b'F', Some(0.25)),
            (b'T', None),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn words_are_read_with_and_without_blanks_and_comments() {
        let mut block = LooseBlock::default();
        block.read(b"n10 G 0 1X-1.5 (Z99.) T0101 W#1 ; Y5");
        let found: Vec<(u8, Option<f64>)> = block.words.iter().map(|word| (word.letter, word.value)).collect();
        let expected = [(b'N', Some(10.0)), (b'G', Some(1.0)), (b'X', Some(-1.5)), (b'T', Some(101.0)), (b'W', None)];
        assert_eq!(found, expected);
        assert_eq!(block.word_of(b'T').map(|word| word.digits), Some(4));
        for line in ["IF[#1EQ2]GOTO10", "#1=5 X2", "CALL O100", "R1=5"] {
            block.read(line.as_bytes());
            assert!(block.words.is_empty(), "{line}");
        }
    }
}
