//! Textual comparison of two programs: for programs that cannot be executed here or that are unrelated.
//!
//! Lines are aligned by their text and by their target position to a millimeter. A program in which every line is changed is thus aligned as well as
//! an unchanged one. Block numbers, comments, blanks, number formats and repeated modal words have no effect: `X3.100F30.` equals `N10 G1 X3.1 F030`
//! while G1 is active.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::{Duration, Instant};

use similar::{Algorithm, DiffOp, capture_diff_slices_deadline};

use super::words::{LineWord, words};

/// Time limit; after it the alignment reached so far is used.
const LONGEST: Duration = Duration::from_secs(5);
/// Addresses whose numbers are codes: another code makes another line.
const CODES: [&str; 6] = ["G", "M", "T", "D", "H", "L"];

/// The alignment result of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Pairing {
    /// Equal text: lines of both programs, from 1.
    Same([u32; 2]),
    /// Equal but for numbers.
    Changed([u32; 2], Vec<ChangedNumber>),
    /// Present in the first program only.
    Gone(u32),
    /// Present in the second program only.
    New(u32),
}

/// A word with another number.
#[derive(Clone, Debug, PartialEq)]
pub struct ChangedNumber {
    /// Its address.
    pub address: String,
    /// Its text in both programs.
    pub texts: [String; 2],
    /// The second number minus the first, in the unit of the programs.
    pub added: f64,
}

/// A line with content.
#[derive(Clone, Copy, Debug)]
struct Line {
    number: u32,
    /// Start and length, bytes.
    at: (u32, u32),
    /// Hash of the line without numbers.
    loose: u64,
    /// Hash that includes the axis positions to a millimeter.
    near: u64,
    /// Axis positions after the line, and the feed, as far as numbers determine them; otherwise NaN.
    now: [f64; MODAL.len()],
}

/// The lines of a program with content. Positions, feed and motion mode carry over from line to line, so that repeated modal words have no effect.
fn lines(bytes: &[u8], end: u8) -> Vec<Line> {
    let mut now = [f64::NAN; MODAL.len()];
    let mut motion = f64::NAN;
    let mut out = Vec::new();
    let mut next = 0_usize;
    for (line, number) in bytes.split(|byte| *byte == end).zip(1_u32..) {
        let at = (next as u32, line.len() as u32);
        next += line.len() + 1;
        let text = String::from_utf8_lossy(line);
        let words = words(&text);
        if words.is_empty() {
            continue;
        }
        let mut hasher = DefaultHasher::new();
        let mut moves = false;
        for word in &words {
            if is_motion(word) {
                motion = word.number.unwrap_or(motion);
            } else if let Some(place) = modal(word) {
                now[place] = word.number.unwrap_or(f64::NAN);
                moves |= place < FEED;
            } else {
                word.address.to_ascii_uppercase().hash(&mut hasher);
                let is_code = CODES.iter().any(|code| word.address.eq_ignore_ascii_case(code));
                match word.number {
                    Some(number) if is_code => number.to_bits().hash(&mut hasher),
                    Some(_) => {}
                    None => word.value.to_ascii_uppercase().hash(&mut hasher),
                }
            }
        }
        if moves {
            motion.to_bits().hash(&mut hasher);
        }
        let loose = hasher.finish();
        let places = now.iter().take(FEED).map(|place| if place.is_nan() { i64::MIN } else { place.round() as i64 });
        places.for_each(|place| place.hash(&mut hasher));
        let near = if moves { hasher.finish() } else { loose };
        out.push(Line { number, at, loose, near, now });
    }
    out
}

/// Addresses whose numbers are modal.
const MODAL: [&str; 10] = ["X", "Y", "Z", "A", "B", "C", "U", "V", "W", "F"];
/// Index of the feed in [`MODAL`].
const FEED: usize = MODAL.len() - 1;

fn modal(word: &LineWord<'_>) -> Option<usize> {
    MODAL.iter().position(|address| word.address.eq_ignore_ascii_case(address))
}

/// `true` for G0 to G3.
fn is_motion(word: &LineWord<'_>) -> bool {
    word.address.eq_ignore_ascii_case("G") && word.number.is_some_and(|number| (0.0..=3.0).contains(&number))
}

