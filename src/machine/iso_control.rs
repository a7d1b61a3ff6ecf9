//! Settings of the control that concern Fanuc and RS274/NGC.

use std::collections::BTreeMap;

use crate::diagnostic::Code;
use crate::geometry::{AXES, Axis};

use super::section::Section;

/// What a number without a decimal point means (Fanuc parameter 3401, bit 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecimalPoint {
    /// Whole millimetres, inches or degrees.
    Calculator,
    /// Least input increments of IS-B: 0.001 mm, 0.0001 inch, 0.001 degrees.
    Increment,
}

/// The axis along which G43 compensates (Fanuc parameter 5001).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LengthAxis {
    /// A: always Z.
    #[default]
    Z,
    /// B: the axis across the working plane.
    Plane,
    /// C: the axis programmed in the block of G43.
    Programmed,
}

/// Settings of Fanuc and RS274/NGC controls.
#[derive(Clone, Debug, PartialEq)]
pub struct IsoControl {
    /// What a number without a decimal point means; `None` where the file does not say it.
    pub decimal_point: Option<DecimalPoint>,
    /// Along which axis G43 compensates.
    pub length_axis: LengthAxis,
    /// Words that hold before the first block (RS274NGC_STARTUP_CODE of LinuxCNC, parameter 3402 of Fanuc).
    pub startup_code: String,
    /// Whether G4 X under G95 counts turns of the spindle (Fanuc parameter 3405, bit 1).
    pub dwell_turns: bool,
    /// Reference points of G28 (1) and G30 (2 to 4), mm or rad; machine zero is assumed for those of G28 that are missing.
    pub reference_points: BTreeMap<(u8, Axis), f64>,
    /// How far G73 draws back behind each peck, mm (Fanuc parameter 5114).
    pub chip_clearance_mm: f64,
    /// How far above the depth that is reached G83 goes over from rapid to feed, mm (Fanuc parameter 5115).
    pub peck_clearance_mm: f64,
    /// Axis and sense along which G76 and G87 step aside by Q with the spindle oriented (Fanuc parameter 5101, bits 4 and 5).
    pub orient_shift: Option<(Axis, f64)>,
    /// Whether G74 and G84 tap rigidly without M29 (Fanuc parameter 5200, bit 0); `None` where the file does not say it.
    pub rigid_tapping: Option<bool>,
}

impl Default for IsoControl {
    fn default() -> Self {
        IsoControl {
            decimal_point: None,
            length_axis: LengthAxis::Z,
            startup_code: String::new(),
            dwell_turns: false,
            reference_points: BTreeMap::new(),
            chip_clearance_mm: 1.0,
            peck_clearance_mm: 1.0,
            orient_shift: None,
            rigid_tapping: None,
        }
    }
}

/// Reads them.
pub(super) fn read(section: &mut Section<'_>, iso: &mut IsoControl) {
    match section.text("decimal_point") {
        None => {}
        Some("calculator") => iso.decimal_point = Some(DecimalPoint::Calculator),
        Some("increment") => iso.decimal_point = Some(DecimalPoint::Increment),
        Some(other) => {
            let message = format!("decimal_point must be \"calculator\" or \"increment\", found \"{other}\"");
            let help = "calculator: X10 is 10 mm; increment: X10 is 0.01 mm (Fanuc parameter 3401, bit 0)";
            section.report(Code::BAD_VALUE, section.place_of("decimal_point"), message, help);
        }
    }
    match section.text("length_compensation") {
        None | Some("A") => {}
        Some("B") => iso.length_axis = LengthAxis::Plane,
        Some("C") => iso.length_axis = LengthAxis::Programmed,
        Some(other) => {
            let message = format!("length_compensation must be \"A\", \"B\" or \"C\", found \"{other}\"");
            let help = "A: along Z; B: across the working plane; C: along the axis programmed (Fanuc parameter 5001)";
            section.report(Code::BAD_VALUE, section.place_of("length_compensation"), message, help);
        }
    }
    if let Some(value) = section.text("startup_code") {
        iso.startup_code = value.to_owned();
    }
    if let Some(value) = section.boolean("dwell_turns") {
        iso.dwell_turns = value;
    }
    for point in 1..=4_u8 {
        for axis in AXES {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            if let Some(value) = section.number(&format!("reference_point_{point}_{axis}_{unit}")) {
                let value = if axis.is_rotary() { value.to_radians() } else { value };
                iso.reference_points.insert((point, axis), value);
            }
        }
    }
    for (key, place) in
        [("chip_clearance_mm", &mut iso.chip_clearance_mm), ("peck_clearance_mm", &mut iso.peck_clearance_mm)]
    {
        match section.number(key) {
            None => {}
            Some(value) if value >= 0.0 => *place = value,
            Some(value) => {
                let message = format!("{key} must not be negative, found {value}");
                section.report(Code::BAD_VALUE, section.place_of(key), message, "give a distance in mm");
            }
        }
    }
    match section.text("orient_shift").map(str::as_bytes) {
        None => {}
        Some([sign @ (b'+' | b'-'), letter @ (b'X' | b'Y' | b'Z')]) => {
            let sense = if *sign == b'+' { 1.0 } else { -1.0 };
            iso.orient_shift = Axis::from_letter(*letter).map(|axis| (axis, sense));
        }
        Some(_) => {
            let message = "orient_shift must be a sense and an axis";
            let help = "write \"+X\", \"-X\", \"+Y\", \"-Y\", \"+Z\" or \"-Z\" (Fanuc parameter 5101, bits 4 and 5)";
            section.report(Code::BAD_VALUE, section.place_of("orient_shift"), message, help);
        }
    }
    if let Some(value) = section.boolean("rigid_tapping") {
        iso.rigid_tapping = Some(value);
    }
}
