//! The first run of a program that is fed: all diagnostics, a check of every line against the link, the forecast.

use std::collections::BTreeSet;

use crate::correction::corrected_before;
use crate::coverage;
use crate::diagnostics::Diagnostics;
use crate::disk::hash::short_hash;
use crate::error::Error;
use crate::head;
use crate::run::{self, Watch};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::Source;
use ncfix_dnc::drip::Lines;
use ncfix_dnc::feed::{Forecaster, Line, LinkRate, port};
use ncfix_language::exec::RapidOrder;
use ncfix_machine::machine::{Firmware, LackingWord};
use ncfix_path::path::{Corrector, Output};
use ncfix_report::feed::{Before, FeedEvent, Late, rate};

use super::job::Transfer;
use super::live_lines::LiveLines;

/// Maximum number of reported lines that the link cannot take.
const MOST_SHOWN: usize = 20;
/// Largest permitted share of the motion during which the control is starved.
const MOST_STARVED: f64 = 0.01;
/// Starved intervals shorter than this are not reported, s.
const UNNOTICED_S: f64 = 0.05;
/// Starvation up to this total time, s, is always permitted.
const LEAST_STARVED_S: f64 = 0.5;

/// Runs the program without sending anything; `None` if there are errors.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn run(
    job: &Transfer,
    (port, has_sensors): (&str, bool),
    watch: Option<fn() -> Box<dyn Watch>>,
    findings: &mut Diagnostics,
) -> Result<Option<Before>, Error> {
    let profile = &job.link.profile;
    // A file waits in the control as a whole before it is started.
    let sends_file = profile.protocol.sends_file;
    if let Some(caution) = &profile.caution {
        let help = "if yours is such a control, load the corrected program instead: `ncfix IN -o OUT`";
        findings.add(Diagnostic::nowhere(Code::LINK_OF_OTHERS, caution.clone(), help), &[]);
    }
    let own = LinkRate { characters_per_s: f64::INFINITY, answer_s: 0.0, lines: 1, bytes: usize::MAX };
    let lines = LinkRate {
        characters_per_s: port::characters_per_s(port, profile),
        answer_s: profile.answer_s,
        lines: profile.window.lines + profile.window.planned,
        // Answered lines use no bytes of the window.
        bytes: if profile.window.planned > 0 { usize::MAX } else { profile.window.bytes },
    };
    let link = if sends_file { own } else { lines };
    let mut forecaster = Forecaster::new(link);
    let end_of_block = profile.frame.end_of_block.len();
    // One line for each reason, so that no reason is hidden by many lines with another.
    let (mut refused, mut reasons, mut options) = (Vec::new(), BTreeSet::new(), BuildOptions::default());
    let base = job.machine.model();
    let mut live = if has_sensors && !sends_file { LiveLines::new(job, &base)? } else { None };
    let program = walk(job, watch, findings, &mut |step| {
        let line = match step {
            Step::Element(output) => {
                if let Some(live) = &mut live {
                    live.take(output);
                }
                return;
            }
            Step::Line(line) => line,
        };
        if let Err(why) = profile.check(&line.text)
            && refused.len() < MOST_SHOWN
            && reasons.insert(why.clone())
        {
            refused.push(not_for_link(line, &why, profile.longest_line, profile.firmware));
        }
        if let Some(firmware) = profile.firmware {
            options.take(firmware, &line.text);
        }
        forecaster.line(line.text.len() + end_of_block, line.source_line, line.busy_s);
    })?;
    if let (Some(mut live), true) = (live, refused.is_empty()) {
        live.finish();
        refused = live.refused;
    }
    findings.extend(refused, &[]);
    findings.extend(profile.firmware.and_then(|firmware| options.finish(firmware)), &[]);
    if findings.has_errors() {
        return Ok(None);
    }
    let forecast = forecaster.finish();
    if forecast.lines == 0 {
        return Err(Error::usage("the program has no line to send".into()));
    }
    let late = |stretch: &ncfix_dnc::feed::Stretch| Late {
        source_lines: stretch.source_lines,
        starved_s: stretch.starved_s,
        needed_per_s: stretch.needed_per_s,
        given_per_s: stretch.given_per_s,
    };
    // As many lines of middle length as the window takes, and those that the control holds beyond it.
    let by_bytes = profile.window.bytes as f64 * forecast.lines as f64 / (forecast.bytes as f64).max(1.0);
    let frozen = by_bytes.floor().clamp(1.0, profile.window.lines.max(1) as f64) + profile.window.planned as f64;
    let per_line_s = forecast.motion_s / forecast.lines as f64;
    let before = Before {
        schema: 1,
        event: FeedEvent::Forecast,
        program,
        lines: forecast.lines,
        bytes: forecast.bytes,
        motion_s: forecast.motion_s,
        total_s: forecast.total_s,
        starved_s: forecast.starved_s,
        lowest: forecast.lowest.filter(|_| !sends_file),
        line_by_line: !sends_file && link.lines <= 1,
        file: profile.file.path.clone().filter(|_| sends_file),
        frozen_s: if sends_file { forecast.motion_s } else { per_line_s * frozen.min(forecast.lines as f64) },
        late: forecast.stretches.iter().filter(|stretch| stretch.starved_s >= UNNOTICED_S).map(late).collect(),
        sensors: Vec::new(),
        diagnostics: Vec::new(),
    };
    judge(job.options.allow_starvation, &before, findings);
    Ok(Some(before))
}

