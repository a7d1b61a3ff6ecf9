//! Grbl 1.1: a ring of bytes, a planner of so many blocks, one answer for each line as it enters the planner.
//!
//! Bytes for which the ring has no room are gone (Grbl 1.1, serial.c: "overflow"). `?`, `!`, `~` and reset never enter it. A line that cannot be
//! carried out is answered by `error:N` and left out; those behind it go on.

use std::collections::VecDeque;

use super::{Control, Faults, Place};

/// Size of the ring, bytes, and of the planner, blocks.
const RING: usize = 128;
const PLANNER: usize = 15;

pub(crate) struct Grbl {
    faults: Faults,
    ring: VecDeque<u8>,
    line: Vec<u8>,
    /// Lines in the planner, and when the first of them is done.
    planner: VecDeque<Vec<u8>>,
    done_s: f64,
    busy_s: f64,
    is_held: bool,
    /// Bytes of the first line of the ring if it waits: a dwell for the planner, the start of the spindle for its speed.
    dwelt: usize,
    /// Run-up of the spindle, s, and the time at which it has its speed.
    pub(crate) runs_up_s: f64,
    runs_until_s: Option<f64>,
    /// Line, from 1, with which somebody moves the zero in X by 5 mm at the control.
    pub(crate) moves_zero_at: Option<u64>,
    /// Zero offset in force.
    pub(crate) active: &'static str,
    is_alarmed: bool,
    /// Whether it does not know `$I`.
    is_old: bool,
    was_reset: bool,
    /// Places of its planner and of its ring, and whether it tells them.
    planner_size: usize,
    ring_size: usize,
    tells_sizes: bool,
    /// What it says it does, whatever it does.
    state: Option<&'static str>,
    answers: u64,
    lines: u64,
    out: Vec<u8>,
    executed: Vec<Vec<u8>>,
    place: Place,
    /// Offset of the program against the machine, mm, and whether it reports it, with positions in inches or of the program.
    offset: Option<[f64; 3]>,
    pub(crate) tells_inches: bool,
    pub(crate) tells_work: bool,
    reports: u64,
    /// Bytes that were lost.
    pub(crate) overflows: usize,
    /// Whether a reset locks it, as it does where homing is on.
    pub(crate) locks: bool,
    /// It is reset when its ring has so many bytes, not before.
    pub(crate) resets_from: usize,
    /// Lines that were carried out before a reset that threw others away.
    pub(crate) before_reset: Option<usize>,
    /// The line that it has refused as it was told to.
    pub(crate) refused: Option<u64>,
}

impl Grbl {
    pub(crate) fn new(faults: &Faults, busy_s: f64) -> Grbl {
        Grbl {
            faults: faults.clone(),
            ring: VecDeque::new(),
            line: Vec::new(),
            planner: VecDeque::new(),
            done_s: 0.0,
            busy_s,
            is_held: false,
            dwelt: 0,
            runs_up_s: 0.0,
            runs_until_s: None,
            moves_zero_at: None,
            active: "G54",
            is_alarmed: false,
            is_old: false,
            was_reset: false,
            planner_size: PLANNER,
            ring_size: RING,
            tells_sizes: true,
            state: None,
            answers: 0,
            lines: 0,
            out: Vec::new(),
            executed: Vec::new(),
            place: Place::default(),
            offset: None,
            tells_inches: false,
            tells_work: false,
            reports: 0,
            overflows: 0,
            locks: true,
            resets_from: 0,
            before_reset: None,
            refused: None,
        }
    }

    pub(crate) fn in_alarm(mut self) -> Grbl {
        self.is_alarmed = true;
        self
    }

    /// grblHAL as it is delivered: a hundred blocks in its planner.
    pub(crate) fn of_a_hundred_blocks(mut self) -> Grbl {
        (self.planner_size, self.ring_size) = (100, 1024);
        self
    }

    pub(crate) fn that_tells_no_sizes(mut self) -> Grbl {
        self.tells_sizes = false;
        self
    }

    /// It reports where its axes are, and the offset of the program against the machine in every tenth report (report.c).
    pub(crate) fn that_tells_its_place(mut self, offset: [f64; 3]) -> Grbl {
        self.offset = Some(offset);
        self
    }

