//! INI file of LinuxCNC: `[TRAJ]`, `[AXIS_X]`, `[JOINT_0]`, `[KINS]` (LinuxCNC manual, *INI Configuration*).

use std::collections::BTreeMap;

use super::{ControlDataFormat, ControlFacts, known, number, rounded};
use crate::describe::stated::TravelRange;
use ncfix_base::geometry::Axis;

/// INI file of LinuxCNC.
pub(super) const FORMAT: ControlDataFormat = ControlDataFormat { name: "LinuxCNC INI", is, read };

/// Limits beyond this are those of an axis that turns without limits, degrees.
const NO_LIMIT: f64 = 1e6;
/// Millimeters of an inch.
const INCH_MM: f64 = 25.4;
/// Seconds of a minute: velocities are per second.
const MINUTE_S: f64 = 60.0;

fn is(text: &str) -> bool {
    let has = |section: &str| text.lines().any(|line| line.trim().eq_ignore_ascii_case(section));
    has("[EMC]") || (has("[TRAJ]") && has("[KINS]"))
}

/// Keys of `[EMCIO]` that let a tool change move axes.
const CHANGE_MOVES: [&str; 3] = ["TOOL_CHANGE_POSITION", "TOOL_CHANGE_QUILL_UP", "TOOL_CHANGE_AT_G30"];

/// True if the file replaces M6 by a program, which may move axes.
fn remaps_change(text: &str) -> bool {
    let is_remap = |line: &str| {
        let line = line.trim().to_ascii_uppercase();
        let value = line.strip_prefix("REMAP").map(str::trim_start).and_then(|rest| rest.strip_prefix('='));
        value.is_some_and(|value| matches!(value.split_whitespace().next(), Some("M6" | "M06")))
    };
    text.lines().any(is_remap)
}

/// Values of the file by section and key, in upper case, with their lines.
fn values(text: &str) -> BTreeMap<(String, String), (&str, usize)> {
    let (mut section, mut out) = (String::new(), BTreeMap::new());
    for (at, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            section = name.0.trim().to_ascii_uppercase();
        } else if let Some((key, value)) = line.split_once('=').filter(|_| !line.starts_with(['#', ';'])) {
            let value = value.split(['#', ';']).next().unwrap_or_default().trim();
            out.entry((section.clone(), key.trim().to_ascii_uppercase())).or_insert((value, at + 1));
        }
    }
    out
}

fn read(name: &str, text: &str, facts: &mut ControlFacts) -> Result<(), String> {
    let values = values(text);
    let get = |section: &str, key: &str| values.get(&(section.to_owned(), key.to_owned())).copied();
    facts.control = Some(known("linuxcnc".to_owned(), (name, 1), "INI of LinuxCNC"));
    let Some((unit, unit_line)) = get("TRAJ", "LINEAR_UNITS") else {
        return Err(format!(
            "{name} has no LINEAR_UNITS in [TRAJ], so the unit of its lengths is not known; add it as LinuxCNC uses it"
        ));
    };
    let (scale, saved_unit) = match unit.to_ascii_lowercase().as_str() {
        "mm" | "metric" => (1.0, "mm"),
        "inch" | "in" | "imperial" => (INCH_MM, "inch"),
        _ => return Err(format!("{name}:{unit_line} LINEAR_UNITS = {unit} is neither mm nor inch")),
    };
    facts.saved_unit = Some(known(saved_unit, (name, unit_line), "LINEAR_UNITS"));
    let coordinates: Vec<Axis> = get("TRAJ", "COORDINATES")
        .map(|(text, _)| text.bytes().filter_map(|letter| Axis::from_letter(letter.to_ascii_uppercase())).collect())
        .unwrap_or_default();
    for (joint, axis) in coordinates.iter().copied().enumerate() {
        let joint = format!("JOINT_{joint}");
        let sections = [format!("AXIS_{axis}"), joint.clone()];
        let find = |key: &str| sections.iter().find_map(|section| Some((section.as_str(), get(section, key)?)));
        let scale = if axis.is_rotary() { 1.0 } else { scale };
        let wrapped =
            get(&sections[0], "WRAPPED_ROTARY").filter(|(value, _)| number(value).is_some_and(|value| value != 0.0));
        let ends = find("MIN_LIMIT").zip(find("MAX_LIMIT"));
        if let Some((_, line)) = wrapped.filter(|_| axis.is_rotary()) {
            facts.axis_mut(axis).travel = Some(known(TravelRange::Modulo, (name, line), "WRAPPED_ROTARY"));
        } else if let Some(((section, (low, line)), (_, (high, _)))) = ends
            && let (Some(low), Some(high)) = (number(low), number(high))
            && low < high
            && high - low < NO_LIMIT
        {
            let travel = TravelRange::Ends([low, high].map(|end| rounded(end * scale)));
            facts.axis_mut(axis).travel =
                Some(known(travel, (name, line), &format!("[{section}] MIN_LIMIT, MAX_LIMIT")));
        } else {
            facts.note(format!("{name} has no limits of {axis} in [AXIS_{axis}] or [{joint}]"));
        }
        if let Some((section, (value, line))) = find("MAX_VELOCITY")
            && let Some(value) = number(value).filter(|value| *value > 0.0)
        {
            let feed = rounded(value * scale * MINUTE_S);
            facts.axis_mut(axis).max_feed = Some(known(feed, (name, line), &format!("[{section}] MAX_VELOCITY")));
        }
        for (key, meaning) in [
            ("BACKLASH", "LinuxCNC compensates this backlash: ncfix needs only the rest"),
            ("COMP_FILE", "LinuxCNC compensates the pitch error from this file: measure with it active"),
        ] {
            if let Some((value, line)) = get(&joint, key).filter(|(value, _)| number(value) != Some(0.0)) {
                facts.note(format!("{name}:{line} [{joint}] {key} = {value} ({axis}): {meaning}"));
            }
        }
    }
    if coordinates.is_empty() {
        facts.note(format!("{name} has no COORDINATES in [TRAJ]: no limits are taken"));
    }
    let is_off = |value: &str| matches!(value.to_ascii_uppercase().as_str(), "0" | "NO" | "FALSE" | "");
    let moves = CHANGE_MOVES.iter().any(|key| get("EMCIO", key).is_some_and(|(value, _)| !is_off(value)));
    if !moves && !remaps_change(text) && !text.to_ascii_uppercase().contains("#INCLUDE") {
        let without = format!("[EMCIO] has none of {}", CHANGE_MOVES.join(", "));
        facts.tool_change_moves = Some(known(false, (name, 1), &without));
    }
    if let Some((value, line)) = get("RS274NGC", "RS274NGC_STARTUP_CODE").filter(|(value, _)| !value.is_empty()) {
        facts.startup_code = Some(known(value.to_owned(), (name, line), "[RS274NGC] RS274NGC_STARTUP_CODE"));
    }
    if let Some((value, line)) = get("KINS", "KINEMATICS") {
        facts.note(format!(
            "{name}:{line} KINEMATICS = {value}: pivots of a five-axis module are in its HAL pins, not in the INI"
        ));
    }
    facts.note(format!("{name} does not state which axis carries the workpiece: it follows from the template"));
    Ok(())
}
