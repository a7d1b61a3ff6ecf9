//! What a control can answer, state by state: rows of a table, each held against the dialogue; and that nothing waits for ever.
//!
//! Sources: Grbl 1.1, interface and report.c; grblHAL, report.c; Marlin, queue.cpp and language.h; emcrsh.cc of LinuxCNC 2.9; TNC 360, data transfer;
//! B-63322EN, protocol B; Haas VF, setting 14.

use std::io;
use std::time::Duration;

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::feed::{Dialogue, Ended, Event, Line, PROFILES, Patience, Port, Profile, Sender, Wire};

use super::controls::{Blockwise, Control, Faults, Grbl, Marlin, Notes, Planned, Reader, Rsh};

/// What becomes of the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Then {
    /// It goes on.
    On,
    /// It ends: nobody knows the state of the control.
    Unknown,
    /// It ends, and the reason has this in it.
    Lost(&'static str),
}
use Then::{Lost, On, Unknown};

/// Two lines were answered, the third is under way; or it was answered, too, and none is.
const UNDER_WAY: bool = true;
const NONE: bool = false;

/// Link, state, answer, what becomes of the job. The third line of Marlin is N1005.
const ROWS: &[(&str, bool, &str, Then)] = &[
    ("grbl", UNDER_WAY, "ok", On),
    ("grbl", UNDER_WAY, "ok\r\nok", Unknown),
    ("grbl", UNDER_WAY, "error:33", On),
    ("grbl", NONE, "ok", Unknown),
    ("grbl", NONE, "error:9", Unknown),
    ("grbl", UNDER_WAY, "o*", Unknown),
    ("grbl", UNDER_WAY, "OK", Unknown),
    ("grbl", UNDER_WAY, "\u{0}ok", Unknown),
    ("grbl", UNDER_WAY, "", On),
    ("grbl", UNDER_WAY, "Grbl 1.1h ['$' for help]", Lost("reset")),
    ("grbl", NONE, "Grbl 1.1h ['$' for help]", Lost("reset")),
    ("grbl", UNDER_WAY, "GrblHAL 1.1f ['$' or '$HELP' for help]", Lost("reset")),
    ("grbl", UNDER_WAY, "okgRBL 1.1f ['$' for help]", Lost("reset")),
    ("grbl", UNDER_WAY, "\u{7f}x.Grbl 0.9j ['$' for help]", Lost("reset")),
    ("grbl", UNDER_WAY, ">G54G20:ok", Lost("reset")),
    ("grbl", UNDER_WAY, "[MSG:'$H'|'$X' to unlock]", Lost("alarm")),
    ("grbl", UNDER_WAY, "[MSG:Reset to continue]", Lost("alarm")),
    ("grbl", UNDER_WAY, "ALARM:1", Lost("alarm 1")),
    ("grbl", NONE, "ALARM:2", Lost("alarm 2")),
    ("grbl", UNDER_WAY, "<Alarm|MPos:0.000,0.000,0.000|FS:0,0>", Lost("alarm")),
    ("grbl", UNDER_WAY, "<Sleep|MPos:0.000,0.000,0.000|FS:0,0>", Lost("asleep")),
    ("grbl", UNDER_WAY, "<Check|MPos:0.000,0.000,0.000|FS:0,0>", Lost("check mode")),
    ("grbl", NONE, "<Jog|MPos:0.000,0.000,0.000|FS:0,0>", Lost("jogged or homed")),
    ("grbl", NONE, "<Home|MPos:0.000,0.000,0.000|FS:0,0>", Lost("jogged or homed")),
    ("grbl", UNDER_WAY, "<Run|MPos:0.000,0.000,0.000|FS:0,0>", On),
    ("grbl", UNDER_WAY, "<Hold:1|MPos:0.000,0.000,0.000|FS:0,0>", On),
    ("grbl", UNDER_WAY, "<Door:1|MPos:0.000,0.000,0.000|FS:0,0>", On),
    ("grbl", UNDER_WAY, "<Tool|MPos:0.000,0.000,0.000|FS:0,0>", On),
    ("grbl", UNDER_WAY, "<Rum|MPos:0.000,0.000,0.000|FS:0,0>", Unknown),
    ("grbl", UNDER_WAY, "<Run|MPos:0.000,0.000,0.000|Bf:15|FS:0,0>", Unknown),
    // More in its buffer than was not answered: an answer came twice.
    ("grbl", NONE, "<Run|MPos:0.000,0.000,0.000|Bf:10,100|FS:0,0>", Unknown),
    ("grbl", UNDER_WAY, "[MSG:Pgm End]", On),
    ("grbl", UNDER_WAY, "[PRB:0.000,0.000,1.492:1]", On),
    ("grbl", UNDER_WAY, "[OPT:V,15,128]", Unknown),
    ("grbl", UNDER_WAY, "[VER:1.1h.20190830:]", Unknown),
    ("grbl", UNDER_WAY, "$10=3", Unknown),
    ("grbl", UNDER_WAY, "start", Lost("reset")),
    ("marlin", UNDER_WAY, "ok", On),
    ("marlin", UNDER_WAY, "ok N1005 P15 B3", On),
    ("marlin", UNDER_WAY, "ok N1004 P15 B3", Unknown),
    ("marlin", UNDER_WAY, "ok N1006 P15 B3", Unknown),
    ("marlin", UNDER_WAY, "ok\nok", Unknown),
    ("marlin", NONE, "ok", Unknown),
    ("marlin", UNDER_WAY, "Resend: 1005", On),
    ("marlin", UNDER_WAY, "Resend:1005\nok", On),
    ("marlin", UNDER_WAY, "rs N1005", On),
    ("marlin", UNDER_WAY, "Error:checksum mismatch, Last Line: 1004\nResend: 1005\nok", On),
    ("marlin", UNDER_WAY, "Error:No Checksum with line number, Last Line: 1004\nResend: 1005", On),
    // It has taken it: it says so twice.
    ("marlin", UNDER_WAY, "Error:Line Number is not Last Line Number+1, Last Line: 1005\nResend: 1006\nok", On),
    // It went out once.
    ("marlin", UNDER_WAY, "Resend: 1006", Unknown),
    ("marlin", UNDER_WAY, "Error:checksum mismatch, Last Line: 1004\nResend: 1006", Unknown),
    ("marlin", UNDER_WAY, "Error:checksum mismatch, Last Line: 1005\nResend: 1005", Unknown),
    ("marlin", UNDER_WAY, "Resend: 1004", Lost("lost count")),
    ("marlin", UNDER_WAY, "Resend: 1", Lost("lost count")),
    ("marlin", UNDER_WAY, "Resend: 1007", Unknown),
    ("marlin", UNDER_WAY, "Resend: 100", Unknown),
    ("marlin", UNDER_WAY, "Error:checksum mismatch, Last Line: 0", Lost("lost count")),
    ("marlin", UNDER_WAY, "Error:checksum mismatch, Last Line: 1003", Lost("lost count")),
    ("marlin", NONE, "Resend: 1006", Unknown),
    ("marlin", NONE, "Resend: 1005", Unknown),
    ("marlin", NONE, "Resend: 1", Lost("lost count")),
    ("marlin", UNDER_WAY, "Resend: x", On),
    ("marlin", UNDER_WAY, "start", Lost("reset")),
    ("marlin", NONE, "START", Lost("reset")),
    ("marlin", UNDER_WAY, "\u{7f}\u{1}start", Lost("reset")),
    ("marlin", UNDER_WAY, "Marlin 2.1.2.4", Lost("reset")),
    ("marlin", UNDER_WAY, "echo:Marlin 1.1.9", Lost("reset")),
    ("marlin", UNDER_WAY, "echo: External Reset", Lost("reset")),
    ("marlin", UNDER_WAY, "echo: Watchdog Reset", Lost("reset")),
    ("marlin", UNDER_WAY, " Free Memory: 4096  PlannerBufferBytes: 1152", Lost("reset")),
    ("marlin", UNDER_WAY, "Grbl 1.1h ['$' for help]", Lost("reset")),
    ("marlin", UNDER_WAY, "Error:Printer halted. kill() called!", Lost("has halted")),
    ("marlin", NONE, "!!", Lost("has halted")),
    ("marlin", UNDER_WAY, "Error:MINTEMP triggered, system stopped! Heater_ID: bed", Lost("has halted")),
    ("marlin", UNDER_WAY, "//action:cancel", Lost("canceled")),
    ("marlin", UNDER_WAY, "wait", On),
    ("marlin", UNDER_WAY, "echo:busy: processing", On),
    ("marlin", UNDER_WAY, "echo:busy: paused for user", On),
    ("marlin", UNDER_WAY, "T:20.1 /0.0 B:19.8 /0.0", On),
    ("marlin", UNDER_WAY, "o*", Unknown),
    ("marlin", UNDER_WAY, "garbage ###", Unknown),
    ("marlin", NONE, "garbage ###", Unknown),
    ("marlin", UNDER_WAY, "echo:enqueueing \"G28\"", Unknown),
    ("marlin", UNDER_WAY, "echo:Home Z First\nok", Lost("not homed")),
    ("marlin", UNDER_WAY, "echo:endstops hit:  X:12.00", Lost("limit switch")),
    ("marlin", UNDER_WAY, "Printer stopped due to errors. Fix the error and use M999 to restart.", Lost("has halted")),
    ("marlin", UNDER_WAY, "Error", Lost("has halted")),
    ("marlin", UNDER_WAY, "//action:poweroff", Lost("power")),
    ("marlin", UNDER_WAY, "//action:start", Unknown),
    ("marlin", UNDER_WAY, "//action:pause", On),
    ("marlin", UNDER_WAY, "//action:paused\n//action:resumed", On),
    ("marlin", UNDER_WAY, "X:1.00 Y:2.00 Z:3.00 E:0.00 Count X:80 Y:160 Z:1200", On),
    ("marlin", UNDER_WAY, "Cap:EEPROM:1", On),
    ("heidenhain-fe1", UNDER_WAY, "\u{6}", On),
    ("heidenhain-fe1", UNDER_WAY, "\u{15}", On),
    ("heidenhain-fe1", UNDER_WAY, "\u{11}", On),
    ("heidenhain-fe1", UNDER_WAY, "\u{6}\u{6}", Unknown),
    ("heidenhain-fe1", NONE, "\u{6}", Unknown),
    ("heidenhain-fe1", NONE, "\u{15}", Unknown),
    ("heidenhain-fe1", UNDER_WAY, "\u{4}", Lost("aborted")),
    ("heidenhain-fe1", UNDER_WAY, "\u{18}", Lost("aborted")),
    ("heidenhain-fe1", UNDER_WAY, "\u{46}", Unknown),
    ("linuxcnc", UNDER_WAY, "SET MDI ACK", On),
    ("linuxcnc", UNDER_WAY, "SET MDI NAK", On),
    ("linuxcnc", UNDER_WAY, "error: joint 0 following error", On),
    ("linuxcnc", UNDER_WAY, "SET MDI ACK\r\nSET MDI ACK", Unknown),
    ("linuxcnc", UNDER_WAY, "PROGRAM_STATUS IDLE", Unknown),
    ("linuxcnc", UNDER_WAY, "SET MDI ACK\r\nPROGRAM_STATUS RUNNING\r\nPROGRAM_STATUS IDLE", Unknown),
    ("linuxcnc", UNDER_WAY, "SET MDI ACK\r\nPROGRAM_STATUS IDLE\r\nENABLE ON", Unknown),
    ("linuxcnc", UNDER_WAY, "SET MDI ACK\r\nPROGRAM_STATUS IDLE\r\nSET WAIT ACK", On),
    ("linuxcnc", UNDER_WAY, "HELLO ACK EMCNETSVR 1.1", Unknown),
    ("linuxcnc", NONE, "SET MDI ACK", Unknown),
    ("linuxcnc", NONE, "ERROR OK", Unknown),
    ("fanuc-rs232", UNDER_WAY, "\u{13}", On),
    ("fanuc-rs232", UNDER_WAY, "\u{0}\u{12}\u{14}", On),
    ("fanuc-rs232", UNDER_WAY, "\u{16}", Lost("reset")),
    ("fanuc-rs232", UNDER_WAY, "\u{15}", Lost("alarm")),
    ("fanuc-rs232", UNDER_WAY, "S", Unknown),
    // It gets what it asks for.
    ("fanuc-rs232", UNDER_WAY, "\u{11}", Unknown),
];

