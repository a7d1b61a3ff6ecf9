//! Backlash: at a reversal the carriage lags, along the axis (backlash), or across it or in rotation (lateral play).

use super::{Candidate, Cause, Correctable, EffectKind, Weight, own};
use crate::diagnose::scene::{Scene, Through};
use ncfix_base::geometry::Axis;
use ncfix_model::ParameterName;
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(super) const BACKLASH: Cause = Cause {
    name: "backlash",
    effect: EffectKind::Backlash,
    made_by: "backlash of nut, preload or gear; wind-up of the screw",
    shown_by: "ball-bar: steps at the reversals of the axis, of opposite sign in the two directions; laser in both directions",
    separate_by: "a second feed: lag increases with the feed, backlash does not",
    correctable: Correctable::Program,
    propose: |scene, out| propose(scene, out, &BACKLASH, true),
};

pub(super) const LATERAL_PLAY: Cause = Cause {
    name: "lateral play",
    effect: EffectKind::LateralPlay,
    made_by: "clearance of the guideway",
    shown_by: "ball-bar: the traces of the two directions differ across the axis, without steps",
    separate_by: "both directions of the ball-bar; both directions along the axis with an indicator across it",
    correctable: Correctable::Program,
    propose: |scene, out| propose(scene, out, &LATERAL_PLAY, false),
};

/// Smallest range of positions approached from each side, as a share of the range of all positions of the axis. Less does not show a backlash that
/// changes along the axis.
const WAY: f64 = 0.5;

/// Wind-up grows with the length of the screw between bearing and nut.
pub(super) const WIND_UP: Cause = Cause {
    name: "backlash that depends on the position",
    effect: EffectKind::Backlash,
    made_by: "wind-up of the screw, or wear where it is used most",
    shown_by: "laser in both directions over the whole travel: the two lines are not parallel",
    separate_by: "both directions at three or more positions",
    correctable: Correctable::Program,
    propose: wind_up,
};

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>, cause: &'static Cause, along: bool) {
    for axis in super::axes(scene).filter(|axis| both_ways(scene, *axis, 0.0)) {
        let sense = Weight::new(move |row| row.sense_of(axis));
        for name in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
            if (name == own(axis)) != along {
                continue;
            }
            let one = Candidate::one(cause, name, Through::Component(name), sense.clone());
            out.push(one.driven_by(&[&format!("{axis}_dir")]).extends(&[ParameterName::backlash(name)]));
        }
    }
}

/// True if the axis was measured after motions in both directions, each over at least this share of its range. With one direction only, a backlash is
/// a constant, and a backlash that changes along the axis is a scale.
fn both_ways(scene: &Scene<'_>, axis: Axis, share: f64) -> bool {
    let spread = |of: fn(f64) -> bool| {
        let places = scene.rows.iter().filter(|row| of(row.sense_of(axis))).map(|row| row.position[axis]);
        super::spread(places).map(|[low, high]| high - low)
    };
    let [Some(all), Some(up), Some(down)] =
        [spread(|_| true), spread(|sense| sense > 0.0), spread(|sense| sense < 0.0)]
    else {
        return false;
    };
    up.min(down) >= share * all
}

fn wind_up(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in super::axes(scene).filter(|axis| both_ways(scene, *axis, WAY)) {
        let Some([low, high]) = super::range(scene, axis) else { continue };
        let through = Through::Component(own(axis));
        let share = move |row: &crate::diagnose::row::SceneRow| (row.position[axis] - low) / (high - low);
        let columns = [0, 1].map(|power| Weight::new(move |row| row.sense_of(axis) * share(row).powi(power)));
        let mut one = Candidate::one(&WIND_UP, own(axis), through, Weight::new(|_| 0.0));
        one.columns = columns.into_iter().map(|weight| vec![(through, weight)]).collect();
        out.push(one.driven_by(&[&format!("{axis}_dir"), &axis]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn play_shows_where_an_axis_came_from_both_sides() {
        let machine = bench::machine();
        let found = |places: &[f64], share: f64| {
            let cells: Vec<(f64, &str)> = places.iter().map(|&x| (x, "")).collect();
            let sets = [bench::along_x(&machine, "", &cells)];
            both_ways(&bench::scene(&machine, &sets), Axis::X, share)
        };
        // The first position has no direction of approach.
        assert!(!found(&[300.0, 200.0, 100.0], 0.0));
        assert!(found(&[300.0, 200.0, 100.0, 150.0, 190.0], 0.0));
        // Upwards only over 40 mm of 200 mm.
        assert_eq!([0.1, 0.3].map(|share| found(&[300.0, 200.0, 100.0, 150.0, 190.0], share)), [true, false]);
    }
}
