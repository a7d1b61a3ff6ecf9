//! Direct measurement of one component at a time: laser interferometer, level, autocollimator, straightedge.
//!
//! `component` names what was measured, `value_um` or `value_urad` how much: the deviation of the body that the axis moves, at the point of
//! measurement that the tool vector gives, so that a displacement contains the angular errors with their Abbe arms (Spaan 1995, ch. 3).
//! `offset` frees the zero of the instrument for every set-up and component.

use super::{Equation, Kind, Seen, Unknown, at, needed, no_ties, optional, zeros};
use crate::csv::{DecimalSign, Row, Table};
use crate::diagnostic::{Code, Diagnostic};
use crate::machine::Branch;
use crate::measure::data::{DataSet, Free, Observation, number_of, text};
use crate::model::ErrorName;
use crate::model::name::ErrorKind;
use crate::units::{mm_from_um, rad_from_urad};

/// The kind.
pub(super) const KIND: Kind = Kind {
    name: "direct",
    title: "one error component at a time",
    free: &[Free::Offset],
    read,
    check: |_: &DataSet, _: &Table, _: &mut Vec<Diagnostic>| {},
    unknowns,
    start: zeros,
    equations,
    ties: no_ties,
    columns: &["component", "value_um", "value_urad"],
};

fn read(data: &mut DataSet, row: &Row<'_>, sign: DecimalSign, observation: &mut Observation) -> Result<(), Diagnostic> {
    let column = needed(row, "component")?;
    let name = text(row, column);
    let component = name.parse::<ErrorName>().ok().filter(|name| name.kind == ErrorKind::Motion);
    let Some(component) = component else {
        let help = "write a motion error such as EXX, EYX or EAX";
        return Err(Diagnostic::at(Code::DATA_CELL, row.place(column), format!("'{name}' is no motion error"), help));
    };
    observation.component = Some(component);
    observation.target = Some(number_of(&mut data.targets, &name));
    if data.is_plan {
        observation.values[0] = Some(0.0);
        return Ok(());
    }
    let is_rotation = component.direction.is_rotation();
    let (own, other) = if is_rotation { ("value_urad", "value_um") } else { ("value_um", "value_urad") };
    let column = needed(row, own)?;
    if row.column(other).is_some_and(|column| !row.text(column).is_empty()) {
        let message = format!("{name} has no {other}");
        return Err(Diagnostic::at(Code::DATA_CELL, row.place(column), message, format!("write it into {own}")));
    }
    let value = optional(row, Some(column), sign)?;
    observation.values[0] = value.map(if is_rotation { rad_from_urad } else { mm_from_um });
    Ok(())
}

fn unknowns(data: &DataSet) -> Vec<Unknown> {
    let count = if data.free.contains(&Free::Offset) { data.setups.len() * data.targets.len() } else { 0 };
    (0..count).map(|which| Unknown::Offset(which, 0)).collect()
}

fn equations(data: &DataSet, observation: &Observation, seen: &Seen<'_>, values: &[f64], out: &mut Vec<Equation>) {
    let (Some(read), Some(component)) = (observation.values[0], observation.component) else { return };
    // The body that moves: against the tool on the workpiece side.
    let on_table = component.axis().and_then(|axis| seen.machine.topology.branch(axis)) == Some(Branch::Workpiece);
    let sense = if on_table { -1.0 } else { 1.0 };
    let k = component.direction.index() % 3;
    let mut equation = Equation::default();
    let direction = seen.direction(k) * sense;
    let mut predicted = if component.direction.is_rotation() {
        equation.by_turn = direction;
        equation.is_angle = true;
        seen.turn()[k] * sense
    } else {
        equation.by_tip = direction;
        seen.displacement()[k] * sense
    };
    if data.free.contains(&Free::Offset) {
        let place = observation.setup * data.targets.len() + observation.target.unwrap_or(0);
        predicted += at(values, place);
        equation.by_unknown.push((place, 1.0));
    }
    equation.residual = read - predicted;
    out.push(equation);
}
