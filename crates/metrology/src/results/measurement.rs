//! Measurements as pairs of texts: a table NAME.csv and a description NAME.toml.

use std::path::{Path, PathBuf};

use crate::decompose::{self, Of};
use crate::measure::copies::{Copied, copied};
use crate::measure::data::{self, DataSet, Observation, ReadAs};
use crate::measure::kind::Instruments;
use crate::measure::trace::{self, Described, xml};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source, Span};
use ncfix_base::units::{rad_from_urad, um_from_mm};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// A measurement with its texts.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// What was read.
    pub data: DataSet,
    /// Table and description.
    pub sources: [Source; 2],
}

/// What is read of a pair of texts.
#[derive(Clone, Copy, Debug)]
pub enum Purpose<'a> {
    /// All readings, of a trace too.
    Fit,
    /// A plan: positions without readings.
    Plan,
    /// Readings, with sensors that may be dead in some rows, which is no refusal; of a trace what goes with the speed, beside this model.
    Diagnosis(&'a ErrorModel),
}

/// The identities of the texts of a measurement: `number` tells measurements apart, 0 is left for the machine file.
#[must_use]
pub fn ids(number: usize) -> [FileId; 2] {
    [1, 2].map(|offset| FileId(u16::try_from(2 * number + offset).unwrap_or(u16::MAX)))
}

/// The description beside a table; `None` where there can be none.
#[must_use]
pub fn description_of(table: &Path) -> Option<PathBuf> {
    let is_toml = table.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    (table != Path::new("-") && !is_toml).then(|| table.with_extension("toml"))
}

/// The file of what a control recorded beside a trace, where the description of a table names one.
#[must_use]
pub fn control_file(table: &Path, described: &Described) -> Option<PathBuf> {
    let name = described.control.as_ref()?;
    Some(table.parent().unwrap_or(Path::new(".")).join(name))
}

/// The measurement that a pair of texts is, of one of these kinds; `None` where findings forbid to use it. `control` reads what a control recorded beside a trace, by its
/// description.
///
/// # Errors
/// Those of `control`.
pub fn parse<E>(
    name: &str,
    sources: &[Source; 2],
    machine: &Machine,
    (purpose, instruments): (Purpose<'_>, &Instruments),
    control: impl FnOnce(&Described) -> Result<Option<Source>, E>,
    findings: &mut Vec<Diagnostic>,
) -> Result<Option<Measurement>, E> {
    let data = if let Some((described, found)) = trace::describe(name, &sources[1]) {
        findings.extend(found);
        let of = match purpose {
            Purpose::Fit | Purpose::Plan => Of::Everything,
            Purpose::Diagnosis(errors) => Of::Speed(errors),
        };
        let Some(described) = described else { return Ok(None) };
        let beside = control(&described)?;
        of_trace(&described, &sources[0], beside.as_ref(), (machine, of), findings)
    } else {
        let how = match purpose {
            Purpose::Fit => ReadAs::Readings,
            Purpose::Plan => ReadAs::Plan,
            Purpose::Diagnosis(_) => ReadAs::WithDead,
        };
        let (data, found) = data::load_with(instruments, [&sources[0], &sources[1]], name, machine, how);
        findings.extend(found);
        data.map(|mut data| {
            if reads_angles(&data) {
                // An instrument for angles has as many µrad as one for lengths has µm.
                data.sigma_rad = data.sigma_rad.or(data.sigma.map(|mm| rad_from_urad(um_from_mm(mm))));
            }
            data
        })
    };
    Ok(data.map(|data| Measurement { data, sources: sources.clone() }))
}

/// A trace, brought to one clock.
fn of_trace(
    described: &Described,
    table: &Source,
    control: Option<&Source>,
    (machine, of): (&Machine, Of<'_>),
    findings: &mut Vec<Diagnostic>,
) -> Option<DataSet> {
    let mut signals = None;
    if let Some(file) = control {
        match xml::read(file, &described.signals, machine) {
            Ok(read) => signals = Some(read),
            Err(found) => {
                findings.extend(found);
                return None;
            }
        }
    }
    let (read, found) = trace::read(described, table, signals.as_ref(), machine);
    findings.extend(found);
    let read = read?;
    let place = Place { file: table.id(), span: Span::new(0, 0) };
    match decompose::measurement(machine, &read, of, place) {
        Ok(data) => Some(data),
        Err(fault) => {
            let help = "ncfix decompose says more of a trace";
            findings.push(Diagnostic::at(Code::NOT_TOLD, place, fault.to_string(), help));
            None
        }
    }
}

/// Says which tables are the same as one before: readings that count twice look better than they are, and those that were fitted are no test.
#[must_use]
pub fn check_copies(all: &[Measurement]) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for (number, one) in all.iter().enumerate() {
        let same = |other: &&Measurement| other.sources[0].bytes() == one.sources[0].bytes();
        if let Some(first) = all.get(..number).unwrap_or_default().iter().find(same) {
            let message = format!("the table is the same as {}", first.sources[0].name());
            let help = "give each measurement once; hold out readings that were taken again";
            let place = Place { file: one.sources[0].id(), span: Span::new(0, 0) };
            findings.push(Diagnostic::at(Code::DATA_REPEATED, place, message, help));
        }
    }
    findings
}

/// Says which tables have readings of one before, rounded or in another order: a judge that was fitted is none.
#[must_use]
pub fn check_near_copies(all: &[Measurement]) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
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
            findings.push(Diagnostic::at(Code::DATA_REPEATED, place, message, help));
        }
    }
    findings
}

/// Whether all readings of a measurement are angles.
#[must_use]
pub fn reads_angles(data: &DataSet) -> bool {
    !data.observations.is_empty() && data.observations.iter().all(Observation::is_angle)
}

/// Copies of the data of measurements.
pub(super) fn data_of(all: &[Measurement]) -> Vec<DataSet> {
    all.iter().map(|one| one.data.clone()).collect()
}

/// The first line of a text.
pub(super) fn first_line(source: &Source) -> Place {
    let end = source.bytes().iter().position(|&byte| byte == b'\n' || byte == b'\r');
    Place { file: source.id(), span: Span::new(0, end.unwrap_or(source.bytes().len())) }
}
