//! The end of the next piece of a move: for arcs the longest that fits, for fixed steps by the axis that moves farthest.

use super::Feeds;
use super::extend::{SearchBounds, longest};
use super::segment_candidate::{BEND_SHARE, SegmentCandidate, SegmentFitter};
use super::standing::PathState;

/// Largest sweep of a piece of an arc that is not a full circle, rad: near a full turn, rounding could swap start and end.
const MOST_SWEEP: f64 = 330.0 * std::f64::consts::PI / 180.0;
/// Tolerance within which a sweep counts as a full turn, rad.
const SAME_ANGLE: f64 = 1e-7;
/// Minimum number of chords that an arc piece must save to be useful.
const USEFUL_CHORDS: f64 = 3.0;
/// Shortest piece of an arc, in increments. A control rounds both ends to its grid, and equal ends are a full circle: rounding and correction change the
/// distance by less than three increments.
const SHORTEST_ARC: f64 = 4.0;
/// Grid of a control whose programs may have finer words, mm: a Sinumerik as delivered has 1000 increments per mm (MD10200).
const USUAL_GRID_MM: f64 = 1e-3;
/// Maximum halvings of a piece that turns rotary corrections too far.
const MOST_HALVINGS: u32 = 8;
/// Largest written feed, mm/min or 1/min: controls accept six digits before the point. No axis is as fast.
pub(super) const MOST_FEED: f64 = 999_999.0;
/// Largest reciprocal time that a Fanuc reads, 1/min (B-62764EN, inverse time: 0.001 to 9999.999). Such a block takes 6 ms.
const MOST_INVERSE_OF_FANUC: f64 = 9999.999;
/// Parameters nearer to each other than this are one place.
const SAME_PARAMETER: f64 = 1e-9;

/// The straight line in place of an arc that is so short that a control might mill a full circle; `None` if the arc is longer, or the line does not fit.
pub(super) fn line_for_short_arc<'m>(
    bench: &SegmentFitter<'_, 'm>,
    standing: &PathState,
    between: [f64; 2],
    scratch: &mut Vec<f64>,
) -> Option<SegmentCandidate<'m>> {
    let shortest_mm = SHORTEST_ARC * bench.placer.increments.linear_mm.max(USUAL_GRID_MM);
    let length_mm = bench.route.sweep_rad().abs() * bench.route.radius_mm() * (between[1] - between[0]);
    (length_mm < shortest_mm).then(|| bench.straight(standing, between, scratch)).filter(SegmentCandidate::fits)
}

/// The longest useful arc between two parameters of the move, beginning at the first; `None` if chords serve equally well. `guess` is the initial
/// length of the search.
pub(super) fn fit_arc<'m>(
    bench: &SegmentFitter<'_, 'm>,
    standing: &PathState,
    within: [f64; 2],
    guess: f64,
    scratch: &mut Vec<f64>,
) -> Option<SegmentCandidate<'m>> {
    let [from, limit] = within;
    let swept = bench.route.sweep_rad().abs();
    if from == 0.0 && limit >= 1.0 {
        let whole = bench.arc(standing, [0.0, 1.0], scratch);
        if whole.is_some_and(|trial| trial.fits()) {
            return whole;
        }
    }
    let turn = std::f64::consts::TAU / swept;
    let full_turn = from + turn;
    if full_turn <= limit + SAME_ANGLE / swept {
        let to = if full_turn > 1.0 - SAME_PARAMETER { 1.0 } else { full_turn };
        let circle = bench.arc(standing, [from, to], scratch);
        if circle.is_some_and(|trial| trial.fits()) {
            return circle;
        }
    }
    // Half the angle of a chord whose sag is the tolerance.
    let half_chord = (1.0 - bench.tolerance_mm / bench.route.radius_mm()).max(-1.0).acos();
    let reach = SearchBounds {
        from,
        limit: limit.min(from + MOST_SWEEP / swept),
        guess,
        floor: USEFUL_CHORDS * 2.0 * half_chord / swept,
        order: 3.0,
    };
    longest(reach, |between| bench.arc(standing, between, scratch)).filter(SegmentCandidate::fits)
}

/// The longest straight piece that fits. `first` is the candidate over the whole range, if available. If a piece turns rotary corrections too far for
/// one block, it is shortened. If no shorter one helps, as after a step of the errors, length is not the reason.
pub(super) fn fit_line<'m>(
    bench: &SegmentFitter<'_, 'm>,
    standing: &PathState,
    reach: SearchBounds,
    mut first: Option<SegmentCandidate<'m>>,
    scratch: &mut Vec<f64>,
) -> Option<SegmentCandidate<'m>> {
    let mut found =
        longest(reach, |between| first.take().or_else(|| Some(bench.straight(standing, between, scratch))))?;
    if !found.fits() {
        // The shortest piece has a deviation that does not come from its length: a piece with hardly more is as good.
        let enough_mm = (1.0 + BEND_SHARE) * found.deviation_mm;
        let enough_tilt = (1.0 + BEND_SHARE) * found.tilt_share.max(1.0);
        let reach = SearchBounds { guess: reach.limit - reach.from, ..reach };
        found = longest(reach, |between| {
            let trial = bench.straight(standing, between, scratch);
            let tilt_share = trial.tilt_share / enough_tilt;
            Some(SegmentCandidate { allowed_mm: trial.allowed_mm.max(enough_mm), tilt_share, ..trial })
        })?;
    }
    let mut shorter = found;
    for _ in 0..MOST_HALVINGS {
        let half = 0.5 * (shorter.between[1] - reach.from);
        if !shorter.end.is_held_back || half < reach.floor {
            break;
        }
        shorter = bench.straight(standing, [reach.from, reach.from + half], scratch);
    }
    Some(if shorter.end.is_held_back { found } else { shorter })
}

/// The end of a piece of fixed length along the axis that moves farthest, by `leading_mm` over the whole path.
pub(super) fn next_step(leading_mm: f64, from: f64, step_mm: f64) -> f64 {
    let steps = (from * leading_mm / step_mm + SAME_PARAMETER).floor() + 1.0;
    let to = steps * step_mm / leading_mm;
    if to < 1.0 - SAME_PARAMETER { to } else { 1.0 }
}

/// Scales a reciprocal time to a share of the move; a step without duration keeps the value of the move. The result is one that the control reads.
pub(super) fn of_share(feed: f64, share: f64, feeds: Feeds) -> f64 {
    let most = if feeds == Feeds::OfAll { MOST_INVERSE_OF_FANUC } else { MOST_FEED };
    let of_share = if share > 0.0 && share < 1.0 { feed / share } else { feed };
    ((of_share * 1e6).round() / 1e6).min(most.max(feed))
}
