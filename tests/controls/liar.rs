//! A cable over which a control lies: its answers get lost, come twice, late, garbled, with other numbers, between answers that nobody gave; it is reset
//! and does not say so. The control behind it is a faithful one, which knows what it has received and carried out.

use std::collections::VecDeque;
use std::io;

use ncfix_dnc::feed::Port;

use super::Control;
use crate::plant::random::Random;

/// What is done to answers, each with a chance of its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lies {
    pub(crate) lost: f64,
    /// At once, and some time later.
    pub(crate) doubled: f64,
    pub(crate) echoed: f64,
    pub(crate) late: f64,
    pub(crate) garbled: f64,
    /// A number in it is another one.
    pub(crate) miscounted: f64,
    /// Bytes before it that mean nothing.
    pub(crate) noise: f64,
    /// In a second, one of `forgeries` that nobody has said.
    pub(crate) forged: f64,
    pub(crate) forgeries: Vec<Vec<u8>>,
    /// Answers with this in them are never heard: the greeting behind a silent reset.
    pub(crate) swallowed: Option<&'static [u8]>,
    /// So many answers too many, at most.
    pub(crate) most_surplus: usize,
}

pub(crate) struct Liar<C> {
    pub(crate) control: C,
    lies: Lies,
    /// Whether an answer is a line, or a byte.
    is_lines: bool,
    said: Vec<u8>,
    /// What is under way, each with the time at which it is heard.
    there: VecDeque<(f64, u8)>,
    back: VecDeque<(f64, Vec<u8>)>,
    echoes: Vec<(f64, Vec<u8>)>,
    latency_s: f64,
    /// How long the line takes for a byte, s.
    character_s: f64,
    free_s: f64,
    last_s: f64,
    random: Random,
    pub(crate) now_s: f64,
    /// All that the program under test has written.
    pub(crate) wrote: Vec<u8>,
    pub(crate) has_moved: bool,
    surplus: usize,
}

/// ACK, NAK, XON, XOFF, with parity or without.
fn is_answer(byte: u8) -> bool {
    matches!(byte & 0x7f, 0x06 | 0x11 | 0x13 | 0x15)
}

impl<C: Control> Liar<C> {
    pub(crate) fn new(control: C, lies: Lies, is_lines: bool, character_s: f64, seed: u64) -> Liar<C> {
        let mut random = Random::new(seed, "liar");
        let latency_s = random.between(0.0005, 0.01);
        Liar {
            control,
            lies,
            is_lines,
            said: Vec::new(),
            there: VecDeque::new(),
            back: VecDeque::new(),
            echoes: Vec::new(),
            latency_s,
            character_s,
            free_s: 0.0,
            last_s: 0.0,
            random,
            now_s: 0.0,
            wrote: Vec::new(),
            has_moved: false,
            surplus: 0,
        }
    }

    pub(crate) fn turn_to(&mut self, now_s: f64) {
        let dt = now_s - self.now_s;
        self.now_s = now_s;
        while self.there.front().is_some_and(|(at, _)| *at <= now_s) {
            let (at, byte) = self.there.pop_front().unwrap();
            self.control.hear(byte, at);
        }
        self.control.tick(now_s);
        self.said.extend(self.control.say());
        while let Some(end) = if self.is_lines {
            self.said.iter().position(|byte| *byte == b'\n').map(|at| at + 1)
        } else {
            (!self.said.is_empty()).then_some(1)
        } {
            let answer: Vec<u8> = self.said.drain(..end).collect();
            self.bend(answer);
        }
        if self.random.unit() < self.lies.forged * dt && !self.lies.forgeries.is_empty() {
            let at = self.random.below(self.lies.forgeries.len());
            let forged = self.lies.forgeries[at].clone();
            if self.may_add(&forged) {
                self.queue(forged);
            }
        }
        let due: Vec<Vec<u8>> = self.echoes.extract_if(.., |(at, _)| *at <= now_s).map(|(_, answer)| answer).collect();
        due.into_iter().for_each(|answer| self.queue(answer));
    }

    /// Whether one more of these may be made up: so many that take a line for taken a link without numbers stands, and no more.
    fn may_add(&mut self, answer: &[u8]) -> bool {
        if !answer.starts_with(b"ok") {
            return true;
        }
        self.surplus += 1;
        self.surplus <= self.lies.most_surplus
    }

    fn queue(&mut self, answer: Vec<u8>) {
        self.last_s = self.last_s.max(self.now_s + self.latency_s);
        self.back.push_back((self.last_s, answer));
    }

    /// What becomes of an answer.
    fn bend(&mut self, mut answer: Vec<u8>) {
        let lies = self.lies.clone();
        let chance = |random: &mut Random, chance: f64| chance > 0.0 && random.unit() < chance;
        if lies.swallowed.is_some_and(|part| answer.windows(part.len()).any(|window| window == part)) {
            return;
        }
        if chance(&mut self.random, lies.lost) {
            return;
        }
        if chance(&mut self.random, lies.late) {
            self.last_s = self.last_s.max(self.now_s) + self.random.between(0.0, 3.0);
        }
        if chance(&mut self.random, lies.miscounted) {
            let digits: Vec<usize> = (0..answer.len()).filter(|at| answer[*at].is_ascii_digit()).collect();
            if !digits.is_empty() {
                answer[self.random.pick(&digits)] = b'0' + self.random.below(10) as u8;
            }
        }
        if chance(&mut self.random, lies.garbled) {
            let at = self.random.below(answer.len());
            match self.random.below(3) {
                0 if self.is_lines => _ = answer.remove(at),
                1 => answer[at] = self.random.below(256) as u8,
                _ => answer[at] ^= 1 << self.random.below(7),
            }
            // A byte that becomes another answer was forged.
            if !self.is_lines && is_answer(answer[at]) {
                answer[at] = 0x7f;
            }
        }
        if chance(&mut self.random, lies.noise) {
            let count = 1 + self.random.below(6);
            let mut noise: Vec<u8> = (0..count).map(|_| self.random.below(256) as u8).collect();
            if self.is_lines && self.random.unit() < 0.5 {
                noise.push(b'\n');
            }
            if !self.is_lines {
                noise.retain(|byte| !is_answer(*byte));
            }
            self.queue(noise);
        }
        if chance(&mut self.random, lies.doubled) && self.may_add(&answer) {
            self.queue(answer.clone());
        }
        if chance(&mut self.random, lies.echoed) && self.may_add(&answer) {
            let at = self.now_s + self.random.between(0.0, 2.0);
            self.echoes.push((at, answer.clone()));
        }
        self.queue(answer);
    }
}

impl<C: Control> Port for Liar<C> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut count = 0;
        while self.back.front().is_some_and(|(at, answer)| *at <= self.now_s && count + answer.len() <= into.len()) {
            let (_, answer) = self.back.pop_front().unwrap();
            into[count..count + answer.len()].copy_from_slice(&answer);
            count += answer.len();
        }
        self.has_moved |= count > 0;
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = bytes.len().min(1 + self.random.below(64));
        for &byte in &bytes[..count] {
            self.free_s = self.free_s.max(self.now_s) + self.character_s;
            self.there.push_back((self.free_s + self.latency_s, byte));
        }
        self.wrote.extend(&bytes[..count]);
        self.has_moved |= count > 0;
        Ok(count)
    }

    fn queued(&mut self) -> Option<usize> {
        (self.character_s > 0.0).then(|| self.there.iter().filter(|(at, _)| at - self.latency_s > self.now_s).count())
    }
}
