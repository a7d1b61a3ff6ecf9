//! Actions of a program other than axis motion, in sequence along the path.
//!
//! Both programs are executed, so that values are evaluated and cycles, calls and loops are expanded. Words that only define the meaning of
//! coordinates are excluded: their effect shows in the motion.

use super::difference::ActSubject;
use super::same_text::is_same_text;
use ncfix_dialect::{BlockEnd, BlockEnds};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{CycleArgument, Dwell, Element, FrameKind, FrameWords, Kind, Origin, Word, WordValue};

/// Relative and absolute tolerance of equal numbers.
const SAME_NUMBER: [f64; 2] = [1e-6, 1e-9];
/// Tolerance of a speed: it may be written as a whole number.
const SAME_SPEED: f64 = 0.5;
/// Tolerance of a dwell, which may be written in whole milliseconds, s.
const SAME_DWELL: f64 = 1e-3;
/// Tolerance of data that the control computes from its position: values have six decimals, mm, degrees or inches.
const SAME_DATA: f64 = 2e-5;
/// Maximum number of acts examined between two moves; a loop without motion could have any number.
const MOST_ACTS: usize = 20_000;
/// Maximum number of acts for a comparison of all pairs.
const MOST_PAIRED: usize = 400;

/// Words that define the meaning of coordinates, or that the writer replaces.
const OF_COORDINATES: [&str; 21] = [
    "G20", "G21", "G70", "G71", "G700", "G710", "G90", "G91", "G90.1", "G91.1", "G40", "G41", "G42", "G41.1", "G42.1",
    "G80", "G53", "G153", "SUPA", "G17", "G18",
];
/// Further such words; the unit of a feed is compared with the feed.
const OF_FEEDS: [&str; 4] = ["G19", "G93", "G94", "G95"];

/// Comments with a function in RS274/NGC.
const ACTIVE_COMMENTS: [&str; 7] = ["MSG", "DEBUG", "PRINT", "LOG", "LOGOPEN", "LOGAPPEND", "PROBEOPEN"];

/// An action.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Act {
    pub(super) origin: Origin,
    /// Its subject.
    pub(super) subject: ActSubject,
    /// Its text as written.
    pub(super) text: String,
    number: Option<f64>,
    /// True for a frame statement that ends the frame: `TRANS` without an axis.
    ends_frame: bool,
}

impl Act {
    fn new(origin: Origin, subject: ActSubject, text: String) -> Act {
        Act { origin, subject, text, number: None, ends_frame: false }
    }

    /// `true` if both have the same effect.
    pub(super) fn is_like(&self, other: &Act) -> bool {
        if self.subject != other.subject {
            return false;
        }
        let is_same_data = || of_data(&self.text) == of_data(&other.text);
        match (self.number, other.number) {
            (Some(one), Some(other)) => {
                let same = match self.subject {
                    ActSubject::SpindleSpeed => SAME_SPEED,
                    ActSubject::Dwell => SAME_DWELL,
                    // Both programs stand at different places, so that the values differ, but the data must not.
                    ActSubject::ComputedData => {
                        return (one - other).abs() <= SAME_DATA && is_same_data();
                    }
                    _ => SAME_NUMBER[1],
                };
                (one - other).abs() <= same.max(SAME_NUMBER[0] * one.abs())
            }
            _ => is_same_text(&self.text, &other.text),
        }
    }
}

/// The acts between two moves.
#[derive(Clone, Debug, Default)]
pub(super) struct Acts(
    pub(super) Vec<Act>,
    /// Those that belong to the first feed move of a hole: the rapid moves to the hole may be in the cycle or in front of it.
    Vec<Act>,
);

impl Acts {
    /// Takes the acts before a move.
    pub(super) fn before(&mut self, rapid: bool) -> Vec<Act> {
        if !rapid {
            self.0.append(&mut self.1);
        }
        std::mem::take(&mut self.0)
    }

