//! Rivals that the data cannot tell apart, and the one measurement that would.

use super::cause::{Candidate, Effect};

/// Steps in the shortest period.
const STEPS: f64 = 3.0;
/// A step that shows all pitches of screws, mm.
const MOST_STEP: f64 = 2.0;

/// What tells a cause from its first rival.
pub(super) fn separating(one: &Candidate, rival: &Candidate) -> String {
    // The order of the two does not matter.
    let pair = [one.cause.effect, rival.cause.effect];
    let is = |a, b| pair == [a, b] || pair == [b, a];
    let both = |a| pair == [a, a];
    let known = if is(Effect::Location, Effect::ServoMismatch) {
        "the same circle in the other sense: squareness stays, a mismatch of the servos turns over"
    } else if is(Effect::Backlash, Effect::Following) || is(Effect::Backlash, Effect::Delay) {
        "the same line at twice the feed: a lag doubles, backlash stays"
    } else if is(Effect::Backlash, Effect::LateralPlay) || both(Effect::LateralPlay) || both(Effect::Backlash) {
        "forth and back with two tool lengths, and with an indicator along and across: a turn of the carriage grows with the tool"
    } else if is(Effect::Motion, Effect::ThermalExpansion) || is(Effect::Location, Effect::ThermalSquareness) {
        "the same lines at another temperature"
    } else if is(Effect::Motion, Effect::Setup) {
        "the same line with the artefact shifted along it and turned by 90°"
    } else if is(Effect::Motion, Effect::Cross) {
        "lines at three places of the other axis"
    } else if is(Effect::Motion, Effect::Periodic) {
        "steps of an eighth of the period over three periods"
    } else if is(Effect::Motion, Effect::Location) {
        "lines at two heights, and at the ends of the other axis"
    } else if both(Effect::Motion) {
        "the same lines with a second tool length, and at a second height: angles grow with the arm, straightness does not"
    } else if both(Effect::Location) {
        "the same poses with a second tool length, and the artefact turned by 90°"
    } else if is(Effect::ThermalDrift, Effect::Drift) || both(Effect::ThermalDrift) || both(Effect::Drift) {
        "a run in which the temperatures do not rise together: spindle on and off by chance, then cooling"
    } else if is(Effect::ThermalDrift, Effect::ThermalExpansion) {
        "two poses far apart along the axis, in turn, while it warms up"
    } else if both(Effect::ServoMismatch) || is(Effect::ServoMismatch, Effect::Following) || both(Effect::Following) {
        "circles in the planes of the other axes at the same feed"
    } else if is(Effect::Following, Effect::Dynamic) {
        "another radius at the same feed: a lag goes with the velocity, a deflection with its square over the radius"
    } else if is(Effect::Periodic, Effect::Dynamic) {
        "another feed: what vibrates moves along the path, what is periodic in position stays"
    } else {
        return one.cause.separate_by.to_owned();
    };
    known.to_owned()
}

/// A wave with another period, by the name of its component.
pub(super) fn every(parameter: &str, period: f64) -> String {
    format!("{parameter} every {} mm", hundredths(period))
}

/// What tells a wave from one of a shorter period that is the same at the places that were measured.
pub(super) fn steps(one: &Candidate, shortest: f64) -> String {
    let longest = one.constant.map_or(shortest, |(period, _)| period.max(shortest));
    let step = hundredths((shortest / STEPS).min(MOST_STEP));
    format!(
        "the same line at points of uneven spacing, or every {step} mm over {} mm",
        hundredths((3.0 * longest / step).ceil() * step)
    )
}

fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
