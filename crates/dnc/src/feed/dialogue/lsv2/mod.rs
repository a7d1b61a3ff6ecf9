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
mod read_back;
mod run;
mod serial;
mod telegram;

use std::time::Duration;

use self::decode::{NO_FILE, ProgramState, SelectedProgram, TelegramRefusal};
use self::read_back::ReadBack;
use self::run::{ControlReports, FileRun, RunVerdict};
use self::serial::SerialFrames;
use self::telegram::{TcpTelegrams, Telegram};
use super::answers::{impossible, shown};
use super::{Dialogue, Event, Halt, Line, Profile, Protocol, Wire, check_text};
use crate::feed::profile::FileOptions;

/// Entry of the dialogue over TCP; profiles select it by its name.
pub(super) const TCP: Protocol = Protocol {
    name: "lsv2",
    title: "LSV/2 over TCP: the program as one file (HEIDENHAIN)",
    asks_idle: true,
    sends_file: true,
    has_planner: false,
    beyond: 0,
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
        events.push(Event::Lost(format!("{before}{why}; {}", self.of_file())));
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

    fn answer(&mut self, telegram: &Telegram, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if telegram.name.starts_with(b"M_") && self.messages < MOST_MESSAGES {
            // Messages need no answer, and are not answers.
            self.messages += 1;
            return;
        }
        if let Some(refusal) = TelegramRefusal::read(telegram) {
            return self.refuse(refusal, now, wire, events);
        }
        let is_ok = telegram.name == *b"T_OK" && telegram.data.is_empty();
        let data = |name: &[u8; 4]| (telegram.name == *name).then_some(&telegram.data[..]);
        let is_known = match self.step {
            Step::Inspect if is_ok => Some(self.ask(Step::Version, now, wire)),
            Step::Version => data(b"S_VR").map(|data| {
                events.push(Event::Said(format!("control {}", decode::version(data))));
                let next = if matches!(self.layer, Layer::Tcp(_)) { Step::Parameters } else { Step::AnswersEnd };
                self.ask(next, now, wire);
            }),
            // Parameters of another length state no size: telegrams stay small.
            Step::Parameters => {
                data(b"S_PR").map(|data| self.agree(decode::block_length(data).unwrap_or_default(), now, wire))
            }
            Step::Buffer(size) if is_ok => {
                self.telegram = size;
                Some(self.ask(Step::AnswersEnd, now, wire))
            }
            Step::AnswersEnd if is_ok => {
                self.answers_end = true;
                Some(self.ask_rights(now, wire))
            }
            Step::Dnc if is_ok => Some(self.ask(Step::Status, now, wire)),
            Step::Status => data(b"S_RI").and_then(ProgramState::read).map(|state| {
                self.seen.state = Some(state);
                self.hear_state(state, now, wire, events);
            }),
            Step::Mode => data(b"S_RI").and_then(decode::mode).map(|(mode, why)| {
                self.seen.mode = mode;
                match why {
                    Some(why) => self.lost(&format!("the control is in the mode {mode}: {why}"), events),
                    None => self.ask(Step::Selected, now, wire),
                }
            }),
            Step::Selected => data(b"S_RI").and_then(SelectedProgram::read).map(|selected| {
                self.hear_selected(selected, now, wire, events);
            }),
            Step::Position | Step::SecondPosition => data(b"S_RI").and_then(decode::position).map(|position| {
                let before = std::mem::replace(&mut self.seen.position, position);
                let moved = decode::has_moved(&before, &self.seen.position);
                self.hear_position(moved, now, wire, events);
            }),
            Step::File if is_ok => Some(self.ask(Step::Exists, now, wire)),
            Step::Exists => data(b"S_FI").map(|_| self.hear_exists(now, wire, events)),
            Step::Remove if is_ok => Some(self.ask(Step::Begin, now, wire)),
            Step::Begin if is_ok => Some(self.ask(Step::Block, now, wire)),
            Step::Block if is_ok => Some(self.hear_block(now, wire, events)),
            Step::End if is_ok => Some(self.hear_end(now, wire)),
            Step::Read => match data(b"S_FL") {
                Some(bytes) => Some(self.hear_file(bytes, now, wire, events)),
                None => data(b"T_FD").filter(|data| data.is_empty()).map(|_| self.compare(now, wire, events)),
            },
            Step::Discard if is_ok => Some(self.discarded(None, now, wire, events)),
            Step::Logout if is_ok => Some(self.step = Step::Closed),
            _ => None,
        };
        if is_known.is_none() {
            let size = telegram.data.len();
            let what = format!("{} with {size} bytes is not an answer to {}", telegram.shown(), self.doing());
            self.lost(&impossible(&what), events);
        }
    }

    /// Handles a refusal of the current step.
    fn refuse(&mut self, refusal: TelegramRefusal, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let why = refusal.words();
        match self.step {
            // Without them the transfer is slower, or the end of the file is not answered.
            Step::Parameters => self.ask(Step::AnswersEnd, now, wire),
            Step::Buffer(_) => self.ask(Step::AnswersEnd, now, wire),
            Step::AnswersEnd => self.ask_rights(now, wire),
            Step::Version => {
                let next = if matches!(self.layer, Layer::Tcp(_)) { Step::Parameters } else { Step::AnswersEnd };
                self.ask(next, now, wire);
            }
            Step::Position | Step::SecondPosition => {
                self.has_position = false;
                self.seen.position.clear();
                events.push(Event::Said(format!("no positions: {why}")));
                if self.is_ready { self.judge(now, wire, events) } else { self.ask(Step::File, now, wire) }
            }
            // No program is selected.
            Step::Selected => self.hear_selected(SelectedProgram::default(), now, wire, events),
            Step::Exists if refusal.number == NO_FILE => self.ask(Step::Taking, now, wire),
            Step::Dnc => {
                let help = "its state cannot be asked. The control needs the option for DNC (18), and external access must be on. With watch = false in [file] of your own link file ncfix only transfers the file";
                self.lost(&format!("the control refuses the login DNC: {why}; {help}"), events);
            }
            Step::Block | Step::End => {
                self.discard(format!("the control refuses {}: {why}", self.doing()), now, wire);
            }
            Step::Read if !self.is_ready => {
                self.discard(format!("the file cannot be read back: {why}"), now, wire);
            }
            Step::Discard => self.discarded(Some(why), now, wire, events),
            Step::Logout => self.step = Step::Closed,
            Step::Taking | Step::Standing | Step::Resting | Step::Closed | Step::Over => {
                let what = format!("the control refuses something that it was not asked ({why})");
                self.lost(&impossible(&what), events);
            }
            _ => self.lost(&format!("the control refuses {}: {why}", self.doing()), events),
        }
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

    /// Agrees on the size of telegrams.
    fn agree(&mut self, most: usize, now: Duration, wire: &mut Wire) {
        let most = most.min(self.most_telegram);
        match BUFFERS.iter().find(|(size, _)| *size <= most) {
            Some((size, _)) => self.ask(Step::Buffer(*size), now, wire),
            None => self.ask(Step::AnswersEnd, now, wire),
        }
    }

    fn ask_rights(&mut self, now: Duration, wire: &mut Wire) {
        self.ask(if self.options.watches { Step::Dnc } else { Step::File }, now, wire);
    }

    fn hear_state(&mut self, state: ProgramState, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.is_ready {
            self.ask(Step::Selected, now, wire);
        } else if state.is_at_rest() {
            self.ask(Step::Mode, now, wire);
        } else {
            let help = "let it end, or cancel it there";
            self.lost(&format!("the control is not idle ({}): {help}", state.words()), events);
        }
    }

    fn hear_selected(&mut self, selected: SelectedProgram, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.seen.selected = selected;
        match (self.has_position, self.is_ready) {
            (true, _) => self.ask(Step::Position, now, wire),
            (false, true) => self.judge(now, wire, events),
            (false, false) => self.ask(Step::File, now, wire),
        }
    }

    fn hear_position(&mut self, moved: bool, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.is_ready {
            self.judge(now, wire, events);
        } else if self.step == Step::Position {
            self.ask(Step::Standing, now, wire);
        } else if moved {
            self.lost("the axes move although no program runs: wait until they stand still", events);
        } else {
            self.ask(Step::File, now, wire);
        }
    }

    fn hear_exists(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.exists = true;
        if self.options.replaces {
            self.ask(Step::Taking, now, wire);
            return;
        }
        let why = format!(
            "the file {} exists on the control: delete it there, give another path with --to, or set replace = true in [file] of your own link file",
            self.path
        );
        self.lost(&why, events);
    }

    /// Handles the answer to a block.
    fn hear_block(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.answered = self.sent;
        let count = self.ends.partition_point(|end| *end <= self.answered) as u64;
        if count > self.acknowledged {
            self.acknowledged = count;
            events.push(Event::Acknowledged(count));
        }
        if self.sent < self.file.len() && !self.is_stopped {
            self.ask(Step::Block, now, wire);
            return;
        }
        self.ask(Step::End, now, wire);
        if !self.answers_end {
            self.hear_end(now, wire);
        }
    }

    fn hear_end(&mut self, now: Duration, wire: &mut Wire) {
        if self.sent < self.file.len() {
            self.discard(String::new(), now, wire);
        } else {
            self.ask(Step::Read, now, wire);
        }
    }

    /// Handles a block of the file that is read back.
    fn hear_file(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.read_back.take(bytes, &self.file);
        if self.read_back.count() > self.file.len() + SURPLUS || bytes.is_empty() {
            return self.lost("the file that is read back does not end", events);
        }
        self.send_telegram(*b"T_OK", Vec::new(), now, wire);
    }

    /// Compares the file that was read back.
    fn compare(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let difference = self.read_back.finish(&self.file);
        match (difference, self.is_ready) {
            (Some(difference), false) => {
                let why = format!("the file on the control differs from the program: {difference}");
                self.discard(why, now, wire);
            }
            (Some(difference), true) => {
                let why = format!(
                    "the program has finished, but its file on the control was changed: {difference}. It is not certain that the corrected lines were executed"
                );
                self.lost(&why, events);
            }
            (None, false) => {
                self.is_ready = true;
                events.push(Event::Checked(self.acknowledged));
                let what =
                    format!("the control has the program as {}, and it was read back without a difference", self.path);
                if !self.options.watches || self.is_stopped {
                    events.push(Event::Said(what));
                    self.ask(Step::Logout, now, wire);
                    return;
                }
                events.push(Event::Said(format!("{what}: select it there and start it; ncfix starts nothing")));
                self.run.wait(now);
                self.ask(Step::Resting, now, wire);
            }
            (None, true) => {
                events.push(Event::Executed(self.acknowledged));
                self.ask(Step::Logout, now, wire);
            }
        }
    }

    /// Ends the job after the file was deleted, or could not be deleted.
    fn discarded(&mut self, refusal: Option<String>, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.has_begun = refusal.is_some();
        let of_file = match refusal {
            None => format!("the incomplete or wrong file {} was deleted", self.path),
            Some(why) => {
                format!("the incomplete or wrong file {} could not be deleted ({why}): delete it there", self.path)
            }
        };
        let why = self.why.take().unwrap_or_default();
        if why.is_empty() {
            events.push(Event::Said(of_file));
            self.ask(Step::Logout, now, wire);
        } else {
            self.step = Step::Over;
            events.push(Event::Lost(format!("{why}; {of_file}")));
        }
    }

    /// Evaluates what the control reports of the run.
    fn judge(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        events.push(Event::Reported(self.seen.words()));
        match self.run.look(&self.seen, &self.path, now) {
            RunVerdict::Continues(None) => self.ask(Step::Resting, now, wire),
            RunVerdict::Continues(Some(said)) => {
                events.push(Event::Said(said));
                self.ask(Step::Resting, now, wire);
            }
            RunVerdict::Ended => self.ask(Step::Read, now, wire),
            RunVerdict::Lost(why) => self.lost(&why, events),
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