fn profile(name: &str) -> Profile {
    let (_, text) = PROFILES.iter().find(|(known, _)| *known == name).unwrap();
    Profile::read(&Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()).unwrap()
}

fn control(name: &str) -> Box<dyn Control> {
    let faults = Faults::default();
    match name {
        "grbl" => Box::new(Grbl::new(&faults, 0.001)),
        "marlin" => Box::new(Marlin::new(&faults, 0.001)),
        "heidenhain-fe1" => Box::new(Blockwise::new(&faults, 0.001)),
        "linuxcnc" => Box::new(Rsh::new(&faults, 0.001)),
        _ => Box::new(Reader::new(&faults, 0.001, 24, 1)),
    }
}

fn line(number: u64) -> Line {
    Line { number, text: format!("G1X{number}Y2Z3F4000").into_bytes(), busy_s: 0.001, ..Line::default() }
}

/// A dialogue with a faithful control, until so many lines were answered; what is said then no longer reaches the control.
struct Bench {
    dialogue: Box<dyn Dialogue>,
    control: Box<dyn Control>,
    wire: Wire,
    events: Vec<Event>,
    now_s: f64,
}

impl Bench {
    fn new(name: &str, lines: u64) -> Bench {
        let profile = profile(name);
        let protocol = profile.protocol;
        let mut bench = Bench {
            dialogue: (protocol.create)(&profile).unwrap(),
            control: control(name),
            wire: Wire::default(),
            events: Vec::new(),
            now_s: 0.0,
        };
        bench.dialogue.open(Duration::ZERO, &mut bench.wire);
        for number in 1..=lines {
            bench.wait(|bench| bench.dialogue.is_open() && bench.dialogue.in_flight().0 == 0);
            bench.send(number);
        }
        bench.wait(|bench| bench.dialogue.in_flight().0 == 0);
        bench
    }

