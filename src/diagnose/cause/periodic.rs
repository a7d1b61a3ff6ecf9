//! Errors that repeat with a pitch, fixed in position: ball screw, scale, rotary encoder (ISO 230-2).

use std::f64::consts::TAU;

use super::{Candidate, Cause, Correctable, Effect, Weight};
use crate::diagnose::scene::{Scene, Through};
use crate::geometry::Axis;
use crate::model::name::{DIRECTIONS, ErrorName};

pub(super) const CAUSE: Cause = Cause {
    name: "periodic error",
    effect: Effect::Periodic,
    made_by: "pitch of the screw, interpolation of the scale, an eccentric encoder",
    shown_by: "fine steps along the axis; ball-bar: ripples that stay at their places at another feed",
    separate_by: "another feed: what vibrates moves along the path, what is periodic in position stays",
    correctable: Correctable::Program,
    propose,
};

/// Harmonics of a turn.
const HARMONICS: u8 = 4;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in scene.machine.axes.iter().flatten().map(|data| data.axis) {
        // Harmonics of the turn; what a linear axis repeats with is searched ([`crate::diagnose::sweep`]).
        for harmonic in (1..=HARMONICS).filter(|_| axis.is_rotary()) {
            for name in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
                out.push(candidate(name, axis, TAU / f64::from(harmonic)));
            }
        }
    }
}

/// A sine and a cosine.
pub(in crate::diagnose) fn candidate(name: ErrorName, axis: Axis, period: f64) -> Candidate {
    let through = Through::Component(name);
    let sine = Weight::new(move |row| (TAU * row.position[axis] / period).sin());
    let cosine = Weight::new(move |row| (TAU * row.position[axis] / period).cos());
    let mut one = Candidate::one(&CAUSE, name, through, sine).driven_by(&[&axis]);
    one.columns.push(vec![(through, cosine)]);
    one.constant = Some(if axis.is_rotary() { (period.to_degrees(), "deg") } else { (period, "mm") });
    one
}
