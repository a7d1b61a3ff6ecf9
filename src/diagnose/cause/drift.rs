//! Displacement with time, of no known temperature.

use super::{Candidate, Cause, Correctable, Effect, Weight};
use crate::diagnose::scene::{Scene, Through};

pub(super) const CAUSE: Cause = Cause {
    name: "drift with time",
    effect: Effect::Drift,
    made_by: "warming up, a set-up that creeps",
    shown_by: "readings of the same pose at different times",
    separate_by: "sensors of temperature; the poses in another order",
    correctable: Correctable::No,
    propose,
};

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let Some(start) = scene.rows.iter().filter_map(|row| row.time_s).min_by(f64::total_cmp) else { return };
    for direction in 0..3 {
        let weight = Weight::new(move |row| row.time_s.map_or(0.0, |time| (time - start) / 3600.0));
        let one = Candidate::one(&CAUSE, ["X", "Y", "Z"][direction], Through::Tip(direction), weight);
        out.push(one.driven_by(&[&"t_s"]));
    }
}
