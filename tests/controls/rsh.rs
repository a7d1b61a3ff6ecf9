//! linuxcncrsh of LinuxCNC 2.9 with MDI behind it, after emcrsh.cc, shcom.cc and emctaskmain.cc and what a real one was seen to say.
//!
//! Commands are taken one after the other; one that is sent on to the task takes a tenth of a second. Everything that was heard is echoed until that
//! is switched off. After an error, and where somebody breaks off, all that waits is thrown away, and the next command is taken as if nothing had
//! happened. Breaking off stops the spindle and is no error.

use std::collections::VecDeque;

use super::{Control, Faults, Place};

/// How long a command is on its way to the task, s.
const DELAY_S: f64 = 0.1;

pub(crate) struct Rsh {
    faults: Faults,
    line: Vec<u8>,
    commands: VecDeque<String>,
    /// Answered when the task has received it.
    pending: Option<(f64, String)>,
    waits_until_done: bool,
    echo: bool,
    is_linked: bool,
    is_verbose: bool,
    pub(crate) is_enabled: bool,
    /// When another client takes the control over and breaks off, s.
    pub(crate) taken_over_s: Option<f64>,
    pub(crate) is_on: bool,
    pub(crate) is_homed: bool,
    mode: &'static str,
    turns: bool,
    /// Lines that wait, and the one that runs.
    queue: VecDeque<(u64, String)>,
    under_way: Option<(f64, String)>,
    lines: u64,
    has_failed: bool,
    errors: VecDeque<String>,
    was_broken: bool,
    /// A line was broken off while the spindle stood: nothing that can be asked for shows it.
    pub(crate) unseen: bool,
    was_stopped: bool,
    busy_s: f64,
    out: Vec<u8>,
    executed: Vec<Vec<u8>>,
    /// Position in the coordinates of the program, and the tool length, mm.
    place: Place,
    /// Offsets of G54 and G55: X, Y, Z in mm, A and the rotation about Z in degrees. The selected one, from 0.
    pub(crate) offsets: [[f64; 5]; 2],
    pub(crate) selected: usize,
    pub(crate) length: f64,
    /// Another screen reads the messages.
    pub(crate) has_other_screen: bool,
    display: VecDeque<String>,
    /// Position of A in the machine, degrees.
    a: f64,
}

impl Rsh {
    pub(crate) fn new(faults: &Faults, busy_s: f64) -> Rsh {
        Rsh {
            faults: faults.clone(),
            line: Vec::new(),
            commands: VecDeque::new(),
            pending: None,
            waits_until_done: false,
            echo: true,
            is_linked: false,
            is_verbose: false,
            is_enabled: false,
            taken_over_s: None,
            is_on: true,
            is_homed: true,
            mode: "MANUAL",
            turns: false,
            queue: VecDeque::new(),
            under_way: None,
            lines: 0,
            has_failed: false,
            // Left there by somebody.
            errors: VecDeque::from(["joint 0 following error".to_owned()]),
            was_broken: false,
            unseen: false,
            was_stopped: false,
            busy_s,
            out: Vec::new(),
            executed: Vec::new(),
            place: Place::default(),
            offsets: [[0.0; 5]; 2],
            selected: 0,
            length: 0.0,
            has_other_screen: false,
            display: VecDeque::new(),
            a: 0.0,
        }
    }

    /// `(debug,text #5221 …)`: the parameters have six digits (seen with 2.9).
    fn print(&mut self, text: &str) {
        let words = text.trim_start_matches("(debug,").trim_end_matches(')').split(' ').map(|word| {
            let Some(name) = word.strip_prefix('#') else { return word.to_owned() };
            let value = match name.parse::<usize>() {
                Err(_) => 1.0,
                Ok(5220) => 1.0 + self.selected as f64,
                Ok(5422) => self.place.axes[2],
                Ok(number @ 5221..=5260) => {
                    let [x, y, z, a, r] = self.offsets[(number - 5221) / 20];
                    [x, y, z, a, 0.0, 0.0, 0.0, 0.0, 0.0, r].get((number - 5221) % 20).copied().unwrap_or(0.0)
                }
                Ok(_) => 0.0,
            };
            format!("{value:.6}")
        });
        let text = words.collect::<Vec<_>>().join(" ");
        if !self.has_other_screen {
            self.display.push_back(text);
        }
    }

