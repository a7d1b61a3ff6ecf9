//! Settings of the control that concern radius compensation.

use super::Control;
use super::section::Section;

/// Reads them.
pub(super) fn read(section: &mut Section<'_>, control: &mut Control) {
    let is_angle = |value: f64| (0.0..=180.0).contains(&value);
    if let Some(value) = section.number_where("compensation_corner_deg", "an angle from 0 to 180", is_angle) {
        control.compensation_corner_rad = value.to_radians();
    }
    if let Some(value) = section.number_where("compensation_flat_deg", "an angle from 0 to 180", is_angle) {
        control.compensation_flat_rad = value.to_radians();
    }
    let is_count = |value: f64| (0.0..=100.0).contains(&value) && value.fract() == 0.0;
    if let Some(value) = section.number_where("compensation_blocks_between", "a whole number from 0 to 100", is_count) {
        control.compensation_blocks_between = value as u32;
    }
    if let Some(value) = section.number_where("compensation_look_ahead", "a whole number from 0 to 100", is_count) {
        control.compensation_look_ahead = value as u32;
    }
}
