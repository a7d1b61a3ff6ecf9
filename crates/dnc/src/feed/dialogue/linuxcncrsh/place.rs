//! LinuxCNC: zero offsets and positions.
//!
//! `get abs_cmd_pos` and `get rel_cmd_pos` state the commanded position in machine units: absolute, and less the selected offset and G92 (emcrsh.cc). So
//! their difference is the offset in force. The second one contains the tool length, and ignores the rotation of an offset. `get pos_offset` also converts
//! degrees into the unit of the display, and `get tool_offset` has no valid number in 2.9, so neither is asked.
//!
//! All offsets, their rotation and the tool length are parameters. The comment `(debug,…)` prints them as a message (LinuxCNC manual, *Debug messages*). A
//! message reaches one program only. If another screen has read it, a person must compare the offsets.

use std::fmt::Write as _;

use ncfix_base::units::MM_PER_INCH;

use super::Rsh;
use crate::feed::dialogue::position::PositionComparison;
use crate::feed::dialogue::zero::ZeroValues;
use crate::feed::dialogue::zeros::each_code;

/// Axes in the order of the answers.
const LETTERS: &[u8] = b"XYZABCUVW";
/// Number of linear axes that a tool length may shift.
const SHIFTED: usize = 3;
/// First word of the printed parameters.
const MARK: &str = "ncfix";
/// Kinds of printed parameters: the code in force; a selectable offset has its code, G92 and the length those of their codes.
const ACTIVE: u32 = 0;
const SHIFT: u32 = 920;
const LENGTH: u32 = 490;
/// Digits after the point.
const DIGITS: usize = 6;
/// Codes in tenths that change the tool length.
const LENGTHS: std::ops::RangeInclusive<u32> = 430..=499;

/// Positions that the control has stated, in its unit.
#[derive(Debug, Default)]
pub(super) struct StatedPlace {
    pub(super) absolute: Vec<f64>,
    pub(super) relative: Vec<f64>,
    /// Millimeters in its unit; `None` if it is not a known one.
    pub(super) unit_mm: Option<f64>,
    /// Shift of X, Y and Z by the tool; `None` if it is not known.
    tool_mm: [Option<f64>; SHIFTED],
}

/// Reads the numbers after the name of an answer; `None` if one is not a number.
pub(super) fn numbers(text: &str) -> Option<Vec<f64>> {
    let all = text.split_ascii_whitespace().take(LETTERS.len()).map(|word| word.parse().ok());
    all.collect::<Option<Vec<f64>>>().filter(|all| !all.is_empty())
}

/// Returns the millimeters in a unit of the control.
pub(super) fn unit_mm(name: &str) -> Option<f64> {
    match name {
        "MM" => Some(1.0),
        "INCH" => Some(MM_PER_INCH),
        "CM" => Some(10.0),
        _ => None,
    }
}

/// Returns the lines that print the parameters for these offsets: the code in force, G92, the unit and the position, each offset.
pub(super) fn questions(used: &[u32]) -> Vec<Vec<u8>> {
    let printed = |kind: u32, parameters: &mut dyn Iterator<Item = u32>| {
        let mut text = format!("(debug,{MARK} {kind}");
        parameters.for_each(|number| _ = write!(text, " #{number}"));
        (text + ")").into_bytes()
    };
    let mut out = vec![printed(ACTIVE, &mut [5220].into_iter()), printed(SHIFT, &mut (5210..=5219))];
    out.push(format!("(debug,{MARK} {LENGTH} #<_metric> #5422)").into_bytes());
    for &code in used {
        // G54 begins at 5221, each further one 20 numbers higher; G59.1 follows G59.
        let index = if code > 590 { 5 + code - 590 } else { code.saturating_sub(540) / 10 };
        let first = 5221 + 20 * index;
        out.push(printed(code, &mut (first..first + 10)));
    }
    out
}

