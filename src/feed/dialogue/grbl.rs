//! Grbl 1.1: every line is answered by `ok` or `error:N`; lines are sent ahead as long as their bytes fit the receive buffer.
//!
//! The control says in `[OPT:…,blocks,bytes]` how large its buffers are and in `<…|Bf:blocks,bytes>` how much of them is free (Grbl 1.1, interface).
//! Answers too many must not make the buffer overflow, so room for the longest line under way is kept free twice; one that got lost shows
//! when the control is idle and has nothing in its buffers: it may have been a refusal, so the job ends there.

use std::collections::VecDeque;
use std::time::Duration;

use super::depth::{Depth, not_idle, read_report};
use super::{Answers, Dialogue, Event, Halt, Line, Profile, Protocol, Wire, check_text};

/// What profiles call it.
pub(super) const PROTOCOL: Protocol = Protocol {
    name: "grbl",
    title: "ok per line, bytes counted",
    asks_idle: true,
    has_planner: true,
    check: |profile, text| check_text(text, profile.longest_line, &profile.refused),
    create: |profile| Ok(Box::new(Grbl::new(profile))),
};

/// Status, hold, reset: bytes that the control takes out of the stream at once.
const STATUS: &[u8] = b"?";
const HOLD: &[u8] = b"!";
const RESET: &[u8] = &[0x18];
/// Blocks that have left the planner and are still stepped: the buffer of segments has 6 places in Grbl 1.1, 10 in grblHAL (stepper.h).
const STEPPED: u64 = 16;
/// While lines are under way the control is asked where it stands this often.
const ASK_EVERY: Duration = Duration::from_millis(250);
/// After a refusal, this long without a word means that everything was answered.
const QUIET: Duration = Duration::from_millis(500);
/// So many answers too many, until the control is asked next, do not make its buffer overflow.
const SURPLUS: usize = 2;
/// What the control leaves of a buffer.
const MARGIN: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Asked for a sign of life.
    Greeting,
    /// Asked for its buffers. Answers to lines of an earlier job, which it still has, may come first.
    Asking,
    /// Asked whether it is idle, last of all.
    Looking,
    /// Lines are sent.
    Open,
    /// The last line was sent.
    Closed,
    /// A line was refused and the axes are held; what else was under way is still answered.
    Refusing,
    /// Nothing more is said.
    Over,
}

struct Grbl {
    state: State,
    window: (usize, usize),
    /// What it says of the blocks that its planner holds beyond those.
    depth: Depth,
    /// Size of the receive buffer, where the control has told it.
    buffer: Option<usize>,
    /// Whether it has begun to say what it is.
    has_told: bool,
    /// Whether there was an answer that may have been to that question: older ones do not know it.
    has_answered: bool,
    refused: Vec<u8>,
    longest_line: usize,
    patience: Duration,
    /// Number, bytes, how long it takes.
    in_flight: VecDeque<(u64, usize, Duration)>,
    bytes: usize,
    heard: Answers,
    last_heard: Duration,
    last_asked: Duration,
    /// How often it was asked without an answer.
    asked: u32,
    /// How often in a row it said that nothing is left to do.
    idle: u32,
    /// The last line that was acknowledged, and the last up to which every line had one answer.
    acknowledged: u64,
    sure: u64,
    /// The line that was refused, and what the control said.
    refusal: (u64, String),
    refused_at: Duration,
    /// Answers beyond those to the lines that were sent.
    surplus: u64,
    /// Whether somebody at the control holds the axes, or its door is open.
    is_held: bool,
}

impl Grbl {
    fn new(profile: &Profile) -> Grbl {
        Grbl {
            state: State::Greeting,
            window: (profile.window.lines, profile.window.bytes),
            depth: Depth::default(),
            buffer: None,
            has_told: false,
            has_answered: false,
            refused: profile.refused.clone(),
            longest_line: profile.longest_line,
            patience: profile.answer_within,
            in_flight: VecDeque::new(),
            bytes: 0,
            heard: Answers::default(),
            last_heard: Duration::ZERO,
            last_asked: Duration::ZERO,
            asked: 0,
            idle: 0,
            acknowledged: 0,
            sure: 0,
            refusal: (0, String::new()),
            refused_at: Duration::ZERO,
            surplus: 0,
            is_held: false,
        }
    }

    fn ask(&mut self, now: Duration, wire: &mut Wire) {
        wire.push_urgent(STATUS);
        self.last_asked = now;
        self.asked += 1;
    }

