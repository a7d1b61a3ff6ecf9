//! RS274/NGC (LinuxCNC).
//!
//! G61.1 stops at the end of each block. Lines of a block before its last have G61 instead, which follows the path without stopping; G64 would round
//! the joints of pieces.

use super::super::{Writer, WriterOptions};
use super::{Flavour, Language, UnitCodes};
use crate::path::{Centers, Feeds, Turns};

pub(super) const FLAVOUR: Flavour = Flavour {
    language: Language::Rs274,
    dialect: "rs274",
    units: UnitCodes::G20AndG21,
    assumed: "G21 G90 G91.1 G40",
    // G80 would end the motion mode, and is in one group with the motion of its line.
    replaced: &["G20", "G21", "G90", "G91", "G90.1", "G91.1", "G40", "G41", "G42", "G41.1", "G42.1", "G80"],
    is_pointed: false,
    feed_digits: 12,
    // The interpreter reads at most 255 bytes.
    longest: 240,
    is_numbered: false,
    is_plain: false,
    turns: Turns::Several,
    centers: Centers::AsWritten,
    feeds: Feeds::OfLinear,
    guard: Some(crate::emit::guard::rs274),
};

pub(super) fn create(options: &WriterOptions) -> Option<Box<dyn Writer>> {
    super::create(&FLAVOUR, options)
}
