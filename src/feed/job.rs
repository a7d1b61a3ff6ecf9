//! A transfer: the program, the machine, the link and the options.

use std::path::Path;

use super::first_answers;
use super::link::ControlLink;
use super::options::FeedOptions;
use super::start_state;
use crate::assumed_start::assumed_start;
use crate::correction::Writing;
use crate::datum;
use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::disk::hash::short_hash;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::Options;
use crate::program::Program;
use crate::run::{self, Opened};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_dialect::Dialect;
use ncfix_dnc::drip::Settings;
use ncfix_dnc::feed::{Dialogue, DosingLimits, FileOptions};
use ncfix_dnc::sense::{Config, Panel};
use ncfix_report::feed::Before;

/// A program that will be sent to a control line by line, corrected for the current temperatures.
///
/// ```
/// use ncfix::prelude::*;
///
/// let machine = Machine::demo();
/// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
/// let transfer = program.feed(&machine, ControlLink::named("siemens-v24")?, &Options::default(), FeedOptions::default())?;
/// assert!(transfer.forecast()?.lines > 2);
/// # Ok::<(), ncfix::Error>(())
/// ```
pub struct Transfer {
    pub(crate) program: Program,
    pub(crate) machine: Machine,
    pub(crate) link: ControlLink,
    /// Hash of the file of the sensors.
    pub(crate) sensors_hash: String,
    pub(crate) options: FeedOptions,
    pub(crate) writing: Writing,
    pub(crate) dialect: &'static Dialect,
    pub(crate) settings: Settings,
    /// Codes of the start that the program does not state.
    pub(super) stated: String,
}

impl Transfer {
    /// Parses the program, which has no stamp; `None` if there are errors.
    ///
    /// # Errors
    /// If the program cannot be written.
    pub(crate) fn new(
        program: Program,
        machine: Machine,
        (mut link, sensors_hash): (ControlLink, String),
        (correction, options): (&Options, FeedOptions),
        found: &mut Diagnostics,
    ) -> Result<Option<Transfer>, Error> {
        let program = program.keeping_subprograms();
        name_file(&mut link, &options)?;
        let mut machine = datum::with_written(&program, &machine);
        if let Some(increment_mm) = correction.increment_mm {
            machine.machine.control.increment_mm = increment_mm;
        }
        let Some(opened) = program.open(Some(&machine), found)? else { return Ok(None) };
        if let Err(why) = link.profile.check_dialect(opened.dialect.name) {
            let help = "choose the link of your control with --link, or its dialect with controller in the machine file; to allow others, list them under dialects in [text] of your own link file";
            found.add(Diagnostic::nowhere(Code::NOT_FOR_LINK, why, help), &[]);
            return Ok(None);
        }
        let source = program.source();
        run::keep_unit(source, opened.dialect, true, &mut machine.machine);
        found.extend(assumed_start(source, opened.dialect, &machine.machine), std::slice::from_ref(source));
        let bytes = (source, short_hash([source.bytes()]));
        let writing = Writing::new(correction, program.reading().start, opened.dialect.name, &machine, bytes)?;
        let limits = DosingLimits {
            per_block: options.dose_per_block_mm,
            per_mm: options.dose_per_mm,
            per_s: options.dose_per_s_mm,
        };
        let settings = Settings {
            limits,
            rapids_only: options.rapids_only,
            is_upper_case: link.profile.is_upper_case,
            keeps_headers: link.profile.protocol.sends_file,
        };
        let dialect = opened.dialect;
        let stated = start_state::unstated(&program, &machine.machine, dialect.language, &link.profile);
        Ok(Some(Transfer { program, machine, link, sensors_hash, options, writing, dialect, settings, stated }))
    }

    /// Opens the program again from its beginning.
    ///
    /// # Errors
    /// Only errors that [`Transfer::new`] would have reported.
    pub(super) fn open(&self) -> Result<Opened, Error> {
        let opened = self.program.open(Some(&self.machine), &mut Diagnostics::default())?;
        opened.ok_or_else(|| Error::usage("the program has changed".into()))
    }

    /// The dialogue of the link.
    ///
    /// # Errors
    /// If the profile does not match it.
    pub(crate) fn dialogue(&self) -> Result<Box<dyn Dialogue>, Error> {
        let profile = &self.link.profile;
        (profile.protocol.create)(profile).map_err(|why| Error::usage(format!("the link {}: {why}", profile.name)))
    }

