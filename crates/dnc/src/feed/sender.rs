//! Drives a dialogue: lines from a supply, bytes to and from a port, a record of both. It never waits and has no clock.

use std::fmt::Write as _;
use std::io;
use std::time::Duration;

use super::dialogue::{Dialogue, Event, Halt, LossKind};
use super::watch::{Patience, TransferWatch};
use super::{Line, Wire};

/// Number of bytes per read.
const CHUNK: usize = 4096;
/// Maximum number of reads per step, so that a control that never stops sending does not block the lines.
const MOST_READS: usize = 16;

/// Two-way byte link. Only [`Port::wait`] waits.
pub trait Port {
    /// Reads received bytes; returns 0 if there are none now.
    ///
    /// # Errors
    /// The other end has closed, or the port has failed.
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize>;

    /// Writes as many bytes as fit now and returns their number.
    ///
    /// # Errors
    /// The other end has closed, or the port has failed.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize>;

    /// Returns the bytes that the operating system has accepted and not sent, if it reports them.
    fn queued(&mut self) -> Option<usize> {
        None
    }

    /// Waits until bytes have come, at most for the given time.
    fn wait(&mut self, most: Duration) {
        std::thread::sleep(most);
    }
}

/// Next item of a supply.
#[derive(Clone, Debug, PartialEq)]
pub enum Supplied {
    /// A line, frozen now.
    Line(Line),
    /// The next line is not ready yet.
    NotYet,
    /// There is no further line.
    End,
    /// No line may follow, for this reason.
    Fault(String),
}

/// Source of lines. Each is made on request, with the current temperatures.
pub trait Supply {
    /// Returns the next line; never waits.
    fn next(&mut self) -> Supplied;

    /// Uses idle time to prepare the next line.
    fn look_ahead(&mut self) {}
}

/// Record of a transfer.
pub trait Record {
    /// Records a frozen line; no byte of it has been sent.
    ///
    /// # Errors
    /// The record cannot be written. The line is not sent then.
    fn frozen(&mut self, line: &Line, now: Duration) -> io::Result<()>;

    /// Records an event.
    ///
    /// # Errors
    /// The record cannot be written.
    fn event(&mut self, event: &Event, now: Duration) -> io::Result<()>;

    /// Writes everything noted so far, before any byte that it concerns is sent.
    ///
    /// # Errors
    /// The record cannot be written. Nothing is sent then.
    fn settle(&mut self) -> io::Result<()> {
        Ok(())
    }

    /// Handles the passing of time.
    ///
    /// # Errors
    /// Earlier records could not be made permanent.
    fn tick(&mut self, _now: Duration) -> io::Result<()> {
        Ok(())
    }
}

/// End of a transfer.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    /// All lines are acknowledged; on a link without answers: have left.
    Done,
    /// A person stopped it; everything sent is acknowledged, or has left.
    Stopped,
    /// It was aborted, with the kind of loss and the reason. Lines that were sent and not acknowledged may have been executed, or may still be.
    Lost(LossKind, String),
    /// A person or a sensor caused the axes to be held, or the lines to be discarded, for this reason. Sent lines may remain in the control.
    Held(String),
    /// The control has refused a line: its number and the answer of the control.
    Refused(u64, String),
    /// The next line may not be sent, for this reason. Everything sent before is acknowledged, or has left.
    Fault(String),
}

/// Progress of a transfer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferProgress {
    /// Lines that were frozen and passed to the link.
    pub sent: u64,
    /// Lines that the control has taken.
    pub acknowledged: u64,
    /// Lines that went out over a link without answers. The number of them that wait in the control is not known.
    pub left: u64,
    /// Lines that the control has executed, if it reports them.
    pub executed: Option<u64>,
    /// Axes whose reported position is that of the last line sent, if the control stands still there.
    pub in_position: Option<String>,
    /// Maximum number of blocks that the control may have taken and not executed, if it states it.
    pub holds: Option<u64>,
    /// Lines and bytes currently under way.
    pub in_flight: (usize, usize),
    /// Minimum number of lines under way since the window was first full; `None` before that.
    pub lowest: Option<usize>,
    /// Bytes that the port has taken.
    pub bytes: u64,
    /// Lines that were sent again.
    pub repeats: u64,
    /// Number of times that the control did not answer in time.
    pub stalls: u64,
    /// Last report of the control about its state and position.
    pub control: Option<String>,
    /// Last line that was sent.
    pub last: Line,
}

/// A transfer.
pub struct Sender<'a> {
    dialogue: Box<dyn Dialogue>,
    record: &'a mut dyn Record,
    wire: Wire,
    watch: TransferWatch,
    /// Frozen line for which the window had no room.
    pending: Option<Line>,
    /// Maximum number of bytes in the queue of the operating system.
    system_bytes: usize,
    is_opened: bool,
    is_supplied: bool,
    is_stopped: bool,
    is_closed: bool,
    /// Reason why no further line may be sent.
    fault: Option<String>,
    ended: Option<Ended>,
    progress: TransferProgress,
    events: Vec<Event>,
}

impl<'a> Sender<'a> {
    /// Prepares a transfer; nothing is sent before the first step.
    #[must_use]
    pub fn new(dialogue: Box<dyn Dialogue>, system_bytes: usize, record: &'a mut dyn Record) -> Sender<'a> {
        Sender {
            dialogue,
            record,
            wire: Wire::default(),
            watch: TransferWatch::new(Patience::default()),
            pending: None,
            system_bytes: system_bytes.max(1),
            is_opened: false,
            is_supplied: false,
            is_stopped: false,
            is_closed: false,
            fault: None,
            ended: None,
            progress: TransferProgress::default(),
            events: Vec::new(),
        }
    }

    /// Sets the maximum times without progress.
    #[must_use]
    pub fn patient(mut self, patience: Patience) -> Sender<'a> {
        self.watch = TransferWatch::new(patience);
        self
    }

