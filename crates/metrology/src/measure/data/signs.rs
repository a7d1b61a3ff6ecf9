//! Test of the sign of a direct measurement (Spaan 1995, ch. 9): the program moves the tool by a known amount, and the reading must follow.
//!
//! A row with a number in the column `moved_um` belongs to the test: the tool stood beside the position of the row by this number of micrometers, along the
//! measured component. For an angle, `moved_urad` is the turn about it: by a rotary axis, or of the instrument by hand. Rows with 0 are the reference of the others. Readings that do not follow are an error: a wrong sign doubles the errors of the machine.
//! The rows of the test are then removed.

use ncfix_base::csv::{DecimalSign, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::units::{mm_from_um, rad_from_urad};

use super::{DataSet, MOVED, Observation, TURNED};
use crate::measure::kind::Measurand;

/// Range of a reading that follows a move, as a share of the move.
const FOLLOWS: std::ops::RangeInclusive<f64> = 0.8..=1.2;
/// Largest share of a move that counts as standing still.
const STANDS: f64 = 0.05;

/// The known moves of the rows, mm or rad; `None` for rows that are no test.
fn moves(
    table: &Table,
    rows: &[Observation],
    sign: DecimalSign,
    findings: &mut Vec<Diagnostic>,
) -> Option<Vec<Option<f64>>> {
    let columns = [MOVED, TURNED].map(|name| table.column(name));
    if columns == [None, None] {
        return None;
    }
    let mut moves = Vec::new();
    for (row, observation) in table.rows().zip(rows) {
        let is_angle = observation.is_angle();
        let [length, angle] = columns.map(|column| column.filter(|&column| !row.text(column).is_empty()));
        let (own, other) = if is_angle { (angle, length) } else { (length, angle) };
        if let (Some(column), Some(component)) = (other, observation.component) {
            let [right, wrong] = if is_angle { [TURNED, MOVED] } else { [MOVED, TURNED] };
            let message = format!("{component} has no {wrong}");
            findings.push(Diagnostic::at(Code::DATA_CELL, row.place(column), message, format!("write it in {right}")));
        }
        moves.push(own.and_then(|column| match row.number(column, sign) {
            Ok(micro) => Some(if is_angle { rad_from_urad(micro) } else { mm_from_um(micro) }),
            Err(found) => {
                findings.push(found);
                None
            }
        }));
    }
    Some(moves)
}

/// Tests the signs, and removes the rows of the test from a measurement that was read without errors.
pub(super) fn test(data: &mut DataSet, table: &Table, sign: DecimalSign, findings: &mut Vec<Diagnostic>) {
    if data.kind.measurand != Measurand::Component || table.rows().count() != data.observations.len() {
        return;
    }
    let Some(moves) = moves(table, &data.observations, sign, findings) else { return };
    for (number, (row, by)) in data.observations.iter().zip(&moves).enumerate() {
        let (Some(by), Some(component)) = (by.filter(|by| *by != 0.0), row.component) else { continue };
        let is_reference = |other: usize| {
            let known = data.observations.get(other);
            known.is_some_and(|known| known.component == row.component && known.setup == row.setup)
        };
        // The nearest reference before, or the next one.
        let zeros: Vec<usize> =
            (0..moves.len()).filter(|&other| moves[other] == Some(0.0) && is_reference(other)).collect();
        let reference = zeros.iter().rev().find(|&&other| other < number).or(zeros.first());
        let Some(reference) = reference.and_then(|&other| data.observations.get(other)) else {
            let help = "give a row at the same place with a move of 0";
            findings.push(Diagnostic::at(
                Code::DATA_CELL,
                row.place,
                format!("a move of {component} without a reference"),
                help,
            ));
            continue;
        };
        let [Some(now), Some(then)] = [row.values[0], reference.values[0]] else { continue };
        let share = (now - then) / by;
        if FOLLOWS.contains(&share) {
            continue;
        }
        let (message, help) = if FOLLOWS.contains(&-share) {
            (
                format!("the readings of {component} have the opposite sign"),
                "turn the sign of its readings, in ncfix import with --sign",
            )
        } else if share.abs() < STANDS {
            (
                format!("the readings of {component} do not follow a known move"),
                "the instrument reads another direction, or its column belongs to another component",
            )
        } else {
            (
                format!("the readings of {component} follow a known move by a factor of {share:.3}"),
                "check the unit and the direction of the instrument",
            )
        };
        findings.push(Diagnostic::at(Code::DATA_SIGN, row.place, message, help));
    }
    let mut kept = moves.iter().map(Option::is_none);
    data.observations.retain(|_| kept.next().unwrap_or(true));
    for column in &mut data.drivers {
        let mut kept = moves.iter().map(Option::is_none);
        column.values.retain(|_| kept.next().unwrap_or(true));
    }
    data.drivers.retain(|column| column.values.iter().any(|value| !value.is_nan()));
}
