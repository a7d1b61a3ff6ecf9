//! Reads program and machine files; `-` is standard input.

use std::fs;
use std::io::{self, Read as _};
use std::path::Path;

use super::progress;
use super::stop::Stop;
use super::voice;
use crate::source::{FileId, MAX_BYTES, Source};

/// The name shown for standard input.
pub(super) const STANDARD_INPUT: &str = "<stdin>";

/// Whether a path on the command line means standard input or output.
pub(super) fn is_standard_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Standard output takes one of both.
///
/// # Errors
/// Where it would be both.
pub(super) fn one_stream(is_json: bool, machine_goes_out: bool) -> Result<(), Stop> {
    if is_json && machine_goes_out {
        return Err(Stop::Usage(
            "--json and the machine file cannot both go to standard output; give -o a file".into(),
        ));
    }
    Ok(())
}

/// The bytes of a file with the name to show for it; `role` says in a note what it is and how it was found; without one nothing
/// is noted, where a file is read again.
///
/// # Errors
/// A sentence where the file cannot be read or is too large.
pub(super) fn read(path: &Path, id: FileId, role: &str) -> Result<Source, Stop> {
    // An option that named the file is named in turn.
    let is_option = role.contains("--") || role.contains("NCFIX_");
    let fault = |error: io::Error| match Stop::file("read", path, &error) {
        Stop::Usage(sentence) if is_option => Stop::Usage(format!("{sentence} ({role})")),
        stop => stop,
    };
    let (name, bytes) = if is_standard_stream(path) {
        // Whoever types it sees what he types.
        progress::end();
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes).map_err(fault)?;
        (STANDARD_INPUT.to_owned(), bytes)
    } else {
        // Some systems open a folder and fail with an odd reason when it is read.
        if path.is_dir() {
            return Err(fault(io::ErrorKind::IsADirectory.into()));
        }
        (path.display().to_string(), fs::read(path).map_err(fault)?)
    };
    if !role.is_empty() {
        voice::note(|| format!("read {name}: {role}"));
    }
    Source::new(id, &name, bytes)
        .map_err(|_| Stop::Usage(format!("cannot read {name}: it has more than {MAX_BYTES} bytes")))
}
