//! An error of one axis that depends on the position of another: stacked axes and finite stiffness (Spaan 1995, ch. 4: EAY grows with X).

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_base::geometry::Axis;
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

/// Displacements of an axis that are curved along it or along another axis, and proportional to the position of the other one, with all lower products: for
/// `cross EZX`, up to X²·Y and up to X·Y². Too many for a search; they are variants of a cause that someone states.
pub(in crate::diagnose) fn curved(scene: &Scene<'_>, effect: EffectKind, parameter: &str) -> Vec<Candidate> {
    let name = parameter.parse::<ErrorName>().ok().filter(|name| !name.direction.is_rotation());
    let Some((name, axis)) = name.and_then(|name| Some((name, name.axis()?))).filter(|_| effect == EffectKind::Cross)
    else {
        return Vec::new();
    };
    let is_other = |other: &Axis| *other != axis && !axis.is_rotary();
    let ranges = super::linear(scene).filter(is_other);
    let ranges = ranges.filter_map(|other| Some((other, super::range(scene, axis)?, super::range(scene, other)?)));
    let mut out = Vec::new();
    for (other, own, across) in ranges {
        let middle = |[low, high]: [f64; 2]| f64::midpoint(low, high);
        let from = [middle(own), middle(across)];
        for highest in [[2, 1], [1, 2]] {
            let powers = (0..=highest[0]).flat_map(|own| (0..=highest[1]).map(move |across| [own, across]));
            let through = Through::Component(name);
            let column = |[own, across]: [i32; 2]| {
                let weight = Weight::new(move |row| {
                    (row.position[axis] - from[0]).powi(own) * (row.position[other] - from[1]).powi(across)
                });
                vec![(through, weight)]
            };
            let mut one = Candidate::one(&CAUSE, name, through, Weight::new(|_| 0.0)).driven_by(&[&axis, &other]);
            one.columns = powers.filter(|powers| *powers != [0, 0]).map(column).collect();
            out.push(one);
        }
    }
    out
}

/// A displacement that acts on readings as an accepted angle does by its lever arm. The search does not propose it.
pub(in crate::diagnose) const LEVER: Cause =
    Cause { name: "cross-coupled displacement by a lever arm", propose: |_, _| {}, ..CAUSE };

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
