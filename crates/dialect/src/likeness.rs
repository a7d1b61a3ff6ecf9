//! Dialect of a text without an unmistakable mark: evidence of several lines, added up. A text with too little evidence, or with as much for another dialect,
//! has none.

use std::sync::LazyLock;

use ncfix_base::pattern::{RegexSet, patterns};

use super::blocks::{LooseBlock, lines};
use super::{DIALECTS, Dialect, Language};

/// Number of bytes that are examined.
pub(super) const HEAD: usize = 65_536;
/// Smallest sum of weights at which a dialect is likely.
const ENOUGH: u32 = 3;
/// Lead over the next dialect, and between the two dialects with the words of ISO 6983.
const LEAD: u32 = 2;
const ISO_LEAD: u32 = 1;
/// Weight against a Fanuc of whole numbers beside fractions: there a number without a point may count least increments.
const MIXED_NUMBERS: u32 = 3;

/// Words that are usual in a dialect and rare in others.
struct Evidence {
    language: Language,
    weight: u32,
    what: &'static str,
    pattern: &'static str,
}

const fn of(language: Language, weight: u32, what: &'static str, pattern: &'static str) -> Evidence {
    Evidence { language, weight, what, pattern }
}

/// Dialect of a text, with its evidence.
#[derive(Debug)]
pub struct Likeness {
    /// Most likely dialect.
    pub dialect: &'static Dialect,
    /// Evidence, each with its line from 1.
    pub reasons: Vec<(&'static str, u32)>,
}

/// Evidence; each counts once.
const EVIDENCE: &[Evidence] = &[
    of(Language::Fanuc, 2, "G28 or G30 under G91", r"G91\s*G(?:28|30)|G(?:28|30)\s*G91"),
    of(Language::Fanuc, 3, "a call of a macro", r"G6[56]\s*P[0-9]"),
    of(Language::Fanuc, 3, "M98 P", r"M98\s*P[0-9]"),
    of(Language::Fanuc, 3, "an additional work offset", r"G54\.1\s*P|G154\s*P"),
    of(Language::Fanuc, 2, "a length offset G43 H", r"G43\s*(?:[XYZ][-.0-9]+\s*)?H[0-9]"),
    of(Language::Fanuc, 2, "a cycle with R", r"G(?:98|99)\s*G(?:8[1-9]|73|76)|G(?:8[1-9]|73|76)\s*G(?:98|99)"),
    of(Language::Fanuc, 2, "a program number", r"^O\s*[0-9]{1,5}\s*(?:\(|$)"),
    of(Language::Fanuc, 1, "numbers that end with a point", r"[XYZ]-?[0-9]+\.(?:\s|[A-Z]|$)"),
    of(Language::Fanuc, 1, "a comment in brackets", r"^(?:N[0-9]+\s*)?\([^)]*\)$"),
    of(Language::Fanuc, 1, "a unit G20 or G21", r"^[^(;]*\bG2[01]\b"),
    of(Language::Fanuc, 1, "an offset number of two digits", r"^[^(;]*[GXYZ0-9.\s][DH]0[0-9](?:\s|[A-Z]|$)"),
    of(Language::Fanuc, 1, "a dwell in milliseconds", r"G0?4\s*P[0-9]{3}"),
    of(Language::Fanuc, 1, "look-ahead", r"G0?5\s*P10000|G0?5\.1\s*Q1"),
    of(Language::Rs274, 3, "a path tolerance G64 P", r"G64\s*P[.0-9]"),
    of(Language::Rs274, 3, "digital outputs", r"M6[2-6]\s*P[0-9]"),
    of(Language::Rs274, 3, "centers as G90.1 or G91.1", r"G9[01]\.1"),
    of(Language::Rs274, 3, "a probe G38", r"G38\.[2-5]"),
    of(Language::Rs274, 3, "an expression in a word", r"^[^(;]*[XYZ]\s*\[.*#[0-9<]"),
    of(Language::Rs274, 1, "a unit G20 or G21", r"^[^(;]*\bG2[01]\b"),
    of(Language::Rs274, 1, "a comment in brackets", r"^(?:N[0-9]+\s*)?\([^)]*\)$"),
    of(Language::Rs274, 2, "a dwell in seconds", r"G0?4\s*P[0-9]*\.[0-9]"),
    of(Language::Rs274, 2, "lower-case words", r"(?-i:^(?:n[0-9]+ *)?g[0-9]+.* [xyz])"),
    of(Language::Rs274, 2, "a length offset G43 H", r"G43\s*(?:[XYZ][-.0-9]+\s*)?H[0-9]"),
    of(Language::Sinumerik, 3, "an assignment", r"^[^(;]*\b(?:R[0-9]+|CR|AP|RP|TURN|[XYZIJK])\s*=\s*[-.0-9A-Z]"),
    of(
        Language::Sinumerik,
        3,
        "a call of a cycle",
        r"^[^(;]*\b(?:CYCLE[0-9]+|HOLES[12]|POCKET[1-4]|SLOT[12]|LONGHOLE)\s*\(",
    ),
    of(Language::Sinumerik, 3, "a frame", r"^[^(;]*\bA?(?:TRANS|ROT|MIRROR|SCALE)\b"),
    of(
        Language::Sinumerik,
        3,
        "a word of the control",
        r"^[^(;]*\b(?:SUPA|MCALL|STOPRE|GOTOF|GOTOB|TRAORI|TRAFOOF|ENDIF|DEF REAL|MSG\s*\()",
    ),
    of(Language::Sinumerik, 2, "a zero offset G500", r"^[^(;]*\bG5(?:00|0[5-9]|[1-9][0-9])\b"),
    of(Language::Sinumerik, 1, "a comment after a semicolon", r"^(?:N[0-9]+\s*)?;"),
    of(Language::Grundig, 3, "an E parameter", r"^[^(;]*(?:\bE[0-9]+\s*=|=\s*-?E[0-9])"),
    of(Language::Grundig, 3, "a tool change M66 or M67", r"\bT[0-9]+\s*M6[67]\b"),
    of(Language::Grundig, 3, "a graphic window G98 or G99", r"\bG9[89]\s*X\S+\s*Y\S+\s*Z\S+\s*I\S+\s*J"),
    of(Language::Grundig, 2, "a zero offset with a number", r"\bG54\s*I[0-9]"),
    of(Language::Grundig, 2, "an address with an index", r"^[^(;]*\b[ABCIJKLRXYZ][1-9]="),
];

static PATTERNS: LazyLock<RegexSet> = LazyLock::new(|| patterns(EVIDENCE.iter().map(|one| one.pattern)));

/// Evidence of a text: the lines where it was found, from 1.
pub(super) struct TextEvidence {
    lines: Vec<Option<u32>>,
    whole: Option<u32>,
    has_fraction: bool,
}

impl TextEvidence {
    pub(super) fn search(head: &[u8]) -> TextEvidence {
        let mut found = TextEvidence { lines: vec![None; EVIDENCE.len()], whole: None, has_fraction: false };
        let mut block = LooseBlock::default();
        for (line, (_, text)) in (1..).zip(lines(head)) {
            for place in &PATTERNS.matches(text.trim_ascii()) {
                if let Some(first) = found.lines.get_mut(place) {
                    first.get_or_insert(line);
                }
            }
            block.read(text);
            found.numbers(&block, line);
        }
        found
    }

