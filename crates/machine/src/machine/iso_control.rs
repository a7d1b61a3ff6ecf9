//! Settings of the control for Fanuc and RS274/NGC.

use std::collections::BTreeMap;

use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AXES, Axis};

use super::section::Section;

/// Meaning of a number without a decimal point (Fanuc parameter 3401, bit 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecimalPoint {
    /// Whole millimeters, inches or degrees.
    Calculator,
    /// Least input increments.
    Increment,
}

/// Increment system: least input increment of positions (Fanuc parameter 1013).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IncrementSystem {
    /// IS-A: 0.01 mm, 0.001 inch, 0.01 degrees.
    A,
    /// IS-B: 0.001 mm, 0.0001 inch, 0.001 degrees.
    #[default]
    B,
    /// IS-C: 0.0001 mm, 0.00001 inch, 0.0001 degrees.
    C,
}

impl IncrementSystem {
    /// Returns the number of increments per millimeter or degree; an inch has ten times as many.
    #[must_use]
    pub fn per_unit(self) -> f64 {
        match self {
            IncrementSystem::A => 1e2,
            IncrementSystem::B => 1e3,
            IncrementSystem::C => 1e4,
        }
    }
}

/// Axis along which G43 compensates (Fanuc parameter 5001).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LengthAxis {
    /// A: always Z.
    #[default]
    Z,
    /// B: the axis perpendicular to the working plane.
    Plane,
    /// C: the axis programmed in the block of G43.
    Programmed,
}

/// Target of a plane axis that a block after G68, G51, G51.1 or their end does not name (Fanuc parameter 11600, bit 5, AX1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OneAxis {
    /// Its last programmed value, taken in the new coordinates (AX1 = 0).
    Value,
    /// No motion: in the new coordinates it keeps the position of the tool (AX1 = 1).
    Place,
}

/// Control whose meaning of a word counts where a Fanuc and a Haas differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordMeaning {
    /// A Fanuc.
    Fanuc,
    /// A Haas.
    Haas,
}

/// Settings of Fanuc and RS274/NGC controls.
#[derive(Clone, Debug, PartialEq)]
pub struct IsoControl {
    /// Meaning of a number without a decimal point; `None` if the file does not state it.
    pub decimal_point: Option<DecimalPoint>,
    /// Grid to which a Fanuc rounds the words of lengths and angles.
    pub increment_system: IncrementSystem,
    /// Axis along which G43 compensates.
    pub length_axis: LengthAxis,
    /// Words in force before the first block (RS274NGC_STARTUP_CODE of LinuxCNC, parameter 3402 of Fanuc).
    pub startup_code: String,
    /// True if G4 X under G95 counts spindle revolutions (Fanuc parameter 3405, bit 1).
    pub dwell_turns: bool,
    /// Reference points of G28 (1) and G30 (2 to 4), mm or rad; for G28, missing ones default to machine zero.
    pub reference_points: BTreeMap<(u8, Axis), f64>,
    /// Retraction of G73 after each peck, mm (Fanuc parameter 5114).
    pub chip_clearance_mm: f64,
    /// Distance above the reached depth at which G83 changes from rapid to feed, mm (Fanuc parameter 5115).
    pub peck_clearance_mm: f64,
    /// Axis and direction in which G76 and G87 move by Q with the spindle oriented (Fanuc parameter 5101, bits 4 and 5).
    pub orient_shift: Option<(Axis, f64)>,
    /// Seconds of one unit of P with a decimal point in a dwell or cycle; `None`: a Fanuc stops with an alarm, a Haas reads seconds.
    pub pointed_dwell_s: Option<f64>,
    /// True if G74 and G84 tap rigidly without M29 (Fanuc parameter 5200, bit 0); `None` if the file does not state it.
    pub rigid_tapping: Option<bool>,
    /// True if planes, zero offsets and reference points may be programmed within G68, G51 and G51.1, which a Fanuc forbids.
    pub codes_within_rotation: bool,
    /// Target of a plane axis that the first block within a rotation does not name; `None` if the file does not state it.
    pub one_axis_in_rotation: Option<OneAxis>,
    /// True if programs are for mills, even if they contain features of a lathe.
    pub is_mill: bool,
    /// Control whose meaning counts where a Fanuc and a Haas differ; `None` if the file does not state it.
    pub word_meaning: Option<WordMeaning>,
    /// True if the control compares the radii at start and end of an arc (Fanuc parameter 3410 is not 0).
    pub checks_arc_radii: bool,
    /// Smallest feed to which the control reduces F in an inner arc beside which the tool moves by G41 or G42, percent of F: setting 44 of a Haas,
    /// parameter 1710 of a Fanuc. 100: F stays.
    pub least_arc_feed_percent: u8,
    /// True if tip coordinates are those of the work offset on a table at zero, wherever the table is at G43.4.
    pub tip_of_table_at_zero: bool,
}

