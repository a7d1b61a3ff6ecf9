//! A difference of a corrected program from its original that is not a correction.

use ncfix_base::geometry::Axis;
use ncfix_machine::snc::{FeedUnit, Origin};

/// A difference with its places in both programs; if one program has no counterpart, the place is its next or last move.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// In the original.
    pub original: Origin,
    /// In the corrected program.
    pub corrected: Origin,
    /// The difference.
    pub what: What,
}

/// Kinds of differences.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// An act other than motion, with its text in both programs; `None` if it is missing. Equal texts mean that it is at another place in the
    /// sequence.
    Act {
        /// `spindle speed`, `coolant`, `tool` …
        subject: &'static str,
        /// In the original.
        before: Option<String>,
        /// In the corrected program.
        after: Option<String>,
    },
    /// The tool deviates from its place by more than was promised, mm.
    Off {
        /// Actual distance.
        off_mm: f64,
        /// Permitted distance.
        limit_mm: f64,
    },
    /// The tool direction differs by more than its uncorrected direction explains, rad.
    Tilted {
        /// Actual tilt.
        tilt_rad: f64,
        /// Permitted tilt.
        limit_rad: f64,
    },
    /// A piece of a move that is evaluated at its end only, such as a rapid move, is off the straight path of the move, mm.
    Detour {
        /// Actual distance.
        off_mm: f64,
        /// Permitted distance.
        limit_mm: f64,
    },
    /// A piece of such a move turns an axis beyond both of its ends.
    Turned {
        /// The axis.
        axis: Axis,
        /// Excess, rad.
        beyond_rad: f64,
    },
    /// A move has another feed: value and unit in both programs, and the ratio if defined.
    Feed {
        /// In the original.
        before: (f64, FeedUnit),
        /// In the corrected program.
        after: (f64, FeedUnit),
        /// Ratio of the new feed to the original feed.
        share: f64,
    },
}
