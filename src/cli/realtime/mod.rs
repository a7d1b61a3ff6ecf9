//! `ncfix realtime`: corrections for controller set-points in real time.

pub(in crate::cli) mod arguments;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::cli::arguments::RealtimeArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::output::Target;
use crate::cli::stop::Stop;
use crate::cli::{machine_choice, pages, tell};
use crate::realtime::{self, RealtimeCorrection, RingFile};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_report::page::stability::stability;
use ncfix_report::realtime::{kernel, page};
use ncfix_tables::realtime::ServingEnd;
use ncfix_tables::realtime::stability::StabilityResult;
use ncfix_tables::results::realtime::RealtimeResult;

/// Answers set-points.
pub(in crate::cli) fn run(arguments: &RealtimeArguments) -> Result<ExitCode, Stop> {
    if let Some(path) = &arguments.stability {
        pages::publish(Target::new(path)?, &stability(&StabilityResult::simulated()))?;
        return Ok(ExitCode::Done);
    }
    let mut findings = Findings::default();
    let prepared = prepare(arguments, &mut findings);
    findings.draw();
    let Some(mut correction) = prepared? else {
        tell(&format!("{}; no set-point was read\n", findings.count()));
        return Ok(findings.exit_code());
    };
    tell(&kernel(&correction.kernel));
    let result = match &arguments.ring {
        Some(name) => serve(name, arguments.records, &mut correction),
        None => answer(&mut correction),
    };
    // The summary of the run is printed even if it ended early.
    if !matches!(result, Err(Stop::Usage(_))) {
        tell(&page(&RealtimeResult::from(&correction.counts), arguments.latency));
    }
    result
}

fn prepare(arguments: &RealtimeArguments, findings: &mut Findings) -> Result<Option<RealtimeCorrection>, Stop> {
    let search = machine_choice::MachineSearch::of_program(Path::new("-"));
    let Some(all) = machine_choice::choose(&arguments.machine, search, findings)? else { return Ok(None) };
    let renewal = ((&arguments.state).into(), arguments.update_s);
    let chosen = realtime::in_use(&all, arguments.machine.head.as_deref(), &renewal.0, findings)?;
    let Some(chosen) = chosen else { return Ok(None) };
    let recipe = arguments.recipe(&chosen.machine);
    Ok(RealtimeCorrection::new((chosen, all), recipe, arguments.dosing(), renewal, Findings::draw, findings))
}

/// Answers the lines of standard input.
fn answer(correction: &mut RealtimeCorrection) -> Result<ExitCode, Stop> {
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let wrong = correction.answer(std::io::stdin().lock(), &mut out)?;
    Ok(wrong.map_or(ExitCode::Done, refused))
}

/// Serves rings in shared memory until the control or the user ends it.
fn serve(name: &str, records: u64, correction: &mut RealtimeCorrection) -> Result<ExitCode, Stop> {
    let file = RingFile::create(name)?;
    let ring = correction.ring(&file, records)?;
    let is_over = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&is_over))
            .map_err(|error| Stop::Usage(format!("cannot catch Ctrl-C: {error}")))?;
    }
    tell(&format!("rings of {records} records at {}\n", file.path().display()));
    Ok(match correction.serve(&ring, || is_over.load(Ordering::Relaxed)) {
        ServingEnd::Control => ExitCode::Done,
        ServingEnd::Stopped => ExitCode::Interrupted,
        end @ (ServingEnd::NoKernel | ServingEnd::Order(_)) => refused(correction.no_order(&end)),
        ServingEnd::Overrun(overrun) => refused(correction.overrun(overrun, records)),
    })
}

/// Prints the diagnostic that ended the run.
fn refused(diagnostic: Diagnostic) -> ExitCode {
    let mut findings = Findings::default();
    findings.add(diagnostic, &[]);
    findings.draw();
    findings.exit_code()
}
