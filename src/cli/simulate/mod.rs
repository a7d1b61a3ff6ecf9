//! `ncfix simulate`: readings of instruments on a machine with errors.

pub(in crate::cli) mod arguments;
mod trace;

use crate::cli::arguments::SimulateArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::is_standard_stream;
use crate::cli::measurement::{self, description_of};
use crate::cli::output::{Spool, Target};
use crate::cli::program::protect;
use crate::cli::stop::Stop;
use crate::cli::{machine_choice, state, tell};
use ncfix_base::csv::Table;
use ncfix_metrology::results::simulated::PlannedReadings;

/// Simulates a measurement.
pub(in crate::cli) fn run(arguments: &SimulateArguments) -> Result<ExitCode, Stop> {
    crate::stated_zero::refuse(
        &arguments.state.zero,
        "readings are deviations from the commanded positions in the machine",
    )?;
    let mut findings = Findings::default();
    let is_plan = arguments.plan.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    if !is_plan {
        return trace::run(arguments);
    }
    if !arguments.feed.is_empty() {
        return Err(Stop::Usage("--feed applies only to part programs, not to plans".into()));
    }
    let result = simulate(arguments, &mut findings);
    findings.draw();
    match result? {
        Some(rows) => tell(&format!("{rows} rows simulated and written to {}\n", arguments.output.display())),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

/// Writes both files; the number of rows, `None` if there are errors.
fn simulate(arguments: &SimulateArguments, findings: &mut Findings) -> Result<Option<usize>, Stop> {
    if is_standard_stream(&arguments.output) {
        return Err(Stop::Usage("a measurement is a pair of files, NAME.csv and NAME.toml; give -o NAME.csv".into()));
    }
    let paths = [arguments.output.clone(), description_of(&arguments.output)?];
    let targets = [Target::new(&paths[0])?, Target::new(&paths[1])?];
    if targets.iter().any(|target| !target.is_file()) {
        return Err(Stop::Usage("a measurement is a pair of files, NAME.csv and NAME.toml; give -o NAME.csv".into()));
    }
    let found = machine_choice::choose(&arguments.machine, &arguments.plan, findings)?;
    let Some(mut chosen) = found else { return Ok(None) };
    if !state::apply(&arguments.state, &mut chosen, findings)? {
        return Ok(None);
    }
    let inputs = [arguments.plan.clone(), description_of(&arguments.plan)?];
    for target in &targets {
        protect(target, chosen.files.iter().chain(&inputs), findings);
    }
    let read = measurement::read(&arguments.plan, 0, true, &chosen.machine, findings)?;
    let Some(mut plan) = read.filter(|_| !findings.has_errors()) else { return Ok(None) };
    let (Some(table), _) = Table::read(&plan.sources[0]) else { return Ok(None) };
    crate::condition::withdraw_answered(&table, &chosen.errors, findings);
    plan.data.fill_in(&chosen.condition);
    let model = chosen.model();
    let job =
        PlannedReadings { machine: &chosen.machine, errors: &chosen.errors, model: &model, plan: &plan, table: &table };
    let mut found = Vec::new();
    let rows = job.rows(arguments.noise, arguments.seed, &mut found);
    findings.extend(found, &plan.sources);
    if findings.has_errors() {
        return Ok(None);
    }
    let [data, description] = targets;
    let mut data = Spool::new(data)?;
    if let Err(error) = job.write(&rows, data.writer()) {
        return Err(data.fault(&error).into());
    }
    let mut together = AtomicWrites::default();
    together.take(data)?;
    together.add(description, &job.description(arguments.noise))?;
    together.publish()?;
    Ok(Some(rows.len()))
}
