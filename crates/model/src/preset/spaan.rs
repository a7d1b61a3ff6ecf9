//! Models of three linear axes: `spaan-18` and `spaan-21`.
//!
//! Each linear axis has three translations and three rotations, 18 functions, and there are three squareness errors (Spaan 1995, ch. 3, table of direct
//! measurements). A function is a piecewise polynomial of degree 2, continuous with its slope, with knots every 50 mm of the travel (eq. 3.3 and the example
//! of Fig. 3.4). A fit removes insignificant terms. To avoid redundancy,
//!
//! - no function has a constant, which would be the zero of an axis or the position of the workpiece, and
//! - straightness has no slope, which is squareness or the direction of the axis.
//!
//! `spaan-21` lists the squareness errors separately. In `spaan-18` they are the constants of the matching rotations, as the accumulator of Spaan, ch. 6,
//! adds them (`xsy` to `yrz` on a machine X-Y-Z). That requires his lever arms, which include the motion of the axis itself (`lever = "fixed"`); with them
//! both presets describe the same machines. On an axis whose errors are carried, a constant rotation tilts what stands on the axis, not its path. There
//! squareness is the slope of its straightness instead. The two models then differ by a constant tilt of tool or workpiece.
//!
//! With readings of the tip only, the rotations of the axis next to the spindle are determined only by several tool vectors. With one tool length along the
//! spindle a roll about it is not identifiable. Rotary axes, if any, have no errors here: they are clamped.

use super::Unsuitable;
use super::roles::{Linear, along};
use crate::name::{DIRECTIONS, ErrorKind, ErrorName};
use crate::parameter::{ComponentTerm, ParameterName};
use ncfix_machine::machine::{AxisData, Lever, Machine};

/// Distance of the knots, mm.
const KNOT_DISTANCE_MM: i32 = 50;
/// Maximum travel with knots, mm: no machine tool is longer.
const LONGEST_TRAVEL_MM: f64 = 100_000.0;

/// Returns the parameters of Spaan 1995, eq. 2.2–2.9.
pub(super) fn functions_18(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    let Linear(axes) = Linear::of(machine)?;
    let squareness = Linear(axes).squareness(machine);
    let within: Vec<_> = squareness.iter().filter_map(|name| within_a_function(machine, *name)).collect();
    Ok(functions(&axes, &within))
}

/// Returns the parameters of Spaan 1995, ch. 3: direct measurement.
pub(super) fn functions_21(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    let linear = Linear::of(machine)?;
    let mut parameters = functions(&linear.0, &[]);
    parameters.extend(linear.squareness(machine).map(ParameterName::location));
    Ok(parameters)
}

/// Returns the coefficient of a function of the same axis that represents a squareness error.
fn within_a_function(machine: &Machine, squareness: ErrorName) -> Option<ParameterName> {
    let data = machine.axis(squareness.axis()?)?;
    if data.lever == Lever::Fixed {
        return Some(ParameterName::coefficient(ErrorName { kind: ErrorKind::Motion, ..squareness }, 0));
    }
    // Perpendicular to the axis, and to the direction about which it is tilted.
    let used = [along(&data.direction).index(), squareness.direction.index() % 3];
    let across = DIRECTIONS[..3].iter().find(|direction| !used.contains(&direction.index()))?;
    Some(ParameterName::coefficient(ErrorName::motion(*across, data.axis), 1))
}

/// Returns the functions of the axes, including the listed additional coefficients.
fn functions(axes: &[&AxisData; 3], also: &[ParameterName]) -> Vec<ParameterName> {
    let mut axes = *axes;
    axes.sort_by_key(|data| data.axis);
    let mut parameters = Vec::new();
    for data in axes {
        for direction in DIRECTIONS {
            let component = ErrorName::motion(direction, data.axis);
            let is_straightness = !direction.is_rotation() && direction.index() != data.axis.dimension();
            let first = 1 + u8::from(is_straightness);
            parameters.extend(also.iter().filter(|parameter| parameter.component == component));
            parameters.extend((first..=2).map(|degree| ParameterName::coefficient(component, degree)));
            let knots = knots(data).map(|at| ParameterName { component, term: ComponentTerm::Knot { degree: 2, at } });
            parameters.extend(knots);
        }
    }
    parameters
}

/// Returns the multiples of the distance inside the travel; none without a travel.
fn knots(data: &AxisData) -> impl Iterator<Item = i32> + use<> {
    let [low, high] = data.travel.unwrap_or_default();
    let is_known = low.abs() < LONGEST_TRAVEL_MM && high.abs() < LONGEST_TRAVEL_MM;
    let [low, high] = if is_known { [low, high] } else { [0.0, 0.0] };
    let first = (low / f64::from(KNOT_DISTANCE_MM)).floor() as i32 + 1;
    let last = (high / f64::from(KNOT_DISTANCE_MM)).ceil() as i32 - 1;
    (first..=last).map(|number| number * KNOT_DISTANCE_MM)
}
