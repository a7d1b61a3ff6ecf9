//! Axis positions that the lines sent command, to be compared with those that a control reports when it stands still.
//!
//! An answer proves that a line was accepted. A control that accepts a line and does not move reports another position than the line commands. Only what the
//! text states for certain is compared: an axis is known after an absolute position or G92, in the coordinates of the program. It is unknown after everything
//! that moves or shifts it by an amount that the text does not state (G28, G53, another zero offset, a tool length, a tool change). Relative moves add to a
//! known position. After a statement whose effect on positions is not known here, nothing is compared any more.
//!
//! A later line that commands the same axes again hides an earlier line that was not executed. The comparison sees it only if they are compared in between:
//! after every line (LinuxCNC), or at the stops of [`super::barrier`].

mod compare;

use ncfix_base::units::MM_PER_INCH;

pub(super) use compare::{PositionComparison, elsewhere, number};

/// Axis letters in the order in which controls report them.
pub(super) const LETTERS: &[u8; 9] = b"XYZABCUVW";
const COUNT: usize = LETTERS.len();

/// Codes in tenths that change no position and no meaning of one.
const HARMLESS: &[u32] =
    &[40, 170, 180, 190, 400, 500, 610, 611, 640, 690, 901, 911, 930, 940, 950, 960, 970, 980, 990];
/// Codes that shift or move axes by an amount that the text does not state: all positions are unknown until they are commanded again.
const SHIFTING: &[u32] = &[100, 280, 281, 300, 301, 382, 383, 384, 385, 430, 431, 432, 490, 921, 922, 923];
/// Zero offsets.
const OFFSETS: std::ops::RangeInclusive<u32> = 540..=593;
/// Motion codes whose words are the end point.
const TO_END: &[u32] = &[0, 10, 20, 30];
/// Other motion codes: cycles, splines, threads. They stay in force.
const NOT_TO_END: &[u32] = &[50, 51, 52, 330, 331, 730, 760, 810, 820, 830, 840, 850, 860, 870, 880, 890];
/// M codes that move no axis. All others may.
const STILL: &[u32] = &[0, 1, 2, 3, 4, 5, 7, 8, 9, 30, 48, 49, 50, 51, 52, 53, 56, 60, 106, 107, 117, 118];

/// Ends of a program, as M codes in tenths.
const ENDS: &[u32] = &[20, 300];
/// Statements at which a person or a tool changer acts, so that a question to the control delays nothing. A dwell or M1 can be in the cut, where a longer
/// stop leaves a mark.
const STOPS: &[u32] = &[0, 60, 600];

/// Axis positions that the lines sent command.
#[derive(Clone, Debug)]
pub(super) struct CommandedPosition {
    /// Positions in the coordinates of the program, mm or degrees, by the order of [`LETTERS`].
    axes: [Option<f64>; COUNT],
    is_relative: bool,
    /// Millimeters in one unit of the program; `None` if the text has not stated it.
    unit_mm: Option<f64>,
    /// True if the words of the motion code in force are an end point.
    is_to_end: bool,
    /// Zero offset that the text has stated, as its code.
    offset: Option<u32>,
    /// True if the text has set G92 or a tool length, which the end of a program may change.
    is_shifted: bool,
    /// True after M2 or M30, which select G54.
    has_ended: bool,
    /// True after a statement whose effect is not known.
    is_beyond: bool,
}

impl Default for CommandedPosition {
    fn default() -> CommandedPosition {
        CommandedPosition {
            axes: [None; COUNT],
            is_relative: false,
            unit_mm: None,
            is_to_end: true,
            offset: None,
            is_shifted: false,
            has_ended: false,
            is_beyond: false,
        }
    }
}

fn slot(letter: u8) -> Option<usize> {
    LETTERS.iter().position(|known| *known == letter)
}

fn is_rotary(slot: usize) -> bool {
    (3..6).contains(&slot)
}

/// Splits a line into letters and values; `None` if a value is not a plain number.
fn read(text: &[u8]) -> Option<Vec<(u8, f64)>> {
    let mut out = Vec::new();
    let mut rest = text.trim_ascii();
    while let Some((&letter, behind)) = rest.split_first() {
        let end = behind.iter().position(|byte| !(byte.is_ascii_digit() || b"+-. \t".contains(byte)));
        let (value, next) = behind.split_at(end.unwrap_or(behind.len()));
        let value: String =
            value.iter().filter(|byte| !byte.is_ascii_whitespace()).map(|&byte| char::from(byte)).collect();
        if !letter.is_ascii_alphabetic() {
            return None;
        }
        out.push((letter.to_ascii_uppercase(), value.parse().ok()?));
        rest = next;
    }
    Some(out)
}