    fn answer(&mut self, text: &str, wire: &mut Wire, events: &mut Vec<Event>) {
        self.has_told |= self.state == State::Asking && text.starts_with('[');
        if text.starts_with("Grbl ") {
            match self.state {
                State::Greeting => self.ask_for_buffers(wire),
                _ => self.lost("the control was reset", events),
            }
        } else if let Some(report) = text.strip_prefix('<').and_then(|text| text.strip_suffix('>')) {
            self.report(report, wire, events);
        } else if let Some(options) = text.strip_prefix("[OPT:").and_then(|text| text.strip_suffix(']')) {
            self.depth.hear(options.split(',').nth(1), STEPPED, text);
            let numbers: Vec<usize> = options.split(',').skip(1).filter_map(|number| number.parse().ok()).collect();
            if let Some(&bytes) = numbers.get(1) {
                self.buffer = Some(bytes);
                self.window.1 = self.window.1.min(bytes.saturating_sub(MARGIN)).max(1);
            }
        } else if text == "ok" {
            self.acknowledge(events);
        } else if let Some(code) = text.strip_prefix("error:") {
            if self.state == State::Asking {
                self.has_answered = true;
            } else if let Some((number, length, _)) = self.in_flight.pop_front() {
                self.bytes -= length;
                if self.state != State::Refusing {
                    wire.push_urgent(HOLD);
                    self.state = State::Refusing;
                    self.refusal = (number, format!("error:{code}"));
                    self.refused_at = self.last_heard;
                }
            } else if self.state != State::Refusing {
                wire.push_urgent(HOLD);
                let why = "and answered more lines than were sent";
                self.lost(&format!("the control has refused a line with error:{code}, {why}"), events);
            }
        } else if let Some(code) = text.strip_prefix("ALARM:") {
            self.lost(&format!("the control stands in alarm {code}"), events);
        } else if text.starts_with(['[', '$', '>']) {
            events.push(Event::Said(text.to_owned()));
        } else if !text.is_empty() && self.state != State::Greeting {
            // It may have been a refusal.
            let shown: String = text.chars().take(80).collect();
            let why = "the line that it was for may have been refused";
            self.lost(&format!("an answer cannot be read: '{shown}'; {why}"), events);
        }
    }

    fn ask_for_buffers(&mut self, wire: &mut Wire) {
        self.state = State::Asking;
        wire.push(b"$I\n");
    }

    fn acknowledge(&mut self, events: &mut Vec<Event>) {
        if self.state == State::Asking {
            self.has_answered = true;
            if self.has_told {
                (self.state, self.asked) = (State::Looking, 0);
            }
        } else if let Some((number, length, _)) = self.in_flight.pop_front() {
            self.bytes -= length;
            self.acknowledged = number;
            events.push(Event::Acknowledged(number));
        } else if matches!(self.state, State::Open | State::Closed) {
            self.lost("the control has answered more lines than were sent", events);
        } else if self.state == State::Refusing {
            self.surplus += 1;
        }
    }

    /// Which line was refused is sure when all that were sent were taken and have one answer each.
    fn refused(&mut self, is_taken: bool, events: &mut Vec<Event>) {
        let (number, said) = std::mem::take(&mut self.refusal);
        if is_taken && self.surplus == 0 && self.in_flight.is_empty() {
            self.state = State::Over;
            let what = "the axes are held; cycle start (~) would carry out the lines behind it, a reset (Ctrl-X) throws them away";
            events.push(Event::Refused(number, format!("{said}; {what}")));
        } else {
            let first = number.saturating_sub(self.surplus.max(1));
            self.lost(&format!("the control has refused line {number}, or one from {first} on, with {said}; not every line has one answer"), events);
        }
    }

    /// `Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:0,0`.
    fn report(&mut self, report: &str, wire: &mut Wire, events: &mut Vec<Event>) {
        self.asked = 0;
        let (state, [free_blocks, free_bytes]) = read_report(report);
        if state == "Idle" && self.in_flight.is_empty() {
            self.depth.hear(free_blocks, STEPPED, report);
        }
        let free_bytes = free_bytes.and_then(|bytes| bytes.parse::<usize>().ok());
        if matches!(self.state, State::Greeting | State::Asking | State::Looking) {
            match not_idle(state) {
                Some(why) => return self.lost(&why, events),
                None if self.state == State::Greeting => return self.ask_for_buffers(wire),
                None if self.state == State::Looking => return self.begin(events),
                None => {}
            }
        }
        if state.starts_with("Alarm") {
            self.lost("the control stands in an alarm", events);
            return;
        }
        let is_held = ["Hold", "Door"].iter().any(|held| state.starts_with(held));
        if std::mem::replace(&mut self.is_held, is_held) != is_held && self.state != State::Refusing {
            events.push(Event::Paused(is_held));
        }
        if self.state == State::Refusing {
            // While the axes are held, lines may wait for the planner without an answer.
            let is_taken = self.buffer.zip(free_bytes).is_some_and(|(buffer, free)| free >= buffer);
            if self.in_flight.is_empty() || is_taken {
                self.refused(is_taken, events);
            }
            return;
        }
        if let (Some(buffer), Some(free)) = (self.buffer, free_bytes)
            && buffer.saturating_sub(free) > self.bytes + wire.waiting() + MARGIN
        {
            self.lost("the control has more than was not answered: an answer came twice", events);
            return;
        }
        let is_empty = self.buffer.zip(free_bytes).is_none_or(|(buffer, free)| free >= buffer);
        self.idle = if state == "Idle" && is_empty && wire.waiting() == 0 { self.idle + 1 } else { 0 };
        if self.state == State::Asking {
            // It has nothing left that it could answer: what it said was its answer.
            if self.idle >= 2 && self.has_answered {
                self.begin(events);
            }
            return;
        }
        // Twice: the first report may be older than the last bytes.
        if self.idle >= 2 {
            match self.in_flight.back() {
                None => {
                    if self.sure < self.acknowledged {
                        events.push(Event::Executed(self.acknowledged));
                    }
                    self.sure = self.acknowledged;
                }
                // It may have been a refusal: then a line was left out, and nobody knows which.
                Some((last, _, _)) => {
                    let why = format!(
                        "an answer was lost: the control is idle with nothing in its buffers, but one of the lines {} to {last} may have been refused",
                        self.sure + 1
                    );
                    self.lost(&why, events);
                }
            }
        }
    }

