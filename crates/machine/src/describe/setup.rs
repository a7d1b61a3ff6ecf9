//! Text of the zero offsets, tools and variables of a machine, as sections of its file.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::machine::{Machine, Setting, Tool};
use ncfix_base::geometry::{Axis, AxisVector, FrameParts};

/// Largest difference of numbers after they were written and read, mm, rad or a factor: the conversion to degrees and back rounds.
const SAME: f64 = 1e-9;

/// Returns the sections of zero offsets, tools and variables that `full` has and `bare`, the machine of a text, has not. The edges of [`worn_edges`] are not
/// among them.
///
/// # Errors
/// Names the data that a machine file cannot hold.
pub fn setup_text(bare: &Machine, full: &Machine) -> Result<String, String> {
    let refused = [
        (bare.base_frames != full.base_frames, "base frames"),
        (bare.parameters != full.parameters, "R parameters"),
        (bare.partial_offsets != full.partial_offsets, "zero offsets without a shift of X, Y and Z"),
    ];
    let names: Vec<&str> = refused.into_iter().filter(|(is_there, _)| *is_there).map(|(_, name)| name).collect();
    if !names.is_empty() {
        return Err(names.join(" and "));
    }
    let mut out = String::new();
    for (name, parts) in full.zero_offsets.iter().filter(|(name, parts)| bare.zero_offsets.get(*name) != Some(parts)) {
        offset(&mut out, name, parts, full);
    }
    let worn = worn_edges(bare, full);
    let is_new = |tool: &&Tool| !bare.tools.contains(tool) && !worn.contains(&(tool.number, tool.edge));
    for tool in full.tools.iter().filter(is_new) {
        // Writing into a String cannot fail.
        let _ = writeln!(out, "\n[[tool]]\nnumber = {}", tool.number);
        if let Some(name) = &tool.name {
            let _ = writeln!(out, "name = {}", quoted(name));
        }
        if tool.edge != 1 {
            let _ = writeln!(out, "edge = {}", tool.edge);
        }
        let _ = match tool.length_mm {
            [length, 0.0, 0.0] => writeln!(out, "length_mm = {length}"),
            lengths => writeln!(out, "length_mm = {}", list(lengths)),
        };
        let _ = writeln!(out, "radius_mm = {}", tool.radius_mm);
    }
    for (section, own, others) in [("system", &full.system, &bare.system), ("gud", &full.gud, &bare.gud)] {
        let new: Vec<_> = own.iter().filter(|(name, value)| others.get(*name) != Some(value)).collect();
        if !new.is_empty() {
            let _ = writeln!(out, "\n[{section}]");
        }
        for (name, value) in new {
            let _ = writeln!(out, "{} = {}", quoted(name), setting(value));
        }
    }
    Ok(out)
}

/// Number and edge of each tool whose radius has a wear in `full` that it has not in `bare`: a machine file has no place for the wear, and without it the
/// control would follow another path. A tool table lists edges without wear, too.
#[must_use]
pub fn worn_edges(bare: &Machine, full: &Machine) -> BTreeSet<(u32, u32)> {
    let is_other =
        |(place, wear_mm): &(&(u32, u32), &f64)| **wear_mm != bare.radius_wear_mm.get(*place).copied().unwrap_or(0.0);
    full.radius_wear_mm.iter().filter(is_other).map(|(place, _)| *place).collect()
}

/// True if `one` has the zero offsets, variables and tools of `other`, without its [`worn_edges`].
#[must_use]
pub fn has_same_setup(one: &Machine, other: &Machine) -> bool {
    let worn = worn_edges(one, other);
    let offsets = [&one.zero_offsets, &other.zero_offsets];
    let is_same = |(name, parts): (&String, &FrameParts)| offsets[1].get(name).is_some_and(|own| is_near(parts, own));
    offsets[0].len() == offsets[1].len()
        && offsets[0].iter().all(is_same)
        && one.tools.iter().eq(other.tools.iter().filter(|tool| !worn.contains(&(tool.number, tool.edge))))
        && one.system == other.system
        && one.gud == other.gud
}

fn is_near(one: &FrameParts, other: &FrameParts) -> bool {
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME);
    let all = |vector: &AxisVector| ncfix_base::geometry::AXES.map(|axis| vector[axis]);
    near(&all(&one.translation), &all(&other.translation))
        && near(&all(&one.fine), &all(&other.fine))
        && near(&one.rotation, &other.rotation)
        && near(&one.scale, &other.scale)
        && one.mirror == other.mirror
}

fn offset(out: &mut String, name: &str, parts: &FrameParts, machine: &Machine) {
    let _ = writeln!(out, "\n[zero_offset.{}]", quoted(name));
    let edge = |axis: Axis, value: f64| if axis.is_rotary() { degrees(value) } else { value };
    for axis in machine.axis_set().iter() {
        let unit = if axis.is_rotary() { "deg" } else { "mm" };
        let _ = writeln!(out, "{axis}_{unit} = {}", edge(axis, parts.translation[axis]));
        if parts.fine[axis] != 0.0 {
            let _ = writeln!(out, "fine_{axis}_{unit} = {}", edge(axis, parts.fine[axis]));
        }
    }
    if parts.rotation != [0.0; 3] {
        let _ = writeln!(out, "rotation_deg = {}", list(parts.rotation.map(degrees)));
    }
    if parts.scale != [1.0; 3] {
        let _ = writeln!(out, "scale = {}", list(parts.scale));
    }
    if parts.mirror != [false; 3] {
        let named = ["X", "Y", "Z"].into_iter().zip(parts.mirror).filter(|(_, mirrored)| *mirrored);
        let names: Vec<String> = named.map(|(name, _)| quoted(name)).collect();
        let _ = writeln!(out, "mirror = [{}]", names.join(", "));
    }
}

/// An angle as a person enters it: the noise of the conversion is below every control.
fn degrees(rad: f64) -> f64 {
    (rad.to_degrees() * 1e9).round() / 1e9
}

fn list(values: [f64; 3]) -> String {
    format!("[{}]", values.map(|value| value.to_string()).join(", "))
}

/// A basic string of TOML; names of files and variables have no control characters.
fn quoted(text: &str) -> String {
    let plain: String = text.chars().filter(|letter| !letter.is_control()).collect();
    format!("\"{}\"", plain.replace('\\', "\\\\").replace('"', "\\\""))
}

fn setting(value: &Setting) -> String {
    match value {
        Setting::Whole(number) => number.to_string(),
        // A number with a fraction stays one.
        Setting::Number(number) => format!("{number:?}"),
        Setting::Truth(truth) => truth.to_string(),
        Setting::Text(text) => quoted(text),
        Setting::List(values) => format!("[{}]", values.iter().map(setting).collect::<Vec<_>>().join(", ")),
    }
}