    pub(crate) fn that_says(mut self, state: &'static str) -> Grbl {
        self.state = Some(state);
        self
    }

    /// Somebody holds its axes; lines are still taken.
    pub(crate) fn hold(&mut self) {
        self.is_held = true;
    }

    /// Blocks that were taken and not carried out.
    pub(crate) fn planned(&self) -> usize {
        self.planner.len()
    }

    /// The current is gone: what was not carried out never is.
    pub(crate) fn fail(&mut self) {
        self.planner.clear();
        self.ring.clear();
        self.is_alarmed = true;
    }

    /// Its answers to a job that was killed still wait in the port.
    pub(crate) fn with_answers_that_nobody_read(mut self) -> Grbl {
        self.out = b"ok\r\nok\r\n<Run|MPos:1.000,2.000,3.000|Bf:3,80|FS:500,0>\r\nok\r\n<Run|MPos:4.000,2.000,3.000|Bf:9,99|FS:500,0>\r\n".to_vec();
        self
    }

    pub(crate) fn that_is_old(mut self) -> Grbl {
        self.is_old = true;
        self
    }

    fn answer(&mut self, text: &str) {
        self.answers += 1;
        let mut bytes = format!("{text}\r\n").into_bytes();
        if self.faults.lost.contains(&self.answers) {
            return;
        }
        if self.faults.garbled.contains(&self.answers) {
            bytes[0] = b'*';
        }
        self.out.extend(&bytes);
        if self.faults.doubled.contains(&self.answers) {
            self.out.extend(&bytes);
        }
    }

    fn reset(&mut self) {
        if !(self.ring.is_empty() && self.line.is_empty() && self.planner.is_empty()) {
            self.before_reset.get_or_insert(self.executed.len());
        }
        self.ring.clear();
        self.line.clear();
        self.planner.clear();
        (self.is_held, self.dwelt) = (false, 0);
        // With homing on, a reset locks it until it is homed.
        self.is_alarmed = self.locks;
        self.out.extend(b"\r\nGrbl 1.1h ['$' for help]\r\n");
    }

    /// The fields of a report for positions.
    fn place(&mut self) -> (String, String) {
        let Some(offset) = self.offset else { return ("MPos:0.000,0.000,0.000".to_owned(), String::new()) };
        let (unit, digits) = if self.tells_inches { (25.4, 4) } else { (1.0, 3) };
        let shown = |values: [f64; 3]| values.map(|value| format!("{:.digits$}", value / unit)).join(",");
        let work = self.place.axes;
        let machine = [0, 1, 2].map(|k| work[k] + offset[k]);
        let place = if self.tells_work { format!("WPos:{}", shown(work)) } else { format!("MPos:{}", shown(machine)) };
        self.reports += 1;
        let has_offset = self.reports % 10 == 5;
        (place, if has_offset { format!("|WCO:{}", shown(offset)) } else { String::new() })
    }

    fn status(&mut self) {
        let state = match (self.is_alarmed, self.is_held, self.planner.is_empty()) {
            (true, _, _) => "Alarm",
            (_, true, _) => "Hold:0",
            (_, _, true) => "Idle",
            _ => "Run",
        };
        let state = self.state.unwrap_or(state);
        // The line that is carried out has left the ring.
        let ring = self.ring.len() - self.dwelt;
        let free = [self.planner_size - self.planner.len(), self.ring_size - ring];
        let free = if self.tells_sizes { format!("|Bf:{},{}", free[0], free[1]) } else { String::new() };
        let (place, offset) = self.place();
        let report = format!("<{state}|{place}{free}|FS:0,0{offset}>\r\n");
        self.out.extend(report.bytes());
    }
}

impl Control for Grbl {
    fn hear(&mut self, byte: u8, now_s: f64) {
        self.tick(now_s);
        match byte {
            b'?' => self.status(),
            b'!' => self.is_held = true,
            b'~' => self.is_held = false,
            0x18 => self.reset(),
            _ if self.ring.len() >= self.ring_size => self.overflows += 1,
            _ => self.ring.push_back(byte),
        }
    }

