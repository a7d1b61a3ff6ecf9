//! Journal of a transfer: frozen lines, acknowledgements and answers, written before the bytes concerned are sent.
//!
//! One record per line, append-only: milliseconds since the start, kind of record, its words.
//!
//! ```text
//! ncfix journal 1
//! # program 5a1e… part.mpf
//! 0 T 24.125 nose                           temperature of a sensor, °C, valid from here on
//! 0 F 12 9c41f00a 37 51 X+0.0123 Z-0.0040/-0.0051   frozen: number, CRC-32 of the text, source line, element of the corrected program,
//!                                           thermal correction (mm, degrees), and that of the model if different
//! 20 O G54 100.000,100.000,-60.000          zero offsets that the control states at the start, in its unit
//! 20 P 116 [OPT:VL,100,1024]                maximum number of blocks taken and not executed, and the words of the control
//! 31 A 12                                   acknowledged, with all before it
//! 31 C 11                                   certainly taken, with all before it, by evidence other than the count of answers
//! 35 X 10                                   executed, with all before it
//! 31 L 12                                   left, with all before it, over a link without answers
//! 32 R 12                                   sent again
//! 40 E the control was reset                end of the transfer; `not started, …` if the control cannot have executed any line
//! ```
//!
//! A last line without its end was being written when the program died; it is not a record. Records reach the disk in groups. Records that the operating
//! system has accepted survive a crash of the program at once, and a crash of the computer as soon as their group is synced.

use std::collections::VecDeque;
use std::fmt::{self, Write as _};
use std::io::{self, Write};
use std::time::Duration;

use ncfix_base::geometry::AXES;

use super::dialogue::Event;
use super::{Ended, Line, Record, crc32};

/// The first line.
pub(super) const FIRST: &str = "ncfix journal 1";
/// Maximum interval between two syncs.
const GROUP: Duration = Duration::from_millis(50);
/// Decimals of axis values, mm or degrees.
const DECIMALS: usize = 4;

/// End of a journal whose job was resumed in another one.
const TAKEN_UP: &str = "taken up again in ";
/// Beginning of the end of a job if the control cannot have executed any line.
const NOT_STARTED: &str = "not started, ";

/// Keys in the head of a journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeadKey {
    /// The version of the program that wrote it.
    Version,
    /// Hash and name of the part program.
    Program,
    /// Hash and name of the machine.
    Machine,
    /// The state of the machine.
    State,
    /// Hash and name of the profile of the link.
    Link,
    /// Hash of the file of the sensors.
    Sensors,
    /// The port.
    Port,
    /// Number of lines of the job.
    Lines,
    /// The folder in which it began.
    Folder,
    /// Number of the plan by which the job was resumed.
    Resumed,
    /// Of the parts of the job before this one: last element at which they can be resumed, last one that may have been sent, last source line that was certainly
    /// executed.
    Earlier,
    /// A word of the command line.
    Argument,
}

impl HeadKey {
    const ALL: [HeadKey; 12] = [
        HeadKey::Version,
        HeadKey::Program,
        HeadKey::Machine,
        HeadKey::State,
        HeadKey::Link,
        HeadKey::Sensors,
        HeadKey::Port,
        HeadKey::Lines,
        HeadKey::Folder,
        HeadKey::Resumed,
        HeadKey::Earlier,
        HeadKey::Argument,
    ];

    /// Its word in the file.
    fn word(self) -> &'static str {
        match self {
            HeadKey::Version => "version",
            HeadKey::Program => "program",
            HeadKey::Machine => "machine",
            HeadKey::State => "state",
            HeadKey::Link => "link",
            HeadKey::Sensors => "sensors",
            HeadKey::Port => "port",
            HeadKey::Lines => "lines",
            HeadKey::Folder => "folder",
            HeadKey::Resumed => "resumed",
            HeadKey::Earlier => "earlier",
            HeadKey::Argument => "argument",
        }
    }
}

