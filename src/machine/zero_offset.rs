//! Settable zero offsets in the machine file: `[zero_offset.G54]` with shifts, rotation, scale and mirror.

use std::collections::BTreeMap;

use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::{Axis, AxisSet, FrameParts};

use super::section::Section;

pub(super) const ZERO_OFFSET_NAMES: &str = "settable zero offsets are G500, G54 to G57 and G505 to G599";

pub(super) fn is_zero_offset_name(name: &str) -> bool {
    let number = name.strip_prefix('G').filter(|digits| digits.bytes().all(|digit| digit.is_ascii_digit()));
    let number: Option<u32> = number.and_then(|digits| digits.parse().ok());
    number.is_some_and(|number| matches!(number, 54..=57 | 500 | 505..=599)) && !name.starts_with("G0")
}

pub(super) fn read_zero_offsets(
    root: &mut Section<'_>,
    axes: AxisSet,
    findings: &mut Vec<Diagnostic>,
) -> BTreeMap<String, FrameParts> {
    let mut offsets = BTreeMap::new();
    let Some(mut section) = root.section("zero_offset") else { return offsets };
    let names: Vec<&str> = section.keys().collect();
    for name in names {
        if !is_zero_offset_name(name) {
            let message = format!("\"{name}\" is no settable zero offset");
            section.accept(name);
            section.report(Code::UNKNOWN_KEY, section.place_of_key(name), message, ZERO_OFFSET_NAMES);
            continue;
        }
        let Some(mut own) = section.section(name) else { continue };
        let parts = read_parts(&mut own, axes);
        own.finish(findings);
        offsets.insert(name.to_owned(), parts);
    }
    section.finish(findings);
    offsets
}

fn read_parts(section: &mut Section<'_>, axes: AxisSet) -> FrameParts {
    let mut parts = FrameParts::default();
    for axis in axes.iter() {
        let unit = if axis.is_rotary() { "deg" } else { "mm" };
        let value = |number: f64| if axis.is_rotary() { number.to_radians() } else { number };
        parts.translation[axis] = section.number(&format!("{axis}_{unit}")).map_or(0.0, value);
        parts.fine[axis] = section.number(&format!("fine_{axis}_{unit}")).map_or(0.0, value);
    }
    if let Some(angles) = section.vector("rotation_deg") {
        parts.rotation = [angles.x, angles.y, angles.z].map(f64::to_radians);
    }
    if let Some(factors) = section.vector("scale") {
        if factors.iter().all(|factor| (1e-6..1e6).contains(factor)) {
            parts.scale = [factors.x, factors.y, factors.z];
        } else {
            let help = "write the factors of X, Y and Z, for example [1, 1, 1]";
            section.report(Code::BAD_VALUE, section.place_of("scale"), "scale factors must be above 0", help);
        }
    }
    for (index, name) in section.texts("mirror").unwrap_or_default().iter().enumerate() {
        let axis = [Axis::X, Axis::Y, Axis::Z].into_iter().find(|axis| axis.to_string() == *name);
        match axis.and_then(|axis| parts.mirror.get_mut(axis.slot())) {
            Some(mirror) => *mirror = true,
            None => {
                let place = section.place_of_item("mirror", index);
                let message = format!("\"{name}\" cannot be mirrored");
                section.report(Code::BAD_VALUE, place, message, "name X, Y or Z");
            }
        }
    }
    parts
}
