//! Displacement with the spindle speed, if no temperature of the spindle was measured: immediate, as bearings and tapers widen, and delayed, as they
//! warm up.
//!
//! A spindle that is cold at the first reading warms up with its speed and a time constant. Readings are relative to the first one of each run, where
//! the instrument was set to zero.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Candidate, Cause, Correctable, EffectKind, Values, Weight, column, tip};
use crate::diagnose::scene::{Scene, Through};

pub(super) const CAUSE: Cause = Cause {
    name: "displacement with the spindle speed",
    effect: EffectKind::SpindleSpeed,
    made_by: "heat of the bearings, centrifugal expansion, compliance of the drawbar",
    shown_by: "readings of one pose at several spindle speeds, from cold",
    separate_by: "a temperature sensor at the spindle nose; speeds in random order, each until the displacement is constant",
    correctable: Correctable::No,
    propose,
};

/// Name of the column.
const SPEED: &str = "spindle_rpm";
/// Amounts are per this speed, 1/min.
const UNIT_RPM: f64 = 1e3;
/// Time of the speed change between two readings, as the share of the interval after the change: unknown, with the later reading, with the earlier
/// one.
pub(super) const CHANGES: [f64; 3] = [0.5, 0.0, 1.0];
/// Tested time constants, s: from a nose to a headstock. They are refined afterwards.
const LAGS_S: [f64; 7] = [60.0, 180.0, 420.0, 900.0, 1800.0, 3600.0, 7200.0];

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let Some(speeds) = column(scene.sets, SPEED) else { return };
    let mut all = speeds.iter().flatten().filter(|speed| speed.is_finite());
    let first = all.next();
    if !all.any(|speed| Some(speed) != first) {
        return;
    }
    for direction in 0..3 {
        // Centrifugal forces grow with the square of the speed.
        for power in 1..=2 {
            let at_once = of_runs(scene, &speeds, |row, _| row.powi(power));
            out.push(candidate(direction, &at_once, None));
        }
        for lag_s in LAGS_S {
            if let Some(values) = followed(scene, &speeds, lag_s, CHANGES[0]) {
                out.push(candidate(direction, &values, Some(lag_s)));
            }
        }
    }
}

fn candidate(direction: usize, values: &Values, lag_s: Option<f64>) -> Candidate {
    let weight = Weight::of_column(Arc::clone(values), |value| value);
    let mut one = Candidate::one(&CAUSE, tip(direction), Through::Tip(direction), weight);
    one.constant = lag_s.map(|lag_s| (lag_s, "s"));
    one.driven_by(&[&SPEED])
}

/// The candidate with another time constant, s, and another time of the speed change.
pub(super) fn with_lag(scene: &Scene<'_>, one: &Candidate, lag_s: f64, change: f64) -> Option<Candidate> {
    let Some((Through::Tip(direction), _)) = one.columns.first()?.first() else { return None };
    let values = followed(scene, &column(scene.sets, SPEED)?, lag_s, change)?;
    Some(candidate(*direction, &values, Some(lag_s)))
}

/// Shortest and longest time constant around a tested one, s.
pub(super) fn around(lag_s: f64) -> [f64; 2] {
    [lag_s / 2.5, 2.5 * lag_s]
}

/// The speed followed with a time constant, by measurement and row; `None` without times.
fn followed(scene: &Scene<'_>, speeds: &Values, lag_s: f64, change: f64) -> Option<Values> {
    if scene.rows.iter().any(|row| row.time_s.is_none()) {
        return None;
    }
    Some(of_runs(scene, speeds, |speed, step| {
        let Some((before, level, seconds)) = step else { return 0.0 };
        level + (before + change * (speed - before) - level) * (1.0 - (-seconds / lag_s).exp())
    }))
}

/// Values by measurement and row, relative to the first reading of each run. `of` gets the speed and, except at the first reading of a measurement,
/// the previous speed and value and the time since then, s.
fn of_runs(scene: &Scene<'_>, speeds: &Values, of: impl Fn(f64, Option<(f64, f64, f64)>) -> f64) -> Values {
    let by_set = scene.sets.iter().enumerate().map(|(number, set)| {
        let own = speeds.get(number).map_or(&[][..], Vec::as_slice);
        let mut places: Vec<usize> = (0..set.observations.len().min(own.len())).collect();
        let time = |place: usize| set.observations.get(place).and_then(|one| one.t_s).unwrap_or(0.0);
        places.sort_by(|&one, &other| time(one).total_cmp(&time(other)));
        let mut out = vec![f64::NAN; own.len()];
        let mut zeros: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        let mut before = None;
        for place in places {
            let speed = own[place] / UNIT_RPM;
            if !speed.is_finite() {
                continue;
            }
            let level = of(speed, before.map(|(speed, level, at)| (speed, level, time(place) - at)));
            before = Some((speed, level, time(place)));
            let run = set.observations.get(place).map_or((0, 0), |one| (one.setup, one.run));
            out[place] = level - *zeros.entry(run).or_insert(level);
        }
        out
    });
    Arc::new(by_set.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn a_body_follows_the_speed_from_the_first_reading_of_a_run() {
        let machine = bench::machine();
        let rows = "t_s,X,Y,Z,spindle_rpm,dx_um,dy_um,dz_um\n0,0,0,0,0,0,0,0\n100,0,0,0,6000,0,0,0\n200,0,0,0,6000,0,0,0\n300,0,0,0,0,0,0,0\n";
        let sets = [bench::table(&machine, rows, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")];
        let scene = bench::scene(&machine, &sets);
        let mut found = Vec::new();
        propose(&scene, &mut found);
        // Two immediate powers and seven time constants, in three directions.
        assert_eq!(found.len(), 27);
        let weights =
            |one: &Candidate| -> Vec<f64> { scene.rows.iter().map(|row| one.columns[0][0].1.of(row)).collect() };
        assert_eq!(weights(&found[0]), [0.0, 6.0, 6.0, 0.0]);
        assert_eq!(weights(&found[1]), [0.0, 36.0, 36.0, 0.0]);
        // After 100 s with a time constant of 60 s, exp(−5/3) = 0.188876 of the difference remains: 3 · 0.811124; then towards 6, then towards 3.
        let expected = [0.0, 2.433373, 5.326351, 3.439391];
        let own = weights(&found[2]);
        assert!(own.iter().zip(expected).all(|(own, expected)| (own - expected).abs() < 1e-5), "{own:?}");
    }
}
