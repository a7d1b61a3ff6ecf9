//! What a program does besides moving its axes, in its place along the path.
//!
//! Both programs are executed, so that values are values and cycles, calls and loops have become what they do. Words that only say how coordinates
//! are to be read have no place here: what they mean is seen in the motion.

use super::difference::ActSubject;
use super::same_text::is_same_text;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Dwell, Element, FrameWords, Kind, Origin, Word, WordValue};

/// Numbers that differ by less are one number: of a whole, and by themselves.
const SAME_NUMBER: [f64; 2] = [1e-6, 1e-9];
/// A speed may be written as a whole number.
const SAME_SPEED: f64 = 0.5;
/// A dwell may be written in whole milliseconds, s.
const SAME_DWELL: f64 = 1e-3;
/// Acts between two moves that are looked at; a loop that moves nothing could have any number.
const MOST_ACTS: usize = 20_000;
/// Between so many acts each is compared with each.
const MOST_PAIRED: usize = 400;

/// Words that say how coordinates are to be read, or that the writer puts in their place anew.
const OF_COORDINATES: [&str; 21] = [
    "G20", "G21", "G70", "G71", "G700", "G710", "G90", "G91", "G90.1", "G91.1", "G40", "G41", "G42", "G41.1", "G42.1",
    "G80", "G53", "G153", "SUPA", "G17", "G18",
];
/// More of them; the unit of a feed is compared with the feed.
const OF_FEEDS: [&str; 4] = ["G19", "G93", "G94", "G95"];
/// Words about stops at the ends of blocks: they stay in force.
const STOPS: [&str; 12] = ["G60", "G61", "G61.1", "G62", "G63", "G64", "G641", "G642", "G643", "G644", "G645", "G9"];
/// Stops exactly at the end of its block only.
const ONCE: &str = "G9";
/// What lines of a block say that are not its last, where the program stops exactly at the end of each block.
const RUNNING: [&str; 2] = ["G64", "G61"];
const EXACT: [&str; 3] = ["G60", "G61", "G61.1"];

/// Comments that do something in RS274/NGC.
const ACTIVE_COMMENTS: [&str; 7] = ["MSG", "DEBUG", "PRINT", "LOG", "LOGOPEN", "LOGAPPEND", "PROBEOPEN"];

/// Something that is done.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Act {
    pub(super) origin: Origin,
    /// What it is about.
    pub(super) subject: ActSubject,
    /// As it is written.
    pub(super) text: String,
    number: Option<f64>,
}

impl Act {
    fn new(origin: Origin, subject: ActSubject, text: String) -> Act {
        Act { origin, subject, text, number: None }
    }

