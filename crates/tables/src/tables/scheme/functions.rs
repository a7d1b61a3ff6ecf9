//! One table for each error function: for controls with their own kinematics (Spaan 1995, chapter 6: 18 functions of three axes).
//!
//! Location errors become part of the functions of their axis, for formats without a place for them: D(e₀)·M(q) = M(q)·D(e) with e = M(q)⁻¹ e₀, which
//! is a function of the position (Spaan adds squareness to a rotation in the same way). Errors of the spindle become part of the last axis of its
//! side.
//!
//! A motion error that also depends on a second axis is taken as its mean over the range of that axis: the control's functions depend on one axis
//! (Spaan neglects the cross-coupling for this reason, chapter 4). [`left_out`] says what the tables then lack.

use super::{Holds, Scheme, Task};
use crate::tables::{AxisErrors, ErrorTables, Orientation, Tables};
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{AxisData, Lever, State};
use ncfix_model::ErrorName;
use ncfix_model::motion::EntryFunction;
use ncfix_model::name::{Carrier, ErrorKind};

pub(super) const SCHEME: Scheme = Scheme {
    name: "functions",
    title: "a table for each error function, for controls with their own kinematics (18 on three axes)",
    needs: &[Holds::Errors],
    home: Orientation::Smooth,
    finds_nodes: false,
    fill: functions,
};

fn functions(task: &Task<'_>) -> Result<Tables, String> {
    let parts = task.errors.parts();
    let has_locations = task.format.can_hold(Holds::Locations);
    let mut tables = ErrorTables::default();
    let data: Vec<&AxisData> = task.target.machine.axes.iter().flatten().collect();
    let last = task.target.machine.topology.tool.last().copied();
    for one in &data {
        let axis = one.axis;
        let positions = super::assembly::positions(axis, task.region, task.points);
        let mut values = vec![[0.0; 6]; positions.len()];
        for (name, function, value) in &parts {
            let is_location = name.kind == ErrorKind::Location;
            if is_location && has_locations {
                continue;
            }
            for (row, &at) in values.iter_mut().zip(&positions) {
                match (name.carrier, is_location) {
                    (Carrier::Axis(own), false) if own == axis => add_motion(task, row, *name, *function, (axis, at)),
                    (Carrier::Axis(own), true) if own == axis => add(row, &moved(*name, *value, one, at)),
                    (Carrier::Spindle, _) if last == Some(axis) => add(row, &spindle(task, *name, *value, one)),
                    _ => {}
                }
            }
        }
        if values.iter().flatten().any(|value| *value != 0.0) {
            let unit = |at: f64| if axis.is_rotary() { at.to_degrees() } else { at };
            tables.axes.push(AxisErrors { axis, positions: positions.into_iter().map(unit).collect(), values });
        }
    }
    if has_locations {
        let locations = parts.iter().filter(|(name, ..)| name.kind == ErrorKind::Location);
        tables.location = locations.map(|&(name, _, value)| (name, value)).collect();
    } else if last.is_none() && parts.iter().any(|(name, ..)| name.carrier == Carrier::Spindle) {
        return Err("errors of the spindle cannot be assigned to an axis on its side".to_owned());
    }
    Ok(Tables { errors: Some(tables), ..Tables::default() })
}

fn add(row: &mut [f64; 6], error: &[f64; 6]) {
    row.iter_mut().zip(error).for_each(|(sum, value)| *sum += value);
}

fn add_motion(
    task: &Task<'_>,
    row: &mut [f64; 6],
    name: ErrorName,
    function: Option<&EntryFunction>,
    (axis, at): (Axis, f64),
) {
    if let Some(function) = function {
        row[name.direction.index()] += over_second(task, function, (axis, at)).0;
    }
}

/// Number of positions of a second axis.
const SECONDS: usize = 64;

/// The mean of a function over the range of its second axis, at a position of its own one, and the largest distance of its values from the mean.
fn over_second(task: &Task<'_>, function: &EntryFunction, (axis, at): (Axis, f64)) -> (f64, f64) {
    let mut pose = AxisVector::default();
    pose[axis] = task.in_turn(axis, at);
    let state = State::default();
    let Some(second) = function.with().filter(|second| *second != axis) else {
        return (function.value(axis, &pose, &state), 0.0);
    };
    let [low, high] = task.region.range(second);
    let mut value_at = |share: f64| {
        pose[second] = task.in_turn(second, low + (high - low) * share);
        function.value(axis, &pose, &state)
    };
    // The middles of equal parts have the mean of a straight line exactly; the ends are farthest from it.
    let mean = (0..SECONDS).map(|index| value_at((index as f64 + 0.5) / SECONDS as f64)).sum::<f64>() / SECONDS as f64;
    let far = (0..=SECONDS).map(|index| (value_at(index as f64 / SECONDS as f64) - mean).abs()).fold(0.0, f64::max);
    (mean, far)
}

/// A part of a motion error that error functions lack: it depends on a second axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondAxisPart {
    /// The error.
    pub name: ErrorName,
    /// Its second axis.
    pub second: Axis,
    /// Largest distance from the mean over the second axis, mm or rad.
    pub largest: f64,
}

/// The parts that tables of error functions lack, one entry for each motion error with a second axis.
#[must_use]
pub fn left_out(task: &Task<'_>) -> Vec<SecondAxisPart> {
    let part = |(name, function, _): (ErrorName, Option<&EntryFunction>, f64)| {
        let (function, axis) = (function?, name.axis()?);
        let second = function.with()?;
        let positions = super::assembly::positions(axis, task.region, task.points);
        let far = positions.iter().map(|&at| over_second(task, function, (axis, at)).1).fold(0.0, f64::max);
        (far > 0.0).then_some(SecondAxisPart { name, second, largest: far })
    };
    task.errors.parts().into_iter().filter_map(part).collect()
}

/// Translation and rotation of a single component.
fn split(name: ErrorName, value: f64) -> (Vector, Vector) {
    let unit = Vector::ith(name.direction.index() % 3, value);
    if name.direction.is_rotation() { (Vector::zeros(), unit) } else { (unit, Vector::zeros()) }
}

fn joined(translation: Vector, rotation: Vector) -> [f64; 6] {
    [translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z]
}

/// A location error as a motion error of its axis at a position.
fn moved(name: ErrorName, value: f64, data: &AxisData, at: f64) -> [f64; 6] {
    let (translation, rotation) = split(name, value);
    if data.lever == Lever::Fixed {
        return joined(translation, rotation);
    }
    if data.axis.is_rotary() {
        return joined(turned(&translation, &data.direction, -at), turned(&rotation, &data.direction, -at));
    }
    joined(translation + rotation.cross(&(data.direction * at)), rotation)
}

/// A vector rotated about a unit vector (Rodrigues).
fn turned(vector: &Vector, about: &Vector, angle: f64) -> Vector {
    let (sin, cos) = angle.sin_cos();
    vector * cos + about.cross(vector) * sin + about * (about.dot(vector) * (1.0 - cos))
}

/// An error of the spindle as an error of the axis that carries it: the rotation acts at the gauge point.
fn spindle(task: &Task<'_>, name: ErrorName, value: f64, data: &AxisData) -> [f64; 6] {
    let (translation, rotation) = split(name, value);
    let arm = data.point_mm - task.target.machine.spindle.origin_mm;
    joined(translation + rotation.cross(&arm), rotation)
}
