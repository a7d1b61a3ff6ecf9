//! Errors of the motion of axes that are smooth in the position: scale, straightness, roll, pitch and yaw (ISO 230-1).

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_base::geometry::Axis;
use ncfix_model::ParameterName;
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::parameter::ComponentTerm;

pub(in crate::diagnose) const CAUSE: Cause = Cause {
    name: "motion of an axis",
    effect: EffectKind::Motion,
    made_by: "guideways, ball screw, scale",
    shown_by: "laser, level, hole plate; ball-bar: lobes that are equal in both directions and at all feeds",
    separate_by: "a second tool length or plate height separates angles from straightness; two radii separate a scale from the length of the bar",
    correctable: Correctable::Program,
    propose,
};

/// Degrees of the polynomials.
const DEGREES: [u8; 5] = [1, 2, 3, 4, 5];
/// Knots for shapes that these polynomials do not follow, as shares of the measured range.
const KNOTS: [&[f64]; 2] = [&[0.33, 0.67], &[0.2, 0.4, 0.6, 0.8]];
/// Numbers of equal pieces between knots for a component that is measured directly: they follow up to three cycles over the range. A wave with more cycles is
/// a periodic error.
const FINE: [u32; 2] = [8, 12];
/// Minimum number of measured positions for each column of such a shape.
const PLACES_EACH: usize = 2;
/// Positions nearer to each other than this are one, mm.
const SAME_PLACE_MM: f64 = 1e-3;

/// Columns of one axis: weights with the terms of their parameters.
type Shape = Vec<(Weight, ComponentTerm)>;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in super::axes(scene) {
        let Some([low, high]) = super::range(scene, axis) else { continue };
        let powers: Shape = DEGREES
            .into_iter()
            .map(|degree| {
                (Weight::new(move |row| row.position[axis].powi(i32::from(degree))), ComponentTerm::Coefficient(degree))
            })
            .collect();
        let mut shapes: Vec<Shape> =
            (1..=powers.len()).map(|most| powers.iter().take(most).cloned().collect()).collect();
        let knotted = |shares: &mut dyn Iterator<Item = f64>| {
            let mut shape: Shape = powers.iter().take(2).cloned().collect();
            for share in shares {
                let at = (low + share * (high - low)).round();
                let weight = Weight::new(move |row| (row.position[axis] - at).max(0.0).powi(2));
                shape.push((weight, ComponentTerm::Knot { degree: 2, at: at as i32 }));
            }
            shape
        };
        let knots = KNOTS.into_iter().filter(|_| !axis.is_rotary());
        shapes.extend(knots.map(|knots| knotted(&mut knots.iter().copied())));
        let fine: Vec<Shape> = FINE
            .into_iter()
            .filter(|_| !axis.is_rotary())
            .map(|pieces| knotted(&mut (1..pieces).map(|k| f64::from(k) / f64::from(pieces))))
            .collect();
        // An angle also has a value at the zero of the axis, which lever arms show. That of a rotary axis is the orientation of the next axis (ISO 230-1).
        let always = (Weight::new(|_| 1.0), ComponentTerm::Coefficient(0));
        let tilted: Vec<Shape> =
            (1..=2).map(|most| powers.iter().take(most).chain([&always]).cloned().collect()).collect();
        let has_value = |component: ErrorName| component.direction.is_rotation() && !axis.is_rotary();
        for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
            let places = direct_places(scene, component, axis);
            let fine = fine.iter().filter(|shape| places >= PLACES_EACH * shape.len());
            for shape in shapes.iter().chain(tilted.iter().filter(|_| has_value(component))).chain(fine) {
                let mut one = Candidate::one(&CAUSE, component, Through::Component(component), Weight::new(|_| 0.0));
                one.columns =
                    shape.iter().map(|(weight, _)| vec![(Through::Component(component), weight.clone())]).collect();
                let parameters: Vec<_> =
                    shape.iter().map(|(_, term)| ParameterName { component, term: *term }).collect();
                out.push(one.driven_by(&[&axis]).extends(&parameters));
            }
        }
    }
}

