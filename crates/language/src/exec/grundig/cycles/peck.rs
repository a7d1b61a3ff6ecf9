//! G83: in pecks of K, each shorter than the previous one by I. After each peck the tool lifts by J, or retracts fully if J is 0 or after K1= pecks.

use super::basis::{At, CycleFault, CycleWords, HoleHeights, dwell, fault};
use crate::exec::core::step::Feed;
use crate::exec::core::step::Step;

/// Maximum number of pecks; more is an input error.
const MOST_PECKS: u32 = 10_000;
/// Depth below which a remainder is rounding noise.
const HAIR_MM: f64 = 1e-6;

pub(super) fn steps(words: &CycleWords, at: &At) -> Result<Vec<Step>, CycleFault> {
    let heights = HoleHeights::of(words, at)?;
    let (first, less, lift) = (words.value(b'K'), words.value(b'I'), words.value(b'J'));
    if first <= 0.0 || less < 0.0 || lift < 0.0 {
        return Err(fault(
            "K must be above 0, I and J must not be negative",
            "K is the first peck, I the reduction of each further peck",
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
        // A peck never becomes zero.
        if peck - less > 0.0 {
            peck -= less;
        }
    }
    dwell(words, &mut steps);
    steps.push(Step::rapid_height(heights.retract));
    Ok(steps)
}
