//! The limit of rotary corrections near a singularity, block by block.
//!
//! Where the tool is almost parallel to a rotary axis, a small tilt takes a large motion of that axis. The model damps it
//! ([`Solve::Full`](ncfix_model::Solve::Full)), which makes the correction a smooth function of the pose; but a block may lead far across
//! the singularity, and errors may step (backlash, tables). So near it the rotary corrections change by at most [`MOST_TURN_RAD`] from one
//! block to the next: longer ways are cut, what still is too much is left to the following blocks, and the linear axes bring the tip to its
//! place for the rotary commands that there are.
//!
//! Rapid moves that are not cut are not limited: they cut nothing, and a feed move should begin with the orientation that it needs.

use ncfix_base::geometry::{AxisVector, ROTARY_AXES};
use ncfix_machine::machine::State;

use super::place::Placed;
use super::trial::SegmentFitter;

/// The most by which the correction of a rotary axis changes in one block near a singularity, rad. A tip 300 mm from the axis leaves the
/// chord by 300 · φ²/8 = 0.01 µm then, less than any increment, so the position is exact between the ends too; and a table that
/// turns at 20 rpm needs a quarter of a millisecond for it, less than a block takes.
pub(super) const MOST_TURN_RAD: f64 = 5e-4;
/// Places of a piece that are looked at: the damped range is 5.7° wide, a piece of 180° is seen to pass it.
const PLACES: u32 = 32;

impl SegmentFitter<'_, '_> {
    /// Corrects and rounds a place at an end of a piece; `correction` is that of the block before.
    pub(super) fn place(
        &self,
        between: [f64; 2],
        nominal: &AxisVector,
        state: &State,
        correction: &AxisVector,
    ) -> Placed {
        let placed = self.placer.place(nominal, self.known, state, correction, f64::INFINITY);
        if !self.limits_turns || !self.placer.has_rotary {
            return placed;
        }
        let change = placed.command - *nominal - *correction;
        if change.max_abs(&ROTARY_AXES) <= MOST_TURN_RAD || !self.passes_singularity(between) {
            return placed;
        }
        let limited = self.placer.place(nominal, self.known, state, correction, MOST_TURN_RAD);
        Placed { is_held_back: true, ..limited }
    }

    fn passes_singularity(&self, between: [f64; 2]) -> bool {
        let [from, to] = between;
        let at = |k| self.route.at(from + (to - from) * f64::from(k) / f64::from(PLACES));
        (0..=PLACES).any(|k| self.placer.model.is_near_singularity(&at(k), &self.placer.setup.tool_mm))
    }
}