    /// Takes all acts.
    pub(super) fn rest(&mut self) -> Vec<Act> {
        self.before(false)
    }

    /// Updates the state with an element.
    pub(super) fn see(&mut self, element: &Element, machine: &Machine, passing: &Passing) {
        if self.0.len() >= MOST_ACTS {
            return;
        }
        let origin = element.origin;
        match &element.kind {
            Kind::Before(words) | Kind::After(words) => self.0.extend(words.iter().map(|one| of_word(one, origin))),
            Kind::Tool(value) => {
                self.0.push(of_word(&Word { letter: b'T', extension: None, value: value.clone() }, origin));
            }
            Kind::Dwell(dwell) => {
                let (number, text) = match dwell {
                    Dwell::Seconds(number) => (*number, format!("a dwell of {} s", shown(*number))),
                    Dwell::Turns(number) => (*number, format!("a dwell of {} turns of the spindle", shown(*number))),
                };
                let subject =
                    if matches!(dwell, Dwell::Seconds(_)) { ActSubject::Dwell } else { ActSubject::DwellInTurns };
                self.0.push(Act { number: Some(number), ..Act::new(origin, subject, text) });
            }
            Kind::Keep(word) if is_of_coordinates(word, machine) || passing.is_word(word) => {}
            Kind::Keep(word) => self.0.push(Act::new(origin, ActSubject::Mode, (*word).to_owned())),
            Kind::Verbatim(text) => {
                let text = String::from_utf8_lossy(text).trim().to_owned();
                if !passing.is_word(first_word(&text)) && !text.is_empty() {
                    self.0.push(Act::new(origin, ActSubject::Statement, text));
                }
            }
            Kind::Here(here) => {
                for axis in here.named.iter() {
                    let data = here.data[axis];
                    let data = if axis.is_rotary() { data.to_degrees() } else { data };
                    let text = format!("{} {axis} = {}", here.words, shown(data));
                    self.0.push(Act { number: Some(data), ..Act::new(origin, ActSubject::ComputedData, text) });
                }
                if !here.after.is_empty() {
                    let text = format!("{}{}", here.words, here.after);
                    self.0.push(Act::new(origin, ActSubject::Statement, text));
                }
            }
            Kind::Header(text) => {
                if let Some(number) = program_number(text) {
                    self.0.push(Act::new(origin, ActSubject::ProgramNumber, number));
                }
            }
            Kind::Comment(text) if machine.controller.eq_ignore_ascii_case("rs274") => {
                let text = String::from_utf8_lossy(text).trim().to_owned();
                let inner = text.strip_prefix('(').unwrap_or_default().trim_start().to_ascii_uppercase();
                let word = inner.split([',', ')']).next().unwrap_or_default().trim_end();
                if inner.contains(',') && ACTIVE_COMMENTS.contains(&word) {
                    self.0.push(Act::new(origin, ActSubject::Message, text));
                }
            }
            Kind::Message(text) => {
                let text = format!("MSG(\"{}\")", String::from_utf8_lossy(text));
                self.0.push(Act::new(origin, ActSubject::Message, text));
            }
            Kind::Cycle(Some(cycle)) => {
                // M29 S500 announces rigid tapping; the moves of the cycle do not show it.
                let words = cycle.arguments.iter().filter_map(CycleArgument::function);
                self.1.extend(words.map(|word| Act::new(origin, ActSubject::Statement, word.to_owned())));
            }
            Kind::Frame(FrameWords::Settable(name)) => {
                self.0.push(Act::new(origin, ActSubject::WorkOffset, name.clone()));
            }
            Kind::Frame(FrameWords::Statement(one)) => {
                // It replaces the frame, so that an end of the frame directly before it does nothing.
                let replaces = !one.additive && !matches!(one.kind, FrameKind::Coarse | FrameKind::Fine);
                if replaces && self.0.last().is_some_and(|last| last.ends_frame) {
                    self.0.pop();
                }
                let values = one.named.iter().map(|axis| {
                    let value = one.values[axis];
                    format!(" {axis}{value:.6}")
                });
                let more = one.in_plane_rad.map_or_else(String::new, |angle| format!(" RPL={:.6}", angle.to_degrees()));
                let text = format!(
                    "{:?}{}{}{more}",
                    one.kind,
                    if one.additive { " additive" } else { "" },
                    values.collect::<String>()
                );
                let is_empty = one.named.is_empty() && one.in_plane_rad.is_none();
                let ends_frame = one.kind == FrameKind::Translate && !one.additive && is_empty;
                self.0.push(Act { ends_frame, ..Act::new(origin, ActSubject::Frame, text) });
            }
            _ => {}
        }
    }
}

