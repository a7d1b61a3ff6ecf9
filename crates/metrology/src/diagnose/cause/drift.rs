//! Displacement with time without a known temperature: creep, and events such as an opened door.

use super::{Candidate, Cause, Correctable, EffectKind, Weight, tip};
use crate::diagnose::scene::{Scene, Through};

pub(super) const CAUSE: Cause = Cause {
    name: "drift with time",
    effect: EffectKind::Drift,
    made_by: "warm-up, creep of the set-up",
    shown_by: "readings of the same pose at different times",
    separate_by: "temperature sensors; the poses in another order",
    correctable: Correctable::No,
    propose,
};

pub(super) const EVENT: Cause = Cause {
    name: "drift after an event",
    effect: EffectKind::Drift,
    made_by: "coolant, an opened door, a cold workpiece",
    shown_by: "a step in the readings of one pose that decays",
    separate_by: "a log of events with times; repeat the measurement",
    correctable: Correctable::No,
    propose: |_, _| {},
};

/// Highest degree of the polynomial in time.
const DEGREES: usize = 3;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let Some([start, end]) = super::times(scene) else { return };
    let weights: Vec<Weight> = (1..=DEGREES as i32)
        .map(|degree| {
            Weight::new(move |row| row.time_s.map_or(0.0, |time| ((time - start) / (end - start)).powi(degree)))
        })
        .collect();
    for direction in 0..3 {
        for count in 1..=DEGREES {
            let mut one = Candidate::one(&CAUSE, tip(direction), Through::Tip(direction), Weight::new(|_| 0.0));
            one.columns =
                weights.iter().take(count).map(|weight| vec![(Through::Tip(direction), weight.clone())]).collect();
            out.push(one.driven_by(&[&"t_s"]));
        }
    }
}

/// Displacement that decays after an instant, s, in one measurement, with a time constant `fade`, s.
pub(in crate::diagnose) fn behind(direction: usize, set: usize, instant: f64, fade: f64) -> Candidate {
    let weight = Weight::new(move |row| {
        let since = row.time_s.filter(|&time| row.set == set && time >= instant);
        since.map_or(0.0, |time| (-(time - instant) / fade).exp())
    });
    let mut one = Candidate::one(&EVENT, tip(direction), Through::Tip(direction), weight);
    one.constant = Some((fade, "s"));
    one.driven_by(&[&"t_s"])
}