/// The words of two lines whose numbers differ by more than the tolerance.
fn changes([one, other]: [&Line; 2], texts: [&str; 2], tolerance: f64) -> Vec<ChangedNumber> {
    let [of_one, of_other] = texts.map(words);
    // Codes of aligned lines are equal.
    let counts = |word: &&LineWord<'_>| !CODES.iter().any(|code| word.address.eq_ignore_ascii_case(code));
    let mut out = Vec::new();
    let mut note = |address: &str, texts: [&str; 2], numbers: [Option<f64>; 2]| {
        let [Some(before), Some(after)] = numbers else { return };
        let added = after - before;
        if added.abs() > tolerance {
            out.push(ChangedNumber { address: address.to_ascii_uppercase(), texts: texts.map(str::to_owned), added });
        }
    };
    // If a line does not repeat a modal word, the active value is compared.
    let holds = |line: &Line, place: Option<usize>| place.map(|place| line.now[place]).filter(|held| !held.is_nan());
    for word in of_one.iter().filter(counts) {
        let same = of_other.iter().find(|other| other.address.eq_ignore_ascii_case(word.address));
        let number = same.map_or(holds(other, modal(word)), |other| other.number);
        note(word.address, [word.value, same.map_or("", |other| other.value)], [word.number, number]);
    }
    for word in of_other.iter().filter(counts) {
        if !of_one.iter().any(|one| one.address.eq_ignore_ascii_case(word.address)) {
            note(word.address, ["", word.value], [holds(one, modal(word)), word.number]);
        }
    }
    out
}

/// Two aligned programs. The result of a line is computed on demand, as there may be millions.
#[derive(Debug)]
pub struct Aligned<'a> {
    bytes: [&'a [u8]; 2],
    lines: [Vec<Line>; 2],
    /// Indices of paired lines, or of single lines.
    pairs: Vec<[u32; 2]>,
    tolerance: f64,
}

/// Index for no line.
const NONE: u32 = u32::MAX;

/// Aligns two programs, each with its line end byte. Numbers that differ by at most the tolerance count as equal.
#[must_use]
pub fn compare(programs: [(&[u8], u8); 2], tolerance: f64) -> Aligned<'_> {
    let [one, other] = programs.map(|(bytes, end)| lines(bytes, end));
    let [one_keys, other_keys] = [&one, &other].map(|all| all.iter().map(|line| line.near).collect::<Vec<u64>>());
    let deadline = Some(Instant::now() + LONGEST);
    let steps = capture_diff_slices_deadline(Algorithm::Myers, &one_keys, &other_keys, deadline);
    let mut pairs = Vec::with_capacity(one.len().max(other.len()));
    for step in steps {
        let (of_one, of_other) = (step.old_range(), step.new_range());
        // Positions on both sides of a half millimeter, or farther apart: lines still pair if they are equal but for the numbers.
        let is_alike = |(one_at, other_at): &(usize, usize)| one[*one_at].loose == other[*other_at].loose;
        let alike = match step {
            DiffOp::Equal { .. } => of_one.len(),
            _ if of_one.len() == of_other.len() => of_one.clone().zip(of_other.clone()).take_while(is_alike).count(),
            _ => 0,
        };
        pairs.extend(of_one.clone().zip(of_other.clone()).take(alike).map(|(one, other)| [one as u32, other as u32]));
        pairs.extend(of_one.skip(alike).map(|one| [one as u32, NONE]));
        pairs.extend(of_other.skip(alike).map(|other| [NONE, other as u32]));
    }
    Aligned { bytes: programs.map(|(bytes, _)| bytes), lines: [one, other], pairs, tolerance }
}