    /// The control is idle: lines may go out.
    fn begin(&mut self, events: &mut Vec<Event>) {
        self.state = State::Open;
        self.depth.tell(events);
    }

    /// Whether every line was answered, and the control has said since that nothing is left to do.
    fn is_finished(&self) -> bool {
        self.in_flight.is_empty() && self.sure == self.acknowledged
    }

    fn lost(&mut self, why: &str, events: &mut Vec<Event>) {
        self.state = State::Over;
        events.push(Event::Lost(why.to_owned()));
    }
}

impl Dialogue for Grbl {
    fn open(&mut self, now: Duration, wire: &mut Wire) {
        self.last_heard = now;
        self.ask(now, wire);
    }

    fn is_open(&self) -> bool {
        self.state == State::Open
    }

    fn has_room(&self, length: usize) -> bool {
        let spare = SURPLUS * self.in_flight.iter().map(|(_, length, _)| *length).max().unwrap_or(0);
        let fits = self.in_flight.is_empty() || self.bytes + length + 1 + spare <= self.window.1;
        self.state == State::Open && self.in_flight.len() < self.window.0 && fits
    }

    fn send(&mut self, line: &Line, _now: Duration, wire: &mut Wire) -> Result<(), String> {
        check_text(&line.text, self.longest_line, &self.refused)?;
        wire.push(&line.text);
        wire.push(b"\n");
        let length = line.text.len() + 1;
        self.bytes += length;
        self.idle = 0;
        self.in_flight.push_back((line.number, length, line.busy()));
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.last_heard = now;
        let mut rest = bytes;
        while let Some(answer) = self.heard.next(&mut rest) {
            if self.state != State::Over {
                self.answer(&answer, wire, events);
            }
        }
    }

    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.state == State::Over {
            return;
        }
        if self.state == State::Refusing {
            if now.saturating_sub(self.refused_at) > self.patience {
                self.refused(false, events);
            } else if now.saturating_sub(self.last_heard) > QUIET && now.saturating_sub(self.last_asked) > QUIET {
                self.ask(now, wire);
            }
            return;
        }
        if self.state == State::Looking && self.asked == 0 {
            self.ask(now, wire);
        }
        let is_quiet = now.saturating_sub(self.last_heard.max(self.last_asked)) > QUIET;
        if self.state == State::Asking && self.has_answered && is_quiet && self.asked == 0 {
            self.ask(now, wire);
        }
        let busy = self.in_flight.front().map_or(Duration::ZERO, |(_, _, busy)| *busy);
        let is_silent = now.saturating_sub(self.last_heard) > self.patience + busy;
        let is_waiting = !matches!(self.state, State::Open | State::Closed) || !self.is_finished();
        if is_silent && is_waiting && now.saturating_sub(self.last_asked) > self.patience {
            if self.asked >= 3 {
                self.lost("the control does not answer", events);
                return;
            }
            events.push(Event::Stalled);
            self.ask(now, wire);
        } else if !self.is_finished() && now.saturating_sub(self.last_asked) > ASK_EVERY && self.asked == 0 {
            self.ask(now, wire);
        }
    }

    fn close(&mut self, _now: Duration, _wire: &mut Wire) {
        if self.state == State::Open {
            self.state = State::Closed;
        }
    }

    fn is_done(&self, _wire: &Wire) -> bool {
        // What is in the planner is not done yet.
        self.state == State::Closed && self.is_finished()
    }

    fn in_flight(&self) -> (usize, usize) {
        (self.in_flight.len(), self.bytes)
    }

    fn halt(&mut self, halt: Halt, _now: Duration, wire: &mut Wire) -> Option<String> {
        let lines = self.in_flight.len();
        match halt {
            Halt::Stop => Some(format!(
                "no further line is sent; the control carries out the {lines} that it has not answered and {}",
                self.depth.words()
            )),
            Halt::Hold => {
                wire.push_urgent(HOLD);
                Some(format!(
                    "the axes stop, the spindle turns; {lines} lines that were not answered and {} stay in the control and go on with cycle start (~)",
                    self.depth.words()
                ))
            }
            Halt::Abort => {
                wire.clear();
                wire.push_urgent(RESET);
                self.state = State::Over;
                Some(format!("the control is reset; the {lines} lines that it had are thrown away"))
            }
        }
    }
}
