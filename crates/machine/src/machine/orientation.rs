//! Settings of the control for five-axis transformations.

use super::section::Section;
use super::{Control, OriPath, OrientationAngles, TiltAbout};
use ncfix_base::diagnostic::Code;

/// Reads `orientation_angles`, `tilt_about`, `oripath` and `pole_limit_deg` of `[control]`.
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
    match section.text("tilt_about") {
        None | Some("normal") => {}
        Some("tangent") => control.tilt_about = TiltAbout::Tangent,
        Some("turned_tangent") => control.tilt_about = TiltAbout::TurnedTangent,
        Some(other) => {
            let message =
                format!("tilt_about must be \"normal\", \"tangent\" or \"turned_tangent\", found \"{other}\"");
            let help = "MD21094, tens digit: 0 normal, 1 and 4 tangent, 2 and 3 turned_tangent";
            section.report(Code::BAD_VALUE, section.place_of("tilt_about"), message, help);
        }
    }
    match section.text("oripath") {
        None | Some("end") => {}
        Some("path") => control.ori_path = OriPath::Path,
        Some(other) => {
            let message = format!("oripath must be \"end\" or \"path\", found \"{other}\"");
            let help = "MD21094, last digit: 0 end, 1 path";
            section.report(Code::BAD_VALUE, section.place_of("oripath"), message, help);
        }
    }
    let range = |value: f64| (0.0..=45.0).contains(&value);
    if let Some(value) = section.number_where("pole_limit_deg", "an angle from 0 to 45", range) {
        control.pole_limit_rad = value.to_radians();
    }
}
