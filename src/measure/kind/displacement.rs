//! Displacement of the tool from the workpiece along F's directions: hole plates, grids, straightedges, R-tests, indicators.
//!
//! An artefact may lie off its nominal place: `offset` shifts and `rotation` turns it, d = d(model) − offset − rotation × p with p the
//! nominal tip in F's directions.

use super::{Equation, Kind, Seen, Unknown, at, no_ties, optional, three, vector_at};
use crate::csv::{DecimalSign, Row, Table};
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::Vector;
use crate::measure::data::{DataSet, Free, Observation};
use crate::units::mm_from_um;

const COLUMNS: [&str; 3] = ["dx_um", "dy_um", "dz_um"];

/// The kind.
pub(super) const KIND: Kind = Kind {
    name: "displacement",
    title: "displacement of the tool from the workpiece",
    free: &[Free::Offset, Free::Rotation],
    read,
    check,
    unknowns,
    equations,
    ties: no_ties,
    columns: &COLUMNS,
};

fn read(_: &mut DataSet, row: &Row<'_>, sign: DecimalSign, observation: &mut Observation) -> Result<(), Diagnostic> {
    for (value, name) in observation.values.iter_mut().zip(COLUMNS) {
        *value = optional(row, row.column(name), sign)?.map(mm_from_um);
    }
    Ok(())
}

fn check(_: &DataSet, table: &Table, findings: &mut Vec<Diagnostic>) {
    if COLUMNS.iter().all(|name| table.column(name).is_none()) {
        let help = "name the columns of the readings dx_um, dy_um, dz_um (any of them)";
        findings.push(Diagnostic::at(
            Code::DATA_COLUMN,
            table.header_place(None),
            "there is no column of readings",
            help,
        ));
    }
}

fn unknowns(data: &DataSet) -> Vec<Unknown> {
    let count = data.setups.len();
    let offset = three(count, Unknown::Offset).filter(|_| data.free.contains(&Free::Offset));
    let rotation = three(count, Unknown::Rotation).filter(|_| data.free.contains(&Free::Rotation));
    offset.chain(rotation).collect()
}

fn equations(data: &DataSet, observation: &Observation, seen: &Seen<'_>, values: &[f64], out: &mut Vec<Equation>) {
    let found = seen.displacement();
    let [has_offset, has_rotation] = [Free::Offset, Free::Rotation].map(|free| data.free.contains(&free));
    let first = 3 * observation.setup;
    let turn = first + if has_offset { 3 * data.setups.len() } else { 0 };
    let place = seen.to_f * seen.nominal.translation;
    let turned = if has_rotation { vector_at(values, turn).cross(&place) } else { Vector::zeros() };
    for (k, read) in observation.values.iter().enumerate().filter_map(|(k, value)| Some((k, (*value)?))) {
        let mut predicted = found[k] - turned[k];
        let mut by_unknown = Vec::with_capacity(4);
        if has_offset {
            predicted -= at(values, first + k);
            by_unknown.push((first + k, -1.0));
        }
        if has_rotation {
            // −(ρ × p)ₖ by ρ: −(p × eₖ).
            let by_turn = -place.cross(&Vector::ith(k, 1.0));
            by_unknown.extend((0..3).map(|j| (turn + j, by_turn[j])));
        }
        out.push(Equation {
            residual: read - predicted,
            by_tip: seen.direction(k),
            by_turn: Vector::zeros(),
            by_unknown,
        });
    }
}
