//! Links made for tape readers: bytes, one byte that stops them (XOFF), one that resumes them (XON), and no answers.
//!
//! A control that reads sends XON (DC1) when it wants data and XOFF (DC3) when its buffer is nearly full. A remote buffer of Fanuc ends with SYN after a
//! reset and with NAK after an alarm (B-63322EN, protocol B). Nothing confirms a line: it has *left* when its last byte is gone, and its further fate is
//! unknown. Bytes in the queue of the operating system can no longer be held back; with USB adapters not even the driver can. So bytes are passed on no
//! faster than the line carries them, and never more at once than the control accepts after its XOFF.

mod hear;

use std::collections::VecDeque;
use std::time::Duration;

use super::answers::counted;
use super::{Dialogue, Event, Halt, Line, Profile, Protocol, Wire, check_text};
use crate::feed::profile::Flow;

/// Entry of this dialogue; profiles select it by its name.
pub(super) const PROTOCOL: Protocol = Protocol {
    name: "tape",
    title: "flow control with XON and XOFF, no answers (RS-232 reader interface)",
    asks_idle: false,
    sends_file: false,
    has_planner: false,
    beyond: 0,
    rewrite: None,
    check: |profile, text| check_text(text, profile.longest_line, &profile.refused),
    create,
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// The control has not asked for data yet.
    Waiting,
    Open,
    /// The last line was sent.
    Closed,
    /// A person has aborted the job.
    Broken,
    Over,
}

struct Tape {
    state: State,
    flow: Flow,
    leader: Vec<u8>,
    start: Vec<u8>,
    end_of_block: Vec<u8>,
    trailer: Vec<u8>,
    is_upper_case: bool,
    longest_line: usize,
    refused: Vec<u8>,
    window: (usize, usize),
    /// Maximum number of bytes that are passed on and have not left.
    ahead: usize,
    characters_per_s: f64,
    /// Mask of the significant bits of a character.
    mask: u8,
    patience: Duration,
    /// Bytes that were not passed on yet.
    out: VecDeque<u8>,
    /// Bytes that have left, by the line speed and by the queue length that the system reports.
    gone: f64,
    /// Bytes that were queued for the wire, or will be.
    total: u64,
    /// Lines that have not left: number, position of the last byte, duration.
    lines: VecDeque<(u64, u64, Duration)>,
    is_held: bool,
    /// Time when the control last resumed the flow, and time when bytes last left.
    asked: Duration,
    fed: Duration,
    ticked: Duration,
    /// Time of the last activity.
    moved: Duration,
    /// Time until which the control is busy with everything that has left.
    busy_until: Duration,
}

fn create(profile: &Profile) -> Result<Box<dyn Dialogue>, String> {
    let Flow { xon, xoff, wait_for_xon } = profile.flow;
    if xon.is_some() != xoff.is_some() || xon.is_some() && xon == xoff {
        return Err("xon and xoff must be given together: write two different bytes, or neither".into());
    }
    if xon.is_none() && !profile.serial.rts_cts {
        return Err("there is no flow control: write xon and xoff, or rts_cts = true".into());
    }
    if wait_for_xon && xon.is_none() {
        return Err("wait_for_xon needs xon".into());
    }
    if profile.frame.end_of_block.is_empty() {
        return Err("without end_of_block lines cannot be separated".into());
    }
    Ok(Box::new(Tape::new(profile)))
}

impl Tape {
    fn new(profile: &Profile) -> Tape {
        Tape {
            state: State::Waiting,
            flow: profile.flow,
            leader: profile.frame.leader.clone(),
            start: profile.frame.start.clone(),
            end_of_block: profile.frame.end_of_block.clone(),
            trailer: profile.frame.trailer.clone(),
            is_upper_case: profile.is_upper_case,
            longest_line: profile.longest_line,
            refused: profile.refused.clone(),
            window: (profile.window.lines, profile.window.bytes),
            ahead: profile.window.system_bytes,
            characters_per_s: profile.serial.characters_per_s(),
            // With seven data bits the eighth is the parity bit, which some adapters do not remove.
            mask: if profile.serial.data_bits == 7 { 0x7F } else { 0xFF },
            patience: profile.answer_within,
            out: VecDeque::new(),
            gone: 0.0,
            total: 0,
            lines: VecDeque::new(),
            is_held: false,
            asked: Duration::ZERO,
            fed: Duration::ZERO,
            ticked: Duration::ZERO,
            moved: Duration::ZERO,
            busy_until: Duration::ZERO,
        }
    }