/// End of a job in a journal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JournalEnd {
    /// All lines were acknowledged, or have left.
    Done,
    /// It was resumed in the journal at this path.
    TakenUp(String),
    /// It was interrupted, for this reason.
    BrokenOff(String),
    /// It was interrupted before the control could execute any line, for this reason.
    NotStarted(String),
}

impl JournalEnd {
    fn read(text: &str) -> JournalEnd {
        match text.strip_prefix(TAKEN_UP) {
            _ if text == "done" => JournalEnd::Done,
            Some(path) => JournalEnd::TakenUp(path.to_owned()),
            None => match text.strip_prefix(NOT_STARTED) {
                Some(why) => JournalEnd::NotStarted(why.to_owned()),
                None => JournalEnd::BrokenOff(text.to_owned()),
            },
        }
    }
}

impl fmt::Display for JournalEnd {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            JournalEnd::Done => out.write_str("done"),
            JournalEnd::TakenUp(path) => write!(out, "{TAKEN_UP}{path}"),
            JournalEnd::BrokenOff(why) => out.write_str(why),
            JournalEnd::NotStarted(why) => write!(out, "{NOT_STARTED}{why}"),
        }
    }
}

/// Append-only file.
pub trait Store: Write {
    /// Writes everything to the disk.
    ///
    /// # Errors
    /// I/O errors of the file.
    fn sync(&mut self) -> io::Result<()>;
}

impl Store for std::fs::File {
    fn sync(&mut self) -> io::Result<()> {
        self.sync_data()
    }
}

impl<S: Store> Store for &mut S {
    fn sync(&mut self) -> io::Result<()> {
        (**self).sync()
    }
}

impl Store for Vec<u8> {
    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Writes a journal.
#[derive(Debug)]
pub struct Journal<S> {
    store: S,
    /// Records that were not yet passed to the operating system.
    line: String,
    synced: Duration,
    is_synced: bool,
}

impl<S: Store> Journal<S> {
    /// Begins a journal. The head contains pairs of a name and a value that must be equal when the job is restarted.
    ///
    /// # Errors
    /// I/O errors of the file.
    pub fn new(mut store: S, head: &[(HeadKey, &str)]) -> io::Result<Journal<S>> {
        let mut text = format!("{FIRST}\n");
        for (key, value) in head {
            let value: String = value.chars().map(|one| if one.is_control() { ' ' } else { one }).collect();
            let _ = writeln!(text, "# {} {value}", key.word());
        }
        store.write_all(text.as_bytes())?;
        store.sync()?;
        Ok(Journal { store, line: String::new(), synced: Duration::ZERO, is_synced: true })
    }

    /// Records how the transfer ended. `may_have_run` is false if the control cannot have executed any line.
    ///
    /// # Errors
    /// I/O errors of the file.
    pub fn end(&mut self, ended: &Ended, may_have_run: bool, now: Duration) -> io::Result<()> {
        let text = match ended {
            Ended::Done => "done".to_owned(),
            Ended::Stopped => "stopped".to_owned(),
            Ended::Lost(_, why) => format!("lost: {why}"),
            Ended::Held(why) => format!("held: {why}"),
            Ended::Fault(why) => format!("fault: {why}"),
            Ended::Refused(number, said) => format!("refused {number}: {said}"),
        };
        let begin = if may_have_run || *ended == Ended::Done { "" } else { NOT_STARTED };
        self.note(now, &format!("E {begin}{}", text.replace(['\n', '\r'], " ")));
        self.settle()?;
        self.store.sync()
    }

    fn note(&mut self, now: Duration, text: &str) {
        let _ = writeln!(self.line, "{} {text}", now.as_millis());
    }

