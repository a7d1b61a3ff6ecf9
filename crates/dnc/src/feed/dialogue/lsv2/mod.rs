//! LSV/2 of HEIDENHAIN, over TCP and over a serial line: the program goes to the control as one file, which a person starts there.
//!
//! Login, question for state, mode, selected program and position; then the file: written, read back, compared. After that ncfix asks for the state until the
//! program has run. It never presses a key of the control, and never starts or stops a program.
//!
//! | state | answer | meaning |
//! | --- | --- | --- |
//! | question | the telegram of that question | the next step |
//! | | `T_ER`, `T_BD` | refused: the reason, and no further step; optional questions are left out |
//! | file blocks | `T_OK` | the block is stored. Nothing is executed |
//! | file read back | `S_FL`, then `T_FD` | the file of the control; any difference ends the job, and the file is deleted |
//! | run | started, then finished | executed, if the selected program is this file, the run was long enough, and the file is still the same |
//! | any | another telegram, none, data of another length | impossible: the job ends |
//!
//! Sources. The telegrams over TCP, their numbers and data are those that pyLSV2 1.x uses with controls (its source and its protocol notes, read in 2026).
//! They rest on traffic that others recorded, and on a manual of 1993; HEIDENHAIN publishes no description. [`serial`] has the sources of the serial frames.
//! The list of commands of that manual names a DNC load (`C_NC`, `C_CN`), but no public source has its data. So it is not used here: LSV/2 sends whole
//! files, and a correction for later temperatures is not possible. No buffer question is published either.

mod decode;
mod hear;
mod read_back;
mod run;
mod serial;
mod telegram;

use std::time::Duration;

use self::read_back::ReadBack;
use self::run::{ControlReports, FileRun};
use self::serial::SerialFrames;
use self::telegram::{TcpTelegrams, Telegram};
use super::answers::{impossible, shown};
use super::{Dialogue, Event, Halt, Line, LossKind, Profile, Protocol, Wire, check_text};
use crate::feed::profile::FileOptions;

/// Entry of the dialogue over TCP; profiles select it by its name.
pub(super) const TCP: Protocol = Protocol {
    name: "lsv2",
    title: "LSV/2 over TCP: the program as one file (HEIDENHAIN)",
    asks_idle: true,
    sends_file: true,
    has_planner: false,
    beyond: 0,
    rewrite: None,
    check: |profile, text| check_text(text, profile.longest_line, &profile.refused),
    create: |profile| Ok(Box::new(Lsv2::new(profile, Layer::Tcp(TcpTelegrams::default())))),
};

/// Entry of the dialogue over a serial line.
pub(super) const SERIAL: Protocol = Protocol {
    name: "lsv2-serial",
    title: "LSV/2 over a serial line: the program as one file (HEIDENHAIN)",
    create: |profile| Ok(Box::new(Lsv2::new(profile, Layer::Serial(SerialFrames::new(profile.most_repeats))))),
    ..TCP
};

/// Longest file, bytes. It stays in memory until the control has it.
const MOST_BYTES: usize = 64 << 20;
/// Largest telegram without an agreement, and over a serial line, bytes.
const PLAIN: usize = 256;
const PLAIN_SERIAL: usize = 128;
/// Bytes of a telegram beside its data, and those that stay free.
const BESIDE: usize = 10;
/// Buffers that a control can be asked for (`C_CC`): size in bytes and number, largest first.
const BUFFERS: [(usize, u16); 5] = [(4096, 7), (3072, 6), (2048, 5), (1024, 3), (512, 4)];
/// Number of `C_CC` after which the end of a file is answered.
const ANSWERS_END: u16 = 19;
/// Interval of questions while the control waits or runs, and time between two positions before the file is sent.
const ASK_EVERY: Duration = Duration::from_millis(250);
const STANDS_FOR: Duration = Duration::from_millis(500);
/// Maximum number of unasked messages (`M_…`).
const MOST_MESSAGES: u32 = 1000;
/// Bytes that the control may send beyond the file, until the comparison ends.
const SURPLUS: usize = 65_536;

/// Layer below the telegrams.
#[derive(Debug)]
enum Layer {
    Tcp(TcpTelegrams),
    Serial(SerialFrames),
}

/// Question or command that waits for its answer, or a state without one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Inspect,
    Version,
    Parameters,
    Buffer(usize),
    AnswersEnd,
    Dnc,
    Status,
    Mode,
    Selected,
    Position,
    /// Waits before the second position.
    Standing,
    SecondPosition,
    File,
    Exists,
    /// Takes lines.
    Taking,
    Remove,
    Begin,
    Block,
    End,
    Read,
    /// Waits before the next question of a run.
    Resting,
    /// Deletes a file that must not stay.
    Discard,
    Logout,
    Closed,
    Over,
}

