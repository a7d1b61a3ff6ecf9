//! Dialect of a text with too little evidence: the languages that do not have its codes or its comments are left out. Numbers and arcs mean the same in the
//! languages that remain.

use std::sync::LazyLock;

use ncfix_base::pattern::{RegexSet, patterns};

use super::blocks::{LooseBlock, lines};
use super::likeness::{HEAD, TextEvidence};
use super::{DIALECTS, Dialect, Language, find};

/// Dialects to choose from, in the order of preference if nothing speaks for one of them. A Grundig text is accepted only on evidence: its centers of arcs
/// are absolute.
const CANDIDATES: [&str; 3] = ["sinumerik", "rs274", "fanuc"];

/// Number of codes that are noted for a dialect: a text with more is no program.
const MOST_CODES: usize = 50;

/// Form of a line that a language does not have.
struct Form {
    languages: &'static [Language],
    what: &'static str,
    pattern: &'static str,
}

/// Forms of lines; each counts once.
const FORMS: &[Form] = &[
    Form {
        languages: &[Language::Sinumerik],
        what: "a comment in brackets",
        // A number before a bracket is one of a word, not of a name such as `CYCLE83 (`.
        pattern: r"^/?(?:N\s*[0-9]+\s*)?\(|^[^(;]*(?:^|[^A-Z_])[FGMSTXYZ]\s*[-+]?[.0-9]+\s*\(",
    },
    Form {
        languages: &[Language::Sinumerik, Language::Grundig],
        what: "a code with a decimal point",
        pattern: r"^[^(;]*(?:^|[^A-Z_])G[0-9]+\.[1-9]",
    },
    Form { languages: &[Language::Sinumerik], what: "a variable with #", pattern: r"^[^(;]*#\s*[0-9<\[]" },
    Form {
        languages: &[Language::Fanuc, Language::Grundig],
        what: "a comment after a semicolon",
        pattern: r"^[^(]*;\s*[A-Z]",
    },
    Form {
        languages: &[Language::Fanuc, Language::Rs274],
        what: "an assignment to an address",
        pattern: r"^[^(;#]*\b[A-Z][0-9]*\s*=",
    },
];

static PATTERNS: LazyLock<RegexSet> = LazyLock::new(|| patterns(FORMS.iter().map(|form| form.pattern)));

/// Codes in tenths and forms that a text has and a dialect lacks, each with its line.
struct Misfits {
    dialect: &'static Dialect,
    codes: Vec<(u32, u32)>,
    forms: Vec<(&'static str, u32)>,
}

impl Misfits {
    fn new(dialect: &'static Dialect) -> Misfits {
        Misfits { dialect, codes: Vec::new(), forms: Vec::new() }
    }

    fn count(&self) -> usize {
        self.codes.len() + self.forms.len()
    }

    fn note_code(&mut self, tenths: u32, line: u32) {
        // The range of zero offsets of a Sinumerik depends on the machine.
        let is_offset =
            self.dialect.language == Language::Sinumerik && (5000..6000).contains(&tenths) && tenths.is_multiple_of(10);
        let is_known = is_offset || self.dialect.codes().g_tenths(tenths as usize).is_some();
        if !is_known && self.codes.len() < MOST_CODES && !self.codes.iter().any(|(code, _)| *code == tenths) {
            self.codes.push((tenths, line));
        }
    }

    fn note_form(&mut self, form: &Form, line: u32) {
        let is_own = form.languages.contains(&self.dialect.language);
        if is_own && !self.forms.iter().any(|(what, _)| *what == form.what) {
            self.forms.push((form.what, line));
        }
    }

