//! Names characters that are easily mistaken: files in UTF-16, and letters, dashes and blanks that look like ASCII.

use encoding_rs::{Encoding, UTF_8, WINDOWS_1251, WINDOWS_1252};

use crate::source::shown;

/// Characters and the ASCII characters that they resemble.
const ALIKE: &[(&str, &str)] = &[
    ("АВСЕНІЈКМОРЅТУХ", "ABCEHIJKMOPSTYX"),
    ("ΑΒΕΖΗΙΚΜΝΟΡΤΥΧ", "ABEZHIKMNOPTYX"),
    ("‐‑‒–—−", "------"),
    ("‘’“”„«»", "''\"\"\"\"\""),
    ("×٫，．；：", "X.,.;:"),
];

/// Returns the encoding of a file whose byte order mark shows that it is not a single-byte encoding or UTF-8: `UTF-16LE`.
#[must_use]
pub fn wide_encoding(bytes: &[u8]) -> Option<&'static str> {
    let (encoding, _) = Encoding::for_bom(bytes)?;
    (encoding != UTF_8).then(|| encoding.name())
}

/// Returns the ASCII character that a character resembles.
fn alike(character: char) -> Option<char> {
    if character.is_whitespace() {
        return Some(' ');
    }
    // Full-width forms of East Asian fonts.
    if let wide @ 0xff01..=0xff5e = u32::from(character) {
        return char::from_u32(wide - 0xff01 + 0x21);
    }
    ALIKE
        .iter()
        .find_map(|(from, to)| from.chars().zip(to.chars()).find(|&(from, _)| from == character))
        .map(|(_, to)| to)
}

/// Names the character at an offset if it is not ASCII: `Х (U+0425) is no X`, or the meaning of a byte in common encodings.
#[must_use]
pub fn name_at(bytes: &[u8], at: usize) -> Option<String> {
    let lead = *bytes.get(at).filter(|byte| !byte.is_ascii())?;
    let few = &bytes[at..(at + 4).min(bytes.len())];
    let whole = few.utf8_chunks().next().and_then(|chunk| chunk.valid().chars().next());
    let Some(character) = whole else {
        let [western, cyrillic] = [WINDOWS_1252, WINDOWS_1251].map(|encoding| {
            let (text, _) = encoding.decode_without_bom_handling(&few[..1]);
            shown(&text)
        });
        return Some(format!("the byte {lead:02X} is {western} in windows-1252 and {cyrillic} in windows-1251"));
    };
    let code = u32::from(character);
    Some(match alike(character) {
        Some(' ') => format!("U+{code:04X} is a blank, but not a space"),
        Some(letter) => format!("{character} (U+{code:04X}) is not {letter}"),
        None => format!("{} is U+{code:04X}", shown(&character.to_string())),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_looks_alike_is_named() {
        let named = |text: &str| name_at(text.as_bytes(), 0).unwrap();
        assert_eq!(named("Х10"), "Х (U+0425) is not X");
        assert_eq!(named("–5"), "– (U+2013) is not -");
        assert_eq!(named("Ｇ1"), "Ｇ (U+FF27) is not G");
        assert_eq!(named("\u{a0}X1"), "U+00A0 is a blank, but not a space");
        assert_eq!(named("é"), "é is U+00E9");
        assert_eq!(name_at(b"\xd510", 0).unwrap(), "the byte D5 is Õ in windows-1252 and Х in windows-1251");
        assert_eq!([name_at(b"X", 0), name_at(b"X", 1)], [None, None]);
        for (from, to) in ALIKE {
            assert_eq!(from.chars().count(), to.chars().count());
        }
    }

    #[test]
    fn a_byte_order_mark_tells_two_bytes_a_character() {
        assert_eq!(wide_encoding(b"\xff\xfeN\0"), Some("UTF-16LE"));
        assert_eq!(wide_encoding(b"\xfe\xff\0N"), Some("UTF-16BE"));
        assert_eq!([wide_encoding(b"\xef\xbb\xbfN10"), wide_encoding(b"N10")], [None, None]);
    }
}