impl Aligned<'_> {
    /// The number of lines; a pair counts once.
    #[must_use]
    pub fn count(&self) -> usize {
        self.pairs.len()
    }

    /// The result of a line, by its index in the merged order of both programs.
    #[must_use]
    pub fn at(&self, place: usize) -> Option<Pairing> {
        let [one, other] = *self.pairs.get(place)?;
        let line = |program: usize, at: u32| self.lines[program].get(at as usize);
        Some(match (line(0, one), line(1, other)) {
            (Some(one), Some(other)) => {
                let [before, after] = [self.text(0, one), self.text(1, other)];
                let changes = changes([one, other], [&before, &after], self.tolerance);
                let numbers = [one.number, other.number];
                if changes.is_empty() { Pairing::Same(numbers) } else { Pairing::Changed(numbers, changes) }
            }
            (Some(one), None) => Pairing::Gone(one.number),
            (None, other) => Pairing::New(other?.number),
        })
    }

    /// All results, in order.
    pub fn all(&self) -> impl Iterator<Item = Pairing> {
        (0..self.count()).filter_map(|place| self.at(place))
    }

    fn text(&self, program: usize, line: &Line) -> std::borrow::Cow<'_, str> {
        let (from, length) = (line.at.0 as usize, line.at.1 as usize);
        String::from_utf8_lossy(self.bytes[program].get(from..from + length).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(programs: [(&[u8], u8); 2], tolerance: f64) -> Vec<Pairing> {
        compare(programs, tolerance).all().collect()
    }

    #[test]
    fn numbers_comments_and_spelling_do_not_count() {
        let one = "%\nN10 X3.100 F30.0 (FIRST)\nG1 Y2\nM30\n";
        let other = "N5 x3.1F030\n\nN20 G01 Y2. ; same\nM30";
        let found = all([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.0);
        assert_eq!(found, [Pairing::Same([2, 1]), Pairing::Same([3, 3]), Pairing::Same([4, 4])]);
    }

    #[test]
    fn every_line_may_have_another_number() {
        let one: String = (0..500).map(|k| format!("N{k} G1 X{k} Y{}\n", 2 * k)).collect();
        let other: String = (0..500).map(|k| format!("G1 X{k}.0123 Y{}\n", 2 * k)).collect();
        let found = all([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.0);
        assert_eq!(found.len(), 500);
        let Pairing::Changed([8, 8], changes) = &found[7] else { panic!("{:?}", found[7]) };
        assert_eq!(
            (changes[0].address.as_str(), changes[0].texts.clone()),
            ("X", ["7".to_owned(), "7.0123".to_owned()])
        );
        assert!((changes[0].added - 0.0123).abs() < 1e-12 && changes.len() == 1);
        let alike = all([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.02);
        assert!(alike.iter().all(|line| matches!(line, Pairing::Same(_))));
    }

    #[test]
    fn a_line_that_came_in_between_shifts_no_other() {
        let line = |k: u32, by: f64| format!("X{:.4} Y{:.4}\n", f64::from(k) * 1.7 + by, f64::from(k * k) / 50.0 - by);
        let one: String = (0..300).map(|k| line(k, 0.0)).collect();
        let other: String =
            (0..300).map(|k| if k == 100 { "X170.5\n".to_owned() + &line(k, 0.012) } else { line(k, 0.012) }).collect();
        let (one, other) = (format!("G1 F100\n{one}"), format!("G1 F100\n{other}"));
        let found = all([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.02);
        let new: Vec<u32> =
            found.iter().filter_map(|line| if let Pairing::New(k) = line { Some(*k) } else { None }).collect();
        assert!(new.len() <= 2 && !new.is_empty() && new.iter().all(|k| (100..=104).contains(k)), "{new:?}");
        assert!(found.iter().filter(|line| matches!(line, Pairing::Same(_))).count() >= 298);
    }

    #[test]
    fn repeated_modal_words_are_the_same() {
        let one = "G1 X1 Y2 F100\nX3\nY5\nG0 Z4\n";
        let other = "G1 X1 Y2 F100\nG1 X3 Y2\nG1 X3.01 Y5 F100\nG1 Z4\n";
        let found = all([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.0);
        assert_eq!(found[..2], [Pairing::Same([1, 1]), Pairing::Same([2, 2])]);
        let Pairing::Changed([3, 3], changes) = &found[2] else { panic!("{found:?}") };
        assert_eq!((changes[0].address.as_str(), &changes[0].texts), ("X", &[String::new(), "3.01".to_owned()]));
        // A rapid move is not a feed move.
        assert_eq!(found[3..], [Pairing::Gone(4), Pairing::New(4)]);
    }

    #[test]
    fn lines_that_came_and_went_are_named() {
        let one = "G0 X1\nG1 X2 F100\nG1 X3\nM30\n";
        let other = "G0 X1\nG1 X2.4 F100\nG4 F1\nM30\n";
        let found = all([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.0);
        let names: Vec<&str> = found
            .iter()
            .map(|line| match line {
                Pairing::Same(_) => "same",
                Pairing::Changed(..) => "changed",
                Pairing::Gone(_) => "gone",
                Pairing::New(_) => "new",
            })
            .collect();
        assert_eq!(names, ["same", "changed", "gone", "new", "same"]);
    }
}
