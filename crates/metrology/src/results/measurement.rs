//! Measurements as pairs of texts: a table NAME.csv and a description NAME.toml.

use std::path::{Path, PathBuf};

use crate::decompose::{self, Of};
use crate::measure::copies::{Copied, ReadingsByPlace, copied};
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
    /// The readings.
    pub data: DataSet,
    /// Table and description.
    pub sources: [Source; 2],
}

/// Required content of a pair of texts.
#[derive(Clone, Copy, Debug)]
pub enum Purpose<'a> {
    /// All readings, including those of a trace.
    Fit,
    /// A plan: positions without readings.
    Plan,
    /// Readings, with temperature sensors that may have failed in some rows; of a trace the speed-dependent part relative to this model.
    Diagnosis(&'a ErrorModel),
}

/// The ids of the texts of a measurement: `number` identifies the measurement, 0 is reserved for the machine file.
#[must_use]
pub fn ids(number: usize) -> [FileId; 2] {
    [1, 2].map(|offset| FileId(u16::try_from(2 * number + offset).unwrap_or(u16::MAX)))
}

/// The description next to a table; `None` if there cannot be one.
#[must_use]
pub fn description_of(table: &Path) -> Option<PathBuf> {
    let is_toml = table.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    (table != Path::new("-") && !is_toml).then(|| table.with_extension("toml"))
}

/// The control recording next to a trace, if the description of the table names one.
#[must_use]
pub fn control_file(table: &Path, described: &Described) -> Option<PathBuf> {
    let name = described.control.as_ref()?;
    Some(table.parent().unwrap_or(Path::new(".")).join(name))
}

/// The measurement of a pair of texts, of one of these kinds; `None` if there are errors. `control` reads the control recording next to a
/// trace, given its description.
///
/// # Errors
/// Errors of `control`.
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
                // An angle instrument has as many µrad as a length instrument has µm.
                data.sigma_rad = data.sigma_rad.or(data.sigma.map(|mm| rad_from_urad(um_from_mm(mm))));
            }
            data
        })
    };
    Ok(data.map(|data| Measurement { data, sources: sources.clone() }))
}

/// A trace on a common clock.
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
            let help = "ncfix decompose shows more about a trace";
            findings.push(Diagnostic::at(Code::NOT_TOLD, place, fault.to_string(), help));
            None
        }
    }
}

/// Reports tables that equal an earlier one, or contain its readings rounded or reordered: readings that count twice underestimate uncertainties, and
/// fitted ones are not an independent test.
#[must_use]
pub fn check_copies(all: &[Measurement]) -> Vec<Diagnostic> {
    let tell = |one: &Measurement, message: String| {
        let help = "give each measurement once; hold out repeated readings";
        let place = Place { file: one.sources[0].id(), span: Span::new(0, 0) };
        Diagnostic::at(Code::DATA_REPEATED, place, message, help)
    };
    let mut findings = Vec::new();
    for (number, one) in all.iter().enumerate() {
        let same = |other: &&Measurement| other.sources[0].bytes() == one.sources[0].bytes();
        if let Some(first) = all.get(..number).unwrap_or_default().iter().find(same) {
            findings.push(tell(one, format!("the table is the same as {}", first.sources[0].name())));
        }
    }
    if !findings.is_empty() || all.len() < 2 {
        return findings;
    }
    let by_place: Vec<ReadingsByPlace> = all.iter().map(|one| ReadingsByPlace::new(&one.data)).collect();
    for (number, (one, own)) in all.iter().zip(&by_place).enumerate() {
        let mut earlier = all.iter().zip(&by_place).take(number);
        let near = earlier.find_map(|(first, of_first)| Some((first.sources[0].name(), copied(of_first, own)?)));
        if let Some((first, Copied { readings, of })) = near {
            findings.push(tell(
                one,
                format!(
                    "{readings} of {of} readings at the same places are those of {first}, rounded or in another order: repeated readings would differ by their noise"
                ),
            ));
        }
    }
    findings
}

/// `true` if all readings of a measurement are angles.
#[must_use]
pub fn reads_angles(data: &DataSet) -> bool {
    !data.observations.is_empty() && data.observations.iter().all(Observation::is_angle)
}

/// Copies of the data of measurements.
#[must_use]
pub fn data_of(all: &[Measurement]) -> Vec<DataSet> {
    all.iter().map(|one| one.data.clone()).collect()
}

/// The first line of a text.
pub(super) fn first_line(source: &Source) -> Place {
    let end = source.bytes().iter().position(|&byte| byte == b'\n' || byte == b'\r');
    Place { file: source.id(), span: Span::new(0, end.unwrap_or(source.bytes().len())) }
}
