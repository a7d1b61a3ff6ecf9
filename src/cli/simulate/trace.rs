//! `ncfix simulate PROGRAM`: a part program run through the servo loops, recorded as a trace.

use crate::cli::arguments::SimulateArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::is_standard_stream;
use crate::cli::measurement::description_of;
use crate::cli::output::{Spool, Target};
use crate::cli::stop::Stop;
use crate::cli::{machine_choice, program, progress, tell};
use crate::simulate::{Recorded, Recorder, SimulateOptions};

/// Records a program.
pub(super) fn run(arguments: &SimulateArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let result = record(arguments, &mut findings);
    findings.draw();
    match result? {
        Some(recorded) => tell(&format!("{}; written {}\n", recorded.sentence(), arguments.output.display())),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

/// Writes both files; `None` if there are errors.
fn record(arguments: &SimulateArguments, findings: &mut Findings) -> Result<Option<Recorded>, Stop> {
    if is_standard_stream(&arguments.output) {
        return Err(Stop::Usage("a measurement is a pair of files, NAME.csv and NAME.toml; give -o NAME.csv".into()));
    }
    let feeds = &arguments.feed;
    if let Some(twice) = (1..feeds.len()).find(|&k| feeds[..k].contains(&feeds[k])) {
        return Err(Stop::Usage(format!("--feed gives {} twice", feeds[twice])));
    }
    let paths = [arguments.output.clone(), description_of(&arguments.output)?];
    let [data, description] = [Target::new(&paths[0])?, Target::new(&paths[1])?];
    let part = program::of(&arguments.plan, &arguments.program)?;
    let found = machine_choice::choose_in(&arguments.machine, &arguments.state, &arguments.plan, findings)?;
    let Some(machine) = found else { return Ok(None) };
    for target in [&data, &description] {
        program::protect(target, machine.files.iter().chain([&arguments.plan]), findings);
    }
    let options = SimulateOptions { feeds_mm_min: feeds.clone(), noise_mm: arguments.noise, seed: arguments.seed };
    let Some(mut recorder) = Recorder::new(&part, &machine, &options, findings) else { return Ok(None) };
    let mut table = Spool::new(data.clone())?;
    let mut guard = |read: &[_], findings: &mut Findings| {
        [&data, &description].into_iter().for_each(|target| program::protect(target, read, findings));
    };
    let written = recorder.record(table.writer(), Some(progress::watch), &mut guard, findings)?;
    let is_whole = written.map_err(|error| table.fault(&error))?;
    if !is_whole {
        return Ok(None);
    }
    let mut together = AtomicWrites::default();
    together.take(table)?;
    together.add(description, recorder.description().as_bytes())?;
    together.publish()?;
    Ok(Some(recorder.recorded))
}
