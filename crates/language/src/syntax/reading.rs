//! Detects text that a person reads differently from the control: line ends that only some controls recognize, and invisible characters.

use super::MAX_FINDINGS;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span, is_deceptive};

/// The diagnostics of a text, up to the number at which it is not a program.
pub(super) fn hidden(source: &Source) -> Vec<Diagnostic> {
    let bytes = source.bytes();
    let mut findings = Vec::new();
    let (mut at, mut looks) = (0, 0);
    while let Some(step) = next_suspect(&bytes[at..]) {
        at += step;
        let (finding, length) = match bytes[at] {
            b'\r' if source.line_end() == b'\n' => carriage_return(source, at),
            b'\r' => (None, 1),
            _ => character(source, at, &mut looks),
        };
        findings.extend(finding);
        at += length;
        if findings.len() > MAX_FINDINGS {
            break;
        }
    }
    findings
}

/// Maximum number of lines checked for UTF-8: if that many are not, the file is not UTF-8.
const MOST_LOOKS: usize = 10_000;

/// Bytes that may be, or begin, such text.
const IS_SUSPECT: [bool; 256] = {
    let mut suspect = [false; 256];
    let mut k = 0;
    let bytes: [u8; 8] = [0x07, 0x08, b'\r', 0x1b, 0x7f, 0xc2, 0xd8, 0xe2];
    while k < bytes.len() {
        suspect[bytes[k] as usize] = true;
        k += 1;
    }
    suspect
};

/// The offset of the next suspect byte. It tests eight bytes at a time, because most text is plain.
fn next_suspect(bytes: &[u8]) -> Option<usize> {
    const LOW: u64 = 0x0101_0101_0101_0101;
    const HIGH: u64 = 0x8080_8080_8080_8080;
    let is_suspect = |byte: &u8| IS_SUSPECT[usize::from(*byte)];
    let (words, rest) = bytes.as_chunks::<8>();
    for (number, word) in words.iter().enumerate() {
        let value = u64::from_le_bytes(*word);
        // A byte below a blank borrows and 0x7f becomes 0x80: if no eighth bit is set, all eight bytes are plain.
        if (value | value.wrapping_sub(LOW * 0x20) | value.wrapping_add(LOW)) & HIGH == 0 {
            continue;
        }
        if let Some(place) = word.iter().position(is_suspect) {
            return Some(8 * number + place);
        }
    }
    rest.iter().position(is_suspect).map(|place| 8 * words.len() + place)
}

/// Checks carriage returns at an offset, and returns their number: only blanks may follow a line end.
fn carriage_return(source: &Source, at: usize) -> (Option<Diagnostic>, usize) {
    let rest = &source.bytes()[at..];
    let is_filler = |byte: &u8| *byte <= b' ' && *byte != b'\n' || *byte == 0x7f;
    let length = rest.iter().take_while(|byte| is_filler(byte)).count();
    if matches!(rest.get(length), None | Some(b'\n')) {
        return (None, length);
    }
    let message = "a carriage return followed by text in the same line";
    let help =
        "some controls read the rest as a separate block, others do not: replace it with a line feed, or remove it";
    (Some(Diagnostic::at(Code::HIDDEN_BLOCK, place(source, at, 1), message, help)), length.max(1))
}

/// Checks an offset for an invisible character, and returns the number of examined bytes.
fn character(source: &Source, at: usize, looks: &mut usize) -> (Option<Diagnostic>, usize) {
    let bytes = source.bytes();
    let (found, length) = match bytes[at] {
        0x7f => {
            let length = bytes[at..].iter().take_while(|&&byte| byte == 0x7f).count();
            // Deleted tape characters at the beginning or end of a line, or beside a blank.
            let shows = |byte: Option<&u8>| byte.is_some_and(|&byte| byte > b' ');
            let is_within =
                shows(at.checked_sub(1).and_then(|before| bytes.get(before))) && shows(bytes.get(at + length));
            (is_within.then_some('\u{7f}'), length)
        }
        byte if byte < 0x80 => (Some(char::from(byte)), 1),
        _ => (in_utf8(source, at, looks), 1),
    };
    let Some(found) = found else { return (None, length) };
    let message =
        format!("the control character U+{:04X}, which is invisible and changes the display", u32::from(found));
    let help = "remove it: the text on the screen is not the program that runs";
    (Some(Diagnostic::at(Code::DECEPTIVE_TEXT, place(source, at, found.len_utf8()), message, help)), length)
}

