//! `ncfix correct-readings`: subtracts corrections from positions read on the machine.

pub(in crate::cli) mod arguments;

use crate::cli::arguments::MeasuredArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::output::Target;
use crate::cli::program::protect;
use crate::cli::progress::Progress;
use crate::cli::stop::Stop;
use crate::cli::{input, machine_choice, tell};
use crate::measured::correct_file;
use ncfix_base::source::FileId;
use ncfix_metrology::results::corrected::CorrectedReadings;
use ncfix_report::measured::table;

/// Corrects a table of readings.
pub(in crate::cli) fn run(arguments: &MeasuredArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let result = correct(arguments, &mut findings);
    findings.draw();
    match result? {
        Some(found) => tell(&table(&found, &arguments.output.display().to_string())),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

/// Reads the table and writes its copy; `None` if there are errors.
fn correct(arguments: &MeasuredArguments, findings: &mut Findings) -> Result<Option<CorrectedReadings>, Stop> {
    let target = Target::new(&arguments.output)?;
    let source = input::read(&arguments.data, FileId(0), "positions")?;
    let chosen = machine_choice::choose_in(&arguments.machine, &arguments.state, &arguments.data, findings)?;
    let Some(chosen) = chosen else { return Ok(None) };
    protect(&target, chosen.files.iter().chain([&arguments.data]), findings);
    let how = (arguments.rotary.solve(), arguments.max_correction);
    let mut progress = Progress::new();
    let mut share = |share| progress.share("rows", share);
    Ok(correct_file(&chosen, &source, how, target, &mut share, findings)?)
}
