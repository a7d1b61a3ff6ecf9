//! Settings of the control for cutter radius compensation.

use ncfix_base::diagnostic::Code;

use super::Control;
use super::section::Section;

/// Approach and retraction of radius compensation at an outer corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompensationStart {
    /// Straight to the point beside the start of the contour, perpendicular to the contour.
    #[default]
    A,
    /// To the point perpendicular to the first block, then around the corner.
    B,
}

/// Path around outer corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompensationCorner {
    /// Straight lines.
    Linear,
    /// Arc around the corner.
    Circular,
}

/// Center of an arc whose radii at start and end differ within the tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArcCenter {
    /// On the perpendicular bisector of start and end: the radius is constant (Sinumerik, Grundig).
    Moved,
    /// As programmed: the radius changes linearly with the angle (Fanuc, RS274/NGC).
    Kept,
}

/// Reads the settings.
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
    match section.text("compensation_start") {
        None => {}
        Some("A") => control.compensation_start = CompensationStart::A,
        Some("B") => control.compensation_start = CompensationStart::B,
        Some(other) => {
            let message = format!("compensation_start must be \"A\" or \"B\", found \"{other}\"");
            let help = "A: at right angles to the contour; B: at right angles to the block that begins, then around the corner";
            section.report(Code::BAD_VALUE, section.place_of("compensation_start"), message, help);
        }
    }
    match section.text("compensation_corner") {
        None => {}
        Some("linear") => control.compensation_corner = Some(CompensationCorner::Linear),
        Some("circular") => control.compensation_corner = Some(CompensationCorner::Circular),
        Some(other) => {
            let message = format!("compensation_corner must be \"linear\" or \"circular\", found \"{other}\"");
            let help = "linear: straight lines around outer corners; circular: an arc about the corner";
            section.report(Code::BAD_VALUE, section.place_of("compensation_corner"), message, help);
        }
    }
    if let Some(value) = section.boolean("arc_words_from_center") {
        control.has_arc_words_from_center = value;
    }
    if let Some(value) = section.boolean("arc_plane_from_words") {
        control.takes_arc_plane_from_words = value;
    }
    match section.text("arc_center") {
        None => {}
        Some("moved") => control.arc_center = Some(ArcCenter::Moved),
        Some("kept") => control.arc_center = Some(ArcCenter::Kept),
        Some(other) => {
            let message = format!("arc_center must be \"moved\" or \"kept\", found \"{other}\"");
            let help = "moved: onto the bisector of the chord; kept: the radius changes linearly with the angle";
            section.report(Code::BAD_VALUE, section.place_of("arc_center"), message, help);
        }
    }
}
