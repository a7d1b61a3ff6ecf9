//! The send loop over port, sender, sensors and keyboard, with one clock.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use super::book::Book;
use super::job::Transfer;
use super::meter::Meter;
use super::source::{self, AHEAD, LineSource};
use super::start_state;
use super::thermal::{Standing, Thermal};
use super::{FeedEnd, FeedView, Sent};
use crate::error::Error;
use ncfix_base::geometry::{AXES, AXIS_COUNT, AxisKey};
use ncfix_dnc::drip::Lines;
use ncfix_dnc::feed::{Ended, Event, Halt, HeadKey, Journal, LossKind, Port, Sender, TransferProgress};
use ncfix_dnc::sense::{Panel, SensorOutages, clock};
use ncfix_report::feed::{Before, ExecutionEvidence, FeedEvent, FeedOutcome, Status};

/// Interval between two checks of the clock, the keyboard and the sensors while nothing arrives.
const IDLE: Duration = Duration::from_millis(5);
/// Interval between two checks while bytes wait for the port, or lines for the execution.
const BUSY: Duration = Duration::from_micros(200);
/// Sensors without a value for this time before the start are missing.
const FIRST_READING: Duration = Duration::from_secs(180);
/// The time for sending the last message, a feed hold.
const LAST: Duration = Duration::from_millis(500);

/// The reason why a transfer did not begin.
#[derive(Debug)]
pub(crate) enum NotBegun {
    /// Something cannot be read or written.
    Error(Error),
    /// It ended before its first line.
    Ended(FeedEnd, String),
}

impl From<Error> for NotBegun {
    fn from(error: Error) -> NotBegun {
        NotBegun::Error(error)
    }
}

/// The link of a transfer.
pub(crate) struct Lane<'a> {
    pub(crate) port: Box<dyn Port>,
    /// Characters per second of the link.
    pub(crate) characters_per_s: f64,
    /// The sensors that are read at the same time.
    pub(crate) panel: Option<Panel>,
    /// Path of the journal.
    pub(crate) journal: &'a Path,
}

/// Sends a program over an open port.
///
/// # Errors
/// If the journal cannot be written, or the sensors do not start.
pub(crate) fn run(
    job: Transfer,
    lane: Lane<'_>,
    before: &Before,
    begin: &Begin,
    view: &mut dyn FeedView,
) -> Result<Sent, NotBegun> {
    let job = Arc::new(job);
    let started = Instant::now();
    let mut dialogue = job.dialogue()?;
    let zero = start_state::expected_zero(&job.program, &job.machine.machine, begin.zero_offsets.clone());
    if !dialogue.asks_zero() {
        let by_hand = zero.by_hand();
        let message = format!(
            "this link cannot ask the control for its zero offsets: before the start, compare {by_hand} of the machine file with the control, and the tool length"
        );
        view.say(FeedEvent::Zero, Duration::ZERO, None, message);
    }
    dialogue.expect(zero);
    let mut book = Book::create(lane.journal, begin.journal.as_deref())?;
    let head = head(&job, before, begin);
    let head: Vec<(HeadKey, &str)> = head.iter().map(|(key, value)| (*key, value.as_str())).collect();
    let unwritten = |error: &io::Error| Error::file("write", lane.journal, error);
    let mut journal = Journal::new(&mut book, &head).map_err(|error| unwritten(&error))?;
    let thermal = match lane.panel {
        Some(panel) => {
            let thermal = Thermal::start(&job, panel, job.options.every, job.options.zero_now, started);
            wait_for_sensors(&thermal, view, started)?;
            thermal
        }
        None => Thermal::default(),
    };
    let base = Arc::new(job.machine.model());
    let (to, made) = sync_channel(AHEAD);
    {
        let (job, base) = (Arc::clone(&job), Arc::clone(&base));
        let program = job.open()?;
        thread::spawn(move || source::produce(&job, &base, program, &to));
    }
    let lines = Lines::new(&job.machine.machine, &base, &job.writing.options, job.writing.writer()?, job.settings)
        .rewritten(job.link.profile.protocol.rewrite.map(|create| create()))
        .stating(&job.stated);
    let mut supply = LineSource::new(&job.options, made, lines, &thermal, (begin.skip, &begin.lines));
    let profile = &job.link.profile;
    let sender = Sender::new(dialogue, profile.window.system_bytes, &mut journal).patient(profile.patience);
    let bound = profile.holds_at_most();
    let (speed, meter, sends_file) = (lane.characters_per_s, Meter::new(), profile.protocol.sends_file);
    let mut drive = Drive {
        sender,
        port: lane.port,
        view,
        before,
        speed,
        bound,
        sends_file,
        started,
        has_asked: false,
        meter,
        halted: None,
    };
    let (ended, end) = drive.go(&mut supply, &thermal).map_err(|error| unwritten(&error))?;
    let status = drive.status(&supply, &thermal, Some(&ended));
    for (name, outages) in thermal.outages() {
        drive.view.say(FeedEvent::Sensors, started.elapsed(), None, outage_sentence(&name, &outages, started));
    }
    let may_have_run = drive.sender.may_have_run();
    let now = started.elapsed();
    journal.end(&ended, may_have_run, now).map_err(|error| unwritten(&error))?;
    book.close().map_err(|error| unwritten(&error))?;
    let may_be_resumed = end != FeedEnd::Done && status.sent > 0 && !profile.protocol.sends_file;
    Ok(Sent { status, end, may_be_resumed })
}

