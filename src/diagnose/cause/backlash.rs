//! Play: the carriage lags behind at a turn, along the axis (backlash), across it or turned (lateral play).

use super::{Candidate, Cause, Correctable, Effect, Weight, own};
use crate::diagnose::scene::{Scene, Through};
use crate::model::ParameterName;
use crate::model::name::{DIRECTIONS, ErrorName};

pub(super) const BACKLASH: Cause = Cause {
    name: "backlash",
    effect: Effect::Backlash,
    made_by: "play of nut, preload or gear; wind-up of the screw",
    shown_by: "ball-bar: steps at the turns of the axis, of opposite sign in the two senses; laser forth and back",
    separate_by: "a second feed: lag grows with it, backlash does not",
    correctable: Correctable::Program,
    propose: |scene, out| propose(scene, out, &BACKLASH, true),
};

pub(super) const LATERAL_PLAY: Cause = Cause {
    name: "lateral play",
    effect: Effect::LateralPlay,
    made_by: "clearance of the guideway",
    shown_by: "ball-bar: the traces of the two senses split across the axis, without steps",
    separate_by: "both senses of the ball-bar; forth and back along the axis with an indicator across it",
    correctable: Correctable::Program,
    propose: |scene, out| propose(scene, out, &LATERAL_PLAY, false),
};

/// Wind-up grows with the length of the screw between bearing and nut.
pub(super) const WIND_UP: Cause = Cause {
    name: "backlash that depends on the position",
    effect: Effect::Backlash,
    made_by: "a screw that winds up, worn where it is used most",
    shown_by: "laser forth and back over the whole travel: the two lines are not parallel",
    separate_by: "forth and back at three places at least",
    correctable: Correctable::Program,
    propose: wind_up,
};

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>, cause: &'static Cause, along: bool) {
    for axis in super::axes(scene) {
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

fn wind_up(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in super::axes(scene) {
        let Some([low, high]) = super::range(scene, axis) else { continue };
        let through = Through::Component(own(axis));
        let share = move |row: &crate::diagnose::row::Row| (row.position[axis] - low) / (high - low);
        let columns = [0, 1].map(|power| Weight::new(move |row| row.sense_of(axis) * share(row).powi(power)));
        let mut one = Candidate::one(&WIND_UP, own(axis), through, Weight::new(|_| 0.0));
        one.columns = columns.into_iter().map(|weight| vec![(through, weight)]).collect();
        out.push(one.driven_by(&[&format!("{axis}_dir"), &axis]));
    }
}
