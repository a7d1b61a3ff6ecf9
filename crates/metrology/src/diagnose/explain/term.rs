//! Terms: the effect of one additional error of the machine on the readings, in a form in which each error has one name.
//!
//! Over the travel of its axis a straightness has no slope, an angular error no mean, and a positioning error no constant, as those are squareness,
//! orientation and zero (ISO 230-1). Shapes are therefore Legendre polynomials over the travel. Of two location errors with the same effect on all
//! measured positions, only the one named by ISO 230-1 is kept.

use super::assumptions::Family;
use crate::diagnose::cause::{Weight, axes, linear, location, own};
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::Scene;
use crate::diagnose::scene::Through;
use ncfix_base::geometry::Axis;
use ncfix_model::name::{DIRECTIONS, ErrorName};

/// Highest order of a shape over the travel.
const ORDERS: u8 = 4;
/// Factor of the odds of an order or a harmonic relative to the one below, and of the size of an order: guideways are smooth, and most of them bow
/// before they wave.
const RARER: f64 = 1.0 / 3.0;
/// Number of harmonics of a revolution of a rotary axis.
const HARMONICS: u8 = 2;

/// A term.
#[derive(Clone, Debug)]
pub struct Term {
    /// Its family.
    pub family: Family,
    /// The component.
    pub component: ErrorName,
    /// Its drivers: `X_dir`, another axis, `order 2`.
    pub shape: String,
    /// Standard deviation of the prior of its amount, mm, rad or s.
    pub size: f64,
    /// Its share of the odds of its family: orders and harmonics of one error share these.
    pub share: f64,
    /// Index of the term that usually accompanies it: for an order, the one below.
    pub parent: Option<usize>,
    /// Effect of one unit on the component at each row; for a shape over the travel, 1 at its end.
    pub weight: Weight,
}

impl Term {
    fn new(family: Family, component: ErrorName, shape: impl Into<String>, travel_mm: f64, weight: Weight) -> Term {
        Term { family, component, shape: shape.into(), size: family.size(travel_mm), share: 1.0, parent: None, weight }
    }

    /// Its displayed name: `EC0X`, `EXX backlash`, `EYX X order 2`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.component, self.shape).trim_end().to_owned()
    }

    /// Returns the path of its effect.
    #[must_use]
    pub fn through(&self) -> Through {
        Through::Component(self.component)
    }
}

/// The travel of an axis, mm or rad: from the machine file, else the measured range.
fn travel(scene: &Scene<'_>, axis: Axis) -> Option<[f64; 2]> {
    let stated = scene.machine.axis(axis).and_then(|data| data.travel);
    stated.or_else(|| crate::diagnose::cause::range(scene, axis))
}

/// Legendre polynomial of an order, for `u` from −1 to 1.
fn legendre(order: u8, u: f64) -> f64 {
    let (mut before, mut now) = (1.0, u);
    if order == 0 {
        return 1.0;
    }
    for k in 1..order {
        let k = f64::from(k);
        (before, now) = (now, ((2.0 * k + 1.0) * u * now - k * before) / (k + 1.0));
    }
    now
}

/// Position of an axis in its travel, from −1 to 1.
fn share(axis: Axis, [low, high]: [f64; 2]) -> impl Fn(&SceneRow) -> f64 + Send + Sync + Copy + 'static {
    move |row: &SceneRow| (2.0 * row.position[axis] - low - high) / (high - low)
}

/// Returns all terms that the axes of a scene can have; those without a visible effect are dropped later.
#[must_use]
pub fn terms(scene: &Scene<'_>) -> Vec<Term> {
    let mut out = Vec::new();
    locations(scene, &mut out);
    for axis in linear(scene) {
        shapes(scene, axis, &mut out);
    }
    for axis in axes(scene).filter(|axis| axis.is_rotary()) {
        turns(axis, &mut out);
    }
    for axis in axes(scene) {
        plays(axis, &mut out);
    }
    lags(scene, &mut out);
    crosses(scene, &mut out);
    out
}

/// A lag of an axis is an error along itself against its motion; for an axis that moves the table the sign is reversed.
fn lags(scene: &Scene<'_>, out: &mut Vec<Term>) {
    for axis in linear(scene) {
        let Some(along) = scene.machine.axis(axis).and_then(|data| data.direction.get(axis.dimension()).copied())
        else {
            continue;
        };
        let by = if along < 0.0 { 1.0 } else { -1.0 };
        let weight = Weight::new(move |row: &SceneRow| by * row.velocity.map_or(0.0, |velocity| velocity[axis]));
        out.push(Term::new(Family::Lag, own(axis), format!("{axis} lag"), 0.0, weight));
    }
}

fn locations(scene: &Scene<'_>, out: &mut Vec<Term>) {
    let always = Weight::new(|_| 1.0);
    let mut push = |name: ErrorName, family: Family| out.push(Term::new(family, name, "", 0.0, always.clone()));
    // Of names with the same effect the first one stays: that of ISO 230-1 if it has an effect on this chain, as in the search.
    let mut names: Vec<ErrorName> =
        axes(scene).flat_map(|axis| DIRECTIONS.map(|direction| ErrorName::location(direction, axis))).collect();
    names.sort_by_key(|&name| location::rank(name));
    for name in names {
        if let Some(axis) = name.axis() {
            let direction = name.direction;
            let family = match (axis.is_rotary(), direction.is_rotation()) {
                // A turn of a linear axis about itself is the tilt of the rotary axis that it carries.
                (false, true) if direction.index() % 3 == axis.dimension() && carries_rotary(scene, axis) => {
                    Family::Tilt
                }
                (false, true) => Family::Squareness,
                // An offset of a linear axis is the zero of its scale.
                (false, false) => continue,
                (true, true) => Family::Tilt,
                (true, false) => Family::Offset,
            };
            push(name, family);
        }
    }
    for direction in DIRECTIONS {
        push(ErrorName::spindle(direction), if direction.is_rotation() { Family::Tilt } else { Family::Offset });
    }
}

