//! Measured data: tables of readings with their descriptions.

use std::convert::Infallible;
use std::path::Path;

use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::source::{FileId, Source};
use ncfix_metrology::measure::kind::Instruments;
use ncfix_metrology::measure::trace;
use ncfix_metrology::results::measurement::{self, Measurement, Purpose};

/// A measurement from its files: a table of readings (`NAME.csv`) and its description (`NAME.toml`), which contains
/// the instrument and the unknowns of its set-ups. It is interpreted for a machine:
/// [`Calibration::run`](crate::prelude::Calibration::run), [`Diagnosis::run`](crate::prelude::Diagnosis::run).
///
/// ```
/// use ncfix::prelude::*;
///
/// let data = DataSet::read("samples/measurements/ball_bar.csv")?;
/// assert!(!data.check(&Machine::demo()).has_errors());
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct DataSet {
    name: String,
    table: Source,
    description: Source,
    /// The data that a control recorded together with a trace.
    control: Option<Source>,
    pub(crate) is_held_out: bool,
}

impl DataSet {
    /// Reads a table with the description of the same name in its folder, and the recording of the control if the
    /// description names one.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = DataSet::read("samples/measurements/ball_bar.csv")?;
    /// assert_eq!(data.name(), "ball_bar");
    /// assert!(DataSet::read("samples/measurements/none.csv").is_err());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a file cannot be read, or the path does not end with `.csv`.
    pub fn read(path: impl AsRef<Path>) -> Result<DataSet, Error> {
        let path = path.as_ref();
        let Some(beside) = measurement::description_of(path) else {
            let name = path.display();
            return Err(Error::usage(format!(
                "a measurement is a pair of files, NAME.csv and NAME.toml; '{name}' is not a NAME.csv"
            )));
        };
        let [own, other] = measurement::ids(0);
        let table = files::read(path, own, "measurement")?;
        let description = files::read_written(&beside, other, files::FileRole::Description)?;
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let described = trace::describe(&name, &description).and_then(|(described, _)| described);
        let control = described.and_then(|described| measurement::control_file(path, &described));
        let control = control.map(|file| files::read(&file, FileId(u16::MAX), "record of the control")).transpose()?;
        Ok(DataSet { name, table, description, control, is_held_out: false })
    }

    /// A measurement from memory: the bytes of a table and the text of its description. No file is read.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let laser = "component,X,Y,Z,value_um\nEXX,0,0,0,0\nEXX,350,0,0,8\nEXX,700,0,0,17\n";
    /// let data = DataSet::parse("laser", laser, "[measurement]\nkind = \"direct\"\n")?;
    /// assert!(data.check(&Machine::demo()).is_empty());
    /// let wrong = DataSet::parse("laser", laser.replace("350,", "350 mm,"), "[measurement]\nkind = \"direct\"\n")?;
    /// assert_eq!(wrong.check(&Machine::demo()).errors().next().and_then(|one| one.line()), Some(3));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a text is too large.
    pub fn parse(name: &str, table: impl Into<Vec<u8>>, description: impl Into<Vec<u8>>) -> Result<DataSet, Error> {
        let [own, other] = measurement::ids(0);
        let source = |id, ending: &str, bytes: Vec<u8>| {
            let file = format!("{name}.{ending}");
            Source::new(id, &file, bytes).map_err(|_| Error::usage(format!("{file} is too large")))
        };
        let (table, description) = (source(own, "csv", table.into())?, source(other, "toml", description.into())?);
        Ok(DataSet { name: name.to_owned(), table, description, control: None, is_held_out: false })
    }

    /// Holds a data set out: it is not used in the search, only to evaluate the result.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let judge = DataSet::read("samples/measurements/ball_bar.csv")?.held_out();
    /// assert_eq!(judge.name(), "ball_bar");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn held_out(mut self) -> DataSet {
        self.is_held_out = true;
        self
    }

    /// Its name: that of the table without its extension.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(DataSet::parse("laser", "", "")?.name(), "laser");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Checks the data against a machine: unknown keys, missing columns, cells that are not numbers, rows outside the travel.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let data = DataSet::parse("bar", "X,Y\n1,2\n", "[measurement]\nkind = \"ballbar\"\n")?;
    /// assert!(data.check(&Machine::demo()).has_errors(), "dr_um and the set-up are missing");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn check(&self, machine: &Machine) -> Diagnostics {
        let mut found = Diagnostics::default();
        self.measurement(0, machine, (Purpose::Fit, &machine.registry.instruments), &mut found);
        found
    }

    /// The measurement on a machine; `None` if there are errors. `number` identifies the measurement.
    pub(crate) fn measurement(
        &self,
        number: usize,
        machine: &Machine,
        how: (Purpose<'_>, &Instruments),
        found: &mut Diagnostics,
    ) -> Option<Measurement> {
        let [own, other] = measurement::ids(number);
        let sources = [with_id(&self.table, own), with_id(&self.description, other)];
        let all: Vec<Source> = sources.iter().chain(&self.control).cloned().collect();
        let mut diagnostics = Vec::new();
        let control = |_: &trace::Described| Ok::<_, Infallible>(self.control.clone());
        let Ok(read) = measurement::parse(&self.name, &sources, &machine.machine, how, control, &mut diagnostics);
        found.extend(diagnostics, &all);
        read
    }
}

/// The text with another identity.
fn with_id(source: &Source, id: FileId) -> Source {
    // It was not too large before.
    Source::new(id, source.name(), source.bytes().to_vec()).unwrap_or_else(|_| source.clone())
}

/// The measurements of data on a machine, used ones first, their number, and their texts; `None` if there are
/// errors.
pub(crate) fn measurements(
    data: &[DataSet],
    machine: &Machine,
    how: (Purpose<'_>, &Instruments),
    found: &mut Diagnostics,
) -> Option<(Vec<Measurement>, usize, Vec<Source>)> {
    let used = data.iter().filter(|one| !one.is_held_out);
    let count = used.clone().count();
    let ordered = used.chain(data.iter().filter(|one| one.is_held_out)).enumerate();
    let all: Vec<Measurement> =
        ordered.filter_map(|(number, one)| one.measurement(number, machine, how, found)).collect();
    let sources = all.iter().flat_map(|one| one.sources.iter().cloned()).collect();
    (!found.has_errors()).then_some((all, count, sources))
}
