//! The limit of rotary corrections near a singularity, block by block.
//!
//! If the tool is almost parallel to a rotary axis, a small tilt needs a large motion of that axis. The model damps it
//! ([`Solve::Full`](ncfix_model::Solve::Full)), which makes the correction a smooth function of the pose. However, a block may lead far across the
//! singularity, and errors may step (backlash, tables). Near the singularity the rotary corrections therefore change by at most [`MOST_TURN_RAD`]
//! from one block to the next. Longer paths are divided; the excess is left to the following blocks, and the linear axes place the tip for the actual
//! rotary commands.
//!
//! Rapid moves that are not divided have no limit: they do not cut, and a feed move should begin with its correct orientation.

use ncfix_base::geometry::{AxisVector, ROTARY_AXES};
use ncfix_machine::machine::State;

use super::place::Placed;
use super::segment_candidate::SegmentFitter;

/// Largest change of the correction of a rotary axis in one block near a singularity, rad. A tip 300 mm from the axis then leaves the chord by 300 ·
/// φ²/8 = 0.01 µm, less than any increment, so the position is exact between the ends too. A table that turns at 20 rpm needs a quarter of a
/// millisecond for it, less than a block takes.
pub(super) const MOST_TURN_RAD: f64 = 5e-4;
/// Number of examined places of a piece: the damped range is 5.7° wide, so a piece of 180° is seen to pass it.
const PLACES: u32 = 32;

impl SegmentFitter<'_, '_> {
    /// Corrects and rounds an end of a piece; `correction` is that of the previous block.
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
