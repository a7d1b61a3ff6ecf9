//! A peak behind the turn of an axis: it sticks until the controller has built up the force, and follows late.

use super::{Candidate, Cause, Correctable, Effect, Weight, own};
use crate::diagnose::scene::{Scene, Through};

pub(super) const CAUSE: Cause = Cause {
    name: "reversal spike",
    effect: Effect::ReversalSpike,
    made_by: "friction and a loop that takes its time",
    shown_by: "ball-bar: short peaks outwards behind each turn, higher at higher feed",
    separate_by: "repeat it: a spike comes again at its place, a false reading does not",
    correctable: Correctable::No,
    propose,
};

/// Lengths over which it fades, mm of the axis.
const FADES: [f64; 5] = [0.02, 0.1, 0.3, 1.0, 3.0];

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let linear = scene.machine.axes.iter().flatten().map(|data| data.axis).filter(|axis| !axis.is_rotary());
    for axis in linear.filter(|&axis| scene.rows.iter().any(|row| row.since_turn[axis].is_finite())) {
        for fade in FADES {
            let weight = Weight::new(move |row| -row.sense_of(axis) * (-row.since_turn[axis] / fade).exp());
            let mut one = Candidate::one(&CAUSE, own(axis), Through::Component(own(axis)), weight);
            one.constant = Some((fade, "mm"));
            out.push(one.driven_by(&[&format!("{axis}_dir"), &axis]));
        }
    }
}
