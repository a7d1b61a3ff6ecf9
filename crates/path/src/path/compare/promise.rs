//! What a correction promises of the program that it writes, for those who compare it with its source.

use super::super::{FiveAxis, Options, Rapids, Rotary, Subdivision};

/// See above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// The largest deviation of a piece from its exactly corrected path, mm.
    pub tolerance_mm: f64,
    /// The increment of the coordinates, where it is not that of the machine file, mm.
    pub increment_mm: Option<f64>,
    /// Whether moves were cut at fixed steps: then the ends of pieces keep the tolerance, and what lies between need not.
    pub is_stepped: bool,
    /// Whether rapid moves stayed as they were.
    pub leaves_rapids: bool,
    /// Whether feeds were lowered.
    pub limits_feed: bool,
    /// Whether positions of the axes are written instead of those of the tip.
    pub in_axes: bool,
    /// Whether the control compensates the radius of tools again, by their wear.
    pub keeps_wear: bool,
    /// Whether all rotary axes take part, so that the words of others are those beside a corrected angle even where that is not written.
    pub corrects_rotary: bool,
}

impl Default for Promise {
    fn default() -> Self {
        Promise::of(&Options::default())
    }
}

impl Promise {
    /// What a correction with these options promises.
    #[must_use]
    pub fn of(options: &Options) -> Promise {
        Promise {
            tolerance_mm: options.tolerance_mm,
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
