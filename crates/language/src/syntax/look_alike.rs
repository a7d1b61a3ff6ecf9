//! Letters typed in place of digits: O for 0, and I or l for 1.

/// Addresses whose values are numbers in every language.
const ADDRESSES: &[u8] = b"ABCDFGHIJKLMNPQRSTUVWXYZ";
const ZERO: &str = "this is the letter O in place of the digit 0: write the digit";
const ONE: &str = "this is the letter I or l in place of the digit 1: write the digit";

/// The help for an error at `at` in a line, if the word there, or the one before it, is a number but for letters that look like digits.
fn help_at(line: &[u8], at: usize) -> Option<&'static str> {
    let before = line.get(..at)?;
    let joined = before.iter().rev().take_while(|byte| byte.is_ascii_alphanumeric()).count();
    for start in at - joined..=at {
        let after_letter = start.checked_sub(1).and_then(|place| line.get(place)).is_some_and(u8::is_ascii_alphabetic);
        if after_letter {
            continue;
        }
        let Some((length, help)) = number(line.get(start..)?) else { continue };
        if start + length >= at {
            return Some(help);
        }
    }
    // `GO X10.`: GO is also a control word, and the error is at the next word.
    let word = before.trim_ascii_end();
    whole(word.rsplit(u8::is_ascii_whitespace).next()?)
}

/// As [`help_at`], for an error at `at` in a text whose line ends at `end`.
pub(crate) fn help_in(text: &[u8], at: usize, end: usize) -> Option<&'static str> {
    let first = text.get(..at)?.iter().rposition(|&byte| matches!(byte, b'\n' | b'\r')).map_or(0, |place| place + 1);
    help_at(text.get(first..end)?, at - first)
}

/// The help for a word that is one address with a number but for such letters.
pub(crate) fn whole(word: &[u8]) -> Option<&'static str> {
    number(word).filter(|(length, _)| *length == word.len()).map(|(_, help)| help)
}

/// Length and help of an address with such a number at the start of a text.
fn number(text: &[u8]) -> Option<(usize, &'static str)> {
    let is_value = |byte: &u8| byte.is_ascii_digit() || b".+-OoIl".contains(byte);
    let (letter, rest) = text.split_first().filter(|(letter, _)| ADDRESSES.contains(&letter.to_ascii_uppercase()))?;
    let (value, behind) = rest.split_at(rest.iter().take_while(|byte| is_value(byte)).count());
    let ends = match behind {
        [] => true,
        // `GOX10`, but not the names `LOOP1` and `GOTO5`.
        [next, digit, ..] if next.is_ascii_alphabetic() => {
            let is_number = value.iter().any(u8::is_ascii_digit) || value.len() == 1 && b"GMgm".contains(letter);
            is_number && (digit.is_ascii_digit() || b".+-".contains(digit))
        }
        [next, ..] => !next.is_ascii_alphabetic() && !matches!(next, b'_' | b'=' | b'[' | b'('),
    };
    let has = |letters: &[u8]| value.iter().any(|byte| letters.contains(byte));
    let help = match () {
        () if !ends => return None,
        () if has(b"Oo") => ZERO,
        () if has(b"Il") && value.iter().any(u8::is_ascii_digit) => ONE,
        () => return None,
    };
    Some((1 + value.len(), help))
}

#[cfg(test)]
mod tests {
    use super::help_at;

    #[test]
    fn letters_in_numbers_are_named_and_names_are_not() {
        for (line, at, wanted) in [
            ("GO X10.", 0, Some("letter O")),
            ("N2 GO X10.", 6, Some("letter O")),
            ("GOX10.", 0, Some("letter O")),
            ("G0O X1", 2, Some("letter O")),
            ("G0XO", 2, Some("letter O")),
            ("XO", 1, Some("letter O")),
            ("MO6", 0, Some("letter O")),
            ("G0 X1O.", 5, Some("letter O")),
            ("Xl0", 0, Some("letter I or l")),
            ("G0l X1", 2, Some("letter I or l")),
            ("X Y1", 0, None),
            ("LOOP", 0, None),
            ("LOOP1", 0, None),
            ("TOOL1", 0, None),
            ("GOTO5 X", 6, None),
            ("TO_1", 0, None),
            ("G2 X1 I", 6, None),
        ] {
            let found = help_at(line.as_bytes(), at);
            assert_eq!(found.is_some(), wanted.is_some(), "{line}: {found:?}");
            assert!(wanted.is_none_or(|part| found.is_some_and(|found| found.contains(part))), "{line}: {found:?}");
        }
    }
}
