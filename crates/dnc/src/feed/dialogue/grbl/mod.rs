//! Grbl 1.1 and grblHAL: every line is answered by `ok` or `error:N`. Lines are sent ahead as long as their bytes fit the receive buffer.
//!
//! The control states the size of its buffers in `[OPT:…,blocks,bytes]` and their free space in `<…|Bf:blocks,bytes>` (Grbl 1.1, interface). Surplus answers
//! must not make the buffer overflow, so room for twice the longest line under way is kept free. A dwell follows the last line; it is answered when the
//! planner is empty. The job is done only then, and when the control reports idle. A dwell is also sent now and then ([`super::barrier`]): a later line can hide
//! that an earlier one was not executed, and without the buffer state in reports only the count of answers says what was taken.
//!
//! When the control has come to a stop after such a dwell, its position must be that of the lines sent ([`place`]). Its zero offsets must be those of the
//! correction before the first line, and may change only by a line of the program ([`super::zeros`]).
//!
//! A control waits in silence, and reports idle, while its spindle runs up. As long as its buffer holds unread lines, no answer is missing.

mod counts;
mod hear;
mod place;
mod status;

use std::collections::VecDeque;
use std::time::Duration;

use super::answers::{Answers, counted};
use super::barrier::Barrier;
use super::depth::Depth;
use super::zeros::ZeroWatch;
use super::{Dialogue, Event, ExpectedZero, Halt, Line, LossKind, Profile, Protocol, Wire, check_text};
use counts::{Counts, SURPLUS};
use place::ReportedPlace;

/// Entry of this dialogue; profiles select it by its name.
pub(super) const PROTOCOL: Protocol = Protocol {
    name: "grbl",
    title: "ok per line, bytes counted",
    asks_idle: true,
    sends_file: false,
    has_planner: true,
    beyond: STEPPED,
    rewrite: None,
    check: |profile, text| check_text(text, profile.longest_line, &profile.refused),
    create: |profile| Ok(Box::new(Grbl::new(profile))),
};

/// Status, hold, reset: bytes that the control takes out of the stream immediately.
const STATUS: &[u8] = b"?";
const HOLD: &[u8] = b"!";
const RESET: &[u8] = &[0x18];
/// Blocks that have left the planner and are still being stepped: the segment buffer has 6 places in Grbl 1.1, 10 in grblHAL (stepper.h).
const STEPPED: u64 = 16;
/// Interval of status questions while lines are under way.
const ASK_EVERY: Duration = Duration::from_millis(200);
/// Silence after a refusal that means that everything was answered.
const QUIET: Duration = Duration::from_millis(500);
/// Dwell that is answered when all moves are done: planned moves are executed first (Grbl 1.1, "sync and planner buffer"). It has no line number.
const BARRIER: &[u8] = b"G4 P0.01\n";
const NO_LINE: u64 = 0;
/// Interval of status questions while the control comes to a stop after a dwell.
const ASK_SOON: Duration = Duration::from_millis(10);
/// Time that a control without a buffer state may report idle before an answer is missing: its spindle may run up meanwhile, and nothing shows that.
const RUN_UP: Duration = Duration::from_secs(15);
/// Receive buffer of a control that does not state its size, bytes: that of Grbl (serial.h), the smallest of the family.
const LEAST_BUFFER: usize = 128;
/// Bytes of the buffer that are kept free.
const MARGIN: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Waits for a sign of life.
    Greeting,
    /// Waits for the buffer sizes. Answers to lines of an earlier job, which the control still holds, may come first.
    Asking,
    /// Waits for the zero offsets and the codes in force.
    Zeroing,
    /// Waits for a final report that the control is idle.
    Looking,
    /// Lines are being sent.
    Open,
    /// The last line was sent.
    Closed,
    /// A line was refused and the axes are held; the other lines under way are still answered.
    Refusing,
    /// Nothing more is sent.
    Over,
}

