//! Two programs compared as they are written: for programs that do not run here, or that have nothing to do with each other.
//!
//! Lines are aligned by what they say without their numbers, so that a program of which every line is changed is aligned as well as one of which none
//! is. Block numbers, comments, blanks and the way a number is written do not count: `X3.100F30.` is `N10 X3.1 F030`.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::{Duration, Instant};

use similar::{Algorithm, DiffOp, capture_diff_slices_deadline};

use super::words::{Word, words};

/// After this time lines are aligned as well as they are by then.
const LONGEST: Duration = Duration::from_secs(5);
/// Addresses whose numbers are codes: another one is another line.
const CODES: [&str; 6] = ["G", "M", "T", "D", "H", "L"];

/// What became of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Pairing {
    /// It says the same: lines of both, from 1.
    Same([u32; 2]),
    /// It says the same with other numbers.
    Changed([u32; 2], Vec<Change>),
    /// It is in the first program only.
    Gone(u32),
    /// It is in the second program only.
    New(u32),
}

/// A word with another number.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Its address.
    pub address: String,
    /// As it is written in both.
    pub texts: [String; 2],
    /// The second number less the first, in the unit of the programs.
    pub added: f64,
}

/// The lines of a program that say anything, with their numbers.
fn lines(bytes: &[u8], end: u8) -> Vec<(u32, String)> {
    let all = bytes.split(|byte| *byte == end).zip(1_u32..);
    let texts = all.map(|(line, number)| (number, String::from_utf8_lossy(line).into_owned()));
    texts.filter(|(_, text)| !words(text).is_empty()).collect()
}

/// What a line says without its numbers.
fn key(text: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    for word in words(text) {
        word.address.to_ascii_uppercase().hash(&mut hasher);
        let is_code = CODES.iter().any(|code| word.address.eq_ignore_ascii_case(code));
        match word.number {
            Some(number) if is_code => number.to_bits().hash(&mut hasher),
            Some(_) => {}
            None => word.value.to_ascii_uppercase().hash(&mut hasher),
        }
    }
    hasher.finish()
}

/// The words of two lines with the same key whose numbers differ by more than the tolerance.
fn changes(one: &str, other: &str, tolerance: f64) -> Vec<Change> {
    let pairs = words(one).into_iter().zip(words(other));
    let change = |(one, other): (Word<'_>, Word<'_>)| {
        let added = other.number? - one.number?;
        let texts = [one.value.to_owned(), other.value.to_owned()];
        (added.abs() > tolerance).then(|| Change { address: one.address.to_ascii_uppercase(), texts, added })
    };
    pairs.filter_map(change).collect()
}

/// Aligns two programs, whose lines end with these bytes. Numbers that differ by no more than the tolerance are the same.
#[must_use]
pub fn compare([one, other]: [(&[u8], u8); 2], tolerance: f64) -> Vec<Pairing> {
    let [one, other] = [one, other].map(|(bytes, end)| lines(bytes, end));
    let [one_keys, other_keys] = [&one, &other].map(|all| all.iter().map(|(_, text)| key(text)).collect::<Vec<u64>>());
    let deadline = Some(Instant::now() + LONGEST);
    let steps = capture_diff_slices_deadline(Algorithm::Myers, &one_keys, &other_keys, deadline);
    let mut out = Vec::with_capacity(one.len().max(other.len()));
    for step in steps {
        let (of_one, of_other) = (step.old_range(), step.new_range());
        if let DiffOp::Equal { .. } = step {
            for (one, other) in one[of_one].iter().zip(&other[of_other]) {
                let numbers = [one.0, other.0];
                let changes = changes(&one.1, &other.1, tolerance);
                out.push(if changes.is_empty() { Pairing::Same(numbers) } else { Pairing::Changed(numbers, changes) });
            }
        } else {
            out.extend(one[of_one].iter().map(|(number, _)| Pairing::Gone(*number)));
            out.extend(other[of_other].iter().map(|(number, _)| Pairing::New(*number)));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_comments_and_spelling_do_not_count() {
        let one = "%\nN10 X3.100 F30.0 (FIRST)\nG1 Y2\nM30\n";
        let other = "N5 x3.1F030\n\nN20 G01 Y2. ; same\nM30";
        let found = compare([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.0);
        assert_eq!(found, [Pairing::Same([2, 1]), Pairing::Same([3, 3]), Pairing::Same([4, 4])]);
    }

    #[test]
    fn every_line_may_have_another_number() {
        let one: String = (0..500).map(|k| format!("N{k} G1 X{k} Y{}\n", 2 * k)).collect();
        let other: String = (0..500).map(|k| format!("G1 X{k}.0123 Y{}\n", 2 * k)).collect();
        let found = compare([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.0);
        assert_eq!(found.len(), 500);
        let Pairing::Changed([8, 8], changes) = &found[7] else { panic!("{:?}", found[7]) };
        assert_eq!(
            (changes[0].address.as_str(), changes[0].texts.clone()),
            ("X", ["7".to_owned(), "7.0123".to_owned()])
        );
        assert!((changes[0].added - 0.0123).abs() < 1e-12 && changes.len() == 1);
        let alike = compare([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.02);
        assert!(alike.iter().all(|line| matches!(line, Pairing::Same(_))));
    }

    #[test]
    fn lines_that_came_and_went_are_named() {
        let one = "G0 X1\nG1 X2 F100\nG1 X3\nM30\n";
        let other = "G0 X1\nG1 X2.5 F100\nG4 F1\nM30\n";
        let found = compare([(one.as_bytes(), b'\n'), (other.as_bytes(), b'\n')], 0.0);
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