    fn tick(&mut self, now_s: f64) {
        if self.faults.reset_s.is_some_and(|at| now_s >= at) && !self.was_reset && self.ring.len() >= self.resets_from {
            self.was_reset = true;
            self.reset();
        }
        if self.is_held {
            self.done_s = now_s + self.busy_s;
        }
        while self.done_s <= now_s {
            let Some(line) = self.planner.pop_front() else { break };
            if self.faults.ignored != Some(1 + self.executed.len() as u64) {
                self.place.take(&line);
            }
            self.executed.push(line);
            self.done_s += self.busy_s;
        }
        self.dwelt = 0;
        // A line leaves the ring when the planner has room for it.
        while self.planner.len() < self.planner_size {
            let Some(byte) = self.ring.pop_front() else { break };
            if byte != b'\n' {
                self.line.push(byte);
                continue;
            }
            let line = std::mem::take(&mut self.line);
            if line == b"$I" && self.is_old {
                self.out.extend(b"error: Unsupported statement\r\n");
                continue;
            }
            // A dwell is carried out when all before it is (protocol_buffer_synchronize); what comes behind it waits in the ring.
            if line == b"G4 P0.01" && !self.is_alarmed {
                if self.planner.is_empty() && !self.is_held {
                    self.answer("ok");
                    continue;
                }
                self.ring.push_front(b'\n');
                line.iter().rev().for_each(|byte| self.ring.push_front(*byte));
                self.dwelt = b"G4 P0.01\n".len();
                break;
            }
            if line == b"$I" {
                let sizes =
                    if self.tells_sizes { format!(",{},{}", self.planner_size, self.ring_size) } else { String::new() };
                self.out.extend(format!("[VER:1.1h.20190830:]\r\n[OPT:V{sizes}]\r\nok\r\n").bytes());
                continue;
            }
            // report_ngc_parameters and report_gcode_modes of report.c.
            if line == b"$#" || line == b"$G" {
                let modes = format!("[GC:G0 {} G17 G21 G90 G94 M5 M9 T0 F0 S0]\r\n", self.active);
                let said = match self.offset.filter(|_| line == b"$#") {
                    Some([x, y, z]) => format!(
                        "[G54:{x:.3},{y:.3},{z:.3}]\r\n[G55:0.000,0.000,0.000]\r\n[G28:0.000,0.000,0.000]\r\n\
                         [G92:0.000,0.000,0.000]\r\n[TLO:0.000]\r\n[PRB:0.000,0.000,0.000:0]\r\n"
                    ),
                    None => String::new(),
                };
                let said = if line == b"$G" { modes } else { said };
                self.out.extend(format!("{said}ok\r\n").bytes());
                continue;
            }
            // A spindle that runs up: nothing is read meanwhile, and the state stays idle.
            if self.runs_up_s > 0.0 && line.ends_with(b"M3") {
                // It begins when all moves before it are done.
                let until = self.planner.is_empty().then(|| *self.runs_until_s.get_or_insert(now_s + self.runs_up_s));
                if until.is_none_or(|until| now_s < until) {
                    self.ring.push_front(b'\n');
                    line.iter().rev().for_each(|byte| self.ring.push_front(*byte));
                    self.dwelt = line.len() + 1;
                    break;
                }
            }
            self.lines += u64::from(line != b"G4 P0.01");
            if self.moves_zero_at == Some(self.lines)
                && let Some([x, ..]) = &mut self.offset
            {
                *x += 5.0;
                (self.reports, self.moves_zero_at) = (4, None);
            }
            if self.faults.refuses == Some(self.lines) || self.is_alarmed {
                if !self.is_alarmed {
                    self.refused = Some(self.lines);
                }
                self.answer("error:33");
                continue;
            }
            if self.planner.is_empty() {
                self.done_s = now_s + self.busy_s;
            }
            // The dwell that a sender waits for.
            if line != b"G4 P0.01" {
                self.planner.push_back(line);
            }
            self.answer("ok");
        }
    }

    fn say(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    fn executed(&self) -> &[Vec<u8>] {
        &self.executed
    }
}
