//! Settings of the control that concern frames.

use crate::diagnostic::Code;
use crate::geometry::RotationOrder;

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
    if let Some(value) = section.boolean("fine_shift") {
        control.fine_shift = value;
    }
}