/// True if the next axis of the chain, seen from the foundation, is rotary.
fn carries_rotary(scene: &Scene<'_>, axis: Axis) -> bool {
    let topology = &scene.machine.topology;
    let next = |branch: &[Axis]| {
        let place = branch.iter().position(|&own| own == axis)?;
        branch.get(place + 1).copied()
    };
    next(&topology.workpiece).or_else(|| next(&topology.tool)).is_some_and(Axis::is_rotary)
}

fn shapes(scene: &Scene<'_>, axis: Axis, out: &mut Vec<Term>) {
    let Some(range) = travel(scene, axis) else { return };
    let at = share(axis, range);
    for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
        let first = match (component.direction.is_rotation(), component == own(axis)) {
            // The mean of an angle is orientation, the line of a straightness is squareness, the constant of a positioning error is the zero.
            (true, _) | (false, true) => 1,
            (false, false) => 2,
        };
        for order in first..=ORDERS {
            let family = match (component.direction.is_rotation(), component == own(axis), order) {
                (true, ..) => Family::Angle,
                (false, true, 1) => Family::Scale,
                (false, true, _) => Family::Positioning,
                (false, false, _) => Family::Straightness,
            };
            let weight = Weight::new(move |row| legendre(order, at(row)));
            let mut one = Term::new(family, component, format!("{axis} order {order}"), range[1] - range[0], weight);
            // A scale has its own family.
            let lowest = if family == Family::Positioning { 2 } else { first };
            let above = order - lowest.min(order);
            one.share = share_of(above, ORDERS - lowest + 1);
            one.parent = (order > first).then(|| out.len() - 1);
            one.size *= RARER.powi(i32::from(above));
            out.push(one);
        }
    }
}

/// Share of the odds of an order, `above` steps over the lowest of `count` orders.
fn share_of(above: u8, count: u8) -> f64 {
    let all: f64 = (0..count).map(|k| RARER.powi(i32::from(k))).sum();
    RARER.powi(i32::from(above)) / all
}

fn turns(axis: Axis, out: &mut Vec<Term>) {
    for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
        let family = if component.direction.is_rotation() { Family::Angle } else { Family::Rotary };
        for harmonic in 1..=HARMONICS {
            let turn = f64::from(harmonic);
            let [sine, cosine] = [
                Weight::new(move |row: &SceneRow| (turn * row.position[axis]).sin()),
                Weight::new(move |row: &SceneRow| (turn * row.position[axis]).cos()),
            ];
            for (name, weight) in [("sin", sine), ("cos", cosine)] {
                let mut one = Term::new(family, component, format!("{name} {harmonic}{axis}"), 0.0, weight);
                one.share = share_of(harmonic - 1, HARMONICS);
                out.push(one);
            }
        }
    }
}

fn plays(axis: Axis, out: &mut Vec<Term>) {
    // A reversal value acts with half its size on either side.
    let side = Weight::new(move |row: &SceneRow| 0.5 * row.sense_of(axis));
    for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
        let family = match (component == own(axis), component.direction.is_rotation()) {
            (true, _) => Family::Backlash,
            (false, true) => Family::AngularPlay,
            (false, false) => Family::LateralPlay,
        };
        let mut one = Term::new(family, component, format!("{axis}_dir"), 0.0, side.clone());
        if axis.is_rotary() && family == Family::Backlash {
            one.size = Family::Angle.size(0.0);
        }
        out.push(one);
    }
}

fn crosses(scene: &Scene<'_>, out: &mut Vec<Term>) {
    let all: Vec<Axis> = linear(scene).collect();
    for &axis in &all {
        for &other in all.iter().filter(|&&other| other != axis) {
            let (Some(own), Some(across)) = (travel(scene, axis), travel(scene, other)) else { continue };
            let (own, across) = (share(axis, own), share(other, across));
            let product = Weight::new(move |row| own(row) * across(row));
            for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
                let family = if component.direction.is_rotation() { Family::CrossAngle } else { Family::Cross };
                out.push(Term::new(family, component, format!("{axis} and {other}"), 0.0, product.clone()));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_share_the_odds_of_their_family() {
        // 9 : 3 : 1 of 13.
        let all = [0, 1, 2].map(|above| share_of(above, 3));
        assert!(all.iter().zip([9.0, 3.0, 1.0]).all(|(own, of)| (own - of / 13.0).abs() < 1e-12), "{all:?}");
    }

    #[test]
    fn shapes_are_those_of_legendre() {
        // P2 = (3u² − 1)/2, P3 = (5u³ − 3u)/2, P4 = (35u⁴ − 30u² + 3)/8 (Abramowitz and Stegun 1964, 22.3.8).
        let at = |u: f64| [0, 1, 2, 3, 4].map(|order| legendre(order, u));
        for u in [-1.0, -0.3, 0.0, 0.5, 1.0] {
            let (square, cube) = (u * u, u * u * u);
            let expected = [
                1.0,
                u,
                1.5 * square - 0.5,
                2.5 * cube - 1.5 * u,
                (35.0 * square * square - 30.0 * square + 3.0) / 8.0,
            ];
            assert!(at(u).iter().zip(expected).all(|(own, expected)| (own - expected).abs() < 1e-12), "{u}");
        }
    }
}
