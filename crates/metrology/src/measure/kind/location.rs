//! Readings of a location error itself, such as a squareness that a certificate, a square or another program states.
//!
//! A reading is the number that the machine file has, in µrad or µm: it has no place, no zero and no alignment. A squareness is an angle between two axes, and
//! both may have a location error about the same normal: the reading is the difference of the two if they are on two sides of F, because each of them
//! alone changes the angle. On one side only that of the axis further from F does.

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Plane;
use ncfix_base::units::urad_from_rad;
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::squareness::{SquarenessTerm, pair, squareness};
use ncfix_model::ErrorName;

use crate::measure::data::DataSet;

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
pub(super) fn parts(machine: &Machine, name: ErrorName) -> [Option<(ErrorName, f64)>; 2] {
    let second = squareness_of(machine, name).filter(|(term, _)| is_on_two_sides(machine, term));
    let second = second.and_then(|(term, is_other)| {
        let text = if is_other { &term.name } else { &term.other };
        Some((text.parse::<ErrorName>().ok()?, -1.0))
    });
    [Some((name, 1.0)), second]
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
            let message = format!("{name} has no effect on the angle between {first} and {second} in this chain");
            let help = format!(
                "write the reading as {}: positive opens or closes the angle as in the machine file",
                term.name
            );
            findings.push(Diagnostic::at(Code::DATA_CELL, row.place, message, help));
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

/// The plane of a squareness, by the direction of its rotation.
fn plane_of(name: ErrorName) -> Option<Plane> {
    [Plane::YZ, Plane::ZX, Plane::XY].get(name.direction.index().checked_sub(3)?).copied()
}
