//! Settings of the Grundig, Philips and `MillPlus` controls.

use ncfix_base::diagnostic::Code;

use super::Control;
use super::section::Section;

/// Differences between these controls, mostly by machine constants.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a setting of its own")]
pub struct GrundigControl {
    /// True if `A4=` of G73 is in per cent instead of a factor.
    pub scale_in_percent: bool,
    /// Axes that `A4=` scales.
    pub scaled_axes: ScaledAxes,
    /// True if G53 to G59 cancel the shift and rotation of G92 and G93.
    pub offset_cancels_shift: bool,
    /// Distance above the old depth at which a peck of G83 begins again, mm.
    pub peck_clearance_mm: f64,
    /// Cutting width of pockets without `I`, per cent of the tool diameter.
    pub engagement_percent: f64,
    /// True if a slot is measured from the center of the arc at its end instead of the end itself.
    pub slot_from_arc_center: bool,
    /// True if rapid moves move the tool axis and the plane one after the other at the start.
    pub positioning_logic: bool,
    /// True if G73 acts outside the shift and rotation of G92 and G93, instead of inside them.
    pub mirror_outside: bool,
    /// True if the shift of G92 is along the rotated axes, instead of those of the stored zero offset.
    pub shift_is_turned: bool,
    /// True if B4= in a block with a shift rotates first, so that the shift is along the new axes.
    pub turns_first: bool,
    /// True if I1= and K are lengths of chamfers, instead of distances from the corner.
    pub chamfer_is_length: bool,
    /// Position of the swivel head that the axes of the machine file describe: 53 or 54.
    pub head: Option<u16>,
    /// Order in which G7 turns by several angles; `None` if the file does not state it.
    pub plane_order: Option<PlaneOrder>,
}

/// Order in which the angles A5, B5, C5 of G7 turn the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneOrder {
    /// About X, then about the turned Y, then about the turned Z: `Rx · Ry · Rz`.
    Turned,
    /// About X, then Y, then Z of the workpiece, which stay: `Rz · Ry · Rx`.
    Fixed,
}

/// Axes that are scaled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScaledAxes {
    /// Axes of the working plane.
    #[default]
    Plane,
    /// The tool axis, too.
    All,
}

impl Default for GrundigControl {
    fn default() -> Self {
        GrundigControl {
            scale_in_percent: false,
            scaled_axes: ScaledAxes::Plane,
            offset_cancels_shift: true,
            peck_clearance_mm: 1.0,
            engagement_percent: 83.0,
            slot_from_arc_center: false,
            positioning_logic: true,
            mirror_outside: false,
            shift_is_turned: true,
            turns_first: false,
            chamfer_is_length: false,
            head: None,
            plane_order: None,
        }
    }
}

/// Reads the settings.
pub(super) fn read(section: &mut Section<'_>, control: &mut Control) {
    let settings = &mut control.grundig;
    if let Some(value) = section.boolean("grundig_scale_in_percent") {
        settings.scale_in_percent = value;
    }
    match section.text("grundig_scaled_axes") {
        None | Some("plane") => {}
        Some("all") => settings.scaled_axes = ScaledAxes::All,
        Some(other) => {
            let message = format!("grundig_scaled_axes must be \"plane\" or \"all\", found \"{other}\"");
            let help = "plane: A4= of G73 scales the axes of the working plane; all: the tool axis too";
            section.report(Code::BAD_VALUE, section.place_of("grundig_scaled_axes"), message, help);
        }
    }
    if let Some(value) = section.boolean("grundig_offset_cancels_shift") {
        settings.offset_cancels_shift = value;
    }
    let is_distance = |value: f64| (0.0..=100.0).contains(&value);
    if let Some(value) = section.number_where("grundig_peck_clearance_mm", "a distance from 0 to 100", is_distance) {
        settings.peck_clearance_mm = value;
    }
    let is_share = |value: f64| value > 0.0 && value <= 100.0;
    if let Some(value) = section.number_where("grundig_engagement_percent", "a number above 0, up to 100", is_share) {
        settings.engagement_percent = value;
    }
    for (key, place) in [
        ("grundig_slot_from_arc_center", &mut settings.slot_from_arc_center),
        ("grundig_positioning_logic", &mut settings.positioning_logic),
        ("grundig_mirror_outside", &mut settings.mirror_outside),
        ("grundig_shift_is_turned", &mut settings.shift_is_turned),
        ("grundig_turns_first", &mut settings.turns_first),
        ("grundig_chamfer_is_length", &mut settings.chamfer_is_length),
    ] {
        if let Some(value) = section.boolean(key) {
            *place = value;
        }
    }
    match section.text("grundig_plane_order") {
        None => {}
        Some("turned") => settings.plane_order = Some(PlaneOrder::Turned),
        Some("fixed") => settings.plane_order = Some(PlaneOrder::Fixed),
        Some(other) => {
            let message = format!("grundig_plane_order must be \"turned\" or \"fixed\", found \"{other}\"");
            let help = "turned: B5 and C5 of G7 turn about the axes that the angles before have turned; fixed: about the axes of the workpiece";
            section.report(Code::BAD_VALUE, section.place_of("grundig_plane_order"), message, help);
        }
    }
    match section.text("grundig_head") {
        None => {}
        Some("M53") => settings.head = Some(53),
        Some("M54") => settings.head = Some(54),
        Some(other) => {
            let message = format!("grundig_head must be \"M53\" or \"M54\", found \"{other}\"");
            let help = "name the position of the head that the axes of this file describe";
            section.report(Code::BAD_VALUE, section.place_of("grundig_head"), message, help);
        }
    }
}
