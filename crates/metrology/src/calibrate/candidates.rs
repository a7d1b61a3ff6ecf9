//! Candidates for the selection of terms: piecewise polynomials of motion errors (Spaan 1995, eq. 3.3).
//!
//! The global part has degrees from 1: degree 0 is a location error. Truncated powers begin at whole multiples of the spacing within the range of the
//! data, each of the highest degree up to 2, so that the function has a continuous slope, as Spaan requires. A kink or step is a candidate only if it
//! is named (`EXX1@150`). Any subset may be selected: the origin of an axis has no relation to its errors, so degree 2 does not need degree 1.

use crate::measure::data::DataSet;
use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::machine::Machine;
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::parameter::{ComponentTerm, ParameterName};

use super::effect::Parameter;

/// Highest degree of truncated powers.
const MOST_KNOT_DEGREE: u8 = 2;
/// Maximum number of knots of an axis: a travel of 20 m every 20 mm.
const MOST_KNOTS: usize = 1000;
/// Penalty of a truncated power in −2 ln of the likelihood: two standard deviations.
const KNOT_HANDICAP: f64 = 4.0;

/// Piecewise polynomials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PiecewisePolynomials {
    /// Spacing of the knots, whole mm.
    pub spacing_mm: i32,
    /// Highest degree.
    pub degree: u8,
}

/// The terms of one motion error. A rotary axis has no truncated powers.
#[must_use]
pub fn of_component(component: ErrorName, data: &[DataSet], pieces: PiecewisePolynomials) -> Vec<ParameterName> {
    let mut terms: Vec<ParameterName> =
        (1..=pieces.degree).map(|degree| ParameterName::coefficient(component, degree)).collect();
    let Some(axis) = component.axis().filter(|axis| !axis.is_rotary()) else { return terms };
    let degree = pieces.degree.min(MOST_KNOT_DEGREE);
    let knot = |at| ParameterName { component, term: ComponentTerm::Knot { degree, at } };
    terms.extend(knots(axis, data, pieces.spacing_mm).into_iter().map(knot));
    terms
}

/// The terms of all motion errors of the linear axes.
#[must_use]
pub fn of_motion(machine: &Machine, data: &[DataSet], pieces: PiecewisePolynomials) -> Vec<ParameterName> {
    let linear = AXES.into_iter().filter(|&axis| !axis.is_rotary() && machine.axis(axis).is_some());
    let components = linear.flat_map(|axis| DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)));
    components.flat_map(|component| of_component(component, data, pieces)).collect()
}

/// The penalty of a candidate: of two that are not distinguishable, the one without a knot is selected.
#[must_use]
pub fn handicap(parameter: &Parameter) -> f64 {
    if matches!(parameter, Parameter::Geometry(ParameterName { term: ComponentTerm::Knot { .. }, .. })) {
        KNOT_HANDICAP
    } else {
        0.0
    }
}

/// Whole multiples of the spacing between the first and the last position of an axis.
fn knots(axis: Axis, data: &[DataSet], spacing_mm: i32) -> Vec<i32> {
    let positions = data.iter().flat_map(|set| &set.observations).map(|row| row.reading.position[axis]);
    let (low, high) = positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let spacing = f64::from(spacing_mm.max(1));
    // Positions beyond the range of a knot are beyond every machine.
    let first = (low / spacing).floor() as i32;
    let behind = (first..).take(MOST_KNOTS + 1).filter_map(|number| number.checked_mul(spacing_mm.max(1)));
    behind
        .map(|at| (at, f64::from(at)))
        .take_while(|&(_, at)| at < high)
        .filter(|&(_, at)| at > low)
        .map(|(at, _)| at)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::data::{DataSet, Observation};

    fn data(positions: &[f64]) -> Vec<DataSet> {
        let row = |&at: &f64| {
            let mut position = ncfix_base::geometry::AxisVector::ZERO;
            position[Axis::X] = at;
            Observation {
                reading: crate::measure::reading::Reading {
                    position,
                    tool_mm: ncfix_base::geometry::Vector::zeros(),
                    state: ncfix_machine::machine::State::default(),
                },
                setup: 0,
                run: 0,
                t_s: None,
                temperature_c: None,
                feed: None,
                cycle: None,
                condition: 0,
                values: [Some(0.0); 3],
                target: None,
                component: None,
                spindle_rad: 0.0,
                place: ncfix_base::diagnostic::Place {
                    file: ncfix_base::source::FileId(0),
                    span: ncfix_base::source::Span::default(),
                },
            }
        };
        let observations = positions.iter().map(row).collect();
        vec![DataSet {
            name: String::new(),
            kind: &crate::measure::kind::TRACE,
            date: None,
            head: None,
            sigma: None,
            sigma_rad: None,
            free: Vec::new(),
            artefact: crate::measure::data::Setup::default(),
            rods: Vec::new(),
            cycles: Vec::new(),
            setups: Vec::new(),
            runs: Vec::new(),
            targets: Vec::new(),
            lengths: Vec::new(),
            balls: Vec::new(),
            scale_sigma: 0.0,
            is_plan: false,
            conditions: Vec::new(),
            is_in_order: true,
            is_order_stated: true,
            is_unit_stated: false,
            is_square_stated: false,
            sensors: None,
            has_senses: true,
            fixed: Vec::new(),
            ranges: Vec::new(),
            drivers: Vec::new(),
            observations,
        }]
    }

    #[test]
    fn knots_lie_inside_what_was_measured() {
        let pieces = PiecewisePolynomials { spacing_mm: 50, degree: 2 };
        let names = |component: &str, positions: &[f64], pieces| {
            let terms = of_component(component.parse().unwrap(), &data(positions), pieces);
            terms.iter().map(ParameterName::to_string).collect::<Vec<String>>().join(" ")
        };
        assert_eq!(names("EYX", &[-60.0, 10.0, 150.0], pieces), "EYX1 EYX2 EYX2@-50 EYX2@0 EYX2@50 EYX2@100");
        assert_eq!(names("EXX", &[0.0, 100.0], PiecewisePolynomials { spacing_mm: 100, degree: 3 }), "EXX1 EXX2 EXX3");
        assert_eq!(names("EXX", &[0.0, 90.0], PiecewisePolynomials { degree: 1, ..pieces }), "EXX1 EXX1@50");
        assert_eq!(names("ECC", &[0.0, 90.0], pieces), "ECC1 ECC2");
        // For any distance.
        assert!(of_component("EXX".parse().unwrap(), &data(&[-1e300, 1e300]), pieces).len() <= MOST_KNOTS + 3);
        assert_eq!(names("EXX", &[0.0], pieces), "EXX1 EXX2");
    }
}
