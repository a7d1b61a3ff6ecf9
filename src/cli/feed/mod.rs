//! `ncfix feed`: sends a program to a control line by line, corrected for the temperatures of the moment.
//!
//! The program is run twice. The first time ([`survey`]) nothing is sent: all findings come up, every line is held against the link, and the forecast is
//! made. The second time a thread of its own executes and corrects ([`source`]), another one looks at the temperatures ([`thermal`]), and the main one
//! adds the second step, sends and listens ([`drive`]).

pub(in crate::cli) mod arguments;

mod book;
mod drive;
mod job;
mod meter;
mod show;
mod source;
mod survey;
mod thermal;

use std::path::Path;

use super::arguments::FeedArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::stop::Stop;
use super::{input, print, tell};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_dnc::feed::{Dialogue, port};
use ncfix_dnc::sense::{Config, Panel};
use ncfix_report::feed::Before;
use ncfix_report::json;

pub(super) use book::{TAKEN_UP, is_held};
pub(super) use drive::Begin;
pub(super) use job::Job;
pub(super) use survey::{Step, walk};

/// Sends a program.
pub(super) fn run(arguments: &FeedArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let prepared = prepare(arguments, &mut findings);
    let (job, before) = match prepared {
        Ok(Some((job, mut before))) => {
            before.diagnostics = findings.json();
            (job, before)
        }
        Ok(None) => {
            findings.draw();
            tell(&format!("{}; nothing was sent\n", findings.count()));
            return Ok(findings.exit_code());
        }
        Err(stop) => {
            findings.draw();
            return Err(stop);
        }
    };
    findings.draw();
    if arguments.json {
        print(&json::line(&before).map_err(Stop::Usage)?)?;
    } else if arguments.dry_run {
        print(&before.table())?;
    } else {
        tell(&before.table());
    }
    if findings.has_errors() {
        tell(&format!("{}; nothing was sent\n", findings.count()));
        return Ok(findings.exit_code());
    }
    if arguments.dry_run {
        return Ok(ExitCode::Done);
    }
    let begin = Begin { words: std::env::args().skip(1).collect(), ..Begin::default() };
    send(arguments, job, &before, &begin)
}

/// Opens the port and sends.
///
/// # Errors
/// Where the port cannot be opened, or the journal not be written.
pub(super) fn send(arguments: &FeedArguments, job: Job, before: &Before, begin: &Begin) -> Result<ExitCode, Stop> {
    let name = arguments.port.as_deref().ok_or_else(|| Stop::Usage("--port is missing".into()))?;
    if !asks_idle(&job) && !arguments.i_checked_the_machine_stands_still {
        let mut findings = Findings::default();
        findings.add(unasked(&job), &[]);
        findings.draw();
        tell(&format!("{}; nothing was sent\n", findings.count()));
        return Ok(findings.exit_code());
    }
    let opened = port::open(name, &job.profile).map_err(|sentence| Stop::Ended(ExitCode::Link, sentence))?;
    drive::run(arguments, job, opened, before, begin)
}

/// Reads everything and walks through the program; `None` where findings forbid to send it.
///
/// # Errors
/// Where a file cannot be read, or the program cannot be written.
pub(super) fn prepare(arguments: &FeedArguments, findings: &mut Findings) -> Result<Option<(Job, Before)>, Stop> {
    let Some(job) = Job::new(arguments, findings)? else { return Ok(None) };
    let before = survey::run(arguments, &job, findings)?;
    // The profile fits its protocol, and the sensors are told of as they will be read.
    dialogue(&job)?;
    if arguments.dry_run {
        panel(arguments, &job, findings)?;
    }
    Ok(before.map(|before| (job, before)))
}

/// The dialogue of a job.
///
/// # Errors
/// Where the profile does not fit it.
fn dialogue(job: &Job) -> Result<Box<dyn Dialogue>, Stop> {
    (job.profile.protocol.create)(&job.profile)
        .map_err(|why| Stop::Usage(format!("the link {}: {why}", job.profile.name)))
}

/// Whether the control is asked if it stands still before the first line.
fn asks_idle(job: &Job) -> bool {
    job.profile.protocol.asks_idle
}

fn unasked(job: &Job) -> Diagnostic {
    let message = format!(
        "the link {} has no question whether the machine stands still; lines that are sent into a machine that moves run into what it does",
        job.profile.name
    );
    let help = "look at the machine: no program runs, nothing moves, no alarm stands. Then add --i-checked-the-machine-stands-still";
    Diagnostic::nowhere(Code::IDLE_UNKNOWN, message, help)
}

/// Opens the sensors of a job; `None` where there are none, or findings forbid it.
fn panel(arguments: &FeedArguments, job: &Job, findings: &mut Findings) -> Result<Option<Panel>, Stop> {
    let needed = job.chosen.errors.sensors();
    let Some(path) = &arguments.sensors else { return Ok(None) };
    let source = input::read_written(path, FileId(0), "sensors, --sensors")?;
    let fault = |found, findings: &mut Findings| {
        findings.extend(found, std::slice::from_ref(&source));
        Ok(None)
    };
    let config = match Config::read(&source) {
        Ok(config) => config,
        Err(found) => return fault(found, findings),
    };
    let is_known = |name: &str| {
        config.channels.iter().any(|channel| channel.name == name) || job.chosen.condition.trace(name).is_some()
    };
    let lacking: Vec<String> = needed.into_iter().filter(|name| !is_known(name)).map(str::to_owned).collect();
    if !lacking.is_empty() {
        findings.add(job::missing(&lacking), &[]);
        return Ok(None);
    }
    match Panel::open(&config, path.parent().unwrap_or(Path::new("."))) {
        Ok(panel) => Ok(Some(panel)),
        Err(found) => fault(found, findings),
    }
}
