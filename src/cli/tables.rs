//! `ncfix tables`: makes compensation tables, checks them as the control interpolates, reads, draws, compares and converts them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::arguments::TablesArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::output::{Spool, Target};
use super::stop::Stop;
use super::tables_compare::{difference, range_of};
use super::tables_read;
use super::value::ToolVector;
use super::{print, program, state};
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::{AxisVector, Vector};
use crate::machine::{ActiveTables, Machine};
use crate::model::Accumulator;
use crate::report::json;
use crate::report::tables::{CheckReport, TablesReport, TriedReport, picture};
use crate::tables::check::check;
use crate::tables::region::Region;
use crate::tables::scheme::{self, SCHEMES, Task};
use crate::tables::{Control, FORMATS, Format, Orientation, Tables, Wiring};
use crate::units::{um_from_mm, urad_from_rad};

/// Start of the generator of the poses of a check: none of those of a scheme.
const SEED: u64 = 0x43_4845_434b;

/// Makes or reads tables.
pub(super) fn run(arguments: &TablesArguments) -> Result<ExitCode, Stop> {
    if arguments.list {
        print(&list())?;
        return Ok(ExitCode::Done);
    }
    let mut findings = Findings::default();
    let mut report = TablesReport::default();
    let result = work(arguments, &mut report, &mut findings);
    if !arguments.json || result.is_err() {
        findings.draw();
    }
    result?;
    let goes_out = arguments.output.as_deref().is_some_and(super::input::is_standard_stream);
    if arguments.json {
        report.diagnostics = findings.json();
        print(&json::line(&report).map_err(Stop::Usage)?)?;
    } else if report.tables > 0 {
        if goes_out { super::tell(&report.page()) } else { print(&report.page())? }
    }
    Ok(findings.exit_code())
}

/// Tools whose tips are no farther apart are one, mm.
const SAME_TOOL_MM: f64 = 1e-6;

/// What is asked, with the machine that it is asked of.
struct Job<'a> {
    arguments: &'a TablesArguments,
    chosen: Chosen,
    region: Region,
    wiring: Wiring,
    tool_mm: Vector,
}

fn work(arguments: &TablesArguments, report: &mut TablesReport, findings: &mut Findings) -> Result<(), Stop> {
    if arguments.read.is_empty() {
        return make(arguments, report, findings);
    }
    let needs_machine = arguments.machine.machine.is_some() || arguments.check;
    let job = if needs_machine { job(arguments, findings)? } else { None };
    if needs_machine && job.is_none() {
        return Ok(());
    }
    let mut wiring = job.as_ref().map_or_else(Wiring::usual, |job| job.wiring.clone());
    arguments.axis_name.iter().for_each(|(axis, name)| wiring.rename(*axis, name));
    // A format to read in is only asked for where nothing is written.
    let asked = if arguments.output.is_none() { arguments.format } else { None };
    let Some(read) = tables_read::read(&arguments.read, asked, &wiring, findings)? else { return Ok(()) };
    report.note(&read.tables);
    report.format = read.format.name.to_owned();
    if let Some(job) = &job {
        report.machine.clone_from(&job.chosen.machine.name);
        if arguments.check {
            report.check = Some(job.check(&read.tables));
            let other = read.tool_mm.filter(|own| (own - job.tool_mm).norm() > SAME_TOOL_MM);
            report.made_for_tool_mm = other.map(|own| [own.x, own.y, own.z]);
        }
    }
    let other = match &arguments.compare {
        None => None,
        Some(path) => match tables_read::read(std::slice::from_ref(path), None, &wiring, findings)? {
            Some(other) => Some(other),
            None => return Ok(()),
        },
    };
    if let Some(other) = &other {
        let both = [&read.tables, &other.tables];
        let found = match &job {
            Some(job) => difference(both, Some(&job.chosen.machine), &job.region, job.tool_mm, SEED, arguments.poses),
            None => difference(both, None, &range_of(both), Vector::zeros(), SEED, arguments.poses),
        };
        report.difference = found?;
    }
    let mut files = Vec::new();
    if let (Some(format), Some(output)) = (arguments.format, &arguments.output) {
        let mut tables = read.tables.clone();
        (format.round)(&mut tables);
        let notes = [format!("read from {}", shown(&arguments.read))];
        files = texts(format, &tables, &wiring, &notes, output, findings);
        report.format = format!("{} as {}", read.format.name, format.name);
    } else if arguments.output.is_some() {
        return Err(Stop::Usage("give --format to convert the tables, or leave -o out".into()));
    }
    let mut sets = vec![("", &read.tables)];
    if let Some(other) = &other {
        sets = vec![("first ", &read.tables), ("second ", &other.tables)];
    }
    let inputs: Vec<PathBuf> = arguments.read.iter().chain(&arguments.compare).cloned().collect();
    publish(arguments, files, &sets, inputs, report, findings)
}

