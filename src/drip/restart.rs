//! Where a job that was broken off can be taken up again, and what the control must be told before.
//!
//! A place is safe where the tool moves rapidly at or above the highest place at which anything is machined, so that whatever was carried out behind it is
//! carried out again from a place that nothing is hit on the way to. What the control must know there is read from the lines before: the last code of
//! every group, spindle and coolant, and where each axis stands. Frames and words of unknown effect cannot be rebuilt; behind them nothing is safe but
//! the beginning.

use std::collections::BTreeMap;

use crate::dialect::CodeTable;
use crate::feed::Line;
use crate::geometry::Axis;
use crate::path::{Output, Piece};
use crate::snc::{FrameWords, Kind};

/// The group of motions, in all tables of codes.
const MOTION: u8 = 1;
/// Codes of one block that make its positions mean something else.
const ELSEWHERE: &[&str] = &["G53", "G153", "SUPA", "G28", "G30"];
/// What turns the spindle, and what cools.
const SPINDLE: &[&str] = &["M3", "M4", "M5", "M03", "M04", "M05"];
const COOLANT: &[&str] = &["M7", "M8", "M9", "M07", "M08", "M09"];

/// What a control has been told.
#[derive(Clone, Debug, Default, PartialEq)]
struct Told {
    /// The last code of each group.
    codes: BTreeMap<u8, String>,
    /// The last value of each address.
    values: BTreeMap<u8, String>,
    motion: Option<String>,
    spindle: Option<String>,
    coolant: Option<String>,
}

/// A place to begin again.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The first element that is sent.
    pub element: u64,
    /// Line of the source.
    pub source_line: u32,
    /// What is sent before it.
    pub lines: Vec<String>,
    /// The tool word that was last in force.
    pub tool: Option<String>,
    /// The first line of the program that is sent.
    pub first: String,
}

/// Looks for the last safe place.
pub struct Search {
    codes: &'static CodeTable,
    /// No place behind this element.
    until: u64,
    /// The last element that may have been carried out.
    sent: u64,
    /// The highest place of the tool at which something is machined, mm of Z.
    highest_mm: f64,
    told: Told,
    /// What it was told at the best place.
    at_best: Told,
    stands_mm: Option<f64>,
    element: u64,
    pending: Option<u64>,
    best: Option<Place>,
    is_numbered: bool,
    /// Line of the source behind which nothing is safe.
    unsure: Option<u32>,
}

/// The highest place at which a piece machines, mm of Z.
#[must_use]
pub fn cuts_at_mm(output: &Output) -> Option<f64> {
    match output {
        Output::Piece(piece) if !piece.rapid => Some(piece.command[Axis::Z]),
        _ => None,
    }
}

impl Search {
    /// Begins one in a program that machines no higher than that; nothing behind the element `until` is taken, and nothing
    /// behind the element `sent` has been carried out.
    #[must_use]
    pub fn new(codes: &'static CodeTable, highest_mm: f64, until: u64, sent: u64) -> Search {
        Search {
            codes,
            until,
            sent,
            highest_mm,
            told: Told::default(),
            at_best: Told::default(),
            stands_mm: None,
            element: 0,
            pending: None,
            best: None,
            is_numbered: false,
            unsure: None,
        }
    }

    /// The next element, before its lines.
    pub fn element(&mut self, output: &Output) {
        self.element += 1;
        match output {
            Output::Piece(piece) => {
                if self.is_safe(piece) {
                    self.pending = Some(self.element);
                }
                self.stands_mm = Some(piece.command[Axis::Z]);
            }
            Output::Element(element) => {
                let is_unknown = match &element.kind {
                    Kind::Frame(FrameWords::Statement(_)) => true,
                    Kind::Verbatim(text) => !is_plain(text, self.codes),
                    _ => false,
                };
                if is_unknown {
                    self.unsure.get_or_insert(element.origin.line);
                } else if matches!(element.kind, Kind::Lost(_)) {
                    self.stands_mm = None;
                }
            }
        }
    }

