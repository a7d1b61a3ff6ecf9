//! New values of zero offsets, as the control reads them: `$P_UIFR` of a Sinumerik, `G10 L2` of a Fanuc or LinuxCNC, or the variable file of LinuxCNC.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::linuxcnc_variables::SYSTEMS;
use crate::machine::Machine;
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::units::MM_PER_INCH;

/// Linear axes of a shift.
const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
/// Axes in a system of the variable file before the first axis.
const NAMED_MOST: usize = 20;

/// The text that gives the control new zero offsets: the values of the machine plus these shifts, mm. `notes` are remarks at its beginning;
/// `variables` is the variable file of a LinuxCNC, in which only the values of these offsets change.
///
/// # Errors
/// The reason, if the control has no such text, or the machine no such offset.
pub fn shifted_zeros(
    machine: &Machine,
    shifts_mm: &BTreeMap<String, AxisVector>,
    notes: &[String],
    variables: Option<&str>,
) -> Result<String, String> {
    if shifts_mm.is_empty() || shifts_mm.len() > NAMED_MOST {
        return Err("the program cuts in no zero offset, or in too many".into());
    }
    let mut values = Vec::new();
    for (name, shift) in shifts_mm {
        let old = machine.zero_offsets.get(name).ok_or_else(|| format!("{name} has no value in the machine file"))?;
        values.push((name.as_str(), AXES.map(|axis| (axis, old.translation[axis] + shift[axis]))));
    }
    let there = |(axis, _): &(Axis, f64)| machine.axis(*axis).is_some();
    let decimals = 6;
    let mut text = String::new();
    let number = |value: f64| {
        let text = format!("{value:.decimals$}");
        let bare = text.trim_end_matches('0');
        let bare = if bare.ends_with('.') { text.get(..=bare.len()).unwrap_or(bare) } else { bare };
        if bare == "-0.0" { "0.0".to_owned() } else { bare.to_owned() }
    };
    match (machine.controller.as_str(), variables) {
        ("sinumerik", _) => {
            text.push_str("%_N_ZERO_SHIFT_INI\n");
            notes.iter().for_each(|note| _ = writeln!(text, "; {note}"));
            text.push_str("CHANDATA(1)\n");
            for (name, axes) in values {
                let index = sinumerik(name).ok_or_else(|| format!("{name} is no settable frame of this control"))?;
                for (axis, value) in axes.iter().filter(|one| there(one)) {
                    let _ = writeln!(text, "$P_UIFR[{index},{axis},TR]={}", number(*value));
                }
            }
            text.push_str("M17\n");
        }
        ("rs274", Some(variables)) => {
            let unit_mm = match machine.control.saved_inch {
                Some(false) => 1.0,
                Some(true) => MM_PER_INCH,
                None => return Err("the unit of the variable file is not known; write saved_unit in [control]".into()),
            };
            return changed(variables, &values, unit_mm);
        }
        (control @ ("fanuc" | "rs274"), _) => {
            let is_fanuc = matches!(control, "fanuc");
            if is_fanuc {
                text.push_str("%\n");
            }
            notes.iter().for_each(|note| _ = writeln!(text, "({})", note.replace(['(', ')'], " ")));
            text.push_str("G21 G90\n");
            for (name, axes) in values {
                let words = system(name, is_fanuc).ok_or_else(|| format!("{name} cannot be set with G10"))?;
                let _ = write!(text, "G10 {words}");
                axes.iter().filter(|one| there(one)).for_each(|(axis, value)| {
                    let _ = write!(text, " {axis}{}", number(*value));
                });
                text.push('\n');
            }
            text.push_str(if is_fanuc { "M30\n%\n" } else { "M2\n" });
        }
        (other, _) => {
            return Err(format!("zero offsets cannot be written for controller = \"{other}\"; enter them by hand"));
        }
    }
    Ok(text)
}

/// Number of a settable frame: G54 to G57 are 1 to 4, G505 to G599 are 5 to 99.
fn sinumerik(name: &str) -> Option<u32> {
    match name.strip_prefix('G')?.parse::<u32>().ok()? {
        500 => Some(0),
        number @ 54..=57 => Some(number - 53),
        number @ 505..=599 => Some(number - 500),
        _ => None,
    }
}

/// The external offset of a Fanuc, which shifts all others, and its words in G10.
const EXTERNAL: [(&str, &str); 1] = [("EXT", "L2 P0")];

/// The words that name an offset in G10.
fn system(name: &str, is_fanuc: bool) -> Option<String> {
    if is_fanuc {
        if let Some((_, words)) = EXTERNAL.iter().find(|(known, _)| *known == name) {
            return Some((*words).to_owned());
        }
        if let Some(number) = name.strip_prefix("G54.1 P").or(name.strip_prefix("G154 P")) {
            return Some(format!("L20 P{}", number.parse::<u32>().ok()?));
        }
        let number = name.strip_prefix('G')?.parse::<u32>().ok()?;
        return (54..=59).contains(&number).then(|| format!("L2 P{}", number - 53));
    }
    let place = SYSTEMS.iter().position(|(known, _)| *known == name)?;
    Some(format!("L2 P{}", place + 1))
}

/// The variable file with other values of some offsets.
fn changed(variables: &str, values: &[(&str, [(Axis, f64); 3])], unit_mm: f64) -> Result<String, String> {
    let mut left: BTreeMap<u32, f64> = BTreeMap::new();
    for (name, axes) in values {
        let first = SYSTEMS.iter().find(|(known, _)| known == name).map(|(_, first)| *first);
        let first = first.ok_or_else(|| format!("{name} is not in a variable file"))?;
        left.extend((first..).zip(axes.iter().map(|(_, value)| value / unit_mm)));
    }
    let mut text = String::new();
    for line in variables.lines() {
        let mut parts = line.split_whitespace();
        let key = parts.next().and_then(|key| key.parse::<u32>().ok());
        match key.and_then(|key| left.remove(&key).map(|value| (key, value))) {
            Some((key, value)) => _ = writeln!(text, "{key}\t{value:.6}"),
            None => _ = writeln!(text, "{line}"),
        }
    }
    match left.keys().next() {
        Some(key) => Err(format!("the variable file has no line {key}")),
        None => Ok(text),
    }
}