fn make(arguments: &TablesArguments, report: &mut TablesReport, findings: &mut Findings) -> Result<(), Stop> {
    let Some(format) = arguments.format else {
        return Err(Stop::Usage("give --format; ncfix tables --list shows what there is".into()));
    };
    let Some(output) = &arguments.output else {
        return Err(Stop::Usage("give -o, the file to write; -o - for standard output".into()));
    };
    let scheme = scheme::find(&arguments.scheme);
    if scheme.is_none() && !arguments.scheme.eq_ignore_ascii_case("auto") {
        let names: Vec<&str> = SCHEMES.iter().map(|scheme| scheme.name).chain(["auto"]).collect();
        return Err(Stop::Usage(format!("'{}' is no scheme; the schemes are {}", arguments.scheme, names.join(", "))));
    }
    let Some(job) = job(arguments, findings)? else { return Ok(()) };
    let machine = &job.chosen.machine;
    let model = job.chosen.model();
    let errors = Accumulator::sum(machine, &job.chosen.errors, &job.chosen.condition, |_| true);
    let target = job.target(&model);
    let task = Task {
        target,
        orientation: arguments.orientation.map(|choice| choice.orientation()),
        errors: &errors,
        region: &job.region,
        points: arguments.points as usize,
        tolerance_mm: arguments.tolerance,
        multiplication: arguments.multiplication.multiplication(),
        format,
        wiring: &job.wiring,
    };
    let refuse = |findings: &mut Findings, why: String| {
        let help = "ncfix tables --list shows what each format holds; try --scheme auto or a larger --tolerance";
        findings.add(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, why, help), &[]);
    };
    let (name, tables) = if let Some(scheme) = scheme {
        match scheme.tables(&task) {
            Ok(tables) => (scheme.name, tables),
            Err(why) => {
                refuse(findings, why);
                return Ok(());
            }
        }
    } else {
        let (best, tried) = scheme::choose(&task);
        report.tried = tried.iter().map(tried_report).collect();
        let Some((scheme, tables)) = best else {
            let tried: Vec<String> = report.tried.iter().map(said).collect();
            refuse(findings, format!("no scheme leaves {} um: {}", um_from_mm(arguments.tolerance), tried.join("; ")));
            return Ok(());
        };
        (scheme.name, tables)
    };
    report.machine.clone_from(&machine.name);
    name.clone_into(&mut report.scheme);
    format.name.clone_into(&mut report.format);
    report.note(&tables);
    if tables.is_empty() {
        findings.add(
            Diagnostic::nowhere(
                Code::TABLES_DO_NOT_FIT,
                "the model has no errors that tables correct",
                "calibrate the machine first",
            ),
            &[],
        );
        return Ok(());
    }
    let checked = job.check(&tables);
    let state = job.chosen.state.as_deref().map_or(String::new(), |state| format!(", state {state}"));
    let notes = [
        format!(
            "ncfix {}: machine {} ({}{state}), scheme {name}",
            env!("CARGO_PKG_VERSION"),
            machine.name,
            job.chosen.hash
        ),
        tables_read::tool_remark(&job.tool_mm),
        format!(
            "tip error over the volume, rms: {:.3} um without, {:.3} um with these tables",
            checked.before.rms_um, checked.tables.rms_um
        ),
        format!("{}; measure before and after: with the wrong sign errors double", format.sign),
    ];
    report.check = arguments.check.then_some(checked);
    let files = texts(format, &tables, &job.wiring, &notes, output, findings);
    publish(arguments, files, &[("", &tables)], job.chosen.files.clone(), report, findings)
}

