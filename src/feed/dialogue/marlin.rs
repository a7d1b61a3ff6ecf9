//! Marlin: lines with a number and a checksum; the control asks again for what it did not get.
//!
//! One line is under way. `N12 G1 X3*45` is answered by `ok`, or by `Resend: 12` and then `ok`, which closes that exchange and takes no line. A line
//! that comes twice is refused by its number (`Resend: 13`), so that the same bytes may always be sent again: what was lost, and which way, does not
//! matter. Before a line is sent again on demand there is a short silence: the demand may have been the answer to a copy, and the `ok` for the line
//! itself on its way; else every further line would go out twice.

use std::collections::VecDeque;
use std::time::Duration;

use super::{Answers, Dialogue, Event, Halt, Line, Profile, Protocol, Wire, check_text};

/// What profiles call it.
pub(super) const PROTOCOL: Protocol = Protocol {
    name: "marlin",
    title: "numbered lines with a checksum, sent again on demand",
    asks_idle: true,
    has_planner: true,
    check: |profile, text| check_text(text, profile.longest_line, &profile.refused),
    create: |profile| Ok(Box::new(Marlin::new(profile))),
};

/// Lines that can be asked for again.
const RING: usize = 64;
/// Silence before a line is sent again on demand.
const QUIET: Duration = Duration::from_millis(60);
/// The largest number of a line: that of a signed word of 32 bits.
const LAST_NUMBER: u64 = i32::MAX as u64;
/// Answered when all moves are done: only then the job is.
const WAIT: &[u8] = b"M400";
/// Emergency stop; it is read at once where the firmware has its emergency parser.
const EMERGENCY_STOP: &[u8] = b"M112\n";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// The count of lines is being set.
    Opening,
    Open,
    /// The last line was sent; whether the control has been asked to say when all is done.
    Closed(bool),
    Over,
}

#[derive(Clone, Debug)]
struct Sent {
    number: u64,
    bytes: Vec<u8>,
    busy: Duration,
}

