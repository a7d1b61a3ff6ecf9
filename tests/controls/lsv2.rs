//! A control that speaks LSV/2, over TCP or in frames of DIN 66019. It keeps files, a person starts one of them, and it carries out its lines.
//!
//! It is written from the description of the protocol: telegrams of a length, a name and data; logins that give rights; files that are sent in blocks. It
//! shares no code with the program, and reads what comes byte for byte in its own way.

use std::collections::{BTreeMap, BTreeSet};

use super::Control;

/// A wrong reaction in place of the right answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Odd {
    /// `T_ER` with class 1 and this number.
    Error(u8),
    /// An error of a transfer, without data.
    PlainError,
    Silence,
    /// Only a part of the answer.
    Half,
    /// A length of two gigabytes.
    Giant,
    /// A length that is too large by one, and one that is too small.
    Longer,
    Shorter,
    /// Another telegram.
    Other,
    /// Text of another protocol.
    Text,
    /// The answer comes twice.
    Twice,
    /// Data that do not belong there.
    Data,
    /// Messages without an end.
    Messages,
}

/// States of the selected program.
const STARTED: u16 = 0;
const STOPPED: u16 = 1;
const FINISHED: u16 = 2;
const CANCELLED: u16 = 3;
const IDLE: u16 = 7;

enum Wires {
    /// Bytes of a telegram that is not complete.
    Network(Vec<u8>),
    Line(Line),
}

/// One end of a serial line.
#[derive(Default)]
struct Line {
    /// Bytes since the last control sequence.
    seen: Vec<u8>,
    is_in_block: bool,
    /// Telegrams to be sent, framed, and whether the first is under way.
    out: Vec<Vec<u8>>,
    has_asked: bool,
}

pub(crate) struct Lsv2 {
    wires: Wires,
    /// The telegram that is answered otherwise: its name, how many of them before, and what happens.
    pub(crate) odd: Option<(&'static str, u64, Odd)>,
    heard: BTreeMap<String, u64>,
    rights: BTreeSet<String>,
    /// Files by path.
    pub(crate) files: BTreeMap<String, Vec<Vec<u8>>>,
    /// Without the option for DNC, without telegrams of positions, without an answer to the end of a file.
    pub(crate) has_dnc: bool,
    pub(crate) has_position: bool,
    pub(crate) has_secure_end: bool,
    is_secure: bool,
    most_bytes: usize,
    buffer: usize,
    /// Path and bytes of the file that comes in, and blocks that are still to go out.
    incoming: Option<(String, bool, Vec<u8>)>,
    outgoing: Vec<Vec<u8>>,
    /// State and mode that it reports; the axis that it moves.
    pub(crate) status: u16,
    pub(crate) mode: u16,
    pub(crate) drifts: bool,
    x_um: i64,
    selected: String,
    /// The time after the file has come at which a person starts it, s; what the person starts; when the run is stopped, resumed, cancelled.
    pub(crate) starts_after_s: Option<f64>,
    pub(crate) starts_path: Option<String>,
    pub(crate) stop: Option<(usize, f64)>,
    pub(crate) cancels_at: Option<usize>,
    /// A byte of the file is damaged when it is stored; a person edits the file during the run.
    pub(crate) damages: Option<usize>,
    pub(crate) edits: bool,
    /// It says nothing of the end, and goes to idle.
    pub(crate) ends_idle: bool,
    complete_s: Option<f64>,
    under_way: Option<(usize, f64)>,
    busy_s: f64,
    executed: Vec<Vec<u8>>,
    /// Telegram of a line, until its EOT.
    waiting: Option<(String, Vec<u8>)>,
    out: Vec<u8>,
    now_s: f64,
    pub(crate) says_bad_check: u64,
    pub(crate) refuses_blocks: u64,
    /// Commands that move or press something: none may ever come.
    pub(crate) pressed: u64,
}

impl Lsv2 {
    pub(crate) fn over_network(busy_s: f64) -> Lsv2 {
        Lsv2::new(Wires::Network(Vec::new()), busy_s)
    }

    pub(crate) fn over_line(busy_s: f64) -> Lsv2 {
        Lsv2::new(Wires::Line(Line::default()), busy_s)
    }

    fn new(wires: Wires, busy_s: f64) -> Lsv2 {
        Lsv2 {
            wires,
            odd: None,
            heard: BTreeMap::new(),
            rights: BTreeSet::new(),
            files: BTreeMap::new(),
            has_dnc: true,
            has_position: true,
            has_secure_end: true,
            is_secure: false,
            most_bytes: 4096,
            buffer: 256,
            incoming: None,
            outgoing: Vec::new(),
            status: IDLE,
            mode: 4,
            drifts: false,
            x_um: 0,
            selected: "TNC:\\OTHER.PM".into(),
            starts_after_s: Some(0.5),
            starts_path: None,
            stop: None,
            cancels_at: None,
            damages: None,
            edits: false,
            ends_idle: false,
            complete_s: None,
            under_way: None,
            busy_s,
            executed: Vec::new(),
            waiting: None,
            out: Vec::new(),
            now_s: 0.0,
            says_bad_check: 0,
            refuses_blocks: 0,
            pressed: 0,
        }
    }

