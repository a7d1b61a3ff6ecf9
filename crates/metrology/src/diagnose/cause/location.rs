//! Errors of the location of axes: squareness, offsets and tilts of rotary axes, of the spindle (ISO 230-1, ISO 230-7).

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_model::ParameterName;
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(super) const CAUSE: Cause = Cause {
    name: "location of an axis",
    effect: EffectKind::Location,
    made_by: "assembly, a collision, a foundation that has moved",
    shown_by: "ball-bar: an oval at 45° that is equal in both directions; chase-the-ball: readings that turn with the axis",
    separate_by: "turn the artifact by 90°, or index the rotary axis at three more angles",
    correctable: Correctable::Program,
    propose,
};

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes = scene.machine.axes.iter().flatten();
    let of_axes = axes.flat_map(|data| DIRECTIONS.map(|direction| ErrorName::location(direction, data.axis)));
    let of_spindle = DIRECTIONS.map(ErrorName::spindle);
    let always = Weight::new(|_| 1.0);
    for name in of_axes.chain(of_spindle) {
        let one = Candidate::one(&CAUSE, name, Through::Component(name), always.clone());
        out.push(one.extends(&[ParameterName::location(name)]));
    }
}
