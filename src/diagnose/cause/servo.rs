//! What the servo loops leave: lag of one axis behind the other, of all behind the command, deflection by acceleration.
//!
//! An axis that lags by τ is at −τ v from its command; two of them with one lag make no error of the path but along it.

use super::{Candidate, Cause, Correctable, Effect, Weight};
use crate::diagnose::scene::{Scene, Through};
use crate::geometry::{Axis, AxisVector};

pub(super) const MISMATCH: Cause = Cause {
    name: "servo mismatch",
    effect: Effect::ServoMismatch,
    made_by: "velocity gains that differ",
    shown_by: "ball-bar: an oval at 45° that turns over with the sense and grows with the feed",
    separate_by: "the other sense of the same circle",
    correctable: Correctable::No,
    propose: mismatch,
};

pub(super) const FOLLOWING: Cause = Cause {
    name: "following error",
    effect: Effect::Following,
    made_by: "velocity gain without feed-forward",
    shown_by: "traces: set point less encoder grows with the velocity; ball-bar: circles shrink with the square of the feed",
    separate_by: "two feeds tell it from the length of the bar",
    correctable: Correctable::No,
    propose: following,
};

pub(super) const DYNAMIC: Cause = Cause {
    name: "deflection by acceleration",
    effect: Effect::Dynamic,
    made_by: "inertia and a frame that gives way",
    shown_by: "errors at corners and small circles that grow with the acceleration",
    separate_by: "encoders: a lag shows in them, a deflection does not",
    correctable: Correctable::No,
    propose: dynamic,
};

/// Linear axes of which it is known how fast they go.
fn moving(scene: &Scene<'_>, of: fn(&crate::diagnose::row::Row) -> Option<AxisVector>) -> Vec<Axis> {
    let axes = scene.machine.axes.iter().flatten().map(|data| data.axis).filter(|axis| !axis.is_rotary());
    axes.filter(|&axis| scene.rows.iter().any(|row| of(row).is_some_and(|value| value[axis] != 0.0))).collect()
}

/// Feeds must differ for these to be no geometry.
fn mismatch(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes = moving(scene, |row| row.velocity);
    for (place, &one) in axes.iter().enumerate() {
        for &other in axes.iter().skip(place + 1) {
            let lag = |axis: Axis, sign: f64| {
                let weight = Weight::new(move |row| sign * row.velocity.map_or(0.0, |velocity| velocity[axis]) / 2.0);
                (Through::Component(super::own(axis)), weight)
            };
            let (through, weight) = lag(one, -1.0);
            let mut candidate = Candidate::one(&MISMATCH, format!("{one}{other}"), through, weight.clone());
            candidate.drivers = vec![one.to_string(), other.to_string(), "feed_mm_min".into()];
            // The amounts of both are one number: the difference of the lags.
            candidate.columns = vec![vec![(through, weight), lag(other, 1.0)]];
            out.push(candidate);
        }
    }
}

fn following(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in moving(scene, |row| row.velocity) {
        let weight = Weight::new(move |row| -row.velocity.map_or(0.0, |velocity| velocity[axis]));
        let one = Candidate::one(&FOLLOWING, axis, Through::Component(super::own(axis)), weight);
        out.push(one.driven_by(&[&axis, &"feed_mm_min"]));
    }
}

fn dynamic(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in moving(scene, |row| row.acceleration) {
        for direction in 0..3 {
            let weight = Weight::new(move |row| row.acceleration.map_or(0.0, |acceleration| acceleration[axis]));
            let letter = ["X", "Y", "Z"][direction];
            let one = Candidate::one(&DYNAMIC, format!("{axis}{letter}"), Through::Tip(direction), weight);
            out.push(one.driven_by(&[&axis, &"feed_mm_min"]));
        }
    }
}
