//! What Fanuc and its kin write.
//!
//! Every position and feed has a decimal point, as a number without one means whole units on one control and thousandths on the
//! other. Codes that are options of the control are not taken for granted, so that nobody needs an option to run a corrected program.

use super::super::{Writer, WriterOptions};
use super::{Flavour, Language};
use crate::path::{Centers, Feeds, Turns};

pub(super) const FLAVOUR: Flavour = Flavour {
    language: Language::Fanuc,
    dialect: "fanuc",
    assumed: "G21 G90 G40",
    replaced: &["G20", "G21", "G90", "G91", "G40", "G41", "G42", "G80"],
    is_pointed: true,
    // Eight digits are the longest number.
    feed_digits: 8,
    longest: 120,
    is_numbered: false,
    is_plain: true,
    // Turns beyond the first need the option for spirals.
    turns: Turns::One,
    centers: Centers::OnBisector,
    feeds: Feeds::OfAll,
};

pub(super) fn create(options: &WriterOptions) -> Option<Box<dyn Writer>> {
    super::create(&FLAVOUR, options)
}