/// Number of positions of an axis at which a component was measured directly.
fn direct_places(scene: &Scene<'_>, component: ErrorName, axis: Axis) -> usize {
    let own = scene.rows.iter().filter(|row| row.component == Some(component));
    let mut places: Vec<f64> = own.map(|row| row.position[axis]).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < SAME_PLACE_MM);
    places.len()
}

/// Motions of linear axes without slope, of the second degree and with the third: Legendre polynomials over the measured range. Together with a
/// squareness, which contains the slope, they describe a straightness completely.
pub(in crate::diagnose) fn bows(scene: &Scene<'_>) -> Vec<Candidate> {
    let mut out = Vec::new();
    for axis in super::linear(scene) {
        let Some([low, high]) = super::range(scene, axis) else { continue };
        let (middle, half) = (f64::midpoint(low, high), 0.5 * (high - low));
        let of = |shape: fn(f64) -> f64| Weight::new(move |row| shape((row.position[axis] - middle) / half));
        let [second, third] = [of(|u| u * u), of(|u| u * (u * u - 0.6))];
        for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
            let through = Through::Component(component);
            let one = Candidate::one(&CAUSE, component, through, second.clone()).driven_by(&[&axis]);
            let mut both = one.clone();
            both.columns.push(vec![(through, third.clone())]);
            out.extend([one, both]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn pieces_meet_at_shares_of_the_range_and_bend_behind_them() {
        let machine = bench::machine();
        let sets = [bench::along_x(&machine, "", &[(-100.0, ""), (0.0, ""), (200.0, "")])];
        let scene = bench::scene(&machine, &sets);
        let mut found = Vec::new();
        propose(&scene, &mut found);
        // Knots at one third and two thirds of 300 mm, from −100 mm.
        let knots = |one: &&Candidate| one.columns.len() == 4 && one.term == knotted([-1, 101]);
        let one = found.iter().find(knots).unwrap();
        let at = |column: usize, row: usize| one.columns[column][0].1.of(&scene.rows[row]);
        assert_eq!([0, 1, 2].map(|row| at(2, row)), [0.0, 1.0, 201.0 * 201.0]);
        assert_eq!([0, 1, 2].map(|row| at(3, row)), [0.0, 0.0, 99.0 * 99.0]);
    }

    fn knotted(knots: [i32; 2]) -> super::super::Term {
        let component = ErrorName::motion(DIRECTIONS[1], ncfix_base::geometry::Axis::X);
        let terms = [ComponentTerm::Coefficient(1), ComponentTerm::Coefficient(2)]
            .into_iter()
            .chain(knots.map(|at| ComponentTerm::Knot { degree: 2, at }));
        super::super::Term::Parameters(terms.map(|term| ParameterName { component, term }).collect())
    }

    #[test]
    fn bows_are_those_of_legendre_over_the_range() {
        let machine = bench::machine();
        let sets = [bench::along_x(&machine, "", &[(100.0, ""), (200.0, ""), (250.0, ""), (300.0, "")])];
        let scene = bench::scene(&machine, &sets);
        let found = bows(&scene);
        let both = found.iter().find(|one| one.parameter == "EYX" && one.columns.len() == 2).unwrap();
        let at = |column: usize| [0, 1, 2, 3].map(|row| both.columns[column][0].1.of(&scene.rows[row]));
        // At −1, 0, 1/2 and 1: u² and u³ − 3/5 u.
        let expected = [[1.0, 0.0, 0.25, 1.0], [-0.4, 0.0, 0.125 - 0.3, 0.4]];
        for (column, expected) in expected.iter().enumerate() {
            assert!(at(column).iter().zip(expected).all(|(own, expected)| (own - expected).abs() < 1e-12), "{column}");
        }
    }
}
