//! Marlin: lines with a number and a checksum; the control asks again for what it did not get.
//!
//! One line is under way. `N1012 G1 X3*45` is answered by `ok`, or by `Resend: 1012`, behind which some versions say `ok` and others do not: that one takes
//! no line. A line that comes twice is refused by its number (`Resend: 1013`), so that the same bytes may always be sent again: what was lost, and which way,
//! does not matter. Before a line is sent again on demand there is a short silence: the demand may have been the answer to a copy, and the `ok` for the
//! line itself on its way; else every further line would go out twice.
//!
//! Numbers begin far above those of a control that was reset, which asks for line 1: so a reset shows even where its greeting got lost. Before the first
//! line, behind the last, and now and then where answers have no number ([`super::barrier`]), the control waits for all moves (`M400`) and repeats a text (`M118`): an `ok` has no number, but behind the text none is left
//! of what went before.

mod hear;
mod texts;

use std::collections::VecDeque;
use std::time::Duration;

use super::answers::Answers;
use super::barrier::Barrier;
use super::depth::Depth;
use super::{Dialogue, Event, Halt, Line, Profile, Protocol, Wire, check_text};

/// What profiles call it.
pub(super) const PROTOCOL: Protocol = Protocol {
    name: "marlin",
    title: "numbered lines with a checksum, sent again on demand",
    asks_idle: true,
    has_planner: true,
    beyond: BEYOND,
    check: |profile, text| check_text(text, profile.longest_line, &profile.refused),
    create: |profile| Ok(Box::new(Marlin::new(profile))),
};

/// The number to which the count is set.
const FIRST_NUMBER: u64 = 1000;
/// The largest number of a line: that of a signed word of 32 bits.
const LAST_NUMBER: u64 = i32::MAX as u64;
/// Silence before a line is sent again on demand.
const QUIET: Duration = Duration::from_millis(60);
/// The same where no `ok` follows the demand.
const NO_OK: Duration = Duration::from_millis(250);
/// Silence behind a greeting, before the count is set.
const START: Duration = Duration::from_millis(500);
/// Beyond the free places of its planner: the block that moves, and lines of its queue (`BUFSIZE` is 4 to 8).
const BEYOND: u64 = 9;
/// Blocks of its planner and lines of its queue, at most (`BLOCK_BUFFER_SIZE` is 64 at most in the configurations that come with it).
const MOST_PLANNED: usize = 72;
/// Answered when all moves are done: only then the job is.
const WAIT: &[u8] = b"M400";
/// Emergency stop; it is read at once where the firmware has its emergency parser.
const EMERGENCY_STOP: &[u8] = b"M112\n";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// The count is being set; then all moves are awaited, and a text.
    Opening,
    Open,
    /// No further line comes.
    Closing,
    Closed,
    Over,
}

/// What is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    /// `M110`, which sets the count.
    Count,
    /// `M400`, which waits for all moves.
    Wait,
    /// `M118`, whose text comes back.
    Mark,
    /// This line of the program.
    Line(u64),
}

#[derive(Clone, Debug)]
struct Sent {
    what: What,
    number: u64,
    bytes: Vec<u8>,
    busy: Duration,
    /// How often it went out.
    copies: u32,
}

struct Marlin {
    state: State,
    refused: Vec<u8>,
    longest_line: usize,
    patience: Duration,
    most_repeats: u32,
    under_way: Option<Sent>,
    /// The number of the next line that goes out, and how often the last one did.
    next: u64,
    last_copies: u32,
    /// The last line of the program that was sent, and that was taken.
    last: u64,
    taken: u64,
    /// How long the last lines take: their moves may still be waited for.
    recent: VecDeque<Duration>,
    /// What it says of its planner.
    depth: Depth,
    /// Whether the text of the mark came back.
    is_marked: bool,
    /// The last line that the control named in a fault, since something was sent.
    named: Option<u64>,
    /// Whether a demand came whose `ok`, if there is one, takes no line.
    is_closing: bool,
    /// What is sent again, or was taken, when nothing more comes until then.
    again: Option<(u64, Duration)>,
    repeats: u32,
    /// Whether the control waits for a person, and whether it has asked to pause.
    is_waiting: bool,
    is_paused: bool,
    /// Whether it was said that it is held.
    is_held: bool,
    barrier: Barrier,
    /// Whether the control is to come to rest behind the line under way, unless its answer has a number.
    is_due: bool,
    heard: Answers,
    last_heard: Duration,
}