    /// Carries out a line.
    fn carry_out(&mut self, text: &str) {
        for (code, system) in [("G54", 0), ("G55", 1)] {
            if text.contains(code) && self.selected != system {
                let of = |system: usize| self.offsets[system];
                for axis in 0..3 {
                    self.place.axes[axis] += of(self.selected)[axis] - of(system)[axis];
                }
                self.selected = system;
            }
        }
        self.place.take(text.as_bytes());
        let word = text.split_once('A').and_then(|(_, rest)| rest.split(|c: char| c.is_ascii_alphabetic()).next());
        if let Some(a) = word.and_then(|word| word.trim().parse::<f64>().ok()) {
            self.a = a + self.offsets[self.selected][3];
        }
    }

    /// Commanded position without its offset, or with it.
    fn shown_place(&self, name: &str, is_relative: bool) -> String {
        let [x, y, z, a, _] = self.offsets[self.selected];
        let [px, py, pz] = self.place.axes;
        let at = [px + x, py + y, pz + z + self.length, self.a];
        let less = if is_relative { [x, y, z, a] } else { [0.0; 4] };
        let all = [0, 1, 2, 3].map(|k| format!("{:.6}", at[k] - less[k])).join(" ");
        format!("{name} {all} 0.000000 0.000000")
    }

    fn answer(&mut self, text: &str) {
        let end = if text.starts_with("SET ") && !text.starts_with("SET NAK") { "\n\r" } else { "\r\n" };
        self.out.extend(text.bytes().chain(end.bytes()));
    }

    fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.under_way.is_none()
    }

    fn drop_all(&mut self) {
        self.queue.clear();
        self.under_way = None;
    }

    fn fail(&mut self, text: &str) {
        self.has_failed = true;
        self.errors.push_back(text.to_owned());
        self.drop_all();
    }

    /// What the task makes of a line.
    fn begin(&mut self, number: u64, text: &str, now_s: f64) {
        if !self.is_homed {
            return self.fail("Can't issue MDI command when not homed");
        }
        if self.mode != "MDI" {
            return self.fail("Must be in MDI mode to issue MDI command");
        }
        if self.faults.refuses == Some(number) {
            return self.fail("Linear move on line 0 would exceed X's positive limit");
        }
        if text.starts_with("(debug,") {
            self.print(text);
        }
        if text.starts_with('(') {
            return;
        }
        if text.contains("M3") {
            self.turns = true;
        }
        if text.contains("M5") || text.contains("M30") {
            self.turns = false;
        }
        self.under_way = Some((now_s + self.busy_s, text.to_owned()));
    }

    fn command(&mut self, command: &str, now_s: f64) {
        let words: Vec<&str> = command.split_ascii_whitespace().collect();
        let lower: Vec<String> = words.iter().map(|word| word.to_lowercase()).collect();
        let lower: Vec<&str> = lower.iter().map(String::as_str).collect();
        match lower.as_slice() {
            ["hello", ..] => {
                self.is_linked = words.get(1) == Some(&"EMC");
                self.answer(if self.is_linked { "HELLO ACK EMCNETSVR 1.1" } else { "HELLO NAK" });
            }
            ["get", "error"] => {
                let text = self.errors.pop_front().unwrap_or("OK".into());
                self.answer(&format!("ERROR {text}"));
            }
            ["get", "enable"] => self.answer(if self.is_enabled { "ENABLE ON" } else { "ENABLE OFF" }),
            ["get", "estop"] => self.answer("ESTOP OFF"),
            ["get", "machine"] => self.answer(if self.is_on { "MACHINE ON" } else { "MACHINE OFF" }),
            ["get", "mode"] => self.answer(&format!("MODE {}", self.mode)),
            ["get", "spindle", "0"] => self.answer(if self.turns { "SPINDLE 0 FORWARD" } else { "SPINDLE 0 OFF" }),
            ["get", "user_linear_units"] => self.answer("USER_LINEAR_UNITS MM"),
            ["get", "abs_cmd_pos"] => self.answer(&self.shown_place("ABS_CMD_POS", false)),
            ["get", "rel_cmd_pos"] => self.answer(&self.shown_place("REL_CMD_POS", true)),
            ["get", "operator_display"] => {
                let text = self.display.pop_front().unwrap_or("OK".into());
                self.answer(&format!("OPERATOR_DISPLAY {text}"));
            }
            ["get", "program_status"] => {
                self.answer(if self.is_idle() { "PROGRAM_STATUS IDLE" } else { "PROGRAM_STATUS RUNNING" });
            }
            ["get", ..] => panic!("it dies of {command}"),
            _ if !self.is_linked => self.answer("SET NAK"),
            ["set", what, rest @ ..] => self.set(what, rest, &words, command, now_s),
            _ => panic!("{command}"),
        }
    }

    fn set(&mut self, what: &str, rest: &[&str], words: &[&str], command: &str, now_s: f64) {
        let name = what.to_uppercase();
        let is_taken = match (what, rest) {
            ("echo", [state]) => {
                self.echo = *state == "on";
                true
            }
            ("verbose", [state]) => {
                self.is_verbose = *state == "on";
                true
            }
            ("enable", [_]) => {
                self.is_enabled = words[2] == "EMCTOO";
                self.is_enabled
            }
            _ if !self.is_enabled => false,
            ("set_wait", ["received"]) => true,
            ("wait", ["done"]) => {
                self.waits_until_done = true;
                return;
            }
            _ if !self.is_on => false,
            ("mode" | "mdi" | "abort", [first, ..]) => {
                match what {
                    "mode" => self.mode = if *first == "mdi" { "MDI" } else { "MANUAL" },
                    "mdi" => {
                        assert!(command.len() < 256);
                        let text = command.split_at(8).1.to_owned();
                        self.has_failed = false;
                        let number = if text.starts_with('(') { 0 } else { self.lines + 1 };
                        self.lines = self.lines.max(number);
                        self.queue.push_back((number, text));
                    }
                    _ => {}
                }
                self.pending = Some((now_s + DELAY_S, format!("SET {name} ACK")));
                return;
            }
            ("abort", []) => {
                self.break_off();
                self.pending = Some((now_s + DELAY_S, "SET ABORT ACK".into()));
                return;
            }
            _ => false,
        };
        if !is_taken || self.is_verbose {
            self.answer(&format!("SET {name} {}", if is_taken { "ACK" } else { "NAK" }));
        }
    }

    fn break_off(&mut self) {
        self.drop_all();
        self.turns = false;
    }
}

