//! `ncfix plan`: poses of a measurement and the program that runs them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::arguments::PlanArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::output::Target;
use super::program::protect;
use super::stop::Stop;
use super::together::Together;
use super::value::ToolVector;
use super::{measurement, parameters, tell};
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::words::listed;
use ncfix_metrology::calibrate::{Column, Parameter, identify, improve};
use ncfix_metrology::measure::data::{DataSet, Observation};
use ncfix_metrology::measure::plan::builder::Builder;
use ncfix_metrology::measure::plan::{Wishes, table};
use ncfix_path::emit::flat;

/// What a row without a reading is taken for when it is asked what it tells.
const READ: f64 = 0.0;
/// Names that are shown of those that would have to be left out.
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
    if targets.iter().any(|target| !target.is_file()) {
        return Err(Stop::Usage("the plan is two files; give -o the name of the table, such as plan.csv".into()));
    }
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
    let Some(others) = others(&arguments.with, &chosen.machine, findings)? else { return Ok(None) };
    let mut report = String::new();
    if let Some(name) = &arguments.model {
        let Some(parameters) = parameters::choose(name, &chosen.machine, &chosen.errors, findings)? else {
            return Ok(None);
        };
        report = judge(name, arguments.improve.unwrap_or(0), &chosen, &mut plan, others, &parameters)?;
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
    let mut together = Together::default();
    for (target, text) in targets.into_iter().zip(texts) {
        together.add(target, &text)?;
    }
    together.publish()?;
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

/// Measurements and plans that are there already; `None` where one is no such thing. Empty cells of a measurement say nothing, a table without any
/// reading is a plan.
fn others(tables: &[PathBuf], machine: &Machine, findings: &mut Findings) -> Result<Option<Vec<DataSet>>, Stop> {
    let mut out = Vec::new();
    let mut is_sound = true;
    for (number, table) in tables.iter().enumerate() {
        let mut found = Findings::default();
        let made = measurement::read(table, number, false, machine, &mut found)?;
        let made = made.filter(|one| one.data.observations.iter().any(has_reading));
        let read = if made.is_some() { made } else { measurement::read(table, number, true, machine, findings)? };
        match read {
            Some(read) => out.push(read.data),
            None => is_sound = false,
        }
    }
    Ok(is_sound.then_some(out))
}

/// Whether something was read in a row: a value, or the position at a ball.
fn has_reading(row: &Observation) -> bool {
    row.values.iter().any(Option::is_some) || row.target.is_some() && row.component.is_none()
}

/// Asks what the plan tells of a preset, together with other measurements, and adds poses.
fn judge(
    name: &str,
    more: usize,
    chosen: &Chosen,
    plan: &mut Builder,
    others: Vec<DataSet>,
    parameters: &[Parameter],
) -> Result<String, Stop> {
    if !plan.is_geometric {
        return Err(Stop::Usage("this plan is no measurement of a preset's parameters; leave --model out".into()));
    }
    let machine = &chosen.machine;
    let mut all = vec![as_read(plan)];
    let mut report = String::new();
    let who = match others.len() {
        0 => "the plan".to_owned(),
        count => {
            report.push_str(&said("the plan alone", name, chosen, parameters, &all));
            all.extend(others);
            format!("with {count} other{} it", if count > 1 { "s" } else { "" })
        }
    };
    report.push_str(&said(&who, name, chosen, parameters, &all));
    if more > 0 {
        if plan.candidates.is_empty() {
            return Err(Stop::Usage("this plan has no further poses to choose from; leave --improve out".into()));
        }
        let mut candidates = plan.candidates.clone();
        for candidate in &mut candidates {
            candidate.values = values(plan);
        }
        for chosen_one in improve(machine, &chosen.errors, parameters, &all, &candidates, more) {
            if let Some(candidate) = plan.candidates.get(chosen_one).copied() {
                plan.visit(&candidate, "more")
                    .map_err(|reason| Stop::Usage(format!("no way to a further pose: {reason}")))?;
            }
        }
        if let Some(own) = all.first_mut() {
            *own = as_read(plan);
        }
        report.push_str(&said(&format!("with {more} more poses it"), name, chosen, parameters, &all));
    }
    Ok(report)
}

/// What a plan tells, in words.
fn said(who: &str, name: &str, chosen: &Chosen, parameters: &[Parameter], data: &[DataSet]) -> String {
    let Some(told) = identify(&chosen.machine, &chosen.errors, parameters, data) else {
        return format!("{who} has positions that are too large to judge it\n");
    };
    let (columns, count) = (told.columns.len(), parameters.len());
    let unknowns = told.columns.iter().filter(|column| matches!(column, Column::Unknown(..))).count();
    let mut out = format!(
        "model {name}, {count} parameters and {unknowns} unknowns of the set-up: {who} tells {} of {columns} (condition {:.0})\n",
        told.rank, told.condition
    );
    for one in told.lost.confused.iter().take(MOST_SENTENCES) {
        let _ = writeln!(out, "  cannot tell: {}\n    {}", one.sentence, one.remedy);
    }
    let all = told.lost.confused.len();
    if all > MOST_SENTENCES {
        let _ = writeln!(out, "  cannot tell:{}", more(all, MOST_SENTENCES));
    }
    let silent = told.lost.unknowns.iter().filter(|_| told.lost.leave_out.is_empty());
    for sentence in silent.take(MOST_SENTENCES) {
        let _ = writeln!(out, "  no harm: {sentence}");
    }
    if told.lost.leave_out.len() > 1 {
        let left_out = &told.lost.leave_out;
        let _ = writeln!(
            out,
            "  all others could be told without these {}: {}",
            left_out.len(),
            listed(left_out, MOST_NAMES)
        );
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
        ("centre", !arguments.centre.is_empty()),
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
        ("force", !arguments.force.is_empty()),
        ("place", !arguments.place.is_empty()),
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
    if arguments.centre.len() > 1 && kind.name != "plate" {
        return Err(Stop::Usage(format!("a plan {} has one --centre", kind.name)));
    }
    let spindle = machine.spindle.axis;
    let tool = |tool: &ToolVector| match tool {
        ToolVector::Tip(tip_mm) => *tip_mm,
        ToolVector::Length(length_mm) => -spindle * *length_mm,
    };
    let angle = |degrees: Option<f64>| degrees.map(f64::to_radians);
    let is_turned = arguments.axis.is_some_and(|axis| axis.is_rotary());
    let linear = machine.axes.iter().flatten().filter(|data| !data.axis.is_rotary());
    let slowest = linear.filter_map(|data| data.max_feed).min_by(f64::total_cmp);
    if let (Some(feed), Some(most), false) = (arguments.feed, slowest, is_turned)
        && feed > most
    {
        // The control would be slower than the program says, or the machine faster than it may.
        return Err(Stop::Usage(format!(
            "--feed {feed} mm/min is beyond the {most} mm/min that every linear axis of the machine {} has; give {most} or less",
            machine.name
        )));
    }
    Ok(Wishes {
        tools_mm: arguments.tool.iter().map(tool).collect(),
        centres_mm: arguments.centre.clone(),
        margin_mm: arguments.margin,
        forces_n: arguments.force.clone(),
        places_mm: arguments.place.clone(),
        radius_mm: arguments.radius,
        feed: arguments.feed,
        planes: arguments.plane.clone(),
        every: if matches!(kind.name, "plate" | "load") { arguments.every } else { angle(arguments.every) },
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