    fn is_safe(&self, piece: &Piece) -> bool {
        let is_above = |mm: f64| mm >= self.highest_mm;
        piece.rapid
            && piece.first
            && !piece.take_up
            && self.unsure.is_none()
            && self.element <= self.until
            && self.stands_mm.is_some_and(is_above)
            && is_above(piece.command[Axis::Z])
    }

    /// A line of the program, in order.
    pub fn line(&mut self, line: &Line) {
        let text = String::from_utf8_lossy(&line.text).into_owned();
        if let Some(element) = self.pending.filter(|element| line.element >= *element) {
            self.pending = None;
            if let Some(lines) = self.told.lines(self.is_numbered) {
                let tool = self.told.values.get(&b'T').cloned();
                self.at_best = self.told.clone();
                self.best = Some(Place { element, source_line: line.source_line, lines, tool, first: text.clone() });
            }
        }
        self.is_numbered |= text.starts_with('N');
        if line.element <= self.sent {
            self.told.note(&text, self.codes);
        }
    }

    /// The last safe place; `None` where only the beginning is: also where the control was told something behind it of which nothing is known before it, an
    /// axis, a zero offset, the coolant: how it stood then nobody has said.
    #[must_use]
    pub fn finish(self) -> Option<Place> {
        let is_known = self.at_best.knows(&self.told);
        self.best.filter(|_| is_known)
    }

    /// The line of the source behind which the state of the control cannot be rebuilt.
    #[must_use]
    pub fn unsure(&self) -> Option<u32> {
        self.unsure
    }
}

/// Whether a text is codes of groups and plain numbers only.
fn is_plain(text: &[u8], codes: &CodeTable) -> bool {
    String::from_utf8_lossy(text).split_ascii_whitespace().all(|word| match codes.word(word) {
        Some(entry) => entry.group > 0,
        None => {
            let (letter, value) = word.split_at_checked(1).unwrap_or((word, ""));
            b"XYZABCUVWFSTDH".contains(&letter.as_bytes().first().copied().unwrap_or(0)) && value.parse::<f64>().is_ok()
        }
    })
}

impl Told {
    /// Whether all is known of which another one speaks.
    fn knows(&self, other: &Told) -> bool {
        other.codes.keys().all(|group| self.codes.contains_key(group))
            && other.values.keys().all(|address| self.values.contains_key(address))
            && (self.spindle.is_some() || other.spindle.is_none())
            && (self.coolant.is_some() || other.coolant.is_none())
    }

    fn note(&mut self, text: &str, codes: &CodeTable) {
        // Behind another zero offset or tool length the old places mean something else.
        let shifts = |name: &str| codes.word(name).map(|entry| entry.group);
        let shifting = [shifts("G54"), shifts("G43")];
        let mut is_elsewhere = false;
        let mut is_shifted = false;
        for word in text.split_ascii_whitespace() {
            let group = codes.word(word).map(|entry| entry.group).filter(|group| *group > 0);
            let is_new = group.is_some_and(|group| self.codes.get(&group).is_none_or(|old| old != word));
            is_shifted |= group.is_some() && shifting.contains(&group) && is_new;
            is_shifted |=
                word.starts_with(['D', 'H']) && self.values.get(&word.as_bytes()[0]).is_none_or(|old| old != word);
        }
        if is_shifted {
            self.forget_places();
        }
        for word in text.split_ascii_whitespace() {
            is_elsewhere |= ELSEWHERE.contains(&word);
            if SPINDLE.contains(&word) {
                self.spindle = Some(word.to_owned());
            } else if COOLANT.contains(&word) {
                self.coolant = Some(word.to_owned());
            } else if word == "M6" || word == "M06" {
                // The tool changer has moved the axes.
                self.forget_places();
            } else if let Some(entry) = codes.word(word).filter(|entry| entry.group > 0 && !word.starts_with('M')) {
                if entry.group == MOTION {
                    self.motion = Some(word.to_owned());
                } else {
                    self.codes.insert(entry.group, word.to_owned());
                }
            } else if let Some((&address, value)) = word.as_bytes().split_first()
                && b"XYZABCUVWFSTDH".contains(&address)
            {
                let is_number = value.iter().all(|byte| byte.is_ascii_digit() || b"+-.=".contains(byte));
                if is_number && !value.is_empty() {
                    self.values.insert(address, word.to_owned());
                } else {
                    // An expression: where it leads is not known here.
                    self.values.remove(&address);
                }
            }
        }
        if is_elsewhere {
            self.forget_places();
        }
    }