    /// The reason why nothing may be sent before a person has checked the machine: the link cannot query whether it stands still.
    pub(crate) fn unasked(&self) -> Option<Diagnostic> {
        let profile = &self.link.profile;
        if profile.asks_idle() || self.options.machine_stands_still {
            return None;
        }
        let message = format!(
            "the link {} cannot ask whether the machine stands still; lines sent to a moving machine can interfere with its current motion",
            profile.name
        );
        let help = "check the machine: no program runs, nothing moves, no alarm is active. Then add --i-checked-the-machine-stands-still";
        Some(Diagnostic::nowhere(Code::IDLE_UNKNOWN, message, help))
    }

    /// Opens the sensors of a file; `None` if there is no file, or there are errors.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn panel(&self, path: Option<&Path>, found: &mut Diagnostics) -> Result<Option<Panel>, Error> {
        let Some(path) = path else { return Ok(None) };
        let source = files::read_written(path, FileId(0), files::option("sensors, --sensors"))?;
        let config = match Config::read(&source) {
            Ok(config) => config,
            Err(faults) => {
                found.extend(faults, std::slice::from_ref(&source));
                return Ok(None);
            }
        };
        let names: Vec<&str> = config.channels.iter().map(|channel| channel.name.as_str()).collect();
        if let Some(missing) = self.missing(&names) {
            found.add(missing, &[]);
            return Ok(None);
        }
        if self.link.profile.protocol.sends_file {
            let message = format!(
                "the link {} sends the program as one file: the temperatures at the time of sending apply to the whole run, and later ones have no effect",
                self.link.profile.name
            );
            let help = "send the program shortly before it is started, or use a link that sends lines";
            found.add(Diagnostic::nowhere(Code::WHOLE_FILE, message, help), &[]);
        }
        let opened = Panel::open(&config, path.parent().unwrap_or(Path::new(".")));
        Ok(opened.map_err(|faults| found.extend(faults, std::slice::from_ref(&source))).ok())
    }

    /// Asks each sensor of a file once, and writes the answers into the forecast of a dry run.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(crate) fn ask_sensors(
        &self,
        path: Option<&Path>,
        before: &mut Option<Before>,
        found: &mut Diagnostics,
    ) -> Result<(), Error> {
        if let (Some(mut panel), Some(before)) = (self.panel(path, found)?, before) {
            before.sensors = first_answers::ask(&mut panel);
        }
        Ok(())
    }

    /// A diagnostic if sensors of the model are missing among those of a panel.
    pub(crate) fn missing(&self, channels: &[&str]) -> Option<Diagnostic> {
        let is_known = |name: &str| channels.contains(&name) || self.machine.condition.trace(name).is_some();
        let needed = self.machine.errors.sensors();
        let lacking: Vec<&str> = needed.into_iter().filter(|name| !is_known(name)).collect();
        (!lacking.is_empty()).then(|| missing(&lacking))
    }
}

/// Gives a link that sends a file the path of the options.
///
/// # Errors
/// If the path is not valid, or the link sends lines, or no path is given.
fn name_file(link: &mut ControlLink, options: &FeedOptions) -> Result<(), Error> {
    let sends_file = link.profile.protocol.sends_file;
    match &options.control_file {
        Some(_) if !sends_file => {
            let name = &link.profile.name;
            return Err(Error::usage(format!("the link {name} sends lines, not a file: omit --to")));
        }
        Some(path) => {
            FileOptions::check_path(path).map_err(|why| Error::usage(format!("--to {path}: {why}")))?;
            link.profile.file.path = Some(path.clone());
        }
        None if sends_file && link.profile.file.path.is_none() => {
            return Err(Error::usage(
                "give the path of the file on the control with --to, such as TNC:\\PART.PM".into(),
            ));
        }
        None => {}
    }
    Ok(())
}

/// The diagnostic for missing sensors of the model.
fn missing(names: &[&str]) -> Diagnostic {
    let message = format!(
        "neither the sensors nor the state have a temperature of {}, which the error model needs",
        names.join(", ")
    );
    Diagnostic::nowhere(
        Code::MISSING_SENSOR,
        message,
        "add it to the file of --sensors, or correct its name in the machine file",
    )
}
