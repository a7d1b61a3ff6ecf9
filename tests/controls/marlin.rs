//! Marlin as its sources describe it: the number and the checksum of each line are checked, what does not fit is asked for again, every line ends with
//! one `ok`, which is said when it has entered the planner, not when it was carried out. With `ADVANCED_OK` it has its number and the free places.

use std::collections::VecDeque;

use super::{Control, Faults, Place};

/// Blocks of the planner, one of which stays free, and lines of the queue before it.
const BUFFER: usize = 15;
const QUEUE: u64 = 3;

pub(crate) struct Marlin {
    faults: Faults,
    line: Vec<u8>,
    /// Lines that were taken and not carried out; their `ok` is said when they enter.
    buffer: VecDeque<(u64, Vec<u8>)>,
    waiting: VecDeque<(u64, Vec<u8>)>,
    last: u64,
    done_s: f64,
    busy_s: f64,
    lines: u64,
    answers: u64,
    demands: u64,
    was_reset: bool,
    /// Whether an `ok` follows a demand.
    pub(crate) says_ok: bool,
    /// Whether an `ok` has the number of its line and the free places (`ADVANCED_OK`).
    pub(crate) numbers_ok: bool,
    /// Where it stands as far as it tells, and whether it answers `M114` with that.
    place: Place,
    pub(crate) tells_place: bool,
    /// Offset in force, mm, if it answers `M114 D` with the position in both coordinates (`M114_DETAIL`).
    pub(crate) offset: Option<[f64; 3]>,
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
            numbers_ok: false,
            place: Place::default(),
            tells_place: false,
            offset: None,
            out: Vec::new(),
            executed: Vec::new(),
        }
    }

    fn ok(&mut self, number: Option<u64>) {
        self.answers += 1;
        if self.faults.lost.contains(&self.answers) {
            return;
        }
        let text = match (self.faults.garbled.contains(&self.answers), number.filter(|_| self.numbers_ok)) {
            (true, _) => "o*\n".to_owned(),
            (_, None) => "ok\n".to_owned(),
            (_, Some(number)) => format!("ok N{number} P{} B{QUEUE}\n", BUFFER - self.buffer.len()),
        };
        self.out.extend(text.bytes());
        if self.faults.doubled.contains(&self.answers) {
            self.out.extend(text.bytes());
        }
    }

    fn demand(&mut self, why: &str) {
        self.demands += 1;
        let wrong = u64::from(self.faults.wrong_demands.contains(&self.demands));
        let text = format!("Error:{why}, Last Line: {}\nResend: {}\n", self.last, self.last + 1 + wrong);
        self.out.extend(text.bytes());
        if self.says_ok {
            self.ok(None);
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
            return self.ok(Some(number));
        }
        if number != self.last + 1 {
            return self.demand("Line Number is not Last Line Number+1");
        }
        self.last = number;
        self.waiting.push_back((number, rest.as_bytes().to_vec()));
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
            let Some((number, line)) = self.buffer.pop_front() else { break };
            if line == b"M400" {
                self.ok(Some(number));
                continue;
            }
            // `M114_Detail`: logical positions with two digits, then the counts of the steps.
            if line.starts_with(b"M114") {
                let [x, y, z] = self.place.axes;
                if let Some([dx, dy, dz]) = self.offset.filter(|_| line == b"M114 D") {
                    let both = format!(
                        "\nLogical: X:{x:8.3} Y:{y:8.3} Z:{z:8.3}\nRaw:     X:{:8.3} Y:{:8.3} Z:{:8.3}\nStepper: X:0 Y:0 Z:0 E:0\n",
                        x + dx,
                        y + dy,
                        z + dz
                    );
                    self.out.extend(both.bytes());
                } else if self.tells_place {
                    self.out.extend(format!("X:{x:.2} Y:{y:.2} Z:{z:.2} E:0.00 Count X:0 Y:0 Z:0\n").bytes());
                }
                self.ok(Some(number));
                continue;
            }
            if let Some(text) = line.strip_prefix(b"M118 ") {
                self.out.extend(text.iter().chain(b"\n"));
                self.ok(Some(number));
                continue;
            }
            if self.faults.ignored != Some(1 + self.executed.len() as u64) {
                self.place.take(&line);
            }
            self.executed.push(line);
            self.done_s += self.busy_s;
        }
        while self.buffer.len() < BUFFER {
            let Some((number, line)) = self.waiting.pop_front() else { break };
            if self.buffer.is_empty() {
                self.done_s = now_s + self.busy_s;
            }
            let is_move = line != b"M400" && !line.starts_with(b"M114") && !line.starts_with(b"M118");
            self.buffer.push_back((number, line));
            // The other is answered when all before it is done.
            if is_move {
                self.ok(Some(number));
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