    fn say(&mut self, name: &str, data: &[u8]) {
        match &mut self.wires {
            Wires::Network(_) => {
                let length = data.len();
                self.out
                    .extend([length >> 24, length >> 16 & 255, length >> 8 & 255, length & 255].map(|part| part as u8));
                self.out.extend(name.bytes().chain(data.iter().copied()));
            }
            Wires::Line(line) => {
                let plain: Vec<u8> = name.bytes().chain(data.iter().copied()).collect();
                let mut sum = 3;
                let mut framed = vec![16, 2];
                for byte in plain {
                    sum ^= byte;
                    framed.extend(std::iter::repeat_n(byte, if byte == 16 { 2 } else { 1 }));
                }
                framed.extend([16, 3, sum]);
                line.out.push(framed);
                if !std::mem::replace(&mut line.has_asked, true) {
                    self.out.push(5);
                }
            }
        }
    }

    fn error(&mut self, number: u8) {
        self.say("T_ER", &[1, number]);
    }

    /// A telegram has come.
    fn telegram(&mut self, name: &str, data: &[u8]) {
        let before = self.heard.entry(name.to_owned()).or_default();
        *before += 1;
        let is_odd = self.odd.is_some_and(|(of, skip, _)| of == name && skip + 1 == *before);
        let (from, line_from) = (self.out.len(), self.line_count());
        self.answer(name, data);
        if is_odd && let Some((.., odd)) = self.odd {
            self.twist(odd, from, line_from);
        }
    }

    fn line_count(&self) -> usize {
        if let Wires::Line(line) = &self.wires { line.out.len() } else { 0 }
    }

    /// Replaces the answer.
    fn twist(&mut self, odd: Odd, from: usize, line_from: usize) {
        if let Wires::Line(line) = &mut self.wires {
            line.out.truncate(line_from);
            line.has_asked = line_from > 0;
        }
        let right = self.out.split_off(from);
        match odd {
            Odd::Silence => {}
            Odd::Error(number) => self.error(number),
            Odd::PlainError => self.say("T_BD", &[]),
            Odd::Half => self.out.extend(&right[..right.len() / 2]),
            Odd::Giant => self.out.extend(b"\x7f\xff\xff\xffT_OK"),
            Odd::Longer | Odd::Shorter => {
                let mut bytes = right;
                if let Some(last) = bytes.get_mut(3) {
                    *last = if odd == Odd::Longer { last.wrapping_add(1) } else { last.wrapping_sub(1) };
                }
                self.out.extend(bytes);
            }
            Odd::Other => self.say("S_DR", b"X\0"),
            Odd::Text => self.out.extend(b"HTTP/1.1 400 Bad Request\r\n\r\n"),
            Odd::Twice => {
                self.out.extend(&right);
                self.out.extend(&right);
            }
            Odd::Data => {
                let name = right.get(4..8).map_or("T_OK".to_owned(), |name| String::from_utf8_lossy(name).into_owned());
                self.say(&name, &[0xaa; 7]);
            }
            Odd::Messages => (0..5000).for_each(|_| self.say("M_CC", &[0, 27, 0, 100])),
        }
    }

    fn has(&self, right: &str) -> bool {
        self.rights.contains(right)
    }