struct Marlin {
    state: State,
    refused: Vec<u8>,
    longest_line: usize,
    patience: Duration,
    most_repeats: u32,
    /// The last lines, in order.
    ring: VecDeque<Sent>,
    /// The line that is under way; the next to come where none is.
    current: u64,
    is_under_way: bool,
    /// The last line that was reported as taken.
    taken: u64,
    /// The last line of the program, once it is known.
    last_line: Option<u64>,
    /// What the control asks for; its `ok` has not come.
    demanded: Option<u64>,
    /// What is sent again when nothing more comes until then.
    again: Option<(u64, Duration)>,
    repeats: u32,
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
            ring: VecDeque::new(),
            current: 0,
            is_under_way: false,
            taken: 0,
            last_line: None,
            demanded: None,
            again: None,
            repeats: 0,
            heard: Answers::default(),
            last_heard: Duration::ZERO,
        }
    }

    fn sent(&self, number: u64) -> Option<&Sent> {
        self.ring.iter().find(|sent| sent.number == number)
    }

    fn keep(&mut self, sent: Sent) {
        if self.ring.len() >= RING {
            self.ring.pop_front();
        }
        self.ring.push_back(sent);
    }

    /// Sends the line that is under way, for the first time or again.
    fn push(&mut self, now: Duration, wire: &mut Wire) {
        if let Some(sent) = self.ring.iter().find(|sent| sent.number == self.current) {
            wire.push(&sent.bytes);
            self.is_under_way = true;
            self.last_heard = now;
        }
    }

    fn lost(&mut self, why: &str, events: &mut Vec<Event>) {
        self.state = State::Over;
        events.push(Event::Lost(why.to_owned()));
    }

    /// The line under way was taken; what was sent before and is asked for again follows.
    fn take(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if !self.is_under_way {
            return;
        }
        (self.is_under_way, self.again, self.repeats) = (false, None, 0);
        if self.state == State::Opening {
            self.state = State::Open;
        } else if self.current > self.taken && self.last_line.is_none_or(|last| self.current <= last) {
            self.taken = self.current;
            events.push(Event::Acknowledged(self.current));
        } else if self.last_line.is_some_and(|last| self.current > last) && self.taken > 0 {
            // The answer to the wait for all moves.
            events.push(Event::Executed(self.taken));
        }
        self.current += 1;
        self.push(now, wire);
    }

    /// Sends again from a line on.
    fn repeat(&mut self, number: u64, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.is_under_way && number == self.current + 1 {
            // It asks for the next: this one came, and its answer did not.
            self.take(now, wire, events);
        } else if number <= self.current && self.sent(number).is_some() {
            self.repeats += 1;
            if self.repeats > self.most_repeats {
                let why = format!(
                    "line {number} was sent {} times and not taken: the control asks for it again, or does not answer",
                    self.repeats
                );
                self.lost(&why, events);
                return;
            }
            self.current = number;
            events.push(Event::Repeated(number));
            self.push(now, wire);
        } else {
            self.lost(&format!("the control asks for line {number}; line {} is under way", self.current), events);
        }
    }

    fn answer(&mut self, text: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let number = |text: &str| text.trim_start_matches([':', ' ', 'N']).trim().parse::<u64>().ok();
        if text == "ok" || text.starts_with("ok ") {
            match self.demanded.take() {
                Some(demanded) => self.again = Some((demanded, now + QUIET)),
                None => self.take(now, wire, events),
            }
        } else if let Some(rest) = text.strip_prefix("Resend").or_else(|| text.strip_prefix("rs ")) {
            // What cannot be read is asked for again by silence.
            self.demanded = number(rest).or(self.demanded);
        } else if text == "start" && self.state != State::Opening {
            self.lost("the control was reset", events);
        } else if text.contains("kill() called") || text.contains("Printer halted") || text == "!!" {
            self.lost(&format!("the control has stopped itself: {text}"), events);
        } else if text.starts_with("echo:Unknown command") && self.is_under_way && self.state != State::Opening {
            // It would pass over a zero offset or a tool length and go on.
            self.state = State::Over;
            events.push(Event::Refused(self.current, text.to_owned()));
        } else if !text.is_empty() && !text.contains("busy:") {
            events.push(Event::Said(text.to_owned()));
        }
    }
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
        self.ring.push_back(Sent { number: 0, bytes: frame(0, b"M110 N0"), busy: Duration::ZERO });
        self.push(now, wire);
    }

    fn is_open(&self) -> bool {
        self.state == State::Open
    }

    fn has_room(&self, _length: usize) -> bool {
        self.state == State::Open && !self.is_under_way
    }

    fn send(&mut self, line: &Line, now: Duration, wire: &mut Wire) -> Result<(), String> {
        check_text(&line.text, self.longest_line, &self.refused)?;
        if line.number != self.current || line.number > LAST_NUMBER {
            return Err(format!("it is not the next one, which is {}", self.current));
        }
        let busy = line.busy();
        self.keep(Sent { number: line.number, bytes: frame(line.number, &line.text), busy });
        self.push(now, wire);
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.last_heard = now;
        let mut rest = bytes;
        while let Some(answer) = self.heard.next(&mut rest) {
            if self.state != State::Over {
                self.answer(&answer, now, wire, events);
            }
        }
    }

    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.state == State::Over {
            return;
        }
        if let Some((number, at)) = self.again
            && now >= at
        {
            self.again = None;
            self.repeat(number, now, wire, events);
            return;
        }
        if self.state == State::Closed(false) && !self.is_under_way {
            self.state = State::Closed(true);
            self.last_line = Some(self.current.saturating_sub(1));
            // It ends when all that it has moves.
            let busy = self.ring.iter().map(|sent| sent.busy).sum();
            self.keep(Sent { number: self.current, bytes: frame(self.current, WAIT), busy });
            self.push(now, wire);
            return;
        }
        let busy = self.sent(self.current).map_or(Duration::ZERO, |sent| sent.busy);
        if self.is_under_way && wire.is_empty() && now.saturating_sub(self.last_heard) > self.patience + busy {
            self.demanded = None;
            events.push(Event::Stalled);
            self.repeat(self.current, now, wire, events);
        }
    }

    fn close(&mut self, _now: Duration, _wire: &mut Wire) {
        self.state = State::Closed(false);
    }

    fn is_done(&self, _wire: &Wire) -> bool {
        self.state == State::Closed(true) && !self.is_under_way
    }

    fn in_flight(&self) -> (usize, usize) {
        let bytes = self.sent(self.current).filter(|_| self.is_under_way).map(|sent| sent.bytes.len());
        (usize::from(bytes.is_some()), bytes.unwrap_or(0))
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