struct Lsv2 {
    layer: Layer,
    step: Step,
    asked: Duration,
    messages: u32,
    patience: Duration,
    longest_line: usize,
    refused: Vec<u8>,
    options: FileOptions,
    path: String,
    end_of_block: Vec<u8>,
    trailer: Vec<u8>,
    /// Largest telegram that the profile allows, and that is agreed, bytes.
    most_telegram: usize,
    telegram: usize,
    /// True if the control answers the end of a file.
    answers_end: bool,
    /// The file, the places at which its lines end, and the places up to which it was sent and was answered.
    file: Vec<u8>,
    ends: Vec<usize>,
    sent: usize,
    answered: usize,
    acknowledged: u64,
    read_back: ReadBack,
    /// True if a file with this path exists on the control.
    exists: bool,
    /// True if the control answers the question for positions.
    has_position: bool,
    seen: ControlReports,
    run: FileRun,
    /// True after all questions before the file.
    was_opened: bool,
    /// True while a part of the file may be on the control.
    has_begun: bool,
    /// True after the whole file was compared: from then on a person may start it.
    is_ready: bool,
    is_stopped: bool,
    is_cut: bool,
    /// Reason of the end, while the file is deleted.
    why: Option<String>,
}

impl Lsv2 {
    fn new(profile: &Profile, layer: Layer) -> Lsv2 {
        let is_serial = matches!(layer, Layer::Serial(_));
        let plain = if is_serial { PLAIN_SERIAL } else { PLAIN };
        let path = profile.file.path.clone().unwrap_or_default();
        Lsv2 {
            layer,
            step: Step::Inspect,
            asked: Duration::ZERO,
            messages: 0,
            patience: profile.answer_within,
            longest_line: profile.longest_line,
            refused: profile.refused.clone(),
            options: profile.file.clone(),
            path,
            end_of_block: profile.frame.end_of_block.clone(),
            trailer: profile.frame.trailer.clone(),
            most_telegram: if is_serial { plain } else { profile.window.bytes },
            telegram: plain,
            answers_end: false,
            file: profile.frame.start.clone(),
            ends: Vec::new(),
            sent: 0,
            answered: 0,
            acknowledged: 0,
            read_back: ReadBack::new(profile.file.is_binary),
            exists: false,
            has_position: true,
            seen: ControlReports::default(),
            run: FileRun::new(profile.patience),
            was_opened: false,
            has_begun: false,
            is_ready: false,
            is_stopped: false,
            is_cut: false,
            why: None,
        }
    }

    fn send_telegram(&mut self, name: [u8; 4], data: Vec<u8>, now: Duration, wire: &mut Wire) {
        let telegram = Telegram::new(name, data);
        match &mut self.layer {
            Layer::Tcp(_) => TcpTelegrams::send(&telegram, wire),
            Layer::Serial(line) => line.send(telegram, now, wire),
        }
        self.asked = now;
    }

    /// Path of the file as a text of a telegram, with or without the mode of the transfer.
    fn named(&self, with_mode: bool) -> Vec<u8> {
        let mut data = zeroed(&self.path);
        data.extend(with_mode.then_some(u8::from(self.options.is_binary)));
        data
    }

    /// Asks the question of a step.
    fn ask(&mut self, step: Step, now: Duration, wire: &mut Wire) {
        self.step = step;
        let (name, data) = match step {
            Step::Inspect => (*b"A_LG", zeroed("INSPECT")),
            Step::Version => (*b"R_VR", Vec::new()),
            Step::Parameters => (*b"R_PR", Vec::new()),
            Step::Buffer(size) => {
                let number = BUFFERS.iter().find(|(known, _)| *known == size).map_or(0, |(_, number)| *number);
                (*b"C_CC", number.to_be_bytes().to_vec())
            }
            Step::AnswersEnd => (*b"C_CC", ANSWERS_END.to_be_bytes().to_vec()),
            Step::Dnc => (*b"A_LG", zeroed("DNC")),
            Step::Status => (*b"R_RI", decode::STATUS.to_be_bytes().to_vec()),
            Step::Mode => (*b"R_RI", decode::MODE.to_be_bytes().to_vec()),
            Step::Selected => (*b"R_RI", decode::SELECTED.to_be_bytes().to_vec()),
            Step::Position | Step::SecondPosition => (*b"R_RI", decode::POSITION.to_be_bytes().to_vec()),
            Step::File => (*b"A_LG", zeroed("FILE")),
            Step::Exists => (*b"R_FI", self.named(false)),
            Step::Remove | Step::Discard => (*b"C_FD", self.named(false)),
            Step::Begin => {
                self.has_begun = true;
                (*b"C_FL", self.named(true))
            }
            Step::Block => {
                let end = self.file.len().min(self.sent + self.telegram.saturating_sub(BESIDE).max(1));
                let block = self.file.get(self.sent..end).unwrap_or_default().to_vec();
                self.sent = end;
                (*b"S_FL", block)
            }
            Step::End => (*b"T_FD", Vec::new()),
            Step::Read => {
                self.read_back = ReadBack::new(self.options.is_binary);
                (*b"R_FL", self.named(true))
            }
            Step::Logout => (*b"A_LO", Vec::new()),
            // These send nothing.
            Step::Taking => {
                self.was_opened = true;
                return;
            }
            Step::Standing | Step::Resting | Step::Closed | Step::Over => {
                self.asked = now;
                return;
            }
        };
        self.send_telegram(name, data, now, wire);
        // The job is over, and a control may close the connection. Over a serial line the telegram needs its handshake.
        if step == Step::Logout && matches!(self.layer, Layer::Tcp(_)) {
            self.step = Step::Closed;
        }
    }