impl CommandedPosition {
    /// Follows a line that is sent. Returns true if the axes stand still after it in any case: a dwell, a program stop, a tool change.
    pub(super) fn sent(&mut self, text: &[u8]) -> bool {
        let text = text.trim_ascii();
        if text.is_empty() || text == b"%" {
            return false;
        }
        let Some(words) = read(text) else { return self.give_up() };
        let (mut g, mut m) = (Vec::new(), Vec::new());
        for &(letter, value) in &words {
            let tenths = (value * 10.0).round();
            match letter {
                b'O' => return self.give_up(),
                b'G' | b'M' if !(0.0..1e5).contains(&tenths) => return self.give_up(),
                b'G' => g.push(tenths as u32),
                b'M' => m.push(tenths as u32),
                _ => {}
            }
        }
        if m.iter().any(|code| code % 10 != 0 || !STILL.contains(&(code / 10))) {
            self.forget();
        }
        // The words of G4 are no positions.
        let (mut moves, mut sets) = (!g.contains(&40), false);
        for &code in &g {
            match code {
                900 => self.is_relative = false,
                910 => self.is_relative = true,
                200 => self.unit_mm = Some(MM_PER_INCH),
                210 => self.unit_mm = Some(1.0),
                920 => (sets, self.is_shifted) = (true, true),
                800 => self.is_to_end = true,
                _ if TO_END.contains(&code) => self.is_to_end = true,
                _ if NOT_TO_END.contains(&code) => self.is_to_end = false,
                _ if OFFSETS.contains(&code) => {
                    if self.offset != Some(code) {
                        self.forget();
                    }
                    self.offset = Some(code);
                }
                530 => {
                    // Machine coordinates.
                    words.iter().filter_map(|&(letter, _)| slot(letter)).for_each(|slot| self.axes[slot] = None);
                    moves = false;
                }
                _ if SHIFTING.contains(&code) => {
                    self.is_shifted |= (430..490).contains(&code);
                    self.forget();
                    // Their words are offsets, or positions on the way.
                    moves = false;
                }
                _ if HARMLESS.contains(&code) => {}
                _ => return self.give_up(),
            }
        }
        if sets || moves {
            self.axes(&words, sets);
        }
        self.has_ended = m.iter().any(|code| ENDS.contains(code));
        self.is_relative &= !self.has_ended;
        m.iter().any(|code| STOPS.contains(code))
    }

    /// True if any position is known.
    pub(super) fn is_known(&self) -> bool {
        !self.is_beyond && self.axes.iter().any(Option::is_some)
    }

    /// Returns the position of an axis, mm or degrees; `None` if it is not known, or its unit is not stated.
    pub(super) fn of(&self, letter: u8) -> Option<f64> {
        let slot = slot(letter).filter(|slot| !self.is_beyond && (is_rotary(*slot) || self.unit_mm.is_some()))?;
        self.axes[slot]
    }

    /// Applies the axis words of a line. `sets` if they are those of G92.
    fn axes(&mut self, words: &[(u8, f64)], sets: bool) {
        for &(letter, value) in words {
            let Some(slot) = slot(letter) else { continue };
            if !self.is_to_end && !sets {
                // A cycle: it ends where its words and its mode say.
                return self.forget();
            }
            let inches = self.unit_mm.is_some_and(|unit| unit > 1.0);
            let value = if is_rotary(slot) { value } else { value * self.unit_mm.unwrap_or(1.0) };
            let place = &mut self.axes[slot];
            *place = match *place {
                // Some controls also convert degrees.
                _ if is_rotary(slot) && inches => None,
                Some(before) if self.is_relative && !sets => Some(before + value),
                None if self.is_relative && !sets => None,
                _ => Some(value),
            };
        }
    }

    fn forget(&mut self) {
        self.axes = [None; COUNT];
    }

