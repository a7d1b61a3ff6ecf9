//! Marlin: zero offset in force.
//!
//! A build with `M114_DETAIL` answers `M114 D` with the position in the coordinates of the program (`Logical: X: 1.000 …`) and in those of the machine
//! (`Raw: X: 11.000 …`), as in `M114.cpp`. Their difference is the offset in force: that of `G54` to `G59.3`, of `G92` and of `M206`. Other builds print the
//! usual position, and a person must compare the offset.

use super::{Event, Marlin};
use crate::feed::dialogue::position::number;

/// Question for the positions in both coordinates.
pub(super) const DETAIL: &[u8] = b"M114 D";
/// Labels of further lines of the answer.
const OTHERS: &[&str] = &[
    "Leveled:",
    "UnLevel:",
    "UnLeveled:",
    "UnWarped:",
    "Stepper:",
    "FromStp:",
    "Differ:",
    "DeltaK:",
    "ScaraK:",
    "PolarK:",
];

/// Position by axis letters.
type AxisPositions = Vec<(u8, f64)>;

/// Zero offset as the control states it.
#[derive(Debug, Default)]
pub(super) struct StatedOffset {
    logical: AxisPositions,
    raw: AxisPositions,
    /// True if the control has stated both once.
    pub(super) is_known: bool,
    /// True if the line under way selects an offset.
    pub(super) is_selected: bool,
}

/// Reads ` X:   1.000 Y:   2.000 E: 0.0`; `None` if it is another text.
fn positions(text: &str) -> Option<AxisPositions> {
    let mut out = Vec::new();
    let mut rest = text.trim_ascii();
    while let Some((letter, next)) = rest.split_once(':') {
        let &[letter] = letter.trim_ascii().as_bytes() else { return None };
        let next = next.trim_ascii_start();
        let end = next.find(' ').unwrap_or(next.len());
        let (value, _) = number(next.get(..end)?)?;
        out.push((letter, value));
        rest = next.get(end..)?.trim_ascii_start();
    }
    (rest.is_empty() && !out.is_empty()).then_some(out)
}

impl Marlin {
    /// Notes a line of the answer. Returns false if it is another text.
    pub(super) fn hear_detail(&mut self, text: &str) -> bool {
        for (label, into) in [("Logical:", &mut self.offset.logical), ("Raw:", &mut self.offset.raw)] {
            if let Some(found) = text.strip_prefix(label).and_then(positions) {
                *into = found;
                return true;
            }
        }
        // The usual position is the answer of other builds.
        text.starts_with("X:") || OTHERS.iter().any(|label| text.starts_with(label))
    }

    /// Compares the offset in force, once the question was answered. Returns why the job must end.
    pub(super) fn compare_zero(&mut self, is_opening: bool, events: &mut Vec<Event>) -> Option<String> {
        let (logical, raw) = (std::mem::take(&mut self.offset.logical), std::mem::take(&mut self.offset.raw));
        let at = |letter: u8| logical.iter().find(|(known, _)| *known == letter).map(|(_, value)| *value);
        let stated: Vec<(u8, f64)> = raw
            .iter()
            .filter_map(|&(letter, raw)| Some((letter, raw - at(letter)?)))
            .filter(|(letter, _)| *letter != b'E')
            .collect();
        let was_known = std::mem::replace(&mut self.offset.is_known, !stated.is_empty());
        if was_known && !self.offset.is_known {
            return Some("the control does not state the zero offset that a line selects".to_owned());
        }
        if !self.offset.is_known {
            events.push(Event::Said(format!(
                "the control does not state its zero offset (M114 D needs a build with M114_DETAIL): compare {} at the control, with G92 and M206",
                self.zero.by_hand()
            )));
            return None;
        }
        // The program selects its offset later.
        if is_opening && self.zero.names_any() {
            return None;
        }
        let why = self.zero.see_in_force(&stated);
        if why.is_none() {
            events.extend(self.zero.stated().map(Event::ZeroOffsets));
        }
        why
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_have_blanks_before_their_numbers() {
        let told = [(b'X', 1.0), (b'Y', -22.5), (b'Z', 3.25)];
        assert_eq!(positions(" X:   1.000 Y: -22.500 Z:   3.250"), Some(told.to_vec()));
        assert_eq!(positions("X:1.000 Y:-22.500 Z:3.250"), Some(told.to_vec()));
        for text in ["", "X:", "X 1", "X:1 Y", "Count X:80"] {
            assert_eq!(positions(text), None, "{text}");
        }
    }
}
