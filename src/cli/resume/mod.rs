//! `ncfix resume`: how a job that was broken off can be taken up again. It shows a plan, and does nothing without its number.

use crate::cli::arguments::{self, Command, FeedArguments, ResumeArguments};
use crate::cli::exit_code::ExitCode;
use crate::cli::feed::{self, Begin, Job, Step, walk};
use crate::cli::findings::Findings;
use crate::cli::input;
use crate::cli::machine_choice::short_hash;
use crate::cli::stop::Stop;
use crate::cli::{print, tell};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_dnc::drip::restart::{CLEAR_MM, Found, Place, Search, Why};
use ncfix_dnc::drip::{Ends, Grammar, Heights};
use ncfix_dnc::feed::{Frozen, Told, read_journal};
use ncfix_machine::machine::ToolChange;
use ncfix_path::path::Tips;
use ncfix_report::feed::{Before, Plan};
use ncfix_report::json;

/// Moves of the program that the plan shows, with the lines between them.
const SHOWN: usize = 3;
const MOST_SHOWN: usize = 40;

/// Shows the plan, or carries it out.
pub(in crate::cli) fn run(arguments: &ResumeArguments) -> Result<ExitCode, Stop> {
    let source = input::read(&arguments.journal, FileId(0), "journal")?;
    let shown = arguments.journal.display();
    if feed::is_held(&arguments.journal) {
        return Err(Stop::Usage(format!("the job of {shown} is still running")));
    }
    let text = String::from_utf8_lossy(source.bytes()).into_owned();
    let told = read_journal(&text).map_err(|(line, why)| Stop::Usage(format!("{shown}:{line}: {why}")))?;
    if told.ended.as_deref() == Some("done") {
        return Err(Stop::Usage(format!("the job of {shown} is done: there is nothing to take up again")));
    }
    if let Some(other) = told.ended.as_deref().and_then(|ended| ended.strip_prefix(feed::TAKEN_UP))
        && !is_empty(other)
    {
        return Err(Stop::Usage(format!("the job of {shown} was taken up again: its journal is {other}")));
    }
    if told.frozen == 0 && !head(&told, "resumed").is_empty() {
        return Err(Stop::Usage(format!(
            "{shown} has no line: the control took none when the job was to be taken up again; look at the newest journal beside it, `ncfix resume {shown}.old` or .old1 …"
        )));
    }
    let mut feed = began_with(&told)?;
    if arguments.port.is_some() {
        feed.port.clone_from(&arguments.port);
    }
    // Who looked when the job began has not looked now.
    feed.i_checked_the_machine_stands_still = arguments.i_checked_the_machine_stands_still;
    feed.journal = Some(arguments.journal.clone());
    let mut findings = Findings::default();
    let Some((job, before)) = feed::prepare(&feed, &mut findings)? else {
        findings.draw();
        return Ok(findings.exit_code());
    };
    check_same(&told, &job, &before, &mut findings);
    if feed.dosing.zero_now {
        let message = "drift counts from the condition in which the job began (--zero-now), which is gone";
        let help = "set the zero point of the workpiece anew, and feed what is left as a job of its own";
        findings.add(Diagnostic::nowhere(Code::OTHER_JOB, message, help), &[]);
    }
    if findings.has_errors() {
        findings.draw();
        tell(&format!("{}; nothing was sent\n", findings.count()));
        return Ok(findings.exit_code());
    }
    let planned = plan(&told, &feed, &job, (source.bytes(), arguments.clearance))?;
    let (plan, begin) = match planned {
        Ok(planned) => planned,
        Err(finding) => {
            findings.add(finding, &[]);
            findings.draw();
            tell(&format!("{}; nothing was sent\n", findings.count()));
            return Ok(findings.exit_code());
        }
    };
    match &arguments.confirm {
        None => {
            print(&if arguments.json {
                json::line(&plan).map_err(Stop::Usage)?
            } else {
                plan.table(&shown.to_string())
            })?;
            Ok(ExitCode::Done)
        }
        Some(confirmed) if *confirmed == plan.plan => {
            tell(&format!("taking up again at line {} of the source\n", plan.source_line));
            feed::send(&feed, job, &before, &begin)
        }
        Some(confirmed) => Err(Stop::Usage(format!(
            "{confirmed} is not the number of the plan for this journal, which is {}: read it first (ncfix resume {shown})",
            plan.plan
        ))),
    }
}

/// Whether a journal says that no line was sent.
fn is_empty(journal: &str) -> bool {
    let text = std::fs::read_to_string(journal);
    text.is_ok_and(|text| read_journal(&text).is_ok_and(|told| told.frozen == 0))
}

