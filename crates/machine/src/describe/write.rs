//! Text of a machine file for a description: every value with its origin, and the errors that are not measured yet.

use std::fmt::Write as _;

use super::description::{AxisDescription, Description};
use super::known::{Known, KnownOrigin};
use super::stated::TravelRange;
use crate::machine::OTHER_AXIS;
use crate::machine::controller::{ControllerMeaning, controller};
use crate::machine::squareness::{pair, squareness};
use ncfix_base::geometry::{Axis, Plane};

/// Column at which comments begin.
const COMMENT: usize = 36;

/// Controls whose programs have three decimals.
const THREE_DECIMALS: [&str; 3] = ["grbl", "grblhal", "fluidnc"];

/// Returns the machine file of a description.
#[must_use]
pub fn text(description: &Description) -> String {
    let mut out = String::new();
    let control = &description.control;
    // The name itself: some controls refuse words that others with the same language execute.
    let known = controller(&control.value);
    let name = known.map_or(control.value.as_str(), |row| row.name);
    let language = match known.map(|row| row.meaning) {
        Some(ControllerMeaning::Language(language)) if language != name => format!("reads the language {language}"),
        _ => String::new(),
    };
    // Writing into a String cannot fail.
    let _ = writeln!(out, "# {}: {}.", description.name.replace(char::is_control, " "), description.template.line);
    let _ = writeln!(out, "# ASSUMED marks a value that nobody stated: check it at the machine.\n");
    let _ = writeln!(out, "[machine]");
    line(&mut out, &format!("name = {}", quoted(&description.name)), "");
    line(
        &mut out,
        &format!("topology = \"{}\"", description.topology),
        "bodies from the workpiece w through F to the tool t",
    );
    let about = [language, origin(control)].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ");
    line(&mut out, &format!("controller = \"{name}\""), &about);
    if let Some(order) = &description.axis_order {
        let names: Vec<String> = order
            .value
            .iter()
            .map(|axis| quoted(&axis.map_or_else(|| OTHER_AXIS.to_owned(), |axis| axis.to_string())))
            .collect();
        let about = format!("AX1, AX2 … of the control; {}", origin(order));
        line(&mut out, &format!("axis_order = [{}]", names.join(", ")), &about);
    }
    for axis in &description.axes {
        axis_section(&mut out, axis);
    }
    let has_three = THREE_DECIMALS.contains(&control.value.to_ascii_lowercase().as_str());
    let has_words =
        description.startup_code.is_some() || description.saved_unit.is_some() || !description.control_lines.is_empty();
    if has_three || has_words || description.increments_per_mm.is_some() {
        let _ = writeln!(out, "\n[control]");
    }
    if has_three {
        line(&mut out, "increment_mm = 0.001", "decimals of the output");
    }
    if let Some(unit) = &description.saved_unit {
        let parts = ["unit of saved offsets and tools".to_owned(), origin(unit)];
        let from = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ");
        line(&mut out, &format!("saved_unit = \"{}\"", unit.value), &from);
    }
    if let Some(code) = &description.startup_code {
        let parts = ["in force before the first block".to_owned(), origin(code)];
        let from = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ");
        line(&mut out, &format!("startup_code = {}", quoted(&code.value)), &from);
    }
    for one in &description.control_lines {
        line(&mut out, &one.value, &format!("in force before the first block; {}", origin(one)));
    }
    if let Some(count) = &description.increments_per_mm {
        let from = format!("positions are rounded to them; {}", origin(count));
        line(&mut out, &format!("increments_per_mm = {}", count.value), &from);
    }
    if let Some(moves) = &description.tool_change_moves {
        let _ = writeln!(out, "\n[[opaque]]");
        line(&mut out, "name = \"M6\"", "tool change");
        line(&mut out, &format!("moves = {}", moves.value), &origin(moves));
    }
    unmeasured(&mut out, description);
    if !description.notes.is_empty() {
        let _ = writeln!(out, "\n# Read in the data of the control, and not in this file:");
        for note in &description.notes {
            let _ = writeln!(out, "# - {}", note.text.replace(char::is_control, " "));
        }
    }
    out
}

/// A basic string of TOML.
fn quoted(text: &str) -> String {
    let plain: String = text.chars().filter(|letter| !letter.is_control()).collect();
    format!("\"{}\"", plain.replace('\\', "\\\\").replace('"', "\\\""))
}

fn line(out: &mut String, key: &str, comment: &str) {
    let _ = if comment.is_empty() { writeln!(out, "{key}") } else { writeln!(out, "{key:<COMMENT$} # {comment}") };
}

