//! Search for the longest piece that fits, with few attempts.
//!
//! The deviation of a straight piece grows with the square of its length, that of an arc faster. An attempt that is too long or too short thus
//! predicts the next one. If kinks or rounding make the deviation jump, bisection takes over.

use super::segment_candidate::SegmentCandidate;

/// Maximum attempts for one piece.
const MOST_TRIALS: usize = 12;
/// Share of the tolerance above which a piece is within a few percent of the longest one.
const GOOD_ENOUGH: f64 = 0.92;
/// Ratio of the bounds at which the search ends.
const CLOSE_ENOUGH: f64 = 1.03;
/// Target of the next attempt as a share of the allowed deviation.
const AIM: f64 = 0.96;
/// Largest ratio of the next attempt to one that fits.
const MOST_GROWTH: f64 = 3.0;

/// A remainder shorter than this share of the previous piece is a splinter.
const SPLINTER_SHARE: f64 = 0.5;

/// Bounds of the search: lengths in the parameter of the move.
#[derive(Clone, Copy, Debug)]
pub(super) struct SearchBounds {
    /// Start of the piece.
    pub(super) from: f64,
    /// Largest end of the piece.
    pub(super) limit: f64,
    /// Initial length.
    pub(super) guess: f64,
    /// Shortest length.
    pub(super) floor: f64,
    /// Exponent with which the deviation grows with the length.
    pub(super) order: f64,
}

/// The longest piece that fits, or the one at the floor if none fits. If little would remain after it, the rest is halved: the number of pieces is
/// unchanged, and none is a splinter.
pub(super) fn longest<'m>(
    reach: SearchBounds,
    mut attempt: impl FnMut([f64; 2]) -> Option<SegmentCandidate<'m>>,
) -> Option<SegmentCandidate<'m>> {
    let found = search(reach, &mut attempt)?;
    let [from, to] = found.between;
    let (length, rest) = (to - from, reach.limit - to);
    if rest > 0.0 && rest < SPLINTER_SHARE * length && found.fits() {
        let half = attempt([from, from + 0.5 * (length + rest)]);
        return half.filter(SegmentCandidate::fits).or(Some(found));
    }
    Some(found)
}

/// Searches without regard to the remainder.
fn search<'m>(
    reach: SearchBounds,
    attempt: &mut impl FnMut([f64; 2]) -> Option<SegmentCandidate<'m>>,
) -> Option<SegmentCandidate<'m>> {
    let most = reach.limit - reach.from;
    let floor = reach.floor.min(most);
    let mut best: Option<SegmentCandidate<'m>> = None;
    let mut too_long = f64::INFINITY;
    let mut length = reach.guess.clamp(floor, most);
    for _ in 0..MOST_TRIALS {
        // A remainder that is hardly longer is included: exactly to the limit.
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
            // The target is outside the open interval.
            length = if fitting > 0.0 { (fitting * too_long).sqrt() } else { (0.5 * too_long).max(floor) };
        }
    }
    best.or_else(|| attempt([reach.from, reach.from + floor]))
}