    fn answer(&mut self, name: &str, data: &[u8]) {
        let right = match name {
            "A_LG" => "",
            "R_VR" | "R_PR" | "C_CC" => "INSPECT",
            "R_RI" => "DNC",
            "R_FI" | "C_FL" | "R_FL" | "C_FD" => "FILE",
            _ => "",
        };
        if !right.is_empty() && !self.has(right) {
            return self.error(23);
        }
        let text =
            || data.split(|byte| *byte == 0).next().map(|text| String::from_utf8_lossy(text).into_owned()).unwrap();
        let number = || data.iter().fold(0_u32, |sum, byte| sum * 256 + u32::from(*byte));
        match name {
            "A_LG" if data.last() != Some(&0) => self.error(20),
            "A_LG" if text() == "DNC" && !self.has_dnc => self.error(23),
            "A_LG" if ["INSPECT", "DNC", "FILE"].contains(&text().as_str()) => {
                self.rights.insert(text());
                self.say("T_OK", &[]);
            }
            "A_LG" => self.error(49),
            "A_LO" => {
                self.rights.clear();
                self.say("T_OK", &[]);
            }
            "R_VR" => self.say("S_VR", b"MILLPlusIT\x00340420 01\x00PLC 1\x0000000\0"),
            "R_PR" => {
                let mut data = vec![0; 120];
                data[98..100].copy_from_slice(&(self.most_bytes as u16).to_be_bytes());
                self.say("S_PR", &data);
            }
            "C_CC" if number() == 19 && !self.has_secure_end => self.error(22),
            "C_CC" => {
                match number() {
                    3 => self.buffer = 1024,
                    4 => self.buffer = 512,
                    5 => self.buffer = 2048,
                    6 => self.buffer = 3072,
                    7 => self.buffer = 4096,
                    19 => self.is_secure = true,
                    _ => return self.error(24),
                }
                assert!(self.buffer <= self.most_bytes);
                self.say("T_OK", &[]);
            }
            "R_RI" => self.information(number()),
            "R_FI" => match self.files.get(&text()) {
                Some(lines) => {
                    let mut data = (lines.iter().map(Vec::len).sum::<usize>() as u32).to_be_bytes().to_vec();
                    data.extend([0; 8]);
                    data.extend(text().bytes().chain([0]));
                    self.say("S_FI", &data);
                }
                None => self.error(32),
            },
            "C_FD" => match self.files.remove(&text()) {
                _ if self.under_way.is_some() => self.error(36),
                Some(_) => self.say("T_OK", &[]),
                None => self.error(32),
            },
            "C_FL" => {
                let mode = *data.last().unwrap();
                assert!(mode < 2 && data.len() == text().len() + 2, "{data:?}");
                if self.files.contains_key(&text()) {
                    return self.error(34);
                }
                self.files.insert(text(), Vec::new());
                self.incoming = Some((text(), mode == 1, Vec::new()));
                self.say("T_OK", &[]);
            }
            "S_FL" => {
                assert!(data.len() + 8 < self.buffer, "{} of {}", data.len(), self.buffer);
                let Some((.., bytes)) = &mut self.incoming else { return self.error(21) };
                bytes.extend(data);
                self.say("T_OK", &[]);
            }
            "T_FD" => {
                let Some((path, _, mut bytes)) = self.incoming.take() else { return self.error(21) };
                if let Some(at) = self.damages {
                    bytes[at] ^= 1;
                }
                let mut lines: Vec<Vec<u8>> = bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
                // The last one is a part if the file was cut off.
                let part = lines.pop().filter(|part| !part.is_empty());
                lines.iter_mut().for_each(|line| assert_eq!(line.pop(), Some(b'\r')));
                lines.extend(part);
                self.files.insert(path, lines);
                self.complete_s = None;
                if self.is_secure {
                    self.say("T_OK", &[]);
                }
            }
            "R_FL" => {
                let is_binary = *data.last().unwrap() == 1;
                let Some(lines) = self.files.get(&text()) else { return self.error(32) };
                let end: &[u8] = if is_binary { b"\r\n" } else { b"\0" };
                let bytes: Vec<u8> = lines.iter().flat_map(|line| [line, end].concat()).collect();
                self.outgoing = bytes.chunks(self.buffer - 11).rev().map(<[u8]>::to_vec).collect();
                self.next_block();
            }
            "T_OK" => self.next_block(),
            _ => {
                self.pressed += 1;
                self.error(22);
            }
        }
    }

    fn next_block(&mut self) {
        match self.outgoing.pop() {
            Some(block) => self.say("S_FL", &block),
            None => {
                self.complete_s.get_or_insert(self.now_s);
                self.say("T_FD", &[]);
            }
        }
    }

    fn information(&mut self, number: u32) {
        match number {
            22 if !self.has_position => self.error(24),
            22 => {
                self.x_um += 10 * i64::from(self.drifts);
                let text = format!("{}.{:03}\0+20.000\0X\0Z\0", self.x_um / 1000, self.x_um % 1000);
                self.say("S_RI", &[&[0, 2][..], text.as_bytes()].concat());
            }
            23 => self.say("S_RI", &self.mode.to_be_bytes()),
            24 => {
                let line = self.under_way.map_or(0, |(line, _)| line as u32 + 1);
                let data = [&line.to_be_bytes()[..], format!("{0}\0{0}\0", self.selected).as_bytes()].concat();
                self.say("S_RI", &data);
            }
            26 => self.say("S_RI", &self.status.to_be_bytes()),
            _ => self.error(24),
        }
    }