    /// Whether both do the same.
    pub(super) fn is_like(&self, other: &Act) -> bool {
        if self.subject != other.subject {
            return false;
        }
        match (self.number, other.number) {
            (Some(one), Some(other)) => {
                let same = match self.subject {
                    ActSubject::SpindleSpeed => SAME_SPEED,
                    ActSubject::Dwell => SAME_DWELL,
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
pub(super) struct Acts(pub(super) Vec<Act>);

impl Acts {
    /// Takes note of an element.
    pub(super) fn see(&mut self, element: &Element, machine: &Machine) {
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
            Kind::Keep(word) if is_of_coordinates(word, machine) || STOPS.contains(word) => {}
            Kind::Keep(word) => self.0.push(Act::new(origin, ActSubject::Mode, (*word).to_owned())),
            Kind::Verbatim(text) => {
                let text = String::from_utf8_lossy(text).trim().to_owned();
                if !STOPS.contains(&first_word(&text)) && !text.is_empty() {
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
            Kind::Frame(FrameWords::Settable(name)) => {
                self.0.push(Act::new(origin, ActSubject::WorkOffset, name.clone()))
            }
            Kind::Frame(FrameWords::Statement(one)) => {
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
                self.0.push(Act::new(origin, ActSubject::Frame, text));
            }
            _ => {}
        }
    }
}

/// How the ends of blocks are passed: what stays in force, and what is for one block.
#[derive(Clone, Debug, Default)]
pub(super) struct Passing {
    /// G64, G60 …; `None` where the program has said nothing.
    pub(super) mode: Option<std::sync::Arc<Act>>,
    /// G9.
    pub(super) stops_once: bool,
}

impl Passing {
    /// Takes note of an element.
    pub(super) fn see(&mut self, element: &Element) {
        if element.starts_block {
            self.stops_once = false;
        }
        let text = match &element.kind {
            Kind::Keep(word) => (*word).to_owned(),
            Kind::Verbatim(text) if text.first() == Some(&b'G') => String::from_utf8_lossy(text).trim().to_owned(),
            _ => return,
        };
        match first_word(&text) {
            ONCE => self.stops_once = true,
            word if STOPS.contains(&word) => {
                self.mode = Some(std::sync::Arc::new(Act::new(element.origin, ActSubject::Passing, text)));
            }
            _ => {}
        }
    }

    /// As it is written.
    pub(super) fn text(&self) -> Option<String> {
        let mode = self.mode.as_ref().map(|mode| mode.text.clone());
        match (mode, self.stops_once) {
            (Some(mode), true) => Some(format!("{mode} and {ONCE}")),
            (None, true) => Some(ONCE.to_owned()),
            (mode, false) => mode,
        }
    }

    /// Whether a block of the corrected program passes its end like this one; a piece that is not the last of its move may run on.
    pub(super) fn is_kept_by(&self, piece: &Passing, is_last: bool) -> bool {
        let is_alike = match (&self.mode, &piece.mode) {
            (Some(one), Some(other)) => one.is_like(other),
            (None, None) => true,
            _ => false,
        };
        if is_last {
            return is_alike && self.stops_once == piece.stops_once;
        }
        let is = |passing: &Passing, words: &[&str]| {
            passing.mode.as_ref().is_some_and(|mode| words.contains(&mode.text.as_str()))
        };
        !piece.stops_once && (is_alike || is(self, &EXACT) && is(piece, &RUNNING))
    }
}

/// Acts of the one program beside those of the other.
pub(super) type ActPairing<'a> = (Option<&'a Act>, Option<&'a Act>);

/// What the acts of the one program lack beside those of the other: what is changed, what is missing and what is new, in order.
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
    // What is left of one subject on both sides has another value, or stands elsewhere.
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

/// What is left of both where the longest common sequence is taken out.
fn rest<'a>(original: &'a [Act], corrected: &'a [Act]) -> [Vec<&'a Act>; 2] {
    let (rows, columns) = (original.len(), corrected.len());
    if rows > MOST_PAIRED || columns > MOST_PAIRED {
        return [original.iter().collect(), corrected.iter().collect()];
    }
    // Lengths of the common sequences of what is behind each pair of places.
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

/// Whether the one may have become the other.
fn is_about_the_same(one: &Act, other: &Act) -> bool {
    let first = |act: &'_ Act| first_word(&act.text).trim_end_matches(|sign: char| sign.is_ascii_digit()).to_owned();
    one.subject == other.subject && (one.subject != ActSubject::Statement || first(one) == first(other))
}

/// An auxiliary word, and what it is about.
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
    Act { origin, subject, text, number: number.filter(|_| is_plain) }
}

/// What an M function is about.
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

fn is_of_coordinates(word: &str, machine: &Machine) -> bool {
    // The Grundig calls compensation along an axis so; elsewhere it is the tool length.
    let is_along_axis = ["G43", "G44"].contains(&word) && machine.controller.eq_ignore_ascii_case("grundig");
    // What the transformation does is seen in the motion.
    let is_of_transform = word.starts_with("TRA") || word.starts_with("ORI");
    OF_COORDINATES.contains(&word) || OF_FEEDS.contains(&word) || is_along_axis || is_of_transform
}

/// What a control finds a program by: the `O1000` of `O1000 (PLATE)`, `%PM9010`, `%_N_PLATE_MPF`; `None` for other lines of a header.
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

/// A number without the noise of arithmetic.
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
        // A control whose speeds are whole numbers.
        assert_eq!(found("S1234.4", "S1234"), [""; 0]);
    }
}
