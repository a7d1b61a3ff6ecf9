//! Marlin: lines with a number and a checksum; the control demands lines that did not arrive intact.
//!
//! One line is under way. `N1012 G1 X3*45` is answered by `ok` or by `Resend: 1012`. Some versions send `ok` after a demand and others do not; this `ok`
//! takes no line. A line that arrives twice is refused by its number (`Resend: 1013`). So the same bytes may always be sent again, whatever was lost in
//! either direction. A line is sent again on demand only after a short silence. The demand may have answered a copy while the `ok` for the line itself is on
//! its way; without the silence every further line would be sent twice.
//!
//! Numbers begin far above those of a control that was reset, which asks for line 1. So a reset is detected even if its greeting was lost. The control waits
//! for all moves (`M400`) and repeats a text (`M118`) before the first line, after the last line, and now and then
//! ([`super::barrier`]). An `ok` has no number, but after the text no earlier answer is outstanding. Between the two it asks for the position (`M114`), which
//! must be that of the lines sent ([`super::position`]). It also asks for the zero offset in force ([`zero`]), before the first line and after a line that
//! selects another one.
//!
//! The lines of the program come here as commands of one line each ([`commands`]).

mod commands;
mod hear;
mod texts;
mod zero;

use std::collections::VecDeque;
use std::time::Duration;

use super::answers::Answers;
use super::barrier::Barrier;
use super::depth::Depth;
use super::position::{CommandedPosition, PositionComparison, elsewhere};
use super::zeros::{ZeroSource, ZeroWatch};
use super::{Dialogue, Event, ExpectedZero, Halt, Line, LossKind, Profile, Protocol, Wire, check_text};
use commands::MarlinCommands;
use zero::{DETAIL, StatedOffset};

/// Entry of this dialogue; profiles select it by its name.
pub(super) const PROTOCOL: Protocol = Protocol {
    name: "marlin",
    title: "numbered lines with a checksum, sent again on demand",
    asks_idle: true,
    sends_file: false,
    has_planner: true,
    beyond: BEYOND,
    rewrite: Some(|| Box::new(MarlinCommands::default())),
    check: |profile, text| check_text(text, profile.longest_line, &profile.refused),
    create: |profile| Ok(Box::new(Marlin::new(profile))),
};

/// Number to which the line count is set.
const FIRST_NUMBER: u64 = 1000;
/// Largest line number: that of a signed 32-bit integer.
const LAST_NUMBER: u64 = i32::MAX as u64;
/// Silence before a line is sent again on demand.
const QUIET: Duration = Duration::from_millis(60);
/// Silence before a line is sent again if no `ok` follows the demand.
const NO_OK: Duration = Duration::from_millis(250);
/// Silence after a greeting before the count is set.
const START: Duration = Duration::from_millis(500);
/// Blocks beyond the free places of the planner: the moving block, and lines of the queue (`BUFSIZE` is 4 to 8).
const BEYOND: u64 = 9;
/// Maximum number of planner blocks and queued lines (`BLOCK_BUFFER_SIZE` is at most 64 in the shipped configurations).
const MOST_PLANNED: usize = 72;
/// Command that is answered when all moves are done; only then the job is done.
const WAIT: &[u8] = b"M400";
/// Question for the position, in the coordinates of the program (`M114.cpp`), and how often it is asked: another report may have come in between.
const WHERE: &[u8] = b"M114";
const MOST_LOOKS: u32 = 3;
/// Emergency stop; it is read immediately if the firmware has its emergency parser.
const EMERGENCY_STOP: &[u8] = b"M112\n";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// The count is being set; then all moves are awaited, and a text.
    Opening,
    Open,
    /// No further line follows.
    Closing,
    Closed,
    Over,
}

/// Content under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    /// `M110`, which sets the count.
    Count,
    /// `M400`, which waits for all moves.
    Wait,
    /// `M114`, which returns the position.
    Where,
    /// `M114 D`, which returns the position in both coordinates.
    Zero,
    /// `M118`, whose text is returned.
    Mark,
    /// Line of the program with this number.
    Line(u64),
}

