//! Readings of a location error itself, such as a squareness that a certificate, a square or another program states.
//!
//! A reading is the number that the machine file has, in µrad or µm: it has no zero and no alignment. A squareness is an angle between two axes, and
//! both may have a location error about the same normal: the reading is the difference of the two if they are on two sides of F, because each of them
//! alone changes the angle. On one side only that of the axis further from F does: the rotation of the nearer axis relative to the further one, which a
//! reading with its letter states, has the opposite sign.
//!
//! A squareness is read between the reference lines of the two motions (ISO 230-1): the least-squares lines through the places of the tip over the range of
//! each axis. A straightness that the model states relative to its tangent at zero turns the line, and so does an angular error with a lever arm.
//!
//! The offsets and tilts of a rotary axis are those of its axis average line (ISO 230-7): the mean over its positions. An error motion that the model states
//! from its value at zero displaces this line by its mean. Errors that repeat with a turn have none over a whole turn, but over the travel of a swivel they have.

use std::f64::consts::TAU;

use nalgebra::Rotation3;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisVector, Plane, Vector};
use ncfix_base::units::urad_from_rad;
use ncfix_machine::machine::squareness::{SquarenessTerm, pair, squareness};
use ncfix_machine::machine::{AxisData, Branch, Condition, Lever, Machine, State};
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorModel, ErrorName, Model};

use super::{ByComponent, PathDerivative, Seen};
use crate::measure::data::DataSet;
use crate::measure::reading::Reading;

/// Largest angle that counts as a location error, rad: beyond it a number or its unit is wrong.
const MOST_RAD: f64 = 0.05;

/// The squareness to which a location error belongs, and `true` if it counts as the second one of the pair.
fn squareness_of(machine: &Machine, name: ErrorName) -> Option<(SquarenessTerm, bool)> {
    let direction = |axis| machine.axis(axis).map(|data| data.direction);
    [Plane::XY, Plane::ZX, Plane::YZ].into_iter().find_map(|plane| {
        let term = squareness(&machine.topology, plane, direction)?;
        let [own, other] = [&term.name, &term.other].map(|text| text.parse::<ErrorName>() == Ok(name));
        (own || other).then_some((term, other))
    })
}

/// True if the two axes of a squareness are on the two sides of F.
fn is_on_two_sides(machine: &Machine, term: &SquarenessTerm) -> bool {
    let branch = |text: &str| text.parse::<ErrorName>().ok()?.axis().and_then(|axis| machine.topology.branch(axis));
    branch(&term.name) != branch(&term.other)
}

/// The location errors whose sum a reading is, with their factors.
pub(super) fn parts(machine: &Machine, name: ErrorName) -> ByComponent {
    let Some((term, is_other)) = squareness_of(machine, name) else { return [Some((name, 1.0)), None, None] };
    let text = if is_other { &term.name } else { &term.other };
    let other = text.parse::<ErrorName>().ok().map(|other| (other, -1.0));
    match (is_on_two_sides(machine, &term), is_other) {
        (true, _) => [Some((name, 1.0)), other, None],
        (false, true) => [other, None, None],
        (false, false) => [Some((name, 1.0)), None, None],
    }
}

/// Places of the tip along a reference line.
const PLACES: u32 = 21;
/// Smallest cosine between an axis and the axis of F of its letter at which the angle between two motions is a squareness: 2.6°.
const LEAST_COSINE: f64 = 0.999;

