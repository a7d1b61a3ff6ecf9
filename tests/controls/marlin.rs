//! Marlin as its sources describe it: the number and the checksum of each line are checked, what does not fit is asked for again, every line ends with
//! one `ok`.

use std::collections::VecDeque;

use super::{Control, Faults};

/// Lines that wait.
const BUFFER: usize = 4;

pub(crate) struct Marlin {
    faults: Faults,
    line: Vec<u8>,
    /// Lines that were taken and not carried out; their `ok` is said when they enter.
    buffer: VecDeque<Vec<u8>>,
    waiting: VecDeque<Vec<u8>>,
    last: u64,
    done_s: f64,
    busy_s: f64,
    lines: u64,
    answers: u64,
    demands: u64,
    was_reset: bool,
    /// Whether an `ok` follows a demand.
    pub(crate) says_ok: bool,
    out: Vec<u8>,
    executed: Vec<Vec<u8>>,
}

impl Marlin {
    pub(crate) fn new(faults: &Faults, busy_s: f64) -> Marlin {
        Marlin {
            faults: faults.clone(),
            line: Vec::new(),
            buffer: VecDeque::new(),
            waiting: VecDeque::new(),
            last: 0,
            done_s: 0.0,
            busy_s,
            lines: 0,
            answers: 0,
            demands: 0,
            was_reset: false,
            says_ok: true,
            out: Vec::new(),
            executed: Vec::new(),
        }
    }

    fn ok(&mut self) {
        self.answers += 1;
        if self.faults.lost.contains(&self.answers) {
            return;
        }
        let text: &[u8] = if self.faults.garbled.contains(&self.answers) { b"o*\n" } else { b"ok\n" };
        self.out.extend(text);
        if self.faults.doubled.contains(&self.answers) {
            self.out.extend(text);
        }
    }

    fn demand(&mut self, why: &str) {
        self.demands += 1;
        let wrong = u64::from(self.faults.wrong_demands.contains(&self.demands));
        let text = format!("Error:{why}, Last Line: {}\nResend: {}\n", self.last, self.last + 1 + wrong);
        self.out.extend(text.bytes());
        if self.says_ok {
            self.ok();
        }
    }

    fn take(&mut self, line: &[u8]) {
        self.lines += 1;
        let mut line = line.to_vec();
        if self.faults.corrupted.contains(&self.lines) {
            let at = line.len() / 2;
            line[at] ^= 0x04;
        }
        let text = String::from_utf8_lossy(&line).into_owned();
        let Some((body, sum)) = text.rsplit_once('*') else { return self.demand("No Checksum with line number") };
        let own = body.bytes().fold(0_u8, |sum, byte| sum ^ byte);
        if sum.trim().parse::<u8>() != Ok(own) {
            return self.demand("checksum mismatch");
        }
        let (number, rest) = body[1..].split_once(' ').unwrap();
        let number: u64 = number.parse().unwrap();
        if rest.starts_with("M110") {
            self.last = number;
            return self.ok();
        }
        if number != self.last + 1 {
            return self.demand("Line Number is not Last Line Number+1");
        }
        self.last = number;
        self.waiting.push_back(rest.as_bytes().to_vec());
    }
}

impl Control for Marlin {
    fn hear(&mut self, byte: u8, now_s: f64) {
        self.tick(now_s);
        if byte == b'\n' {
            let line = std::mem::take(&mut self.line);
            self.take(&line);
        } else {
            self.line.push(byte);
        }
    }

    fn tick(&mut self, now_s: f64) {
        if self.faults.reset_s.is_some_and(|at| now_s >= at) && !self.was_reset {
            self.was_reset = true;
            (self.last, self.line) = (0, Vec::new());
            (self.buffer, self.waiting) = (VecDeque::new(), VecDeque::new());
            self.out.extend(b"start\n");
        }
        while self.done_s <= now_s {
            let Some(line) = self.buffer.pop_front() else { break };
            if line == b"M400" {
                self.ok();
                continue;
            }
            if let Some(text) = line.strip_prefix(b"M118 ") {
                self.out.extend(text.iter().chain(b"\n"));
                self.ok();
                continue;
            }
            self.executed.push(line);
            self.done_s += self.busy_s;
        }
        while self.buffer.len() < BUFFER {
            let Some(line) = self.waiting.pop_front() else { break };
            if self.buffer.is_empty() {
                self.done_s = now_s + self.busy_s;
            }
            let is_move = line != b"M400" && !line.starts_with(b"M118");
            self.buffer.push_back(line);
            // The other is answered when all before it is done.
            if is_move {
                self.ok();
            }
        }
    }

    fn say(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    fn executed(&self) -> &[Vec<u8>] {
        &self.executed
    }
}
