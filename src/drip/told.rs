//! What a control was told by the lines before a place: the last code of every group, spindle and coolant, where each axis stands.

use std::collections::BTreeMap;

use crate::dialect::CodeTable;

/// The group of motions, in all tables of codes.
const MOTION: u8 = 1;
/// Codes of one block that make its positions mean something else.
const ELSEWHERE: &[&str] = &["G53", "G153", "SUPA", "G28", "G30"];
/// What turns the spindle, and what cools.
const SPINDLE: &[&str] = &["M3", "M4", "M5", "M03", "M04", "M05"];
const COOLANT: &[&str] = &["M7", "M8", "M9", "M07", "M08", "M09"];

/// Millimeters of an inch.
const MM_PER_INCH: f64 = 25.4;

/// What a control has been told.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Told {
    /// The last code of each group.
    codes: BTreeMap<u8, String>,
    /// The last value of each address.
    pub(super) values: BTreeMap<u8, String>,
    motion: Option<String>,
    spindle: Option<String>,
    coolant: Option<String>,
    /// Whether a tool was changed.
    was_changed: bool,
}

impl Told {
    /// Whether all is known of which another one speaks.
    pub(super) fn knows(&self, other: &Told) -> bool {
        other.codes.keys().all(|group| self.codes.contains_key(group))
            && other.values.keys().all(|address| self.values.contains_key(address))
            && (self.spindle.is_some() || other.spindle.is_none())
            && (self.coolant.is_some() || other.coolant.is_none())
    }

    pub(super) fn note(&mut self, text: &str, codes: &CodeTable) {
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
                self.was_changed = true;
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

    /// What brings a control there, by way of a height where one is given; `None` where an axis stands nobody knows where.
    pub(super) fn lines(&self, is_numbered: bool, clearance_mm: Option<f64>) -> Option<Vec<String>> {
        let place = |address: &u8| self.values.get(address).map(String::as_str);
        let [x, y, z] = [place(&b'X')?, place(&b'Y')?, place(&b'Z')?];
        let mut codes: Vec<&str> = self.codes.values().map(String::as_str).collect();
        codes.extend([b'D', b'H'].iter().filter_map(place));
        let others: Vec<&str> = b"ABCUVW".iter().filter_map(place).collect();
        let spindle: Vec<&str> = [place(&b'S'), self.spindle.as_deref()].into_iter().flatten().collect();
        let mut out = vec![codes.join(" "), spindle.join(" ")];
        out.extend(self.coolant.clone());
        // Up first; nothing turns while something moves across.
        out.push(clearance_mm.map_or_else(|| format!("G0 {z}"), |mm| self.lift(mm)));
        if !others.is_empty() {
            out.push(format!("G0 {}", others.join(" ")));
        }
        out.push(format!("G0 {x} {y}"));
        out.extend(clearance_mm.map(|_| format!("G0 {z}")));
        let motion = self.motion.as_deref().filter(|motion| !matches!(*motion, "G0" | "G00"));
        out.push([motion, place(&b'F')].into_iter().flatten().collect::<Vec<_>>().join(" "));
        out.retain(|line| !line.is_empty());
        Some(numbered(out, is_numbered))
    }

    /// What lifts the tool before the beginning; `None` behind a tool or a length of it, with which Z means something else.
    pub(super) fn beginning(&self, is_numbered: bool, clearance_mm: f64) -> Option<Vec<String>> {
        if b"TDH".iter().any(|address| self.values.contains_key(address)) || self.was_changed {
            return None;
        }
        let codes: Vec<&str> = self.codes.values().map(String::as_str).collect();
        let mut out = vec![codes.join(" "), self.lift(clearance_mm)];
        out.retain(|line| !line.is_empty());
        Some(numbered(out, is_numbered))
    }

    /// The rapid move to a height, in the unit that is in force.
    fn lift(&self, mm: f64) -> String {
        let is_inch = self.codes.values().any(|code| matches!(code.as_str(), "G20" | "G70" | "G700"));
        let text = format!("{:.4}", if is_inch { mm / MM_PER_INCH } else { mm });
        format!("G0 Z{}", text.trim_end_matches('0'))
    }
}

fn numbered(lines: Vec<String>, is_numbered: bool) -> Vec<String> {
    if !is_numbered {
        return lines;
    }
    (1..).zip(lines).map(|(number, line)| format!("N{number} {line}")).collect()
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
        let found = told(&lines).lines(false, None).unwrap();
        let [codes, rest @ ..] = found.as_slice() else { panic!("{found:?}") };
        assert!(["G17", "G21", "G54", "G90"].iter().all(|code| codes.split(' ').any(|word| word == *code)), "{codes}");
        assert_eq!(rest, ["S2000 M3", "M8", "G0 Z50.", "G0 X5. Y2.", "F300"]);
    }

    #[test]
    fn behind_a_tool_change_or_machine_coordinates_places_must_be_stated_again() {
        assert_eq!(told(&["G0 X1. Y2. Z3.", "T4 M6", "G0 Z5."]).lines(false, None), None);
        assert_eq!(told(&["G0 X1. Y2. Z3.", "G53 G0 Z0."]).lines(false, None), None);
        assert!(told(&["T4 M6", "G0 X1. Y2. Z3."]).lines(false, None).is_some());
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
    fn a_clearance_comes_first_in_the_unit_that_is_in_force() {
        let lines = ["G21 G90 G17 G54", "S2000 M3", "G0 X1. Y2. Z5.", "G1 Z-1. F300"];
        let found = told(&lines).lines(false, Some(30.0)).unwrap();
        assert_eq!(found[2..], ["G0 Z30.", "G0 X1. Y2.", "G0 Z-1.", "G1 F300"]);
        let found = told(&["G20 G90", "G0 X1. Y2. Z5."]).lines(true, Some(50.8)).unwrap();
        assert_eq!(found[1..], ["N2 G0 Z2.", "N3 G0 X1. Y2.", "N4 G0 Z5."]);
        assert_eq!(told(&["G21 G90"]).beginning(false, 12.5).unwrap(), ["G90 G21", "G0 Z12.5"]);
        for tool in ["T3 M6", "G43 H1", "M6"] {
            assert_eq!(told(&["G21 G90", tool]).beginning(false, 12.5), None, "{tool}");
        }
    }
}