impl Control for Rsh {
    fn hear(&mut self, byte: u8, now_s: f64) {
        if self.echo && self.is_linked {
            self.out.push(byte);
        }
        if byte != b'\n' && byte != b'\r' {
            self.line.push(byte);
        } else if !self.line.is_empty() {
            let line = String::from_utf8(std::mem::take(&mut self.line)).unwrap();
            self.commands.push_back(line);
        }
        self.tick(now_s);
    }

    fn tick(&mut self, now_s: f64) {
        if self.faults.broken_off_s.is_some_and(|at| now_s >= at) && !self.was_broken {
            self.was_broken = true;
            // An abort while nothing runs or waits loses no line.
            self.unseen = !self.turns && !self.is_idle();
            self.break_off();
        }
        if self.taken_over_s.is_some_and(|at| now_s >= at) {
            self.taken_over_s = None;
            self.is_enabled = false;
            self.break_off();
        }
        // Emergency stop.
        if self.faults.reset_s.is_some_and(|at| now_s >= at) && !self.was_stopped {
            self.was_stopped = true;
            self.is_on = false;
            self.break_off();
        }
        if let Some((_, text)) = self.under_way.take_if(|(done_s, _)| *done_s <= now_s) {
            if self.faults.ignored != Some(1 + self.executed.len() as u64) {
                self.carry_out(&text);
            }
            self.executed.push(text.into_bytes());
        }
        while self.under_way.is_none()
            && let Some((number, text)) = self.queue.pop_front()
        {
            self.begin(number, &text, now_s);
        }
        loop {
            if let Some((_, text)) = self.pending.take_if(|(at, _)| *at <= now_s) {
                self.answer(&text);
            }
            if std::mem::take(&mut self.waits_until_done) {
                if self.has_failed {
                    self.answer("SET WAIT NAK");
                } else if self.is_idle() {
                    self.answer("SET WAIT ACK");
                } else {
                    self.waits_until_done = true;
                }
            }
            if self.pending.is_some() || self.waits_until_done {
                return;
            }
            let Some(command) = self.commands.pop_front() else { return };
            self.command(&command, now_s);
        }
    }

    fn say(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    fn executed(&self) -> &[Vec<u8>] {
        &self.executed
    }
}
