//! An error of one axis that depends on where another one stands: stacked axes and finite stiffness (Spaan 1995, ch. 2: EAY that grows with X).

use super::{Candidate, Cause, Correctable, Effect, Weight};
use crate::diagnose::scene::{Scene, Through};
use crate::model::name::{DIRECTIONS, ErrorName};

pub(super) const CAUSE: Cause = Cause {
    name: "cross-coupled error",
    effect: Effect::Cross,
    made_by: "stacked axes, weight that moves, a frame that gives way",
    shown_by: "lines measured at several places of the other axes",
    separate_by: "a grid of lines: three places of the other axis",
    correctable: Correctable::Program,
    propose,
};

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes: Vec<_> = scene.machine.axes.iter().flatten().map(|data| data.axis).collect();
    for &axis in &axes {
        for &other in axes.iter().filter(|&&other| other != axis) {
            for name in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
                let product = Weight::new(move |row| row.position[axis] * row.position[other]);
                out.push(Candidate::one(&CAUSE, name, Through::Component(name), product).driven_by(&[&axis, &other]));
            }
        }
    }
}