/// Stops at block ends: the modal word and the one for a single block.
#[derive(Clone, Debug)]
pub(super) struct Passing {
    /// The words of the language.
    words: BlockEnds,
    /// G64, G60 …; `None` if the program has not set it.
    pub(super) mode: Option<std::sync::Arc<Act>>,
    /// An exact stop at the end of this block.
    pub(super) stops_once: bool,
}

impl Passing {
    /// The state before the first such word.
    pub(super) fn of(machine: &Machine) -> Passing {
        let words = ncfix_dialect::find(&machine.controller).map_or(BlockEnds::NONE, |dialect| dialect.block_ends);
        Passing { words, mode: None, stops_once: false }
    }

    /// `true` if a word controls the stops at block ends.
    pub(super) fn is_word(&self, word: &str) -> bool {
        self.words.of(word).is_some()
    }

    /// Updates the state with an element.
    pub(super) fn see(&mut self, element: &Element) {
        if element.starts_block {
            self.stops_once = false;
        }
        let text = match &element.kind {
            Kind::Keep(word) => (*word).to_owned(),
            Kind::Verbatim(text) if text.first() == Some(&b'G') => String::from_utf8_lossy(text).trim().to_owned(),
            _ => return,
        };
        match self.words.of(first_word(&text)) {
            Some(BlockEnd::Once) => self.stops_once = true,
            Some(BlockEnd::Exact | BlockEnd::Running) => {
                self.mode = Some(std::sync::Arc::new(Act::new(element.origin, ActSubject::Passing, text)));
            }
            None => {}
        }
    }

    /// Its text as written.
    pub(super) fn text(&self) -> Option<String> {
        let mode = self.mode.as_ref().map(|mode| mode.text.clone());
        match (mode, self.words.once.filter(|_| self.stops_once)) {
            (Some(mode), Some(once)) => Some(format!("{mode} and {once}")),
            (None, Some(once)) => Some(once.to_owned()),
            (mode, None) => mode,
        }
    }

    /// `true` if a block of the corrected program stops, or passes, at its end like this one. A piece that is not the last of its move may pass.
    pub(super) fn is_kept_by(&self, piece: &Passing, is_last: bool) -> bool {
        let is_alike = match (&self.mode, &piece.mode) {
            (Some(one), Some(other)) => one.is_like(other),
            (None, None) => true,
            _ => false,
        };
        if is_last {
            return is_alike && self.stops_once == piece.stops_once;
        }
        let is = |passing: &Passing, word: &str| passing.mode.as_ref().is_some_and(|mode| mode.text == word);
        !piece.stops_once && (is_alike || is(self, self.words.exact) && is(piece, self.words.running))
    }
}

/// An act of one program and its counterpart in the other.
pub(super) type ActPairing<'a> = (Option<&'a Act>, Option<&'a Act>);

