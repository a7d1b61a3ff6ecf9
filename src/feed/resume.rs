//! Interrupted jobs: the content of their journals, and the places where they can be resumed.

use std::path::Path;

use super::book::is_held;
use super::drive::Begin;
use super::job::Transfer;
use super::survey::{Step, walk};
use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::disk::hash::short_hash;
use crate::error::Error;
use crate::run::Watch;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::{FileId, Source};
use ncfix_dnc::drip::restart::{CLEAR_MM, RestartPlace, RestartSearch, SearchOutcome, Why};
use ncfix_dnc::drip::{Ends, Grammar, Heights};
use ncfix_dnc::feed::{Frozen, HeadKey, JournalContents, JournalEnd, read_journal};
use ncfix_machine::machine::ToolChange;
use ncfix_path::path::Tips;
use ncfix_report::feed::{Before, Plan};

/// Moves of the program that the plan shows, with the lines between them.
const SHOWN: usize = 3;
const MOST_SHOWN: usize = 40;

/// An interrupted job.
pub(crate) struct Broken {
    /// Its journal.
    pub(crate) source: Source,
    /// The content of the journal.
    pub(crate) told: JournalContents,
}

/// Reads the journal of an interrupted job.
///
/// # Errors
/// If it cannot be read, or there is nothing to take up again.
pub(crate) fn read(path: &Path) -> Result<Broken, Error> {
    let source = files::read(path, FileId(0), "journal")?;
    let shown = path.display();
    if is_held(path) {
        return Err(Error::usage(format!("the job of {shown} is still running")));
    }
    let text = String::from_utf8_lossy(source.bytes()).into_owned();
    let told = read_journal(&text).map_err(|(line, why)| Error::usage(format!("{shown}:{line}: {why}")))?;
    if told.ended == Some(JournalEnd::Done) {
        // A link without reports ends with its last byte: the control may have lost the blocks in its buffer.
        let lost = match told.executed {
            0 => {
                "; if the control lost power or was reset before it executed them, delete the journal, and feed the program from its beginning (docs/how-to/restart.md)"
            }
            _ => "",
        };
        return Err(Error::usage(format!(
            "all lines of the job of {shown} were sent: there is nothing to resume{lost}"
        )));
    }
    if let Some(JournalEnd::NotStarted(_)) = &told.ended {
        return Err(Error::usage(format!(
            "no line of the job of {shown} was executed: feed the program from its beginning with `ncfix feed`"
        )));
    }
    if let Some(JournalEnd::TakenUp(other)) = &told.ended
        && !is_empty(other)
    {
        return Err(Error::usage(format!("the job of {shown} was resumed: its journal is {other}")));
    }
    if told.frozen == 0 && !head(&told, HeadKey::Resumed).is_empty() {
        return Err(Error::usage(format!(
            "{shown} has no line: the control accepted none when the job was resumed; use the newest journal in its folder, `ncfix resume {shown}.old` or .old1 …"
        )));
    }
    Ok(Broken { source, told })
}

/// The words of the command line with which the job began.
///
/// # Errors
/// If it began in another folder.
pub(crate) fn began_with(told: &JournalContents) -> Result<impl Iterator<Item = &str>, Error> {
    let folder = std::env::current_dir().map(|folder| folder.display().to_string()).unwrap_or_default();
    let began_in = head(told, HeadKey::Folder);
    if folder != began_in {
        return Err(Error::usage(format!("the job began in the folder {began_in}; change to it first")));
    }
    Ok(told.head.iter().filter(|(key, _)| *key == HeadKey::Argument).map(|(_, value)| value.as_str()))
}

/// True if a journal says that no line was sent.
fn is_empty(journal: &str) -> bool {
    let text = std::fs::read_to_string(journal);
    text.is_ok_and(|text| read_journal(&text).is_ok_and(|told| told.frozen == 0))
}

/// The value of a key in the head of a journal.
fn head(told: &JournalContents, key: HeadKey) -> &str {
    told.head.iter().find(|(known, _)| *known == key).map_or("", |(_, value)| value)
}

/// Refuses a job with changed settings or files.
pub(crate) fn check_same(told: &JournalContents, job: &Transfer, before: &Before, findings: &mut Diagnostics) {
    let state = job.machine.state.clone().unwrap_or_default();
    let first = |key: HeadKey| head(told, key).split(' ').next().unwrap_or_default().to_owned();
    for (key, what, is) in [
        (HeadKey::Program, "the program, or one that it calls,", before.program.as_str()),
        (HeadKey::Machine, "the machine file", job.machine.hash.as_str()),
        (HeadKey::State, "the state of the machine", state.as_str()),
        (HeadKey::Link, "the profile of the link", job.link.hash.as_str()),
        (HeadKey::Sensors, "the file of the sensors", job.sensors_hash.as_str()),
        (HeadKey::Version, "the version of ncfix", env!("CARGO_PKG_VERSION")),
    ] {
        let was = first(key);
        if was != is {
            let message = format!("{what} has changed since the job began (was {was}, is {is})");
            let help = if key == HeadKey::Machine {
                "restore it; if a new tool has another length, the job cannot be resumed: feed the program from its beginning, or correct the original again and start it at the control with a block search"
            } else {
                "restore it; otherwise correct the original again, and feed it from its beginning or start it at the control with a block search"
            };
            findings.add(Diagnostic::nowhere(Code::OTHER_JOB, message, help), &[]);
        }
    }
}

