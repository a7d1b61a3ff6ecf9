//! Faults of the data, as `ncfix diagnose` looks for them first: reports them, refuses files that say something else than what was measured, and
//! takes out what is at fault.

use super::findings::Findings;
use crate::diagnose::Scene;
use crate::diagnose::fault::{Fault, Then, find, take_sensors_out};
use crate::diagnostic::{Code, Diagnostic};
use crate::machine::Machine;
use crate::measure::data::DataSet;
use crate::model::ErrorModel;
use crate::report::diagnosis::DataFault;

/// Looks for faults and takes sensors out that have one; rows are excluded from a scene with [`crate::diagnose::fault::exclude`]. `None` where the
/// readings cannot even tell the set-ups.
pub(super) fn look(
    machine: &Machine,
    errors: &ErrorModel,
    sets: &mut [DataSet],
    findings: &mut Findings,
    report: &mut Vec<DataFault>,
) -> Option<Vec<Fault>> {
    let faults = find(&Scene::new(machine, errors, sets).ok()?);
    for fault in &faults {
        let Some(set) = sets.get(fault.set) else { continue };
        report.push(reported(fault, set));
        if fault.then == Then::Refuse {
            findings.add(refusal(fault, set), &[]);
        }
    }
    take_sensors_out(sets, &faults);
    Some(faults)
}

fn reported(fault: &Fault, set: &DataSet) -> DataFault {
    let rows = match &fault.then {
        // Single readings are no range.
        Then::WithoutReadings(readings) => {
            let mut rows: Vec<usize> = readings.iter().map(|(row, _)| row + 1).collect();
            rows.dedup();
            rows
        }
        _ => fault.rows.map(|row| row + 1).to_vec(),
    };
    let excluded = match &fault.then {
        Then::Refuse => "the whole file".into(),
        Then::WithoutRows => "these rows".into(),
        Then::WithoutReadings(readings) => format!("{} single readings", readings.len()),
        Then::WithoutSensors(names) => format!("what {} says, as a cause", names.join(" and ")),
        Then::OwnZero => "nothing; the rows behind the step have a zero of their own".into(),
        Then::MoreNoise(_) => "nothing; the readings count with more noise".into(),
    };
    DataFault {
        kind: fault.kind.into(),
        name: fault.name.clone(),
        what: fault.what.clone(),
        rows,
        file: set.name.clone(),
        evidence: fault.evidence.clone(),
        excluded,
    }
}

fn refusal(fault: &Fault, set: &DataSet) -> Diagnostic {
    let name = if fault.name == set.name { String::new() } else { format!(" {}", fault.name) };
    let message = format!("{}{name}: {}: {}", set.name, fault.what, fault.evidence);
    let help = match fault.kind {
        "unit" => {
            "convert the column to the unit that its name says, and check sigma_um (or sigma_urad) in the description"
        }
        "axes" => "exchange or turn the columns, or check how the instrument was mounted; then diagnose again",
        _ => {
            "measure with the table of the control switched off, or give with --machine what the control does not take out"
        }
    };
    Diagnostic::nowhere(Code::DATA_FAULT, message, help)
}