impl Marlin {
    fn new(profile: &Profile) -> Marlin {
        Marlin {
            state: State::Opening,
            refused: profile.refused.clone(),
            longest_line: profile.longest_line,
            patience: profile.answer_within,
            most_repeats: profile.most_repeats,
            under_way: None,
            next: FIRST_NUMBER,
            last_copies: 0,
            last: 0,
            taken: 0,
            recent: VecDeque::new(),
            depth: Depth::default(),
            is_marked: false,
            named: None,
            is_closing: false,
            again: None,
            repeats: 0,
            is_waiting: false,
            is_paused: false,
            is_held: false,
            barrier: Barrier::default(),
            is_due: false,
            heard: Answers::default(),
            last_heard: Duration::ZERO,
        }
    }

    /// Sends something for the first time.
    fn begin(&mut self, (what, busy): (What, Duration), text: &[u8], now: Duration, wire: &mut Wire) {
        let number = self.next;
        self.next += 1;
        self.is_marked = false;
        self.under_way = Some(Sent { what, number, bytes: frame(number, text), busy, copies: 0 });
        self.push(now, wire);
    }

    /// Begins with the count, which is not sent yet.
    fn prepare(&mut self) {
        let bytes = frame(FIRST_NUMBER, format!("M110 N{FIRST_NUMBER}").as_bytes());
        (self.next, self.is_marked, self.is_closing) = (FIRST_NUMBER + 1, false, false);
        self.under_way = Some(Sent { what: What::Count, number: FIRST_NUMBER, bytes, busy: Duration::ZERO, copies: 0 });
    }

    fn mark(&mut self, now: Duration, wire: &mut Wire) {
        let text = format!("M118 {}", mark(self.next));
        self.begin((What::Mark, self.moves()), text.as_bytes(), now, wire);
    }

    /// How long all that it may still have takes.
    fn moves(&self) -> Duration {
        self.recent.iter().sum()
    }

    /// Sends what is under way, for the first time or again.
    fn push(&mut self, now: Duration, wire: &mut Wire) {
        if let Some(sent) = &mut self.under_way {
            wire.push(&sent.bytes);
            sent.copies += 1;
            (self.last_heard, self.named) = (now, None);
        }
    }

    fn lost(&mut self, why: &str, events: &mut Vec<Event>) {
        self.state = State::Over;
        events.push(Event::Lost(why.to_owned()));
    }

    /// What is under way was taken; `is_checked` where its answer had its number.
    fn take(&mut self, is_checked: bool, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let Some(sent) = self.under_way.take() else { return };
        self.last_copies = sent.copies;
        (self.again, self.repeats) = (None, 0);
        match sent.what {
            What::Line(line) => {
                self.taken = line;
                events.push(Event::Acknowledged(line));
                if is_checked {
                    events.push(Event::Checked(line));
                } else if std::mem::take(&mut self.is_due) {
                    self.begin((What::Wait, self.moves()), WAIT, now, wire);
                }
            }
            What::Count => self.begin((What::Wait, Duration::ZERO), WAIT, now, wire),
            What::Wait => self.mark(now, wire),
            What::Mark if self.state == State::Opening => {
                self.state = State::Open;
                self.depth.tell(events);
            }
            What::Mark => {
                if self.state == State::Closing {
                    self.state = State::Closed;
                }
                self.barrier.is_over();
                if self.taken > 0 {
                    events.push(Event::Executed(self.taken));
                }
            }
        }
    }