    /// Notes how the positions of a block are written. Zero is the same number with and without a point.
    fn numbers(&mut self, block: &LooseBlock, line: u32) {
        // X is a time after G4. Arguments of macros are numbers of their own.
        if [40, 650, 660].into_iter().any(|code| block.has_code(code)) {
            return;
        }
        let positions = block.words.iter().filter(|word| matches!(word.letter, b'X'..=b'Z'));
        for word in positions.filter(|word| word.value.is_some_and(|value| value != 0.0)) {
            self.has_fraction |= word.has_point;
            if !word.has_point {
                self.whole.get_or_insert(line);
            }
        }
    }

    /// Sum of the weights for a language.
    pub(super) fn sum(&self, language: Language) -> u32 {
        let own = EVIDENCE.iter().zip(&self.lines).filter(|(one, line)| one.language == language && line.is_some());
        let sum: u32 = own.map(|(one, _)| one.weight).sum();
        match language {
            Language::Rs274 => sum + u32::from(self.whole.is_some()),
            Language::Fanuc if self.whole.is_some() && self.has_fraction => sum.saturating_sub(MIXED_NUMBERS),
            _ => sum,
        }
    }

    fn reasons(&self, language: Language) -> Vec<(&'static str, u32)> {
        let own = EVIDENCE.iter().zip(&self.lines).filter(|(one, _)| one.language == language);
        let numbers = self.whole.filter(|_| language == Language::Rs274);
        let numbers = numbers.map(|line| ("whole numbers without a point", line));
        own.filter_map(|(one, line)| Some((one.what, (*line)?))).chain(numbers).collect()
    }
}

/// Returns the most likely dialect of a text.
#[must_use]
pub fn likeness(bytes: &[u8]) -> Option<Likeness> {
    let found = TextEvidence::search(bytes.get(..bytes.len().min(HEAD)).unwrap_or_default());
    let sum = |language: Language| found.sum(language);
    let (best, dialect) =
        DIALECTS.iter().map(|dialect| (sum(dialect.language), dialect)).max_by_key(|(sum, _)| *sum)?;
    let is_iso = |language: Language| matches!(language, Language::Fanuc | Language::Rs274);
    let leads = |other: &Dialect| {
        let lead = if is_iso(other.language) && is_iso(dialect.language) { ISO_LEAD } else { LEAD };
        other.language == dialect.language || best >= sum(other.language) + lead
    };
    if best < ENOUGH || !DIALECTS.iter().all(leads) {
        return None;
    }
    Some(Likeness { dialect, reasons: found.reasons(dialect.language) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_hints_make_a_dialect_and_plain_words_do_not() {
        assert_eq!(PATTERNS.len(), EVIDENCE.len());
        for (text, name) in [
            ("%\nG91 G28 Z0.\nT1 M6\nG0 G90 G54 X1. Y2.\nG43 Z5. H1", "fanuc"),
            ("N10 G90 G17\nN20 T1 M6\nN30 G43 H1 Z50.\nN40 G98 G81 X1. Y1. Z-5. R2. F100.", "fanuc"),
            ("(PLATE)\nG90 G94\nG21\nG0 X5 Y2.5", "rs274"),
            ("(PLATE)\nG90 G94\nG21\nG0 X5. Y2.5", "fanuc"),
            ("(PLATE)\nG90\nG21\nG28 G91 Z0\nG90\nG0 X1.25 Y2\nZ6", "rs274"),
            ("%\n(7)\nN1 G21\nN2 G28 G91 Z0\nN3 T1 M6\nN4 G43 Z25 H1\nN5 G1X-1.5Y4F90", "rs274"),
            ("(ENGRAVING)\nG21\nM3\nG04 P2.50\nG00 X1.0000 Y2.", "rs274"),
            ("(BLOCK)\nG20 G90\nG4 P500\nG0X1.Y.5", "fanuc"),
            ("(BLOCK)\nG20 G90\nG0 X1.0 Y-1.0\nG43 H01 Z0.1", "fanuc"),
            ("G21 G90 G64 P0.01\nG0 X1 Y2\nM64 P1", "rs274"),
            ("N10 G0 X=R1 Y5\nN20 G2 X5 CR=10", "sinumerik"),
            ("; PART\nG54\nTRANS X10\nG1 X5 F100", "sinumerik"),
            ("N1 G17 T1 M66\nN2 G0 X5\nN3 G98 X0 Y0 Z0 I10 J10 K10", "grundig"),
        ] {
            let found = likeness(text.as_bytes());
            assert_eq!(found.as_ref().map(|found| found.dialect.name), Some(name), "{text}");
            assert!(found.is_some_and(|found| !found.reasons.is_empty()));
        }
        for text in ["G0 X1", "N10 G0 X1\nN20 G1 X2. F100", "", "%\nG0 X1", "#1=5", "N10 (TEXT)\nG0 X1"] {
            assert!(likeness(text.as_bytes()).is_none(), "{text}");
        }
    }
}
