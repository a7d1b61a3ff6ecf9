//! Displacement of the tool from the workpiece along F's directions: hole plates, grids, straightedges, R-tests, indicators.
//!
//! An artefact may be displaced from its nominal position: `offset` and `rotation` move it in the workpiece, with which it turns. A point with the
//! nominal position p is at R p + o, so that the displacement of the tool is d = F's directions of (tip − R p − o). R is exact: the square of 1 mrad
//! over 500 mm gives 0.25 µm. An artifact of known expansion and temperature is scaled before, about its origin.

use nalgebra::Rotation3;

use super::{Equation, Instrument, Measurand, Seen, Unknown, no_expansion, no_ties, optional, three, vector_at, zeros};
use crate::measure::data::{DataSet, Free, Observation};
use crate::measure::nest::SensorNest;
use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;
use ncfix_base::units::mm_from_um;

pub(super) const COLUMNS: [&str; 3] = ["dx_um", "dy_um", "dz_um"];

/// Cell of a reading that the row does not give, in a plan and in its measurement: the center of a hole has no height.
pub const NOT_READ: &str = "-";

/// The kind.
pub(super) const KIND: Instrument = Instrument {
    name: "displacement",
    title: "displacement of the tool from the workpiece",
    measurand: Measurand::Displacement,
    free: &[Free::Offset, Free::Rotation],
    read,
    check,
    unknowns,
    start: zeros,
    equations,
    ties: no_ties,
    temperature: Some("T_artefact_C"),
    columns: &COLUMNS,
};

pub(super) fn read(
    data: &mut DataSet,
    row: &Row<'_>,
    sign: DecimalSign,
    observation: &mut Observation,
) -> Result<(), Diagnostic> {
    let is_read = |column: usize| row.text(column).trim_ascii() != NOT_READ.as_bytes();
    if data.is_plan {
        // Existing columns determine the readings; without any, all three are read.
        let wants_all = COLUMNS.iter().all(|name| row.column(name).is_none());
        for (value, name) in observation.values.iter_mut().zip(COLUMNS) {
            *value = (wants_all || row.column(name).is_some_and(is_read)).then_some(0.0);
        }
        return Ok(());
    }
    if let Some(sensors) = &data.sensors {
        return read_sensors(sensors, row, sign, observation);
    }
    for (value, name) in observation.values.iter_mut().zip(COLUMNS) {
        *value = optional(row, row.column(name).filter(|&column| is_read(column)), sign)?.map(mm_from_um);
    }
    Ok(())
}

/// Reads three sensors with directions of their own: each displacement needs all of them.
fn read_sensors(
    sensors: &SensorNest,
    row: &Row<'_>,
    sign: DecimalSign,
    observation: &mut Observation,
) -> Result<(), Diagnostic> {
    let [first, ..] = &sensors.columns;
    let mut readings = [None; 3];
    for (reading, name) in readings.iter_mut().zip(&sensors.columns) {
        *reading = optional(row, row.column(name), sign)?;
    }
    let place = row.place(row.column(first).unwrap_or_default());
    match readings {
        [None, None, None] => return Ok(()),
        [Some(one), Some(two), Some(three)] => {
            let readings = [one, two, three];
            if let Some((message, help)) = sensors.beyond_text(&readings) {
                return Err(Diagnostic::at(Code::DATA_SIZE, place, message, help));
            }
            let [x, y, z]: [f64; 3] = sensors.displacement_mm(&readings).into();
            observation.values = [Some(x), Some(y), Some(z)];
        }
        _ => {
            let help = "a displacement needs the readings of all three sensors: leave all of them empty, or fill all";
            return Err(Diagnostic::at(Code::DATA_CELL, place, "a sensor without a reading", help));
        }
    }
    Ok(())
}

pub(super) fn check(data: &DataSet, table: &Table, findings: &mut Vec<Diagnostic>) {
    if let Some(sensors) = data.sensors.as_ref().filter(|_| !data.is_plan) {
        sensors.missing(table, findings);
    } else if !data.is_plan && COLUMNS.iter().all(|name| table.column(name).is_none()) {
        let is_in_mm = COLUMNS.iter().any(|name| table.column(&name.replace("_um", "_mm")).is_some());
        let help = match is_in_mm {
            true => "convert the readings to µm, and name their columns dx_um, dy_um, dz_um",
            false => "name the columns of the readings dx_um, dy_um, dz_um (any of them)",
        };
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), "there is no reading column", help));
    }
    no_expansion(data, table, findings);
}

pub(super) fn unknowns(data: &DataSet) -> Vec<Unknown> {
    let count = data.setups.len();
    let offset = three(count, Unknown::Offset).filter(|_| data.free.contains(&Free::Offset));
    let rotation = three(count, Unknown::Rotation).filter(|_| data.free.contains(&Free::Rotation));
    offset.chain(rotation).collect()
}

pub(super) fn equations(
    data: &DataSet,
    observation: &Observation,
    seen: &Seen<'_>,
    values: &[f64],
    out: &mut Vec<Equation>,
) {
    let [has_offset, has_rotation] = [Free::Offset, Free::Rotation].map(|free| data.free.contains(&free));
    let first = 3 * observation.setup;
    let turn = first + if has_offset { 3 * data.setups.len() } else { 0 };
    let mut point = seen.nominal.translation;
    let setup = data.setups.get(observation.setup);
    if let Some(origin) = setup.filter(|setup| setup.expansion_per_k > 0.0).and_then(|setup| setup.origin_mm) {
        // The points of a warm artifact move away from its origin.
        point = origin + (point - origin) * data.stretch(observation);
    }
    let mut angle = Vector::zeros();
    if has_rotation {
        angle = vector_at(values, turn);
        point = Rotation3::new(angle) * point;
    }
    let turned = point;
    if has_offset {
        point += vector_at(values, first);
    }
    let off = seen.to_f * (seen.actual.translation - point);
    for (k, read) in observation.values.iter().enumerate().filter_map(|(k, value)| Some((k, (*value)?))) {
        let direction = seen.direction(k);
        let mut by_unknown = Vec::with_capacity(6);
        if has_offset {
            by_unknown.extend((0..3).map(|j| (first + j, -direction[j])));
        }
        if has_rotation {
            // A small change of the rotation vector rotates the point by (1 + ρ×/2 + (ρ×)²/6 + …) of it.
            let by_turn = -turned.cross(&direction);
            let half = angle.cross(&by_turn) / 2.0;
            let by_angle = by_turn - half + angle.cross(&half) / 3.0;
            by_unknown.extend((0..3).map(|j| (turn + j, by_angle[j])));
        }
        out.push(Equation { residual: read - off[k], by_tip: direction, by_unknown, ..Equation::default() });
    }
}
