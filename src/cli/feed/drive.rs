//! Sends: the loop over port, sender, sensors and the keyboard, with one clock.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::{Duration, Instant};

use crate::cli::arguments::FeedArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::{complain, tell};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_dnc::drip::Lines;
use ncfix_dnc::feed::port::{self, OpenPort};
use ncfix_dnc::feed::{Ended, Event, Halt, Journal, Port, Progress, Sender};
use ncfix_report::feed::{Before, Status};

use super::book::{self, Book};
use super::job::Job;
use super::meter::Meter;
use super::show::{Show, axes};
use super::source::{self, AHEAD, Source};
use super::thermal::{Standing, Thermal};

/// Time between two looks at the clock, the keyboard and the sensors, where nothing comes.
const IDLE: Duration = Duration::from_millis(5);
/// The same where bytes wait for the port, or lines for the execution.
const BUSY: Duration = Duration::from_micros(200);
/// Sensors that have said nothing for so long before the start are not there.
const FIRST_READING: Duration = Duration::from_secs(180);
/// What goes out last, a hold, has so long to leave.
const LAST: Duration = Duration::from_millis(500);

/// Sends a program over an open port.
///
/// # Errors
/// Where the journal cannot be written, or the sensors do not begin.
pub(super) fn run(
    arguments: &FeedArguments,
    job: Job,
    opened: OpenPort,
    before: &Before,
    begin: &Begin,
) -> Result<ExitCode, Stop> {
    let job = Arc::new(job);
    let book_path = book::path(&arguments.input, arguments.journal.as_deref())?;
    let mut findings = Findings::default();
    if begin.resumed.is_none() {
        book::check(&book_path, &mut findings)?;
    }
    let help = "give the lasting name to --port, or change the profile";
    findings.extend(opened.notes.iter().map(|note| Diagnostic::nowhere(Code::SERIAL_SETTINGS, note, help)), &[]);
    let started = Instant::now();
    let panel = super::panel(arguments, &job, &mut findings)?;
    findings.draw();
    if findings.has_errors() {
        tell(&format!("{}; nothing was sent\n", findings.count()));
        return Ok(findings.exit_code());
    }
    let dialogue = super::dialogue(&job)?;
    let mut book = Book::create(&book_path, begin.journal.as_deref())?;
    let head = head(arguments, &job, before, begin);
    let head: Vec<(&str, &str)> = head.iter().map(|(name, value)| (*name, value.as_str())).collect();
    let unwritten = |error: &io::Error| Stop::file("write", &book_path, error);
    let mut journal = Journal::new(&mut book, &head).map_err(|error| unwritten(&error))?;
    let keys = Keys::new()?;
    let mut show = Show::new(arguments.json);
    let thermal = match panel {
        Some(panel) => {
            let thermal = Thermal::start(&job, panel, arguments.dosing.every, arguments.dosing.zero_now, started);
            wait_for_sensors(&thermal, &keys, &mut show, started)?;
            thermal
        }
        None => Thermal::default(),
    };
    let base = Arc::new(job.chosen.model());
    let (to, made) = sync_channel(AHEAD);
    {
        let (arguments, job, base) = (arguments.clone(), Arc::clone(&job), Arc::clone(&base));
        let program = job.open(&arguments)?;
        thread::spawn(move || source::produce(&arguments, &job, &base, program, &to));
    }
    let lines = Lines::new(&job.chosen.machine, &base, &job.writing.options, job.writing.writer()?, job.settings);
    let mut supply = Source::new(arguments, made, lines, &thermal, (begin.skip, &begin.lines));
    let sender = Sender::new(dialogue, job.profile.window.system_bytes, &mut journal).patient(job.profile.patience);
    let speed = port::characters_per_s(arguments.port.as_deref().unwrap_or_default(), &job.profile);
    let bound = job.profile.holds_at_most();
    let meter = Meter::new();
    let mut drive = Drive { sender, port: opened.port, show, before, speed, bound, started, meter, halted: None };
    let (ended, code) = drive.go(&mut supply, &thermal, &keys).map_err(|error| unwritten(&error))?;
    let status = drive.status(&supply, &thermal, Some(&ended));
    let mut show = drive.show;
    let now = started.elapsed();
    journal.end(&ended, now).map_err(|error| unwritten(&error))?;
    book.close().map_err(|error| unwritten(&error))?;
    show.end(&status)?;
    if let Some(message) = &status.message
        && !arguments.json
    {
        complain(message);
    }
    if code != ExitCode::Done && status.sent > 0 && !arguments.json {
        tell(&format!("help: `ncfix resume {}` shows how it can be taken up again\n", book_path.display()));
    }
    Ok(code)
}

