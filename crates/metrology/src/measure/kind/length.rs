//! Lengths along lines: laser interferometers on diagonals (ISO 230-6), and lengths from a station (tracing interferometers, trackers).
//!
//! `dl_um` is the measured minus the nominal change of a length. Along a line with the direction n, dl = n · (tip − nominal tip) + z. From a station at
//! s, dl = |tip − s| − |nominal tip − s₀| + z, with the described place s₀. z is the zero of the set-up, because an interferometer has no absolute length.
//! s may have an unknown correction. The line and the station move with the workpiece.

use super::{
    Equation, Instrument, Measurand, Seen, Unknown, at, needed, no_expansion, no_ties, three, vector_at, zeros,
};
use crate::measure::data::{DataSet, Free, Observation};
use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_base::units::mm_from_um;

/// Name of the unknown z.
const ZERO: &str = "zero of the length";

/// The kind.
pub(super) const KIND: Instrument = Instrument {
    name: "length",
    title: "change of a length along a line, or from a station",
    measurand: Measurand::LineLength,
    free: &[Free::Offset, Free::Centre],
    read,
    check,
    unknowns,
    start: zeros,
    equations,
    ties: no_ties,
    temperature: None,
    columns: &["dl_um"],
};

fn read(data: &mut DataSet, row: &Row<'_>, sign: DecimalSign, observation: &mut Observation) -> Result<(), Diagnostic> {
    observation.values[0] = Some(if data.is_plan { 0.0 } else { mm_from_um(row.number(needed(row, "dl_um")?, sign)?) });
    Ok(())
}

fn check(data: &DataSet, table: &Table, findings: &mut Vec<Diagnostic>) {
    let place = table.header_place(table.column("setup"));
    let mut fault = |message: String, help: String| {
        findings.push(Diagnostic::at(Code::DATA_COLUMN, place, message, help));
    };
    for setup in &data.setups {
        let label = if setup.label.is_empty() { "A" } else { &setup.label };
        match (setup.direction, setup.station_mm) {
            (None, None) => fault(
                format!("the set-up '{}' has no line", setup.label),
                format!("give direction, such as [1, 1, 0], or station_mm in [setup.{label}]"),
            ),
            (Some(_), Some(_)) => fault(
                format!("the set-up '{}' has a direction and a station", setup.label),
                format!("remove one of them from [setup.{label}]"),
            ),
            (Some(_), None) if data.free.contains(&Free::Centre) => fault(
                format!("the set-up '{}' has a direction, and no station that could be free", setup.label),
                "remove centre from free, or give station_mm".into(),
            ),
            _ => {}
        }
    }
    no_expansion(data, table, findings);
}

fn unknowns(data: &DataSet) -> Vec<Unknown> {
    let count = data.setups.len();
    let zero = (0..count).map(|which| Unknown::Own(ZERO, which)).filter(|_| data.free.contains(&Free::Offset));
    let station = three(count, Unknown::Centre).filter(|_| data.free.contains(&Free::Centre));
    zero.chain(station).collect()
}

fn equations(data: &DataSet, observation: &Observation, seen: &Seen<'_>, values: &[f64], out: &mut Vec<Equation>) {
    let (Some(read), Some(setup)) = (observation.values[0], data.setups.get(observation.setup)) else { return };
    let mut by_unknown = Vec::with_capacity(4);
    let mut predicted = 0.0;
    let mut stations = 0;
    if data.free.contains(&Free::Offset) {
        predicted += at(values, observation.setup);
        by_unknown.push((observation.setup, 1.0));
        stations = data.setups.len();
    }
    let along = match (setup.direction, setup.station_mm) {
        (Some(direction), _) => {
            predicted += direction.dot(&(seen.actual.translation - seen.nominal.translation));
            direction
        }
        (None, Some(station_mm)) => {
            let mut command = AxisVector::ZERO;
            command.set_xyz(station_mm);
            let described = seen.model.nominal(&command, &Vector::zeros()).translation;
            let mut station = described;
            if data.free.contains(&Free::Centre) {
                station += vector_at(values, stations + 3 * observation.setup);
            }
            let beam = seen.actual.translation - station;
            let length = beam.norm();
            let along = if length > 0.0 { beam / length } else { Vector::zeros() };
            if data.free.contains(&Free::Centre) {
                by_unknown.extend((0..3).map(|k| (stations + 3 * observation.setup + k, -along[k])));
            }
            predicted += length - (seen.nominal.translation - described).norm();
            along
        }
        (None, None) => return,
    };
    out.push(Equation { residual: read - predicted, by_tip: along, by_unknown, ..Equation::default() });
}
