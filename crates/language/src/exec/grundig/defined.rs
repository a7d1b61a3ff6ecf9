//! A cycle that is defined.

use super::cycles::Cycle;
use super::cycles::CycleWords;
/// A cycle that is defined.
#[derive(Clone)]
pub(super) struct Defined {
    pub(super) cycle: &'static Cycle,
    pub(super) words: CycleWords,
    /// Its feed, where its block names one.
    pub(super) feed: Option<f64>,
    /// Pitch of G84, mm.
    pub(super) pitch: Option<f64>,
    /// Whether it was defined under G95, in whose unit its feeds are.
    pub(super) per_turn: bool,
}

impl std::fmt::Debug for Defined {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "G{}", self.cycle.number)
    }
}
