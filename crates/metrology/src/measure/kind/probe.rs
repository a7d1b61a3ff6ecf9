//! Probing: axis positions at which the tip's center coincides with a ball of unknown position in the workpiece (SAMBA, RUMBA, chase-the-ball).
//!
//! tip − b = 0 for the ball b of the row, along the directions of F: a drift of the machine or of the probe keeps its direction there while the
//! rotary axes turn. Known distances |b − b′| connect balls. `tool` frees the tool vector, one for each set-up. It turns with
//! the spindle angle in `spindle_deg`, which separates the stylus from the offsets of the spindle itself.

use nalgebra::{Rotation3, Unit};

use super::{Equation, Instrument, Measurand, Seen, Unknown, needed, optional, three, vector_at};
use crate::measure::data::{DataSet, Free, Observation, number_of, text};
use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Matrix, Vector};
use ncfix_model::Model;

/// The kind.
pub(super) const KIND: Instrument = Instrument {
    name: "probe",
    title: "probing of balls with unknown positions",
    measurand: Measurand::BallPlace,
    free: &[Free::Tool],
    read,
    check,
    unknowns,
    start,
    equations,
    ties,
    temperature: None,
    columns: &["target"],
};

fn read(data: &mut DataSet, row: &Row<'_>, sign: DecimalSign, observation: &mut Observation) -> Result<(), Diagnostic> {
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
    observation.spindle_rad = optional(row, row.column("spindle_deg"), sign)?.unwrap_or(0.0).to_radians();
    Ok(())
}

fn check(data: &DataSet, table: &Table, findings: &mut Vec<Diagnostic>) {
    for (number, label) in data.targets.iter().enumerate() {
        let mut rows = data.observations.iter().filter(|row| row.target == Some(number));
        if let (first, None) = (rows.next(), rows.next()) {
            let place = first.map_or_else(|| table.header_place(table.column("target")), |row| row.place);
            let (message, help) = if first.is_some() {
                (
                    format!("the ball {label} was probed once, which determines only its position"),
                    "probe it also at other angles, or remove it",
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

/// The mean of the nominal tips: known distances give no information for coincident balls.
fn start(data: &DataSet, model: &Model) -> Vec<f64> {
    let mut sums = vec![(Vector::zeros(), 0.0); data.targets.len()];
    for observation in &data.observations {
        if let Some((sum, count)) = observation.target.and_then(|target| sums.get_mut(target)) {
            *sum += model.nominal(&observation.reading.position, &observation.reading.tool_mm).translation;
            *count += 1.0;
        }
    }
    let mut values = vec![0.0; unknowns(data).len()];
    for (places, (sum, count)) in values.chunks_exact_mut(3).zip(sums) {
        places.copy_from_slice((sum / f64::max(count, 1.0)).as_slice());
    }
    values
}

fn equations(data: &DataSet, observation: &Observation, seen: &Seen<'_>, values: &[f64], out: &mut Vec<Equation>) {
    let Some(target) = observation.target else { return };
    let ball = vector_at(values, 3 * target);
    let tool = 3 * (data.targets.len() + observation.setup);
    let mut off = seen.actual.translation - ball;
    let mut stylus = Matrix::zeros();
    let has_tool = data.free.contains(&Free::Tool);
    if has_tool {
        let axis = Unit::new_normalize(seen.machine.spindle.axis);
        stylus = seen.actual.rotation * Rotation3::from_axis_angle(&axis, observation.spindle_rad).into_inner();
        off += stylus * vector_at(values, tool);
    }
    for k in 0..3 {
        let direction = seen.direction(k);
        let mut by_unknown: Vec<(usize, f64)> = (0..3).map(|j| (3 * target + j, -direction[j])).collect();
        if has_tool {
            let by_tool = stylus.transpose() * direction;
            by_unknown.extend((0..3).map(|j| (tool + j, by_tool[j])));
        }
        out.push(Equation { residual: -direction.dot(&off), by_tip: direction, by_unknown, ..Equation::default() });
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
