//! What a feed counts.

/// The unit of a feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedUnit {
    /// Of the way a minute: mm/min, degrees/min.
    #[default]
    PerMinute,
    /// Of the way a turn of the spindle.
    PerTurn,
    /// Blocks a minute: the reciprocal of the time of a block.
    InverseTime,
}

const WORDS: &[(FeedUnit, &[&str])] = &[
    (FeedUnit::PerMinute, &["G94", "G942", "G961", "G971"]),
    (FeedUnit::PerTurn, &["G95", "G952", "G96", "G97", "G962", "G972", "G973"]),
    (FeedUnit::InverseTime, &["G93", "G931"]),
];

impl FeedUnit {
    /// The unit that a modal word selects; `None` where it is about something else.
    #[must_use]
    pub fn of(word: &str) -> Option<FeedUnit> {
        WORDS.iter().find(|(_, words)| words.contains(&word)).map(|(unit, _)| *unit)
    }

    /// The word for it in the text of the stream.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            FeedUnit::PerMinute => "G94",
            FeedUnit::PerTurn => "G95",
            FeedUnit::InverseTime => "G93",
        }
    }
}