    fn send(&mut self, number: u64) {
        self.dialogue.send(&line(number), self.now(), &mut self.wire).unwrap();
    }

    fn now(&self) -> Duration {
        Duration::from_secs_f64(self.now_s)
    }

    fn wait(&mut self, is_there: impl Fn(&Bench) -> bool) {
        while !is_there(self) {
            self.now_s += 0.002;
            assert!(self.now_s < 30.0, "{:?}", self.events);
            let now = self.now();
            self.dialogue.tick(now, &mut self.wire, &mut self.events);
            for byte in take(&mut self.wire) {
                self.control.hear(byte, self.now_s);
            }
            self.control.tick(self.now_s);
            let said = self.control.say();
            self.dialogue.hear(&said, now, &mut self.wire, &mut self.events);
        }
    }
}

/// What has left.
fn take(wire: &mut Wire) -> Vec<u8> {
    let mut bytes = Vec::new();
    while !wire.next(1).is_empty() {
        bytes.extend(wire.next(99));
        wire.took(99);
    }
    wire.queue(0);
    bytes
}

#[test]
fn every_answer_means_what_the_table_says() {
    let mut wrong = Vec::new();
    for &(name, is_under_way, answer, then) in ROWS {
        let mut bench = Bench::new(name, if is_under_way { 2 } else { 3 });
        if is_under_way {
            bench.send(3);
        }
        // On a tape link bytes leave by its clock.
        bench.now_s += if name == "fanuc-rs232" { 0.6 } else { 0.001 };
        let now = bench.now();
        bench.dialogue.tick(now, &mut bench.wire, &mut bench.events);
        take(&mut bench.wire);
        bench.dialogue.tick(now, &mut bench.wire, &mut bench.events);
        bench.events.clear();
        let end = if name.contains("rs232") || name.contains("fe1") { "" } else { "\r\n" };
        bench.dialogue.hear(format!("{answer}{end}").as_bytes(), now, &mut bench.wire, &mut bench.events);
        let why = bench
            .events
            .iter()
            .find_map(|event| if let Event::Lost(_, why) = event { Some(why.clone()) } else { None });
        let is_right = match then {
            On => why.is_none(),
            Unknown => why.as_ref().is_some_and(|why| why.contains("the state of the control is unknown")),
            Lost(part) => why.as_ref().is_some_and(|why| why.contains(part)),
        };
        // Nothing but a hold goes out behind the end: the sender withdraws the rest.
        if why.is_some() {
            bench.wire.withdraw();
        }
        let sent = take(&mut bench.wire);
        if !is_right || then != On && sent.iter().any(|byte| *byte != b'!') {
            wrong.push(format!(
                "{name}, line under way: {is_under_way}, {answer:?}: {then:?}, but {why:?}, sent {sent:?}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_refused_line_holds_the_axes() {
    let mut bench = Bench::new("grbl", 2);
    bench.send(3);
    take(&mut bench.wire);
    let now = bench.now();
    bench.dialogue.hear(b"error:33\r\n", now, &mut bench.wire, &mut bench.events);
    assert_eq!(take(&mut bench.wire), b"!");
}

/// A control that answers as it must for a while, and from then on says one thing again and again, or nothing.
struct Stuck {
    control: Box<dyn Control>,
    from_s: f64,
    now_s: f64,
    said_s: f64,
    back: Vec<u8>,
}

impl Port for Stuck {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.back.len().min(into.len());
        into[..count].copy_from_slice(&self.back.drain(..count).collect::<Vec<u8>>());
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for byte in bytes {
            self.control.hear(*byte, self.now_s);
        }
        Ok(bytes.len())
    }
}

/// Link, what it says, when it ends at the latest, s, and the reason. Lines take a tenth of a second; 60 s without one are granted, 600 s for a hold.
const STUCK: &[(&str, &str, f64, &str)] = &[
    ("grbl", "", 15.0, "does not answer"),
    ("grbl", "<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n", 4.0, "an answer was lost"),
    ("grbl", "<Run|MPos:0.000,0.000,0.000|FS:0,0>\r\n", 64.0, "no line was answered"),
    ("grbl", "<Hold:0|MPos:0.000,0.000,0.000|FS:0,0>\r\n", 602.0, "in hold"),
    ("grbl", "<Door:1|MPos:0.000,0.000,0.000|FS:0,0>\r\n", 602.0, "in hold"),
    ("grbl", "<Tool|MPos:0.000,0.000,0.000|FS:0,0>\r\n", 602.0, "in hold"),
    ("grbl", "<Sleep|MPos:0.000,0.000,0.000|FS:0,0>\r\n", 2.0, "asleep"),
    ("grbl", "[MSG:x]\r\n", 64.0, "no line was answered"),
    ("grbl", "noise", 15.0, "does not answer"),
    ("marlin", "", 20.0, "not accepted"),
    ("marlin", "wait\n", 20.0, "not accepted"),
    ("marlin", "noise", 20.0, "not accepted"),
    ("marlin", "echo:busy: processing\n", 64.0, "no line was answered"),
    ("marlin", "echo:busy: paused for user\n", 602.0, "in hold"),
    ("marlin", "T:20.0 /0.0\n", 64.0, "no line was answered"),
    ("heidenhain-fe1", "", 32.0, "does not answer"),
    ("heidenhain-fe1", "\u{11}", 32.0, "does not answer"),
    ("linuxcnc", "", 45.0, "does not answer"),
    ("linuxcnc", "noise", 45.0, "does not answer"),
    ("linuxcnc", "PROGRAM_STATUS RUNNING", 64.0, "no line was answered"),
    ("linuxcnc", "PROGRAM_STATUS PAUSED", 602.0, "in hold"),
    ("fanuc-rs232", "\u{13}", 602.0, "in hold"),
    ("haas", "\u{13}", 602.0, "in hold"),
    ("marlin", "//action:pause\n", 602.0, "in hold"),
    // By turns: that it goes on is no progress. 20 s of every 40 are held; 60 s beside are granted.
    (
        "grbl",
        "<Hold:0|MPos:0.000,0.000,0.000|FS:0,0>\r\n~<Run|MPos:0.000,0.000,0.000|FS:0,0>\r\n",
        145.0,
        "no line was answered",
    ),
    (
        "grbl",
        "<Door:1|MPos:0.000,0.000,0.000|FS:0,0>\r\n~<Run|MPos:0.000,0.000,0.000|FS:0,0>\r\n",
        145.0,
        "no line was answered",
    ),
    ("marlin", "echo:busy: paused for user\n~echo:busy: processing\n", 145.0, "no line was answered"),
    (
        "marlin",
        "//action:pause\necho:busy: processing\n~//action:resume\necho:busy: processing\n",
        145.0,
        "no line was answered",
    ),
    ("linuxcnc", "PROGRAM_STATUS PAUSED~PROGRAM_STATUS RUNNING", 145.0, "no line was answered"),
    ("fanuc-rs232", "\u{13}\u{11}\u{13}", 602.0, "in hold"),
    ("haas", "\u{13}\u{11}\u{13}", 602.0, "in hold"),
];

fn stuck(name: &str, says: &'static str, from_s: f64) -> (f64, Ended) {
    let profile = profile(name);
    let protocol = profile.protocol;
    let patience = Patience { stall: Duration::from_secs(60), hold: Duration::from_secs(600) };
    let mut notes = Notes::default();
    let mut sender =
        Sender::new((protocol.create)(&profile).unwrap(), profile.window.system_bytes, &mut notes).patient(patience);
    let mut planned = Planned::new(10_000, 0.1);
    let mut port = Stuck { control: control(name), from_s, now_s: 0.0, said_s: 0.0, back: Vec::new() };
    let mut moved_s = 0.0;
    loop {
        port.now_s += if port.now_s < port.from_s { 0.005 } else { 0.02 };
        port.control.tick(port.now_s);
        let said = port.control.say();
        let turns: Vec<&str> = says.split('~').collect();
        let says = turns[(port.now_s / 20.0) as usize % turns.len()];
        if port.now_s < port.from_s {
            port.back.extend(said);
            moved_s = port.now_s;
        } else if says.starts_with("PROGRAM_STATUS") {
            // What answers a question is said once for each.
            let said = String::from_utf8(said).unwrap();
            port.back.extend(said.replace("PROGRAM_STATUS IDLE", says).replace("PROGRAM_STATUS RUNNING", says).bytes());
        } else if port.now_s - port.said_s > 0.3 {
            port.said_s = port.now_s;
            port.back.extend(says.bytes());
        }
        let now = Duration::from_secs_f64(port.now_s);
        if let Some(ended) = sender.step(now, &mut port, &mut planned, &mut |_| ()).unwrap() {
            return (port.now_s - moved_s, ended);
        }
        assert!(port.now_s < 2000.0, "{name} {says:?} waits for ever");
    }
}

#[test]
fn nothing_waits_for_ever() {
    let mut wrong = Vec::new();
    for &(name, says, within_s, reason) in STUCK {
        let (took_s, ended) = stuck(name, says, 3.0);
        if took_s > within_s || !matches!(&ended, Ended::Lost(_, why) if why.contains(reason)) {
            wrong.push(format!("{name} {says:?}: after {took_s:.1} s {ended:?}, not {reason} within {within_s} s"));
        }
    }
    // And before the first line.
    for name in ["grbl", "marlin", "heidenhain-fe1", "linuxcnc", "fanuc-rs232"] {
        for says in ["", "noise", "x\r\n"] {
            let (took_s, ended) = stuck(name, says, 0.0);
            if took_s > 602.0 || !matches!(ended, Ended::Lost(..)) {
                wrong.push(format!("{name} {says:?} before the first line: after {took_s:.1} s {ended:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_line_goes_out_while_marlin_asks_to_pause() {
    let mut bench = Bench::new("marlin", 2);
    bench.send(3);
    let hear = |bench: &mut Bench, text: &str| {
        let now = bench.now();
        bench.dialogue.hear(text.as_bytes(), now, &mut bench.wire, &mut bench.events);
        bench.dialogue.has_room(1)
    };
    // An answer to the line under way does not end it.
    assert!(!hear(&mut bench, "//action:pause\nok\n"));
    assert!(!hear(&mut bench, "T:20.0 /0.0\n"));
    assert!(hear(&mut bench, "//action:resume\n"));
    let paused: Vec<bool> =
        bench.events.iter().filter_map(|event| if let Event::Paused(is) = event { Some(*is) } else { None }).collect();
    assert_eq!(paused, [true, false]);
}

#[test]
fn a_dwell_is_awaited_while_grbl_says_that_it_is_idle() {
    // Grbl 1.1 says Idle while it dwells (protocol_buffer_synchronize ends the cycle first).
    let mut bench = Bench::new("grbl", 2);
    let dwell = Line { number: 3, text: b"G4 P20".to_vec(), busy_s: 20.0, ..Line::default() };
    bench.dialogue.send(&dwell, bench.now(), &mut bench.wire).unwrap();
    take(&mut bench.wire);
    let is_lost = |bench: &Bench| bench.events.iter().any(|event| matches!(event, Event::Lost(..)));
    let report = b"<Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:0,0>\r\n";
    for after_s in [1.0, 10.0, 20.0] {
        let now = bench.now() + Duration::from_secs_f64(after_s);
        bench.dialogue.hear(report, now, &mut bench.wire, &mut bench.events);
        assert!(!is_lost(&bench), "{after_s}: {:?}", bench.events);
    }
    // 20 s of the dwell and 2 s of patience after the first report that nothing is left to execute.
    let now = bench.now() + Duration::from_secs(24);
    bench.dialogue.hear(report, now, &mut bench.wire, &mut bench.events);
    assert!(is_lost(&bench));
}

#[test]
fn a_control_that_starts_is_counted_anew_and_one_that_starts_for_ever_is_left() {
    let profile = profile("marlin");
    let protocol = profile.protocol;
    let mut dialogue = (protocol.create)(&profile).unwrap();
    let (mut wire, mut events) = (Wire::default(), Vec::new());
    dialogue.open(Duration::ZERO, &mut wire);
    assert!(take(&mut wire).starts_with(b"N1000 M110 N1000*"));
    let greeting = b"start\r\nMarlin 2.1.2\r\necho: External Reset\r\n".repeat(1000);
    let mut sent = 0;
    for second in 1..=60 {
        let now = Duration::from_secs(second);
        dialogue.hear(&greeting, now, &mut wire, &mut events);
        dialogue.tick(now + Duration::from_millis(600), &mut wire, &mut events);
        let bytes = take(&mut wire);
        assert!(bytes.is_empty() || bytes.starts_with(b"N1000 M110 N1000*") && bytes.len() < 30, "{bytes:?}");
        sent += bytes.len();
    }
    // Five times more, as the profile says.
    assert!(sent > 0 && matches!(events.last(), Some(Event::Lost(..))), "{sent} {:?}", events.last());
}
