//! `ncfix max-step`: the largest fixed step that keeps a residual, over the working volume or along a program.

pub(in crate::cli) mod arguments;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::cli::arguments::StepsArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::output::Target;
use crate::cli::progress::{self, Progress};
use crate::cli::stop::Stop;
use crate::cli::{input, machine_choice, pages, print, program};
use crate::program::Program;
use crate::steps::StepSearch;
use ncfix_base::source::{FileId, Source};
use ncfix_report::inputs::InputFile;
use ncfix_report::plot::Picture as _;
use ncfix_report::residual::Residual;
use ncfix_report::steps::StepReport;
use ncfix_report::terminal::Colors;
use ncfix_report::{json, page};

/// Finds the step.
pub(in crate::cli) fn run(arguments: &StepsArguments) -> Result<ExitCode, Stop> {
    crate::stated_zero::refuse(&arguments.state.zero, "the zero adds the same displacement at both ends of a step")?;
    let started = Instant::now();
    let mut findings = Findings::default();
    let result = find(arguments, &mut findings);
    if !arguments.json || result.is_err() {
        findings.draw();
    }
    let mut report = result?;
    report.seconds = started.elapsed().as_secs_f64();
    if arguments.json {
        report.diagnostics = findings.json();
        print(&json::line(&report).map_err(Stop::Usage)?)?;
    } else if report.answer.is_some() {
        let page = report.page(Colors::Ansi);
        progress::end();
        let mut out = anstream::stdout().lock();
        out.write_all(page.as_bytes()).and_then(|()| out.flush()).map_err(|error| Stop::output(&error))?;
    }
    Ok(findings.exit_code())
}

/// Finds the step and draws the file; the report has no answer if there are errors.
fn find(arguments: &StepsArguments, findings: &mut Findings) -> Result<StepReport, Stop> {
    // Missing inputs are reported before any work is done.
    let part = arguments.input.as_deref().map(|path| program::of(path, &arguments.program)).transpose()?;
    let target = arguments.svg.as_deref().map(Target::new).transpose()?;
    let page = arguments.report.as_deref().map(pages::file).transpose()?;
    if arguments.json && target == Some(Target::Standard) {
        return Err(Stop::Usage("--json and --svg cannot both go to standard output; give --svg a file".into()));
    }
    let (residual_mm, rotary) = (arguments.residual, arguments.rotary.into());
    let search = StepSearch { program: part.as_ref(), tool: arguments.tool, residual_mm, rotary };
    let folder = arguments.input.as_deref().unwrap_or(Path::new("."));
    let beside = folder.join("ncfix");
    let near = if arguments.input.is_some() { folder } else { &beside };
    let found = machine_choice::choose_in(&arguments.machine, &arguments.state, near, findings)?;
    let Some(machine) = found else { return Ok(search.empty()) };
    for target in target.iter().chain(&page) {
        program::protect(target, machine.files.iter().chain(&arguments.input), findings);
    }
    if findings.has_errors() {
        return Ok(search.empty());
    }
    let mut progress = Progress::new();
    let mut report = search.run(&machine, Some(progress::watch), |share| progress.share("steps", share), findings)?;
    drop(progress);
    if report.answer.is_none() {
        return Ok(report);
    }
    let mut together = AtomicWrites::default();
    if let Some(target) = target {
        together.add(target, Residual(&report).svg().as_bytes())?;
    }
    if let Some(page) = page {
        report.diagnostics = findings.json();
        let inputs = inputs(part.as_ref().map(Program::source), &machine.files)?;
        together.add(page, page::steps::steps(&report, &inputs).as_bytes())?;
    }
    together.publish()?;
    Ok(report)
}

/// The files of a result.
fn inputs(program: Option<&Source>, machine: &[PathBuf]) -> Result<Vec<InputFile>, Stop> {
    let mut all: Vec<InputFile> = program.map(|one| pages::input(one, "program")).into_iter().collect();
    for path in machine {
        all.push(pages::input(&input::read_written(path, FileId(0), "machine file")?, "machine"));
    }
    Ok(all)
}
