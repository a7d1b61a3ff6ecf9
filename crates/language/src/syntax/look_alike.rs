//! Letters typed in place of digits: O for 0, and I or l for 1.

/// Addresses whose values are numbers in every language. A name such as `LOOP` begins with one of them too, but has other letters.
const ADDRESSES: &[u8] = b"ABCDFGHIJKLMNPQRSTUVWXYZ";

const LETTER_O: &str = "this is the letter O in place of the digit 0: write the digit";

/// The help for an error at `at` in a line, if the word there is a number but for letters that look like digits.
pub(crate) fn help_at(line: &[u8], at: usize) -> Option<&'static str> {
    let is_address = |byte: &u8| ADDRESSES.contains(&byte.to_ascii_uppercase());
    let is_value = |byte: &u8| byte.is_ascii_digit() || b".+-OoIl".contains(byte);
    let first = at.saturating_sub(line.get(..at)?.iter().rev().take_while(|byte| byte.is_ascii_alphanumeric()).count());
    for start in first..=at.min(line.len()) {
        let Some((letter, rest)) = line.get(start..)?.split_first() else { break };
        let length = rest.iter().take_while(|byte| is_value(byte)).count();
        let (value, behind) = rest.split_at(length);
        let ends = behind.first().is_none_or(|byte| !byte.is_ascii_alphabetic() && !b"_=[(".contains(byte));
        if !is_address(letter) || !ends || start + length < at {
            continue;
        }
        if value.iter().any(|byte| b"Oo".contains(byte)) {
            return Some(LETTER_O);
        }
        let has_digit = value.iter().any(u8::is_ascii_digit);
        if has_digit && value.iter().any(|byte| b"Il".contains(byte)) {
            return Some("this is the letter I or l in place of the digit 1: write the digit");
        }
    }
    // The error may be at the word behind it: a Fanuc has GO as a short GOTO, and O alone is a word.
    let before = line.get(..at)?.trim_ascii_end();
    let length = before.iter().rev().take_while(|byte| byte.is_ascii_alphanumeric()).count();
    let word = before.get(before.len() - length..)?;
    let (letter, value) = word.split_first().filter(|_| before.len() < at)?;
    let is_number = is_address(letter) && value.iter().all(is_value) && value.iter().any(u8::is_ascii_digit);
    let has_letter = is_number && value.iter().any(|byte| b"Oo".contains(byte));
    (has_letter || word.eq_ignore_ascii_case(b"GO")).then_some(LETTER_O)
}

#[cfg(test)]
mod tests {
    use super::help_at;

    #[test]
    fn letters_in_numbers_are_named_and_names_are_not() {
        for (line, at, wanted) in [
            ("GO X10.", 0, Some("letter O")),
            ("G0O X1", 2, Some("letter O")),
            ("G0XO", 2, Some("letter O")),
            ("XO", 1, Some("letter O")),
            ("MO6", 0, Some("letter O")),
            ("G0 X1O.", 5, Some("letter O")),
            ("Xl0", 0, Some("letter I or l")),
            ("G0l X1", 2, Some("letter I or l")),
            ("X Y1", 0, None),
            ("LOOP", 0, None),
            ("TO_1", 0, None),
            ("G2 X1 I", 6, None),
        ] {
            let found = help_at(line.as_bytes(), at);
            assert_eq!(found.is_some(), wanted.is_some(), "{line}: {found:?}");
            assert!(wanted.is_none_or(|part| found.is_some_and(|found| found.contains(part))), "{line}: {found:?}");
        }
    }
}