/// The place where a transfer begins.
#[derive(Clone, Debug, Default)]
pub(crate) struct Begin {
    /// The names of the program and of the port, as given.
    pub(crate) input: String,
    pub(crate) port: String,
    /// Elements of the program up to this one are skipped.
    pub(crate) skip: u64,
    /// The lines that are sent first.
    pub(crate) lines: Vec<String>,
    /// The words of the command line that began the job.
    pub(crate) words: Vec<String>,
    /// The plan for resuming, and the journal from which it was made.
    pub(crate) resumed: Option<String>,
    /// Of the earlier parts of the job: the last element at which they can be resumed, the last one that they may have sent, and the last source line that they
    /// have certainly executed.
    pub(crate) earlier: [u64; 3],
    /// Zero offsets that the control stated when the job began.
    pub(crate) zero_offsets: Option<String>,
    pub(crate) journal: Option<Vec<u8>>,
}

/// The settings that must be the same when the job is resumed.
fn head(job: &Transfer, before: &Before, begin: &Begin) -> Vec<(HeadKey, String)> {
    let mut head = vec![
        (HeadKey::Version, env!("CARGO_PKG_VERSION").to_owned()),
        (HeadKey::Program, format!("{} {}", before.program, begin.input)),
        (HeadKey::Machine, format!("{} {}", job.machine.hash, job.machine.machine.name)),
        (HeadKey::State, job.machine.state.clone().unwrap_or_default()),
        (HeadKey::Link, format!("{} {}", job.link.hash, job.link.profile.name)),
        (HeadKey::Sensors, job.sensors_hash.clone()),
        (HeadKey::Port, begin.port.clone()),
        (HeadKey::Lines, before.lines.to_string()),
    ];
    let folder = std::env::current_dir().map(|folder| folder.display().to_string()).unwrap_or_default();
    head.push((HeadKey::Folder, folder));
    head.extend(begin.resumed.clone().map(|resumed| (HeadKey::Resumed, resumed)));
    if begin.resumed.is_some() {
        let [until, sent, line] = begin.earlier;
        head.push((HeadKey::Earlier, format!("{until} {sent} {line}")));
    }
    head.extend(begin.words.iter().map(|word| (HeadKey::Argument, word.clone())));
    head
}

/// Waits until every sensor has a value.
fn wait_for_sensors(thermal: &Thermal, view: &mut dyn FeedView, started: Instant) -> Result<(), NotBegun> {
    loop {
        let (standing, _) = thermal.standing();
        let said = match standing {
            Standing::Good if thermal.now().model.is_some() => return Ok(()),
            Standing::Good => "reading temperatures".to_owned(),
            Standing::Waiting(names) => format!("waiting for the first reading of {names}"),
            Standing::Frozen(why) | Standing::Stop(why) | Standing::Hold(why) => {
                let message = format!("sensors are bad before the start: {why}; nothing was sent");
                return Err(NotBegun::Ended(FeedEnd::Sensors, message));
            }
        };
        if started.elapsed() > FIRST_READING {
            let message = format!(
                "{said}, for {} s: check with `ncfix sensors … --watch`; nothing was sent",
                FIRST_READING.as_secs()
            );
            return Err(NotBegun::Ended(FeedEnd::Sensors, message));
        }
        view.waiting(&said, started.elapsed());
        if view.is_stopped() {
            return Err(NotBegun::Ended(FeedEnd::Stopped, "stopped before the start; nothing was sent".into()));
        }
        thread::sleep(BUSY.max(IDLE));
    }
}