/// The reading of a squareness, rad, and its derivatives with respect to the tip along both axes; `None` for another location error, and for axes without a
/// range.
pub(super) fn angle(
    ranges: &[(Axis, [f64; 2])],
    reading: &Reading,
    seen: &Seen<'_>,
    name: ErrorName,
) -> Option<(f64, Vec<PathDerivative>)> {
    let (term, is_other) = squareness_of(seen.machine, name)?;
    let [first, second, _] = pair(plane_of(name)?);
    // The value of the error for γ = 1. γ closes as the tip leaves its line towards the positive direction of the other axis.
    let factor = term.factor * if is_other { 1.0 } else { -1.0 };
    let (mut predicted, mut by_path) = (0.0, Vec::new());
    for [axis, across] in [[first, second], [second, first]] {
        let along = seen.machine.axis(axis)?;
        let cosine = along.direction[axis.dimension()];
        if cosine.abs() < LEAST_COSINE {
            return None;
        }
        let stated = ranges.iter().find(|(own, _)| *own == axis).map(|(_, range)| *range);
        let [low, high] = stated.or(along.travel).filter(|[low, high]| low < high)?;
        let sense = if seen.machine.topology.branch(axis)? == Branch::Workpiece { -1.0 } else { 1.0 };
        let way = ReferenceLine::over([low, high]);
        for (at, weight) in way.places() {
            let mut reading = *reading;
            reading.position[axis] = at;
            let there = Seen::new(seen.machine, seen.model, &reading, &reading.tool_mm);
            let weight = factor * weight * sense * cosine.signum();
            predicted += weight * there.displacement()[across.dimension()];
            let by_tip = there.direction(across.dimension()) * weight;
            by_path.push(PathDerivative { reading, by_tip, by_component: [None; 3] });
        }
    }
    Some((predicted, by_path))
}

/// Positions over which the line of a rotary axis is averaged.
const TURN_PLACES: u32 = 36;

/// The reading of an offset or a tilt of a rotary axis, mm or rad, and its derivatives with respect to components: the location error and the mean of the
/// error motion in its direction, over the range, the travel or a whole turn. `None` for another location error, and for a rotation about the axis itself,
/// whose zero is a position.
pub(super) fn average_line(
    ranges: &[(Axis, [f64; 2])],
    reading: &Reading,
    seen: &Seen<'_>,
    name: ErrorName,
) -> Option<(f64, Vec<PathDerivative>)> {
    let axis = name.axis().filter(|axis| name.is_location() && axis.is_rotary())?;
    let own = seen.machine.axis(axis)?;
    let is_about = name.direction.is_rotation() && name.direction.index() % 3 == axis.dimension();
    let stated = ranges.iter().find(|(own, _)| *own == axis).map(|(_, range)| *range);
    let [low, high] = stated.or(own.travel.filter(|_| !own.modulo)).unwrap_or([0.0, TAU]);
    if is_about || low >= high {
        return None;
    }
    let mut predicted = seen.model.location(name);
    let mut by_path = Vec::new();
    for number in 0..TURN_PLACES {
        let mut reading = *reading;
        reading.position[axis] = low + (high - low) * (f64::from(number) + 0.5) / f64::from(TURN_PLACES);
        let share = 1.0 / f64::from(TURN_PLACES);
        let by_component =
            along_fixed(own, reading.position[axis], name).map(|part| part.map(|(own, k)| (own, share * k)));
        let value =
            |(own, factor): &(ErrorName, f64)| factor * seen.model.motion(*own, &reading.position, &reading.state);
        predicted += by_component.iter().flatten().map(value).sum::<f64>();
        by_path.push(PathDerivative { reading, by_tip: Vector::zeros(), by_component });
    }
    // The location itself does not change along the path.
    by_path.push(PathDerivative {
        reading: *reading,
        by_tip: Vector::zeros(),
        by_component: [Some((name, 1.0)), None, None],
    });
    Some((predicted, by_path))
}

/// The error motions of a rotary axis whose sum with these factors is the one in a direction that does not turn with the axis.
fn along_fixed(data: &AxisData, at: f64, name: ErrorName) -> ByComponent {
    let kind = name.direction.index() / 3;
    let unit = Vector::ith(name.direction.index() % 3, 1.0);
    // Errors of a carried lever turn with the axis.
    let unit = match data.lever {
        Lever::Carried => Rotation3::new(data.direction * -at) * unit,
        Lever::Fixed => unit,
    };
    [0, 1, 2].map(|k| {
        let direction = *DIRECTIONS.get(3 * kind + k)?;
        (unit[k].abs() > f64::EPSILON).then(|| (ErrorName::motion(direction, data.axis), unit[k]))
    })
}