/// Where a transfer begins.
#[derive(Clone, Debug, Default)]
pub(in crate::cli) struct Begin {
    /// Elements of the program up to this one are not sent.
    pub(in crate::cli) skip: u64,
    /// What is sent before.
    pub(in crate::cli) lines: Vec<String>,
    /// The words of the command line that began the job.
    pub(in crate::cli) words: Vec<String>,
    /// The plan by which it is taken up again, and the journal as it was read for that.
    pub(in crate::cli) resumed: Option<String>,
    pub(in crate::cli) journal: Option<Vec<u8>>,
}

/// What must be the same when the job is taken up again.
fn head(arguments: &FeedArguments, job: &Job, before: &Before, begin: &Begin) -> Vec<(&'static str, String)> {
    let mut head = vec![
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("program", format!("{} {}", before.program, arguments.input.display())),
        ("machine", format!("{} {}", job.chosen.hash, job.chosen.machine.name)),
        ("state", job.chosen.state.clone().unwrap_or_default()),
        ("link", format!("{} {}", job.link_hash, job.profile.name)),
        ("sensors", job.sensors_hash.clone()),
        ("port", arguments.port.clone().unwrap_or_default()),
        ("lines", before.lines.to_string()),
    ];
    let folder = std::env::current_dir().map(|folder| folder.display().to_string()).unwrap_or_default();
    head.push(("folder", folder));
    head.extend(begin.resumed.clone().map(|resumed| ("resumed", resumed)));
    head.extend(begin.words.iter().map(|word| ("argument", word.clone())));
    head
}

/// Ctrl-C and its kin.
struct Keys(Arc<AtomicBool>);

impl Keys {
    fn new() -> Result<Keys, Stop> {
        let pressed = Arc::new(AtomicBool::new(false));
        let signals = [
            signal_hook::consts::SIGINT,
            signal_hook::consts::SIGTERM,
            #[cfg(unix)]
            signal_hook::consts::SIGHUP,
        ];
        for signal in signals {
            signal_hook::flag::register(signal, Arc::clone(&pressed))
                .map_err(|error| Stop::Usage(format!("cannot listen to Ctrl-C: {error}")))?;
        }
        Ok(Keys(pressed))
    }

    fn pressed(&self) -> bool {
        self.0.swap(false, Ordering::Relaxed)
    }
}

/// Waits until every sensor has said something.
fn wait_for_sensors(thermal: &Thermal, keys: &Keys, show: &mut Show, started: Instant) -> Result<(), Stop> {
    loop {
        let (standing, _) = thermal.standing();
        let said = match standing {
            Standing::Good if thermal.now().model.is_some() => return Ok(()),
            Standing::Good => "reading temperatures".to_owned(),
            Standing::Waiting(names) => format!("waiting for the first reading of {names}"),
            Standing::Frozen(why) | Standing::Stop(why) | Standing::Hold(why) => {
                let message = format!("sensors are bad before the start: {why}; nothing was sent");
                return Err(Stop::Ended(ExitCode::Sensor, message));
            }
        };
        if started.elapsed() > FIRST_READING {
            let message = format!(
                "{said}, for {} s: look at `ncfix sensors … --watch`; nothing was sent",
                FIRST_READING.as_secs()
            );
            return Err(Stop::Ended(ExitCode::Sensor, message));
        }
        show.waiting(&said, started.elapsed());
        if keys.pressed() {
            return Err(Stop::Ended(ExitCode::Interrupted, "stopped before the start; nothing was sent".into()));
        }
        thread::sleep(BUSY.max(IDLE));
    }
}

