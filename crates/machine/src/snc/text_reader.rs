//! Reads the text form of the stream.

use super::{Dwell, Element, FeedUnit, Kind, Move, Origin, Turning, Word, WordValue};
use ncfix_base::geometry::{Arc, Axis, AxisSet, AxisVector, Matrix, Plane, Vector};
use ncfix_base::source::Span;

/// A normal shorter than this has no direction.
const SHORTEST_NORMAL: f64 = 1e-6;

/// Reason why a line of SNC text cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextError {
    /// Line number, from 1.
    pub line: usize,
    /// Description of the fault.
    pub message: String,
}

/// Converts an axis command to the position fixed to the workpiece.
type OnWorkpiece<'a> = Box<dyn Fn(&AxisVector) -> AxisVector + 'a>;

/// Reads SNC text. Positions are taken as axis commands, that is, for a tool of length zero.
pub struct TextReader<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    on_workpiece: OnWorkpiece<'a>,
    position: AxisVector,
    known: AxisSet,
    call_lines: Vec<u32>,
}

impl<'a> TextReader<'a> {
    /// Creates a reader of a text.
    #[must_use]
    pub fn new(text: &'a str) -> Self {
        TextReader {
            lines: text.lines().enumerate(),
            on_workpiece: Box::new(|command| *command),
            position: AxisVector::ZERO,
            known: AxisSet::EMPTY,
            call_lines: Vec::new(),
        }
    }

    /// Sets the conversion of an axis command to the position fixed to the workpiece, mm and rad, for the centers of arcs in the workpiece.
    #[must_use]
    pub fn with_workpiece(self, on_workpiece: impl Fn(&AxisVector) -> AxisVector + 'a) -> Self {
        TextReader { on_workpiece: Box::new(on_workpiece), ..self }
    }

    /// Returns the lines of the calls that led to the last element, innermost first.
    #[must_use]
    pub fn call_lines(&self) -> &[u32] {
        &self.call_lines
    }

    fn element(&mut self, text: &str, number: usize) -> Result<Option<Element>, String> {
        let (words, comment) = words_and_comment(text);
        let mut values = Vec::new();
        for word in words {
            let letter = word.as_bytes().first().copied().filter(u8::is_ascii_alphabetic);
            let (Some(letter), Some(rest)) = (letter, word.get(1..)) else {
                return Err("a word does not begin with a letter".into());
            };
            values.push((letter, rest));
        }
        let Some(&(first, code)) = values.first() else { return Ok(None) };
        let mut lines = match comment.strip_prefix('@') {
            Some(origin) => origin
                .split('<')
                .map(|line| line.trim().parse().map_err(|_| "the origin after ;@ is not a line number"))
                .collect::<Result<Vec<u32>, _>>()?,
            None => vec![u32::try_from(number).unwrap_or(u32::MAX)],
        };
        let line = lines.remove(0);
        self.call_lines = lines;
        let origin = Origin { line, span: Span::default(), ..Origin::default() };
        let kind = match (first, code) {
            (b'G', "4") => self.dwell(&values[1..])?,
            (b'G', _) => {
                let (plain, tip) = motion_code(code).ok_or_else(|| format!("G{code} does not occur in SNC"))?;
                Kind::Move(Move { tip, ..self.motion(plain, tip.is_some(), &values[1..])? })
            }
            (b'T', _) => Kind::Tool(value_of(code)?),
            _ => Kind::Before(values.iter().map(|&(letter, rest)| auxiliary(letter, rest)).collect::<Result<_, _>>()?),
        };
        Ok(Some(Element { origin, starts_block: true, number: None, kind }))
    }

    fn dwell(&self, values: &[(u8, &str)]) -> Result<Kind, String> {
        match values {
            [(b'S', seconds)] => Ok(Kind::Dwell(Dwell::Seconds(parse(seconds)?))),
            [(b'R', turns)] => Ok(Kind::Dwell(Dwell::Turns(parse(turns)?))),
            _ => Err("G4 needs S with seconds or R with turns".into()),
        }
    }

