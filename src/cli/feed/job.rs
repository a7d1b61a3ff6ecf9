//! What a transfer is about: the program, the machine, the link, the sensors.

use std::path::{Path, PathBuf};

use crate::cli::arguments::FeedArguments;
use crate::cli::findings::Findings;
use crate::cli::input;
use crate::cli::machine_choice::{self, Chosen, short_hash};
use crate::cli::program::{self, Opened};
use crate::cli::state;
use crate::cli::stop::Stop;
use crate::correction::{Writing, corrected_before};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::{FileId, Source};
use ncfix_dialect::Dialect;
use ncfix_dnc::drip::Settings;
use ncfix_dnc::feed::{Links, Profile};
use ncfix_path::emit;

/// What a transfer is about.
pub(in crate::cli) struct Job {
    pub(in crate::cli) source: Source,
    pub(in crate::cli) chosen: Chosen,
    pub(in crate::cli) profile: Profile,
    /// Hash of the profile's text, and of the file of the sensors.
    pub(in crate::cli) link_hash: String,
    pub(in crate::cli) sensors_hash: String,
    pub(in crate::cli) writing: Writing,
    pub(in crate::cli) dialect: &'static Dialect,
    pub(in crate::cli) settings: Settings,
}

impl Job {
    /// Reads what the arguments name; `None` where findings forbid to go on.
    ///
    /// # Errors
    /// Where a file cannot be read, or the program cannot be written.
    pub(in crate::cli) fn new(arguments: &FeedArguments, findings: &mut Findings) -> Result<Option<Job>, Stop> {
        let (profile, link_hash) = profile(&arguments.link, findings)?;
        let sensors_hash = match &arguments.sensors {
            Some(path) => short_hash([input::read_written(path, FileId(0), "sensors, --sensors")?.bytes()]),
            None => String::new(),
        };
        let source = program::read(&arguments.input)?;
        let Some(mut chosen) = machine_choice::choose(&arguments.machine, &arguments.input, findings)? else {
            return Ok(None);
        };
        if chosen.is_demo && !arguments.dry_run {
            return Err(Stop::Usage(
                "the embedded demo machine is nobody's: give --machine, or put the machine file beside the program"
                    .into(),
            ));
        }
        let is_read = match arguments.sensors {
            // What the state does not say, sensors will.
            Some(_) => state::read(&arguments.state, &mut chosen, findings)?,
            None => state::apply(&arguments.state, &mut chosen, findings)?,
        };
        if emit::is_stamped(source.bytes()) {
            findings.add(corrected_before(&source), std::slice::from_ref(&source));
        }
        if let Some(increment_mm) = arguments.correction.increment {
            chosen.machine.control.increment_mm = increment_mm;
        }
        let Some(profile) = profile.filter(|_| is_read && !findings.has_errors()) else { return Ok(None) };
        let Some(opened) = program::open(&source, &arguments.program, Some(&chosen), findings)? else {
            return Ok(None);
        };
        program::keep_unit(&source, opened.dialect, true, &mut chosen.machine);
        let start = arguments.program.start;
        let bytes = (source.bytes(), short_hash([source.bytes()]));
        let writing = Writing::new(&arguments.correction.options(), start, opened.dialect.name, &chosen, bytes)?;
        let settings = Settings {
            limits: arguments.dosing.limits(),
            rapids_only: arguments.dosing.rapids_only,
            is_upper_case: profile.is_upper_case,
        };
        Ok(Some(Job { source, chosen, profile, link_hash, sensors_hash, writing, settings, dialect: opened.dialect }))
    }

    /// The program once more from its beginning.
    ///
    /// # Errors
    /// None that [`Job::new`] would not have met.
    pub(super) fn open(&self, arguments: &FeedArguments) -> Result<Opened, Stop> {
        let opened = program::open(&self.source, &arguments.program, Some(&self.chosen), &mut Findings::default())?;
        opened.ok_or_else(|| Stop::Usage("the program has changed".into()))
    }
}

/// A profile that is shipped, or that of a file, and the hash of its text.
fn profile(link: &str, findings: &mut Findings) -> Result<(Option<Profile>, String), Stop> {
    let links = Links::default();
    let shipped = links.iter().find(|shipped| shipped.name.eq_ignore_ascii_case(link));
    let source = match shipped {
        Some(shipped) => Source::new(FileId(0), &shipped.name, shipped.text.as_bytes().to_vec())
            .map_err(|_| Stop::Usage(format!("the profile {} is too large", shipped.name)))?,
        None if Path::new(link).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) => {
            input::read_written(&PathBuf::from(link), FileId(0), "profile of the link, --link")?
        }
        None => {
            let names: Vec<&str> = links.names().collect();
            return Err(Stop::Usage(format!(
                "there is no link '{link}'; write one of {}, or a profile file (.toml)",
                names.join(", ")
            )));
        }
    };
    let hash = short_hash([source.bytes()]);
    match Profile::read(&source) {
        Ok(profile) => Ok((Some(profile), hash)),
        Err(found) => {
            findings.extend(found, &[source]);
            Ok((None, hash))
        }
    }
}

/// Says that sensors of the model are missing.
pub(super) fn missing(names: &[String]) -> Diagnostic {
    let message = format!(
        "neither the sensors nor the state have a temperature of {}, and the error model needs it",
        names.join(", ")
    );
    Diagnostic::nowhere(
        Code::MISSING_SENSOR,
        message,
        "add it to the file of --sensors, or correct its name in the machine file",
    )
}
