//! Heads: several spindles, or positions of a swivel head, of which an M word selects one.
//!
//! The head that is active at the start of a program is the first one of a machine.

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;

use super::section::Section;

/// Largest number of an M word.
const LARGEST_WORD: u32 = 99_999_999;
/// Maximum number of heads; no machine has more.
pub const MOST_HEADS: usize = 64;

/// The spindle.
#[derive(Clone, Debug, PartialEq)]
pub struct Spindle {
    /// Gauge point in F at the zero pose, mm.
    pub origin_mm: Vector,
    /// Unit vector from the tip to the spindle.
    pub axis: Vector,
}

impl Default for Spindle {
    fn default() -> Self {
        Spindle { origin_mm: Vector::zeros(), axis: Vector::z() }
    }
}

/// One head of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Name.
    pub name: String,
    /// Numbers of the M words that select it.
    pub select: Vec<u32>,
    /// Its spindle.
    pub spindle: Spindle,
}

impl Head {
    /// Returns the M words that select it, for people: `M54`.
    #[must_use]
    pub fn words(&self) -> String {
        self.select.iter().map(|number| format!("M{number}")).collect::<Vec<_>>().join(", ")
    }
}

/// Reads `[[head]]`: the heads in the order of the file, and the index of the one that is active at the start.
pub(super) fn read(root: &mut Section<'_>, findings: &mut Vec<Diagnostic>) -> (Vec<Head>, usize) {
    let sections = root.sections("head");
    if sections.is_empty() {
        return (Vec::new(), 0);
    }
    if root.has("spindle") {
        let help = "write origin_mm and axis of the spindle into a [[head]] with start = true, and remove [spindle]";
        let message = "[spindle] beside [[head]]: it is not clear which one is active at the start";
        root.report(Code::BAD_HEAD, root.place_of_key("spindle"), message, help);
    }
    if sections.len() > MOST_HEADS {
        let message = format!("{} heads, more than {MOST_HEADS}", sections.len());
        root.report(Code::BAD_HEAD, root.place_of_key("head"), message, "describe the heads of this machine alone");
        return (Vec::new(), 0);
    }
    let mut heads: Vec<Head> = Vec::new();
    let mut start: Option<usize> = None;
    for (index, mut section) in sections.into_iter().enumerate() {
        let name = section.required("name", "\"vertical\"", Section::text).unwrap_or_default().to_owned();
        if !name.is_empty() && heads.iter().any(|head| head.name == name) {
            let message = format!("two heads have the name \"{name}\"");
            section.report(Code::BAD_HEAD, section.place_of("name"), message, "give each head its own name");
        }
        let select = read_words(&mut section, &heads);
        if section.boolean("start") == Some(true) {
            if let Some(first) = start {
                let message = format!("two heads are active at the start: {} and {name}", heads[first].name);
                let help = "write start = true for the head that is active at the start of every program";
                section.report(Code::BAD_HEAD, section.place_of("start"), message, help);
            }
            start.get_or_insert(index);
        }
        let spindle = read_spindle_keys(&mut section);
        heads.push(Head { name, select, spindle });
        // The error sources read their sections of the head, and report unknown keys.
        let keys: Vec<&str> = section.keys().collect();
        keys.into_iter().for_each(|key| section.accept(key));
        section.finish(findings);
    }
    if start.is_none() {
        let names: Vec<&str> = heads.iter().map(|head| head.name.as_str()).collect();
        let message = format!("no head is active at the start of a program: {}", names.join(", "));
        let help = "write start = true in the [[head]] that the control has active at the start";
        root.report(Code::BAD_HEAD, root.place_of_key("head"), message, help);
    }
    (heads, start.unwrap_or(0))
}

/// Reads `[spindle]`.
pub(super) fn read_spindle(section: Option<Section<'_>>, findings: &mut Vec<Diagnostic>) -> Spindle {
    let Some(mut section) = section else { return Spindle::default() };
    let spindle = read_spindle_keys(&mut section);
    section.finish(findings);
    spindle
}

/// Reads `origin_mm` and `axis` of `[spindle]` or of a head.
fn read_spindle_keys(section: &mut Section<'_>) -> Spindle {
    let mut spindle = Spindle::default();
    if let Some(origin_mm) = section.vector("origin_mm") {
        spindle.origin_mm = origin_mm;
    }
    if let Some(axis) = section.vector("axis") {
        match axis.try_normalize(1e-12) {
            Some(unit) => spindle.axis = unit,
            None => {
                let help = "write the direction from the tip to the spindle, for example [0, 0, 1]";
                section.report(Code::BAD_VALUE, section.place_of("axis"), "the spindle axis has no length", help);
            }
        }
    }
    spindle
}

