//! Reads measurements: pairs of a table NAME.csv and a description NAME.toml.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::files;
use super::hash::input_of;
use super::output::{Target, protect};
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_metrology::measure::kind::Instruments;
use ncfix_metrology::measure::trace::Described;
use ncfix_metrology::results::measurement::{self, Measurement, Purpose};
use ncfix_model::ErrorModel;
use ncfix_report::inputs::InputFile;

/// The description of a table, with the same name.
///
/// # Errors
/// If the table cannot have one.
pub(crate) fn description_of(table: &Path) -> Result<PathBuf, Error> {
    measurement::description_of(table).ok_or_else(|| {
        let name = table.display();
        Error::usage(format!("a measurement is a pair of files, NAME.csv and NAME.toml; '{name}' is not a NAME.csv"))
    })
}

/// The tables of measurements that a fit uses, and those that are held out.
pub(crate) struct MeasuredTables {
    /// All tables: first those that are used.
    pub(crate) all: Vec<PathBuf>,
    /// Number of tables that are used.
    pub(crate) used: usize,
}

/// Finds the tables: files are taken as they are, of a folder all its measurements, by name. A table that is found twice counts once.
///
/// # Errors
/// If a folder cannot be read, or has no measurement.
pub(crate) fn tables(used: &[PathBuf], held_out: &[PathBuf]) -> Result<MeasuredTables, Error> {
    let mut all = Vec::new();
    for path in used {
        all.extend(in_folder(path)?.unwrap_or_else(|| vec![path.clone()]));
    }
    if used.iter().any(|path| path.is_dir()) {
        // A file that is named twice, without a folder, is reported where copies of measurements are.
        let mut known = BTreeSet::new();
        all.retain(|path| known.insert(path.clone()));
    }
    let count = all.len();
    for path in held_out {
        all.extend(in_folder(path)?.unwrap_or_else(|| vec![path.clone()]));
    }
    Ok(MeasuredTables { all, used: count })
}

/// The measurements of a folder: tables NAME.csv whose NAME.toml has a section [measurement]; `None` for a file.
fn in_folder(path: &Path) -> Result<Option<Vec<PathBuf>>, Error> {
    if !path.is_dir() {
        return Ok(None);
    }
    let entries = std::fs::read_dir(path).map_err(|error| Error::file("read", path, &error))?;
    let (mut found, mut left) = (Vec::new(), Vec::new());
    for entry in entries.flatten() {
        let table = entry.path();
        let is_table = table.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
        let Some(description) = is_table.then(|| measurement::description_of(&table)).flatten() else { continue };
        // A description that cannot be read is no description; that of another kind of file has no such section.
        let text = std::fs::read(&description)
            .map_or_else(|_| String::new(), |bytes| String::from_utf8_lossy(&bytes).into_owned());
        if text.lines().any(|line| line.trim() == "[measurement]") {
            found.push(table);
        } else {
            left.push(table.display().to_string());
        }
    }
    found.sort();
    left.sort();
    if !left.is_empty() {
        log::warn!("not used, because a description NAME.toml with [measurement] is missing: {}", left.join(", "));
    }
    if found.is_empty() {
        let folder = path.display();
        return Err(Error::usage(format!(
            "the folder {folder} has no measurement: a table NAME.csv with NAME.toml that has a section [measurement]"
        )));
    }
    log::info!("measurements in {}: {}", path.display(), found.len());
    Ok(Some(found))
}

/// Reports outputs that would overwrite an input: `files`, and the pairs of these tables.
///
/// # Errors
/// If a table cannot have a description.
pub(crate) fn protect_inputs<'a>(
    targets: impl IntoIterator<Item = &'a Target>,
    mut files: Vec<PathBuf>,
    tables: impl Iterator<Item = &'a PathBuf>,
    findings: &mut Diagnostics,
) -> Result<(), Error> {
    for path in tables {
        files.extend([path.clone(), description_of(path)?]);
    }
    targets.into_iter().for_each(|target| protect(target, &files, findings));
    Ok(())
}

/// Reads a measurement or the plan of one; `None` if there are errors. `number` identifies the measurement.
///
/// # Errors
/// If a file cannot be read.
pub(crate) fn read(
    table: &Path,
    number: usize,
    is_plan: bool,
    machine: &Machine,
    findings: &mut Diagnostics,
) -> Result<Option<Measurement>, Error> {
    read_for(if is_plan { Purpose::Plan } else { Purpose::Fit }, table, number, machine, findings)
}

/// Reads a measurement and accepts sensors that are dead in some rows. For a trace, only the speed-dependent part in
/// addition to a model is used.
///
/// # Errors
/// If a file cannot be read.
pub(crate) fn read_with_dead(
    table: &Path,
    number: usize,
    (machine, errors): (&Machine, &ErrorModel),
    findings: &mut Diagnostics,
) -> Result<Option<Measurement>, Error> {
    read_for(Purpose::Diagnosis(errors), table, number, machine, findings)
}

fn read_for(
    purpose: Purpose<'_>,
    table: &Path,
    number: usize,
    machine: &Machine,
    findings: &mut Diagnostics,
) -> Result<Option<Measurement>, Error> {
    let description = description_of(table)?;
    let [own, beside] = measurement::ids(number);
    let sources = [
        files::read(table, own, "measurement")?,
        files::read_written(&description, beside, files::FileRole::Description)?,
    ];
    let name = table.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let mut all = sources.to_vec();
    let control = |described: &Described| -> Result<Option<Source>, Error> {
        let Some(path) = measurement::control_file(table, described) else { return Ok(None) };
        let file = files::read(&path, FileId(u16::MAX), "record of the control")?;
        all.push(file.clone());
        Ok(Some(file))
    };
    let mut found = Vec::new();
    let how = (purpose, &Instruments::default());
    let read = measurement::parse(&name, &sources, machine, how, control, &mut found);
    findings.extend(found, &all);
    read
}

/// The texts of measurements.
pub(crate) fn sources_of(all: &[Measurement]) -> Vec<Source> {
    all.iter().flat_map(|one| one.sources.iter().cloned()).collect()
}

/// The files of a measurement, for report pages.
pub(crate) fn inputs(one: &Measurement, is_held_out: bool) -> [InputFile; 2] {
    let roles = if is_held_out { ["readings, held out", "description, held out"] } else { ["readings", "description"] };
    [input_of(&one.sources[0], roles[0]), input_of(&one.sources[1], roles[1])]
}
