//! `ncfix steps`: the largest fixed step that keeps a residual, over the working volume or along a program.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::arguments::{RotaryChoice, StepsArguments};
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::output::Target;
use super::pages;
use super::program;
use super::progress::{self, Progress};
use super::state;
use super::stop::Stop;
use super::together::Together;
use super::value::ToolVector;
use super::{input, print};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_base::units::um_from_mm;
use ncfix_language::exec::RapidOrder;
use ncfix_machine::machine::Machine;
use ncfix_path::path::{Answer, Line, Moves, Rotary, StepTrial, Steps, volume};
use ncfix_report::compared::Input;
use ncfix_report::plot::Picture as _;
use ncfix_report::residual::Residual;
use ncfix_report::steps::{StepReport, StepRow, Worst};
use ncfix_report::terminal::Colors;
use ncfix_report::{json, page};

/// Finds the step.
pub(super) fn run(arguments: &StepsArguments) -> Result<ExitCode, Stop> {
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

/// Looks for the step and draws the file; the report has no answer where findings forbid it.
fn find(arguments: &StepsArguments, findings: &mut Findings) -> Result<StepReport, Stop> {
    let empty = StepReport { residual_limit_um: um_from_mm(arguments.residual), ..StepReport::default() };
    // What is missing is said before any work is done.
    let source = arguments.input.as_deref().map(program::read).transpose()?;
    let target = arguments.svg.as_deref().map(Target::new).transpose()?;
    let page = arguments.report.as_deref().map(pages::file).transpose()?;
    if arguments.json && target == Some(Target::Standard) {
        return Err(Stop::Usage("--json and --svg cannot both go to standard output; give --svg a file".into()));
    }
    let program = arguments.input.as_deref().unwrap_or(Path::new("."));
    let beside = program.join("ncfix");
    let near = if arguments.input.is_some() { program } else { &beside };
    let Some(mut chosen) = machine_choice::choose(&arguments.machine, near, findings)? else { return Ok(empty) };
    if !state::apply(&arguments.state, &mut chosen, findings)? {
        return Ok(empty);
    }
    for target in target.iter().chain(&page) {
        program::protect(target, chosen.files.iter().chain(&arguments.input), findings);
    }
    if findings.has_errors() {
        return Ok(empty);
    }
    let model = chosen.model();
    let rotary = match arguments.rotary {
        RotaryChoice::Auto => Rotary::Auto,
        RotaryChoice::Correct => Rotary::Correct,
        RotaryChoice::Hold => Rotary::Hold,
    };
    let trial = StepTrial::new(&model, rotary);
    let mut report = StepReport { machine: chosen.machine.name.clone(), ..empty };
    let mut files = Vec::new();
    let (lines, mut trial) = match &source {
        Some(source) => {
            let Some(gathered) = gather(arguments, source, &chosen, trial, findings)? else { return Ok(report) };
            report.tool_length_mm = arguments.tool.map(|tool| tool_vector(&chosen.machine, tool).norm());
            (report.moves, report.arcs) = (Some(gathered.moves), Some(gathered.arcs));
            files = gathered.sources;
            (gathered.lines, gathered.trial)
        }
        None => {
            let tool = arguments.tool.unwrap_or_else(|| ToolVector::Length(longest_tool_mm(&chosen.machine)));
            let tool_mm = tool_vector(&chosen.machine, tool);
            report.tool_length_mm = Some(tool_mm.norm());
            (volume(&chosen.machine, &tool_mm), trial)
        }
    };
    if source.is_none() && lines.is_empty() {
        return Err(Stop::Usage(
            "no axis of the machine has travel limits, so there is no volume to look at; give a program".into(),
        ));
    }
    let mut progress = Progress::new();
    let steps = trial.search(&lines, arguments.residual, |share| progress.share("steps", share));
    drop(progress);
    if steps.worst.failures > 0 && steps.rows.last().is_some_and(|row| row.largest_mm == 0.0) {
        let message = "on none of the lines a correction was found";
        let help = "check the error model, and that the machine can move the tool in all directions";
        findings.add(Diagnostic::nowhere(Code::NOT_CONVERGED, message, help), &[]);
        return Ok(report);
    }
    note(&mut report, &steps, &lines, &files, &chosen.machine);
    let mut together = Together::default();
    if let Some(target) = target {
        together.add(target, Residual(&report).svg().as_bytes())?;
    }
    if let Some(page) = page {
        report.diagnostics = findings.json();
        let inputs = inputs(source.as_ref(), &chosen.files)?;
        together.add(page, page::steps::steps(&report, &inputs).as_bytes())?;
    }
    together.publish()?;
    Ok(report)
}

/// The files of a result.
fn inputs(program: Option<&Source>, machine: &[PathBuf]) -> Result<Vec<Input>, Stop> {
    let mut all: Vec<Input> = program.map(|one| pages::input(one, "program")).into_iter().collect();
    for path in machine {
        all.push(pages::input(&input::read_written(path, FileId(0), "machine file")?, "machine"));
    }
    Ok(all)
}

/// What a program gave.
struct Gathered<'a> {
    lines: Vec<Line>,
    trial: StepTrial<'a>,
    moves: u64,
    arcs: u64,
    sources: Vec<Source>,
}