/// Reads the M words that select a head; `others` are the heads before it.
fn read_words(section: &mut Section<'_>, others: &[Head]) -> Vec<u32> {
    const KEY: &str = "select";
    let help = "write the M words that select this head, for example select = [\"M54\"]";
    let Some(words) = section.required(KEY, "[\"M54\"]", Section::texts) else { return Vec::new() };
    if words.is_empty() {
        section.report(Code::BAD_HEAD, section.place_of(KEY), "no word selects this head", help);
    }
    let mut numbers = Vec::new();
    for (index, word) in words.iter().enumerate() {
        let place = section.place_of_item(KEY, index);
        let digits = word.strip_prefix(['M', 'm']).filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()));
        let number = digits.and_then(|digits| digits.parse().ok()).filter(|number| *number <= LARGEST_WORD);
        let Some(number) = number else {
            section.report(Code::BAD_HEAD, place, format!("\"{word}\" is not an M word"), help);
            continue;
        };
        if let Some(other) = others.iter().find(|head| head.select.contains(&number)) {
            let message = format!("M{number} already selects the head {}", other.name);
            section.report(Code::BAD_HEAD, place, message, "a word selects one head: remove it from one of them");
        }
        numbers.push(number);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::super::document::Document;
    use super::*;
    use ncfix_base::source::{FileId, Source};

    fn heads(text: &str) -> (Vec<Head>, usize, Vec<String>) {
        let document = Document::parse(&Source::new(FileId(0), "m.toml", text.as_bytes().to_vec()).unwrap()).unwrap();
        let (mut root, mut findings) = (document.root(), Vec::new());
        let (heads, start) = read(&mut root, &mut findings);
        root.accept("spindle");
        root.finish(&mut findings);
        (heads, start, findings.into_iter().map(|found| format!("{} {}", found.code.as_str(), found.message)).collect())
    }

    #[test]
    fn heads_have_words_and_one_starts() {
        let text = "[[head]]\nname = \"h\"\nselect = [\"M53\", \"m153\"]\n\
                    [[head]]\nname = \"v\"\nselect = [\"M54\"]\nstart = true\norigin_mm = [0, 150, 0]\naxis = [0, 2, 0]\n";
        let (heads, start, findings) = heads(text);
        assert_eq!(findings, Vec::<String>::new());
        assert_eq!((start, heads[0].select.as_slice(), heads[1].words().as_str()), (1, &[53, 153][..], "M54"));
        assert_eq!(heads[1].spindle, Spindle { origin_mm: Vector::new(0.0, 150.0, 0.0), axis: Vector::y() });
        assert_eq!(heads[0].spindle, Spindle { origin_mm: Vector::zeros(), axis: Vector::z() });
    }

    #[test]
    fn contradictions_are_named() {
        let one = "[[head]]\nname = \"a\"\nselect = [\"M53\"]\nstart = true\n";
        for (text, expected) in [
            ("[[head]]\nname = \"a\"\nselect = [\"M53\"]\n", "E0411 no head is active at the start of a program: a"),
            (&format!("{one}[[head]]\nname = \"b\"\nselect = [\"M53\"]\n"), "E0411 M53 already selects the head a"),
            (&format!("{one}[[head]]\nname = \"a\"\nselect = [\"M54\"]\n"), "E0411 two heads have the name \"a\""),
            (&format!("{one}axis = [0, 0, 0]\n"), "E0404 the spindle axis has no length"),
            (
                &format!("[spindle]\n{one}"),
                "E0411 [spindle] beside [[head]]: it is not clear which one is active at the start",
            ),
            (&one.replace("M53", "S53"), "E0411 \"S53\" is not an M word"),
            (&one.replace("[\"M53\"]", "[]"), "E0411 no word selects this head"),
            (&one.replace("select = [\"M53\"]\n", ""), "E0403 [[head]] has no select"),
            (
                &format!("{one}[[head]]\nname = \"b\"\nselect = [\"M54\"]\nstart = true\n"),
                "E0411 two heads are active at the start: a and b",
            ),
        ] {
            assert_eq!(heads(text).2, [expected], "{text}");
        }
    }
}