/// The main loop of a transfer.
struct Drive<'a> {
    sender: Sender<'a>,
    port: Box<dyn Port>,
    view: &'a mut dyn FeedView,
    before: &'a Before,
    /// Characters per second of the link.
    speed: f64,
    /// Largest number of blocks that the control has received and not executed, from the profile.
    bound: Option<u64>,
    /// True if the link sends the program as one file.
    sends_file: bool,
    started: Instant,
    /// True if the user was asked to start the control.
    has_asked: bool,
    /// The time from an answer to the bytes of the next line.
    meter: Meter,
    /// A stop requested by the user or a sensor, with its status, its reason and its message.
    halted: Option<(Halt, FeedEnd, String, String)>,
}

impl Drive<'_> {
    fn go(&mut self, supply: &mut LineSource, thermal: &Thermal) -> io::Result<(Ended, FeedEnd)> {
        let mut events: Vec<Event> = Vec::new();
        loop {
            let now = self.started.elapsed();
            let before = (self.sender.progress().sent, self.sender.progress().bytes);
            let ended = self.sender.step(now, self.port.as_mut(), supply, &mut |event| {
                if !matches!(event, Event::Acknowledged(_) | Event::Checked(_) | Event::Left(_) | Event::Executed(_)) {
                    events.push(event.clone());
                }
            })?;
            let progress = self.sender.progress();
            let has_worked = before != (progress.sent, progress.bytes);
            if before.0 > 0 && progress.sent > before.0 {
                self.meter.add(self.started.elapsed().saturating_sub(now));
            }
            let waits_for = self.sender.waits_for();
            if let Some(what) = waits_for.filter(|_| !std::mem::replace(&mut self.has_asked, true)) {
                self.view.say(FeedEvent::Stalled, now, None, what.to_owned());
            }
            // As long as a person has to start the control, silence is no fault.
            events.retain(|event| *event != Event::Stalled || waits_for.is_none());
            events.drain(..).for_each(|event| self.view.event(&event, now));
            if let Some(ended) = ended {
                self.flush(supply)?;
                return Ok(self.code(ended));
            }
            self.view.tick(now);
            self.watch(thermal, now);
            if let Some((Halt::Hold | Halt::Abort, code, _, said)) = self.halted.clone() {
                self.flush(supply)?;
                return Ok((Ended::Held(said), code));
            }
            if let Some((said, line)) = supply.warned.take() {
                self.view.say(
                    FeedEvent::Shift,
                    now,
                    None,
                    format!("{said} at line {line} of the original (--warn-shift)"),
                );
            }
            if self.view.is_due(now) {
                let status = self.status(supply, thermal, None);
                self.view.status(&status, now);
            }
            if !has_worked {
                self.port.wait(if self.sender.wants_to_write() || self.sender.is_hungry() { BUSY } else { IDLE });
            }
        }
    }

    /// The end, with its status.
    fn code(&self, ended: Ended) -> (Ended, FeedEnd) {
        let code = match &ended {
            Ended::Done => FeedEnd::Done,
            Ended::Stopped => self.halted.as_ref().map_or(FeedEnd::Stopped, |(_, code, ..)| *code),
            Ended::Refused(..) => FeedEnd::Control,
            Ended::Lost(LossKind::LinkGone, _) => FeedEnd::Link,
            Ended::Lost(..) | Ended::Held(_) => FeedEnd::Control,
            Ended::Fault(_) => FeedEnd::Fault,
        };
        (ended, code)
    }

    /// The keyboard and the sensors.
    fn watch(&mut self, thermal: &Thermal, now: Duration) {
        if self.view.is_stopped() {
            let halt = if self.halted.is_some() { Halt::Hold } else { Halt::Stop };
            self.halt(halt, FeedEnd::Stopped, "stopped by the user", now);
        }
        match thermal.standing().0 {
            Standing::Stop(why) if self.halted.is_none() => self.halt(Halt::Stop, FeedEnd::Sensors, &why, now),
            Standing::Hold(why) if self.halted.is_none() => self.halt(Halt::Hold, FeedEnd::Sensors, &why, now),
            Standing::Frozen(why) => self.view.frozen(&why, now),
            Standing::Good => self.view.thawed(now),
            _ => {}
        }
    }

    fn halt(&mut self, halt: Halt, code: FeedEnd, why: &str, now: Duration) {
        let said = self.sender.halt(halt, now);
        let halt = match (&said, halt) {
            // Without a hold command, the received blocks run to their end.
            (None, Halt::Hold) if self.halted.is_none() => {
                self.halt(Halt::Stop, code, why, now);
                return;
            }
            _ => halt,
        };
        let open = self.sender.progress().in_flight.0;
        let held = match self.most_held() {
            Some(most) => format!("up to {most} blocks that the control already holds"),
            None => "the blocks that the control already holds, whose number it does not report".to_owned(),
        };
        let by_hand = "this link has no command to hold the axes: use feed hold of the control; ncfix ends";
        let mut rest = vec![held];
        if open > 0 {
            rest.insert(0, lines(open as u64));
        }
        let what = said
            .or(self.sender.remains().map(|remains| format!("{by_hand}; {remains}")))
            .unwrap_or_else(|| format!("{by_hand}; {} may still be executed", rest.join(" and ")));
        let message = format!("{why}: {what}");
        self.view.say(FeedEvent::Halt, now, None, message.clone());
        self.halted = Some((halt, code, why.to_owned(), message));
    }

    /// Waits until the last message is sent.
    fn flush(&mut self, supply: &mut LineSource) -> io::Result<()> {
        let from = Instant::now();
        while self.sender.wants_to_write() && from.elapsed() < LAST {
            let now = self.started.elapsed();
            self.sender.step(now, self.port.as_mut(), supply, &mut |_| ())?;
            self.port.wait(BUSY);
        }
        Ok(())
    }

    /// The message for the lines of a job that are lost.
    fn lost(&self, kind: LossKind, why: &str, progress: &TransferProgress) -> String {
        let taken = progress.acknowledged.max(progress.left);
        if progress.sent == 0 {
            return format!("{why}; no line was sent");
        }
        if self.sends_file {
            let what =
                if self.sender.may_have_run() { "the transfer has ended" } else { "the program was not started" };
            return format!("{what}: {why}");
        }
        let open = progress.sent.saturating_sub(taken);
        let mut what = format!("the transfer has ended: {why}");
        if open == 0 && kind == LossKind::AtAnotherPosition {
            // It stands still at the end of what it has answered.
            return format!("{what}; the control has answered every line that was sent");
        }
        let held = taken.saturating_sub(progress.executed.unwrap_or(0));
        let before = if open > 0 { " before" } else { "" };
        if open > 0 {
            let were = if open == 1 { "was" } else { "were" };
            what += &format!("; {} {were} sent and not acknowledged", lines(open));
        }
        if held > 0 {
            what += &match self.most_held() {
                Some(most) if most < held => {
                    format!("; up to {most} of the {}{before} may still be in its buffer", lines(held))
                }
                Some(_) if held == 1 => format!("; the line{before} may still be in its buffer"),
                Some(_) => format!("; all {}{before} may still be in its buffer", lines(held)),
                None => format!(
                    "; any of the {}{before} may still be in its buffer, because the control does not report how many it holds",
                    lines(held)
                ),
            };
        }
        if open + held == 0 {
            return what;
        }
        what + "; the axes can still start: each of these may have been executed, or may still be executed: reset the control"
    }

    /// Maximum number of received lines that the control may not have executed yet; `None` if it does not report it.
    fn most_held(&self) -> Option<u64> {
        self.sender.progress().holds.max(self.bound)
    }

    fn status(&self, supply: &LineSource, thermal: &Thermal, ended: Option<&Ended>) -> Status {
        let progress: &TransferProgress = self.sender.progress();
        let elapsed_s = self.started.elapsed().as_secs_f64();
        let (standing, age) = thermal.standing();
        let left_s = (self.before.motion_s - supply.busy_s).max(0.0);
        // The sent blocks approximate the executed ones; the future pace is assumed to be the pace so far.
        let pace = if supply.busy_s > 0.0 { (elapsed_s / supply.busy_s).max(1.0) } else { 1.0 };
        let (word, message) = match ended {
            None => (None, None),
            Some(Ended::Done) => (Some(FeedOutcome::Done), None),
            Some(Ended::Stopped) => {
                let why = self.halted.as_ref().map_or("stopped", |(_, _, why, _)| why.as_str());
                let what = if progress.sent == 0 {
                    "no line was sent"
                } else if progress.left > 0 {
                    "every line sent was transmitted"
                } else {
                    "the control has answered every line"
                };
                let rest = if progress.sent > 0 { "; nothing else was sent" } else { "" };
                (Some(FeedOutcome::Stopped), Some(format!("{why}; {what}{rest}")))
            }
            Some(Ended::Held(why)) => (Some(FeedOutcome::Held), Some(why.clone())),
            Some(Ended::Lost(kind, why)) => (Some(FeedOutcome::Lost), Some(self.lost(*kind, why, progress))),
            Some(Ended::Refused(number, said)) => {
                (Some(FeedOutcome::Refused), Some(format!("the control refused line {number}: {said}")))
            }
            Some(Ended::Fault(why)) if !self.sender.may_have_run() => {
                (Some(FeedOutcome::Fault), Some(format!("{why}; no file was sent")))
            }
            Some(Ended::Fault(why)) => (
                Some(FeedOutcome::Fault),
                Some(format!(
                    "no further line was sent: {why}; the lines before it were {}",
                    if progress.left > 0 { "transmitted" } else { "answered" }
                )),
            ),
        };
        Status {
            schema: 1,
            event: if ended.is_some() { FeedEvent::End } else { FeedEvent::Status },
            time_s: elapsed_s,
            lines: self.before.lines,
            sent: progress.sent,
            acknowledged: progress.acknowledged,
            left: (progress.left > 0).then_some(progress.left),
            executed: progress.executed,
            window: progress.in_flight.0,
            window_bytes: progress.in_flight.1,
            lowest: progress.lowest.filter(|_| !self.sends_file),
            link_percent: self
                .speed
                .is_finite()
                .then(|| 100.0 * progress.bytes as f64 / (self.speed * elapsed_s.max(1e-3))),
            repeats: progress.repeats,
            // Before the first line a person may have to start the control.
            stalls: if progress.sent > 0 { progress.stalls } else { 0 },
            applied: axes(&progress.last.offset, &progress.last.target),
            target: axes(&progress.last.target, &progress.last.offset),
            sensor_age_s: age.map(|age| age.as_secs_f64()),
            sensors: match standing {
                Standing::Good => None,
                Standing::Waiting(why) | Standing::Frozen(why) | Standing::Stop(why) | Standing::Hold(why) => Some(why),
            },
            eta_s: (ended.is_none() && !self.sends_file).then_some(left_s * pace),
            delay_us: self.meter.microseconds().filter(|_| !self.sends_file),
            control: progress.control.clone(),
            ended: word,
            confirmed: evidence(ended, progress),
            in_position: progress.in_position.clone().filter(|_| ended.is_some()),
            message,
            source_line: progress.last.source_line,
        }
    }
}