/// The machine, the region and the names; `None` where findings forbid to use them.
fn job<'a>(arguments: &'a TablesArguments, findings: &mut Findings) -> Result<Option<Job<'a>>, Stop> {
    let beside = arguments.output.as_deref().or(arguments.read.first().map(PathBuf::as_path)).unwrap_or(Path::new("."));
    let Some(mut chosen) = machine_choice::choose(&arguments.machine, beside, findings)? else { return Ok(None) };
    // New tables are for the machine itself, and those that are checked stand for themselves.
    chosen.machine.active_tables = ActiveTables::default();
    if !state::apply(&arguments.state, &mut chosen, findings)? || findings.has_errors() {
        return Ok(None);
    }
    let mut region = Region::travel(&chosen.machine).map_err(|axis| {
        Stop::Usage(format!("axis {axis} has no travel; write travel_mm of it into the machine file"))
    })?;
    for &(axis, [low, high]) in &arguments.range {
        let Some(data) = chosen.machine.axis(axis) else {
            return Err(Stop::Usage(format!("--range: the machine has no axis {axis}")));
        };
        let unit = |value: f64| if axis.is_rotary() { value.to_radians() } else { value };
        let range = [unit(low), unit(high)];
        if let Some([lowest, highest]) =
            data.travel.filter(|[lowest, highest]| range[0] < lowest - 1e-9 || range[1] > highest + 1e-9)
        {
            let shown = |value: f64| if axis.is_rotary() { value.to_degrees() } else { value };
            return Err(Stop::Usage(format!("--range: {axis} travels from {} to {}", shown(lowest), shown(highest))));
        }
        region.set(axis, range);
    }
    let mut wiring = Wiring::of(&chosen.machine);
    arguments.axis_name.iter().for_each(|(axis, name)| wiring.rename(*axis, name));
    let tool_mm = match arguments.tool {
        Some(ToolVector::Tip(tip_mm)) => tip_mm,
        Some(ToolVector::Length(length_mm)) => chosen.machine.spindle.axis * -length_mm,
        None => chosen.machine.spindle.axis * -longest_tool_mm(&chosen.machine),
    };
    Ok(Some(Job { arguments, chosen, region, wiring, tool_mm }))
}

fn longest_tool_mm(machine: &Machine) -> f64 {
    machine.tools.iter().map(|tool| tool.length_mm[0].abs()).fold(0.0, f64::max)
}

impl Job<'_> {
    fn target<'t>(&'t self, model: &'t crate::model::Model) -> crate::tables::Target<'t> {
        crate::tables::Target {
            machine: &self.chosen.machine,
            model,
            tool_mm: self.tool_mm,
            orientation: self.arguments.orientation.map_or(Orientation::Smooth, |choice| choice.orientation()),
        }
    }

    /// What tables leave over the volume; a grid knows no rotary axes.
    fn check(&self, tables: &Tables) -> CheckReport {
        let model = self.chosen.model();
        let target = self.target(&model);
        let mut region = self.region.clone();
        if tables.grid.is_some() || tables.matrix.is_some() {
            for (axis, [low, high]) in self.region.ranges.iter().filter(|(axis, _)| axis.is_rotary()) {
                let at = 0_f64.clamp(*low, *high);
                region.set(*axis, [at, at]);
            }
        }
        let poses = region.poses(self.arguments.poses as usize, SEED);
        let found = check(&target, &Control::new(&self.chosen.machine, tables), &poses);
        CheckReport::new(&found, place(&region, &found.worst), &self.tool_mm)
    }
}

/// `X120.5 Y-3 A30`
fn place(region: &Region, pose: &AxisVector) -> String {
    let mut text = String::new();
    for &(axis, _) in &region.ranges {
        let value = if axis.is_rotary() { pose[axis].to_degrees() } else { pose[axis] };
        let _ = write!(text, "{}{axis}{value:.1}", if text.is_empty() { "" } else { " " });
    }
    text
}

