//! Settings of Grbl and grblHAL, as `$$` lists them.
//!
//! `$130` to `$132` are the travels in mm, `$110` to `$112` the maximum rates in mm/min. After homing Grbl counts from the positive end of each axis, so
//! positions are from -travel to 0 (Grbl 1.1 wiki, *Configuration*). These settings are always in mm.

use super::{ControlDataFormat, ControlFacts, known, number};
use crate::describe::stated::TravelRange;
use ncfix_base::geometry::Axis;

/// Settings of Grbl.
pub(super) const FORMAT: ControlDataFormat = ControlDataFormat { name: "Grbl settings ($$)", is, read };

/// The setting of a line `$130=200.000`.
fn setting(line: &str) -> Option<(u32, f64)> {
    let (key, value) = line.trim().strip_prefix('$')?.split_once('=')?;
    let value = value.split_whitespace().next()?;
    Some((key.trim().parse().ok()?, number(value)?))
}

fn is(text: &str) -> bool {
    let settings: Vec<u32> = text.lines().filter_map(setting).map(|(key, _)| key).collect();
    settings.len() >= 5 && settings.contains(&130)
}

fn read(name: &str, text: &str, facts: &mut ControlFacts) -> Result<(), String> {
    facts.control = Some(known("grbl".to_owned(), (name, 1), "settings of Grbl"));
    for (line, (key, value)) in text.lines().enumerate().filter_map(|(at, line)| Some((at + 1, setting(line)?))) {
        let axis = [Axis::X, Axis::Y, Axis::Z].get((key % 10) as usize).copied();
        match (key, axis) {
            (130..=132, Some(axis)) if value > 0.0 => {
                let travel = TravelRange::Ends([-value, 0.0]);
                let remark = format!("${key}, counted from the positive end");
                facts.axis_mut(axis).travel = Some(known(travel, (name, line), &remark));
            }
            (110..=112, Some(axis)) if value > 0.0 => {
                facts.axis_mut(axis).max_feed = Some(known(value, (name, line), &format!("${key}")));
            }
            (100..=102, Some(axis)) => {
                facts.note(format!("{name}:{line} ${key} {axis}: {value} steps/mm; a scale error can also be removed here"));
            }
            (3, _) if value != 0.0 => {
                facts.note(format!("{name}:{line} $3 = {value}: reversed motors; the sense of the axes does not follow from it"));
            }
            (13, _) => {
                let unit = if value == 0.0 { "mm" } else { "inch" };
                facts.saved_unit = Some(known(unit, (name, line), &format!("$13 = {value}, the unit of $#")));
            }
            (22, _) if value == 0.0 => {
                facts.note(format!(
                    "{name}:{line} $22 = 0: without homing the machine zero is where the axes stood at power-on; home the machine, or state the zero offset anew"
                ));
            }
            (23, _) => facts.note(format!(
                "{name}:{line} $23 = {value}: ends to which the axes home; with HOMING_FORCE_SET_ORIGIN Grbl counts from there: then give --travel"
            )),
            _ => {}
        }
    }
    facts.note(format!("{name} does not state which axis carries the workpiece: it follows from the template"));
    Ok(())
}
