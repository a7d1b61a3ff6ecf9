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

impl Defined {
    /// `true` for tapping in which the control couples spindle and axis (I1=1).
    pub(super) fn is_rigid_tapping(&self) -> bool {
        self.cycle.number == 84 && self.words.get(b'I', 1) == Some(1.0)
    }
}

/// Where the last hole of a cycle was, along the tool axis in the coordinates of the program, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastHole {
    pub(super) surface: f64,
    /// Height at which the tool ended.
    pub(super) end: f64,
}

impl std::fmt::Debug for Defined {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "G{}", self.cycle.number)
    }
}