impl IsoControl {
    /// Returns true for a Haas.
    #[must_use]
    pub fn is_haas(&self) -> bool {
        self.word_meaning == Some(WordMeaning::Haas)
    }

    /// Returns true if words that a Haas reads differently have the meaning of a Fanuc.
    #[must_use]
    pub fn reads_as_fanuc(&self) -> bool {
        self.word_meaning == Some(WordMeaning::Fanuc)
    }

    /// Sets the defaults of a Haas.
    pub(super) fn become_haas(&mut self) {
        self.word_meaning = Some(WordMeaning::Haas);
        // A Haas taps rigidly.
        self.rigid_tapping = Some(true);
        // The chapter on cutter compensation in the manual of Haas (Mill Operator's Manual): in inner arcs the speed at the contour stays, down to setting 44.
        self.least_arc_feed_percent = 1;
        // The example of G234 in the manual of Haas (Mill Operator's Manual) turns both rotary axes before G234.
        self.tip_of_table_at_zero = true;
    }
}

impl Default for IsoControl {
    fn default() -> Self {
        IsoControl {
            decimal_point: None,
            increment_system: IncrementSystem::B,
            length_axis: LengthAxis::Z,
            startup_code: String::new(),
            dwell_turns: false,
            reference_points: BTreeMap::new(),
            chip_clearance_mm: 1.0,
            peck_clearance_mm: 1.0,
            orient_shift: None,
            pointed_dwell_s: None,
            rigid_tapping: None,
            codes_within_rotation: false,
            one_axis_in_rotation: None,
            is_mill: false,
            word_meaning: None,
            checks_arc_radii: true,
            least_arc_feed_percent: 100,
            tip_of_table_at_zero: false,
        }
    }
}

