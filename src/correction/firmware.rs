//! Words in the output that a firmware of the Grbl family does not have: it answers such a line with an error, and executes nothing of it.

use std::io::{self, Write};

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_machine::machine::Firmware;

/// Most different words that are named.
const MOST_WORDS: usize = 12;

/// A word that the firmware lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct LackingWord {
    letter: u8,
    /// Number of a G or M code, in tenths.
    tenths: Option<u32>,
}

impl LackingWord {
    fn text(self) -> String {
        let letter = char::from(self.letter);
        match self.tenths {
            Some(tenths) if tenths % 10 == 0 => format!("{letter}{}", tenths / 10),
            Some(tenths) => format!("{letter}{}.{}", tenths / 10, tenths % 10),
            None => letter.to_string(),
        }
    }
}

/// The text of the output on its way to its file; its words are compared with those of the firmware.
pub(super) struct Watched<'a> {
    sink: &'a mut (dyn Write + Send),
    firmware: Firmware,
    /// The beginning of a line whose end is still to come.
    line: Vec<u8>,
    /// Words that it lacks, with the number of lines that have them.
    lacking: Vec<(LackingWord, u64)>,
}

impl<'a> Watched<'a> {
    pub(super) fn new(sink: &'a mut (dyn Write + Send), firmware: Firmware) -> Watched<'a> {
        Watched { sink, firmware, line: Vec::new(), lacking: Vec::new() }
    }

    fn look(&mut self, line: &[u8]) {
        let Watched { firmware, lacking, .. } = self;
        each_lacking(*firmware, line, |word| match lacking.iter().position(|(known, _)| *known == word) {
            Some(index) => lacking[index].1 += 1,
            None if lacking.len() < MOST_WORDS => lacking.push((word, 1)),
            None => {}
        });
    }

    /// The warning about these words, at the first line of the program that has one of them.
    pub(super) fn finish(mut self, program: &Source) -> Option<Diagnostic> {
        let last = std::mem::take(&mut self.line);
        self.look(&last);
        if self.lacking.is_empty() {
            return None;
        }
        let name = self.firmware.name();
        let words = self.lacking.iter().map(|(word, count)| match count {
            1 => word.text(),
            count => format!("{} ({count} lines)", word.text()),
        });
        let words = words.collect::<Vec<_>>().join(", ");
        let message = format!(
            "{name} does not have these words of the output: {words}; it executes nothing of a line with one of them"
        );
        let help = "remove them from the program, or choose the post-processor of this control; if the control is another one or a newer version, check its list of words";
        Some(match self.place(program) {
            Some(place) => Diagnostic::at(Code::NOT_AT_THIS_CONTROL, place, message, help),
            None => Diagnostic::nowhere(Code::NOT_AT_THIS_CONTROL, message, help),
        })
    }

    fn place(&self, program: &Source) -> Option<Place> {
        let mut start = 0;
        for line in program.bytes().split(|&byte| byte == program.line_end()) {
            let mut has = false;
            each_lacking(self.firmware, line, |word| has |= self.lacking.iter().any(|(known, _)| *known == word));
            if has {
                let length = line.trim_ascii_end().len();
                return Some(Place { file: program.id(), span: Span::new(start, start + length) });
            }
            start += line.len() + 1;
        }
        None
    }
}

impl Write for Watched<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.sink.write(bytes)?;
        let mut rest = bytes.get(..count).unwrap_or_default();
        while let Some(end) = rest.iter().position(|&byte| byte == b'\n') {
            let (line, after) = rest.split_at(end + 1);
            if self.line.is_empty() {
                self.look(line);
            } else {
                let mut whole = std::mem::take(&mut self.line);
                whole.extend_from_slice(line);
                self.look(&whole);
                whole.clear();
                self.line = whole;
            }
            rest = after;
        }
        self.line.extend_from_slice(rest);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

/// Calls `found` for each word of a line that the firmware lacks.
fn each_lacking(firmware: Firmware, line: &[u8], mut found: impl FnMut(LackingWord)) {
    let mut rest = line;
    let mut turns = false;
    let mut uses_p = false;
    while let Some((&byte, after)) = rest.split_first() {
        match byte {
            b';' => break,
            b'(' => {
                let end = after.iter().position(|&byte| byte == b')').map_or(after.len(), |end| end + 1);
                rest = &after[end..];
                continue;
            }
            b'#' if !firmware.reads(b'#') => {
                found(LackingWord { letter: b'#', tenths: None });
                break;
            }
            _ => {}
        }
        rest = after;
        let letter = byte.to_ascii_uppercase();
        if !letter.is_ascii_uppercase() {
            continue;
        }
        let text = rest.trim_ascii_start();
        let length =
            text.iter().position(|byte| !matches!(byte, b'0'..=b'9' | b'.' | b'-' | b'+')).unwrap_or(text.len());
        let (number, after) = text.split_at(length);
        if number.is_empty() {
            continue;
        }
        rest = after;
        let value = std::str::from_utf8(number).ok().and_then(|text| text.parse::<f64>().ok());
        // A negative or huge number saturates, and is then no code.
        let tenths = value.map(|value| (value * 10.0).round() as u32);
        match (letter, tenths) {
            (b'G', Some(tenths)) => {
                uses_p |= matches!(tenths, 40 | 100);
                if !firmware.has_g(tenths) {
                    found(LackingWord { letter, tenths: Some(tenths) });
                }
            }
            (b'M', Some(tenths)) => {
                uses_p = true;
                if !firmware.has_m(tenths / 10) {
                    found(LackingWord { letter, tenths: Some(tenths) });
                }
            }
            (b'P', _) => turns = true,
            (letter, _) if !firmware.reads(letter) => found(LackingWord { letter, tenths: None }),
            _ => {}
        }
    }
    if turns && !uses_p && !firmware.has_turns() {
        found(LackingWord { letter: b'P', tenths: None });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_outside_comments() {
        let lacking = |firmware, line: &str| {
            let mut words = Vec::new();
            each_lacking(firmware, line.as_bytes(), |word| words.push(word.text()));
            words.join(" ")
        };
        for (line, wanted) in [
            ("N10 T1 M06", "M6"),
            ("G043 H1 Z5. (M6)", "G43 H"),
            ("G43.1 Z10 ; G81", ""),
            ("G 81 X1 Y2 Z-3 R2 F100", "G81"),
            ("G2 X1 Y0 I5 J0 P2", "P"),
            ("G4 P0.5", ""),
            ("G10 L2 P1 X5", ""),
            ("#5221=105", "#"),
            ("g61.1", "G61.1"),
        ] {
            assert_eq!(lacking(Firmware::Grbl, line), wanted, "{line}");
        }
        assert_eq!(lacking(Firmware::GrblHal, "G43 H1 M6 G81 P2 G41 D1"), "G41");
    }
}