#[derive(Clone, Debug)]
struct Sent {
    what: What,
    number: u64,
    bytes: Vec<u8>,
    busy: Duration,
    /// Number of times it was sent.
    copies: u32,
}

struct Marlin {
    state: State,
    refused: Vec<u8>,
    longest_line: usize,
    patience: Duration,
    most_repeats: u32,
    under_way: Option<Sent>,
    /// Number of the next line to be sent, and the number of copies sent of the last one.
    next: u64,
    last_copies: u32,
    /// Last program line that was sent, and last one that was taken.
    last: u64,
    taken: u64,
    /// Durations of the last lines: their moves may not have ended yet.
    recent: VecDeque<Duration>,
    /// Statement of the control on its planner.
    depth: Depth,
    /// True if the text of the mark was returned.
    is_marked: bool,
    /// Last line that the control named in a fault since something was sent.
    named: Option<u64>,
    /// True after a demand whose `ok`, if it comes, takes no line.
    is_closing: bool,
    /// Line to be sent again or counted as taken, and the time when this happens if nothing more comes.
    again: Option<(u64, Duration)>,
    repeats: u32,
    /// True if the control waits for a person; true if it has asked to pause.
    is_waiting: bool,
    is_paused: bool,
    /// True if the hold was reported.
    is_held: bool,
    barrier: Barrier,
    /// True if the control is to stop after the line under way.
    is_due: bool,
    /// True if its axes stand still after the line under way in any case.
    stands: bool,
    commanded: CommandedPosition,
    /// Position in the answer to `M114`, and the number of times that it was different.
    reported: Vec<(u8, f64, usize)>,
    looks: u32,
    /// Axes that agree.
    agreed: Option<String>,
    zero: ZeroWatch,
    offset: StatedOffset,
    /// True if the control is to stop after the question for the offset.
    waits_then: bool,
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
            stands: false,
            commanded: CommandedPosition::default(),
            reported: Vec::new(),
            looks: 0,
            agreed: None,
            zero: ZeroWatch::new(ZeroSource::Marlin),
            offset: StatedOffset::default(),
            waits_then: false,
            heard: Answers::default(),
            last_heard: Duration::ZERO,
        }
    }

    /// Sends a text for the first time.
    fn begin(&mut self, (what, busy): (What, Duration), text: &[u8], now: Duration, wire: &mut Wire) {
        let number = self.next;
        self.next += 1;
        self.is_marked = false;
        self.under_way = Some(Sent { what, number, bytes: frame(number, text), busy, copies: 0 });
        self.push(now, wire);
    }

    /// Prepares the line count, which is not sent yet.
    fn prepare(&mut self) {
        let bytes = frame(FIRST_NUMBER, format!("M110 N{FIRST_NUMBER}").as_bytes());
        (self.next, self.is_marked, self.is_closing) = (FIRST_NUMBER + 1, false, false);
        self.under_way = Some(Sent { what: What::Count, number: FIRST_NUMBER, bytes, busy: Duration::ZERO, copies: 0 });
    }

    fn look(&mut self, now: Duration, wire: &mut Wire) {
        self.looks += 1;
        self.reported.clear();
        self.begin((What::Where, Duration::ZERO), WHERE, now, wire);
    }

    fn mark(&mut self, now: Duration, wire: &mut Wire) {
        let text = format!("M118 {}", mark(self.next));
        self.begin((What::Mark, self.moves()), text.as_bytes(), now, wire);
    }

    /// Returns the total duration of the moves that the control may still have.
    fn moves(&self) -> Duration {
        self.recent.iter().sum()
    }

    /// Sends the text under way, for the first time or again.
    fn push(&mut self, now: Duration, wire: &mut Wire) {
        if let Some(sent) = &mut self.under_way {
            wire.push(&sent.bytes);
            sent.copies += 1;
            (self.last_heard, self.named) = (now, None);
        }
    }

    fn lost(&mut self, why: &str, events: &mut Vec<Event>) {
        self.lose(LossKind::Other, why, events);
    }

    fn lose(&mut self, kind: LossKind, why: &str, events: &mut Vec<Event>) {
        self.state = State::Over;
        events.push(Event::Lost(kind, why.to_owned()));
    }

    /// Notes that the text under way was taken; `is_checked` if its answer contained its number.
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
                }
                let is_due = std::mem::take(&mut self.is_due);
                self.waits_then = std::mem::take(&mut self.stands) || is_due;
                if std::mem::take(&mut self.offset.is_selected) {
                    self.begin((What::Zero, self.moves()), DETAIL, now, wire);
                } else {
                    self.wait_if_due(now, wire);
                }
            }
            What::Zero => {
                let is_opening = self.state == State::Opening;
                match self.compare_zero(is_opening, events) {
                    Some(why) => self.lost(&why, events),
                    None if is_opening => self.mark(now, wire),
                    None => self.wait_if_due(now, wire),
                }
            }
            What::Count => self.begin((What::Wait, Duration::ZERO), WAIT, now, wire),
            What::Wait if self.state == State::Opening && self.zero.is_expected() => {
                self.begin((What::Zero, Duration::ZERO), DETAIL, now, wire);
            }
            What::Wait if self.state == State::Opening || !self.commanded.is_known() => self.mark(now, wire),
            What::Wait => {
                (self.looks, self.agreed) = (0, None);
                self.look(now, wire);
            }
            What::Where => match self.commanded.compare(&self.reported) {
                PositionComparison::Differs(why) if self.looks >= MOST_LOOKS => {
                    self.lose(LossKind::AtAnotherPosition, &elsewhere(&why), events);
                }
                PositionComparison::Differs(_) => self.look(now, wire),
                PositionComparison::Agrees(axes) => {
                    self.agreed = Some(axes);
                    self.mark(now, wire);
                }
                PositionComparison::Nothing => self.mark(now, wire),
            },
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
                    events.extend(self.agreed.take().map(Event::InPosition));
                }
            }
        }
    }

    /// Waits for all moves if that is due after the line that was taken.
    fn wait_if_due(&mut self, now: Duration, wire: &mut Wire) {
        if std::mem::take(&mut self.waits_then) {
            self.begin((What::Wait, self.moves()), WAIT, now, wire);
        }
    }

    /// Sends the text under way again. If the control demands the next line, it was taken.
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
                    "line {line} was sent {repeats} times and not accepted: the control asks for it again, or does not answer"
                ),
                What::Mark if is_taken => {
                    "the control does not repeat the text of M118, so answers cannot be distinguished".to_owned()
                }
                What::Wait => "the control does not become idle, or does not answer".to_owned(),
                What::Count | What::Where | What::Zero | What::Mark => "the control does not answer".to_owned(),
            };
            self.lost(&why, events);
        } else if is_taken {
            // Its text was lost: another mark.
            self.mark(now, wire);
        } else {
            events.push(Event::Repeated(line));
            self.push(now, wire);
        }
    }
}

/// Returns the text of a mark with the number of its line.
fn mark(number: u64) -> String {
    format!("ncfix-{number}")
}

/// Frames a line: `N12 G1 X3*45` and its end. The checksum is the exclusive or of all bytes before the asterisk.
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
        self.stands = self.commanded.sent(&line.text);
        self.offset.is_selected = self.zero.sent(&line.text) && self.offset.is_known;
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
                // It ends when all moves of the control are done.
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

    fn expect(&mut self, zero: ExpectedZero) {
        self.zero.expect(zero);
    }

    fn asks_zero(&self) -> bool {
        true
    }

    fn in_flight(&self) -> (usize, usize) {
        self.under_way.as_ref().map_or((0, 0), |sent| (1, sent.bytes.len()))
    }

    fn halt(&mut self, halt: Halt, _now: Duration, wire: &mut Wire) -> Option<String> {
        match halt {
            Halt::Stop => Some("no further line is sent; the control executes what is in its planner".into()),
            // Marlin has no hold command.
            Halt::Hold => None,
            Halt::Abort => {
                wire.clear();
                wire.push_urgent(EMERGENCY_STOP);
                self.state = State::Over;
                Some("emergency stop (M112): the control must be reset".into())
            }
        }
    }
}
