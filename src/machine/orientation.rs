//! Settings of the control for five-axis transformations.

use super::section::Section;
use super::{Control, OrientationAngles};
use crate::diagnostic::Code;

/// Reads `orientation_angles` and `pole_limit_deg` of `[control]`.
pub(super) fn read(section: &mut Section<'_>, control: &mut Control) {
    match section.text("orientation_angles") {
        None | Some("rpy") => {}
        Some("euler") => control.orientation_angles = OrientationAngles::Euler,
        Some(other) => {
            let message = format!("orientation_angles must be \"rpy\" or \"euler\", found \"{other}\"");
            let help = "rpy: C2 about Z, B2 about the new Y, A2 about the new X; euler: A2 about Z, B2 about the new X";
            section.report(Code::BAD_VALUE, section.place_of("orientation_angles"), message, help);
        }
    }
    let range = |value: f64| (0.0..=45.0).contains(&value);
    if let Some(value) = section.number_where("pole_limit_deg", "an angle from 0 to 45", range) {
        control.pole_limit_rad = value.to_radians();
    }
}
