//! The promise of a correction about the program that it writes, for comparisons with the source.

use super::super::{CorrectionOptions, FiveAxis, Rapids, Rotary, Subdivision};

/// The promise of a correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// The largest deviation of a piece from its exactly corrected path, mm.
    pub tolerance_mm: f64,
    /// The largest deviation of a hole that stays a drilling cycle, mm.
    pub hole_tolerance_mm: f64,
    /// The increment of the coordinates, if it differs from that of the machine file, mm.
    pub increment_mm: Option<f64>,
    /// `true` if moves were cut at fixed steps: the ends of pieces then keep the tolerance, the path between them may not.
    pub is_stepped: bool,
    /// `true` if rapid moves stayed unchanged.
    pub leaves_rapids: bool,
    /// `true` if feeds were lowered.
    pub limits_feed: bool,
    /// `true` if axis positions are written instead of tip positions.
    pub in_axes: bool,
    /// `true` if the control again compensates tool radii, by their wear.
    pub keeps_wear: bool,
    /// `true` if all rotary axes participate: words of other axes then refer to a corrected angle even if that angle is not written.
    pub corrects_rotary: bool,
}

impl Default for Promise {
    fn default() -> Self {
        Promise::of(&CorrectionOptions::default())
    }
}

impl Promise {
    /// The promise of a correction with these options.
    #[must_use]
    pub fn of(options: &CorrectionOptions) -> Promise {
        Promise {
            tolerance_mm: options.tolerance_mm,
            hole_tolerance_mm: options.hole_tolerance_mm.max(options.tolerance_mm),
            increment_mm: None,
            is_stepped: matches!(options.subdivision, Subdivision::Step(_)),
            leaves_rapids: options.rapids == Rapids::None,
            limits_feed: false,
            in_axes: options.five_axis == FiveAxis::Axes,
            keeps_wear: false,
            corrects_rotary: options.rotary == Rotary::Correct,
        }
    }
}
