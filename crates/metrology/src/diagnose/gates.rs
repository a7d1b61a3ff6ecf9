//! Acceptance tests: significance, gain on unseen parts, data held out.

use super::cause::{Candidate, EffectKind};
use super::fold::{confirmed, counts, worth};
use super::held_out::{Selections, unseen};
use super::readings::{doing, rms};
use super::rejected::{Gate, Rejections};
use super::search::{Field, Taken, Weights};
use super::slow;

/// Largest accepted p-value of a finding, corrected for the number of candidates.
pub(super) const LIMIT: f64 = 1e-3;
/// Held-out data test a finding only if its effect there is at least this share of its effect in the data used.
const EXERCISED: f64 = 0.1;

/// Applies the tests for significance and gain on unseen parts.
pub(super) fn confirm(
    field: &mut Field<'_, '_>,
    weights: &Weights,
    taken: Vec<usize>,
    (selections, rejections): (&mut Selections, &mut Rejections),
    note: &mut dyn FnMut(&str, f64),
) -> Vec<(Taken, f64)> {
    let judged = field.backward(weights, taken, LIMIT, &mut |out| rejections.add(out, Gate::Chance, None));
    let judged = slow::named(field, weights, judged);
    let judged = slow::stand(field, weights, judged, LIMIT, &mut |out| rejections.add(out, Gate::Chance, None));
    let mut out = |term: &Taken, gain| rejections.add(term, Gate::Unseen, gain);
    confirmed(field, weights, judged, selections, &mut out, &mut |share| note("held-out parts", share))
}

/// True for causes that belong to one day or one set-up: other data cannot confirm them.
fn is_only_here(one: &Candidate) -> bool {
    // The phase of a vibration differs from day to day.
    matches!(
        one.cause.effect,
        EffectKind::Setup
            | EffectKind::Earlier
            | EffectKind::Sensor
            | EffectKind::Outlier
            | EffectKind::Program
            | EffectKind::Drift
    ) || (one.cause.effect == EffectKind::Dynamic && one.drivers.iter().all(|driver| driver == "t_s"))
}

/// Removes the terms that the held-out data do not confirm, and records their gains there.
pub(super) fn hold(
    field: &Field<'_, '_>,
    weights: &Weights,
    held_out: &Weights,
    kept: &mut Vec<(Taken, f64)>,
    rejections: &mut Rejections,
) -> Vec<Candidate> {
    let scene = field.scene;
    let mut out = Vec::new();
    if counts(scene, held_out).is_empty() {
        return out;
    }
    loop {
        let taken: Vec<usize> = kept.iter().map(|(term, _)| term.candidate).collect();
        let with = unseen(field, weights, held_out, &taken);
        let mut worst: Option<(f64, usize)> = None;
        for (place, (term, gain)) in kept.iter_mut().enumerate() {
            let number = term.candidate;
            let size = |on: &Weights| {
                let does = doing(field, weights, on, &taken, number);
                rms(counts(scene, on).into_iter().filter_map(|place| does.get(place).copied()))
            };
            let is_drift = field.candidates.get(number).is_some_and(|one| one.cause.effect == EffectKind::Drift);
            // The drift of another day may differ, but a term that worsens the prediction is rejected.
            let least_gain = if is_drift { 0.0 } else { worth(field, number) };
            let is_local = field.candidates.get(number).is_some_and(is_only_here) && !is_drift;
            if is_local || size(held_out) < EXERCISED * size(weights) {
                continue;
            }
            // The others are fitted again without it, so only its own contribution counts.
            let others: Vec<usize> = taken.iter().copied().filter(|&other| other != number).collect();
            let without = unseen(field, weights, held_out, &others);
            *gain = if without > 0.0 { 1.0 - (with / without).sqrt() } else { 0.0 };
            if *gain < least_gain && worst.is_none_or(|(least, _)| *gain < least) {
                worst = Some((*gain, place));
            }
        }
        let Some((_, place)) = worst else { return out };
        let (term, gain) = kept.remove(place);
        rejections.add(&term, Gate::HeldOut, Some(gain));
        out.extend(field.candidates.get(term.candidate).cloned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::scene::Through;

    #[test]
    fn a_day_a_set_up_and_a_vibration_are_only_here() {
        let of =
            |effect: EffectKind, driver: &str| bench::candidate(effect, Through::Tip(0), |_| 1.0).driven_by(&[&driver]);
        assert!(is_only_here(&of(EffectKind::Setup, "setup")) && is_only_here(&of(EffectKind::Drift, "t_s")));
        // A vibration depends on time only; compliance under acceleration is reproducible.
        assert!(is_only_here(&of(EffectKind::Dynamic, "t_s")) && !is_only_here(&of(EffectKind::Dynamic, "X_acc")));
        assert!(!is_only_here(&of(EffectKind::Motion, "t_s")));
    }
}
