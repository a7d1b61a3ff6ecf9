//! A guard at the start of a corrected program: the control compares its zero offsets and tools with those of the correction, and stops if they differ.
//!
//! The lines are words of the control's language, read before the first motion. Each writer that has such words names its function in its
//! [`WriterEntry`](super::WriterEntry).

use std::fmt::Write as _;

use ncfix_base::geometry::{Axis, AxisVector};

/// Largest accepted difference of a length, mm, and of an angle, degrees. Controls show three decimals, so a value may be half of the last one off.
const SAME: f64 = 6e-4;

/// The data of the control for which a program is corrected.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardedData {
    /// The length unit of the output, mm.
    pub unit_mm: f64,
    /// True if the control is a Haas, whose tool lengths have other variables than those of a Fanuc.
    pub is_haas: bool,
    /// Zero offsets in which axes move.
    pub zeros: Vec<GuardedZero>,
    /// Tools that cut.
    pub tools: Vec<GuardedTool>,
}

/// Values of a zero offset.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardedZero {
    /// Its name, such as `G54`, `G505` or `G54.1 P3`.
    pub name: String,
    /// Axes of the machine, in the order of their letters: X to Z, A to C, U to W.
    pub axes: Vec<Axis>,
    /// Coarse and fine shift together, mm and rad.
    pub shift: AxisVector,
    /// Angles about X, Y and Z, rad.
    pub rotation: [f64; 3],
}

/// Length of a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardedTool {
    /// Number of the tool (Sinumerik) or of its offset (Fanuc).
    pub number: u32,
    /// Number of the edge (D).
    pub edge: u32,
    /// First length with wear, mm.
    pub length_mm: f64,
}

/// The guard of one language.
pub type GuardWords = fn(&GuardedData) -> GuardLines;

/// Lines of a guard, and the data that they cannot check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GuardLines {
    /// Lines in the language of the control.
    pub lines: Vec<String>,
    /// Names of what the lines check.
    pub checked: Vec<String>,
    /// Names of zero offsets and tools that the control cannot compare at this place.
    pub left: Vec<String>,
}

impl GuardLines {
    fn check(&mut self, name: &str, lines: impl IntoIterator<Item = String>) {
        self.lines.extend(lines);
        self.checked.push(name.to_owned());
    }
}

/// A difference in the words of an expression: the variable without its value.
fn value_of(zero: &GuardedZero, axis: Axis) -> f64 {
    if axis.is_rotary() { zero.shift[axis].to_degrees() } else { zero.shift[axis] }
}

/// A number with six decimals: a millionth of a millimeter or degree.
fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0');
    if text == "-0." { "0.".to_owned() } else { text.to_owned() }
}

fn whole(name: &str, prefix: &str) -> Option<u32> {
    name.strip_prefix(prefix)?.parse().ok()
}

/// End of the message of a Sinumerik.
const DIFFERS: &str = "value at the control differs from that of the correction";
/// End of the message of a Fanuc.
const CHANGED: &str = "CHANGED SINCE CORRECTION";
/// Beginning of the O words of LinuxCNC, which must not occur in the program: a name cannot.
const LABEL: &str = "o<ncfix_guard";

/// True if a line is one of a guard, also if capitals, blanks or comments have changed.
pub(super) fn is_of_guard(line: &[u8]) -> bool {
    let holds = |text: &str| line.windows(text.len()).any(|window| window.eq_ignore_ascii_case(text.as_bytes()));
    if holds(DIFFERS) || holds(CHANGED) || holds(LABEL) {
        return true;
    }
    // Without its comment, the condition of a Fanuc remains, with the accepted difference in mm or inches.
    if !holds("#3000") {
        return false;
    }
    let plain: Vec<u8> = line.iter().filter(|byte| !byte.is_ascii_whitespace()).map(u8::to_ascii_uppercase).collect();
    let holds = |text: &[u8]| plain.windows(text.len()).any(|window| window == text);
    holds(b"IF[ABS[#") && (holds(b"]]GT0.0006]THEN#3000=1") || holds(b"]]GT0.0000236]THEN#3000=1"))
}

/// The guard of a Sinumerik: `$P_UIFR`, `$TC_DP3` with its wear `$TC_DP12` and its base length `$TC_DP21`; alarm 65000 of the user, then the end of the program (Siemens, System variables
/// list manual; Programming manual, SETAL).
pub(super) fn sinumerik(data: &GuardedData) -> GuardLines {
    let mut guard = GuardLines::default();
    let stop = |name: &str, differs: String| {
        [format!("IF {differs}"), format!("SETAL(65000,\"{name}: {DIFFERS}\")"), "M30".to_owned(), "ENDIF".to_owned()]
    };
    for zero in &data.zeros {
        let index = match whole(&zero.name, "G") {
            Some(number @ 54..=57) => number - 53,
            Some(number @ 505..=599) => number - 500,
            _ => {
                guard.left.push(zero.name.clone());
                continue;
            }
        };
        let mut differs = String::new();
        let mut differ = |read: String, value: f64| {
            let or = if differs.is_empty() { "" } else { " OR " };
            // Writing to a string cannot fail.
            let _ = write!(differs, "{or}(ABS({read}-({}))>{SAME})", number(value).trim_end_matches('.'));
        };
        for &axis in &zero.axes {
            let read = |part: &str| format!("$P_UIFR[{index},{axis},{part}]");
            differ(format!("{}+{}", read("TR"), read("FI")), value_of(zero, axis));
        }
        for (axis, angle) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(zero.rotation) {
            differ(format!("$P_UIFR[{index},{axis},RT]"), angle.to_degrees());
        }
        guard.check(&zero.name, stop(&zero.name, differs));
    }
    for GuardedTool { number: tool, edge, length_mm } in &data.tools {
        let read = |part: u32| format!("$TC_DP{part}[{tool},{edge}]");
        let value = number(*length_mm);
        let differs = format!("ABS({}+{}+{}-({}))>{SAME}", read(3), read(12), read(21), value.trim_end_matches('.'));
        let name = format!("T{tool} D{edge}");
        guard.check(&name, stop(&name, differs));
    }
    guard
}