/// The steps of the survey of a program.
pub(crate) enum Step<'a> {
    /// The next element, before its lines.
    Element(&'a Output),
    /// A line.
    Line(&'a Line),
}

/// Executes and corrects a program without temperatures; after an error without lines, so that all diagnostics are reported. Returns the hash of all of
/// its files.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn walk(
    job: &Transfer,
    watch: Option<fn() -> Box<dyn Watch>>,
    findings: &mut Diagnostics,
    look: &mut dyn FnMut(Step<'_>),
) -> Result<String, Error> {
    let machine = &job.machine.machine;
    let model = job.machine.model();
    let opened = job.open()?;
    let mut running = job.program.start_as(opened, machine, run::strict(RapidOrder::All));
    if let Some(watch) = watch {
        running = running.watched(watch());
    }
    let mut corrector = Corrector::new(running, machine, &model, job.writing.options.clone());
    let mut lines = Lines::new(machine, &model, &job.writing.options, job.writing.writer()?, job.settings)
        .rewritten(job.link.profile.protocol.rewrite.map(|create| create()))
        .stating(&job.stated);
    let mut found = Vec::new();
    let mut is_good = true;
    for output in &mut corrector {
        match output {
            Ok(output) if is_good => {
                look(Step::Element(&output));
                if let Err(finding) = lines.take(output, None, false) {
                    is_good = false;
                    found.push(finding);
                }
                while let Some(line) = lines.pop() {
                    look(Step::Line(&line));
                }
            }
            Ok(_) => {}
            Err(finding) => {
                is_good &= !finding.is_error();
                found.push(finding);
            }
        }
    }
    if is_good && let Err(finding) = lines.finish() {
        is_good = false;
        found.push(finding);
    }
    while let Some(line) = lines.pop() {
        look(Step::Line(&line));
    }
    let sources = corrector.elements().sources();
    if is_good {
        found.extend(coverage::of_run(&job.machine, corrector.elements().extent(), false).1);
    }
    findings.extend(found, sources);
    if is_good {
        let extent = corrector.elements().extent();
        let tolerance_mm = job.writing.options.tolerance_mm;
        head::zeros(&head::in_use(&job.machine, &model, extent), extent, tolerance_mm, findings);
    }
    for corrected in sources.iter().skip(1).filter_map(corrected_before) {
        findings.add(corrected, sources);
    }
    Ok(short_hash(sources.iter().map(Source::bytes)))
}

/// Rates of lines are stated from this ratio on.
const TOLD_RATIO: f64 = 1.05;

/// Checks whether the link is fast enough.
fn judge(allows_starvation: bool, before: &Before, findings: &mut Diagnostics) {
    let Some(worst) = before.late.first() else { return };
    let [first, last] = worst.source_lines;
    let lines = if first == last { format!("line {first}") } else { format!("lines {first} to {last}") };
    // Over a section that mostly waits for the motion, both means are equal and say nothing.
    let rates = if worst.needed_per_s > TOLD_RATIO * worst.given_per_s {
        format!(": {} lines/s needed, {} available", rate(worst.needed_per_s), rate(worst.given_per_s))
    } else {
        String::new()
    };
    let message = format!(
        "the axes will stand still for {:.1} s of {:.1} s, mostly at {lines} of the original{rates}{}",
        before.starved_s,
        before.total_s,
        if before.line_by_line { ", because this link sends line by line" } else { "" }
    );
    let is_much = before.starved_s > LEAST_STARVED_S.max(MOST_STARVED * before.motion_s);
    let help = if before.line_by_line {
        "load the corrected program into the control (`ncfix IN -o OUT`), or choose a larger --tolerance for fewer lines"
    } else {
        "choose a higher baud rate or a larger --tolerance, remove the block numbers from the program, or load the corrected program into the control"
    };
    let (code, help) = if is_much && !allows_starvation {
        (Code::STARVED, format!("{help}; --allow-starvation sends it anyway"))
    } else {
        (Code::STARVING, help.to_owned())
    };
    findings.add(Diagnostic::nowhere(code, message, help), &[]);
}

/// Words of the lines that only some builds of the firmware have.
#[derive(Default)]
struct BuildOptions(Vec<LackingWord>);

impl BuildOptions {
    fn take(&mut self, firmware: Firmware, line: &[u8]) {
        firmware.each_lacking(line, |word| {
            if word.is_option && !self.0.contains(&word) {
                self.0.push(word);
            }
        });
    }

    fn finish(self, firmware: Firmware) -> Option<Diagnostic> {
        if self.0.is_empty() {
            return None;
        }
        let words: Vec<String> = self.0.iter().map(|word| word.text()).collect();
        let message = format!(
            "only some builds of {} have these words: {}; without it, the control refuses its line in the middle of the job",
            firmware.name(),
            words.join(", ")
        );
        let help = "check that your control has it, or remove it from the program: M8 switches the flood coolant";
        Some(Diagnostic::nowhere(Code::NOT_AT_THIS_CONTROL, message, help))
    }
}

fn not_for_link(line: &Line, why: &str, longest_line: usize, firmware: Option<Firmware>) -> Diagnostic {
    let text = String::from_utf8_lossy(&line.text);
    let message = format!("line {} of the original becomes '{text}': {why}", line.source_line);
    let lacks = firmware.is_some_and(|firmware| !firmware.lacks(&line.text).is_empty());
    let help = if lacks {
        "remove the word from the program, or choose the post-processor of this control; with its name as controller in the machine file, drilling cycles, variables and O words become moves; if the control is another one, choose its link with --link"
    } else if text.len() > longest_line {
        "change the program there, choose a larger --increment for shorter numbers, or another profile with --link"
    } else {
        "change the program there, choose another profile with --link, or load the corrected program into the control (`ncfix IN -o OUT`)"
    };
    Diagnostic::nowhere(Code::NOT_FOR_LINK, message, help)
}
