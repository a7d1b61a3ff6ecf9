//! Drives a dialogue: lines from a supply, bytes to and from a port, a record of both. Never waits, knows no clock.

use std::io;
use std::time::Duration;

use super::dialogue::{Dialogue, Event, Halt};
use super::watch::{Patience, Watch};
use super::{Line, Wire};

/// Bytes that are read at a time.
const CHUNK: usize = 4096;
/// Reads of one step: a control that talks without end does not keep lines from being sent.
const MOST_READS: usize = 16;

/// Where bytes go and come from. Nothing here waits but [`Port::wait`].
pub trait Port {
    /// Reads what has come; 0 where there is nothing now.
    ///
    /// # Errors
    /// The other end is gone, or the port has failed.
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize>;

    /// Writes what fits now; returns how many bytes that were.
    ///
    /// # Errors
    /// The other end is gone, or the port has failed.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize>;

    /// Bytes that the system has taken and not sent, where it says so.
    fn queued(&mut self) -> Option<usize> {
        None
    }

    /// Waits until something has come, or for so long.
    fn wait(&mut self, most: Duration) {
        std::thread::sleep(most);
    }
}

/// What comes next.
#[derive(Clone, Debug, PartialEq)]
pub enum Supplied {
    /// A line, frozen now.
    Line(Line),
    /// It is not ready yet.
    NotYet,
    /// There is no further line.
    End,
    /// Nothing may follow: why.
    Fault(String),
}

/// Where lines come from. Each is made when it is asked for, with the temperatures of that moment.
pub trait Supply {
    /// The next line; never waits.
    fn next(&mut self) -> Supplied;

    /// Nothing waits now: time for what takes time before the next line.
    fn look_ahead(&mut self) {}
}

/// Where it is written down what happens.
pub trait Record {
    /// A line is frozen; no byte of it has been sent.
    ///
    /// # Errors
    /// It cannot be written down: then the line is not sent.
    fn frozen(&mut self, line: &Line, now: Duration) -> io::Result<()>;

    /// Something has been heard or has happened.
    ///
    /// # Errors
    /// It cannot be written down.
    fn event(&mut self, event: &Event, now: Duration) -> io::Result<()>;

    /// What was noted is written down, before any byte goes out that it is about.
    ///
    /// # Errors
    /// It cannot be written down: then nothing is sent.
    fn settle(&mut self) -> io::Result<()> {
        Ok(())
    }

    /// Time has passed.
    ///
    /// # Errors
    /// What was written down before did not last.
    fn tick(&mut self, _now: Duration) -> io::Result<()> {
        Ok(())
    }
}

/// How a transfer ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    /// All lines are acknowledged; on a link without answers: have left.
    Done,
    /// A person stopped it; all that was sent is acknowledged, or has left.
    Stopped,
    /// It was broken off: why. What was sent and not acknowledged may have been carried out or not.
    Lost(String),
    /// A person or a sensor had the axes held, or the lines thrown away: why. What was sent may stay in the control.
    Held(String),
    /// The control has refused a line: its number and what the control said.
    Refused(u64, String),
    /// The next line may not be sent: why. What was sent before is acknowledged, or has left.
    Fault(String),
}

/// What a reason begins with where the link is gone.
pub const GONE: &str = "the link is gone";

/// Where a transfer stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// Lines that were frozen and given to the link.
    pub sent: u64,
    /// Lines that the control has taken.
    pub acknowledged: u64,
    /// Lines that have left over a link without answers; how many of them wait in the control nobody knows.
    pub left: u64,
    /// Lines that it has carried out, where it says so.
    pub executed: Option<u64>,
    /// Blocks that it may have taken and not carried out, at most, where it says so.
    pub holds: Option<u64>,
    /// Lines and bytes under way now.
    pub in_flight: (usize, usize),
    /// The fewest lines that were under way since the window was full for the first time; `None` before.
    pub lowest: Option<usize>,
    /// Bytes that the port has taken.
    pub bytes: u64,
    /// Lines that were sent again.
    pub repeats: u64,
    /// Times that the control did not answer in time.
    pub stalls: u64,
    /// The last of the lines that were sent.
    pub last: Line,
}