    /// Returns the progress.
    #[must_use]
    pub fn progress(&self) -> &TransferProgress {
        &self.progress
    }

    /// False if the control cannot have executed any line.
    #[must_use]
    pub fn may_have_run(&self) -> bool {
        self.dialogue.may_have_run()
    }

    /// Describes what the control has of a file, for a link that sends one.
    #[must_use]
    pub fn remains(&self) -> Option<String> {
        self.dialogue.remains()
    }

    /// True if the control has received no byte and is not ready for lines: a transfer that ends now has changed nothing.
    #[must_use]
    pub fn is_untouched(&self) -> bool {
        !self.dialogue.is_open() && self.progress.sent == 0 && self.wire.sent() == 0 && self.wire.is_empty()
    }

    /// Describes what a person must start at the control before the first line; `None` if nothing or no longer.
    #[must_use]
    pub fn waits_for(&self) -> Option<&'static str> {
        self.dialogue.waits_for()
    }

    /// True if bytes wait for the port.
    #[must_use]
    pub fn wants_to_write(&self) -> bool {
        !self.wire.next(1).is_empty()
    }

    /// True if the window has room for lines that are not ready yet.
    #[must_use]
    pub fn is_hungry(&self) -> bool {
        !self.is_closed && !self.is_supplied && self.dialogue.is_open() && self.dialogue.has_room(1)
    }

    /// Does what is possible now. Returns the end of the transfer; `None` while it continues. `note` receives the events.
    ///
    /// # Errors
    /// The record cannot be written. Nothing more may be sent then.
    pub fn step(
        &mut self,
        now: Duration,
        port: &mut dyn Port,
        supply: &mut dyn Supply,
        note: &mut dyn FnMut(&Event),
    ) -> io::Result<Option<Ended>> {
        if self.ended.is_some() {
            // Bytes that stop the motion are still sent.
            let _ = self.write(port);
            return Ok(self.ended.clone());
        }
        if !std::mem::replace(&mut self.is_opened, true) {
            self.dialogue.open(now, &mut self.wire);
        }
        // Before anything is heard: an answer to bytes that have not left is not valid. Asking the system costs as much as writing.
        if self.wire.queued() > 0 {
            self.wire.queue(port.queued().unwrap_or(0));
        }
        if let Err(error) = self.hear(now, port) {
            self.events.push(Event::Lost(LossKind::LinkGone, self.gone(&error)));
        }
        self.dialogue.tick(now, &mut self.wire, &mut self.events);
        self.take_events(now, note)?;
        self.look(now, note)?;
        if self.ended.is_none() {
            self.fill(now, supply)?;
            self.record.settle()?;
        }
        if matches!(self.ended, Some(Ended::Lost(..) | Ended::Refused(..))) {
            self.wire.withdraw();
        }
        if let Some(Ended::Lost(kind, why)) = &mut self.ended
            && self.progress.sent > 0
            && *kind != LossKind::LinkGone
            && let Some(held) = self.dialogue.leave(&mut self.wire)
        {
            let _ = write!(why, "; {held}");
        }
        if let Err(error) = self.write(port)
            && self.ended.is_none()
        {
            self.events.push(Event::Lost(LossKind::LinkGone, self.gone(&error)));
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

    /// Carries out a stop command. Returns its effect on the control as a sentence; `None` if the dialogue has no such command.
    pub fn halt(&mut self, halt: Halt, now: Duration) -> Option<String> {
        self.is_stopped = true;
        // A line of which no byte was sent is not sent.
        self.pending = None;
        if self.is_untouched() {
            self.ended = Some(Ended::Stopped);
            return Some("nothing was sent".to_owned());
        }
        self.dialogue.halt(halt, now, &mut self.wire)
    }

    /// Ends the transfer if it makes no progress for too long.
    fn look(&mut self, now: Duration, note: &mut dyn FnMut(&Event)) -> io::Result<()> {
        let (is_open, is_waiting) = (self.dialogue.is_open(), self.dialogue.in_flight().0 > 0);
        if self.ended.is_none()
            && (is_waiting || !is_open || self.watch.is_held())
            && let Some(why) = self.watch.look(now, is_open, self.is_closed)
        {
            self.events.push(Event::Lost(LossKind::Other, why));
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
                Event::InPosition(axes) => self.progress.in_position = Some(axes),
                Event::Holds(most, _) => self.progress.holds = Some(most),
                Event::Repeated(_) => self.progress.repeats += 1,
                Event::Stalled => self.progress.stalls += 1,
                Event::Refused(number, said) => _ = self.ended.get_or_insert(Ended::Refused(number, said)),
                Event::Lost(kind, why) => _ = self.ended.get_or_insert(Ended::Lost(kind, why)),
                Event::Reported(text) => self.progress.control = Some(text),
                Event::Checked(_) | Event::Paused(_) | Event::Said(_) | Event::ZeroOffsets(_) => {}
            }
        }
        Ok(())
    }

    /// Returns the reason of a link that has failed, with what the control has of a file.
    fn gone(&self, error: &io::Error) -> String {
        let remains = self.dialogue.remains().map_or(String::new(), |remains| format!("; {remains}"));
        format!("the link is gone: {error}; check the cable, the adapter and interference from drives{remains}")
    }

    /// Prevents further lines. Earlier ones run out: a line that has begun to leave is not cut in two.
    fn stop_for(&mut self, why: String) {
        self.fault.get_or_insert(why);
        self.is_stopped = true;
        self.dialogue.cut();
    }

    /// Freezes lines while the window has room.
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
            self.progress.in_position = None;
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