/// The differences between the acts of both programs: changed, missing and new ones, in order.
pub(super) fn differences<'a>(original: &'a [Act], corrected: &'a [Act]) -> Vec<ActPairing<'a>> {
    let is_like = |(one, other): &(&Act, &Act)| one.is_like(other);
    let start = original.iter().zip(corrected).take_while(is_like).count();
    let (original, corrected) = (&original[start..], &corrected[start..]);
    let end = original.iter().rev().zip(corrected.iter().rev()).take_while(is_like).count();
    let (original, corrected) = (&original[..original.len() - end], &corrected[..corrected.len() - end]);
    if original.is_empty() && corrected.is_empty() {
        return Vec::new();
    }
    let [mut missing, mut new] = rest(original, corrected);
    // Remaining acts of one subject on both sides have another value or another place.
    let mut out = Vec::new();
    missing.retain(|one| {
        let partner = new.iter().position(|other| other.is_like(one));
        let partner = partner.or_else(|| new.iter().position(|other| is_about_the_same(one, other)));
        if let Some(at) = partner {
            out.push((Some(*one), Some(new.remove(at))));
        }
        partner.is_none()
    });
    out.extend(missing.into_iter().map(|one| (Some(one), None)));
    out.extend(new.into_iter().map(|other| (None, Some(other))));
    out
}

/// The acts of both outside the longest common sequence.
fn rest<'a>(original: &'a [Act], corrected: &'a [Act]) -> [Vec<&'a Act>; 2] {
    let (rows, columns) = (original.len(), corrected.len());
    if rows > MOST_PAIRED || columns > MOST_PAIRED {
        return [original.iter().collect(), corrected.iter().collect()];
    }
    // Lengths of the common sequences after each pair of places.
    let mut lengths = vec![0_u32; (rows + 1) * (columns + 1)];
    let at = |row: usize, column: usize| row * (columns + 1) + column;
    for row in (0..rows).rev() {
        for column in (0..columns).rev() {
            lengths[at(row, column)] = if original[row].is_like(&corrected[column]) {
                lengths[at(row + 1, column + 1)] + 1
            } else {
                lengths[at(row + 1, column)].max(lengths[at(row, column + 1)])
            };
        }
    }
    let (mut row, mut column) = (0, 0);
    let mut out = [Vec::new(), Vec::new()];
    while row < rows && column < columns {
        if original[row].is_like(&corrected[column]) {
            (row, column) = (row + 1, column + 1);
        } else if lengths[at(row + 1, column)] >= lengths[at(row, column + 1)] {
            out[0].push(&original[row]);
            row += 1;
        } else {
            out[1].push(&corrected[column]);
            column += 1;
        }
    }
    out[0].extend(&original[row..]);
    out[1].extend(&corrected[column..]);
    out
}

/// `true` if one act may be a changed version of the other.
fn is_about_the_same(one: &Act, other: &Act) -> bool {
    let first = |act: &'_ Act| first_word(&act.text).trim_end_matches(|sign: char| sign.is_ascii_digit()).to_owned();
    one.subject == other.subject
        && (one.subject != ActSubject::Statement || first(one) == first(other))
        && (one.subject != ActSubject::ComputedData || of_data(&one.text) == of_data(&other.text))
}

/// The act of an auxiliary word.
fn of_word(word: &Word, origin: Origin) -> Act {
    let letter = char::from(word.letter);
    let (text, number) = match (&word.value, word.extension) {
        (WordValue::Number(number), None) => (format!("{letter}{}", shown(*number)), Some(*number)),
        (WordValue::Number(number), Some(extension)) => {
            (format!("{letter}{extension}={}", shown(*number)), Some(*number))
        }
        (WordValue::Name(name), _) => (format!("{letter}=\"{}\"", String::from_utf8_lossy(name)), None),
    };
    let subject = match (word.letter, number) {
        (b'S', _) => ActSubject::SpindleSpeed,
        (b'T', _) => ActSubject::Tool,
        (b'D', _) => ActSubject::ToolOffset,
        (b'H', _) => ActSubject::ToolLength,
        (b'M', Some(number)) => of_function(number),
        _ => ActSubject::Auxiliary,
    };
    // The number of a spindle and the letter belong to what it is.
    let is_plain = word.extension.is_none() && subject != ActSubject::Auxiliary;
    Act { number: number.filter(|_| is_plain), ..Act::new(origin, subject, text) }
}