/// The guard of a Fanuc: macro variables of the zero offsets and of the lengths in tool memory C, which are in inches under G20; alarm by `#3000` (Fanuc,
/// Operator's manual, custom macro). A Haas has 200 lengths from `#2001` on, their wear from `#2201` on, and `G154 P1` from `#14001` on (Haas, Mill operator's
/// manual, system variables).
pub(super) fn fanuc(data: &GuardedData) -> GuardLines {
    let mut guard = GuardLines::default();
    let stop = |read: &str, (value, unit): (f64, f64), name: &str| {
        let same = (SAME / unit * 1e7).round() / 1e7;
        format!("IF[ABS[{read}-[{}]]GT{same}]THEN #3000=1({name} {CHANGED})", number(value / unit))
    };
    let unit_of = |axis: Axis| if axis.is_rotary() { 1.0 } else { data.unit_mm };
    for zero in &data.zeros {
        let shown = if data.is_haas { zero.name.replace("G54.1 P", "G154 P") } else { zero.name.clone() };
        let first = match (whole(&zero.name, "G54.1 P"), whole(&zero.name, "G")) {
            (Some(number @ 1..=99), _) if data.is_haas => 14_001 + 20 * (number - 1),
            (Some(number @ 1..=48), _) if !data.is_haas => 7001 + 20 * (number - 1),
            (_, Some(number @ 54..=59)) => 5221 + 20 * (number - 54),
            _ => {
                guard.left.push(shown);
                continue;
            }
        };
        let lines: Vec<String> = (first..)
            .zip(&zero.axes)
            .map(|(variable, &axis)| {
                stop(&format!("#{variable}"), (value_of(zero, axis), unit_of(axis)), &format!("{shown} {axis}"))
            })
            .collect();
        guard.check(&shown, lines);
    }
    let (length, wear, count) = if data.is_haas { (2000, 2200, 200) } else { (11_000, 10_000, 999) };
    for &GuardedTool { number: tool, length_mm, .. } in &data.tools {
        let name = format!("H{tool}");
        if (1..=count).contains(&tool) {
            let read = format!("#{}+#{}", length + tool, wear + tool);
            guard.check(&name, [stop(&read, (length_mm, data.unit_mm), &name)]);
        } else {
            guard.left.push(name);
        }
    }
    guard
}

/// The guard of LinuxCNC: the numbered parameters of the zero offsets. The lengths of its tool table are not parameters before the tool is loaded.
pub(super) fn rs274(data: &GuardedData) -> GuardLines {
    let mut guard = GuardLines::default();
    for zero in &data.zeros {
        let system = match zero.name.strip_prefix("G59.").map(str::parse::<u32>) {
            Some(Ok(number @ 1..=3)) => 6 + number,
            _ => match whole(&zero.name, "G") {
                Some(number @ 54..=59) => number - 53,
                _ => {
                    guard.left.push(zero.name.clone());
                    continue;
                }
            },
        };
        let first = 5221 + 20 * (system - 1);
        let mut differs = Vec::new();
        for &axis in &zero.axes {
            let place = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C, Axis::U, Axis::V, Axis::W]
                .iter()
                .position(|one| *one == axis)
                .unwrap_or(0);
            differs.push((first + place as u32, value_of(zero, axis), axis.to_string()));
        }
        differs.push((first + 9, zero.rotation[2].to_degrees(), "R".to_owned()));
        for (variable, value, part) in differs {
            let label =
                format!("{LABEL}_{}_{}>", zero.name.replace('.', "_").to_ascii_lowercase(), part.to_ascii_lowercase());
            let lines = [
                format!("{label} if [ABS[#{variable} - [{}]] GT {SAME}]", number(value)),
                format!("(MSG, {} {part} is not as corrected: correct the program again)", zero.name),
                "M2".to_owned(),
                format!("{label} endif"),
            ];
            guard.lines.extend(lines);
        }
        guard.checked.push(zero.name.clone());
    }
    guard.left.extend(data.tools.iter().map(|tool| format!("T{}", tool.number)));
    guard
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_point_and_no_exponent() {
        for (value, text) in
            [(40.0, "40."), (-0.0, "0."), (1e-7, "0."), (-12.345_678_4, "-12.345678"), (1e6, "1000000.")]
        {
            assert_eq!(number(value), text);
        }
    }
}