/// The loop.
struct Drive<'a> {
    sender: Sender<'a>,
    port: Box<dyn Port>,
    show: Show,
    before: &'a Before,
    /// Characters a second that the link takes.
    speed: f64,
    /// Blocks that the control has taken and not carried out, at most, as the profile says.
    bound: Option<u64>,
    started: Instant,
    /// From an answer to the bytes of the next line.
    meter: Meter,
    /// What a person or a sensor has asked for, with its status, why, and what was said of it.
    halted: Option<(Halt, ExitCode, String, String)>,
}

impl Drive<'_> {
    fn go(&mut self, supply: &mut Source, thermal: &Thermal, keys: &Keys) -> io::Result<(Ended, ExitCode)> {
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
            events.drain(..).for_each(|event| self.show.event(&event, now));
            if let Some(ended) = ended {
                self.flush(supply)?;
                return Ok(self.code(ended));
            }
            self.show.tick(now);
            self.watch(thermal, keys, now);
            if let Some((Halt::Hold | Halt::Abort, code, _, said)) = self.halted.clone() {
                self.flush(supply)?;
                return Ok((Ended::Held(said), code));
            }
            if let Some((said, line)) = supply.warned.take() {
                self.show.say("shift", now, None, format!("{said} at line {line} of the source (--warn-shift)"));
            }
            if self.show.is_due(now) {
                let status = self.status(supply, thermal, None);
                self.show.status(&status, now);
            }
            if !has_worked {
                self.port.wait(if self.sender.wants_to_write() || self.sender.is_hungry() { BUSY } else { IDLE });
            }
        }
    }

    /// What ended it, with its status.
    fn code(&self, ended: Ended) -> (Ended, ExitCode) {
        let code = match &ended {
            Ended::Done => ExitCode::Done,
            Ended::Stopped => self.halted.as_ref().map_or(ExitCode::Interrupted, |(_, code, ..)| *code),
            Ended::Refused(..) => ExitCode::Control,
            Ended::Lost(why) if why.starts_with(ncfix_dnc::feed::GONE) => ExitCode::Link,
            Ended::Lost(_) | Ended::Held(_) => ExitCode::Control,
            Ended::Fault(_) => ExitCode::Refused,
        };
        (ended, code)
    }

    /// The keyboard and the sensors.
    fn watch(&mut self, thermal: &Thermal, keys: &Keys, now: Duration) {
        if keys.pressed() {
            let halt = if self.halted.is_some() { Halt::Hold } else { Halt::Stop };
            self.halt(halt, ExitCode::Interrupted, "stopped by a person", now);
        }
        match thermal.standing().0 {
            Standing::Stop(why) if self.halted.is_none() => self.halt(Halt::Stop, ExitCode::Sensor, &why, now),
            Standing::Hold(why) if self.halted.is_none() => self.halt(Halt::Hold, ExitCode::Sensor, &why, now),
            Standing::Frozen(why) => self.show.frozen(&why, now),
            Standing::Good => self.show.thawed(now),
            _ => {}
        }
    }

    fn halt(&mut self, halt: Halt, code: ExitCode, why: &str, now: Duration) {
        let said = self.sender.halt(halt, now);
        let halt = match (&said, halt) {
            // It has no word for a hold: what it has runs out.
            (None, Halt::Hold) if self.halted.is_none() => {
                self.halt(Halt::Stop, code, why, now);
                return;
            }
            _ => halt,
        };
        let (open, held) = (self.sender.progress().in_flight.0, self.held());
        let what = said.unwrap_or_else(|| {
            format!(
                "this link has no word to hold the axes: use the control's own; ncfix leaves, and the {open} lines under way may still \
                 be carried out, and {held}"
            )
        });
        let message = format!("{why}: {what}");
        self.show.say("halt", now, None, message.clone());
        self.halted = Some((halt, code, why.to_owned(), message));
    }

    /// Lets what was said last go out.
    fn flush(&mut self, supply: &mut Source) -> io::Result<()> {
        let from = Instant::now();
        while self.sender.wants_to_write() && from.elapsed() < LAST {
            let now = self.started.elapsed();
            self.sender.step(now, self.port.as_mut(), supply, &mut |_| ())?;
            self.port.wait(BUSY);
        }
        Ok(())
    }

    /// What a job leaves that is lost.
    fn lost(&self, why: &str, progress: &Progress) -> String {
        let taken = progress.acknowledged.max(progress.left);
        if progress.sent == 0 {
            return format!("{why}; no line was sent");
        }
        let open = progress.sent.saturating_sub(taken);
        let held = taken.saturating_sub(progress.executed.unwrap_or(0));
        let mut what = format!("the job is lost: {why}; {open} lines were sent and not acknowledged");
        if held > 0 {
            what += &format!(", and of the {held} before them {} may still have waited", self.held());
        }
        what + ": each of these may have been carried out or not"
    }

    /// What the control has taken and may not have carried out.
    fn held(&self) -> String {
        match self.sender.progress().holds.max(self.bound) {
            Some(most) => format!("up to {most} blocks that the control holds"),
            None => "those that the control holds, which it does not tell,".to_owned(),
        }
    }

    fn status(&self, supply: &Source, thermal: &Thermal, ended: Option<&Ended>) -> Status {
        let progress: &Progress = self.sender.progress();
        let elapsed_s = self.started.elapsed().as_secs_f64();
        let (standing, age) = thermal.standing();
        let left_s = (self.before.motion_s - supply.busy_s).max(0.0);
        // What is sent is nearly what is done; it is as slow as it has been.
        let pace = if supply.busy_s > 0.0 { (elapsed_s / supply.busy_s).max(1.0) } else { 1.0 };
        let (word, message) = match ended {
            None => (None, None),
            Some(Ended::Done) => (Some("done"), None),
            Some(Ended::Stopped) => {
                let why = self.halted.as_ref().map_or("stopped", |(_, _, why, _)| why.as_str());
                let what = if progress.left > 0 { "has left" } else { "was answered" };
                (Some("stopped"), Some(format!("{why}; all that was sent {what}, and nothing else was sent")))
            }
            Some(Ended::Held(why)) => (Some("held"), Some(why.clone())),
            Some(Ended::Lost(why)) => (Some("lost"), Some(self.lost(why, progress))),
            Some(Ended::Refused(number, said)) => {
                (Some("refused"), Some(format!("the control has refused line {number}: {said}")))
            }
            Some(Ended::Fault(why)) => {
                (Some("fault"), Some(format!("no further line was sent: {why}; what was sent before has run out")))
            }
        };
        Status {
            schema: 1,
            event: if ended.is_some() { "end" } else { "status" },
            time_s: elapsed_s,
            lines: self.before.lines,
            sent: progress.sent,
            acknowledged: progress.acknowledged,
            left: (progress.left > 0).then_some(progress.left),
            executed: progress.executed,
            window: progress.in_flight.0,
            window_bytes: progress.in_flight.1,
            lowest: progress.lowest,
            link_percent: self
                .speed
                .is_finite()
                .then(|| 100.0 * progress.bytes as f64 / (self.speed * elapsed_s.max(1e-3))),
            repeats: progress.repeats,
            stalls: progress.stalls,
            applied: axes(&progress.last.offset, &progress.last.target),
            target: axes(&progress.last.target, &progress.last.offset),
            sensor_age_s: age.map(|age| age.as_secs_f64()),
            sensors: match standing {
                Standing::Good => None,
                Standing::Waiting(why) | Standing::Frozen(why) | Standing::Stop(why) | Standing::Hold(why) => Some(why),
            },
            eta_s: ended.is_none().then_some(left_s * pace),
            delay_us: self.meter.microseconds(),
            ended: word,
            message,
            source_line: progress.last.source_line,
        }
    }
}
