//! Answer of Grbl and grblHAL to `$#`: `[G54:-250.000,-120.500,0.000]`. Lengths are in mm, or in inches if `$13=1` (Grbl 1.1 wiki, *Commands*).

use super::lines::number;
use super::linuxcnc_variables::REFERENCE_POINTS;
use super::{SavedFormat, SavedLine, SavedUnit, SavedValues};
use crate::machine::zero_offset::lacking_axes;
use crate::machine::{Machine, Tool};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, FrameParts};

/// Offsets of Grbl.
pub(super) const FORMAT: SavedFormat = SavedFormat { name: "Grbl offsets ($#)", language: "rs274", is, read };

/// Axes in the order of the report.
const AXES: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];
/// Names of systems.
const SYSTEMS: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/// Name and text of `[G54:…]`.
fn entry<'a>(line: &'a SavedLine<'_>) -> Option<(&'a str, &'a str)> {
    let text = line.text.trim();
    text.strip_prefix('[')?.strip_suffix(']')?.split_once(':')
}

fn is(lines: &[SavedLine<'_>]) -> bool {
    lines.iter().filter_map(entry).any(|(key, _)| SYSTEMS[..6].contains(&key))
}

/// Numbers of a list.
fn list(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(number).collect()
}

fn read(lines: &[SavedLine<'_>], machine: &Machine) -> Result<SavedValues, Diagnostic> {
    let reports = |text: &str| lines.iter().any(|line| line.text.trim().replace(' ', "").starts_with(text));
    let unit = match SavedUnit::stated(machine) {
        _ if reports("$13=1") => SavedUnit::Inch,
        _ if reports("$13=0") => SavedUnit::Millimeter,
        stated => stated.unwrap_or(SavedUnit::Millimeter),
    };
    let mut out = SavedValues::default();
    for line in lines {
        let Some((key, text)) = entry(line) else { continue };
        let unreadable =
            || line.fault(format!("[{key}: …] is not a list of numbers"), "save the answer to $# unchanged");
        let is_system = SYSTEMS.contains(&key);
        if is_system || key == "G92" || key == "TLO" {
            let (text, rotation) = text.split_once(':').map_or((text, None), |(text, angle)| (text, Some(angle)));
            let values = list(text).filter(|values| !values.is_empty()).ok_or_else(unreadable)?;
            if is_system {
                let mut parts = FrameParts::default();
                let count = values.len();
                if let Some((_, message)) = lacking_axes(key, machine.axis_set(), false, |axis| axis.slot() < count) {
                    let help = "the line seems to be cut off: save the answer to $# again";
                    out.warnings.push(line.report(Code::PARTIAL_OFFSET, message, help));
                }
                for (axis, value) in AXES.into_iter().zip(values) {
                    parts.translation[axis] = if axis.is_rotary() { value.to_radians() } else { unit.mm(value) };
                }
                if let Some(angle) = rotation {
                    parts.rotation[2] = number(angle).ok_or_else(unreadable)?.to_radians();
                }
                out.offsets.push((key.to_owned(), parts));
            } else if values.iter().any(|value| *value != 0.0) {
                let help = "cancel it with G92.1 or G49, or set the zero offset instead, and ask for $# again";
                return Err(line.fault(format!("an offset {key} is active, which ncfix does not take over"), help));
            }
        } else if let Some(place) = ["G28", "G30"].iter().position(|own| *own == key) {
            let values = list(text).ok_or_else(unreadable)?;
            for ((axis, key), value) in AXES.into_iter().zip(REFERENCE_POINTS[place]..).zip(values) {
                if machine.axis_set().contains(axis) {
                    out.system.push((format!("#{key}"), if axis.is_rotary() { value } else { unit.mm(value) }));
                }
            }
        } else if key == "T" {
            // grblHAL: number, offsets, radius.
            let parts: Vec<&str> = text.split('|').collect();
            let (Some(tool), Some(offsets), Some(radius)) = (
                parts.first().and_then(|text| text.trim().parse().ok()),
                parts.get(1).and_then(|text| list(text)),
                parts.get(2).and_then(|text| number(text)),
            ) else {
                continue;
            };
            let length = |place: usize| unit.mm(offsets.get(place).copied().unwrap_or_default());
            let length_mm = [length(2), length(1), length(0)];
            out.tools.push(Tool { number: tool, name: None, edge: 1, length_mm, radius_mm: unit.mm(radius) });
        }
    }
    Ok(out)
}
