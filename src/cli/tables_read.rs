//! Reads compensation tables of a control: files, several that belong together, archives.

use std::path::{Path, PathBuf};

use super::archive;
use super::findings::Findings;
use super::input;
use super::stop::Stop;
use crate::diagnostic::Diagnostic;
use crate::machine::Machine;
use crate::source::{FileId, Source};
use crate::tables::{Control, FORMATS, Format, Tables, Wiring, format};

/// Tables that were read.
pub(super) struct ReadTables {
    pub(super) tables: Tables,
    pub(super) format: &'static Format,
}

/// Reads tables from files; `None` where findings forbid to use them.
///
/// # Errors
/// Where a file cannot be read, or nothing tells its format.
pub(super) fn read(
    paths: &[PathBuf],
    asked: Option<&'static Format>,
    wiring: &Wiring,
    findings: &mut Findings,
) -> Result<Option<ReadTables>, Stop> {
    let mut tables = Tables::default();
    let mut known = asked;
    let mut is_usable = true;
    for path in paths {
        for source in members(path)? {
            let format = asked.or_else(|| format::guess(source.name(), source.bytes())).or(known);
            let Some(format) = format else { return Err(unknown(path)) };
            known = Some(format);
            let found = (format.read)(&source, wiring, &mut tables);
            is_usable &= !found.iter().any(Diagnostic::is_error);
            findings.extend(found, std::slice::from_ref(&source));
        }
    }
    let Some(format) = known else {
        let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        return Err(Stop::Usage(format!("there are no compensation tables in {}", names.join(", "))));
    };
    Ok(is_usable.then_some(ReadTables { tables, format }))
}

/// The control with the tables that a machine file names as active, and the files; `None` where findings forbid to use them.
///
/// # Errors
/// Where a file cannot be read, or nothing tells its format.
pub(super) fn active(
    paths: &[PathBuf],
    machine: &Machine,
    findings: &mut Findings,
) -> Result<Option<(Control, Vec<Source>)>, Stop> {
    let read = read(paths, None, &Wiring::of(machine), findings)?;
    let mut sources = Vec::new();
    for path in paths {
        sources.extend(members(path)?);
    }
    Ok(read.map(|read| (Control::new(machine, &read.tables), sources)))
}

/// The files with tables at a path: the file itself, or those in an archive.
fn members(path: &Path) -> Result<Vec<Source>, Stop> {
    let source = input::read(path, FileId(0))?;
    match archive::saved_data(path, source.bytes())? {
        None => Ok(vec![source]),
        Some(members) => {
            let is_table = |member: &Source| format::guess(member.name(), member.bytes()).is_some();
            Ok(members.into_iter().filter(is_table).collect())
        }
    }
}

fn unknown(path: &Path) -> Stop {
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
    Stop::Usage(format!("nothing in {} tells its format; give --format: {}", path.display(), names.join(", ")))
}