    fn push(&mut self, bytes: &[u8]) {
        self.out.extend(bytes);
        self.total += bytes.len() as u64;
    }

    fn begin(&mut self) {
        self.state = State::Open;
        let bytes = [std::mem::take(&mut self.leader), std::mem::take(&mut self.start)].concat();
        self.push(&bytes);
    }

    /// True if bytes wait to leave, or for the control to ask for them.
    fn is_waiting(&self, wire: &Wire) -> bool {
        self.state == State::Waiting || !self.out.is_empty() || !wire.is_empty() || self.gone < wire.sent() as f64
    }
}

impl Dialogue for Tape {
    fn open(&mut self, now: Duration, _wire: &mut Wire) {
        (self.ticked, self.moved) = (now, now);
        if !self.flow.wait_for_xon {
            self.begin();
        }
    }

    fn is_open(&self) -> bool {
        self.state == State::Open
    }

    fn has_room(&self, length: usize) -> bool {
        let bytes = (self.total as f64 - self.gone).max(0.0) as usize + length + self.end_of_block.len();
        let fits = self.lines.is_empty() || self.lines.len() < self.window.0 && bytes <= self.window.1;
        self.state == State::Open && fits
    }

    fn send(&mut self, line: &Line, now: Duration, wire: &mut Wire) -> Result<(), String> {
        let text = if self.is_upper_case { line.text.to_ascii_uppercase() } else { line.text.clone() };
        if !self.is_waiting(wire) {
            self.moved = now;
        }
        // The `%` of the program is sent with the frame.
        let is_framed = text.trim_ascii() == b"%" && (self.trailer.contains(&b'%') || self.start.contains(&b'%'));
        if !is_framed {
            check_text(&text, self.longest_line, &self.refused)?;
            self.push(&text);
            let end = self.end_of_block.clone();
            self.push(&end);
        }
        self.lines.push_back((line.number, self.total, line.busy()));
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        for &byte in bytes {
            if matches!(self.state, State::Over | State::Broken) {
                return;
            }
            self.hear_byte(byte & self.mask, now, wire, events);
        }
        wire.pause(self.is_held);
    }

    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        match self.state {
            State::Over => return,
            State::Broken => {
                let why = "aborted as requested; it is not known whether the sent lines are executed";
                self.lost(why, wire, events);
                return;
            }
            _ => {}
        }
        let by_clock = self.gone + self.characters_per_s * now.saturating_sub(self.ticked).as_secs_f64();
        self.ticked = now;
        let gone = by_clock.min(wire.left() as f64).max(self.gone);
        if gone > self.gone {
            (self.moved, self.fed) = (now, now);
        }
        self.gone = gone;
        while let Some(&(number, end, busy)) = self.lines.front()
            && end as f64 <= self.gone
        {
            self.lines.pop_front();
            self.busy_until = self.busy_until.max(now) + busy;
            events.push(Event::Left(number));
        }
        if !self.is_held {
            let under_way = wire.waiting() + (wire.sent() as f64 - self.gone).max(0.0).ceil() as usize;
            let count = self.ahead.saturating_sub(under_way).min(self.out.len());
            let bytes: Vec<u8> = self.out.drain(..count).collect();
            wire.push(&bytes);
        }
        // The control may be busy for long with its lines; only a longer silence is a fault. Nothing is sent on suspicion.
        if self.is_waiting(wire) && now.saturating_sub(self.moved.max(self.busy_until)) > self.patience {
            events.push(Event::Stalled);
            self.moved = now;
        }
    }

    fn close(&mut self, _now: Duration, _wire: &mut Wire) {
        if self.state == State::Open {
            self.state = State::Closed;
            let trailer = std::mem::take(&mut self.trailer);
            self.push(&trailer);
        }
    }

    fn is_done(&self, wire: &Wire) -> bool {
        self.state == State::Closed && self.lines.is_empty() && !self.is_waiting(wire)
    }

    fn waits_for(&self) -> Option<&'static str> {
        let waits = self.state == State::Waiting;
        waits.then_some("waiting for XON: start reading at the control")
    }

    fn in_flight(&self) -> (usize, usize) {
        (self.lines.len(), (self.total as f64 - self.gone).max(0.0) as usize)
    }

    fn halt(&mut self, halt: Halt, _now: Duration, wire: &mut Wire) -> Option<String> {
        let keeps = "the control executes what is in its buffer; this link does not report how much that is";
        match halt {
            Halt::Stop if self.lines.is_empty() => Some(format!("no further line is started; {keeps}")),
            Halt::Stop => Some(format!(
                "no further line is started; {} in progress will still be sent, and {keeps}",
                counted(self.lines.len(), "line")
            )),
            // Such a link has no command for it: feed hold is a key at the control.
            Halt::Hold => None,
            Halt::Abort => {
                self.out.clear();
                wire.clear();
                self.state = State::Broken;
                Some(format!(
                    "nothing more is sent, perhaps in the middle of a line; {keeps}: stop it and reset it there"
                ))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::PROFILES;
    use ncfix_base::source::{FileId, Source};

    fn profile(name: &str) -> Profile {
        let (_, text) = PROFILES.iter().find(|(known, _)| *known == name).unwrap();
        Profile::read(&Source::new(FileId(0), "x", text.as_bytes().to_vec()).unwrap()).unwrap()
    }

    fn line(number: u64, text: &str) -> Line {
        Line { number, text: text.into(), ..Line::default() }
    }

    /// Returns a dialogue, its wire, and its events.
    fn opened(name: &str) -> (Tape, Wire, Vec<Event>) {
        let (mut tape, mut wire, mut events) = (Tape::new(&profile(name)), Wire::default(), Vec::new());
        tape.open(Duration::ZERO, &mut wire);
        tape.hear(&[0x11], Duration::ZERO, &mut wire, &mut events);
        (tape, wire, events)
    }

    #[test]
    fn a_line_has_left_when_the_line_has_carried_its_last_byte() {
        let (mut tape, mut wire, mut events) = opened("fanuc-rs232");
        tape.send(&line(1, "g1x1"), Duration::ZERO, &mut wire).unwrap();
        let mut sent = Vec::new();
        let mut left_ms = None;
        for ms in 0..100 {
            tape.tick(Duration::from_millis(ms), &mut wire, &mut events);
            sent.extend_from_slice(wire.next(99));
            wire.took(99);
            wire.queue(0);
            left_ms = left_ms.or(events.contains(&Event::Left(1)).then_some(ms));
        }
        assert_eq!(sent, b"%\nG1X1\n");
        // Seven characters of eleven bits at 4800 Bd: 16.04 ms.
        assert!(left_ms.is_some_and(|ms| (17..=18).contains(&ms)), "{left_ms:?}");
    }

    #[test]
    fn what_the_system_has_not_sent_has_not_left() {
        let (mut tape, mut wire, mut events) = opened("fanuc-rs232");
        tape.send(&line(1, "X1"), Duration::ZERO, &mut wire).unwrap();
        for ms in 0..100 {
            tape.tick(Duration::from_millis(ms), &mut wire, &mut events);
            wire.took(99);
            wire.queue(1);
        }
        assert!(!events.contains(&Event::Left(1)));
        wire.queue(0);
        tape.tick(Duration::from_millis(110), &mut wire, &mut events);
        assert!(events.contains(&Event::Left(1)));
    }

    #[test]
    fn reset_and_alarm_of_a_remote_buffer_end_the_job() {
        // B-63322EN, protocol B: DC3 and then SYN after a reset, NAK after an alarm.
        for (byte, word) in [(0x16, "reset"), (0x15, "alarm")] {
            let (mut tape, mut wire, mut events) = opened("fanuc-rs232");
            tape.hear(&[0x13, byte], Duration::ZERO, &mut wire, &mut events);
            assert!(matches!(events.last(), Some(Event::Lost(_, why)) if why.contains(word)), "{events:?}");
        }
    }

    #[test]
    fn what_means_something_else_on_the_link_is_refused() {
        let (mut tape, mut wire, _) = opened("fanuc-rs232");
        assert!(tape.send(&line(1, "%"), Duration::ZERO, &mut wire).is_ok());
        for text in ["G1X1%", "N1(\u{13})", "N1;"] {
            assert!(tape.send(&line(2, text), Duration::ZERO, &mut wire).is_err(), "{text}");
        }
    }

    #[test]
    fn a_link_that_nothing_holds_is_none() {
        let plain = profile("haas");
        let without = |xon, xoff| Profile { flow: Flow { xon, xoff, wait_for_xon: false }, ..plain.clone() };
        assert!(create(&plain).is_ok());
        for (xon, xoff) in [(None, None), (Some(17), None), (None, Some(19)), (Some(17), Some(17))] {
            assert!(create(&without(xon, xoff)).is_err(), "{xon:?} {xoff:?}");
        }
    }
}
