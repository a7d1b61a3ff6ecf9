//! Simulated controls at the end of a simulated cable, with a clock that the test turns: what they carry out is what a machine would have done.
//!
//! Nothing here knows how a dialogue of the program works; the controls are written from what their makers say of them.

mod block;
mod grbl;
pub(crate) mod liar;
mod lsv2;
mod marlin;
pub(crate) mod part;
mod rsh;
mod tape;
mod wired;

pub(crate) use block::Blockwise;
pub(crate) use grbl::Grbl;
pub(crate) use lsv2::{Lsv2, Odd};
pub(crate) use marlin::Marlin;
pub(crate) use rsh::Rsh;
pub(crate) use tape::Reader;
pub(crate) use wired::Wired;

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use ncfix_dnc::feed::{Ended, Event, Halt, Line, Port, Record, Sender, Supplied, Supply};

use super::plant::random::Random;

/// What goes wrong, by script.
#[derive(Clone, Debug, Default)]
pub(crate) struct Faults {
    /// Numbers of the answers, from 1, that get lost, come twice, or come with another character.
    pub(crate) lost: Vec<u64>,
    pub(crate) doubled: Vec<u64>,
    pub(crate) garbled: Vec<u64>,
    /// Numbers of the lines, from 1, that arrive with another character, and of the demands that name a wrong line.
    pub(crate) corrupted: Vec<u64>,
    pub(crate) wrong_demands: Vec<u64>,
    /// Number of the line, from 1, that the control refuses.
    pub(crate) refuses: Option<u64>,
    /// Number of the line, from 1, that the control accepts and does not carry out: its axes stay where they are.
    pub(crate) ignored: Option<u64>,
    /// When the control is reset, s.
    pub(crate) reset_s: Option<f64>,
    /// When the cable is drawn, s.
    pub(crate) unplugged_s: Option<f64>,
    /// Bytes that the port takes at a time, at most.
    pub(crate) most_bytes: usize,
    /// How long a byte is under way, s.
    pub(crate) latency_s: f64,
    /// Characters that the line carries in a second; 0 where it is not the limit.
    pub(crate) characters_per_s: f64,
    /// Whether the port tells how many bytes wait for the line.
    pub(crate) tells_queue: bool,
    /// When somebody breaks off at the control what it does, s.
    pub(crate) broken_off_s: Option<f64>,
}

/// Where a machine stands in the coordinates of the program, mm, after lines with `G90`, `G91`, `G20`, `G21` and words X, Y, Z.
#[derive(Clone, Debug, Default)]
pub(crate) struct Place {
    pub(crate) axes: [f64; 3],
    is_relative: bool,
    is_inch: bool,
}

impl Place {
    /// Carries out a line.
    pub(crate) fn take(&mut self, line: &[u8]) {
        let text = String::from_utf8_lossy(line).to_uppercase();
        let mut at = 0;
        while let Some(letter) = text[at..].chars().next() {
            let rest = &text[at + 1..];
            let end = rest.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(rest.len());
            at += 1 + end;
            let Ok(value) = rest[..end].trim().parse::<f64>() else { continue };
            match (letter, value) {
                ('G', 90.0) => self.is_relative = false,
                ('G', 91.0) => self.is_relative = true,
                ('G', 20.0) => self.is_inch = true,
                ('G', 21.0) => self.is_inch = false,
                ('X' | 'Y' | 'Z', _) => {
                    let axis = &mut self.axes[letter as usize - 'X' as usize];
                    let mm = value * if self.is_inch { 25.4 } else { 1.0 };
                    *axis = if self.is_relative { *axis + mm } else { mm };
                }
                _ => {}
            }
        }
    }
}

/// A control as the cable sees it.
pub(crate) trait Control {
    /// A byte has come.
    fn hear(&mut self, byte: u8, now_s: f64);
    /// Time has passed.
    fn tick(&mut self, now_s: f64);
    /// What it says.
    fn say(&mut self) -> Vec<u8>;
    /// Lines that it has carried out.
    fn executed(&self) -> &[Vec<u8>];
}

/// A port with a control behind it.
pub(crate) struct Cable<C> {
    pub(crate) control: C,
    faults: Faults,
    there: VecDeque<(f64, u8)>,
    back: VecDeque<(f64, u8)>,
    /// When the line has carried the last byte that it was given.
    free_s: f64,
    random: Random,
    now_s: f64,
}

impl<C: Control> Cable<C> {
    pub(crate) fn new(control: C, faults: Faults, seed: u64) -> Cable<C> {
        let random = Random::new(seed, "cable");
        Cable { control, faults, there: VecDeque::new(), back: VecDeque::new(), free_s: 0.0, random, now_s: 0.0 }
    }