struct Grbl {
    state: State,
    window: (usize, usize),
    /// Statement of the control on the blocks of its planner beyond those.
    depth: Depth,
    counts: Counts,
    /// True if the control has begun to identify itself.
    has_told: bool,
    /// True if an answer came that may belong to that question; older controls do not know the question.
    has_answered: bool,
    refused: Vec<u8>,
    longest_line: usize,
    patience: Duration,
    /// Line number, bytes, duration.
    in_flight: VecDeque<(u64, usize, Duration)>,
    bytes: usize,
    heard: Answers,
    last_heard: Duration,
    last_asked: Duration,
    /// Number of questions without an answer.
    asked: u32,
    /// Number of consecutive reports that nothing remains to be done.
    idle: u32,
    /// Time of the first of the consecutive reports that the axes rest and no line is unread.
    rests_since: Option<Duration>,
    /// Time when a line was last sent or answered, or motion was last resumed.
    moved: Duration,
    /// True if its reports contain the buffer state.
    tells_buffers: bool,
    /// Last line that was acknowledged, last line confirmed by a report, last line certainly taken, and last line executed.
    acknowledged: u64,
    confirmed: u64,
    checked: u64,
    sure: u64,
    barrier: Barrier,
    place: ReportedPlace,
    zero: ZeroWatch,
    /// True if the control is to stop before the next line; true if the dwell for that, or after the last line, was sent; true if it was answered.
    is_due: bool,
    has_barrier: bool,
    is_drained: bool,
    /// True if the transfer was lost before its last line.
    ended_early: bool,
    /// The refused line, and the answer of the control.
    refusal: (u64, String),
    refused_at: Duration,
    /// Answers beyond those to the lines that were sent.
    surplus: u64,
    /// True if a person at the control holds the axes, or its door is open.
    is_held: bool,
    /// Time of the first report before the first line that it is not idle.
    busy_since: Option<Duration>,
}

impl Grbl {
    fn new(profile: &Profile) -> Grbl {
        Grbl {
            state: State::Greeting,
            window: (profile.window.lines, profile.window.bytes),
            depth: Depth::default(),
            counts: Counts::default(),
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
            rests_since: None,
            moved: Duration::ZERO,
            tells_buffers: false,
            acknowledged: 0,
            confirmed: 0,
            checked: 0,
            sure: 0,
            barrier: Barrier::default(),
            place: ReportedPlace::default(),
            zero: ZeroWatch::default(),
            is_due: false,
            has_barrier: false,
            is_drained: false,
            ended_early: false,
            refusal: (0, String::new()),
            refused_at: Duration::ZERO,
            surplus: 0,
            is_held: false,
            busy_since: None,
        }
    }

    fn ask(&mut self, now: Duration, wire: &mut Wire) {
        self.counts.ask(wire.waiting());
        wire.push_urgent(STATUS);
        self.last_asked = now;
        self.asked += 1;
    }

    /// The control is idle: begins to send lines.
    fn begin(&mut self, events: &mut Vec<Event>) {
        if let Some(why) = self.zero.begin() {
            return self.lost(&why, events);
        }
        events.extend(self.zero.stated().map(Event::ZeroOffsets));
        self.state = State::Open;
        if !self.tells_buffers {
            let said = "status reports do not include the buffer fill, so the axes stop now and then to confirm the executed lines; $10=2 ($10=3 with machine positions) adds it";
            events.push(Event::Said(said.to_owned()));
        }
        if !self.counts.is_size_known() {
            self.window.1 = self.window.1.min(LEAST_BUFFER - MARGIN);
        }
        self.depth.tell(events);
    }

    fn longest(&self) -> usize {
        self.in_flight.iter().map(|(_, length, _)| *length).max().unwrap_or(0)
    }

    fn fits(&self, length: usize) -> bool {
        let spare = SURPLUS * self.longest();
        self.in_flight.is_empty()
            || self.in_flight.len() < self.window.0 && self.bytes + length + spare <= self.window.1
    }

    fn push(&mut self, (number, busy): (u64, Duration), bytes: &[u8], now: Duration, wire: &mut Wire) {
        wire.push(bytes);
        self.bytes += bytes.len();
        self.counts.sent(number, bytes.len());
        (self.idle, self.moved) = (0, now);
        self.in_flight.push_back((number, bytes.len(), busy));
    }

    /// True if every line was answered and executed.
    fn is_finished(&self) -> bool {
        self.in_flight.is_empty() && self.sure == self.acknowledged
    }

    fn lost(&mut self, why: &str, events: &mut Vec<Event>) {
        self.lose(LossKind::Other, why, events);
    }

