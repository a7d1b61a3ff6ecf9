//! The schemes that fill tables from the error model: one file each, and their register.

use super::format::Holds;
use super::region::Region;
use super::target::Target;
use super::{Multiplication, Tables};
use crate::model::Accumulator;

/// What tables are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The corrections that they shall give.
    pub target: Target<'a>,
    /// The errors one by one.
    pub errors: &'a Accumulator<'a>,
    /// Where.
    pub region: &'a Region,
    /// Points of a table.
    pub points: usize,
    /// How much of the error may be left, mm: its root mean square over the region.
    pub tolerance_mm: f64,
    /// What the control does with products.
    pub multiplication: Multiplication,
}

/// A way to fill tables.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// Its name for `--scheme`.
    pub name: &'static str,
    /// What it does, in a sentence.
    pub title: &'static str,
    /// What a format must hold for it.
    pub needs: &'static [Holds],
    /// Fills the tables; a sentence where it cannot.
    pub fill: fn(&Task<'_>) -> Result<Tables, String>,
}

/// All schemes.
pub const SCHEMES: &[Scheme] = &[];
