//! G84: down with feed, dwell, spindle reversal, out to the first clearance with feed, and reversal to the previous direction.

use super::basis::{At, CycleFault, CycleWords, HoleHeights, dwell};
use crate::exec::core::step::Feed;
use crate::exec::core::step::{Step, Turn};

pub(super) fn steps(words: &CycleWords, at: &At) -> Result<Vec<Step>, CycleFault> {
    let heights = HoleHeights::of(words, at)?;
    let mut steps = Vec::new();
    heights.approach(at, &mut steps);
    steps.push(Step::to_height(heights.bottom, Feed::Cut));
    dwell(words, &mut steps);
    steps.push(Step::Spindle(Turn::Reversed));
    steps.push(Step::to_height(heights.clearance, Feed::Cut));
    steps.push(Step::Spindle(Turn::Again));
    if heights.retract > heights.clearance {
        steps.push(Step::rapid_height(heights.retract));
    }
    Ok(steps)
}
