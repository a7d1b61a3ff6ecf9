//! How far the next piece may reach: the longest that fits, found by few trials.
//!
//! The deviation of a straight piece grows with the square of its length, that of an arc faster; a trial that is too long or too short so
//! says where to try next. Where errors have kinks or rounding makes the deviation jump, bisection takes over.

use super::trial::Trial;

/// Trials for one piece.
const MOST_TRIALS: usize = 12;
/// A piece that uses this much of its tolerance is as long as it can be but for a few percent.
const GOOD_ENOUGH: f64 = 0.92;
/// Bounds between which the search ends: the piece could be longer by this share at most.
const CLOSE_ENOUGH: f64 = 1.03;
/// Aim of the next trial, as a share of what is allowed.
const AIM: f64 = 0.96;
/// A trial that fits may be followed by one this much longer.
const MOST_GROWTH: f64 = 3.0;

/// A rest shorter than this share of the piece before it is a splinter.
const SPLINTER_SHARE: f64 = 0.5;

/// What bounds the search: lengths in the parameter of the move.
#[derive(Clone, Copy, Debug)]
pub(super) struct SearchBounds {
    /// Where the piece begins.
    pub(super) from: f64,
    /// As far as it may go.
    pub(super) limit: f64,
    /// Length to begin with.
    pub(super) guess: f64,
    /// Shortest length.
    pub(super) floor: f64,
    /// Power of the length with which the deviation grows.
    pub(super) order: f64,
}

/// The longest piece found that fits, or failing that the one at the floor. Where little would be left behind it, the rest is halved:
/// the number of pieces is the same, and none is a splinter.
pub(super) fn longest(reach: SearchBounds, mut attempt: impl FnMut([f64; 2]) -> Option<Trial>) -> Option<Trial> {
    let found = search(reach, &mut attempt)?;
    let [from, to] = found.between;
    let (length, rest) = (to - from, reach.limit - to);
    if rest > 0.0 && rest < SPLINTER_SHARE * length && found.fits() {
        let half = attempt([from, from + 0.5 * (length + rest)]);
        return half.filter(Trial::fits).or(Some(found));
    }
    Some(found)
}

/// The same with whatever is left.
fn search(reach: SearchBounds, attempt: &mut impl FnMut([f64; 2]) -> Option<Trial>) -> Option<Trial> {
    let most = reach.limit - reach.from;
    let floor = reach.floor.min(most);
    let mut best: Option<Trial> = None;
    let mut too_long = f64::INFINITY;
    let mut length = reach.guess.clamp(floor, most);
    for _ in 0..MOST_TRIALS {
        // A rest that is hardly longer goes along: exactly to the limit.
        let to = if length >= most * (1.0 - 1e-9) { reach.limit } else { reach.from + length };
        let trial = attempt([reach.from, to]);
        let share = trial.map_or(f64::INFINITY, |trial| trial.share());
        if share <= 1.0 {
            best = trial;
            if to >= reach.limit || share >= GOOD_ENOUGH || length * CLOSE_ENOUGH >= too_long {
                return best;
            }
        } else {
            if length <= floor {
                return trial;
            }
            too_long = length;
        }
        let fitting = best.map_or(0.0, |best| best.between[1] - best.between[0]);
        if fitting > 0.0 && fitting * CLOSE_ENOUGH >= too_long {
            return best;
        }
        let aimed = if share.is_finite() && share > 0.0 {
            length * (AIM / share).powf(1.0 / reach.order)
        } else if share > 1.0 {
            0.5 * length
        } else {
            MOST_GROWTH * length
        };
        length = aimed.clamp(floor, most).min(MOST_GROWTH * length);
        if too_long.is_finite() && !(length > fitting && length < too_long) {
            // The aim is outside of what is still open.
            length = if fitting > 0.0 { (fitting * too_long).sqrt() } else { (0.5 * too_long).max(floor) };
        }
    }
    best.or_else(|| attempt([reach.from, reach.from + floor]))
}
