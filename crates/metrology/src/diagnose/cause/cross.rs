//! An error of one axis that depends on the position of another: stacked axes and finite stiffness (Spaan 1995, ch. 4: EAY grows with X).

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(super) const CAUSE: Cause = Cause {
    name: "cross-coupled error",
    effect: EffectKind::Cross,
    made_by: "stacked axes, moving weight, compliance of the frame",
    shown_by: "lines measured at several positions of the other axes",
    separate_by: "a grid of lines: three positions of the other axis",
    correctable: Correctable::Program,
    propose,
};

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes: Vec<_> = super::axes(scene).collect();
    for (place, &axis) in axes.iter().enumerate() {
        for (later, &other) in axes.iter().enumerate().filter(|&(later, _)| later != place) {
            let (Some(own), Some(across)) = (super::range(scene, axis), super::range(scene, other)) else { continue };
            let middle = |[low, high]: [f64; 2]| f64::midpoint(low, high);
            let (own, across) = (middle(own), middle(across));
            let product = Weight::new(move |row| (row.position[axis] - own) * (row.position[other] - across));
            // The contributions of each axis alone may be added: the origin of a product is arbitrary.
            let alone = [
                Weight::new(move |row| row.position[other] - across),
                Weight::new(move |row| row.position[axis] - own),
            ];
            for name in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
                let through = Through::Component(name);
                let one = Candidate::one(&CAUSE, name, through, product.clone()).driven_by(&[&axis, &other]);
                let mut all = one.clone();
                all.columns.extend(alone.iter().map(|weight| vec![(through, weight.clone())]));
                out.push(one);
                // A rotary axis with a linear one gets only the product, to limit the number of candidates.
                if later < place || !other.is_rotary() {
                    out.push(all);
                }
            }
        }
    }
}
