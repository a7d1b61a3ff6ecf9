//! Settings of the control for frames and for the arithmetic of Sinumerik programs.

use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, RotationOrder};

use super::Control;
use super::section::Section;

/// Path of a modulo axis to an absolute position if the language has no word for the rotary direction (Fanuc parameter 1008).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rollover {
    /// Positions count full turns: 370 degrees are one turn from 10 (ROAx 0).
    None,
    /// The shortest path to the position within the turn (ROAx 1, RABx 0).
    Shortest,
}

/// Reads the settings.
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
    match section.text("rollover") {
        None => {}
        Some("none") => control.rollover = Some(Rollover::None),
        Some("shortest") => control.rollover = Some(Rollover::Shortest),
        Some(other) => {
            let message = format!("rollover must be \"none\" or \"shortest\", found \"{other}\"");
            let help = "none: positions count their turns; shortest: the shortest path to a position within the turn (Fanuc parameter 1008)";
            section.report(Code::BAD_VALUE, section.place_of("rollover"), message, help);
        }
    }
    if let Some(value) = section.boolean("relative_comparison") {
        control.relative_comparison = value;
    }
    if let Some(value) = section.number("swivel_retract_x_mm") {
        control.swivel_retract_x_mm = Some(value);
    }
    if let Some(value) = section.number("swivel_retract_y_mm") {
        control.swivel_retract_y_mm = Some(value);
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
