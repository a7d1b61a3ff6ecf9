//! Displacement with time without a known temperature: creep, and events such as an opened door.

use std::collections::BTreeMap;

use super::{Candidate, Cause, Correctable, EffectKind, Weight, tip};
use crate::diagnose::nature::ORDER;
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::{Scene, Through};
use ncfix_base::geometry::Axis;

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
/// Highest degree of the polynomial in the time of a run.
const IN_RUNS: usize = 2;
/// Minimum number of rows of a run.
const LEAST_ROWS: usize = 3;
/// Positions nearer to each other than this are one, mm.
const SAME_PLACE_MM: f64 = 1e-3;
/// Maximum number of measurements without times whose order of rows is tested.
const MOST_SETS: usize = 8;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    in_each_run(scene, out);
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

/// Proposes a drift that begins again in each run, for measurements whose runs are lines along an axis in one direction only: the drift then grows with the position, as a
/// scale does, and no run with the opposite direction separates them.
fn in_each_run(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let sets = scene.sets.iter().enumerate().filter(|(_, data)| data.is_in_order);
    let sets: Vec<usize> = sets.map(|(set, _)| set).take(MOST_SETS + 1).collect();
    if sets.len() > MOST_SETS {
        return;
    }
    let shares: Vec<(usize, Vec<f64>)> =
        sets.into_iter().filter_map(|set| Some((set, shares_of_runs(scene, set)?))).collect();
    let has_times = |set: &usize| scene.rows.iter().any(|row| row.set == *set && row.time_s.is_some());
    let driver = |sets: &[(usize, Vec<f64>)]| if sets.iter().all(|(set, _)| has_times(set)) { "t_s" } else { ORDER };
    let each = shares.iter().map(std::slice::from_ref);
    let together = (shares.len() > 1).then_some(shares.as_slice());
    for some in each.chain(together) {
        let (driver, some) = (driver(some), some.to_vec());
        let share = move |row: &SceneRow| {
            let own = some.iter().find(|(set, _)| *set == row.set);
            own.and_then(|(_, shares)| shares.get(row.number)).copied()
        };
        polynomials(driver, IN_RUNS, share, out);
    }
}

/// The share of each row in the time of its run, 0 to 1 in the longest one; `None` if the runs do not all pass an axis in the same direction. Without times, the
/// rows of a run count as equally far apart.
fn shares_of_runs(scene: &Scene<'_>, set: usize) -> Option<Vec<f64>> {
    let mut runs: BTreeMap<(usize, usize), Vec<&SceneRow>> = BTreeMap::new();
    for row in scene.rows.iter().filter(|row| row.set == set) {
        runs.entry((row.setup, row.run)).or_default().push(row);
    }
    if runs.len() < 2 || runs.values().any(|run| run.len() < LEAST_ROWS) {
        return None;
    }
    let ways = |axis: Axis, sense: f64| {
        let is_one_way = |run: &Vec<&SceneRow>| {
            let mut steps = run.windows(2).map(|pair| sense * (pair[1].position[axis] - pair[0].position[axis]));
            let ends =
                run.last().zip(run.first()).map_or(0.0, |(last, first)| last.position[axis] - first.position[axis]);
            steps.all(|step| step > -SAME_PLACE_MM) && sense * ends > SAME_PLACE_MM
        };
        runs.values().all(is_one_way)
    };
    let axis = super::linear(scene).find(|axis| ways(*axis, 1.0) || ways(*axis, -1.0))?;
    // A grid returns along one axis again and again, so it is no line.
    let is_line = |run: &Vec<&SceneRow>| {
        let stays =
            |other: Axis| run.iter().all(|row| (row.position[other] - run[0].position[other]).abs() < SAME_PLACE_MM);
        super::axes(scene).all(|other| other == axis || stays(other))
    };
    if !runs.values().all(is_line) {
        return None;
    }
    let since = |run: &[&SceneRow], k: usize| -> Option<f64> {
        let [first, row] = [run.first()?, run.get(k)?];
        Some(match (first.time_s, row.time_s) {
            (Some(start), Some(time)) => time - start,
            _ => row.number as f64 - first.number as f64,
        })
    };
    let longest = runs.values().filter_map(|run| since(run, run.len() - 1)).fold(0.0, f64::max);
    let count = runs.values().flatten().map(|row| row.number + 1).max()?;
    let mut shares = vec![0.0; count];
    for run in runs.values().filter(|_| longest > 0.0) {
        for (k, row) in run.iter().enumerate() {
            if let (Some(share), Some(since)) = (shares.get_mut(row.number), since(run, k)) {
                *share = since / longest;
            }
        }
    }
    Some(shares)
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