    /// Sends again what is under way; where the control asks for the next line it was taken.
    fn repeat(&mut self, number: u64, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let Some(sent) = &self.under_way else { return };
        let (what, is_taken) = (sent.what, number > sent.number);
        if is_taken && what != What::Mark {
            return self.take(false, now, wire, events);
        }
        self.repeats += 1;
        let line = if let What::Line(line) = what { line } else { 0 };
        if self.repeats > self.most_repeats {
            let repeats = self.repeats;
            let why = match what {
                What::Line(line) => format!(
                    "line {line} was sent {repeats} times and not taken: the control asks for it again, or does not answer"
                ),
                What::Mark if is_taken => {
                    "the control does not repeat the text of M118, so that answers cannot be told apart".to_owned()
                }
                What::Wait => "the control does not come to rest, or does not answer".to_owned(),
                What::Count | What::Mark => "the control does not answer".to_owned(),
            };
            self.lost(&why, events);
        } else if is_taken {
            // Its text got lost: another one.
            self.mark(now, wire);
        } else {
            events.push(Event::Repeated(line));
            self.push(now, wire);
        }
    }
}

/// A text that comes back, with the number of its line.
fn mark(number: u64) -> String {
    format!("ncfix-{number}")
}

/// `N12 G1 X3*45` and its end: the checksum is the exclusive or of all bytes before the asterisk.
fn frame(number: u64, text: &[u8]) -> Vec<u8> {
    let mut bytes = format!("N{number} ").into_bytes();
    bytes.extend_from_slice(text);
    let sum = bytes.iter().fold(0_u8, |sum, byte| sum ^ byte);
    bytes.extend_from_slice(format!("*{sum}\n").as_bytes());
    bytes
}

impl Dialogue for Marlin {
    fn open(&mut self, now: Duration, wire: &mut Wire) {
        self.prepare();
        self.push(now, wire);
    }

    fn is_open(&self) -> bool {
        self.state == State::Open
    }

    fn has_room(&self, _length: usize) -> bool {
        self.state == State::Open && self.under_way.is_none() && !self.is_closing && !self.is_paused
    }

    fn send(&mut self, line: &Line, now: Duration, wire: &mut Wire) -> Result<(), String> {
        check_text(&line.text, self.longest_line, &self.refused)?;
        if line.number != self.last + 1 || self.next > LAST_NUMBER {
            return Err(format!("it is not the next one, which is {}", self.last + 1));
        }
        self.last = line.number;
        self.recent.push_back(line.busy());
        if self.recent.len() > MOST_PLANNED {
            self.recent.pop_front();
        }
        self.is_due = self.barrier.sent(&line.text);
        self.begin((What::Line(line.number), line.busy()), &line.text, now, wire);
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let mut rest = bytes;
        while let Some(answer) = self.heard.next(&mut rest) {
            if !matches!(self.state, State::Over | State::Closed) {
                self.answer(&answer, now, wire, events);
            }
        }
    }

    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if matches!(self.state, State::Over | State::Closed) {
            return;
        }
        if let Some((number, at)) = self.again
            && now >= at
        {
            (self.again, self.is_closing) = (None, false);
            self.repeat(number, now, wire, events);
            return;
        }
        let Some(sent) = &self.under_way else {
            if self.state == State::Closing && !self.is_closing {
                // It ends when all that it has moves.
                self.begin((What::Wait, self.moves()), WAIT, now, wire);
            }
            return;
        };
        let number = sent.number;
        if wire.is_empty() && now.saturating_sub(self.last_heard) > self.patience + sent.busy {
            self.is_closing = false;
            events.push(Event::Stalled);
            self.repeat(number, now, wire, events);
        }
    }

    fn close(&mut self, _now: Duration, _wire: &mut Wire) {
        if self.state == State::Open {
            self.state = State::Closing;
        }
    }

    fn is_done(&self, _wire: &Wire) -> bool {
        self.state == State::Closed
    }

    fn in_flight(&self) -> (usize, usize) {
        self.under_way.as_ref().map_or((0, 0), |sent| (1, sent.bytes.len()))
    }

    fn halt(&mut self, halt: Halt, _now: Duration, wire: &mut Wire) -> Option<String> {
        match halt {
            Halt::Stop => Some("no further line is sent; the control carries out what is in its planner".into()),
            // It knows no hold.
            Halt::Hold => None,
            Halt::Abort => {
                wire.clear();
                wire.push_urgent(EMERGENCY_STOP);
                self.state = State::Over;
                Some("emergency stop (M112): the control has to be reset".into())
            }
        }
    }
}