/// Comment about the origin of a value; empty if a person stated it.
fn origin<T>(known: &Known<T>) -> String {
    match &known.origin {
        KnownOrigin::Stated | KnownOrigin::Convention => String::new(),
        KnownOrigin::Assumed => "ASSUMED".to_owned(),
        KnownOrigin::File(line) => line.replace(char::is_control, " "),
    }
}

fn list(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
}

fn axis_section(out: &mut String, described: &AxisDescription) {
    let axis = described.axis;
    let is_rotary = axis.is_rotary();
    let carried = if described.branch == crate::machine::Branch::Tool { "the spindle" } else { "the workpiece" };
    let _ = writeln!(out, "\n[axis.{axis}]");
    let moves = if is_rotary {
        format!("carries {carried} and turns it about this vector for {axis}+ (right-hand rule)")
    } else {
        format!("carries {carried} and moves it along this vector for {axis}+")
    };
    let from = origin(&described.direction);
    let moves = if from.is_empty() { moves } else { format!("{moves}; {from}") };
    line(out, &format!("direction = {}", list(&described.direction.value)), &moves);
    if let Some(point) = &described.point_mm {
        let from = origin(point);
        let place = "point on the axis of rotation, all axes at zero";
        line(
            out,
            &format!("point_mm = {}", list(&point.value)),
            &if from.is_empty() { place.to_owned() } else { format!("{place}; {from}") },
        );
    }
    let (travel, feed) = if is_rotary { ("travel_deg", "max_feed_deg_min") } else { ("travel_mm", "max_feed_mm_min") };
    let from = origin(&described.travel);
    match described.travel.value {
        TravelRange::Ends(ends) => line(out, &format!("{travel} = {}", list(&ends)), &from),
        TravelRange::Modulo => line(out, "modulo = true", &from),
    }
    if let Some(known) = &described.max_feed {
        line(out, &format!("{feed} = {}", known.value), &origin(known));
    }
}

/// First comment of a machine whose errors are not measured.
const NOTHING: &str = "# No error of this machine is measured yet. Without errors ncfix changes nothing.";
/// First comment of one with measured errors.
const REST: &str = "# The errors below are not measured yet, unless a section of this file has them.";

/// Headings of the lists of errors, and of the next measurements.
const LOCATION: &str = "# Not measured, location errors, for [location] (angles in µrad, offsets in µm):";
const MOTION: &str = "# Not measured, motion errors, for [[motion]]:";
const NEXT: &str = "# Measure next:";
/// The next measurements.
const SQUARE: &str = "squareness of X and Y: two diagonals of a test square, `ncfix square`";
const PITCH: &str = "pitch and backlash of each axis: laser or gauge blocks, `ncfix calibrate`";
const CIRCLES: &str = "squareness and straightness: ball-bar circles, `ncfix plan ballbar`";
const BALLS: &str = "offsets and tilts of the rotary axes: probe and ball, `ncfix plan probe`";
/// Words of the lists.
const ANGLE: &str = "squareness of";
const PLACE: &str = "offsets and tilts of";
const BACKLASH: &str = "  and backlash";

/// Returns the text of a machine file after the measurement of an error or of one of its parameters (`EC0Y`, `EXX2@50`, `EXXb`): its own comments no longer list
/// the error as not measured, nor a measurement of nothing else as the next one. Other comments stay.
#[must_use]
pub fn measured(text: &str, name: &str) -> String {
    let is_location = name.as_bytes().get(2) == Some(&b'0');
    let Some(item) = name.get(..if is_location { 4 } else { 3 }) else { return text.to_owned() };
    let is_backlash = !is_location && name.get(3..) == Some("b");
    let lines: Vec<String> = text
        .split('\n')
        .filter_map(|line| listed(line, item, is_backlash))
        .map(|line| line.replace(NOTHING, REST))
        .collect();
    // What is still listed decides which measurements are left.
    let has = |words: &str| lines.iter().any(|line| line.starts_with("#   E") && line.contains(words));
    let own = |axis: &str| lines.iter().any(|line| names(line).is_some_and(|(names, _)| names.contains(&axis)));
    let is_open = |line: &str| match line.split_once(". ").map(|(_, what)| what) {
        Some(SQUARE) => has("squareness of X and Y"),
        Some(PITCH) => ["EXX", "EYY", "EZZ"].into_iter().any(own),
        Some(CIRCLES) => has(ANGLE) || ["EYX", "EZX", "EXY", "EZY", "EXZ", "EYZ"].into_iter().any(own),
        Some(BALLS) => has(PLACE),
        _ => true,
    };
    let mut kept: Vec<&str> = lines.iter().map(String::as_str).filter(|line| is_open(line)).collect();
    for heading in [LOCATION, MOTION, NEXT] {
        let Some(at) = kept.iter().position(|line| *line == heading) else { continue };
        if !kept.get(at + 1).is_some_and(|line| line.starts_with("#   ")) {
            kept.remove(at);
        }
    }
    if !kept.iter().any(|line| [LOCATION, MOTION].contains(line)) {
        kept.retain(|line| *line != REST);
    }
    kept.join("\n")
}

