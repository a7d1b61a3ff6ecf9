//! Errors of the location of axes: squareness, offsets and tilts of rotary axes, of the spindle (ISO 230-1, ISO 230-7).

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_model::ParameterName;
use ncfix_model::name::{DIRECTIONS, ErrorKind, ErrorName};

pub(super) const CAUSE: Cause = Cause {
    name: "location of an axis",
    effect: EffectKind::Location,
    made_by: "assembly, a collision, a foundation that has moved",
    shown_by: "ball-bar: an oval at 45° that is equal in both directions; chase-the-ball: readings that turn with the axis",
    separate_by: "turn the artifact by 90°, or index the rotary axis at three more angles",
    correctable: Correctable::Program,
    propose,
};

/// The place of a name among those of one squareness: the later axis of the plane (ISO 230-1: EC0Y, EB0Z, EA0Z), then the earlier one, then the third axis,
/// whose turn about itself shows only in the axes that it carries. A chain of axes may hide the effect of some names; the first one with an effect is used.
/// 0 for all other errors, which have one name.
pub(in crate::diagnose) fn rank(name: ErrorName) -> u32 {
    let is_squareness = name.kind == ErrorKind::Location && name.direction.is_rotation();
    let Some(axis) = name.axis().filter(|axis| is_squareness && !axis.is_rotary()) else { return 0 };
    let (about, own) = (name.direction.index() % 3, axis.dimension());
    match own {
        _ if own == about => 2,
        _ if (0..3).any(|other| other != about && other > own) => 1,
        _ => 0,
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_squareness_has_the_name_of_its_later_axis() {
        let of = |name: &str| rank(name.parse().unwrap());
        assert_eq!(["EC0Y", "EB0Z", "EA0Z"].map(of), [0; 3]);
        assert_eq!(["EC0X", "EB0X", "EA0Y"].map(of), [1; 3]);
        assert_eq!(["EC0Z", "EB0Y", "EA0X"].map(of), [2; 3]);
        // Rotary axes, offsets and the spindle have one name for each.
        assert_eq!(["EA0C", "EX0C", "EA0S", "EZ0Z"].map(of), [0; 4]);
    }
}
