//! Ball-bar: change of the distance between a ball in the spindle and one on the table (ISO 230-4).
//!
//! dr = |tip − c| − L, with the position c of the table ball and the length L from the description of the set-up. Both may have unknown corrections:
//! c three, and L one for every set-up, or for every extension rod that set-ups share. L is the length at 20 °C. A rod of known expansion is longer
//! when warmer, and its temperature may be unknown instead of the length. The table ball moves with the workpiece.

use super::{
    Equation, Instrument, Measurand, Seen, Unknown, at, needed, no_expansion, no_ties, three, vector_at, zeros,
};
use crate::measure::data::{DataSet, Free, Observation};
use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_base::units::mm_from_um;

/// The kind.
pub(super) const KIND: Instrument = Instrument {
    name: "ballbar",
    title: "distance of two balls",
    measurand: Measurand::BallDistance,
    free: &[Free::Centre, Free::Length, Free::Rod, Free::RodTemperature],
    read,
    check,
    unknowns,
    start: zeros,
    equations,
    ties: no_ties,
    temperature: Some("T_rod_C"),
    columns: &["dr_um"],
};

fn read(data: &mut DataSet, row: &Row<'_>, sign: DecimalSign, observation: &mut Observation) -> Result<(), Diagnostic> {
    if data.is_plan {
        observation.values[0] = Some(0.0);
        return Ok(());
    }
    observation.values[0] = Some(mm_from_um(row.number(needed(row, "dr_um")?, sign)?));
    Ok(())
}

fn check(data: &DataSet, table: &Table, findings: &mut Vec<Diagnostic>) {
    for setup in data.setups.iter().filter(|setup| setup.length_mm <= 0.0) {
        let message = format!("the ball-bar of the set-up '{}' has no length", setup.label);
        let help = format!(
            "give length_mm and centre_mm in [setup.{}]",
            if setup.label.is_empty() { "A" } else { &setup.label }
        );
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(table.column("setup")), message, help));
    }
    no_expansion(data, table, findings);
}

fn unknowns(data: &DataSet) -> Vec<Unknown> {
    let count = data.setups.len();
    let centre = three(count, Unknown::Centre).filter(|_| data.free.contains(&Free::Centre));
    let length = (0..count).map(Unknown::Length).filter(|_| data.free.contains(&Free::Length));
    let rod = (0..data.rods.len()).map(Unknown::Rod).filter(|_| data.free.contains(&Free::Rod));
    let warmth = (0..count).map(Unknown::RodTemperature).filter(|_| data.free.contains(&Free::RodTemperature));
    // The description has at most one of the last three.
    centre.chain(length).chain(rod).chain(warmth).collect()
}

fn equations(data: &DataSet, observation: &Observation, seen: &Seen<'_>, values: &[f64], out: &mut Vec<Equation>) {
    let (Some(read), Some(setup)) = (observation.values[0], data.setups.get(observation.setup)) else { return };
    let mut command = AxisVector::ZERO;
    command.set_xyz(setup.centre_mm);
    let mut ball = seen.model.nominal(&command, &Vector::zeros()).translation;
    let stretch = data.stretch(observation);
    let mut length_mm = setup.length_mm * stretch;
    let mut place = 0;
    let mut by_unknown = Vec::with_capacity(4);
    let mut centre_place = None;
    if data.free.contains(&Free::Centre) {
        centre_place = Some(3 * observation.setup);
        ball += vector_at(values, 3 * observation.setup);
        place = 3 * data.setups.len();
    }
    let bar = seen.actual.translation - ball;
    let distance = bar.norm();
    let along = if distance > 0.0 { bar / distance } else { Vector::zeros() };
    if let Some(first) = centre_place {
        by_unknown.extend((0..3).map(|k| (first + k, -along[k])));
    }
    let has = |free: Free| data.free.contains(&free);
    let longer = if has(Free::Length) {
        Some((observation.setup, stretch))
    } else if has(Free::Rod) {
        Some((setup.rod, stretch))
    } else {
        has(Free::RodTemperature).then_some((observation.setup, 1.0))
    };
    if let Some((which, share)) = longer {
        length_mm += at(values, place + which) * share;
        by_unknown.push((place + which, -share));
    }
    let residual = read - (distance - length_mm);
    out.push(Equation { residual, by_tip: along, by_unknown, ..Equation::default() });
}