/// The files of tables; none where the control cannot take them, which the findings say.
fn texts(
    format: &Format,
    tables: &Tables,
    wiring: &Wiring,
    notes: &[String],
    output: &Path,
    findings: &mut Findings,
) -> Vec<(PathBuf, String)> {
    for fault in format.faults_of(tables, wiring) {
        let help = "try --scheme auto, fewer --points or a larger --tolerance; ncfix tables --list shows the limits";
        findings.add(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, fault, help), &[]);
    }
    if findings.has_errors() {
        return Vec::new();
    }
    let written = (format.write)(tables, wiring, notes);
    let stem = output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = |suffix: &str| {
        if suffix.is_empty() { output.to_owned() } else { output.with_file_name(format!("{stem}{suffix}")) }
    };
    written.into_iter().map(|one| (name(&one.suffix), one.text)).collect()
}

/// Writes all files and the picture, or none.
fn publish(
    arguments: &TablesArguments,
    mut files: Vec<(PathBuf, String)>,
    sets: &[(&str, &Tables)],
    inputs: Vec<PathBuf>,
    report: &mut TablesReport,
    findings: &mut Findings,
) -> Result<(), Stop> {
    if findings.has_errors() {
        return Ok(());
    }
    if let Some(path) = &arguments.svg {
        files.push((path.clone(), picture(sets)));
    }
    let mut spools = Vec::new();
    for (path, text) in &files {
        let target = Target::new(path)?;
        if arguments.json && target == Target::Standard {
            return Err(Stop::Usage("--json and the tables cannot both go to standard output; give -o a file".into()));
        }
        program::protect(&target, inputs.iter(), findings);
        let mut spool = Spool::new(target)?;
        let written = spool.writer().write_all(text.as_bytes());
        written.map_err(|error| spool.fault(&error))?;
        spools.push(spool);
    }
    if findings.has_errors() {
        return Ok(());
    }
    for spool in spools {
        spool.publish(false)?;
    }
    report.written = files.iter().map(|(path, _)| path.display().to_string()).collect();
    Ok(())
}

fn tried_report(tried: &scheme::Tried) -> TriedReport {
    let mut report = TriedReport { scheme: tried.scheme.to_owned(), points: tried.points, ..TriedReport::default() };
    match &tried.outcome {
        Ok((tables, entries, [rms_mm, rms_rad])) => {
            (report.tables, report.entries) = (Some(*tables), Some(*entries));
            (report.rms_um, report.tilt_rms_urad) = (Some(um_from_mm(*rms_mm)), Some(urad_from_rad(*rms_rad)));
        }
        Err(why) => report.reason = Some(why.clone()),
    }
    report
}

/// `free with 33 points leaves 4.2 um`
fn said(tried: &TriedReport) -> String {
    match (&tried.reason, tried.rms_um) {
        (Some(reason), _) => format!("{}: {reason}", tried.scheme),
        (None, rms) => {
            format!("{} with {} points leaves {:.2} um", tried.scheme, tried.points, rms.unwrap_or(f64::NAN))
        }
    }
}

fn shown(paths: &[PathBuf]) -> String {
    let names = paths.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned());
    names.collect::<Vec<_>>().join(", ")
}

/// Formats and schemes.
fn list() -> String {
    let mut text = String::from("formats\n");
    let limit = |value: usize| if value == 0 { "-".to_owned() } else { value.to_string() };
    for one in FORMATS {
        let holds: Vec<String> = one.holds.iter().map(|what| format!("{what:?}").to_lowercase()).collect();
        let _ = writeln!(
            text,
            "  {:<11} {}: {}; tables {}, points {}, largest value {}",
            one.name,
            one.title,
            holds.join(", "),
            limit(one.limits.tables),
            limit(one.limits.points),
            if one.limits.value_mm > 0.0 { format!("{} mm", one.limits.value_mm) } else { "-".to_owned() }
        );
    }
    text.push_str("schemes\n");
    for one in SCHEMES {
        let _ = writeln!(text, "  {:<14} {}", one.name, one.title);
    }
    let _ = writeln!(text, "  {:<14} the fewest tables that reach the tolerance on this control", "auto");
    text
}
