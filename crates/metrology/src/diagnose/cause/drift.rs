//! Displacement with time without a known temperature: creep, and events such as an opened door.

use super::{Candidate, Cause, Correctable, EffectKind, Weight, tip};
use crate::diagnose::nature::ORDER;
use crate::diagnose::row::SceneRow;
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
/// Maximum number of measurements without times whose order of rows is tested.
const MOST_SETS: usize = 8;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    if let Some([start, end]) = super::times(scene) {
        let share = move |row: &SceneRow| row.time_s.map(|time| (time - start) / (end - start));
        polynomials("t_s", DEGREES, share, out);
    }
    // Where no time was noted, the rows stand in the order of the readings, mostly at about equal intervals, unless the description denies it. Each measurement was at another time.
    let is_in_order = |set: &usize| scene.sets.get(*set).is_some_and(|data| data.is_in_order);
    let has_no_time = |set: &usize| scene.rows.iter().all(|row| row.set != *set || row.time_s.is_none());
    let sets: Vec<usize> = (0..scene.sets.len()).filter(is_in_order).filter(has_no_time).take(MOST_SETS + 1).collect();
    if sets.len() > MOST_SETS {
        return;
    }
    let degrees = if sets.len() == 1 { DEGREES } else { 1 };
    for set in sets {
        let last = scene.rows.iter().filter(|row| row.set == set).map(|row| row.number).max().unwrap_or(0) as f64;
        let share = move |row: &SceneRow| (row.set == set && last > 0.0).then(|| row.number as f64 / last);
        polynomials(ORDER, degrees, share, out);
    }
}

/// Proposes displacements by polynomials of a share, from 0 at the first reading to 1 at the last one.
fn polynomials(
    driver: &str,
    degrees: usize,
    share: impl Fn(&SceneRow) -> Option<f64> + Clone + Send + Sync + 'static,
    out: &mut Vec<Candidate>,
) {
    let weights: Vec<Weight> = (1..=degrees as i32)
        .map(|degree| {
            let share = share.clone();
            Weight::new(move |row| share(row).map_or(0.0, |share| share.powi(degree)))
        })
        .collect();
    for direction in 0..3 {
        for count in 1..=degrees {
            let mut one = Candidate::one(&CAUSE, tip(direction), Through::Tip(direction), Weight::new(|_| 0.0));
            one.columns =
                weights.iter().take(count).map(|weight| vec![(Through::Tip(direction), weight.clone())]).collect();
            out.push(one.driven_by(&[&driver]));
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