/// Last element at which the earlier parts of a resumed job can be resumed, the last one that they may have sent, and the last source line that they have
/// certainly executed; 0 without such parts.
fn earlier(told: &JournalContents) -> [u64; 3] {
    let mut words = head(told, HeadKey::Earlier).split(' ').map(|word| word.parse().unwrap_or(0));
    [(); 3].map(|()| words.next().unwrap_or(0))
}

/// True if a line names an axis.
fn is_move(text: &[u8]) -> bool {
    text.split(|&byte| byte == b' ').any(|word| word.first().is_some_and(|letter| b"XYZABCUVW".contains(letter)))
}

/// The largest number of blocks that the control may have received and not executed, and the source of that number: the value that it stated when the
/// job began, but at least the bound of the profile.
fn holds(told: &JournalContents, job: &Transfer) -> Option<(u64, String)> {
    if !job.link.profile.protocol.has_planner {
        return None;
    }
    let source =
        job.link.profile.depth.as_ref().map(|bound| format!("profile {}: {}", job.link.profile.name, bound.source));
    let bound = job.link.profile.holds_at_most().zip(source);
    let stated = told.holds.clone().map(|(most, said)| (most, format!("the control: {said}")));
    [bound, stated].into_iter().flatten().max_by_key(|(most, _)| *most)
}

