//! Vibration: a wave in time that continues while the axes move, whatever their path.

use std::f64::consts::TAU;

use super::{Candidate, Cause, Correctable, EffectKind, Weight, tip};
use crate::diagnose::scene::Through;

pub(super) const CAUSE: Cause = Cause {
    name: "forced vibration",
    effect: EffectKind::Dynamic,
    made_by: "a fan, a pump, the spindle",
    shown_by: "ripples that move along the path at another feed: a line in the spectrum over time",
    separate_by: "another feed: an error that is periodic in position does not move",
    correctable: Correctable::No,
    // Periods in time are searched in [`crate::diagnose::sweep`].
    propose: |_, _| {},
};

/// A sine and a cosine of a frequency, Hz, in a direction.
pub(in crate::diagnose) fn candidate(direction: usize, frequency: f64) -> Candidate {
    let wave = |of: fn(f64) -> f64| Weight::new(move |row| row.time_s.map_or(0.0, |time| of(TAU * frequency * time)));
    let through = Through::Tip(direction);
    let mut one = Candidate::one(&CAUSE, tip(direction), through, wave(f64::sin)).driven_by(&[&"t_s"]);
    one.columns.push(vec![(through, wave(f64::cos))]);
    one.constant = Some((1.0 / frequency, "s period"));
    one
}