/// One transfer.
pub struct Sender<'a> {
    dialogue: Box<dyn Dialogue>,
    record: &'a mut dyn Record,
    wire: Wire,
    watch: Watch,
    /// Frozen, but the window had no room for it.
    pending: Option<Line>,
    /// Bytes in the queue of the system, at most.
    system_bytes: usize,
    is_opened: bool,
    is_supplied: bool,
    is_stopped: bool,
    is_closed: bool,
    /// Why no further line may be sent.
    fault: Option<String>,
    ended: Option<Ended>,
    progress: Progress,
    events: Vec<Event>,
}

impl<'a> Sender<'a> {
    /// Begins one; nothing is sent before the first step.
    #[must_use]
    pub fn new(dialogue: Box<dyn Dialogue>, system_bytes: usize, record: &'a mut dyn Record) -> Sender<'a> {
        Sender {
            dialogue,
            record,
            wire: Wire::default(),
            watch: Watch::new(Patience::default()),
            pending: None,
            system_bytes: system_bytes.max(1),
            is_opened: false,
            is_supplied: false,
            is_stopped: false,
            is_closed: false,
            fault: None,
            ended: None,
            progress: Progress::default(),
            events: Vec::new(),
        }
    }

    /// How long it may stand still.
    #[must_use]
    pub fn patient(mut self, patience: Patience) -> Sender<'a> {
        self.watch = Watch::new(patience);
        self
    }

    /// Where it stands.
    #[must_use]
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Whether bytes wait for the port.
    #[must_use]
    pub fn wants_to_write(&self) -> bool {
        !self.wire.next(1).is_empty()
    }

    /// Whether the window has room for lines that are not ready yet.
    #[must_use]
    pub fn is_hungry(&self) -> bool {
        !self.is_closed && !self.is_supplied && self.dialogue.is_open() && self.dialogue.has_room(1)
    }

    /// Does what can be done now. Returns how it ended; `None` while it goes on. `note` gets what happens.
    ///
    /// # Errors
    /// The record cannot be written: nothing more may be sent.
    pub fn step(
        &mut self,
        now: Duration,
        port: &mut dyn Port,
        supply: &mut dyn Supply,
        note: &mut dyn FnMut(&Event),
    ) -> io::Result<Option<Ended>> {
        if self.ended.is_some() {
            // What stops motion still goes out.
            let _ = self.write(port);
            return Ok(self.ended.clone());
        }
        if !std::mem::replace(&mut self.is_opened, true) {
            self.dialogue.open(now, &mut self.wire);
        }
        // Before anything is heard: an answer to what has not left is none. To ask the system costs as much as to write.
        if self.wire.queued() > 0 {
            self.wire.queue(port.queued().unwrap_or(0));
        }
        if let Err(error) = self.hear(now, port) {
            self.events.push(Event::Lost(gone(&error)));
        }
        self.dialogue.tick(now, &mut self.wire, &mut self.events);
        self.take_events(now, note)?;
        self.look(now, note)?;
        if self.ended.is_none() {
            self.fill(now, supply)?;
            self.record.settle()?;
        }
        if matches!(self.ended, Some(Ended::Lost(_) | Ended::Refused(..))) {
            self.wire.withdraw();
        }
        if let Err(error) = self.write(port)
            && self.ended.is_none()
        {
            self.events.push(Event::Lost(gone(&error)));
            self.take_events(now, note)?;
        }
        self.record.settle()?;
        supply.look_ahead();
        self.record.tick(now)?;
        self.progress.in_flight = self.dialogue.in_flight();
        self.progress.bytes = self.wire.sent();
        if self.ended.is_none() && self.is_closed && self.wire.is_empty() && self.dialogue.is_done(&self.wire) {
            let by_person = if self.is_stopped { Ended::Stopped } else { Ended::Done };
            self.ended = Some(self.fault.take().map_or(by_person, Ended::Fault));
        }
        Ok(self.ended.clone())
    }

    /// What a person asked for. Returns what this leaves in the control; `None` where the dialogue has no word for it.
    pub fn halt(&mut self, halt: Halt, now: Duration) -> Option<String> {
        self.is_stopped = true;
        // A line that no byte was sent of is not sent.
        self.pending = None;
        self.dialogue.halt(halt, now, &mut self.wire)
    }

    /// Ends it where it stands still for too long.
    fn look(&mut self, now: Duration, note: &mut dyn FnMut(&Event)) -> io::Result<()> {
        let (is_open, is_waiting) = (self.dialogue.is_open(), self.dialogue.in_flight().0 > 0);
        if self.ended.is_none()
            && (is_waiting || !is_open || self.watch.is_held())
            && let Some(why) = self.watch.look(now, is_open, self.is_closed)
        {
            self.events.push(Event::Lost(why));
            self.take_events(now, note)?;
        }
        Ok(())
    }