/// The reason why the job cannot be resumed.
fn refusal(found: &SearchOutcome, clearance_mm: Option<f64>) -> Option<Diagnostic> {
    let by_hand = "lift the tool by hand, remove the journal, and feed the program from its beginning";
    let stated_mm = clearance_mm.unwrap_or_default();
    let (code, message, help) = match *found {
        SearchOutcome::Place(_) | SearchOutcome::Beginning(..) => return None,
        SearchOutcome::NotStated(highest_z_mm) => {
            let highest = highest_z_mm.map_or(String::new(), |mm| {
                format!("; the highest point of the feed moves is at Z {mm:.3} mm of the program")
            });
            (
                Code::NOT_CLEAR,
                format!(
                    "no height is given at which the tool may move to the resume position: the height of workpiece and clamps is not known{highest}"
                ),
                "give a height clear of workpiece and clamps, Z of the program with its unit: --clearance 25mm"
                    .to_owned(),
            )
        }
        SearchOutcome::TooLow(highest_z_mm) => (
            Code::CLEARANCE_TOO_LOW,
            format!(
                "--clearance {stated_mm:.3} mm is not {CLEAR_MM} mm above the highest point of the feed moves, Z {highest_z_mm:.3} mm of the program"
            ),
            "give a height above that, and above the workpiece and its clamps".to_owned(),
        ),
        SearchOutcome::OutOfTravel([low_mm, high_mm]) => (
            Code::CLEARANCE_TOO_LOW,
            format!(
                "--clearance {stated_mm:.3} mm is outside the travel of Z, {low_mm:.3} to {high_mm:.3} mm of the program with the tool and zero offset active there"
            ),
            "give a height within it; check its unit, and axis.Z.travel_mm in the machine file".to_owned(),
        ),
        SearchOutcome::Nothing(why) => {
            let message = match why {
                Why::Tilted => "the tool was tilted against Z: lifting Z would pull it sideways through the workpiece".to_owned(),
                Why::HeightUnknown(line) => {
                    format!("line {line} of the original machines at a height that the program does not state: the space above it is not known")
                }
                Why::BeginningCrosses => {
                    "only a restart from the beginning is possible, and ncfix cannot lift the tool before it: the program first changes the tool, its length or another state, so the height of --clearance is not certain there"
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

/// The added lines as the control gets them.
fn rewritten(job: &Transfer, lines: Vec<String>) -> Result<Vec<String>, String> {
    let Some(create) = job.link.profile.protocol.rewrite else { return Ok(lines) };
    let mut rewriter = create();
    let mut out = Vec::new();
    for line in lines {
        let parts = rewriter.rewrite(line.as_bytes())?;
        out.extend(parts.iter().map(|part| String::from_utf8_lossy(part).into_owned()));
    }
    Ok(out)
}

/// The place where the job is resumed; a diagnostic if it cannot be resumed.
pub(crate) fn plan(
    told: &JournalContents,
    (input, port): (String, String),
    job: &Transfer,
    watch: Option<fn() -> Box<dyn Watch>>,
    (journal, clearance_mm): (&[u8], Option<f64>),
) -> Result<Result<(Plan, Begin), Diagnostic>, Error> {
    if job.link.profile.protocol.sends_file {
        let why = "the control has the program as a file: continue it there with a block search; or remove the journal, and feed the program from its beginning";
        return Err(Error::usage(why.into()));
    }
    let mut ignored = Diagnostics::default();
    let (mut ends, mut heights) = (Ends::new(told), Heights::default());
    let from_start = || Tips::new(&job.machine.machine, &job.writing.options);
    let mut tips = from_start();
    walk(job, watch, &mut ignored, &mut |step| {
        if let Step::Element(output) = step {
            ends.element(output);
            heights.look(&tips, output);
            tips.take(output);
        }
    })?;
    let mut tips = from_start();
    walk(job, watch, &mut ignored, &mut |step| {
        if let Step::Element(output) = step {
            heights.take(&tips, output);
            tips.take(output);
        }
    })?;
    let holds = holds(told, job);
    let sure = ends.sure(told, holds.as_ref().map(|(most, _)| *most));
    let at = |number: u64| told.lines.iter().find(|line: &&Frozen| line.number == number);
    // Without a record, only the beginning is certain.
    let until = at(sure + 1).or(at(sure)).map_or(0, |line| line.element);
    let sent = at(told.frozen).map_or(0, |line| line.element);
    // What earlier parts of the job have certainly executed stays executed.
    let [until_before, sent_before, line_before] = earlier(told);
    let (until, sent) = (until.max(until_before), sent.max(sent_before));
    let executed_line = at(sure).map_or(0, |line| u64::from(line.source_line)).max(line_before);
    let grammar = Grammar::new(job.dialect, job.machine.machine.control.tool_change == ToolChange::T);
    let mut search = RestartSearch::new(grammar, (from_start(), &heights), [until, sent], clearance_mm);
    walk(job, watch, &mut ignored, &mut |step| match step {
        Step::Element(output) => search.element(output),
        Step::Line(line) => search.line(line),
    })?;
    let unsure = search.unsure();
    let found = search.finish();
    if let Some(finding) = refusal(&found, clearance_mm) {
        return Ok(Err(finding));
    }
    let (place, skip, lines, above_mm) = match found {
        SearchOutcome::Place(place) => (Some(place.clone()), place.element - 1, place.lines, place.above_mm),
        SearchOutcome::Beginning(lines, above_mm) => (None, 0, lines, above_mm),
        _ => (None, 0, Vec::new(), f64::NAN),
    };
    let lines = match rewritten(job, lines) {
        Ok(lines) => lines,
        Err(why) => return Err(Error::usage(why)),
    };
    let mut first = Vec::new();
    let mut moves = 0;
    walk(job, watch, &mut ignored, &mut |step| {
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
    // Lines of an approach have no source line.
    let line_of = |number: u64| at(number).map(|line| line.source_line).filter(|line| *line > 0);
    let plan = Plan {
        schema: 1,
        plan: number.clone(),
        program: input.clone(),
        ended: told.ended.as_ref().map(ToString::to_string),
        acknowledged: told.acknowledged,
        acknowledged_line: line_of(told.acknowledged),
        executed: sure,
        executed_line: u32::try_from(executed_line).ok().filter(|line| *line > 0),
        holds: holds.as_ref().map(|(most, _)| *most),
        holds_source: holds.map(|(_, source)| source),
        sent: told.frozen,
        sent_line: line_of(told.frozen),
        source_line: first.first().map_or(0, |(line, _)| *line),
        is_beginning: skip == 0,
        above_mm: Some(above_mm).filter(|mm| mm.is_finite()),
        unsure_line: unsure.filter(|_| place.is_none()),
        tool: place.and_then(|place: RestartPlace| place.tool),
        before: lines.clone(),
        first: first.into_iter().map(|(_, text)| text).collect(),
        clearance: clearance_mm.map(|mm| format!("{mm}mm")),
        port: port.clone(),
        needs_a_look: !job.link.profile.asks_idle(),
    };
    let words = told.head.iter().filter(|(key, _)| *key == HeadKey::Argument).map(|(_, word)| word.clone()).collect();
    let begin = Begin {
        input,
        port,
        skip,
        lines,
        words,
        resumed: Some(number),
        earlier: [until, sent, executed_line],
        zero_offsets: told.zero_offsets.clone(),
        journal: Some(journal.to_vec()),
    };
    Ok(Ok((plan, begin)))
}
