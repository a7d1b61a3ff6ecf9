//! What Grundig, Philips and Heidenhain MillPlus write.
//!
//! Every line has a number, and none occurs twice: the first line of a block of the source has its own, so that a block search finds it, all others have
//! numbers above those of the source; numbers need not rise. Centers of arcs are absolute; a full circle
//! has no end point but `B5=360`; a helix becomes arcs of less than a turn.
//!
//! The control moves the tool axis of a rapid move first or last. The execution has split rapid moves already, so each line moves what
//! it should; where the correction adds some micrometers in the other axes, their order does not matter. G27 and G28 stay as they are.

use super::super::{Writer, WriterOptions};
use super::{Flavour, Language};
use crate::path::{Centers, Feeds, Turns};

pub(super) const FLAVOUR: Flavour = Flavour {
    language: Language::Grundig,
    dialect: "grundig",
    assumed: "G71 G90 G40",
    replaced: &["G70", "G71", "G90", "G91", "G40", "G41", "G42", "G43", "G44"],
    is_pointed: false,
    feed_digits: 8,
    longest: 120,
    is_numbered: true,
    is_plain: true,
    // G9 is the pole here, and no code stops at the end of a block.
    turns: Turns::OneFlat,
    centers: Centers::OnBisector,
    feeds: Feeds::OfLinearOnly,
};

pub(super) fn create(options: &WriterOptions) -> Option<Box<dyn Writer>> {
    super::create(&FLAVOUR, options)
}
