//! Grundig, Philips and Heidenhain MillPlus.
//!
//! Every line has a number, and no number occurs twice. The first line of a source block has the number of the block, so that a block search finds
//! it. All other lines have numbers above those of the source; numbers need not rise. Arc centers are absolute. A full circle has no end point but
//! `B5=360`; a helix becomes arcs of less than a turn.
//!
//! The control moves the tool axis of a rapid move first or last. The execution splits rapid moves accordingly, so each line moves the intended axes.
//! The order of the few micrometers that the correction adds in other axes has no effect. G27 and G28 are passed through.

use super::super::{Writer, WriterOptions};
use super::{Flavour, Language, UnitCodes};
use crate::path::{Centers, Feeds, Turns};

pub(super) const FLAVOUR: Flavour = Flavour {
    language: Language::Grundig,
    dialect: "grundig",
    units: UnitCodes::G70AndG71,
    assumed: "G71 G90 G40",
    replaced: &["G70", "G71", "G90", "G91", "G40", "G41", "G42", "G43", "G44"],
    is_pointed: false,
    feed_digits: 8,
    longest: 120,
    is_numbered: true,
    is_plain: true,
    // G9 sets the pole here, and no code stops at the end of a block.
    turns: Turns::OneFlat,
    centers: Centers::OnBisector,
    feeds: Feeds::OfLinearOnly,
    guard: None,
};

pub(super) fn create(options: &WriterOptions) -> Option<Box<dyn Writer>> {
    super::create(&FLAVOUR, options)
}
