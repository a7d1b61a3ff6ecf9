//! A peak behind the turn of an axis: it sticks until the controller has built up the force, and follows late.

use super::{Candidate, Cause, Correctable, EffectKind, Weight, own};
use crate::diagnose::scene::{Scene, Through};

pub(super) const CAUSE: Cause = Cause {
    name: "reversal spike",
    effect: EffectKind::ReversalSpike,
    made_by: "friction and a slow control loop",
    shown_by: "ball-bar: short outward peaks after each reversal, higher at higher feed",
    separate_by: "repeat it: a spike recurs at its position, a false reading does not",
    correctable: Correctable::No,
    propose,
};

/// Ways of the tool over which it fades, mm.
const FADES: [f64; 7] = [0.5, 1.0, 2.0, 3.0, 4.2, 5.8, 8.0];

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in super::linear(scene) {
        if !scene.rows.iter().any(|row| row.way_since_turn[axis].is_finite()) {
            continue;
        }
        for fade in FADES {
            let weight = Weight::new(move |row| -row.sense_of(axis) * (-row.way_since_turn[axis] / fade).exp());
            let mut one = Candidate::one(&CAUSE, axis, Through::Component(own(axis)), weight);
            one.constant = Some((fade, "mm"));
            out.push(one.driven_by(&[&axis, &format!("{axis}_dir")]));
        }
    }
}
