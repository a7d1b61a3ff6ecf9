//! A control that reads as from a tape: XON when it wants data, XOFF when its buffer is nearly full, never an answer.
//!
//! After the Sinumerik 810 (XON at the start; XOFF when fewer than so many bytes of the ring are free), the Haas VF (XON again while nothing comes
//! for 5 s) and the remote buffer of Fanuc (DC3 and SYN after a reset). What comes when the ring is full is an alarm (Fanuc 087): it stands.

use std::collections::VecDeque;

use super::{Control, Faults};
use crate::plant::random::Random;

const XON: u8 = 0x11;
const XOFF: u8 = 0x13;
const SYN: u8 = 0x16;

pub(crate) struct Reader {
    faults: Faults,
    ring: VecDeque<u8>,
    size: usize,
    /// Free bytes at which it stops the sender.
    reserve: usize,
    /// Bytes in the ring at which it lets it go on.
    low: usize,
    is_stopped: bool,
    was_started: bool,
    /// Whether what comes is read; before the first end of block it is skipped where the tape begins with one.
    pub(crate) is_reading: bool,
    /// Whether it asks again when nothing comes.
    pub(crate) asks_again: bool,
    /// Whether it says that it was reset.
    tells_reset: bool,
    /// Reset, or in an alarm: it carries nothing out.
    pub(crate) stands: bool,
    pub(crate) overflows: usize,
    /// Numbers of the bytes for the flow that were XON.
    pub(crate) asked: Vec<u64>,
    said: u64,
    heard_s: f64,
    line: Vec<u8>,
    under_way: Option<Vec<u8>>,
    done_s: f64,
    busy_s: f64,
    out: Vec<u8>,
    executed: Vec<Vec<u8>>,
}

impl Reader {
    pub(crate) fn new(faults: &Faults, busy_s: f64, reserve: usize, seed: u64) -> Reader {
        let mut random = Random::new(seed, "reader");
        let size = reserve + 40 + random.below(400);
        Reader {
            faults: faults.clone(),
            ring: VecDeque::new(),
            size,
            reserve,
            low: random.below(size - reserve),
            is_stopped: false,
            was_started: false,
            is_reading: false,
            asks_again: random.unit() < 0.5,
            tells_reset: random.unit() < 0.5,
            stands: false,
            overflows: 0,
            asked: Vec::new(),
            said: 0,
            heard_s: 0.0,
            line: Vec::new(),
            under_way: None,
            done_s: 0.0,
            busy_s,
            out: Vec::new(),
            executed: Vec::new(),
        }
    }

    fn flow(&mut self, byte: u8) {
        self.said += 1;
        if byte == XON {
            self.asked.push(self.said);
        }
        if self.faults.lost.contains(&self.said) {
            return;
        }
        let byte = if self.faults.garbled.contains(&self.said) { byte ^ 0x40 } else { byte };
        self.out.push(byte);
        if self.faults.doubled.contains(&self.said) {
            self.out.push(byte);
        }
    }
}

impl Control for Reader {
    fn hear(&mut self, byte: u8, now_s: f64) {
        self.tick(now_s);
        self.heard_s = now_s;
        if self.stands {
            return;
        }
        if self.ring.len() >= self.size {
            self.overflows += 1;
            self.stands = true;
            return;
        }
        self.ring.push_back(byte);
        if !self.is_stopped && self.size - self.ring.len() < self.reserve {
            self.is_stopped = true;
            self.flow(XOFF);
        }
    }

    fn tick(&mut self, now_s: f64) {
        if self.faults.reset_s.is_some_and(|at| now_s >= at) && !self.stands {
            self.stands = true;
            if self.tells_reset {
                self.out.extend([XOFF, SYN]);
            }
        }
        if self.stands {
            return;
        }
        // A person presses start.
        if now_s > 0.2 && !self.was_started {
            self.was_started = true;
            self.heard_s = now_s;
            self.flow(XON);
        }
        loop {
            if let Some(line) = self.under_way.take_if(|_| self.done_s <= now_s) {
                self.executed.push(line);
            }
            if self.under_way.is_some() {
                break;
            }
            let Some(byte) = self.ring.pop_front() else { break };
            match byte {
                b'\n' if !self.is_reading => self.is_reading = true,
                b'\n' if self.line.is_empty() => {}
                b'\n' => {
                    self.under_way = Some(std::mem::take(&mut self.line));
                    self.done_s = self.done_s.max(now_s) + self.busy_s;
                }
                // The end of the tape.
                b'%' if self.is_reading => assert!(self.line.is_empty()),
                0 | b'\r' | b'%' => {}
                _ if self.is_reading => self.line.push(byte),
                _ => {}
            }
        }
        if self.is_stopped && self.ring.len() <= self.low {
            self.is_stopped = false;
            self.heard_s = now_s;
            self.flow(XON);
        }
        if self.asks_again && self.was_started && !self.is_stopped && now_s - self.heard_s > 5.0 {
            self.heard_s = now_s;
            self.flow(XON);
        }
    }

    fn say(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    fn executed(&self) -> &[Vec<u8>] {
        &self.executed
    }
}