    fn hear(&mut self, now: Duration, port: &mut dyn Port) -> io::Result<()> {
        let mut chunk = [0; CHUNK];
        for _ in 0..MOST_READS {
            let count = port.read(&mut chunk)?;
            let heard = chunk.get(..count).unwrap_or_default();
            if heard.is_empty() {
                break;
            }
            self.dialogue.hear(heard, now, &mut self.wire, &mut self.events);
            if count < CHUNK {
                break;
            }
        }
        Ok(())
    }

    fn take_events(&mut self, now: Duration, note: &mut dyn FnMut(&Event)) -> io::Result<()> {
        for event in std::mem::take(&mut self.events) {
            self.record.event(&event, now)?;
            self.watch.note(&event, now);
            note(&event);
            match event {
                Event::Acknowledged(number) | Event::Left(number) => {
                    let progress = &mut self.progress;
                    let count =
                        if matches!(event, Event::Left(_)) { &mut progress.left } else { &mut progress.acknowledged };
                    *count = (*count).max(number);
                    if let Some(lowest) = &mut self.progress.lowest
                        && !self.is_supplied
                    {
                        *lowest = (*lowest).min(self.dialogue.in_flight().0);
                    }
                }
                Event::Executed(number) => self.progress.executed = Some(number),
                Event::Holds(most, _) => self.progress.holds = Some(most),
                Event::Repeated(_) => self.progress.repeats += 1,
                Event::Stalled => self.progress.stalls += 1,
                Event::Refused(number, said) => _ = self.ended.get_or_insert(Ended::Refused(number, said)),
                Event::Lost(why) => _ = self.ended.get_or_insert(Ended::Lost(why)),
                Event::Checked(_) | Event::Paused(_) | Event::Said(_) => {}
            }
        }
        Ok(())
    }

    /// No further line may be sent. Those before it run out: a line that has begun to leave is not cut in two.
    fn stop_for(&mut self, why: String) {
        self.fault.get_or_insert(why);
        self.is_stopped = true;
    }

    /// Freezes lines as long as the window has room.
    fn fill(&mut self, now: Duration, supply: &mut dyn Supply) -> io::Result<()> {
        while self.dialogue.is_open() && !self.is_closed {
            if self.is_stopped || self.is_supplied && self.pending.is_none() {
                self.is_closed = true;
                self.dialogue.close(now, &mut self.wire);
                break;
            }
            let line = match self.pending.take() {
                Some(line) => line,
                None if !self.dialogue.has_room(1) => break,
                None => match supply.next() {
                    Supplied::Line(line) => line,
                    Supplied::NotYet => break,
                    Supplied::End => {
                        self.is_supplied = true;
                        continue;
                    }
                    Supplied::Fault(why) => {
                        self.stop_for(why);
                        continue;
                    }
                },
            };
            if !self.dialogue.has_room(line.text.len()) {
                self.pending = Some(line);
                break;
            }
            self.record.frozen(&line, now)?;
            if let Err(why) = self.dialogue.send(&line, now, &mut self.wire) {
                self.stop_for(format!("line {} cannot be sent: {why}", line.number));
                continue;
            }
            self.watch.sent(line.busy(), self.dialogue.in_flight().0 <= 1, now);
            self.progress.sent = line.number;
            self.progress.last = line;
        }
        if self.dialogue.is_open() && (self.pending.is_some() || !self.dialogue.has_room(1)) {
            self.progress.lowest.get_or_insert(self.dialogue.in_flight().0);
        }
        Ok(())
    }

    fn write(&mut self, port: &mut dyn Port) -> io::Result<()> {
        loop {
            let room = self.system_bytes.saturating_sub(self.wire.queued());
            let bytes = self.wire.next(room);
            if bytes.is_empty() {
                return Ok(());
            }
            let count = port.write(bytes)?;
            self.wire.took(count);
            if count == 0 || self.wire.next(1).is_empty() {
                return Ok(());
            }
            self.wire.queue(port.queued().unwrap_or(0));
        }
    }
}

fn gone(error: &io::Error) -> String {
    format!("{GONE}: {error}; look at the cable, the adapter and disturbances by drives")
}
