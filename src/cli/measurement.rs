//! Reads measurements: pairs of a table NAME.csv and a description NAME.toml.

use std::path::{Path, PathBuf};

use super::findings::Findings;
use super::input::{self, is_standard_stream};
use super::output::Target;
use super::program::protect;
use super::stop::Stop;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_base::units::{rad_from_urad, um_from_mm};
use ncfix_machine::machine::Machine;
use ncfix_metrology::decompose::{self, Of};
use ncfix_metrology::measure::copies::{Copied, copied};
use ncfix_metrology::measure::data::{self, DataSet, Observation};
use ncfix_metrology::measure::trace::{self, Described};
use ncfix_model::ErrorModel;

/// A measurement with its files.
pub(super) struct Measurement {
    /// What was read.
    pub(super) data: DataSet,
    /// Table and description.
    pub(super) sources: [Source; 2],
}

/// The description beside a table.
///
/// # Errors
/// Where there can be none.
pub(super) fn description_of(table: &Path) -> Result<PathBuf, Stop> {
    let is_toml = table.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    if is_standard_stream(table) || is_toml {
        let name = table.display();
        return Err(Stop::Usage(format!(
            "a measurement is a pair of files, NAME.csv and NAME.toml; '{name}' is no NAME.csv"
        )));
    }
    Ok(table.with_extension("toml"))
}

/// Says where something that is written would overwrite what is read: `files`, and the pairs of these tables.
///
/// # Errors
/// Where a table can have no description.
pub(super) fn protect_inputs<'a>(
    targets: impl IntoIterator<Item = &'a Target>,
    mut files: Vec<PathBuf>,
    tables: impl Iterator<Item = &'a PathBuf>,
    findings: &mut Findings,
) -> Result<(), Stop> {
    for path in tables {
        files.extend([path.clone(), description_of(path)?]);
    }
    targets.into_iter().for_each(|target| protect(target, &files, findings));
    Ok(())
}

/// Reads a measurement, or the plan of one; `None` where findings forbid to use it. `number` tells measurements apart.
///
/// # Errors
/// Where a file cannot be read.
pub(super) fn read(
    table: &Path,
    number: usize,
    is_plan: bool,
    machine: &Machine,
    findings: &mut Findings,
) -> Result<Option<Measurement>, Stop> {
    let load = if is_plan { data::load_plan } else { data::load };
    read_by(load, table, number, (machine, Of::Everything), findings)
}

/// Reads a measurement in which sensors may be dead in some rows, which is no refusal; of a trace what goes with the speed, beside a model.
///
/// # Errors
/// Where a file cannot be read.
pub(super) fn read_with_dead(
    table: &Path,
    number: usize,
    (machine, errors): (&Machine, &ErrorModel),
    findings: &mut Findings,
) -> Result<Option<Measurement>, Stop> {
    read_by(data::load_with_dead, table, number, (machine, Of::Speed(errors)), findings)
}

/// Reads the text of a pair of files.
type Load = fn(&str, &Source, &Source, &Machine) -> (Option<DataSet>, Vec<Diagnostic>);

fn read_by(
    load: Load,
    table: &Path,
    number: usize,
    (machine, of): (&Machine, Of<'_>),
    findings: &mut Findings,
) -> Result<Option<Measurement>, Stop> {
    let description = description_of(table)?;
    let id = |offset: usize| FileId(u16::try_from(2 * number + offset).unwrap_or(u16::MAX));
    let sources = [
        input::read(table, id(1), "measurement")?,
        input::read_written(&description, id(2), "its description, beside it")?,
    ];
    let name = table.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    if let Some((described, found)) = trace::describe(&name, &sources[1]) {
        findings.extend(found, &sources);
        return of_trace(table, described, sources, (machine, of), findings);
    }
    let (data, found) = load(&name, &sources[0], &sources[1], machine);
    findings.extend(found, &sources);
    Ok(data.map(|mut data| {
        if reads_angles(&data) {
            // An instrument for angles has as many µrad as one for lengths has µm.
            data.sigma_rad = data.sigma_rad.or(data.sigma.map(|mm| rad_from_urad(um_from_mm(mm))));
        }
        Measurement { data, sources }
    }))
}

/// A trace, brought to one clock.
fn of_trace(
    table: &Path,
    described: Option<Described>,
    sources: [Source; 2],
    (machine, of): (&Machine, Of<'_>),
    findings: &mut Findings,
) -> Result<Option<Measurement>, Stop> {
    let Some(described) = described else { return Ok(None) };
    let mut control = None;
    if let Some(path) = super::trace::control_file(table, &described) {
        let file = input::read(&path, FileId(u16::MAX), "what the control recorded")?;
        match trace::xml::read(&file, &described.signals, machine) {
            Ok(signals) => control = Some(signals),
            Err(found) => {
                findings.extend(found, &[file]);
                return Ok(None);
            }
        }
    }
    let (read, found) = trace::read(&described, &sources[0], control.as_ref(), machine);
    findings.extend(found, &sources);
    let Some(read) = read else { return Ok(None) };
    let place = Place { file: sources[0].id(), span: Span::new(0, 0) };
    match decompose::measurement(machine, &read, of, place) {
        Ok(data) => Ok(Some(Measurement { data, sources })),
        Err(fault) => {
            let help = "ncfix decompose says more of a trace";
            findings.add(Diagnostic::at(Code::NOT_TOLD, place, fault.to_string(), help), &sources);
            Ok(None)
        }
    }
}

/// Says which tables are the same as one before: readings that count twice look better than they are, and those that were fitted are no test.
pub(super) fn check_copies(all: &[Measurement], findings: &mut Findings) {
    for (number, one) in all.iter().enumerate() {
        let same = |other: &&Measurement| other.sources[0].bytes() == one.sources[0].bytes();
        if let Some(first) = all.get(..number).unwrap_or_default().iter().find(same) {
            let message = format!("the table is the same as {}", first.sources[0].name());
            let help = "give each measurement once; hold out readings that were taken again";
            let place = Place { file: one.sources[0].id(), span: Span::new(0, 0) };
            findings.add(Diagnostic::at(Code::DATA_REPEATED, place, message, help), &one.sources);
        }
    }
}

/// Says which tables have readings of one before, rounded or in another order: a judge that was fitted is none.
pub(super) fn check_near_copies(all: &[Measurement], findings: &mut Findings) {
    for (number, one) in all.iter().enumerate() {
        let near = |other: &Measurement| {
            copied(&other.data, &one.data).map(|copied| (other.sources[0].name().to_owned(), copied))
        };
        if let Some((first, Copied { readings, of })) = all.get(..number).unwrap_or_default().iter().find_map(near) {
            let message = format!(
                "{readings} of {of} readings at the same places are those of {first}, rounded or in another order: readings that were taken again differ by their noise"
            );
            let help = "give each measurement once; hold out readings that were taken again";
            let place = Place { file: one.sources[0].id(), span: Span::new(0, 0) };
            findings.add(Diagnostic::at(Code::DATA_REPEATED, place, message, help), &one.sources);
        }
    }
}

/// Whether all readings of a measurement are angles.
pub(super) fn reads_angles(data: &DataSet) -> bool {
    !data.observations.is_empty() && data.observations.iter().all(Observation::is_angle)
}
