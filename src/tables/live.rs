//! Tables that follow the temperatures: the state is read again in every period, and the files are written again when the corrections change.

use std::path::Path;
use std::time::{Duration, Instant};

use super::{TableOptions, Tables, request};
use crate::condition;
use crate::diagnostics::Diagnostics;
use crate::disk::atomic_writes::AtomicWrites;
use crate::disk::files;
use crate::disk::output::Target;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::ConditionFiles;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::significant;
use ncfix_base::source::FileId;
use ncfix_machine::machine::condition::log;
use ncfix_tables::results::compared::difference;
use ncfix_tables::results::result::TablesResult;

/// Interval in which the end of the run is checked.
const LOOK: Duration = Duration::from_millis(50);

/// The times and the change at which tables are written again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Renewal {
    /// Interval between two readings of the state.
    pub(crate) period: Duration,
    /// Change of a correction above which the files are written, µm; µrad of a rotary axis, which are µm at an arm of 1 m.
    pub(crate) least_um: f64,
    /// Time after which the run ends; `None` for no end.
    pub(crate) duration: Option<Duration>,
}

/// Tables whose files are on the disk, and what is needed to make them again.
pub(crate) struct LiveTables<'a> {
    machine: Machine,
    /// Number of files of the machine, without those of the state that are read again.
    files: usize,
    choice: ConditionFiles,
    options: TableOptions,
    output: &'a Path,
    written: Tables,
    /// The state that was read last.
    last: Option<String>,
}

impl<'a> LiveTables<'a> {
    /// Tables that were written to `output` for a machine in a state.
    pub(crate) fn new(
        machine: Machine,
        choice: ConditionFiles,
        options: &TableOptions,
        output: &'a Path,
        written: Tables,
    ) -> LiveTables<'a> {
        let options = TableOptions { tries_fewer: false, each_error: false, ..options.clone() };
        let (files, last) = (machine.files.len(), machine.state.clone());
        LiveTables { machine, files, choice, options, output, written, last }
    }

    /// Renews the tables until the time is over or `is_over` ends the run. `say` gets a sentence for each time that the files were written, `complain`
    /// the reason if the state or the tables cannot be used: the files then stay.
    ///
    /// # Errors
    /// If a file cannot be written, and those of `say`.
    pub(crate) fn run<E: From<Error>>(
        mut self,
        renewal: Renewal,
        is_over: impl Fn() -> bool,
        complain: fn(&Diagnostics),
        say: impl Fn(&str) -> Result<(), E>,
    ) -> Result<(), E> {
        let start = Instant::now();
        let mut next = renewal.period;
        while !is_over() && renewal.duration.is_none_or(|duration| start.elapsed() < duration) {
            if start.elapsed() >= next {
                next = start.elapsed() + renewal.period;
                let mut found = Diagnostics::default();
                match self.renewed(&mut found) {
                    Ok(Some((tables, change_um))) if change_um > renewal.least_um => {
                        self.write(&tables)?;
                        self.written = tables;
                        let (change, path) = (significant(change_um), self.output.display());
                        say(&format!(
                            "{:.1} s: a change of {change} µm: {path} was written\n",
                            start.elapsed().as_secs_f64()
                        ))?;
                    }
                    Ok(_) => {}
                    Err(why) => complain(&not_renewed(&why)),
                }
            }
            std::thread::sleep(LOOK.min(renewal.period));
        }
        Ok(())
    }

    /// The tables for the state as it is now, and their largest change; `None` if the state is the same.
    fn renewed(&mut self, found: &mut Diagnostics) -> Result<Option<(Tables, f64)>, String> {
        for path in &self.choice.files {
            let source =
                files::read(path, FileId(0), files::option("state, --state")).map_err(|error| error.to_string())?;
            // The last row of a log that grows may be half written: its last number would be another one.
            if log::is_log(&source) && source.bytes().last().is_some_and(|&byte| byte != b'\n') {
                return Ok(None);
            }
        }
        self.machine.files.truncate(self.files);
        let is_usable = condition::apply(&self.choice, &mut self.machine, found).map_err(|error| error.to_string())?;
        if is_usable && self.machine.state == self.last {
            return Ok(None);
        }
        self.last.clone_from(&self.machine.state);
        let reason = |found: &Diagnostics| {
            found.first().map_or_else(|| "the state cannot be used".to_owned(), |one| one.message.clone())
        };
        if !is_usable {
            return Err(reason(found));
        }
        let (format, options) = (self.written.format, &self.options);
        let mut errors = Diagnostics::default();
        let made = Tables::make_noting(&self.machine, format, options, &mut TablesResult::default(), &mut errors);
        let Some(tables) = made.map_err(|error| error.to_string())? else { return Err(reason(&errors)) };
        let request = request(&self.machine, options).map_err(|error| error.to_string())?;
        let both = [&self.written.tables, &tables.tables];
        let changes = difference(both, Some(request.machine), &request.region, request.tool_mm, request.poses);
        let changes = changes.map_err(|reason| reason.to_string())?;
        let largest = changes.iter().map(|one| one.max).fold(0.0, f64::max);
        Ok(Some((tables, largest)))
    }

    /// Writes all files, or none.
    fn write(&self, tables: &Tables) -> Result<(), Error> {
        let mut together = AtomicWrites::default();
        for (path, text) in tables.files_at(self.output)? {
            together.add(Target::new(&path)?, text.as_bytes())?;
        }
        together.publish()
    }
}

fn not_renewed(why: &str) -> Diagnostics {
    let help = "the files stay as they are; correct the state: it is read again after --update-s";
    let mut found = Diagnostics::default();
    found.add(Diagnostic::nowhere(Code::NOT_RENEWED, format!("the tables were not renewed: {why}"), help), &[]);
    found
}
