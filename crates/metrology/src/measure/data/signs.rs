//! Test of the sign of a direct measurement (Spaan 1995, ch. 9): the program moves the tool by a known amount, and the reading must follow.
//!
//! A row with a number in the column `moved_um` belongs to the test: the tool stood beside the position of the row by this number of micrometers, along the
//! measured component. Rows with 0 are the reference of the others. Readings that do not follow are an error: a wrong sign doubles the errors of the machine.
//! The rows of the test are then removed.

use ncfix_base::csv::{DecimalSign, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::units::mm_from_um;

use super::{DataSet, MOVED};
use crate::measure::kind::Measurand;

/// Range of a reading that follows a move, as a share of the move.
const FOLLOWS: std::ops::RangeInclusive<f64> = 0.8..=1.2;
/// Largest share of a move that counts as standing still.
const STANDS: f64 = 0.05;

/// The known moves of the rows, mm; `None` for rows that are no test.
fn moves(table: &Table, sign: DecimalSign, findings: &mut Vec<Diagnostic>) -> Option<Vec<Option<f64>>> {
    let column = table.column(MOVED)?;
    let mut moves = Vec::new();
    for row in table.rows() {
        moves.push(match row.text(column) {
            [] => None,
            _ => match row.number(column, sign) {
                Ok(um) => Some(mm_from_um(um)),
                Err(found) => {
                    findings.push(found);
                    None
                }
            },
        });
    }
    Some(moves)
}

/// Tests the signs, and removes the rows of the test from a measurement that was read without errors.
pub(super) fn test(data: &mut DataSet, table: &Table, sign: DecimalSign, findings: &mut Vec<Diagnostic>) {
    let Some(moves) = moves(table, sign, findings) else { return };
    if data.kind.measurand != Measurand::Component || moves.len() != data.observations.len() {
        return;
    }
    for (number, (row, by_mm)) in data.observations.iter().zip(&moves).enumerate() {
        let (Some(by_mm), Some(component)) = (by_mm.filter(|by| *by != 0.0), row.component) else { continue };
        let is_reference = |other: usize| {
            let known = data.observations.get(other);
            known.is_some_and(|known| known.component == row.component && known.setup == row.setup)
        };
        // The nearest reference before, or the next one.
        let zeros: Vec<usize> =
            (0..moves.len()).filter(|&other| moves[other] == Some(0.0) && is_reference(other)).collect();
        let reference = zeros.iter().rev().find(|&&other| other < number).or(zeros.first());
        let Some(reference) = reference.and_then(|&other| data.observations.get(other)) else {
            let help = "give a row at the same place with moved_um 0";
            findings.push(Diagnostic::at(
                Code::DATA_CELL,
                row.place,
                format!("a move of {component} without a reference"),
                help,
            ));
            continue;
        };
        let [Some(now), Some(then)] = [row.values[0], reference.values[0]] else { continue };
        let share = (now - then) / by_mm;
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
