//! The groups of G codes, which are given in tenths: `G54.1` is 541.
//!
//! The groups are those of the execution, common to Fanuc and RS274/NGC; other codes are looked up in the code table.

use ncfix_dialect::Language;

/// Groups of G codes. A block has at most one code of each group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// Non-modal actions: G4, G10, G28, G52, G92 …
    Action,
    /// Motion modes; for RS274/NGC including canned cycles.
    Motion,
    /// G17, G18, G19
    Plane,
    /// G90, G91
    Distance,
    /// G90.1, G91.1
    ArcDistance,
    /// G93, G94, G95
    FeedMode,
    /// G20, G21; G70, G71 of Mach
    Units,
    /// G40, G41, G42
    Compensation,
    /// G43, G44, G49
    Length,
    /// G98, G99
    Retract,
    /// G54 … G59.3, G54.1
    Coordinates,
    /// G61, G64
    Control,
    /// G96, G97
    SpindleMode,
    /// G50, G51
    Scale,
    /// G68, G69, G68.2
    Rotation,
    /// G50.1, G51.1
    Mirror,
    /// G15, G16
    Polar,
    /// G66, G67
    Macro,
    /// G12.1, G13.1
    Interpolation,
    /// G7, G8
    Lathe,
    /// G92.1, G92.2, G92.3 of RS274/NGC
    Shift,
    /// Canned cycles of Fanuc.
    Cycle,
}

/// Number of groups.
pub(super) const GROUPS: usize = 22;

/// No motion mode is active.
pub(super) const G80: u16 = 800;

/// The group of a code in tenths; `None` for codes that only the code table contains.
pub(super) fn group_of(tenths: u16, language: Language) -> Option<Group> {
    let is_rs274 = language == Language::Rs274;
    Some(match tenths {
        0 | 10 | 20 | 30 => Group::Motion,
        330 => Group::Motion,
        331 if is_rs274 => Group::Motion,
        730 | 740 | 760 | 800 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890 if is_rs274 => Group::Motion,
        730 | 740 | 760 | 800 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890 => Group::Cycle,
        50 | 51 | 52 | 382 | 383 | 384 | 385 if is_rs274 => Group::Motion,
        842 | 843 if !is_rs274 => Group::Cycle,
        170 | 180 | 190 => Group::Plane,
        200 | 210 => Group::Units,
        // Of Mach; as cycles of a lathe they have further words.
        700 | 710 if is_rs274 => Group::Units,
        900 | 910 => Group::Distance,
        901 | 911 => Group::ArcDistance,
        930 | 940 | 950 => Group::FeedMode,
        400 | 410 | 420 => Group::Compensation,
        411 | 421 if is_rs274 => Group::Compensation,
        430 | 431 | 490 => Group::Length,
        432 if is_rs274 => Group::Length,
        440 | 434 | 435 if !is_rs274 => Group::Length,
        540 | 550 | 560 | 570 | 580 | 590 => Group::Coordinates,
        591..=593 if is_rs274 => Group::Coordinates,
        541 if !is_rs274 => Group::Coordinates,
        610 | 611 | 640 => Group::Control,
        620 | 630 if !is_rs274 => Group::Control,
        960 | 970 => Group::SpindleMode,
        980 | 990 => Group::Retract,
        921..=923 if is_rs274 => Group::Shift,
        40 | 100 | 280 | 300 | 520 | 920 | 921 => Group::Action,
        53 | 281 | 301 if is_rs274 => Group::Action,
        110 | 270 | 290 | 310 | 531 | 650 if !is_rs274 => Group::Action,
        70 | 80 if is_rs274 => Group::Lathe,
        _ if is_rs274 => return None,
        150 | 160 => Group::Polar,
        500 | 510 => Group::Scale,
        501 | 511 => Group::Mirror,
        680 | 690 | 682 | 683 | 684 => Group::Rotation,
        660 | 661 | 670 => Group::Macro,
        121 | 131 => Group::Interpolation,
        _ => return None,
    })
}

/// A code in tenths as written: `G54.1`.
pub(super) fn name_of(tenths: u16) -> String {
    match tenths % 10 {
        0 => format!("G{}", tenths / 10),
        tenth => format!("G{}.{tenth}", tenths / 10),
    }
}
