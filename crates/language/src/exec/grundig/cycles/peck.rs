//! G83: in pecks of K, each shorter than the last by I, with a lift by J after each or a full retraction where J is 0 or K1= pecks are
//! done.

use super::basis::{At, CycleFault, CycleWords, HoleHeights, dwell, fault};
use crate::exec::core::step::Feed;
use crate::exec::core::step::Step;

/// More pecks than this are a slip of the pen.
const MOST_PECKS: u32 = 10_000;
/// What is left of a depth by the rounding of sums is no peck.
const HAIR_MM: f64 = 1e-6;

pub(super) fn steps(words: &CycleWords, at: &At) -> Result<Vec<Step>, CycleFault> {
    let heights = HoleHeights::of(words, at)?;
    let (first, less, lift) = (words.value(b'K'), words.value(b'I'), words.value(b'J'));
    if first <= 0.0 || less < 0.0 || lift < 0.0 {
        return Err(fault(
            "K must be above 0, I and J must not be negative",
            "K is the first peck, I what each is shorter",
        ));
    }
    let until_retraction = words.get(b'K', 1).unwrap_or(0.0);
    let mut steps = Vec::new();
    heights.approach(at, &mut steps);
    let (mut depth, mut peck) = (at.surface, first);
    for count in 1.. {
        if count > MOST_PECKS {
            return Err(fault(format!("more than {MOST_PECKS} pecks"), "correct K or I"));
        }
        depth -= peck;
        if depth < heights.bottom + HAIR_MM {
            depth = heights.bottom;
        }
        steps.push(Step::to_height(depth, Feed::Cut));
        if depth <= heights.bottom {
            break;
        }
        let is_due = until_retraction >= 1.0 && f64::from(count) % until_retraction.floor() == 0.0;
        if lift > 0.0 && !is_due {
            steps.push(Step::rapid_height((depth + lift).min(heights.clearance)));
        } else {
            steps.push(Step::rapid_height(heights.clearance));
            steps.push(Step::rapid_height((depth + at.peck_clearance_mm).min(heights.clearance)));
        }
        // A peck never becomes nothing, nor the whole rest at once.
        if peck - less > 0.0 {
            peck -= less;
        }
    }
    dwell(words, &mut steps);
    steps.push(Step::rapid_height(heights.retract));
    Ok(steps)
}