/// Executes the program and gathers its moves; `None` where findings forbid it.
fn gather<'a>(
    arguments: &StepsArguments,
    source: &Source,
    chosen: &'a Chosen,
    trial: StepTrial<'a>,
    findings: &mut Findings,
) -> Result<Option<Gathered<'a>>, Stop> {
    let machine = &chosen.machine;
    let Some(opened) = program::open(source, &arguments.program, Some(chosen), findings)? else { return Ok(None) };
    let path = arguments.input.as_deref().unwrap_or(Path::new("-"));
    let mut running = program::start(opened, path, &arguments.program, machine, true, RapidOrder::All);
    let fixed_tool_mm = arguments.tool.map(|tool| tool_vector(machine, tool));
    let mut moves = Moves::new(machine, trial, fixed_tool_mm);
    if let Some(start) = arguments.program.start {
        moves.start_at(start);
    }
    while let Some(item) = running.next() {
        match item {
            Ok(element) => moves.note(&element),
            Err(diagnostic) => findings.add(diagnostic, running.sources()),
        }
        if findings.is_hopeless() {
            break;
        }
    }
    if findings.has_errors() {
        return Ok(None);
    }
    let (straight, arcs) = (moves.lines, moves.arcs);
    let (lines, trial) = moves.finish();
    Ok(Some(Gathered { lines, trial, moves: straight, arcs, sources: running.sources().to_vec() }))
}

/// Length of the longest tool of the machine file, 0 without tools.
fn longest_tool_mm(machine: &Machine) -> f64 {
    machine.tools.iter().map(|tool| tool.length_mm[0].abs()).fold(0.0, f64::max)
}

/// From the spindle gauge point to the tip.
fn tool_vector(machine: &Machine, tool: ToolVector) -> Vector {
    match tool {
        ToolVector::Length(length_mm) => machine.spindle.axis * -length_mm,
        ToolVector::Tip(tip_mm) => tip_mm,
    }
}

/// Takes the result into the report.
fn note(report: &mut StepReport, steps: &Steps, lines: &[Line], files: &[Source], machine: &Machine) {
    (report.answer, report.largest_step_mm) = match steps.answer {
        Answer::Any => (Some("any"), None),
        Answer::UpTo(step_mm) => (Some("up_to"), Some(step_mm)),
        Answer::None => (Some("none"), None),
    };
    report.residual_um = um_from_mm(steps.worst.max_mm);
    report.failures = steps.worst.failures;
    report.lines = lines.len() as u64;
    report.steps = steps
        .rows
        .iter()
        .map(|row| StepRow {
            step_mm: row.step_mm,
            residual_um: um_from_mm(row.residual_mm),
            largest_um: um_from_mm(row.largest_mm),
        })
        .collect();
    let place = |position: &AxisVector| {
        let axes = AXES.into_iter().filter(|&axis| machine.axis(axis).is_some());
        let entry = |axis: ncfix_base::geometry::Axis| match axis.is_rotary() {
            true => (format!("{axis}_deg"), position[axis].to_degrees()),
            false => (format!("{axis}_mm"), position[axis]),
        };
        axes.map(entry).collect::<BTreeMap<_, _>>()
    };
    report.worst = lines.get(steps.worst.line).filter(|_| steps.worst.max_mm > 0.0).map(|line| Worst {
        at: place(&steps.worst.at),
        from: place(line.start()),
        to: place(line.end()),
        file: line
            .origin
            .and_then(|origin| files.iter().find(|source| source.id() == origin.file))
            .map(|source| source.name().to_owned()),
        line: line.origin.map(|origin| origin.line),
    });
}