    fn lose(&mut self, kind: LossKind, why: &str, events: &mut Vec<Event>) {
        self.ended_early = self.state == State::Open;
        self.state = State::Over;
        events.push(Event::Lost(kind, why.to_owned()));
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
        self.state == State::Open && !self.is_due && !self.counts.is_in_doubt() && self.fits(length + 1)
    }

    fn send(&mut self, line: &Line, now: Duration, wire: &mut Wire) -> Result<(), String> {
        check_text(&line.text, self.longest_line, &self.refused)?;
        self.zero.sent(&line.text);
        let bytes = [&line.text[..], b"\n"].concat();
        self.push((line.number, line.busy()), &bytes, now, wire);
        let (is_late, stands) = (self.barrier.sent(&line.text), self.place.commanded.sent(&line.text));
        // Where the axes stand still in any case, another stop leaves no mark. After rapid moves it shows that no earlier line was lost.
        self.is_due = is_late || stands;
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let mut rest = bytes;
        while let Some(answer) = self.heard.next(&mut rest) {
            // A text that never ends is not a sign of life.
            self.last_heard = now;
            if self.state != State::Over {
                self.answer(&answer, now, wire, events);
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
        let is_doubted = self.busy_since.is_some_and(|_| now.saturating_sub(self.last_asked) > ASK_EVERY);
        if self.asked == 0 && (self.state == State::Looking || self.state == State::Greeting && is_doubted) {
            self.ask(now, wire);
        }
        let is_resting = self.state == State::Closed || self.state == State::Open && self.is_due;
        if is_resting && !self.has_barrier && self.fits(BARRIER.len()) && !self.counts.is_in_doubt() {
            self.has_barrier = true;
            self.push((NO_LINE, Duration::ZERO), BARRIER, now, wire);
        }
        let is_quiet = now.saturating_sub(self.last_heard.max(self.last_asked)) > QUIET;
        if self.state == State::Asking && self.has_answered && is_quiet && self.asked == 0 {
            self.ask(now, wire);
        }
        if self.state == State::Zeroing && now.saturating_sub(self.moved) > self.patience {
            // It does not know the question. Its reports still have the offset in force.
            (self.state, self.asked) = (State::Looking, 0);
        }
        let every = if self.is_drained { ASK_SOON } else { ASK_EVERY };
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
        } else if !self.is_finished() && now.saturating_sub(self.last_asked) > every && self.asked == 0 {
            self.ask(now, wire);
        }
    }

    fn close(&mut self, _now: Duration, _wire: &mut Wire) {
        if self.state == State::Open {
            self.state = State::Closed;
        }
    }

    fn is_done(&self, _wire: &Wire) -> bool {
        // Blocks in the planner are not done yet.
        self.state == State::Closed && self.is_drained && self.is_finished()
    }

    fn in_flight(&self) -> (usize, usize) {
        (self.in_flight.len(), self.bytes)
    }

    fn expect(&mut self, zero: ExpectedZero) {
        self.zero.expect(zero);
    }

    fn asks_zero(&self) -> bool {
        true
    }

    fn leave(&mut self, wire: &mut Wire) -> Option<String> {
        // After the dwell that follows the last line, nothing waits. At a dwell within the program the control rests, but a person must look at it first.
        if self.in_flight.is_empty() && (self.is_drained && !self.ended_early || self.is_finished()) {
            return None;
        }
        wire.push_urgent(HOLD);
        Some("a feed hold (!) was sent".to_owned())
    }

    fn halt(&mut self, halt: Halt, _now: Duration, wire: &mut Wire) -> Option<String> {
        let lines = counted(self.in_flight.len(), "unanswered line");
        let planned = self.depth.words();
        let all = if self.in_flight.is_empty() { planned } else { format!("{lines} and {planned}") };
        match halt {
            Halt::Stop => Some(format!("no further line is sent; the control executes {all}")),
            Halt::Hold => {
                wire.push_urgent(HOLD);
                Some(format!(
                    "the axes stop, the spindle keeps turning; {all} stay in the control and continue with cycle start (~)"
                ))
            }
            Halt::Abort => {
                wire.clear();
                wire.push_urgent(RESET);
                self.state = State::Over;
                Some(format!("the control is reset; it discards {all}"))
            }
        }
    }
}