    /// The acts of a person at the control, and the run.
    fn work(&mut self) {
        if let (Some(since), Some(after)) = (self.complete_s, self.starts_after_s)
            && self.now_s >= since + after
            && self.under_way.is_none()
            && self.executed.is_empty()
        {
            let own = self.files.keys().next().cloned().unwrap_or_default();
            self.selected = self.starts_path.clone().unwrap_or(own);
            self.starts_after_s = None;
            self.status = STARTED;
            self.under_way = Some((0, self.now_s));
        }
        while let Some((line, since)) = self.under_way {
            if let Some((at, until_s)) = self.stop
                && at == line
            {
                self.status = if self.now_s < until_s { STOPPED } else { STARTED };
                if self.status == STOPPED {
                    self.under_way = Some((line, self.now_s));
                    return;
                }
            }
            if self.cancels_at == Some(line) {
                self.status = CANCELLED;
                self.under_way = None;
                return;
            }
            if self.now_s < since + self.busy_s {
                return;
            }
            self.x_um += 1000;
            let Some(lines) = self.files.get_mut(&self.selected) else {
                // A program of somebody else, of ten lines.
                self.under_way = if line < 9 { Some((line + 1, since + self.busy_s)) } else { None };
                self.status = if line < 9 { STARTED } else { FINISHED };
                continue;
            };
            if let Some(text) = lines.get(line) {
                self.executed.push(text.clone());
            }
            if line + 1 < lines.len() {
                self.under_way = Some((line + 1, since + self.busy_s));
            } else {
                if self.edits {
                    lines[0].push(b' ');
                }
                self.under_way = None;
                self.status = if self.ends_idle { IDLE } else { FINISHED };
            }
        }
    }

    fn hear_line(&mut self, byte: u8) {
        let Wires::Line(line) = &mut self.wires else { unreachable!() };
        line.seen.push(byte);
        if line.is_in_block {
            // The end is an odd DLE, ETX, and the check character behind them.
            let mut at = 0;
            let (mut plain, mut sum) = (Vec::new(), 0_u8);
            while at < line.seen.len() {
                match (line.seen[at], line.seen.get(at + 1)) {
                    (16, Some(16)) => {
                        plain.push(16);
                        sum ^= 16;
                        at += 2;
                    }
                    (16, Some(3)) => {
                        let Some(check) = line.seen.get(at + 2) else { return };
                        sum ^= 3;
                        let is_good = *check == sum && self.refuses_blocks == 0;
                        self.refuses_blocks = self.refuses_blocks.saturating_sub(1);
                        line.seen.clear();
                        line.is_in_block = false;
                        if !is_good {
                            return self.out.push(21);
                        }
                        assert!(plain.len() <= 128, "{}", plain.len());
                        self.out.extend([16, b'1']);
                        let name = String::from_utf8(plain[..4].to_vec()).unwrap();
                        // The answer follows when the line is free: at EOT.
                        self.waiting = Some((name, plain[4..].to_vec()));
                        return;
                    }
                    (16, Some(other)) => panic!("DLE {other}"),
                    (16, None) => return,
                    (byte, _) => {
                        plain.push(byte);
                        sum ^= byte;
                        at += 1;
                    }
                }
            }
            return;
        }
        match line.seen[..] {
            [5] => self.out.extend([16, b'0']),
            [16] => return,
            [16, 2] => line.is_in_block = true,
            // Ready for a block, or again.
            [16, b'0'] | [21] => {
                let mut block = line.out[0].clone();
                if self.says_bad_check > 0 {
                    self.says_bad_check -= 1;
                    *block.last_mut().unwrap() ^= 0x40;
                }
                self.out.extend(block);
            }
            [16, b'1'] => {
                line.out.remove(0);
                self.out.push(4);
                line.has_asked = !line.out.is_empty();
                if line.has_asked {
                    self.out.push(5);
                }
            }
            [4] => {}
            _ => panic!("{:?}", line.seen),
        }
        line.seen.clear();
        if byte == 4
            && let Some((name, data)) = self.waiting.take()
        {
            self.telegram(&name, &data);
        }
    }
}

impl Control for Lsv2 {
    fn hear(&mut self, byte: u8, now_s: f64) {
        self.tick(now_s);
        let Wires::Network(bytes) = &mut self.wires else { return self.hear_line(byte) };
        bytes.push(byte);
        if bytes.len() < 8 {
            return;
        }
        let length = bytes[..4].iter().fold(0_usize, |sum, byte| sum * 256 + usize::from(*byte));
        if bytes.len() < 8 + length {
            return;
        }
        let whole = std::mem::take(bytes);
        assert!(whole.len() < self.buffer, "{} of {}", whole.len(), self.buffer);
        self.telegram(std::str::from_utf8(&whole[4..8]).unwrap(), &whole[8..]);
    }

    fn tick(&mut self, now_s: f64) {
        self.now_s = self.now_s.max(now_s);
        self.work();
    }

    fn say(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    fn executed(&self) -> &[Vec<u8>] {
        &self.executed
    }
}
