//! Something in which a corrected program differs from its original, other than by its correction.

use ncfix_base::geometry::Axis;
use ncfix_machine::snc::{FeedUnit, Origin};

/// A difference, with its places in both programs; where the one program has nothing there, its next move or its last.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// In the original.
    pub original: Origin,
    /// In the corrected program.
    pub corrected: Origin,
    /// What it is.
    pub what: What,
}

/// Kinds of differences.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// Something besides motion: what it is about, and how it is written in both; `None` where it is missing. Where both are the same it stands
    /// elsewhere among the others.
    Act {
        /// `spindle speed`, `coolant`, `tool` …
        subject: &'static str,
        /// In the original.
        before: Option<String>,
        /// In the corrected program.
        after: Option<String>,
    },
    /// The tool is further from its place than was promised, mm.
    Off {
        /// How far.
        off_mm: f64,
        /// How far it may be.
        limit_mm: f64,
    },
    /// The tool points elsewhere than its uncorrected direction explains, rad.
    Tilted {
        /// How far.
        tilt_rad: f64,
        /// How far it may be.
        limit_rad: f64,
    },
    /// A piece of a move that is judged at its end only, a rapid one for instance, is beside the straight way of the move, mm.
    Detour {
        /// How far.
        off_mm: f64,
        /// How far it may be.
        limit_mm: f64,
    },
    /// A piece of such a move turns an axis beyond both of its ends.
    Turned {
        /// The axis.
        axis: Axis,
        /// How far, rad.
        beyond_rad: f64,
    },
    /// A move has another feed: its number and unit in both, and the feed as a share of what it was, where that can be said.
    Feed {
        /// In the original.
        before: (f64, FeedUnit),
        /// In the corrected program.
        after: (f64, FeedUnit),
        /// The feed as a share of what it was.
        share: f64,
    },
}
