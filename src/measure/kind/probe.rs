//! Probing: axis positions at which the tip's center coincides with a ball of unknown place in the workpiece (SAMBA, RUMBA, chase-the-ball).
//!
//! tip − b = 0 for the ball b of the row; known distances |b − b′| tie balls together. `tool` frees the tool vector, one for each set-up: stylus
//! and spindle offsets.

use super::{Equation, Kind, Seen, Unknown, needed, three, vector_at};
use crate::csv::{DecimalSign, Row, Table};
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::Vector;
use crate::measure::data::{DataSet, Free, Observation, number_of, text};

/// The kind.
pub(super) const KIND: Kind = Kind {
    name: "probe",
    title: "probing of balls of unknown place",
    free: &[Free::Tool],
    read,
    check,
    unknowns,
    equations,
    ties,
    columns: &["target"],
};

fn read(data: &mut DataSet, row: &Row<'_>, _: DecimalSign, observation: &mut Observation) -> Result<(), Diagnostic> {
    let column = needed(row, "target")?;
    let label = text(row, column);
    if label.is_empty() {
        return Err(Diagnostic::at(
            Code::DATA_CELL,
            observation.place,
            "the row names no ball",
            "write its label into target",
        ));
    }
    observation.target = Some(number_of(&mut data.targets, &label));
    Ok(())
}

fn check(data: &DataSet, table: &Table, findings: &mut Vec<Diagnostic>) {
    for (number, label) in data.targets.iter().enumerate() {
        let mut rows = data.observations.iter().filter(|row| row.target == Some(number));
        if let (first, None) = (rows.next(), rows.next()) {
            let place = first.map_or_else(|| table.header_place(table.column("target")), |row| row.place);
            let (message, help) = if first.is_some() {
                (
                    format!("the ball {label} was probed once, which only tells where it is"),
                    "probe it at other angles too, or take it out",
                )
            } else {
                (format!("the ball {label} of [[length]] was not probed"), "check its label")
            };
            findings.push(Diagnostic::at(Code::DATA_CELL, place, message, help));
        }
    }
}

fn unknowns(data: &DataSet) -> Vec<Unknown> {
    let tool = three(data.setups.len(), Unknown::Tool).filter(|_| data.free.contains(&Free::Tool));
    three(data.targets.len(), Unknown::Place).chain(tool).collect()
}

fn equations(data: &DataSet, observation: &Observation, seen: &Seen<'_>, values: &[f64], out: &mut Vec<Equation>) {
    let Some(target) = observation.target else { return };
    let ball = vector_at(values, 3 * target);
    let tool = 3 * (data.targets.len() + observation.setup);
    let mut off = seen.actual.translation - ball;
    let has_tool = data.free.contains(&Free::Tool);
    if has_tool {
        off += seen.actual.rotation * vector_at(values, tool);
    }
    for k in 0..3 {
        let mut by_unknown = vec![(3 * target + k, -1.0)];
        if has_tool {
            by_unknown.extend((0..3).map(|j| (tool + j, seen.actual.rotation[(k, j)])));
        }
        out.push(Equation { residual: -off[k], by_tip: Vector::ith(k, 1.0), by_turn: Vector::zeros(), by_unknown });
    }
}

fn ties(data: &DataSet, values: &[f64], out: &mut Vec<Equation>) {
    for length in &data.lengths {
        let [one, other] = length.between;
        let between = vector_at(values, 3 * other) - vector_at(values, 3 * one);
        let distance = between.norm();
        let along = if distance > 0.0 { between / distance } else { Vector::zeros() };
        let to = |first: usize, sign: f64| (0..3).map(move |k| (3 * first + k, sign * along[k]));
        let by_unknown = to(other, 1.0).chain(to(one, -1.0)).collect();
        let equation = Equation { residual: length.value_mm - distance, by_unknown, ..Equation::default() };
        out.push(equation);
    }
}