    /// Ends the job. The reason says what the control may have of the file.
    fn lost(&mut self, why: &str, events: &mut Vec<Event>) {
        if self.step == Step::Logout {
            // The result does not depend on the logout.
            self.step = Step::Closed;
            return;
        }
        let before = self.why.take().filter(|why| !why.is_empty()).map_or(String::new(), |why| format!("{why}; "));
        self.step = Step::Over;
        let why = why.trim_end_matches([' ', '.']);
        events.push(Event::Lost(LossKind::Other, format!("{before}{why}; {}", self.of_file())));
    }

    /// Describes what the control has of the file.
    fn of_file(&self) -> String {
        if self.is_ready {
            format!("the control has the program {}: look there at which block it stands", self.path)
        } else if self.has_begun {
            format!("an incomplete file {} may be on the control: delete it there", self.path)
        } else {
            "the control has nothing of this program".to_owned()
        }
    }

    /// Ends the job after the file was deleted, because it must not be started.
    fn discard(&mut self, why: String, now: Duration, wire: &mut Wire) {
        self.why = Some(why);
        self.ask(Step::Discard, now, wire);
    }

    /// Describes the current step for people.
    fn doing(&self) -> String {
        match self.step {
            Step::Inspect => "the login INSPECT".into(),
            Step::Version => "the question for its version".into(),
            Step::Parameters => "the question for its parameters".into(),
            Step::Buffer(_) => "the size of telegrams".into(),
            Step::AnswersEnd => "the answer to the end of a file".into(),
            Step::Dnc => "the login DNC".into(),
            Step::Status => "the question for the state of the program".into(),
            Step::Mode => "the question for the operating mode".into(),
            Step::Selected => "the question for the selected program".into(),
            Step::Position | Step::SecondPosition => "the question for the position".into(),
            Step::File => "the login FILE".into(),
            Step::Exists => format!("the question for the file {}", self.path),
            Step::Remove | Step::Discard => format!("to delete {}", self.path),
            Step::Begin => format!("the file {}", self.path),
            Step::Block => format!("the block of the file up to byte {}", self.sent),
            Step::End => "the end of the file".into(),
            Step::Read => format!("to read {}", self.path),
            Step::Logout => "the logout".into(),
            Step::Standing | Step::Taking | Step::Resting | Step::Closed | Step::Over => "no question".into(),
        }
    }
}

/// Text of a telegram: its bytes and a zero.
fn zeroed(text: &str) -> Vec<u8> {
    let mut data = text.as_bytes().to_vec();
    data.push(0);
    data
}

impl Dialogue for Lsv2 {
    fn open(&mut self, now: Duration, wire: &mut Wire) {
        if !self.file.is_empty() {
            self.file.extend_from_slice(&self.end_of_block);
        }
        self.ask(Step::Inspect, now, wire);
    }

    fn is_open(&self) -> bool {
        self.was_opened && self.step != Step::Over
    }

    fn has_room(&self, _length: usize) -> bool {
        self.step == Step::Taking
    }