    pub(crate) fn turn_to(&mut self, now_s: f64) {
        self.now_s = now_s;
        while self.there.front().is_some_and(|(at, _)| *at <= now_s) {
            let (at, byte) = self.there.pop_front().unwrap();
            self.control.hear(byte, at);
        }
        self.control.tick(now_s);
        let said = self.control.say();
        self.back.extend(said.into_iter().map(|byte| (now_s + self.faults.latency_s, byte)));
    }

    fn is_drawn(&self) -> bool {
        self.faults.unplugged_s.is_some_and(|at| self.now_s >= at)
    }
}

impl<C: Control> Port for Cable<C> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.is_drawn() {
            return Err(io::Error::from(io::ErrorKind::UnexpectedEof));
        }
        let mut count = 0;
        while count < into.len() && self.back.front().is_some_and(|(at, _)| *at <= self.now_s) {
            into[count] = self.back.pop_front().unwrap().1;
            count += 1;
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_drawn() {
            return Err(io::Error::from(io::ErrorKind::BrokenPipe));
        }
        let most = self.random.below(self.faults.most_bytes + 1);
        let count = bytes.len().min(most);
        let character_s = if self.faults.characters_per_s > 0.0 { 1.0 / self.faults.characters_per_s } else { 0.0 };
        for &byte in &bytes[..count] {
            self.free_s = self.free_s.max(self.now_s) + character_s;
            self.there.push_back((self.free_s + self.faults.latency_s, byte));
        }
        Ok(count)
    }

    fn queued(&mut self) -> Option<usize> {
        let waits = |at: f64| at - self.faults.latency_s > self.now_s;
        self.faults.tells_queue.then(|| self.there.iter().filter(|(at, _)| waits(*at)).count())
    }
}

/// Lines that are there from the start.
pub(crate) struct Planned {
    pub(crate) lines: Vec<Vec<u8>>,
    pub(crate) busy_s: f64,
    next: usize,
    /// What else is known of them, where they are those of a program.
    about: Vec<Line>,
}

impl Planned {
    pub(crate) fn new(count: usize, busy_s: f64) -> Planned {
        let line = |k: usize| format!("G1X{}.{:03}Y{}", k % 97, k % 1000, k).into_bytes();
        Planned { lines: (0..count).map(line).collect(), busy_s, next: 0, about: Vec::new() }
    }

    /// The lines of a part.
    pub(crate) fn of(part: &part::Part, busy_s: f64) -> Planned {
        let lines = part.lines.iter().map(|line| line.text.clone()).collect();
        Planned { lines, busy_s, next: 0, about: part.lines.clone() }
    }
}

impl Supply for Planned {
    fn next(&mut self) -> Supplied {
        let Some(text) = self.lines.get(self.next) else { return Supplied::End };
        self.next += 1;
        let number = self.next as u64;
        let about = self.about.get(self.next - 1).cloned().unwrap_or_default();
        Supplied::Line(Line { number, text: text.clone(), busy_s: self.busy_s, ..about })
    }
}

/// What was written down.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    pub(crate) frozen: Vec<Vec<u8>>,
    pub(crate) events: Vec<Event>,
}

impl Record for Notes {
    fn frozen(&mut self, line: &Line, _now: Duration) -> io::Result<()> {
        self.frozen.push(line.text.clone());
        Ok(())
    }

    fn event(&mut self, event: &Event, _now: Duration) -> io::Result<()> {
        self.events.push(event.clone());
        Ok(())
    }
}

/// Turns the clock until the transfer has ended, and on until the control has nothing left to do.
pub(crate) fn run<C: Control>(sender: &mut Sender<'_>, cable: &mut Cable<C>, planned: &mut Planned) -> Ended {
    run_with_patience(sender, cable, planned, u64::MAX)
}

/// The same; a person breaks it off when nothing has moved so many times.
pub(crate) fn run_with_patience<C: Control>(
    sender: &mut Sender<'_>,
    cable: &mut Cable<C>,
    planned: &mut Planned,
    most_stalls: u64,
) -> Ended {
    let mut ticks = Random::new(7, "ticks");
    let mut now_s = 0.0;
    let ended = loop {
        now_s += ticks.between(0.0001, 0.01);
        assert!(now_s < 3600.0, "it does not end: {:?}", sender.progress());
        cable.turn_to(now_s);
        let step = sender.step(Duration::from_secs_f64(now_s), cable, planned, &mut |_| ());
        if let Some(ended) = step.unwrap() {
            break ended;
        }
        if sender.progress().stalls >= most_stalls {
            sender.halt(Halt::Abort, Duration::from_secs_f64(now_s));
        }
    };
    for _ in 0..1000 {
        now_s += 0.1;
        cable.turn_to(now_s);
    }
    ended
}
