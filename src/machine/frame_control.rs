//! Settings of the control that concern frames, and the arithmetic of Sinumerik programs.

use crate::diagnostic::Code;
use crate::geometry::{Axis, RotationOrder};

use super::Control;
use super::section::Section;

/// Reads them.
pub(super) fn read(section: &mut Section<'_>, control: &mut Control) {
    match section.text("rotation_order") {
        None | Some("rpy") => {}
        Some("euler") => control.rotation_order = RotationOrder::Euler,
        Some(other) => {
            let message = format!("rotation_order must be \"rpy\" or \"euler\", found \"{other}\"");
            let help = "rpy: about Z, the new Y, the new X; euler: about Z, the new X, the new Z (Sinumerik MD10600)";
            section.report(Code::BAD_VALUE, section.place_of("rotation_order"), message, help);
        }
    }
    if let Some(value) = section.boolean("mirror_toggles") {
        control.mirror_toggles = value;
    }
    if let Some(value) = section.boolean("modulo_shortest") {
        control.modulo_shortest = value;
    }
    if let Some(value) = section.boolean("relative_comparison") {
        control.relative_comparison = value;
    }
    if let Some(value) = section.number("swivel_retract_z_mm") {
        control.swivel_retract_z_mm = Some(value);
    }
    match section.text("swivel_direction_axis").map(|text| (text, rotary_axis(text))) {
        None => {}
        Some((_, Some(axis))) => control.swivel_direction_axis = Some(axis),
        Some((other, None)) => {
            let message = format!("swivel_direction_axis must be \"A\", \"B\" or \"C\", found \"{other}\"");
            let help = "name the axis whose smaller angle is preferred with _DIR -1";
            section.report(Code::BAD_VALUE, section.place_of("swivel_direction_axis"), message, help);
        }
    }
    if let Some(value) = section.boolean("fine_shift") {
        control.fine_shift = value;
    }
}

fn rotary_axis(text: &str) -> Option<Axis> {
    let &[letter] = text.as_bytes() else { return None };
    Axis::from_letter(letter).filter(|axis| axis.is_rotary())
}