    fn send(&mut self, line: &Line, _now: Duration, _wire: &mut Wire) -> Result<(), String> {
        check_text(&line.text, self.longest_line, &self.refused)?;
        if self.file.len() + line.text.len() + self.end_of_block.len() + self.trailer.len() > MOST_BYTES {
            return Err(format!("the file would have more than {MOST_BYTES} bytes"));
        }
        self.file.extend_from_slice(&line.text);
        self.file.extend_from_slice(&self.end_of_block);
        self.ends.push(self.file.len());
        self.run.plan(line.busy());
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        for &byte in bytes {
            if matches!(self.step, Step::Over | Step::Closed) {
                return;
            }
            let found = match &mut self.layer {
                Layer::Tcp(tcp) => tcp.hear(byte),
                Layer::Serial(line) => line.hear(byte, now, wire),
            };
            match found {
                Ok(None) => {}
                Ok(Some(telegram)) => self.answer(&telegram, now, wire, events),
                Err(why) => return self.lost(&impossible(&why), events),
            }
        }
    }

    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if matches!(self.step, Step::Over | Step::Closed) {
            return;
        }
        if let Layer::Serial(line) = &mut self.layer
            && let Err(why) = line.tick(now, wire)
        {
            return self.lost(&impossible(&why), events);
        }
        let waited = now.saturating_sub(self.asked);
        match self.step {
            Step::Taking => {}
            Step::Standing if waited >= STANDS_FOR => self.ask(Step::SecondPosition, now, wire),
            Step::Resting if self.is_stopped => self.ask(Step::Logout, now, wire),
            Step::Resting if waited >= ASK_EVERY => self.ask(Step::Status, now, wire),
            Step::Standing | Step::Resting => {}
            // The job is over; its result does not depend on the logout.
            Step::Logout if waited > self.patience => self.step = Step::Closed,
            _ if waited > self.patience => {
                let what = format!("the control does not answer {} within {} s", self.doing(), self.patience.as_secs());
                self.lost(&shown_whole(&what), events);
            }
            _ => {}
        }
    }

    fn close(&mut self, now: Duration, wire: &mut Wire) {
        if self.step != Step::Taking {
            return;
        }
        if self.is_cut || self.is_stopped || self.ends.is_empty() {
            self.ask(Step::Logout, now, wire);
            return;
        }
        if !self.trailer.is_empty() {
            let trailer = std::mem::take(&mut self.trailer);
            self.file.extend_from_slice(&trailer);
            self.file.extend_from_slice(&self.end_of_block);
        }
        self.ask(if self.exists { Step::Remove } else { Step::Begin }, now, wire);
    }

    fn is_done(&self, _wire: &Wire) -> bool {
        self.step == Step::Closed
    }

    fn in_flight(&self) -> (usize, usize) {
        if self.is_ready || matches!(self.step, Step::Logout | Step::Closed | Step::Over) {
            return (0, 0);
        }
        let lines = self.ends.len().saturating_sub(self.acknowledged as usize);
        (lines, self.file.len().saturating_sub(self.answered))
    }

    fn cut(&mut self) {
        self.is_cut = true;
    }

    fn may_have_run(&self) -> bool {
        self.is_ready
    }

    fn remains(&self) -> Option<String> {
        Some(self.of_file())
    }

    fn halt(&mut self, halt: Halt, _now: Duration, _wire: &mut Wire) -> Option<String> {
        if halt != Halt::Stop {
            return None;
        }
        self.is_stopped = true;
        Some(match self.step {
            _ if self.is_ready => {
                format!(
                    "ncfix asks no more; it stops nothing: the program {} stays on the control, and runs there if it was started",
                    self.path
                )
            }
            Step::Begin | Step::Block | Step::End => format!("the incomplete file {} will be deleted", self.path),
            Step::Read => format!("the program stays on the control as {}; nothing was started", self.path),
            _ => "no file is sent".to_owned(),
        })
    }
}

/// Reason with its first characters only: a path can be long.
fn shown_whole(what: &str) -> String {
    what.split(' ').map(shown).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::PROFILES;
    use ncfix_base::source::{FileId, Source};

    fn dialogue() -> Lsv2 {
        let (name, text) = PROFILES.iter().find(|(name, _)| *name == "lsv2").unwrap();
        let profile = Profile::read(&Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()).unwrap();
        Lsv2::new(&profile, Layer::Tcp(TcpTelegrams::default()))
    }

    #[test]
    fn a_file_that_is_too_large_is_refused_at_the_line() {
        let (mut dialogue, mut wire) = (dialogue(), Wire::default());
        let line = Line { number: 1, text: b"G1 X1".to_vec(), ..Line::default() };
        dialogue.file = vec![b' '; MOST_BYTES - 7];
        assert_eq!(dialogue.send(&line, Duration::ZERO, &mut wire), Ok(()));
        assert_eq!(dialogue.file.len(), MOST_BYTES);
        assert!(dialogue.send(&line, Duration::ZERO, &mut wire).unwrap_err().contains("67108864"));
    }

    #[test]
    fn the_path_and_the_mode_follow_the_name_of_a_command() {
        // Published: the path, a zero, and 1 for a transfer of bytes.
        let mut dialogue = dialogue();
        assert_eq!(dialogue.named(true), b"TNC:\\NCFIX.PM\0\0");
        dialogue.options.is_binary = true;
        assert_eq!(dialogue.named(true), b"TNC:\\NCFIX.PM\0\x01");
        assert_eq!(dialogue.named(false), b"TNC:\\NCFIX.PM\0");
    }
}