    fn forget_places(&mut self) {
        b"XYZABCUVW".iter().for_each(|address| _ = self.values.remove(address));
    }

    /// What brings a control there; `None` where an axis stands nobody knows where.
    fn lines(&self, is_numbered: bool) -> Option<Vec<String>> {
        let place = |address: &u8| self.values.get(address).map(String::as_str);
        let [x, y, z] = [place(&b'X')?, place(&b'Y')?, place(&b'Z')?];
        let mut codes: Vec<&str> = self.codes.values().map(String::as_str).collect();
        codes.extend([b'D', b'H'].iter().filter_map(place));
        let others: Vec<&str> = b"ABCUVW".iter().filter_map(place).collect();
        let spindle: Vec<&str> = [place(&b'S'), self.spindle.as_deref()].into_iter().flatten().collect();
        let mut out = vec![codes.join(" "), spindle.join(" ")];
        out.extend(self.coolant.clone());
        // Up first; nothing turns while something moves across.
        out.push(format!("G0 {z}"));
        if !others.is_empty() {
            out.push(format!("G0 {}", others.join(" ")));
        }
        out.push(format!("G0 {x} {y}"));
        let motion = self.motion.as_deref().filter(|motion| !matches!(*motion, "G0" | "G00"));
        out.push([motion, place(&b'F')].into_iter().flatten().collect::<Vec<_>>().join(" "));
        out.retain(|line| !line.is_empty());
        if is_numbered {
            out = (1..).zip(out).map(|(number, line)| format!("N{number} {line}")).collect();
        }
        Some(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect;

    fn told(lines: &[&str]) -> Told {
        let codes = dialect::find("rs274").unwrap().codes();
        let mut told = Told::default();
        lines.iter().for_each(|line| told.note(line, codes));
        told
    }

    #[test]
    fn the_state_is_that_of_the_last_words() {
        let lines = ["G21 G90 G17", "T3 M6", "G54 S2000 M3", "M8", "G0 X1. Y2. Z50.", "G1 Z-1. F300", "X5.", "G0 Z50."];
        let found = told(&lines).lines(false).unwrap();
        let [codes, rest @ ..] = found.as_slice() else { panic!("{found:?}") };
        assert!(["G17", "G21", "G54", "G90"].iter().all(|code| codes.split(' ').any(|word| word == *code)), "{codes}");
        assert_eq!(rest, ["S2000 M3", "M8", "G0 Z50.", "G0 X5. Y2.", "F300"]);
    }

    #[test]
    fn behind_a_tool_change_or_machine_coordinates_places_must_be_stated_again() {
        assert_eq!(told(&["G0 X1. Y2. Z3.", "T4 M6", "G0 Z5."]).lines(false), None);
        assert_eq!(told(&["G0 X1. Y2. Z3.", "G53 G0 Z0."]).lines(false), None);
        assert!(told(&["T4 M6", "G0 X1. Y2. Z3."]).lines(false).is_some());
    }

    #[test]
    fn what_was_told_later_must_have_been_told_before() {
        let before = told(&["G90 G54 S100 M3", "G0 X1. Y2. Z3."]);
        assert!(before.knows(&before));
        for later in ["G0 A90", "M8", "G18", "G43 H1", "T4"] {
            assert!(!before.knows(&told(&["G90 G54 S100 M3", "G0 X1. Y2. Z3.", later])), "{later}");
        }
        // Another of the same group is known.
        assert!(before.knows(&told(&["G91 G55 S100 M4", "G0 X1. Y2. Z3."])));
    }

    #[test]
    fn plain_words_can_be_told_again() {
        let codes = dialect::find("rs274").unwrap().codes();
        assert!(is_plain(b"G43 H12", codes) && is_plain(b"G64", codes));
        assert!(!is_plain(b"G92 X1", codes) && !is_plain(b"ADIS=0.5", codes));
    }
}
