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

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>, cause: &'static Cause, along: bool) {
    for axis in scene.machine.axes.iter().flatten().map(|data| data.axis) {
        for name in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
            if (name == own(axis)) != along {
                continue;
            }
            let sense = Weight::new(move |row| row.sense_of(axis));
            let one = Candidate::one(cause, name, Through::Component(name), sense);
            out.push(one.driven_by(&[&format!("{axis}_dir")]).extends(&[ParameterName::backlash(name)]));
        }
    }
}