    /// The first misfit in words.
    fn first(&self) -> Option<String> {
        let form = self.forms.iter().min_by_key(|(_, line)| *line);
        let code = self.codes.iter().min_by_key(|(_, line)| *line);
        if let Some((what, line)) = form.filter(|(_, line)| code.is_none_or(|(_, other)| line <= other)) {
            return Some(format!("{what} (line {line})"));
        }
        code.map(|(tenths, line)| format!("G{} (line {line})", f64::from(*tenths) / 10.0))
    }
}

/// Returns the dialect that lacks least of what a text contains, and what Sinumerik lacks; `None` if Sinumerik has everything, or if the text may be one of a
/// Grundig.
#[must_use]
pub fn elimination(bytes: &[u8]) -> Option<(&'static Dialect, String)> {
    let head = bytes.get(..bytes.len().min(HEAD)).unwrap_or_default();
    let mut all: Vec<Misfits> = DIALECTS.iter().map(Misfits::new).collect();
    let mut block = LooseBlock::default();
    for (line, (_, text)) in (1..).zip(lines(head)) {
        block.read(text);
        for code in block.codes() {
            all.iter_mut().for_each(|one| one.note_code(code, line));
        }
        for form in PATTERNS.matches(text.trim_ascii()).iter().filter_map(|place| FORMS.get(place)) {
            all.iter_mut().for_each(|one| one.note_form(form, line));
        }
    }
    let misfits = |language: Language| all.iter().find(|one| one.dialect.language == language);
    let why = misfits(Language::Sinumerik).and_then(Misfits::first)?;
    let evidence = TextEvidence::search(head);
    let rank = |dialect: &Dialect| {
        let lacks = misfits(dialect.language).map_or(usize::MAX, Misfits::count);
        (lacks, std::cmp::Reverse(evidence.sum(dialect.language)))
    };
    let best = CANDIDATES.into_iter().filter_map(find).min_by_key(|dialect| rank(dialect))?;
    let others = DIALECTS.iter().filter(|dialect| dialect.language == Language::Grundig);
    let may_be_other = others.into_iter().any(|other| rank(other) < rank(best));
    (best.language != Language::Sinumerik && !may_be_other).then_some((best, why))
}

/// File extensions of hobby controls, lower case. They are rare for other controls, and no Sinumerik program has them.
const USUAL_OF_RS274: [&str; 5] = ["tap", "ngc", "gcode", "gc", "g"];

/// Returns the dialect of a text of which only the file name says something.
#[must_use]
pub fn usual_of_name(file_name: &str) -> Option<&'static Dialect> {
    let (_, extension) = file_name.rsplit_once('.')?;
    let is_usual = USUAL_OF_RS274.iter().any(|usual| extension.eq_ignore_ascii_case(usual));
    is_usual.then(|| find("rs274")).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_hobby_controls_is_no_sinumerik_program() {
        for (name, usual) in
            [("a.TAP", true), ("a.gc", true), ("a.b.g", true), ("a.nc", false), ("a.cnc", false), ("tap", false)]
        {
            assert_eq!(usual_of_name(name).is_some(), usual, "{name}");
        }
    }

    #[test]
    fn a_language_without_the_codes_of_a_text_is_left_out() {
        assert_eq!(PATTERNS.len(), FORMS.len());
        for (text, name, why) in [
            ("G21\nT1M6\nG0Z10.000\nG1X4.5Y2F600", "rs274", "G21 (line 1)"),
            ("T1M6\nG0X2.Y1.\nG20\n", "fanuc", "G20 (line 3)"),
            ("( ROUGH )\nG54\nT2M6\nG0X-22.5Y4.\nG1Z2.8F90", "fanuc", "a comment in brackets (line 1)"),
            ("( ROUGH )\nG54\nT2M6\nG0X-22.5Y4.5\nG1Z2.8F90", "rs274", "a comment in brackets (line 1)"),
            ("T2 M6 (MILL)\nG0 X1", "rs274", "a comment in brackets (line 1)"),
            ("G0 X1\n#1=5", "rs274", "a variable with # (line 2)"),
            ("G90\nG28.2 X0 Y0\nG0 X1.5", "rs274", "a code with a decimal point (line 2)"),
            ("; PART\nG21\nG0 X2. Y1.", "rs274", "G21 (line 2)"),
        ] {
            let found = elimination(text.as_bytes()).map(|(dialect, why)| (dialect.name, why));
            assert_eq!(found, Some((name, why.to_owned())), "{text}");
        }
    }

    #[test]
    fn a_text_that_sinumerik_or_grundig_may_have_stays() {
        for text in [
            "G0 X1",
            "N10 G0 X1\nN20 G1 X2. F100",
            "",
            "N10 G505 G90\nN20 CYCLE83 (5,0,2)\nN30 POCKET3(1)\nN40 MSG (\"(A)\")",
            "N10 G0 X=(R1+2) Y5",
            "N10 G17 T1 M66\n(PART)\nN20 G0 X5 Y2\nN30 G79 X1 Y1",
        ] {
            assert_eq!(elimination(text.as_bytes()).map(|(dialect, why)| (dialect.name, why)), None, "{text}");
        }
    }
}
