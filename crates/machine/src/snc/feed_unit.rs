//! Units of a feed.

/// Modal words that set the unit of F or require it to be programmed again. They include those of constant cutting speed.
pub const FEED_MODES: [&str; 13] =
    ["G93", "G94", "G95", "G96", "G97", "G961", "G962", "G971", "G972", "G973", "G942", "G952", "G931"];

/// Unit of a feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedUnit {
    /// Path per minute: mm/min, degrees/min (G94).
    #[default]
    PerMinute,
    /// Path per spindle revolution (G95).
    PerTurn,
    /// Blocks per minute: the reciprocal of the time of a block (G93).
    InverseTime,
}

impl FeedUnit {
    /// Returns its G code.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            FeedUnit::PerMinute => "G94",
            FeedUnit::PerTurn => "G95",
            FeedUnit::InverseTime => "G93",
        }
    }
}
