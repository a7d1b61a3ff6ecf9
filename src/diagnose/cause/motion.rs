//! Errors of the motion of axes that are smooth in the position: scale, straightness, roll, pitch and yaw (ISO 230-1).

use super::{Candidate, Cause, Correctable, Effect, Weight};
use crate::diagnose::scene::{Scene, Through};
use crate::model::ParameterName;
use crate::model::name::{DIRECTIONS, ErrorName};

pub(super) const CAUSE: Cause = Cause {
    name: "motion of an axis",
    effect: Effect::Motion,
    made_by: "guideways, ball screw, scale",
    shown_by: "laser, level, hole plate; ball-bar: lobes that are the same in both senses and at all feeds",
    separate_by: "a second tool length or plate height tells angles from straightness, two radii a scale from the length of the bar",
    correctable: Correctable::Program,
    propose,
};

/// Degrees that are tried together.
const DEGREES: [u8; 3] = [1, 2, 3];

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in scene.machine.axes.iter().flatten().map(|data| data.axis) {
        for direction in DIRECTIONS {
            let name = ErrorName::motion(direction, axis);
            for most in DEGREES {
                let degrees: Vec<u8> = (1..=most).collect();
                let columns = degrees.iter().map(|&degree| {
                    vec![(Through::Component(name), Weight::new(move |row| row.position[axis].powi(i32::from(degree))))]
                });
                let parameters: Vec<_> =
                    degrees.iter().map(|&degree| ParameterName::coefficient(name, degree)).collect();
                let mut one = Candidate::one(&CAUSE, name, Through::Component(name), Weight::new(|_| 0.0));
                one.columns = columns.collect();
                out.push(one.driven_by(&[&axis]).extends(&parameters));
            }
        }
    }
}
