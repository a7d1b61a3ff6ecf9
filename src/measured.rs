//! Correction of positions that were read on a machine: positions as a machine without errors would have read them.

use std::ops::ControlFlow;

use crate::diagnostics::Diagnostics;
use crate::disk::output::{Old, Spool, Target};
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::csv::Table;
use ncfix_base::source::Source;
use ncfix_metrology::measure::reading::Readings;
use ncfix_metrology::results::corrected::{CorrectedReadings, ReadingCorrection};
use ncfix_model::Solve;

/// Corrects the positions in a table of readings, for the machine and its condition, and writes the table to a file;
/// `None` if there are errors. Larger corrections are refused. `progress` receives the completed share.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn correct_file(
    chosen: &Machine,
    source: &Source,
    (solve, max_correction_mm): (Solve, f64),
    target: Target,
    progress: &mut dyn FnMut(f64),
    found: &mut Diagnostics,
) -> Result<Option<CorrectedReadings>, Error> {
    let sources = std::slice::from_ref(source);
    let (table, read) = Table::read(source);
    found.extend(read, sources);
    let Some(table) = table.filter(|_| !found.has_errors()) else { return Ok(None) };
    let Machine { machine, errors, condition, .. } = chosen;
    let readings = match Readings::new(&table, machine) {
        Ok(readings) => readings,
        Err(faults) => {
            found.extend(faults, sources);
            return Ok(None);
        }
    };
    let mut spool = Spool::new(target)?;
    let correction = ReadingCorrection { machine, errors, condition, solve, max_correction_mm };
    let mut take = |faults| {
        found.extend(faults, sources);
        if found.is_hopeless() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let written = correction.write(&table, readings, spool.writer(), progress, &mut take);
    let result = written.map_err(|error| spool.fault(&error))?;
    if found.has_errors() {
        return Ok(None);
    }
    spool.publish(Old::Replaced)?;
    Ok(Some(result))
}