/// The value of a name in the head of a journal.
fn head<'t>(told: &'t Told, name: &str) -> &'t str {
    told.head.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value)
}

/// The arguments with which the job began.
fn began_with(told: &Told) -> Result<FeedArguments, Stop> {
    let folder = std::env::current_dir().map(|folder| folder.display().to_string()).unwrap_or_default();
    let began_in = head(told, "folder");
    if folder != began_in {
        return Err(Stop::Usage(format!("the job began in the folder {began_in}; go there first")));
    }
    let words = told.head.iter().filter(|(name, _)| name == "argument").map(|(_, value)| value.as_str());
    let words = std::iter::once("ncfix").chain(words);
    match arguments::parse(words.map(std::ffi::OsString::from)) {
        Ok((_, Command::Feed(feed))) => Ok(*feed),
        _ => Err(Stop::Usage("the journal does not say how the job began".into())),
    }
}

/// Refuses what is not as it was.
fn check_same(told: &Told, job: &Job, before: &Before, findings: &mut Findings) {
    let state = job.chosen.state.clone().unwrap_or_default();
    let first = |name: &str| head(told, name).split(' ').next().unwrap_or_default().to_owned();
    for (what, was, is) in [
        ("the program, or one that it calls,", first("program"), before.program.as_str()),
        ("the machine file", first("machine"), job.chosen.hash.as_str()),
        ("the state of the machine", first("state"), state.as_str()),
        ("the profile of the link", first("link"), job.link_hash.as_str()),
        ("the file of the sensors", first("sensors"), job.sensors_hash.as_str()),
        ("the version of ncfix", first("version"), env!("CARGO_PKG_VERSION")),
    ] {
        if was != is {
            let message = format!("{what} is not the one with which the job began ({was}, now {is})");
            let help = "bring back what it was, or machine the workpiece in another way";
            findings.add(Diagnostic::nowhere(Code::OTHER_JOB, message, help), &[]);
        }
    }
}

/// Whether a line names an axis.
fn is_move(text: &[u8]) -> bool {
    text.split(|&byte| byte == b' ').any(|word| word.first().is_some_and(|letter| b"XYZABCUVW".contains(letter)))
}

/// How many blocks the control may have taken and not carried out, at most, and where that comes from: what it stated when the job began, and no less
/// where a bound of the profile is smaller.
fn holds(told: &Told, job: &Job) -> Option<(u64, String)> {
    if !job.profile.protocol.has_planner {
        return None;
    }
    let source = job.profile.depth.as_ref().map(|bound| format!("profile {}: {}", job.profile.name, bound.source));
    let bound = job.profile.holds_at_most().zip(source);
    let stated = told.holds.clone().map(|(most, said)| (most, format!("the control: {said}")));
    [bound, stated].into_iter().flatten().max_by_key(|(most, _)| *most)
}

/// Why nothing is taken up again.
fn refusal(found: &Found, clearance_mm: Option<f64>) -> Option<Diagnostic> {
    let by_hand = "lift the tool by hand, remove the journal, and feed the program from its beginning";
    let stated_mm = clearance_mm.unwrap_or_default();
    let (code, message, help) = match *found {
        Found::Place(_) | Found::Beginning(..) => return None,
        Found::NotStated(highest_z_mm) => {
            let highest = highest_z_mm
                .map_or(String::new(), |mm| format!("; all that is machined ends at Z {mm:.3} mm of the program"));
            (
                Code::NOT_CLEAR,
                format!(
                    "no height is stated over which the tool may go to where the program is taken up again: nobody but you knows how high workpiece and clamps stand{highest}"
                ),
                "state a height that is clear of workpiece and clamps, Z of the program with its unit: --clearance 25mm".to_owned(),
            )
        }
        Found::TooLow(highest_z_mm) => (
            Code::CLEARANCE_TOO_LOW,
            format!(
                "--clearance {stated_mm:.3} mm is not {CLEAR_MM} mm above all that is machined, which ends at Z {highest_z_mm:.3} mm of the program"
            ),
            "state a height above that, and above the workpiece and its clamps".to_owned(),
        ),
        Found::OutOfTravel([low_mm, high_mm]) => (
            Code::CLEARANCE_TOO_LOW,
            format!(
                "--clearance {stated_mm:.3} mm is outside of the travel of Z, which goes from {low_mm:.3} to {high_mm:.3} mm of the program with the tool and the zero offset there"
            ),
            "state a height within it; look at its unit, and at axis.Z.travel_mm in the machine file".to_owned(),
        ),
        Found::Nothing(why) => {
            let message = match why {
                Why::Tilted => "the tool was tilted against Z: lifting Z draws it sideways through the workpiece".to_owned(),
                Why::HeightUnknown(line) => {
                    format!("line {line} of the source machines at a height that the program does not state: what is above it is not known")
                }
                Why::BeginningCrosses => {
                    "only the beginning is left, and nothing can lift the tool to the stated height before it: behind a tool, its length or a word of unknown effect Z means something else"
                        .to_owned()
                }
            };
            let help = match why {
                Why::Tilted => {
                    "retract the tool by hand along itself, remove the journal, and feed the program from its beginning"
                }
                Why::HeightUnknown(_) | Why::BeginningCrosses => by_hand,
            };
            (Code::NOT_CLEAR, message, help.to_owned())
        }
    };
    Some(Diagnostic::nowhere(code, message, help))
}

