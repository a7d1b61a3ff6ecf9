//! A peak after the reversal of an axis: the axis sticks until the controller has built up enough force, and follows late.

use super::{Candidate, Cause, Correctable, EffectKind, Weight, own};
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::{Scene, Through};

pub(super) const CAUSE: Cause = Cause {
    name: "reversal spike",
    effect: EffectKind::ReversalSpike,
    made_by: "friction and a slow control loop",
    shown_by: "ball-bar: short outward peaks after each reversal, higher at higher feed",
    separate_by: "repeat the run: a spike recurs at its position, a false reading does not",
    correctable: Correctable::No,
    propose,
};

/// Lengths of a spike as path of the tool, mm: from one reading of a dense ball-bar trace to a quarter of a small circle. Wide spikes cover many
/// readings, so wide lengths follow each other in steps of a tenth.
const SCALES: [f64; 19] =
    [0.5, 1.0, 2.0, 3.0, 4.2, 5.8, 8.0, 8.8, 9.7, 10.6, 11.7, 12.9, 14.2, 15.6, 17.1, 18.9, 20.7, 22.8, 25.1];

/// Shapes of a spike over the path since the reversal, in units of its length; each has the maximum 1. With an integrating controller the error
/// decays, with a limited force it is held and then released, and if the guide springs before it slides the error first grows; ball-bar traces show
/// all three.
const FORMS: [fn(f64) -> f64; 3] = [|way| (-way).exp(), |way| (-0.5 * way * way).exp(), |way| way * (1.0 - way).exp()];

/// `true` if the reading was taken in motion. An axis that stops at its target, as in ISO 230-2, has settled: the peak is over.
fn is_moving(row: &SceneRow) -> bool {
    row.velocity.is_some() || row.assumed_velocity.is_some()
}

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in super::linear(scene) {
        if !scene.rows.iter().any(|row| is_moving(row) && row.way_since_turn[axis].is_finite()) {
            continue;
        }
        for scale in SCALES {
            for form in FORMS {
                let weight = Weight::new(move |row| {
                    let way = row.way_since_turn[axis] / scale;
                    if is_moving(row) && way.is_finite() { -row.sense_of(axis) * form(way) } else { 0.0 }
                });
                let mut one = Candidate::one(&CAUSE, axis, Through::Component(own(axis)), weight);
                one.constant = Some((scale, "mm"));
                out.push(one.driven_by(&[&axis, &format!("{axis}_dir")]));
            }
        }
    }
}