    fn give_up(&mut self) -> bool {
        self.forget();
        self.is_beyond = true;
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compare(lines: &[&str], reported: &str) -> PositionComparison {
        let mut position = CommandedPosition::default();
        lines.iter().for_each(|line| _ = position.sent(line.as_bytes()));
        let values = reported.split_ascii_whitespace().map(|word| {
            let (value, digits) = number(&word[1..]).unwrap();
            (word.as_bytes()[0], value, digits)
        });
        position.compare(&values.collect::<Vec<_>>())
    }

    fn agrees(axes: &str) -> PositionComparison {
        PositionComparison::Agrees(axes.to_owned())
    }

    #[test]
    fn a_line_that_did_not_move_differs() {
        let lines = ["G21 G90", "G0 X10 Y20", "G1 Z-3 F100", "X15"];
        assert_eq!(compare(&lines, "X15.000 Y20.000 Z-3.000"), agrees("XYZ"));
        assert!(matches!(compare(&lines, "X10.000 Y20.000 Z-3.000"), PositionComparison::Differs(_)));
        assert!(matches!(compare(&lines, "X15.000 Y20.000 Z0.000"), PositionComparison::Differs(_)));
        // Half a step of a coarse drive is no difference; a tenth of a millimeter is.
        assert_eq!(compare(&lines, "X15.031 Y20.000 Z-3.000"), agrees("XYZ"));
        assert!(matches!(compare(&lines, "X15.100 Y20.000 Z-3.000"), PositionComparison::Differs(_)));
    }

    #[test]
    fn relative_moves_inches_and_turns_count() {
        assert_eq!(compare(&["G21 G90", "G0 X10", "G91", "X5", "X-2.5"], "X12.500"), agrees("X"));
        assert_eq!(compare(&["G20 G90", "G0 X1 Y2"], "X25.400 Y50.800"), agrees("XY"));
        // The control reports inches ($13 = 1), the program is in millimeters.
        assert_eq!(compare(&["G21 G90", "G0 X25.4 Y50.8"], "X1.0000 Y2.0000"), agrees("XY"));
        assert!(matches!(compare(&["G21", "G0 X25.4 Y50.8"], "X1.0000 Y1.9000"), PositionComparison::Differs(_)));
        assert_eq!(compare(&["G21 G90", "G0 A725"], "A5.000"), agrees("A"));
        assert!(matches!(compare(&["G21 G90", "G0 A725"], "A6.000"), PositionComparison::Differs(_)));
        assert_eq!(compare(&["G21", "G0 X1", "G92 X0", "G1 X3"], "X3.000"), agrees("X"));
    }

    #[test]
    fn the_position_is_asked_for_after_stops_that_wait_in_any_case() {
        let mut position = CommandedPosition::default();
        for (line, stands) in [
            ("G4 P0.5", false),
            ("M0", true),
            ("M1", false),
            ("T2 M6", true),
            ("M60", true),
            ("M3 S1000", false),
            ("G0 X4", false),
            ("M30", false),
            ("G40", false),
        ] {
            assert_eq!(position.sent(line.as_bytes()), stands, "{line}");
        }
    }

    #[test]
    fn what_the_text_does_not_state_is_not_compared() {
        for lines in [
            &["G21 G90", "G0 X1", "G28 X0"][..],
            &["G21", "G0 X1", "G55"],
            &["G21", "G0 X1", "G53 G0 X0"],
            &["G21", "G0 X1", "M6 T2"],
            &["G21", "G0 X1", "G43.1 Z5"],
            &["G21", "G0 X1", "G38.2 Z-5"],
            &["G21", "G0 X1", "G81 X2 Z-5 R1", "X7"],
            &["G21", "G0 X#5"],
            &["G21", "O100 CALL", "G0 X1"],
            &["G91 G21", "G0 X1"],
            &["G21 G68 X0 Y0 R30", "G0 X1"],
            // The end selects G54; the program stood in G55.
            &["G21 G55", "G0 X1", "M30"],
        ] {
            assert_eq!(compare(lines, "X99.000"), PositionComparison::Nothing, "{lines:?}");
        }
        // Commanded again, or not concerned.
        assert_eq!(compare(&["G21", "G0 X1 Z9", "G53 G0 Z0"], "X1.000 Z-77.000"), agrees("X"));
        assert_eq!(compare(&["G21", "G0 X1 Y9", "G55", "G0 X2"], "X2.000 Y77.000"), agrees("X"));
        assert_eq!(compare(&["G21 G54", "G0 X1", "G4 P0.5", "M5", "M30"], "X1.000"), agrees("X"));
        assert!(matches!(compare(&["G21 G54", "G0 X1", "M30"], "X2.000"), PositionComparison::Differs(_)));
    }
}
