//! Compares machine data that a control has saved with a machine file. The machine file decides how ncfix calculates, so data that differ from it have no
//! effect: a person must know that.

use super::data::{ControlFacts, DataNote, DataNoteKind};
use super::known::{Known, KnownOrigin};
use crate::machine::Machine;
use ncfix_base::geometry::{Axis, ROTARY_AXES, Vector};

/// Distances below this are equal, mm.
const SAME_MM: f64 = 1e-3;
/// Directions with a smaller sine of their angle are equal.
const SAME_DIRECTION: f64 = 1e-6;

/// Sentences on data in a file that contradict the machine; none if the file has no data of a machine.
#[must_use]
pub fn contradictions(name: &str, bytes: &[u8], machine: &Machine) -> Vec<String> {
    let mut facts = ControlFacts::default();
    if facts.read(name, bytes).is_err() {
        return Vec::new();
    }
    let mut out = Vec::new();
    let control = &machine.control;
    let zero_offset = control.initial_zero_offset.as_deref().unwrap_or("G500");
    let own = [
        format!("initial_zero_offset = \"{zero_offset}\""),
        format!("initial_plane = {}", control.initial_plane.number()),
    ];
    for line in &facts.control_lines {
        let key = line.value.split(' ').next().unwrap_or_default();
        if let Some(own) = own.iter().find(|own| own.starts_with(key) && **own != line.value) {
            out.push(format!("{}: programs begin with {}, and the machine file has {own}", origin(line), line.value));
        }
    }
    let is_start = |note: &&DataNote| note.kind == DataNoteKind::UnknownStart;
    out.extend(facts.notes.iter().filter(is_start).map(ToString::to_string));
    if let Some(shift) = &facts.zero_shift_mm {
        let [x, y, z] = shift.value;
        out.push(format!(
            "{}: TRAORI shifts the zero of the workpiece by ({x}, {y}, {z}) mm, and the zero offsets of these data do not contain this shift: a program under TRAORI is corrected for a place that is as far away",
            origin(shift)
        ));
    }
    // With an own gauge point, the machine file may count from another origin.
    if machine.spindle.origin_mm == Vector::zeros() {
        out.extend(ROTARY_AXES.into_iter().filter_map(|axis| rotary(axis, &facts, machine)));
    }
    out
}

/// The contradiction of a rotary axis.
fn rotary(axis: Axis, facts: &ControlFacts, machine: &Machine) -> Option<String> {
    let (stated, own) = (facts.axis(axis)?, machine.axis(axis)?);
    let direction = stated.direction.as_ref()?;
    let [x, y, z] = direction.value;
    let unit = Vector::new(x, y, z) / Vector::new(x, y, z).norm().max(f64::MIN_POSITIVE);
    if unit.cross(&own.direction).norm() > SAME_DIRECTION || unit.dot(&own.direction) < 0.0 {
        return Some(format!(
            "{}: {axis} turns about ({x}, {y}, {z}), and in the machine file about ({}, {}, {})",
            origin(direction),
            own.direction.x,
            own.direction.y,
            own.direction.z
        ));
    }
    let point = stated.point_mm.as_ref()?;
    let [x, y, z] = point.value;
    let away_mm = (Vector::new(x, y, z) - own.point_mm).cross(&own.direction).norm();
    (away_mm > SAME_MM).then(|| {
        format!(
            "{}: the axis of {axis} passes through ({x}, {y}, {z}) mm, which is {away_mm:.3} mm away from its line in the machine file",
            origin(point)
        )
    })
}

fn origin<T>(known: &Known<T>) -> &str {
    match &known.origin {
        KnownOrigin::File(line) => line,
        _ => "data of the control",
    }
}