/// Summary of the outages of a sensor, with the times of day.
fn outage_sentence(name: &str, outages: &SensorOutages, started: Instant) -> String {
    let begun = SystemTime::now() - started.elapsed();
    let [first, last] = [outages.first, outages.last].map(|after| clock(begun + after));
    let times = if outages.count == 1 { "once".to_owned() } else { format!("{} times", outages.count) };
    format!("sensor {name}: {times} without a good reading, {first} to {last} UTC")
}

/// A number of lines with its noun.
fn lines(count: u64) -> String {
    format!("{count} line{}", if count == 1 { "" } else { "s" })
}

/// Evidence that the control has executed the lines of a job that has ended.
fn evidence(ended: Option<&Ended>, progress: &TransferProgress) -> Option<ExecutionEvidence> {
    match ended? {
        Ended::Lost(LossKind::AtAnotherPosition, _) => Some(ExecutionEvidence::Differs),
        Ended::Done if progress.in_position.is_some() => Some(ExecutionEvidence::Position),
        Ended::Done if progress.executed.is_some_and(|executed| executed >= progress.sent) => {
            Some(ExecutionEvidence::Reported)
        }
        Ended::Done if progress.left > 0 => Some(ExecutionEvidence::Transmitted),
        Ended::Done => Some(ExecutionEvidence::Accepted),
        _ => None,
    }
}

/// Axes with a shift, or with a requested shift.
fn axes(values: &[f64; AXIS_COUNT], others: &[f64; AXIS_COUNT]) -> BTreeMap<AxisKey, f64> {
    let mut out = BTreeMap::new();
    for axis in AXES {
        let (value, other) = (values[axis.slot()], others[axis.slot()]);
        if value != 0.0 || other != 0.0 {
            let key = AxisKey::of_deviation(axis);
            out.insert(key, (key.shown(value) * 100.0).round() / 100.0);
        }
    }
    out
}
