//! `ncfix resume`: how a job that was broken off can be taken up again. It shows a plan, and does nothing without its number.

use super::arguments::{self, Command, FeedArguments, ResumeArguments};
use super::exit_code::ExitCode;
use super::feed::{self, Begin, Job, Step, walk};
use super::findings::Findings;
use super::input;
use super::machine_choice::short_hash;
use super::stop::Stop;
use super::{print, tell};
use crate::diagnostic::{Code, Diagnostic};
use crate::drip::restart::{Place, Search, cuts_at_mm};
use crate::feed::{Frozen, Told, read_journal};
use crate::report::feed::{Before, Plan};
use crate::report::json;
use crate::source::FileId;

/// Moves of the program that the plan shows, with the lines between them.
const SHOWN: usize = 3;
const MOST_SHOWN: usize = 40;

/// Shows the plan, or carries it out.
pub(super) fn run(arguments: &ResumeArguments) -> Result<ExitCode, Stop> {
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
    let (plan, begin) = plan(&told, &feed, &job, text.as_bytes())?;
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

/// Where the job is taken up again.
fn plan(told: &Told, feed: &FeedArguments, job: &Job, journal: &[u8]) -> Result<(Plan, Begin), Stop> {
    // What was acknowledged may still have been in the planner of the control when it was lost.
    let planned = job.profile.window.planned as u64;
    let taken = if told.left == 0 {
        told.acknowledged.saturating_sub(planned)
    } else if planned > 0 {
        told.left.saturating_sub(planned)
    } else {
        // How much a control holds that answers nothing is not known.
        0
    };
    let sure = told.executed.max(taken);
    let at = |number: u64| told.lines.iter().find(|line: &&Frozen| line.number == number);
    // Without a record of it nothing but the beginning is sure.
    let until = at(sure + 1).or(at(sure)).map_or(0, |line| line.element);
    let mut highest_mm = f64::NEG_INFINITY;
    let mut ignored = Findings::default();
    walk(feed, job, &mut ignored, &mut |step| {
        if let Step::Element(output) = step {
            highest_mm = highest_mm.max(cuts_at_mm(output).unwrap_or(f64::NEG_INFINITY));
        }
    })?;
    let mut search =
        Search::new(job.dialect.codes(), highest_mm, until, at(told.frozen).map_or(0, |line| line.element));
    walk(feed, job, &mut ignored, &mut |step| match step {
        Step::Element(output) => search.element(output),
        Step::Line(line) => search.line(line),
    })?;
    let unsure = search.unsure();
    let place = search.finish();
    let (skip, lines) = place.as_ref().map_or((0, Vec::new()), |place| (place.element - 1, place.lines.clone()));
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
        sent: told.frozen,
        sent_line: line_of(told.frozen),
        source_line: first.first().map_or(0, |(line, _)| *line),
        is_beginning: skip == 0,
        unsure_line: unsure.filter(|_| place.is_none()),
        tool: place.and_then(|place: Place| place.tool),
        before: lines.clone(),
        first: first.into_iter().map(|(_, text)| text).collect(),
        port: feed.port.clone().unwrap_or_default(),
    };
    let words = told.head.iter().filter(|(name, _)| name == "argument").map(|(_, word)| word.clone()).collect();
    Ok((plan, Begin { skip, lines, words, resumed: Some(number) }))
}