    fn motion(&mut self, code: &str, is_in_workpiece: bool, values: &[(u8, &str)]) -> Result<Move, String> {
        let mut target = self.position;
        let mut named = AxisSet::EMPTY;
        let (mut ijk, mut plane, mut extra_turns, mut feed) = ([0.0; 3], Plane::XY, 0, None);
        let mut unit = FeedUnit::PerMinute;
        let mut normal: Option<Vector> = None;
        for &(letter, text) in values {
            let value: f64 = parse(text)?;
            match (Axis::from_letter(letter), letter) {
                (Some(axis), _) => {
                    target[axis] = if axis.is_rotary() { value.to_radians() } else { value };
                    named.insert(axis);
                }
                (None, b'I' | b'J' | b'K') => ijk[usize::from(letter - b'I')] = value,
                (None, b'D') => normal.get_or_insert_default().x = value,
                (None, b'E') => normal.get_or_insert_default().y = value,
                (None, b'H') => normal.get_or_insert_default().z = value,
                (None, b'P') => {
                    let number = text.parse().map_err(|_| "P must be 17, 18 or 19")?;
                    plane = Plane::from_number(number).ok_or("P must be 17, 18 or 19")?;
                }
                (None, b'L') => extra_turns = text.parse().map_err(|_| "L must be a whole number")?,
                (None, b'F') => feed = Some(value),
                (None, b'G') if feed.is_some() && text == "93" => unit = FeedUnit::InverseTime,
                (None, b'G') if feed.is_some() && text == "95" => unit = FeedUnit::PerTurn,
                _ => return Err(format!("'{}' is not a word of a motion block", char::from(letter))),
            }
        }
        let start = if is_in_workpiece { (self.on_workpiece)(&self.position) } else { self.position };
        let arc_basis = match normal {
            None => None,
            Some(normal) => Some(basis_of(&normal).ok_or("D E H must be the direction of a normal")?),
        };
        let (start, ijk) = match &arc_basis {
            None => (start, ijk),
            Some(basis) => {
                let mut flat = start;
                flat.set_xyz(basis.tr_mul(&start.xyz()));
                (flat, basis.tr_mul(&Vector::from(ijk)).into())
            }
        };
        let arc = matches!(code, "2" | "3").then(|| {
            let [abscissa, ordinate, _] = plane.axes();
            Arc {
                plane,
                clockwise: code == "2",
                center_mm: [start[abscissa] + ijk[abscissa.slot()], start[ordinate] + ijk[ordinate.slot()]],
                extra_turns,
            }
        });
        self.position = target;
        self.known = self.known.union(named);
        Ok(Move {
            rapid: code == "0",
            arc,
            target,
            named,
            known: self.known,
            feed: feed.unwrap_or(0.0),
            feed_named: feed.is_some(),
            unit,
            ways: Default::default(),
            in_machine_frame: false,
            motion_mode: Default::default(),
            off_curve_mm: 0.0,
            tip: None,
            arc_basis,
        })
    }
}

impl Iterator for TextReader<'_> {
    type Item = Result<Element, TextError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let (index, text) = self.lines.next()?;
            match self.element(text, index + 1) {
                Ok(None) => {}
                Ok(Some(element)) => return Some(Ok(element)),
                Err(message) => return Some(Err(TextError { line: index + 1, message })),
            }
        }
    }
}

/// Orthonormal columns, the third along a normal; `None` for a vector without a direction.
fn basis_of(normal: &Vector) -> Option<Matrix> {
    let third = normal.try_normalize(SHORTEST_NORMAL)?;
    // The direction that is farthest from the normal.
    let aside = [Vector::x(), Vector::y(), Vector::z()]
        .into_iter()
        .min_by(|one, other| one.dot(&third).abs().total_cmp(&other.dot(&third).abs()))?;
    let first = aside.cross(&third).try_normalize(SHORTEST_NORMAL)?;
    Some(Matrix::from_columns(&[first, third.cross(&first), third]))
}

/// The code of a motion without its suffix, and the turning of the tool that the suffix names; `None` for another code.
fn motion_code(code: &str) -> Option<(&str, Option<Turning>)> {
    let (plain, tip) = match code.split_once('.') {
        None => (code, None),
        Some((plain, "W")) => (plain, Some(Turning::Axes)),
        Some((plain, "V")) => (plain, Some(Turning::Vector)),
        Some(_) => return None,
    };
    matches!(plain, "0" | "1" | "2" | "3").then_some((plain, tip))
}

/// Splits a line into its words and the text after its semicolon. Tool names are in quotation marks and may contain blanks and semicolons.
fn words_and_comment(text: &str) -> (Vec<&str>, &str) {
    let (mut words, mut start, mut is_name) = (Vec::new(), 0, false);
    let mut end_word = |start: usize, end: usize| words.extend(text.get(start..end).filter(|word| !word.is_empty()));
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'"' => is_name = !is_name,
            _ if is_name => {}
            b';' => {
                end_word(start, at);
                return (words, text.get(at + 1..).unwrap_or_default());
            }
            _ if byte.is_ascii_whitespace() => {
                end_word(start, at);
                start = at + 1;
            }
            _ => {}
        }
    }
    end_word(start, text.len());
    (words, "")
}

fn auxiliary(letter: u8, rest: &str) -> Result<Word, String> {
    let (extension, text) = match rest.split_once('=') {
        // `D="NAME"`
        Some(("", text)) => (None, text),
        Some((extension, text)) => {
            (Some(extension.parse().map_err(|_| "an address extension must be a whole number")?), text)
        }
        None => (None, rest),
    };
    Ok(Word { letter, extension, value: value_of(text)? })
}

fn value_of(text: &str) -> Result<WordValue, String> {
    match text.trim_start_matches('=').strip_prefix('"').and_then(|name| name.strip_suffix('"')) {
        Some(name) => Ok(WordValue::Name(name_of(name.as_bytes()))),
        None => Ok(WordValue::Number(parse(text)?)),
    }
}

/// Returns a name with each `\x1b` replaced by its byte.
fn name_of(mut text: &[u8]) -> Vec<u8> {
    let mut name = Vec::with_capacity(text.len());
    while let Some((&first, rest)) = text.split_first() {
        let hex =
            rest.get(1..3).filter(|_| first == b'\\' && rest[0] == b'x').and_then(|hex| std::str::from_utf8(hex).ok());
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                name.push(byte);
                text = &rest[3..];
            }
            None => {
                name.push(first);
                text = rest;
            }
        }
    }
    name
}

fn parse(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| format!("'{text}' is not a number"))
}
