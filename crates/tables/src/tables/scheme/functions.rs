//! One table for each error function: for controls with their own kinematics (Spaan 1995, chapter 6: 18 functions of three axes).
//!
//! Location errors become part of the functions of their axis, for formats without a place for them: D(e₀)·M(q) = M(q)·D(e) with e = M(q)⁻¹ e₀, which
//! is a function of the position (Spaan adds squareness to a rotation in the same way). Errors of the spindle become part of the last axis of its
//! side.

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
    for (name, function, _) in &parts {
        if let (Some(_), Some(axis)) = (function.and_then(EntryFunction::with), name.axis()) {
            return Err(format!(
                "a motion error of {axis} depends on a second axis, but the control's functions depend on one"
            ));
        }
    }
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
                    (Carrier::Axis(own), false) if own == axis => {
                        add_motion(row, *name, *function, axis, task.in_turn(axis, at))
                    }
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

fn add_motion(row: &mut [f64; 6], name: ErrorName, function: Option<&EntryFunction>, axis: Axis, at: f64) {
    let mut pose = AxisVector::default();
    pose[axis] = at;
    if let Some(function) = function {
        row[name.direction.index()] += function.value(axis, &pose, &State::default());
    }
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