/// Reads the settings.
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
    match section.text("increment_system") {
        None => {}
        Some("IS-A") => iso.increment_system = IncrementSystem::A,
        Some("IS-B") => iso.increment_system = IncrementSystem::B,
        Some("IS-C") => iso.increment_system = IncrementSystem::C,
        Some(other) => {
            let message = format!("increment_system must be \"IS-A\", \"IS-B\" or \"IS-C\", found \"{other}\"");
            let help = "IS-A: 0.01 mm; IS-B: 0.001 mm; IS-C: 0.0001 mm (Fanuc parameter 1013)";
            section.report(Code::BAD_VALUE, section.place_of("increment_system"), message, help);
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
    match section.number("least_arc_feed_percent") {
        None => {}
        Some(value) if (1.0..=100.0).contains(&value) && value.fract() == 0.0 => {
            iso.least_arc_feed_percent = value as u8
        }
        Some(value) => {
            let message = format!("least_arc_feed_percent must be a whole number from 1 to 100, found {value}");
            let help = "give setting 44 of a Haas; 100: F stays in inner arcs with G41 and G42";
            section.report(Code::BAD_VALUE, section.place_of("least_arc_feed_percent"), message, help);
        }
    }
    match section.text("orient_shift").map(str::as_bytes) {
        None => {}
        Some([sign @ (b'+' | b'-'), letter @ (b'X' | b'Y' | b'Z')]) => {
            let sense = if *sign == b'+' { 1.0 } else { -1.0 };
            iso.orient_shift = Axis::from_letter(*letter).map(|axis| (axis, sense));
        }
        Some(_) => {
            let message = "orient_shift must be a direction sign and an axis";
            let help = "write \"+X\", \"-X\", \"+Y\", \"-Y\", \"+Z\" or \"-Z\" (Fanuc parameter 5101, bits 4 and 5)";
            section.report(Code::BAD_VALUE, section.place_of("orient_shift"), message, help);
        }
    }
    if let Some(value) = section.boolean("rigid_tapping") {
        iso.rigid_tapping = Some(value);
    }
    read_rotation(section, iso);
}

/// Reads the settings for codes within G68, G51 and G51.1.
fn read_rotation(section: &mut Section<'_>, iso: &mut IsoControl) {
    match section.text("codes_within_rotation") {
        None | Some("refused") => {}
        Some("allowed") => iso.codes_within_rotation = true,
        Some(other) => {
            let message = format!("codes_within_rotation must be \"refused\" or \"allowed\", found \"{other}\"");
            let help =
                "refused: as a Fanuc; allowed: G17 to G19, G27 to G30, G52 to G59 and G92 act within G68, G51, G51.1";
            section.report(Code::BAD_VALUE, section.place_of("codes_within_rotation"), message, help);
        }
    }
    match section.text("program_kind") {
        None => {}
        Some("mill") => iso.is_mill = true,
        Some(other) => {
            let message = format!("program_kind must be \"mill\", found \"{other}\"");
            section.report(Code::BAD_VALUE, section.place_of("program_kind"), message, "correct it, or remove it");
        }
    }
    match section.text("dwell_with_point") {
        None => {}
        Some("seconds") => iso.pointed_dwell_s = Some(1.0),
        Some("milliseconds") => iso.pointed_dwell_s = Some(1e-3),
        Some(other) => {
            let message = format!("dwell_with_point must be \"seconds\" or \"milliseconds\", found \"{other}\"");
            section.report(Code::BAD_VALUE, section.place_of("dwell_with_point"), message, "correct it, or remove it");
        }
    }
    match section.text("word_meaning") {
        None => {}
        Some("fanuc") => iso.word_meaning = Some(WordMeaning::Fanuc),
        Some("haas") => iso.word_meaning = Some(WordMeaning::Haas),
        Some(other) => {
            let message = format!("word_meaning must be \"fanuc\" or \"haas\", found \"{other}\"");
            section.report(Code::BAD_VALUE, section.place_of("word_meaning"), message, "correct it, or remove it");
        }
    }
    if let Some(value) = section.boolean("arc_radius_check") {
        iso.checks_arc_radii = value;
    }
    match section.text("tip_coordinates") {
        None => {}
        Some("table_at_start") => iso.tip_of_table_at_zero = false,
        Some("table_at_zero") => iso.tip_of_table_at_zero = true,
        Some(other) => {
            let message = format!("tip_coordinates must be \"table_at_start\" or \"table_at_zero\", found \"{other}\"");
            let help = "table_at_start: the work coordinate system is fixed to the table where it is at G43.4; table_at_zero: as if \
                        the rotary axes of the table were at zero there";
            section.report(Code::BAD_VALUE, section.place_of("tip_coordinates"), message, help);
        }
    }
    match section.text("one_axis_in_rotation") {
        None => {}
        Some("value") => iso.one_axis_in_rotation = Some(OneAxis::Value),
        Some("place") => iso.one_axis_in_rotation = Some(OneAxis::Place),
        Some(other) => {
            let message = format!("one_axis_in_rotation must be \"value\" or \"place\", found \"{other}\"");
            let help = "value: the axis that is not named goes to its last value in the new coordinates; place: it stays where \
                        the tool is (Fanuc parameter 11600, bit 5)";
            section.report(Code::BAD_VALUE, section.place_of("one_axis_in_rotation"), message, help);
        }
    }
}