    /// Settles the journal and returns its store.
    ///
    /// # Errors
    /// I/O errors of the file.
    pub fn into_store(mut self) -> io::Result<S> {
        self.settle()?;
        Ok(self.store)
    }
}

impl<S: Store> Record for Journal<S> {
    fn frozen(&mut self, line: &Line, now: Duration) -> io::Result<()> {
        for (sensor, temperature_c) in line.temperatures_c.iter().flat_map(|all| all.iter()) {
            self.note(now, &format!("T {temperature_c:.3} {}", sensor.replace(['\n', '\r'], " ")));
        }
        let mut text = format!("F {} {:08x} {} {}", line.number, crc32(&line.text), line.source_line, line.element);
        for axis in AXES {
            let [offset, target] = [&line.offset, &line.target].map(|of| {
                let value = of[axis.slot()];
                format!("{:+.DECIMALS$}", if axis.is_rotary() { value.to_degrees() } else { value })
            });
            let is_nothing = |text: &str| text.bytes().all(|byte| !matches!(byte, b'1'..=b'9'));
            if !is_nothing(&offset) || !is_nothing(&target) {
                let asked = if target == offset { String::new() } else { format!("/{target}") };
                let _ = write!(text, " {axis}{offset}{asked}");
            }
        }
        self.note(now, &text);
        Ok(())
    }

    fn event(&mut self, event: &Event, now: Duration) -> io::Result<()> {
        match event {
            Event::Acknowledged(number) => self.note(now, &format!("A {number}")),
            Event::Checked(number) => self.note(now, &format!("C {number}")),
            Event::Left(number) => self.note(now, &format!("L {number}")),
            Event::Repeated(number) => self.note(now, &format!("R {number}")),
            Event::Stalled => self.note(now, "W no answer in time"),
            Event::Reported(text) => self.note(now, &format!("W at {}", text.replace(['\n', '\r'], " "))),
            Event::Said(text) => self.note(now, &format!("W {}", text.replace(['\n', '\r'], " "))),
            Event::Paused(is_paused) => self.note(now, if *is_paused { "W paused" } else { "W goes on" }),
            Event::Executed(number) => self.note(now, &format!("X {number}")),
            Event::ZeroOffsets(text) => self.note(now, &format!("O {}", text.replace(['\n', '\r'], " "))),
            Event::InPosition(axes) => self.note(now, &format!("W in position {axes}")),
            Event::Holds(most, said) => self.note(now, &format!("P {most} {}", said.replace(['\n', '\r'], " "))),
            Event::Refused(..) | Event::Lost(..) => {}
        }
        Ok(())
    }

    fn settle(&mut self) -> io::Result<()> {
        if !self.line.is_empty() {
            self.is_synced = false;
            self.store.write_all(self.line.as_bytes())?;
            self.line.clear();
        }
        Ok(())
    }

    fn tick(&mut self, now: Duration) -> io::Result<()> {
        if !self.is_synced && now.saturating_sub(self.synced) >= GROUP {
            self.store.sync()?;
            (self.synced, self.is_synced) = (now, true);
        }
        Ok(())
    }
}

/// Line as recorded in a journal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Frozen {
    /// Its number in the transfer.
    pub number: u64,
    /// Checksum of its text.
    pub crc: u32,
    /// Source line.
    pub source_line: u32,
    /// Element of the corrected program.
    pub element: u64,
}

/// Number of acknowledged lines that are kept. Planners have at most 1000 blocks (grblHAL, $398), with lines without motion in between.
const KEPT: u64 = 8192;

/// Content of a journal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JournalContents {
    /// The head.
    pub head: Vec<(HeadKey, String)>,
    /// The last line that was frozen: it and all before it may have been sent.
    pub frozen: u64,
    /// The last line that was acknowledged: it and all before it were taken.
    pub acknowledged: u64,
    /// The last line that was certainly taken: evidence other than the count of answers shows it.
    pub checked: u64,
    /// The last line that was executed, if the control reported it.
    pub executed: u64,
    /// The lines after the last acknowledged one, and the last lines before them, in order.
    pub lines: VecDeque<Frozen>,
    /// The last line that went out over a link without answers. It, and as many lines before it as fit the buffer of the control, may not have been executed.
    pub left: u64,
    /// Maximum number of blocks that the control may have taken and not executed, and its words; `None` if it stated nothing.
    pub holds: Option<(u64, String)>,
    /// Zero offsets that the control stated at the start; `None` if it stated nothing.
    pub zero_offsets: Option<String>,
    /// End of the transfer; `None` if the program died.
    pub ended: Option<JournalEnd>,
}