/// The part of a squareness that is not its location error, rad: the mean slopes of the other errors of the two axes over their travels, in the middle of all
/// other travels. 0 for an axis without a travel.
pub(in crate::measure) fn beside_location(machine: &Machine, errors: &ErrorModel, name: ErrorName) -> f64 {
    let mut position = AxisVector::ZERO;
    for axis in machine.axes.iter().flatten().filter(|axis| !axis.axis.is_rotary()) {
        position[axis.axis] = axis.travel.map_or(0.0, |[low, high]| f64::midpoint(low, high));
    }
    let reading = Reading { position, tool_mm: Vector::zeros(), state: State::default() };
    let model = Model::at(machine, errors, &Condition::default());
    let seen = Seen::new(machine, &model, &reading, &reading.tool_mm);
    let of_location: f64 =
        parts(machine, name).iter().flatten().map(|(name, factor)| factor * model.location(*name)).sum();
    angle(&[], &reading, &seen, name).map_or(0.0, |(whole, _)| whole - of_location)
}

/// A reference line over a range of positions, mm.
struct ReferenceLine {
    low: f64,
    step: f64,
}

impl ReferenceLine {
    fn over([low, high]: [f64; 2]) -> ReferenceLine {
        ReferenceLine { low, step: (high - low) / f64::from(PLACES - 1) }
    }

    /// Positions, and the weights with which the deviations at them are the slope of the least-squares line, per mm.
    fn places(&self) -> impl Iterator<Item = (f64, f64)> {
        let count = f64::from(PLACES);
        // Sum of the squares of the distances from the middle, in steps.
        let squares = count * (count * count - 1.0) / 12.0;
        (0..PLACES).map(move |number| {
            let number = f64::from(number);
            (self.low + number * self.step, (number - (count - 1.0) / 2.0) / (squares * self.step))
        })
    }
}

/// Reports readings of location errors that say nothing about the machine, or whose uncertainty is unknown.
pub(in crate::measure) fn check(data: &DataSet, machine: &Machine, findings: &mut Vec<Diagnostic>) {
    let mut known: Vec<ErrorName> = Vec::new();
    for row in &data.observations {
        let Some(name) = row.component.filter(|name| name.is_location()) else { continue };
        if let Some(value) = row.values[0].filter(|value| row.is_angle() && value.abs() > MOST_RAD) {
            let message = format!("{name} = {:.0} µrad is no error of a machine", urad_from_rad(value));
            let help = "check the unit; write the deviation from the nominal angle, in µrad";
            findings.push(Diagnostic::at(Code::DATA_CELL, row.place, message, help));
        }
        if known.contains(&name) {
            continue;
        }
        known.push(name);
        if let Some((term, true)) = squareness_of(machine, name)
            && !is_on_two_sides(machine, &term)
        {
            let [first, second, _] = term.name.parse::<ErrorName>().ok().and_then(plane_of).map_or_else(
                || ["the two".to_owned(), "axes".to_owned(), String::new()],
                |plane| pair(plane).map(|axis| axis.to_string()),
            );
            let message = format!(
                "{name} alone has no effect on the angle between {first} and {second} in this chain: the reading counts as {} with the opposite sign",
                term.name
            );
            let (own, further) = (letter(name), letter(term.name.parse().ok().unwrap_or(name)));
            let help = format!(
                "check that positive means: {own} is rotated relative to {further} by the right-hand rule; to be without this warning, write {} and \
                 the value with the opposite sign",
                term.name
            );
            findings.push(Diagnostic::at(Code::OTHER_LETTER, row.place, message, help));
        }
        let (sigma, key) = if row.is_angle() { (data.sigma_rad, "sigma_urad") } else { (data.sigma, "sigma_um") };
        let is_all_angles = data.sigma.is_some() && data.observations.iter().all(|row| row.is_angle());
        if !data.is_plan && sigma.is_none() && !is_all_angles {
            let message = format!("a reading of {name} itself needs its uncertainty");
            let help = format!("add {key} to [measurement]: the standard uncertainty of the reading");
            findings.push(Diagnostic::at(Code::DATA_CELL, row.place, message, help));
        }
    }
}

/// The letter of the axis of an error.
fn letter(name: ErrorName) -> String {
    name.axis().map_or_else(|| "the spindle".to_owned(), |axis| axis.to_string())
}

/// The plane of a squareness, by the direction of its rotation.
fn plane_of(name: ErrorName) -> Option<Plane> {
    [Plane::YZ, Plane::ZX, Plane::XY].get(name.direction.index().checked_sub(3)?).copied()
}
