//! `ncfix fix --zero-shift`: zero offsets that cancel the drift.

use std::path::{Path, PathBuf};

use crate::cli::arguments::FixArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::output::Target;
use crate::cli::stop::Stop;
use crate::cli::{input, machine_choice, program, tell};
use crate::zero_shift;
use ncfix_base::source::FileId;

/// Writes the zero offsets.
pub(super) fn run(arguments: &FixArguments, output: &Path) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let target = Target::new(output)?;
    let program = program::of(&arguments.input, &arguments.program)?;
    let search = program.search(&arguments.input).with_one_head();
    let chosen = machine_choice::choose_in(&arguments.machine, &arguments.state, search, &mut findings)?;
    if let Some(chosen) = chosen.filter(|_| !findings.has_errors()) {
        program::protect(&target, chosen.files.iter().chain([&arguments.input]), &mut findings);
        let is_variables = |path: &&PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("var"));
        let variables = arguments.machine.setup.iter().rev().find(is_variables);
        let variables = variables.map(|path| input::read(path, FileId(0), "variable file")).transpose()?;
        let variables = variables.map(|source| String::from_utf8_lossy(source.bytes()).into_owned());
        let tolerance_mm = arguments.correction.tolerance;
        let shift = zero_shift::find(&program, &chosen, tolerance_mm, variables.as_deref(), &mut findings)?;
        if let Some(shift) = shift.filter(|_| !findings.has_errors()) {
            let mut together = AtomicWrites::default();
            together.add(target, shift.text.as_bytes())?;
            together.publish()?;
            tell(&shift.page);
        }
    }
    findings.draw();
    Ok(findings.exit_code())
}
