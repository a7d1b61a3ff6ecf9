//! What a feed counts.

/// Modal words that say what F counts, or that it must be said anew. Those of the constant cutting speed are among them.
pub const FEED_MODES: [&str; 13] =
    ["G93", "G94", "G95", "G96", "G97", "G961", "G962", "G971", "G972", "G973", "G942", "G952", "G931"];

/// The unit of a feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedUnit {
    /// Of the way a minute: mm/min, degrees/min (G94).
    #[default]
    PerMinute,
    /// Of the way a turn of the spindle (G95).
    PerTurn,
    /// Blocks a minute: the reciprocal of the time of a block (G93).
    InverseTime,
}

impl FeedUnit {
    /// The word for it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            FeedUnit::PerMinute => "G94",
            FeedUnit::PerTurn => "G95",
            FeedUnit::InverseTime => "G93",
        }
    }
}
