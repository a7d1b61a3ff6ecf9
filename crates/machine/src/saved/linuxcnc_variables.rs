//! Variable file of LinuxCNC: `5221 100.000000`. G54 is in 5221 to 5230, each further system 20 numbers higher; the tenth number is the rotation about Z
//! in degrees (LinuxCNC manual, *Parameters*).

use super::lines::number;
use super::{SavedFormat, SavedLine, SavedUnit, SavedValues};
use crate::machine::Machine;
use crate::machine::zero_offset::lacking_axes;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, FrameParts};
use std::collections::BTreeMap;

/// Variable file of LinuxCNC.
pub(super) const FORMAT: SavedFormat = SavedFormat { name: "LinuxCNC variable file", language: "rs274", is, read };

/// Axes in the order of the variables of a system.
const AXES: [Axis; 9] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C, Axis::U, Axis::V, Axis::W];
/// Systems with their first variables.
pub(super) const SYSTEMS: [(&str, u32); 9] = [
    ("G54", 5221),
    ("G55", 5241),
    ("G56", 5261),
    ("G57", 5281),
    ("G58", 5301),
    ("G59", 5321),
    ("G59.1", 5341),
    ("G59.2", 5361),
    ("G59.3", 5381),
];
/// 1 if the G92 offset that follows is applied.
const G92_APPLIED: u32 = 5210;
/// Place of the rotation after the first variable of a system.
const ROTATION: u32 = 9;
/// First variables of the positions of G28 and G30.
pub(super) const REFERENCE_POINTS: [u32; 2] = [5161, 5181];
/// Number of the coordinate system in force: 1 for G54.
const SYSTEM_IN_FORCE: u32 = 5220;
/// Variables of users.
const USER: std::ops::RangeInclusive<u32> = 31..=5000;

fn pair(line: &SavedLine<'_>) -> Option<(u32, f64)> {
    let mut parts = line.text.split_whitespace();
    let pair = (parts.next()?.parse().ok()?, number(parts.next()?)?);
    parts.next().is_none().then_some(pair)
}

/// Variables of the zero offsets, with the number of the active one.
const OFFSETS: std::ops::RangeInclusive<u32> = 5220..=5390;

/// A whole file has all variables; a part of one has nothing but variables, and some of zero offsets.
fn is(lines: &[SavedLine<'_>]) -> bool {
    let is_comment = |line: &&SavedLine<'_>| line.text.trim_start().starts_with(['#', ';', '(']);
    let count = lines.iter().filter(|line| !is_comment(line)).count();
    let keys: Vec<u32> = lines.iter().filter_map(pair).map(|(key, _)| key).collect();
    let is_whole = keys.len() >= 5 && keys.contains(&5220) && keys.contains(&5221);
    let is_part = keys.len() == count && keys.iter().any(|key| OFFSETS.contains(key) && *key != 5220);
    is_whole || is_part
}

fn read(lines: &[SavedLine<'_>], machine: &Machine) -> Result<SavedValues, Diagnostic> {
    let mut values: BTreeMap<u32, (f64, &SavedLine<'_>)> = BTreeMap::new();
    for line in lines {
        let Some((key, value)) = pair(line) else { continue };
        if values.insert(key, (value, line)).is_some_and(|(other, _)| other != value) {
            let help = "remove the line that is not in force, or save the file again";
            return Err(line.fault(format!("a second, different value of {key}"), help));
        }
    }
    let get = |key: u32| values.get(&key).map_or(0.0, |(value, _)| *value);
    let Some(first) = lines.first() else { return Ok(SavedValues::default()) };
    let unit = SavedUnit::required(machine, first)?;
    if get(G92_APPLIED) != 0.0
        && let Some((_, line)) =
            (G92_APPLIED + 1..).take(AXES.len()).find_map(|key| values.get(&key).filter(|(value, _)| *value != 0.0))
    {
        return Err(line.fault("a G52 or G92 offset is applied", "cancel it with G92.1 and save the file again"));
    }
    let mut out = SavedValues::default();
    for (name, start) in SYSTEMS {
        // A system that the file does not have is not set by it.
        let Some((_, (_, line))) = values.range(start..start + ROTATION).next_back() else { continue };
        let place = |axis: Axis| AXES.into_iter().zip(start..).find(|(other, _)| *other == axis).map(|(_, key)| key);
        let is_stated = |axis: Axis| place(axis).is_some_and(|key| values.contains_key(&key));
        if let Some((lacking, message)) = lacking_axes(name, machine.axis_set(), false, is_stated) {
            let keys: Vec<String> = lacking.into_iter().filter_map(place).map(|key| key.to_string()).collect();
            let help =
                format!("add {} with the value of the control: LinuxCNC always saves all of them", keys.join(" and "));
            out.warnings.push(line.report(Code::PARTIAL_OFFSET, message, help));
        }
        let mut parts = FrameParts::default();
        for (axis, key) in AXES.into_iter().zip(start..) {
            let value = get(key);
            parts.translation[axis] = if axis.is_rotary() { value.to_radians() } else { unit.mm(value) };
        }
        parts.rotation[2] = get(start + ROTATION).to_radians();
        out.offsets.push((name.to_owned(), parts));
    }
    out.system = values.range(USER).map(|(key, (value, _))| (format!("#{key}"), *value)).collect();
    // After M2 and M30 it is G54. Another one was in force when the file was saved, and a program that names none begins with it.
    let in_force = values.get(&SYSTEM_IN_FORCE).map(|(value, _)| *value).filter(|value| *value > 1.0);
    out.system.extend(in_force.map(|value| (format!("#{SYSTEM_IN_FORCE}"), value)));
    for start in REFERENCE_POINTS {
        for (axis, key) in AXES.into_iter().zip(start..) {
            if let Some((value, _)) = values.get(&key).filter(|_| machine.axis_set().contains(axis)) {
                out.system.push((format!("#{key}"), if axis.is_rotary() { *value } else { unit.mm(*value) }));
            }
        }
    }
    Ok(out)
}
