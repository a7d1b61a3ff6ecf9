//! A defined cycle.

use super::cycles::Cycle;
use super::cycles::CycleWords;
/// A defined cycle.
#[derive(Clone)]
pub(super) struct Defined {
    pub(super) cycle: &'static Cycle,
    pub(super) words: CycleWords,
    /// Its feed, if its block names one.
    pub(super) feed: Option<f64>,
    /// Pitch of G84, mm.
    pub(super) pitch: Option<f64>,
    /// `true` if it was defined under G95; its feeds are then per turn.
    pub(super) per_turn: bool,
}

impl std::fmt::Debug for Defined {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "G{}", self.cycle.number)
    }
}
