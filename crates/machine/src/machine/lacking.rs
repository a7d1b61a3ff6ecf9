//! Words of a line that a firmware of the Grbl family does not have. It answers such a line with an error, and executes nothing of it.

use super::firmware::Firmware;

/// A word that the firmware lacks, or that only some builds of it have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LackingWord {
    letter: u8,
    /// Number of a G or M code, in tenths.
    tenths: Option<u32>,
    /// True if a build with the option for it has the word.
    pub is_option: bool,
}

impl LackingWord {
    fn letter(letter: u8) -> LackingWord {
        LackingWord { letter, tenths: None, is_option: false }
    }

    /// Returns the word as it is written, such as `G43.1`; of other words the letter.
    #[must_use]
    pub fn text(self) -> String {
        let letter = char::from(self.letter);
        match self.tenths {
            Some(tenths) if tenths % 10 == 0 => format!("{letter}{}", tenths / 10),
            Some(tenths) => format!("{letter}{}.{}", tenths / 10, tenths % 10),
            None => letter.to_string(),
        }
    }
}

impl Firmware {
    /// Calls `found` for each word of a line that the firmware lacks, outside comments.
    pub fn each_lacking(self, line: &[u8], mut found: impl FnMut(LackingWord)) {
        let mut rest = line;
        let mut turns = false;
        let mut uses_p = false;
        let begins_with_dollar = line.trim_ascii_start().starts_with(b"$");
        while let Some((&byte, after)) = rest.split_first() {
            match byte {
                b';' => break,
                b'(' => {
                    let end = after.iter().position(|&byte| byte == b')').map_or(after.len(), |end| end + 1);
                    rest = &after[end..];
                    continue;
                }
                b'#' if !self.reads(b'#') => {
                    found(LackingWord::letter(b'#'));
                    break;
                }
                // A spindle number of LinuxCNC. At the beginning of a line, it is a command for a setting in all firmware of this family.
                b'$' if begins_with_dollar || !self.reads(b'$') => {
                    found(LackingWord::letter(b'$'));
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
            // `O<name> CALL` has no number.
            if letter == b'O' && number.is_empty() && text.starts_with(b"<") {
                if !self.reads(b'O') {
                    found(LackingWord::letter(b'O'));
                }
                break;
            }
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
                    if !self.has_g(tenths) {
                        found(LackingWord { letter, tenths: Some(tenths), is_option: false });
                    }
                }
                (b'M', Some(tenths)) => {
                    uses_p = true;
                    let is_option = self.has_option(tenths / 10);
                    if is_option || !self.has_m(tenths / 10) {
                        found(LackingWord { letter, tenths: Some(tenths), is_option });
                    }
                }
                (b'P', _) => turns = true,
                (letter, _) if !self.reads(letter) => found(LackingWord::letter(letter)),
                _ => {}
            }
        }
        if turns && !uses_p && !self.has_turns() {
            found(LackingWord::letter(b'P'));
        }
    }

    /// Returns the words of a line that no build of the firmware has, each once, in their order.
    #[must_use]
    pub fn lacks(self, line: &[u8]) -> Vec<LackingWord> {
        let mut out: Vec<LackingWord> = Vec::new();
        self.each_lacking(line, |word| {
            if !word.is_option && !out.contains(&word) {
                out.push(word);
            }
        });
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_outside_comments() {
        let lacking = |firmware: Firmware, line: &str| {
            let mut words = Vec::new();
            firmware.each_lacking(line.as_bytes(), |word| {
                words.push(format!("{}{}", word.text(), if word.is_option { "?" } else { "" }));
            });
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
            ("G41 D1 X5", "G41 D"),
            ("O100 CALL [1]", "O"),
            ("o<sub> call", "O"),
            ("M7", "M7?"),
            ("M8 M56", "M56?"),
            ("$1 S500", "$"),
            ("M3 S500 $1", "$"),
        ] {
            assert_eq!(lacking(Firmware::Grbl, line), wanted, "{line}");
        }
        assert_eq!(lacking(Firmware::GrblHal, "G43 H1 M6 G81 P2 G41 D1"), "G41");
        assert_eq!(lacking(Firmware::GrblHal, "M3 S500 $1 M7"), "M7?");
        assert_eq!(lacking(Firmware::GrblHal, "$1 S500"), "$");
        assert_eq!(Firmware::Grbl.lacks(b"G43 H1 M6 M6 M7").len(), 3);
    }
}