/// The motion errors in a line of the list, and whether it lists the backlash too.
fn names(line: &str) -> Option<(Vec<&str>, bool)> {
    let words = line.strip_prefix("#   E").map(|_| &line[4..])?;
    let (list, has_backlash) = words.strip_suffix(BACKLASH).map_or((words, false), |list| (list, true));
    let names: Vec<&str> = list.split(' ').collect();
    names.iter().all(|name| name.len() == 3 && name.starts_with('E')).then_some((names, has_backlash))
}

/// A line without an error that it lists; `None` if it lists nothing else.
fn listed(line: &str, item: &str, is_backlash: bool) -> Option<String> {
    let axis = item.get(2..).unwrap_or_default();
    if is_backlash && line == format!("#   backlash of {axis}") {
        return None;
    }
    if let Some((names, has_backlash)) = names(line) {
        if !names.iter().any(|name| name.ends_with(axis)) {
            return Some(line.to_owned());
        }
        let left: Vec<&str> = names.into_iter().filter(|name| is_backlash || *name != item).collect();
        return match (left.as_slice(), has_backlash && !is_backlash) {
            ([], true) => Some(format!("#   backlash of {axis}")),
            ([], false) => None,
            (left, true) => Some(format!("#   {}{BACKLASH}", left.join(" "))),
            (left, false) => Some(format!("#   {}", left.join(" "))),
        };
    }
    let Some(words) = line.strip_prefix("#   ").filter(|words| words.starts_with('E')) else {
        return Some(line.to_owned());
    };
    if words.contains(ANGLE) {
        return (words.split(' ').next() != Some(item)).then(|| line.to_owned());
    }
    let Some((list, of)) = words.split_once(PLACE) else { return Some(line.to_owned()) };
    let left: Vec<&str> = list.split_whitespace().filter(|name| *name != item).collect();
    (!left.is_empty()).then(|| format!("#   {:<22} {PLACE}{of}", left.join(" ")))
}

/// Comments that name the errors of the chain, none of which is measured, and the next measurements.
fn unmeasured(out: &mut String, description: &Description) {
    let _ = writeln!(out, "\n{NOTHING}");
    let _ = writeln!(out, "{LOCATION}");
    let direction = |axis: Axis| description.axes.iter().find(|one| one.axis == axis).map(AxisDescription::vector);
    for plane in [Plane::XY, Plane::ZX, Plane::YZ] {
        if let Some(term) = squareness(&description.topology, plane, direction) {
            let [first, second, _] = pair(plane);
            let _ = writeln!(out, "#   {:<22} {ANGLE} {first} and {second}", term.name);
        }
    }
    let rotary: Vec<Axis> = description.axes.iter().map(|one| one.axis).filter(|axis| axis.is_rotary()).collect();
    for axis in &rotary {
        let names: Vec<String> = [b"XYZ", b"ABC"]
            .iter()
            .flat_map(|letters| letters.iter().enumerate())
            .filter(|(dimension, _)| *dimension != axis.dimension())
            .map(|(_, letter)| format!("E{}0{axis}", char::from(*letter)))
            .collect();
        let _ = writeln!(out, "#   {:<22} {PLACE} {axis}", names.join(" "));
    }
    let _ = writeln!(out, "{MOTION}");
    for one in &description.axes {
        let axis = one.axis;
        let names: Vec<String> =
            ["X", "Y", "Z", "A", "B", "C"].iter().map(|letter| format!("E{letter}{axis}")).collect();
        let _ = writeln!(out, "#   {}{BACKLASH}", names.join(" "));
    }
    let _ = writeln!(out, "{NEXT}");
    let last = if rotary.is_empty() { CIRCLES } else { BALLS };
    for (number, what) in (1..).zip([SQUARE, PITCH, last]) {
        let _ = writeln!(out, "#   {number}. {what}");
    }
}