impl Rsh {
    /// Notes printed parameters. Returns false if the message is not one of them.
    pub(super) fn printed(&mut self, message: &str) -> bool {
        let Some(rest) = message.strip_prefix(MARK) else { return false };
        let Some(values) =
            rest.split_ascii_whitespace().map(|word| word.parse::<f64>().ok()).collect::<Option<Vec<_>>>()
        else {
            return false;
        };
        let (Some((&kind, values)), Some(unit)) = (values.split_first(), self.place.unit_mm) else { return true };
        let in_mm = |values: &[f64]| {
            let mut out = ZeroValues::default();
            for (slot, (to, from)) in out.iter_mut().zip(values).enumerate() {
                let is_linear = LETTERS.get(slot).is_some_and(|letter| b"XYZUVW".contains(letter));
                *to = if is_linear { from * unit } else { *from };
            }
            out
        };
        match (kind as u32, values) {
            // 1 is G54, 7 is G59.1.
            (ACTIVE, &[number]) if (1.0..=9.0).contains(&number) => {
                let number = number as u32;
                self.zero.has_active(if number > 6 { 584 + number } else { 530 + 10 * number });
            }
            (SHIFT, [is_on, values @ ..]) => {
                self.zero.has_shift(if *is_on == 0.0 { ZeroValues::default() } else { in_mm(values) });
            }
            (LENGTH, &[is_metric, z]) => {
                if let Some(relative) = self.place.relative.get(2) {
                    let program = if is_metric == 0.0 { MM_PER_INCH } else { 1.0 };
                    let length_mm = relative * unit - z * program;
                    // Numerical noise of two rounded numbers is no length.
                    let length_mm = if length_mm.abs() < 1e-4 { 0.0 } else { length_mm };
                    self.zero.has_length(length_mm);
                    self.place.tool_mm = [Some(0.0), Some(0.0), Some(length_mm)];
                }
            }
            (code @ 540..=593, values) => self.zero.has_system(code, in_mm(values)),
            _ => {}
        }
        true
    }

    /// Notes a line that is sent.
    pub(super) fn follow(&mut self, text: &[u8]) {
        self.zero.sent(text);
        self.commanded.sent(text);
        let mut changes = false;
        each_code(text, &mut |letter, code| changes |= letter == b'G' && LENGTHS.contains(&code));
        if changes {
            self.place.tool_mm = [None; SHIFTED];
        }
    }

    /// Compares the offset in force. Returns why the job must end.
    pub(super) fn compare_zero(&mut self) -> Option<String> {
        let unit = self.place.unit_mm?;
        let stated: Vec<(u8, f64)> = (LETTERS.iter().zip(self.place.absolute.iter().zip(&self.place.relative)))
            .map(|(&letter, (absolute, relative))| {
                let factor = if b"ABC".contains(&letter) { 1.0 } else { unit };
                (letter, (absolute - relative) * factor)
            })
            .collect();
        self.zero.see_in_force(&stated)
    }

    /// Compares the position at which the control has executed the line with that of the lines sent.
    pub(super) fn compare_place(&mut self) -> PositionComparison {
        let Some(unit) = self.place.unit_mm else { return PositionComparison::Nothing };
        let mut reported = Vec::new();
        for (slot, (&letter, &value)) in LETTERS.iter().zip(&self.place.relative).enumerate() {
            let mut value = if b"ABC".contains(&letter) { value } else { value * unit };
            if slot < SHIFTED {
                if slot < 2 && self.zero.is_turned() {
                    continue;
                }
                // After a new length, the first position shows it.
                let Some(tool_mm) = self.place.tool_mm[slot] else {
                    self.place.tool_mm[slot] = self.commanded.of(letter).map(|commanded| value - commanded);
                    continue;
                };
                value -= tool_mm;
            }
            reported.push((letter, value, DIGITS));
        }
        self.commanded.compare(&reported)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_offset_has_its_parameters() {
        let text = |code: u32| String::from_utf8(questions(&[code]).pop().unwrap()).unwrap();
        assert_eq!(text(540), "(debug,ncfix 540 #5221 #5222 #5223 #5224 #5225 #5226 #5227 #5228 #5229 #5230)");
        // LinuxCNC manual, parameters: 5321 is G59, 5381 is G59.3.
        assert!(text(590).starts_with("(debug,ncfix 590 #5321 ") && text(593).ends_with("#5390)"));
        assert_eq!(questions(&[540, 550]).len(), 5);
    }

    #[test]
    fn answers_are_numbers() {
        assert_eq!(numbers(" 1.5 -2.000000"), Some(vec![1.5, -2.0]));
        assert_eq!((numbers(""), numbers("1 x")), (None, None));
        assert_eq!([unit_mm("MM"), unit_mm("INCH"), unit_mm("CUSTOM")], [Some(1.0), Some(25.4), None]);
    }
}
