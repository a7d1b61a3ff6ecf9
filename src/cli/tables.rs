//! `ncfix tables`: makes compensation tables, checks them as the control interpolates, reads, draws, compares and converts them.

use std::fmt::Write as _;

use super::arguments::TablesArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::stop::Stop;
use super::tables_job::{job, once};
use super::tables_write::{publish, texts};
use super::{print, tables_read, tables_reread};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Axis;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_model::Accumulator;
use ncfix_report::json;
use ncfix_report::number::significant;
use ncfix_report::tables::{CheckReport, TablesReport, TriedReport};
use ncfix_tables::tables::FORMATS;
use ncfix_tables::tables::format::Holds;
use ncfix_tables::tables::scheme::{self, SCHEMES, Task};

/// Makes or reads tables.
pub(super) fn run(arguments: &TablesArguments) -> Result<ExitCode, Stop> {
    if arguments.list {
        print(&list())?;
        return Ok(ExitCode::Done);
    }
    once("--axis-name", arguments.axis_name.iter().map(|(_, name)| name.clone()))?;
    once("--axis-name", arguments.axis_name.iter().map(|(axis, _)| format!("axis {axis}")))?;
    let mut findings = Findings::default();
    let mut report = TablesReport::default();
    let result = if arguments.read.is_empty() {
        make(arguments, &mut report, &mut findings)
    } else {
        tables_reread::work(arguments, &mut report, &mut findings)
    };
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
        multiplication: job.multiplication().unwrap_or_default(),
        format,
        wiring: &job.wiring,
    };
    let refuse = |findings: &mut Findings, why: String| {
        findings.add(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, why, help(&task)), &[]);
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
        report.aim = Some(aim(arguments.tolerance));
        report.tried = tried.iter().map(tried_report).collect();
        let Some((scheme, tables)) = best else {
            let tried: Vec<String> = report.tried.iter().map(said).collect();
            refuse(findings, format!("no scheme leaves {}: {}", aim(arguments.tolerance), tried.join("; ")));
            return Ok(());
        };
        (scheme.name, tables)
    };
    report.machine.clone_from(&machine.name);
    name.clone_into(&mut report.scheme);
    format.name.clone_into(&mut report.format);
    report.note(&tables);
    let checked = job.check(&tables);
    if tables.are_zeros() {
        report.tables = 0;
        let (why, help) = idle(&checked, &task);
        findings.add(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, why, help), &[]);
        return Ok(());
    }
    if let Some(finding) = worse(&job.everywhere(&tables, &checked), &job.volume()) {
        report.tables = 0;
        findings.add(finding, &[]);
        return Ok(());
    }
    let state = job.chosen.state.as_deref().map_or(String::new(), |state| format!(", state {state}"));
    let mut notes = vec![
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
    report.ranges = job.ranges();
    if !report.ranges.is_empty() {
        notes.push(format!("made for a part of the travel: {}", report.ranges.join(", ")));
    }
    report.check = arguments.check.then_some(checked);
    let files = texts(format, &tables, &job.wiring, &notes, output, findings)?;
    publish(arguments, files, &[("", &tables)], job.chosen.files.clone(), report, findings)
}

/// The finding for tables that leave more than no tables, at the tip or in the direction of the tool.
pub(super) fn worse(checked: &CheckReport, where_: &str) -> Option<Diagnostic> {
    /// What two ways to add up the same may differ by, µm and µrad.
    const NOISE: f64 = 1e-3;
    let (before, with) = (checked.before, checked.tables);
    let kinds = [
        ("tip", "um rms", before.rms_um, with.rms_um),
        ("direction of the tool", "urad rms", before.tilt_rms_urad, with.tilt_rms_urad),
    ];
    let (what, unit, without, left) = kinds.into_iter().find(|(.., without, left)| *left > without + NOISE)?;
    let message = format!(
        "the tables would leave more than no tables: the {what} is off by {} {unit} without them and by {} {unit} with them over {where_}, most at {}",
        significant(without),
        significant(left),
        checked.worst
    );
    let help = "nothing was written; take another --scheme (auto tries them all; own takes no axis that depends on another one), --orientation off \
                where the direction gets worse, the --tool that is used, a --range as large as the use; a constant part is one of the zero offset";
    Some(Diagnostic::nowhere(Code::TABLES_MAKE_WORSE, message, help))
}

/// The axes whose sense of motion counts and which the format has no tables for.
fn plays(task: &Task<'_>) -> Vec<String> {
    let has_play = |axis: &Axis| task.target.model.features(*axis).backlash;
    let is_left = !task.format.can_hold(Holds::Senses);
    task.region.axes().filter(has_play).filter(|_| is_left).map(|axis| axis.to_string()).collect()
}

/// What to do where tables do not fit.
fn help(task: &Task<'_>) -> String {
    let mut help =
        "ncfix tables --list shows what each format holds; try --scheme auto or a larger --tolerance".to_owned();
    if task.target.machine.axes.iter().flatten().any(|data| data.axis.is_rotary()) {
        help += "; --orientation six-rows or off asks for less of the rotary axes, --range for a part of the travel";
    }
    let plays = plays(task).join(" ");
    if !plays.is_empty() {
        help += &format!(
            "; what depends on the sense of {plays} is left: the control's backlash parameter takes it, or a format with senses"
        );
    }
    help
}

/// Why tables would be all zeros, and what to do.
fn idle(checked: &CheckReport, task: &Task<'_>) -> (String, String) {
    let before = checked.before;
    let is_nothing = |um: f64, urad: f64| um < 1e-3 && urad < 1e-3;
    if is_nothing(before.max_um, before.tilt_max_urad) {
        return ("the model has no errors that tables correct".into(), "calibrate the machine first".into());
    }
    let left = format!("{} um rms", significant(before.rms_um));
    let plays = plays(task).join(" ");
    if !plays.is_empty() {
        let why = format!("all values would be 0: of the {left} nothing is left without the senses of {plays}");
        let help = format!(
            "{} has no tables for a sense of motion: enter the play into the control's backlash parameter, or choose cec, comp, ssfk or heidenhain",
            task.format.title
        );
        return (why, help);
    }
    if before.rms_um <= um_from_mm(task.tolerance_mm) {
        let why =
            format!("all values would be 0: the tip is off by {left} without tables, which is within the tolerance");
        return (why, "choose a smaller --tolerance, or no tables".into());
    }
    let why = format!("all values would be 0 in the digits of {}, and the tip is off by {left}", task.format.title);
    (why, help(task))
}

/// `0.95 um, 5 % below the tolerance`
fn aim(tolerance_mm: f64) -> String {
    let below = (1.0 - scheme::AIM) * 100.0;
    let aim = format!("{:.9}", um_from_mm(scheme::AIM * tolerance_mm));
    format!("{} um, {below:.0} % below the tolerance", aim.trim_end_matches('0').trim_end_matches('.'))
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