/// Reads a journal.
///
/// # Errors
/// The number of the line that is not a valid record, and the reason.
pub fn read(text: &str) -> Result<JournalContents, (usize, String)> {
    let mut told = JournalContents::default();
    let whole = text.rfind('\n').map_or("", |end| text.get(..end).unwrap_or_default());
    for (number, line) in (1..).zip(whole.split('\n')) {
        let fault = |why: &str| Err((number, why.to_owned()));
        if number == 1 {
            if line != FIRST {
                return fault("this is not a journal");
            }
            continue;
        }
        if let Some(head) = line.strip_prefix("# ") {
            let (name, value) = head.split_once(' ').unwrap_or((head, ""));
            // Additional keys of another version are information for people.
            let key = HeadKey::ALL.into_iter().find(|key| key.word() == name);
            told.head.extend(key.map(|key| (key, value.to_owned())));
            continue;
        }
        let mut words = line.splitn(3, ' ');
        let (_, Some(what)) = (words.next(), words.next()) else { return fault("a record without its kind") };
        let rest = words.next().unwrap_or_default();
        let mut rest_words = rest.split(' ');
        let first = rest_words.next().and_then(|word| word.parse::<u64>().ok());
        match (what, first) {
            ("F", Some(line_number)) => {
                let crc = rest_words.next().and_then(|word| u32::from_str_radix(word, 16).ok());
                let source_line = rest_words.next().and_then(|word| word.parse().ok());
                let element = rest_words.next().and_then(|word| word.parse().ok());
                let (Some(crc), Some(source_line), Some(element)) = (crc, source_line, element) else {
                    return fault("a frozen line without checksum or place");
                };
                if line_number != told.frozen + 1 {
                    return fault("a frozen line that does not follow the one before it");
                }
                told.frozen = line_number;
                told.lines.push_back(Frozen { number: line_number, crc, source_line, element });
            }
            ("A", Some(line_number)) => {
                if line_number > told.frozen {
                    return fault("an answer to a line that was not sent");
                }
                told.acknowledged = told.acknowledged.max(line_number);
                while told.lines.front().is_some_and(|line| line.number + KEPT < told.acknowledged) {
                    told.lines.pop_front();
                }
            }
            ("C", Some(line_number)) => {
                if line_number > told.frozen {
                    return fault("a line was accepted that was not sent");
                }
                told.checked = told.checked.max(line_number);
            }
            ("X", Some(line_number)) => {
                if line_number > told.frozen {
                    return fault("a line was executed that was not sent");
                }
                told.executed = told.executed.max(line_number);
            }
            ("P", Some(most)) => {
                let said = rest.split_once(' ').map_or("", |(_, said)| said).to_owned();
                // The largest number ever stated.
                told.holds = told.holds.take().filter(|(known, _)| *known >= most).or(Some((most, said)));
            }
            ("L", Some(line_number)) => {
                if line_number > told.frozen {
                    return fault("a line was transmitted that was not sent");
                }
                told.left = told.left.max(line_number);
            }
            ("E", _) => {
                // The lines after it were answered while the axes were held; the refused line was not executed.
                let refused =
                    rest.strip_prefix("refused ").and_then(|rest| rest.split(':').next()?.parse::<u64>().ok());
                if let Some(refused) = refused {
                    let before = refused.saturating_sub(1);
                    told.acknowledged = told.acknowledged.min(before);
                    told.checked = told.checked.min(before);
                    told.executed = told.executed.min(before);
                }
                told.ended = Some(JournalEnd::read(rest));
            }
            ("O", _) => told.zero_offsets = Some(rest.to_owned()),
            ("R" | "W" | "T", _) => {}
            _ => return fault("a record of an unknown kind"),
        }
    }
    if whole.is_empty() { Err((1, "this is not a journal".to_owned())) } else { Ok(told) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::dialogue::LossKind;

    fn line(number: u64) -> Line {
        let mut line = Line {
            number,
            text: format!("G1 X{number}").into_bytes(),
            source_line: 40 + number as u32,
            element: 2 * number,
            ..Line::default()
        };
        line.offset[2] = -0.004;
        line
    }

    #[test]
    fn what_was_written_is_read_again_up_to_the_death_of_the_program() {
        let mut journal = Journal::new(Vec::new(), &[(HeadKey::Program, "5a1e part.mpf")]).unwrap();
        let at = Duration::from_millis;
        for number in 1..=5 {
            journal.frozen(&line(number), at(number)).unwrap();
        }
        journal.event(&Event::Acknowledged(2), at(9)).unwrap();
        journal.event(&Event::Holds(31, "[OPT:V,15,128]".into()), at(9)).unwrap();
        journal.event(&Event::Holds(20, "less".into()), at(9)).unwrap();
        journal.event(&Event::Checked(2), at(9)).unwrap();
        journal.event(&Event::Executed(1), at(10)).unwrap();
        journal.event(&Event::Left(4), at(9)).unwrap();
        journal.event(&Event::Repeated(3), at(10)).unwrap();
        let text = String::from_utf8(journal.into_store().unwrap()).unwrap();
        assert!(text.contains("3 F 3 ") && text.contains(" 43 6 Z-0.0040/+0.0000\n"), "{text}");
        let told = read(&text).unwrap();
        assert_eq!((told.frozen, told.acknowledged, told.checked, told.executed), (5, 2, 2, 1));
        assert_eq!(told.lines.iter().map(|line| line.number).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
        assert_eq!(told.lines[2], Frozen { number: 3, crc: crc32(b"G1 X3"), source_line: 43, element: 6 });
        assert_eq!((told.left, told.holds.clone()), (4, Some((31, "[OPT:V,15,128]".to_owned()))));
        assert_eq!((told.head[0].0, told.ended.clone()), (HeadKey::Program, None));
        // Died in the middle of a record: wherever that is, the records before it remain.
        for end in text.find("1 F").unwrap()..text.len() {
            let told = read(&text[..end]).unwrap();
            assert!(told.frozen <= 5 && told.acknowledged <= told.frozen);
        }
    }

    #[test]
    fn a_job_that_did_not_start_says_so() {
        let ended = |ended: &Ended, may_have_run| {
            let mut journal = Journal::new(Vec::new(), &[]).unwrap();
            journal.frozen(&line(1), Duration::ZERO).unwrap();
            journal.end(ended, may_have_run, Duration::ZERO).unwrap();
            read(&String::from_utf8(journal.into_store().unwrap()).unwrap()).unwrap().ended
        };
        let lost = Ended::Lost(LossKind::Other, "no free space".into());
        assert_eq!(ended(&lost, false), Some(JournalEnd::NotStarted("lost: no free space".into())));
        assert_eq!(ended(&lost, true), Some(JournalEnd::BrokenOff("lost: no free space".into())));
        assert_eq!(ended(&Ended::Done, false), Some(JournalEnd::Done));
    }

    #[test]
    fn what_is_no_journal_is_refused_with_its_line() {
        assert_eq!(read("").unwrap_err().0, 1);
        assert_eq!(read("G1 X0\n").unwrap_err().0, 1);
        let twice = format!("{FIRST}\n0 F 1 00000000 1 1\n1 F 1 00000000 1 1\n");
        assert_eq!(read(&twice).unwrap_err().0, 3);
        assert_eq!(read(&format!("{FIRST}\n0 A 7\n")).unwrap_err().0, 2);
        assert_eq!(read(&format!("{FIRST}\n0 L 7\n")).unwrap_err().0, 2);
        assert_eq!(read(&format!("{FIRST}\n0 P many\n")).unwrap_err().0, 2);
        // Without a stated depth the number of held blocks is unknown.
        assert_eq!(read(&format!("{FIRST}\n0 F 1 00000000 1 1\n9 A 1\n")).unwrap().holds, None);
    }
}
