//! Offsets that a Fanuc punches out as a program: `G10 L2 P1 X-250. Y-120.5`, `G10 L10 P1 R120.5`, and macro variables: `#500=12.5`.
//!
//! L2 is a work offset (P0 the external one, P1 to P6 are G54 to G59), L20 an additional one (G54.1). L10 and L11 are geometry and wear of a length, L12 and
//! L13 those of a radius, R the value (Fanuc operator's manual, *Programmable data input*). Blocks from G10 L50 or L52 to G11 are parameters.

use std::collections::BTreeMap;

use super::lines::{number, words};
use super::{SavedFormat, SavedLine, SavedUnit, SavedValues};
use crate::machine::zero_offset::{EXTERNAL, lacking_axes};
use crate::machine::{DecimalPoint, Machine, Tool};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisSet, FrameParts};

/// Offsets of a Fanuc.
pub(super) const FORMAT: SavedFormat = SavedFormat { name: "Fanuc offsets (G10)", language: "fanuc", is, read };

/// Words of a line without comments and the characters around programs.
fn block(line: &SavedLine<'_>) -> String {
    let (mut out, mut depth) = (String::new(), 0_u32);
    for letter in line.text.chars() {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            '%' | ';' => {}
            _ if depth == 0 => out.push(letter),
            _ => {}
        }
    }
    out
}

/// Number and value of a line `#500=12.5`; the value is `None` if the variable is vacant.
fn variable(text: &str) -> Option<(u32, Option<f64>)> {
    let (key, value) = text.trim().strip_prefix('#')?.split_once('=')?;
    Some((key.trim().parse().ok()?, number(value)))
}

fn is(lines: &[SavedLine<'_>]) -> bool {
    let mut data = 0;
    for line in lines {
        let text = block(line);
        if variable(&text).is_some() {
            data += 1;
            continue;
        }
        let Some(words) = words(&text) else { return false };
        let codes: Vec<f64> = words.iter().filter(|word| word.0 == b'G').filter_map(|word| number(word.1)).collect();
        // A program that also moves is not a punch-out.
        if codes.iter().any(|code| !matches!(*code as i64, 10 | 11 | 20 | 21 | 90 | 91)) {
            return false;
        }
        data += usize::from(codes.contains(&10.0));
    }
    data > 0
}

/// An offset with the axes that the file or the machine file states.
struct Offset<'l> {
    parts: FrameParts,
    /// Axes that the file states.
    stated: AxisSet,
    /// True if an earlier file has the offset.
    is_known: bool,
    /// The first line with it.
    line: &'l SavedLine<'l>,
}

/// Lengths and radii of a register, mm.
#[derive(Default)]
struct Register {
    length_mm: [f64; 2],
    radius_mm: [f64; 2],
}

