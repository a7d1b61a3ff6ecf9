//! The command line of the binary `ncfix`, which is no part of the library: arguments, a call of the library, a view of its result.
//!
//! [`run`] reads the arguments and ends with an [`ExitCode`]. A command collects diagnostics (`findings`), prints them
//! on standard error, and writes results through `output`, completely or not at all.

mod arguments;
mod calibrate;
mod check;
mod completions;
mod decompose;
mod diagnose;
mod diff;
mod exit_code;
mod explain;
mod feed;
mod figures;
mod findings;
mod fix;
mod import;
mod input;
mod load;
mod machine;
mod machine_choice;
mod man;
mod measured;
mod plan;
mod program;
mod progress;
mod realtime;
mod resume;
mod sensors;
mod simulate;
mod snc;
mod square;
mod state;
mod steps;
mod stop;
mod tables;
mod verbosity;
mod verify;

pub use exit_code::ExitCode;

use std::ffi::OsString;
use std::io::Write as _;

use crate::disk::measurements as measurement;
use crate::disk::{atomic_writes, files, output, pages, parameters, traces as trace};
use crate::option_values as value;
use arguments::Command;
use ncfix_report::verdict::colored;
use stop::Stop;

/// Runs the command of a command line; the first argument is the name of the program.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let words: Vec<OsString> = arguments.into_iter().collect();
    if words.len() < 2 {
        say(&arguments::overview(&arguments::definition()));
        return ExitCode::Usage;
    }
    let renamed = arguments::renamed(&words);
    let (voice, command) = match arguments::parse(words) {
        Ok(parsed) => parsed,
        Err(message) => {
            // Help and version are asked for and go to standard output; a reader that went away does not matter.
            let _ = message.print();
            return if message.use_stderr() { ExitCode::Usage } else { ExitCode::Done };
        }
    };
    verbosity::choose(voice);
    progress::allow();
    if let Some((old, new)) = renamed {
        tell(&format!("note: `ncfix {old}` is now called `ncfix {new}`; the old name still works\n"));
    }
    log::info!("{}", verbosity::version());
    files::begin_run(progress::end);
    if let Some(name) = command.silent_work() {
        progress::begin(name);
    }
    let ended = dispatch(&command);
    progress::end();
    match ended {
        Ok(code) => code,
        Err(Stop::ReaderGone) => ExitCode::Done,
        Err(Stop::Usage(sentence)) => {
            complain(&sentence);
            ExitCode::Usage
        }
        Err(Stop::Ended(code, sentence)) => {
            complain(&sentence);
            code
        }
        Err(Stop::Found(diagnostic)) => {
            let mut findings = findings::Findings::default();
            findings.add(*diagnostic, &[]);
            findings.draw();
            findings.exit_code()
        }
    }
}

/// Runs the chosen command.
fn dispatch(command: &Command) -> Result<ExitCode, Stop> {
    match command {
        Command::Fix(arguments) => fix::run(arguments),
        Command::Check(arguments) => check::run(arguments),
        Command::Snc(arguments) => snc::run(arguments),
        Command::Verify(arguments) => verify::run(arguments),
        Command::Diff(arguments) => diff::run(arguments),
        Command::Measured(arguments) => measured::run(arguments),
        Command::Steps(arguments) => steps::run(arguments),
        Command::Tables(arguments) => tables::run(arguments),
        Command::Diagnose(arguments) => diagnose::run(arguments),
        Command::Decompose(arguments) => decompose::run(arguments),
        Command::Sensors(arguments) => sensors::run(arguments),
        Command::Load(arguments) => load::run(arguments),
        Command::Feed(arguments) => feed::run(arguments),
        Command::Realtime(arguments) => realtime::run(arguments),
        Command::Resume(arguments) => resume::run(arguments),
        Command::Import(arguments) => import::run(arguments),
        Command::Plan(arguments) => plan::run(arguments),
        Command::Calibrate(arguments) => calibrate::run(arguments),
        Command::Simulate(arguments) => simulate::run(arguments),
        Command::Figures(arguments) => figures::run(arguments),
        Command::Square(arguments) => square::run(arguments),
        Command::Machine(command) => machine::run(command),
        Command::Explain(arguments) => explain::run(arguments),
        Command::Completions(arguments) => completions::run(arguments),
        Command::Man(arguments) => man::run(arguments),
    }
}

/// Prints a result on standard output.
fn print(text: &str) -> Result<(), Stop> {
    progress::end();
    let mut out = anstream::stdout().lock();
    out.write_all(colored(text).as_bytes()).and_then(|()| out.flush()).map_err(|error| Stop::output(&error))
}

/// Prints a sentence or a table for the user on standard error; nothing with `--quiet`.
fn tell(text: &str) {
    if !verbosity::is_quiet() {
        progress::end();
        say(&colored(text));
    }
}

/// Prints on standard error, without colors if it is not a terminal.
fn say(text: &str) {
    progress::clear();
    // A closed standard error is not an error.
    let _ = anstream::stderr().lock().write_all(text.as_bytes());
}

/// Ends a command with a report: as JSON if requested, else as a page, on standard error if the result itself goes to standard output.
fn deliver(
    result: Result<(), Stop>,
    findings: &findings::Findings,
    goes_out: bool,
    page: String,
    json: Option<Result<String, String>>,
) -> Result<ExitCode, Stop> {
    if let (Ok(()), Some(json)) = (&result, json) {
        print(&json.map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    result?;
    if findings.has_errors() {
        tell(&format!("{}; no result\n", findings.count()));
    } else if goes_out {
        tell(&page);
    } else {
        print(&page)?;
    }
    Ok(findings.exit_code())
}

/// Prints the error that ended the run.
fn complain(sentence: &str) {
    let style = clap::builder::styling::AnsiColor::BrightRed.on_default().bold();
    progress::end();
    say(&format!("{style}error{style:#}: {}\n", ncfix_base::source::shown(sentence)));
}