/// Subject of an M function.
fn of_function(number: f64) -> ActSubject {
    const OF: [(&[f64], ActSubject); 5] = [
        (&[3.0, 4.0, 5.0, 19.0, 70.0], ActSubject::Spindle),
        (&[7.0, 8.0, 9.0], ActSubject::Coolant),
        (&[0.0, 1.0, 60.0], ActSubject::Stop),
        (&[2.0, 17.0, 30.0, 99.0], ActSubject::End),
        (&[6.0], ActSubject::ToolChange),
    ];
    OF.iter().find(|(numbers, _)| numbers.contains(&number)).map_or(ActSubject::Function, |(_, subject)| *subject)
}

/// The data that are computed: the `G10 L20 P1 Z` of `G10 L20 P1 Z = -61`.
fn of_data(text: &str) -> &str {
    text.split('=').next().unwrap_or_default()
}

fn is_of_coordinates(word: &str, machine: &Machine) -> bool {
    // On the Grundig this is compensation along an axis; elsewhere it is the tool length.
    let is_along_axis = ["G43", "G44"].contains(&word) && machine.controller.eq_ignore_ascii_case("grundig");
    // The effect of the transformation shows in the motion.
    let is_of_transform = word.starts_with("TRA") || word.starts_with("ORI");
    OF_COORDINATES.contains(&word) || OF_FEEDS.contains(&word) || is_along_axis || is_of_transform
}

/// The program identifier in a header line: the `O1000` of `O1000 (PLATE)`, `%PM9010`, `%_N_PLATE_MPF`; `None` for other lines.
fn program_number(line: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(line.trim_ascii()).to_ascii_uppercase();
    let word = text.split([' ', '(', ';']).next().unwrap_or_default();
    let rest = word.trim_start_matches(['%', 'O', ':']);
    let is_number = rest.len() < word.len() && !rest.is_empty();
    is_number.then(|| word.to_owned())
}

/// Its first word: `G64` of `G64 P0.01`, `ADIS` of `ADIS=0.5`.
fn first_word(text: &str) -> &str {
    text.split([' ', '=', '(', '[']).next().unwrap_or_default()
}

/// A number rounded to remove noise.
fn shown(number: f64) -> String {
    let rounded = (number * 1e6).round() / 1e6;
    if rounded == 0.0 { "0".to_owned() } else { rounded.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn acts(text: &str) -> Vec<Act> {
        text.split_whitespace()
            .map(|word| {
                let (letter, number) = word.split_at(1);
                let value = WordValue::Number(number.parse().unwrap());
                of_word(&Word { letter: letter.as_bytes()[0], extension: None, value }, Origin::default())
            })
            .collect()
    }

    fn found(original: &str, corrected: &str) -> Vec<String> {
        let (original, corrected) = (acts(original), acts(corrected));
        let text = |act: Option<&Act>| act.map_or("-", |act| act.text.as_str()).to_owned();
        differences(&original, &corrected).into_iter().map(|(a, b)| format!("{}>{}", text(a), text(b))).collect()
    }

    #[test]
    fn what_is_changed_missing_and_new_is_told_apart() {
        assert_eq!(found("T1 M6 S3000 M3 M8", "T1 M6 S3000 M3 M8"), [""; 0]);
        assert_eq!(found("S3000 M3 M8", "S13000 M4 M8"), ["S3000>S13000", "M3>M4"]);
        assert_eq!(found("M3 M8", "M3"), ["M8>-"]);
        assert_eq!(found("M3 M8", "M3 M0 M8"), ["->M0"]);
        assert_eq!(found("M3 M8 M30", "M8 M3 M30"), ["M3>M3"]);
        assert_eq!(found("M54", "M55"), ["M54>M55"]);
        assert_eq!(found("M8", "M5"), ["M8>-", "->M5"]);
        // A control with whole-number speeds.
        assert_eq!(found("S1234.4", "S1234"), [""; 0]);
    }
}