/// The character that begins at an offset, if it is invisible. Other encodings use the same bytes within letters, so the whole line must be UTF-8.
fn in_utf8(source: &Source, at: usize, looks: &mut usize) -> Option<char> {
    /// Maximum bytes of a block line.
    const LONGEST_LINE: usize = 4096;
    let bytes = source.bytes();
    let lead = bytes.get(at..(at + 3).min(bytes.len()))?;
    let is_turn = matches!(lead, [0xe2, 0x80, 0x8e | 0x8f | 0xaa..=0xae] | [0xe2, 0x81, 0xa6..=0xa9]);
    if !(is_turn || matches!(lead, [0xc2, 0x80..=0x9f, ..] | [0xd8, 0x9c, ..])) || *looks >= MOST_LOOKS {
        return None;
    }
    *looks += 1;
    let least = at.saturating_sub(LONGEST_LINE);
    let start = bytes[least..at].iter().rposition(|&byte| byte == b'\n').map_or(least, |newline| least + newline + 1);
    let most = (at + LONGEST_LINE).min(bytes.len());
    let end = bytes[at..most].iter().position(|&byte| byte == b'\n').map_or(most, |newline| at + newline);
    let line = std::str::from_utf8(&bytes[start..end]).ok()?;
    line.get(at - start..)?.chars().next().filter(|&character| is_deceptive(character))
}

fn place(source: &Source, at: usize, length: usize) -> Place {
    Place { file: source.id(), span: Span::new(at, at + length) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::FileId;

    fn found(text: &[u8]) -> Vec<(&'static str, usize)> {
        let source = Source::new(FileId(0), "p", text.to_vec()).unwrap();
        let all = hidden(&source);
        all.iter().map(|one| (one.code.as_str(), one.place.unwrap().span.start as usize)).collect()
    }

    #[test]
    fn every_suspect_byte_is_found_at_any_place_among_any_other() {
        for other in 0..=255_u8 {
            for place in 0..20 {
                for suspect in [0x07, b'\r', 0x1b, 0x7f, 0xe2] {
                    let mut bytes = [other; 20];
                    bytes[place] = suspect;
                    let first = if IS_SUSPECT[usize::from(other)] { 0 } else { place };
                    assert_eq!(next_suspect(&bytes), Some(first), "{suspect} at {place} among {other}");
                }
            }
            assert_eq!(next_suspect(&[other; 20]).is_some(), IS_SUSPECT[usize::from(other)]);
        }
    }

    #[test]
    fn ends_of_lines_are_no_matter() {
        for text in
            [&b"X1\r\nX2\r\n"[..], b"X1\rX2\r", b"X1\r\r\nX2 \r \r\n", b"X1\n\r\nX2\r", b"\r\n\r\n", b"", b"X1\n\x1a"]
        {
            assert_eq!(found(text), [], "{text:?}");
        }
    }

    #[test]
    fn what_stands_behind_a_carriage_return_is_found() {
        assert_eq!(found(b"; face\rG0 Z-50\nX1\n"), [("E0315", 6)]);
        assert_eq!(found(b"(face\rG0 Z-50)\r\nX1\r\n"), [("E0315", 5)]);
        assert_eq!(found(b"X1\r\r Y1\rZ1\n"), [("E0315", 2), ("E0315", 7)]);
    }

    #[test]
    fn what_does_not_show_is_found() {
        assert_eq!(found(b"G1 X10\x08\x08\x08\n"), [("E0316", 6), ("E0316", 7), ("E0316", 8)]);
        assert_eq!(found(b"; \x1b[2K face\n"), [("E0316", 2)]);
        assert_eq!(found(b"T=\"a\x07\"\n"), [("E0316", 4)]);
        assert_eq!(found("; a\u{9b}b \u{202e}c\u{2066}d\u{61c}\n".as_bytes()).len(), 4);
        assert_eq!(found(b"X1\x7f5\n"), [("E0316", 2)]);
        // Deleted tape characters, letters of GBK and Latin-1, a dash, an Arabic letter.
        for text in [
            &b"\x7f\x7fX1 \x7f Y2\x7f\n"[..],
            b"; \xc2\x80\xb0\xa1\n",
            b"; \xe2\x80\n",
            "; 1 \u{2013} 2 \u{628} \u{ae}\n".as_bytes(),
        ] {
            assert_eq!(found(text), [], "{text:?}");
        }
    }

    #[test]
    fn there_is_an_end_to_it() {
        assert_eq!(found(&[0x1b; 5000]).len(), MAX_FINDINGS + 1);
        assert_eq!(found(&[b'\r', b'X'].repeat(5000)), []);
        let mut text = [b'\r', b'X'].repeat(5000);
        text.push(b'\n');
        assert_eq!(found(&text).len(), MAX_FINDINGS + 1);
    }
}
