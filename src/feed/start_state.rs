//! The state of the control at the start of a job: the codes that a program assumes and does not state, and the zero offsets for which it is corrected.
//!
//! A control keeps the codes of an earlier program: its plane, its kind of feed, its zero offset. The correction is for those of `control.startup_code`, else for those with which
//! RS274/NGC begins.

use crate::program::Program;
use ncfix_base::geometry::{AXES, FrameParts};
use ncfix_dialect::Language;
use ncfix_dnc::feed::{ExpectedZero, Profile, ZERO_LETTERS, ZeroValues};
use ncfix_machine::machine::Machine;

/// Codes at the start of a program, with the first and the last code of their groups, in tenths: G17, G94, G54.
const ASSUMED: [(u32, [u32; 2]); 3] = [(170, [170, 192]), (940, [930, 950]), (540, [540, 593])];
/// Code in tenths that sets the values of offsets.
const G10: u32 = 100;
/// Codes in tenths of the selectable zero offsets.
const SYSTEMS: std::ops::RangeInclusive<u32> = 540..=593;
/// Codes in tenths that state a tool length or cancel it.
const LENGTHS: [u32; 4] = [430, 431, 432, 490];
/// Codes in tenths by which a program changes a zero offset itself: G10, G92, a tool length by its value.
const CHANGING: [u32; 7] = [G10, 431, 520, 920, 921, 922, 923];

/// Calls `take` with each G code of a text in tenths, outside comments, and with `None` for each axis word. It stops when `take` returns false.
fn each_word(text: &[u8], take: &mut dyn FnMut(Option<u32>) -> bool) {
    let (mut is_comment, mut at) = (None, 0);
    while let Some(byte) = text.get(at).map(u8::to_ascii_uppercase) {
        at += 1;
        match (is_comment, byte) {
            (Some(end), _) if byte == end => is_comment = None,
            (Some(_), _) => {}
            (None, b'(') => is_comment = Some(b')'),
            (None, b';') => is_comment = Some(b'\n'),
            (None, b'G') => {
                let rest = text.get(at..).unwrap_or_default();
                let end = rest.iter().position(|byte| !(byte.is_ascii_digit() || *byte == b'.')).unwrap_or(rest.len());
                let value = std::str::from_utf8(rest.get(..end).unwrap_or_default()).ok();
                let tenths = value.and_then(|value| value.parse().ok()).map(|value: f64| (value * 10.0).round());
                if let Some(tenths) = tenths.filter(|tenths| *tenths < 1e5)
                    && !take(Some(tenths as u32))
                {
                    return;
                }
            }
            (None, b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C') => {
                let next = text.get(at..).unwrap_or_default().trim_ascii_start().first();
                let is_value = next.is_some_and(|next| next.is_ascii_digit() || b"+-.[#".contains(next));
                if is_value && !take(None) {
                    return;
                }
            }
            _ => {}
        }
    }
}

/// The codes that a program in RS274/NGC assumes and does not state before its first position: those of the startup code, else the
/// usual ones; empty for other links and languages.
pub(super) fn unstated(program: &Program, machine: &Machine, language: Language, profile: &Profile) -> String {
    // Marlin has none of them, and its lines are commands of one code each.
    if language != Language::Rs274 || profile.protocol.rewrite.is_some() {
        return String::new();
    }
    let last_of = |text: &[u8], place: usize| {
        let (_, [first, last]) = ASSUMED[place];
        let mut found = None;
        each_word(text, &mut |word| {
            found = word.filter(|code| (first..=last).contains(code)).or(found);
            word.is_some()
        });
        found
    };
    let startup = machine.control.iso.startup_code.as_bytes();
    let lacking = (0..ASSUMED.len()).filter(|place| last_of(program.bytes(), *place).is_none());
    let codes = lacking.map(|place| written(last_of(startup, place).unwrap_or(ASSUMED[place].0)));
    codes.collect::<Vec<_>>().join(" ")
}

/// Writes a code that is given in tenths.
fn written(code: u32) -> String {
    if code.is_multiple_of(10) { format!("G{}", code / 10) } else { format!("G{}.{}", code / 10, code % 10) }
}

/// The zero offsets for which a job is corrected. `earlier` is the statement of the control when it began, if it is resumed.
pub(super) fn expected_zero(program: &Program, machine: &Machine, earlier: Option<String>) -> ExpectedZero {
    let (mut named, mut is_changed_by_program, mut sets_values) = (Vec::new(), false, false);
    let mut states_length = false;
    each_word(program.bytes(), &mut |word| {
        if let Some(code) = word {
            is_changed_by_program |= CHANGING.contains(&code);
            sets_values |= code == G10;
            states_length |= LENGTHS.contains(&code);
            if SYSTEMS.contains(&code) && !named.contains(&code) {
                named.push(code);
            }
        }
        true
    });
    let values = machine.zero_offsets.iter().filter_map(|(name, parts)| {
        let number: f64 = name.strip_prefix('G')?.parse().ok()?;
        let code = (number * 10.0).round();
        let is_system = code >= 0.0 && SYSTEMS.contains(&(code as u32));
        is_system.then(|| (code as u32, zero_values(parts)))
    });
    // With G10 the program sets the values with which the control begins.
    let offsets = if sets_values { Vec::new() } else { values.collect() };
    let axes = AXES.into_iter().filter(|axis| machine.axis(*axis).is_some()).map(|axis| axis.letter()).collect();
    ExpectedZero { axes, offsets, named, is_changed_by_program, states_length, earlier }
}

/// The values of an offset as controls list them.
fn zero_values(parts: &FrameParts) -> ZeroValues {
    let shift = parts.shift();
    let mut out = ZeroValues::default();
    for (to, letter) in out.iter_mut().zip(ZERO_LETTERS) {
        *to = match AXES.into_iter().find(|axis| axis.letter() == *letter) {
            Some(axis) if axis.is_rotary() => shift[axis].to_degrees(),
            Some(axis) => shift[axis],
            // The rotation about Z.
            None => parts.rotation[2].to_degrees(),
        };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(text: &str) -> Vec<Option<u32>> {
        let mut out = Vec::new();
        each_word(text.as_bytes(), &mut |word| {
            out.push(word);
            true
        });
        out
    }

    #[test]
    fn comments_have_no_words() {
        assert_eq!(codes("(G54 X1)\ng59.1;G17\nG0 X1"), [Some(591), Some(0), None]);
        assert_eq!(codes("G04 P1\nO<box> CALL\nG1Z#5"), [Some(40), Some(10), None]);
    }
}
