//! Fanuc and compatible controls.
//!
//! Every position and feed has a decimal point: a number without one means whole units on some controls and thousandths on others. The output does
//! not require optional codes of the control.

use super::super::{Writer, WriterOptions};
use super::{Flavour, Language, UnitCodes};
use crate::path::{Centers, Feeds, Turns};

pub(super) const FLAVOUR: Flavour = Flavour {
    language: Language::Fanuc,
    dialect: "fanuc",
    units: UnitCodes::G20AndG21,
    assumed: "G21 G90 G40",
    replaced: &["G20", "G21", "G90", "G91", "G40", "G41", "G42", "G80"],
    is_pointed: true,
    // The longest number has eight digits.
    feed_digits: 8,
    longest: 120,
    is_numbered: false,
    is_plain: true,
    // More than one turn requires the spiral option.
    turns: Turns::One,
    centers: Centers::AsWritten,
    feeds: Feeds::OfAll,
    guard: Some(crate::emit::guard::fanuc),
};

pub(super) fn create(options: &WriterOptions) -> Option<Box<dyn Writer>> {
    super::create(&FLAVOUR, options)
}