/// A control punches out `%` before the first block and after the last one.
///
/// # Errors
/// If only the first one is there: the lines in between may lack offsets.
fn check_end(lines: &[SavedLine<'_>]) -> Result<(), Diagnostic> {
    match lines {
        [first, .., last] if first.text.trim_start().starts_with('%') && !last.text.contains('%') => Err(last.fault(
            "the file begins with % and does not end with it, so its end is missing",
            "save the offsets again; if the file is complete, write % in a last line",
        )),
        _ => Ok(()),
    }
}

fn read(lines: &[SavedLine<'_>], machine: &Machine) -> Result<SavedValues, Diagnostic> {
    let mut out = SavedValues::default();
    let mut offsets: BTreeMap<String, Offset<'_>> = BTreeMap::new();
    let mut registers: BTreeMap<u32, Register> = BTreeMap::new();
    let (mut unit, mut is_parameters) = (None, false);
    check_end(lines)?;
    for line in lines {
        let text = block(line);
        if let Some((key, value)) = variable(&text) {
            out.system.extend(value.map(|value| (format!("#{key}"), value)));
            continue;
        }
        let words = words(&text).unwrap_or_default();
        let get = |letter: u8| words.iter().find(|word| word.0 == letter).map(|word| word.1);
        let codes: Vec<i64> = words
            .iter()
            .filter(|word| word.0 == b'G')
            .filter_map(|word| number(word.1))
            .map(|code| code as i64)
            .collect();
        if codes.contains(&20) {
            unit = Some(SavedUnit::Inch);
        } else if codes.contains(&21) {
            unit = Some(SavedUnit::Millimeter);
        }
        if codes.contains(&91) {
            return Err(line.fault("G91 adds to values that ncfix does not know", "save the offsets with G90"));
        }
        if codes.contains(&11) {
            is_parameters = false;
        }
        if !codes.contains(&10) || is_parameters {
            continue;
        }
        let whole = |letter: u8| {
            get(letter).and_then(number).filter(|value| value.fract() == 0.0 && *value >= 0.0).map(|value| value as u32)
        };
        let (kind, place) = (whole(b'L'), whole(b'P'));
        if matches!(kind, Some(50 | 52)) {
            is_parameters = true;
            continue;
        }
        let unit = match unit {
            Some(unit) => unit,
            None => SavedUnit::required(machine, line)?,
        };
        let value = |text: &str, is_length: bool| {
            let value = number(text)
                .ok_or_else(|| line.fault(format!("'{text}' is not a number"), "save the offsets again"))?;
            let is_whole = text.contains('.')
                || value == 0.0
                || machine.control.iso.decimal_point == Some(DecimalPoint::Calculator);
            if !is_whole {
                let message = format!("{text} has no decimal point, and may count increments");
                let help = "save the values with a decimal point, or state decimal_point = \"calculator\" in [control]";
                return Err(line.fault(message, help));
            }
            Ok(if is_length { unit.mm(value) } else { value.to_radians() })
        };
        match (kind, place) {
            (Some(2), Some(place @ 0..=6)) | (Some(20), Some(place @ 1..=300)) => {
                let name = match (kind, place) {
                    (Some(20), place) => format!("G54.1 P{place}"),
                    (_, 0) => "EXT".to_owned(),
                    (_, place) => format!("G{}", 53 + place),
                };
                // G10 leaves the other axes as they are.
                let known = machine.zero_offsets.get(&name);
                let begun = machine.partial_offsets.get(&name);
                let offset = offsets.entry(name).or_insert_with(|| Offset {
                    parts: known.or(begun).copied().unwrap_or_default(),
                    stated: AxisSet::EMPTY,
                    is_known: known.is_some(),
                    line,
                });
                for (letter, text) in &words {
                    if let Some(axis) = Axis::from_letter(*letter) {
                        let own = value(text, !axis.is_rotary())?;
                        if offset.stated.contains(axis) && offset.parts.translation[axis] != own {
                            let help = "remove the line that is not in force, or save the offsets again";
                            return Err(line.fault(format!("a second, different value of {axis} for one offset"), help));
                        }
                        offset.parts.translation[axis] = own;
                        offset.stated.insert(axis);
                    }
                }
            }
            (Some(kind @ (1 | 10..=13)), Some(place @ 1..)) => {
                let Some(text) = get(b'R') else {
                    return Err(line.fault("G10 has no R with the value", "save the offsets of a mill, with R"));
                };
                let register = registers.entry(place).or_default();
                let part = match kind {
                    10 => &mut register.length_mm[0],
                    12 => &mut register.radius_mm[0],
                    13 => &mut register.radius_mm[1],
                    _ => &mut register.length_mm[1],
                };
                *part = value(text, true)?;
            }
            _ => {
                let message = "this G10 is neither a zero offset nor a tool offset of a mill";
                return Err(line.fault(message, "ncfix reads L2, L20 and L10 to L13 with P; remove the other lines"));
            }
        }
    }
    for (name, Offset { parts, stated, is_known, line }) in offsets {
        // Without a linear axis, the offset is still not known: a program that uses it is refused.
        if name != EXTERNAL && !is_known && stated.intersection(AxisSet::XYZ).is_empty() {
            out.partial_offsets.push((name, parts));
            continue;
        }
        if let Some((lacking, message)) =
            lacking_axes(&name, machine.axis_set(), is_known, |axis| stated.contains(axis))
        {
            let letters: Vec<String> = lacking.iter().map(ToString::to_string).collect();
            let help = format!("add {} with the value on the control, even if it is 0", letters.join(" and "));
            out.warnings.push(line.report(Code::PARTIAL_OFFSET, message, help));
        }
        out.offsets.push((name, parts));
    }
    for (place, Register { length_mm: [length, wear], radius_mm: [radius, radius_wear] }) in registers {
        let (length_mm, radius_mm) = ([length + wear, 0.0, 0.0], (radius + radius_wear).max(0.0));
        out.tools.push(Tool { number: place, name: None, edge: 1, length_mm, radius_mm });
        out.wear_mm.push((place, radius_wear));
    }
    Ok(out)
}
