//! `ncfix feed`: sends a program to a control line by line, corrected for the current temperatures.

pub(in crate::cli) mod arguments;
pub(in crate::cli) mod keys;
mod show;

use std::path::{Path, PathBuf};

use super::arguments::FeedArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::stop::Stop;
use super::{complain, input, machine_choice, print, program, progress, state, tell};
use crate::disk::hash::short_hash;
use crate::feed::{self as transfers, Begin, ControlLink, FeedEnd, FeedOptions, Lane, NotBegun, Transfer};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_dnc::feed::port;
use ncfix_report::feed::Before;
use ncfix_report::json;

use show::Show;

/// Sends a program.
pub(super) fn run(arguments: &FeedArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let prepared = prepare(arguments, &mut findings);
    let (job, before) = match prepared {
        Ok(Some((job, mut before))) => {
            before.diagnostics = findings.json();
            (job, before)
        }
        Ok(None) => return Ok(nothing_sent(&findings)),
        Err(stop) => {
            findings.draw();
            return Err(stop);
        }
    };
    findings.draw();
    if arguments.json {
        print(&json::line(&before).map_err(Stop::Usage)?)?;
    } else if arguments.dry_run {
        print(&before.table(job.machine.is_demo))?;
    } else {
        tell(&before.table(false));
    }
    if findings.has_errors() {
        tell(&format!("{}; nothing was sent\n", findings.count()));
        return Ok(findings.exit_code());
    }
    if arguments.dry_run {
        return before.bad_sensors().map_or(Ok(ExitCode::Done), |why| Err(Stop::Ended(ExitCode::Sensor, why)));
    }
    let begin = Begin {
        input: arguments.input.display().to_string(),
        port: arguments.port.clone().unwrap_or_default(),
        words: std::env::args().skip(1).collect(),
        ..Begin::default()
    };
    send(arguments, job, &before, &begin)
}

/// Reports that the transfer is not possible because of errors.
fn nothing_sent(findings: &Findings) -> ExitCode {
    findings.draw();
    tell(&format!("{}; nothing was sent\n", findings.count()));
    findings.exit_code()
}

/// Opens the port and sends.
///
/// # Errors
/// If the port cannot be opened, or the journal cannot be written.
pub(super) fn send(arguments: &FeedArguments, job: Transfer, before: &Before, begin: &Begin) -> Result<ExitCode, Stop> {
    let name = arguments.port.as_deref().ok_or_else(|| Stop::Usage("--port is missing".into()))?;
    let mut findings = Findings::default();
    if let Some(unasked) = job.unasked() {
        findings.add(unasked, &[]);
        return Ok(nothing_sent(&findings));
    }
    let profile = &job.link.profile;
    let opened = port::open(name, profile).map_err(|sentence| Stop::Ended(ExitCode::Link, sentence))?;
    let journal = journal_of(&arguments.input, arguments.journal.as_deref())?;
    if begin.resumed.is_none() {
        transfers::check_journal(&journal, &mut findings)?;
    }
    let help = "give --port the persistent name, or change the profile";
    findings.extend(opened.notes.iter().map(|note| Diagnostic::nowhere(Code::SERIAL_SETTINGS, note, help)), &[]);
    let panel = job.panel(arguments.sensors.as_deref(), &mut findings)?;
    findings.draw();
    if findings.has_errors() {
        tell(&format!("{}; nothing was sent\n", findings.count()));
        return Ok(findings.exit_code());
    }
    let characters_per_s = port::characters_per_s(name, profile);
    let lane = Lane { port: opened.port, characters_per_s, panel, journal: &journal };
    let mut show = Show::new(arguments.json)?;
    let sent = transfers::send(job, lane, before, begin, &mut show).map_err(|refused| match refused {
        NotBegun::Error(error) => Stop::from(error),
        NotBegun::Ended(end, message) => Stop::Ended(code_of(end), message),
    })?;
    show.end(&sent.status)?;
    if let Some(message) = &sent.status.message
        && !arguments.json
    {
        complain(message);
    }
    if sent.may_be_resumed && !arguments.json {
        tell(&format!("help: {}\n", transfers::next_step(&journal, arguments.dosing.zero_now)));
    }
    Ok(code_of(sent.end))
}

/// Exit status for the end of a transfer.
fn code_of(end: FeedEnd) -> ExitCode {
    match end {
        FeedEnd::Done => ExitCode::Done,
        FeedEnd::Fault => ExitCode::Refused,
        FeedEnd::Link => ExitCode::Link,
        FeedEnd::Control => ExitCode::Control,
        FeedEnd::Sensors => ExitCode::Sensor,
        FeedEnd::Stopped => ExitCode::Interrupted,
    }
}

/// Path of the journal of a job.
///
/// # Errors
/// If the program has no file name.
fn journal_of(input: &Path, given: Option<&Path>) -> Result<PathBuf, Stop> {
    if let Some(given) = given {
        return Ok(given.to_path_buf());
    }
    if input::is_standard_stream(input) {
        return Err(Stop::Usage("a program from standard input needs --journal".into()));
    }
    let mut name = input.as_os_str().to_owned();
    name.push(".journal");
    Ok(PathBuf::from(name))
}

/// Reads everything and makes a dry run of the program; `None` if there are errors.
///
/// # Errors
/// If a file cannot be read, or the program cannot be written.
pub(super) fn prepare(arguments: &FeedArguments, findings: &mut Findings) -> Result<Option<(Transfer, Before)>, Stop> {
    let Some(job) = transfer(arguments, findings)? else { return Ok(None) };
    let port = arguments.port.as_deref().unwrap_or_default();
    let mut before = job.survey((port, arguments.sensors.is_some()), Some(progress::watch), findings)?;
    // Checks the profile against its protocol; a dry run also asks the sensors.
    job.dialogue()?;
    if arguments.dry_run {
        job.ask_sensors(arguments.sensors.as_deref(), &mut before, findings)?;
    }
    Ok(before.map(|before| (job, before)))
}

/// Reads the files of the arguments; `None` if errors prevent it from continuing.
fn transfer(arguments: &FeedArguments, findings: &mut Findings) -> Result<Option<Transfer>, Stop> {
    let link = ControlLink::find(&arguments.link, findings)?;
    let sensors_hash = match &arguments.sensors {
        Some(path) => short_hash([input::read_written(path, FileId(0), input::option("sensors, --sensors"))?.bytes()]),
        None => String::new(),
    };
    let part = program::of(&arguments.input, &arguments.program)?;
    let found = machine_choice::choose(
        &arguments.machine,
        machine_choice::MachineSearch::of_program(&arguments.input),
        findings,
    )?;
    let Some(mut machine) = found else { return Ok(None) };
    if machine.is_demo && !arguments.dry_run {
        let sentence = "the embedded demo machine is not a real machine: give --machine, or save the machine file as ncfix.toml in the folder of the program";
        return Err(Stop::Usage(sentence.into()));
    }
    let is_read = match arguments.sensors {
        // Sensors give what the state file lacks.
        Some(_) => state::read(&arguments.state, &mut machine, findings)?,
        None => state::apply(&arguments.state, &mut machine, findings)?,
    };
    findings.advise(Code::NO_TEMPERATURES, transfers::TEMPERATURES_HELP);
    part.was_corrected_before(findings);
    let Some(link) = link.filter(|_| is_read && !findings.has_errors()) else { return Ok(None) };
    let how = (&arguments.correction.options(), FeedOptions::from(arguments));
    Ok(Transfer::new(part, machine, (link, sensors_hash), how, findings)?)
}
