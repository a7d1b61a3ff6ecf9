//! Drilling cycles that stay in the output although a hole is not within its tolerance.

use ncfix_machine::snc::DrillingCycle;

/// Cycles in which the spindle turns with the motion along the hole: moves cannot replace them.
const TAPPING: [&str; 4] = ["G74", "G84", "G84.2", "G84.3"];
/// Such cycles that moves can replace (G331, G332), for example in a rotated plane. A correction of X or Y within the thread would pull the tap aside.
const TAPPING_AS_MOVES: [&str; 2] = ["CYCLE84", "CYCLE840"];

/// `true` if moves cannot replace a cycle.
pub(super) fn must_stay(cycle: &DrillingCycle) -> bool {
    cycle.is_own || TAPPING.contains(&cycle.name.as_str())
}

/// `true` if moves cannot make a better hole than the cycle with its best shift.
pub(super) fn is_better_whole(cycle: &DrillingCycle) -> bool {
    must_stay(cycle) || TAPPING_AS_MOVES.contains(&cycle.name.as_str())
}
