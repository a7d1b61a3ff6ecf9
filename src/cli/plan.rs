//! `ncfix plan`: poses of a measurement and the program that runs them.

use std::fmt::Write as _;
use std::path::Path;

use super::arguments::PlanArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::output::{Spool, Target};
use super::program::protect;
use super::stop::Stop;
use super::tell;
use super::value::ToolVector;
use crate::calibrate::{improve, told};
use crate::emit::flat;
use crate::machine::Machine;
use crate::measure::data::DataSet;
use crate::measure::plan::builder::Builder;
use crate::measure::plan::{Wishes, table};
use crate::model::parameter::ParameterName;
use crate::model::preset::{PRESETS, find};

/// What a row without a reading is taken for when it is asked what it tells.
const READ: f64 = 0.0;
/// Names that are shown of those that no reading feels.
const MOST_NAMES: usize = 30;
/// Sentences that are shown.
const MOST_SENTENCES: usize = 12;

/// Writes a plan.
pub(super) fn run(arguments: &PlanArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let result = plan(arguments, &mut findings);
    findings.draw();
    match result? {
        Some(report) => tell(&report),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

fn plan(arguments: &PlanArguments, findings: &mut Findings) -> Result<Option<String>, Stop> {
    let description = arguments.output.with_extension("toml");
    if description == arguments.output || arguments.output == Path::new("-") {
        return Err(Stop::Usage("the plan is two files; give -o the name of the table, such as plan.csv".into()));
    }
    let mut targets = vec![Target::new(&arguments.output)?, Target::new(&description)?];
    targets.extend(arguments.program.as_deref().map(Target::new).transpose()?);
    if arguments.program.as_ref().is_some_and(|program| *program == arguments.output || *program == description) {
        return Err(Stop::Usage("the program and the plan have the same name".into()));
    }
    let Some(chosen) = machine_choice::choose(&arguments.machine, &arguments.output, findings)? else {
        return Ok(None);
    };
    for target in &targets {
        protect(target, chosen.files.iter(), findings);
    }
    let wishes = wishes(arguments, &chosen.machine)?;
    let refused = |reason: String| Stop::Usage(format!("no plan {}: {reason}", arguments.kind.name));
    let mut plan = (arguments.kind.build)(&chosen.machine, &wishes).map_err(|reason| refused(reason.to_string()))?;
    let mut report = String::new();
    if let Some(name) = &arguments.model {
        report = judge(name, arguments.improve.unwrap_or(0), &chosen, &mut plan)?;
    }
    for note in &plan.notes {
        let _ = writeln!(report, "note: {note}");
    }
    let mut texts = vec![table::csv(&plan).into_bytes(), table::toml(&plan).into_bytes()];
    if arguments.program.is_some() {
        let title = format!("plan {} for {}", arguments.kind.name, chosen.machine.name);
        texts.push(flat(&chosen.machine, &title, &plan.path).map_err(refused)?);
    }
    if findings.has_errors() {
        return Ok(None);
    }
    // All are complete before the first is published.
    let mut spools = Vec::new();
    for (target, text) in targets.into_iter().zip(texts) {
        let mut spool = Spool::new(target)?;
        let written = spool.writer().write_all(&text);
        written.map_err(|error| spool.fault(&error))?;
        spools.push(spool);
    }
    for spool in spools {
        spool.publish(false)?;
    }
    let _ = writeln!(
        report,
        "{}: {} rows in {} set-ups; {} beside it",
        arguments.output.display(),
        plan.data.observations.len(),
        plan.data.setups.len(),
        description.display()
    );
    Ok(Some(report))
}

/// Asks what the plan tells of a preset, and adds poses.
fn judge(name: &str, more: usize, chosen: &Chosen, plan: &mut Builder) -> Result<String, Stop> {
    if !plan.is_geometric {
        return Err(Stop::Usage("a drift has no parameters of a preset; leave --model out".into()));
    }
    let preset = find(name).ok_or_else(|| {
        let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        Stop::Usage(format!("there is no preset '{name}'; the presets are {}", known.join(", ")))
    })?;
    let machine = &chosen.machine;
    let parameters = (preset.parameters)(machine)
        .map_err(|reason| Stop::Usage(format!("preset {name} does not suit the machine {}: {reason}", machine.name)))?;
    let mut report = said("the plan", name, chosen, &parameters, plan);
    if more > 0 {
        if plan.candidates.is_empty() {
            return Err(Stop::Usage("this plan has no further poses to choose from; leave --improve out".into()));
        }
        let mut read = as_read(plan);
        let mut candidates = plan.candidates.clone();
        for candidate in &mut candidates {
            candidate.values = values(plan);
        }
        read.sigma = None;
        for chosen_one in improve(machine, &parameters, &read, &candidates, more) {
            if let Some(candidate) = plan.candidates.get(chosen_one).copied() {
                plan.visit(&candidate, "more")
                    .map_err(|reason| Stop::Usage(format!("no way to a further pose: {reason}")))?;
            }
        }
        report.push_str(&said(&format!("with {more} more poses it"), name, chosen, &parameters, plan));
    }
    Ok(report)
}

/// What a plan tells, in words.
fn said(who: &str, name: &str, chosen: &Chosen, parameters: &[ParameterName], plan: &Builder) -> String {
    let read = as_read(plan);
    let told = told(&chosen.machine, parameters, std::slice::from_ref(&read));
    let unknowns = told.columns - told.parameters;
    let mut out = format!(
        "preset {name}, {} parameters and {unknowns} unknowns of the set-up: {who} tells {} of {} (condition {:.0})\n",
        told.parameters, told.rank, told.columns, told.condition
    );
    if !told.idle.is_empty() {
        let shown: Vec<&str> = told.idle.iter().map(String::as_str).take(MOST_NAMES).collect();
        let _ = writeln!(out, "  not felt: {}{}", shown.join(", "), more(told.idle.len(), shown.len()));
    }
    for sentence in told.sentences.iter().take(MOST_SENTENCES) {
        let _ = writeln!(out, "  cannot tell: {sentence}");
    }
    if told.sentences.len() > MOST_SENTENCES {
        let _ = writeln!(out, "  cannot tell:{}", more(told.sentences.len(), MOST_SENTENCES));
    }
    out
}

/// How many are not shown.
fn more(all: usize, shown: usize) -> String {
    if all > shown { format!(" and {} more", all - shown) } else { String::new() }
}

/// The measurement as if it had been made.
fn as_read(plan: &Builder) -> DataSet {
    let mut read = plan.data.clone();
    let values = values(plan);
    for row in &mut read.observations {
        row.values = values;
    }
    read
}

fn values(plan: &Builder) -> [Option<f64>; 3] {
    plan.reads.map(|is_read| is_read.then_some(READ))
}

/// What the command line wishes, in the units of the program.
fn wishes(arguments: &PlanArguments, machine: &Machine) -> Result<Wishes, Stop> {
    let given = [
        ("centre", arguments.centre.is_some()),
        ("radius", arguments.radius.is_some()),
        ("feed", arguments.feed.is_some()),
        ("plane", !arguments.plane.is_empty()),
        ("every", arguments.every.is_some()),
        ("sweep", arguments.sweep.is_some()),
        ("overlap", arguments.overlap.is_some()),
        ("chord", arguments.chord.is_some()),
        ("variant", arguments.variant.is_some()),
        ("ball", !arguments.ball.is_empty()),
        ("clearance", arguments.clearance.is_some()),
        ("tilt", arguments.tilt.is_some()),
        ("axis", arguments.axis.is_some()),
        ("component", !arguments.component.is_empty()),
        ("range", arguments.range.is_some()),
        ("points", arguments.points.is_some()),
        ("runs", arguments.runs.is_some()),
        ("dwell", arguments.dwell.is_some()),
        ("hours", arguments.hours.is_some()),
        ("speed", arguments.speed.is_some()),
        ("seed", arguments.seed.is_some()),
        ("line", arguments.line.is_some()),
    ];
    let kind = arguments.kind;
    if let Some((name, _)) = given.iter().find(|(name, is_given)| *is_given && !kind.wishes.contains(name)) {
        let known: Vec<String> = kind.wishes.iter().map(|wish| format!("--{wish}")).collect();
        let message = format!("a plan {} has no --{name}; it has --tool, {}", kind.name, known.join(", "));
        return Err(Stop::Usage(message));
    }
    if arguments.tool.len() > 1 && kind.name != "plate" {
        return Err(Stop::Usage(format!("a plan {} has one --tool", kind.name)));
    }
    let spindle = machine.spindle.axis;
    let tool = |tool: &ToolVector| match tool {
        ToolVector::Tip(tip_mm) => *tip_mm,
        ToolVector::Length(length_mm) => -spindle * *length_mm,
    };
    let angle = |degrees: Option<f64>| degrees.map(f64::to_radians);
    let is_turned = arguments.axis.is_some_and(|axis| axis.is_rotary());
    Ok(Wishes {
        tools_mm: arguments.tool.iter().map(tool).collect(),
        centre_mm: arguments.centre,
        radius_mm: arguments.radius,
        feed: arguments.feed,
        planes: arguments.plane.clone(),
        every: if kind.name == "plate" { arguments.every } else { angle(arguments.every) },
        sweep: angle(arguments.sweep),
        overlap: angle(arguments.overlap),
        chord: angle(arguments.chord),
        variant: arguments.variant.clone(),
        balls_mm: arguments.ball.clone(),
        clearance_mm: arguments.clearance,
        tilt: angle(arguments.tilt),
        axis: arguments.axis,
        components: arguments.component.clone(),
        range: arguments.range.map(|range| if is_turned { range.map(f64::to_radians) } else { range }),
        points: arguments.points,
        runs: arguments.runs,
        dwell_s: arguments.dwell,
        hours: arguments.hours,
        speed: arguments.speed,
        seed: arguments.seed.unwrap_or(1),
        line: arguments.line.clone(),
    })
}