/// Where the job is taken up again; a finding where it is not.
fn plan(
    told: &Told,
    feed: &FeedArguments,
    job: &Job,
    (journal, clearance_mm): (&[u8], Option<f64>),
) -> Result<Result<(Plan, Begin), Diagnostic>, Stop> {
    let mut ignored = Findings::default();
    let (mut ends, mut heights) = (Ends::new(told), Heights::default());
    let from_start = || Tips::new(&job.chosen.machine, &job.writing.options);
    let mut tips = from_start();
    walk(feed, job, &mut ignored, &mut |step| {
        if let Step::Element(output) = step {
            ends.element(output);
            heights.look(&tips, output);
            tips.take(output);
        }
    })?;
    let mut tips = from_start();
    walk(feed, job, &mut ignored, &mut |step| {
        if let Step::Element(output) = step {
            heights.take(&tips, output);
            tips.take(output);
        }
    })?;
    let holds = holds(told, job);
    let sure = ends.sure(told, holds.as_ref().map(|(most, _)| *most));
    let at = |number: u64| told.lines.iter().find(|line: &&Frozen| line.number == number);
    // Without a record of it nothing but the beginning is sure.
    let until = at(sure + 1).or(at(sure)).map_or(0, |line| line.element);
    let sent = at(told.frozen).map_or(0, |line| line.element);
    let grammar = Grammar::new(job.dialect, job.chosen.machine.control.tool_change == ToolChange::T);
    let mut search = Search::new(grammar, (from_start(), &heights), [until, sent], clearance_mm);
    walk(feed, job, &mut ignored, &mut |step| match step {
        Step::Element(output) => search.element(output),
        Step::Line(line) => search.line(line),
    })?;
    let unsure = search.unsure();
    let found = search.finish();
    if let Some(finding) = refusal(&found, clearance_mm) {
        return Ok(Err(finding));
    }
    let (place, skip, lines, above_mm) = match found {
        Found::Place(place) => (Some(place.clone()), place.element - 1, place.lines, place.above_mm),
        Found::Beginning(lines, above_mm) => (None, 0, lines, above_mm),
        _ => (None, 0, Vec::new(), f64::NAN),
    };
    let mut first = Vec::new();
    let mut moves = 0;
    walk(feed, job, &mut ignored, &mut |step| {
        if let Step::Line(line) = step
            && line.element > skip
            && moves < SHOWN
            && first.len() < MOST_SHOWN
        {
            moves += usize::from(is_move(&line.text));
            first.push((line.source_line, String::from_utf8_lossy(&line.text).into_owned()));
        }
    })?;
    let number = short_hash([journal, &skip.to_le_bytes()[..], lines.join("\n").as_bytes()]);
    let line_of = |number: u64| at(number).map(|line| line.source_line);
    let plan = Plan {
        schema: 1,
        plan: number.clone(),
        program: feed.input.display().to_string(),
        ended: told.ended.clone(),
        acknowledged: told.acknowledged,
        acknowledged_line: line_of(told.acknowledged),
        executed: sure,
        executed_line: line_of(sure),
        holds: holds.as_ref().map(|(most, _)| *most),
        holds_source: holds.map(|(_, source)| source),
        sent: told.frozen,
        sent_line: line_of(told.frozen),
        source_line: first.first().map_or(0, |(line, _)| *line),
        is_beginning: skip == 0,
        above_mm: Some(above_mm).filter(|mm| mm.is_finite()),
        unsure_line: unsure.filter(|_| place.is_none()),
        tool: place.and_then(|place: Place| place.tool),
        before: lines.clone(),
        first: first.into_iter().map(|(_, text)| text).collect(),
        clearance: clearance_mm.map(|mm| format!("{mm}mm")),
        port: feed.port.clone().unwrap_or_default(),
    };
    let words = told.head.iter().filter(|(name, _)| name == "argument").map(|(_, word)| word.clone()).collect();
    Ok(Ok((plan, Begin { skip, lines, words, resumed: Some(number), journal: Some(journal.to_vec()) })))
}
