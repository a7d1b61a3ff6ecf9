//! Input of commands; `-` is standard input.

use super::stop::Stop;
pub(super) use crate::disk::files::{is_standard_stream, option, read, read_written};

/// Refuses JSON and a machine file that would both go to standard output.
///
/// # Errors
/// If both would.
pub(super) fn one_stream(is_json: bool, machine_goes_out: bool) -> Result<(), Stop> {
    if is_json && machine_goes_out {
        let sentence = "--json and the machine file cannot both go to standard output; give -o a file";
        return Err(Stop::Usage(sentence.into()));
    }
    Ok(())
}
