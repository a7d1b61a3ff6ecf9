//! LinuxCNC over linuxcncrsh: every line is an MDI command; the next one is sent when it is done.
//!
//! `set mdi` is answered as soon as it is received. Then the control is asked for its status until it is idle. `set wait done` says whether the line was
//! executed (emcrsh.cc, shcom.cc, emctaskmain.cc of 2.9). More lines could wait in the control. But after an error it discards them and takes the next one
//! as if nothing had happened: an unnoticed gap. So only one line is under way, and the axes stop between two lines.
//!
//! A person or another program may abort a line at the control; the control then reports the line as done. This is detected if the machine or its mode
//! changed, if the turning spindle stopped, if the line took far less time than it can, or if the control is not at the end of the line ([`place`]). Nothing
//! here switches the machine on or homes it: that is left to a person at the machine.

mod hear;
mod place;

use std::collections::VecDeque;
use std::time::Duration;

use super::answers::Answers;
use super::greeting::{self, Reply};
use super::mdi::{Words, words};
use super::position::{CommandedPosition, PositionComparison, elsewhere};
use super::zeros::{ZeroSource, ZeroWatch};
use super::{Dialogue, Event, ExpectedZero, Halt, Line, LossKind, Profile, Protocol, Wire, check_text};
use place::StatedPlace;

/// Entry of this dialogue; profiles select it by its name.
pub(super) const PROTOCOL: Protocol = Protocol {
    name: "linuxcncrsh",
    title: "MDI, one line after the other (LinuxCNC)",
    asks_idle: true,
    sends_file: false,
    has_planner: false,
    beyond: 0,
    rewrite: None,
    check,
    create,
};

/// Longest line, bytes. The command buffer of the control has 256 bytes without an overflow check; this remains after `set mdi `.
const LONGEST: usize = 247;
/// Interval of status questions while a line runs.
const ASK_EVERY: Duration = Duration::from_millis(20);
/// Number of stalls after which the control is considered gone.
const MOST_STALLS: u32 = 3;
/// Maximum number of messages that are read before the first line and after each line.
const MOST_MESSAGES: usize = 32;
/// A line that should take longer than this and is done in a quarter of its time was aborted.
const NOTICED: Duration = Duration::from_secs(1);
/// Command before the first line: only a comment, which shows that MDI is accepted.
const TRIAL: &[u8] = b"(ncfix)";
/// Questions after a line; the answer to the last one ends the exchange.
const CHECKS: &[u8] = b"set wait done\r\nget enable\r\nget machine\r\nget mode\r\nget spindle 0\r\nget abs_cmd_pos\r\nget rel_cmd_pos\r\nget error\r\n";
/// Number of answers to [`CHECKS`] before the positions, the questions for them again, and how often they are asked.
const BEFORE_PLACE: usize = 5;
const PLACE_AGAIN: &[u8] = b"get abs_cmd_pos\r\nget rel_cmd_pos\r\nget error\r\n";
const MOST_LOOKS: u32 = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Number of greeting steps that were answered.
    Opening(usize),
    Open,
    /// The last line was sent.
    Closed,
    /// A person has aborted the job.
    Broken,
    Over,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Nothing of it is sent: a blank line, or a `%`.
    Nothing,
    Sent,
    Running,
    Checking,
    /// The printed parameters are awaited.
    Showing,
}

struct UnderWay {
    number: u64,
    stage: Stage,
    length: usize,
    since: Duration,
    busy: Duration,
    words: Words,
    /// True if the control has received the line; true if it reports the line as executed.
    is_received: bool,
    is_done: bool,
    /// Number of answered questions after the line.
    answered: usize,
    /// True if the line prints parameters.
    is_asking: bool,
}

struct Rsh {
    state: State,
    passwords: (String, String),
    longest_line: usize,
    patience: Duration,
    under_way: Option<UnderWay>,
    heard: Answers,
    last_heard: Duration,
    asked: Duration,
    /// True if the answer to the last question is still to come.
    is_asked: bool,
    is_paused: bool,
    seen: Seen,
    messages: Vec<String>,
    has_ended: bool,
    /// Number of consecutive timeouts.
    stalls: u32,
    zero: ZeroWatch,
    /// Lines that print parameters, before the first line of the program.
    questions: VecDeque<Vec<u8>>,
    commanded: CommandedPosition,
    place: StatedPlace,
    /// Number of positions that differed, and the axes of the last one that agreed.
    looks: u32,
    agreed: Option<String>,
    /// Number of messages of other programs before the first line.
    others: usize,
}

/// Last reported state of the control.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    is_ours: bool,
    is_on: bool,
    is_mdi: bool,
    turns: bool,
    /// True if the spindle was turning before the line.
    turned: bool,
}

fn create(profile: &Profile) -> Result<Box<dyn Dialogue>, String> {
    if profile.window.lines > 1 {
        return Err("after an error LinuxCNC continues with the next line: write lines = 1 under [window]".into());
    }
    let text = String::from_utf8_lossy(&profile.frame.start).into_owned();
    let mut words = text.split_ascii_whitespace().map(str::to_owned);
    let passwords = (words.next().unwrap_or("EMC".into()), words.next().unwrap_or("EMCTOO".into()));
    Ok(Box::new(Rsh {
        state: State::Opening(0),
        passwords,
        longest_line: profile.longest_line.min(LONGEST),
        patience: profile.answer_within,
        under_way: None,
        heard: Answers::default(),
        last_heard: Duration::ZERO,
        asked: Duration::ZERO,
        is_asked: false,
        is_paused: false,
        seen: Seen::default(),
        messages: Vec::new(),
        has_ended: false,
        stalls: 0,
        zero: ZeroWatch::new(ZeroSource::LinuxCnc),
        questions: VecDeque::new(),
        commanded: CommandedPosition::default(),
        place: StatedPlace::default(),
        looks: 0,
        agreed: None,
        others: 0,
    }))
}

impl Rsh {
    fn say(&mut self, text: &[u8], now: Duration, wire: &mut Wire) {
        wire.push(text);
        wire.push(b"\r\n");
        self.last_heard = now;
    }

    /// Asks the question of the next step before the first line; after the last step a trial line is executed.
    fn ask_step(&mut self, step: usize, now: Duration, wire: &mut Wire) {
        self.state = State::Opening(step);
        match greeting::question(step, &self.passwords) {
            Some(text) => self.say(text.as_bytes(), now, wire),
            None => self.send_line(0, TRIAL, Duration::ZERO, now, wire),
        }
    }

    fn answer_step(&mut self, step: usize, answer: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if let Some(unit) = answer.strip_prefix("USER_LINEAR_UNITS ") {
            self.place.unit_mm = place::unit_mm(unit);
        }
        match greeting::answer(step, answer) {
            Reply::Next(next) => self.ask_step(next, now, wire),
            Reply::Message(_) if self.messages.len() >= MOST_MESSAGES => {
                self.lost("its messages do not end: look at its screen", events);
            }
            Reply::Message(text) => {
                events.push(Event::Said(text.to_owned()));
                self.messages.push(text.to_owned());
                self.ask_step(step, now, wire);
            }
            Reply::Refusal(why) => self.lost(why, events),
            // The control echoes its input until echo is off.
            Reply::Other
                if step < 2 || answer.is_empty() || answer.starts_with("error:") || answer.starts_with("warning:") => {}
            Reply::Other => self.is_none(answer, events),
        }
    }

    fn send_line(&mut self, number: u64, text: &[u8], busy: Duration, now: Duration, wire: &mut Wire) {
        let words = words(text);
        self.messages.clear();
        let stage = if words.is_empty || text.trim_ascii() == b"%" { Stage::Nothing } else { Stage::Sent };
        if stage == Stage::Sent {
            let bytes = [b"set mdi ", text].concat();
            self.say(&bytes, now, wire);
        }
        self.seen.turned = self.seen.turns;
        self.is_asked = false;
        let length = text.len();
        self.under_way = Some(UnderWay {
            number,
            stage,
            length,
            since: now,
            busy,
            words,
            is_received: true,
            is_done: true,
            answered: 0,
            is_asking: number == 0 && text != TRIAL,
        });
    }

    fn ask(&mut self, now: Duration, wire: &mut Wire) {
        wire.push(b"get program_status\r\n");
        (self.asked, self.is_asked) = (now, true);
    }

    fn pause(&mut self, is_paused: bool, events: &mut Vec<Event>) {
        if std::mem::replace(&mut self.is_paused, is_paused) != is_paused {
            events.push(Event::Paused(is_paused));
        }
    }

    /// Evaluates the line under way once all its answers have come.
    fn conclude(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let Some(line) = self.under_way.take() else { return };
        let said = std::mem::take(&mut self.messages).join("; ");
        let which =
            if line.number == 0 { "before the first line".to_owned() } else { format!("in line {}", line.number) };
        let before = if line.words.starts_spindle { true } else { self.seen.turned && !line.words.has_other_m };
        let took = now.saturating_sub(line.since);
        if !self.seen.is_ours {
            self.lost(&format!("another client of linuxcncrsh took over the control {which}. {said}"), events);
        } else if !self.seen.is_on {
            self.lost(&format!("the machine was switched off {which}. {said}"), events);
        } else if !self.seen.is_mdi {
            self.lost(&format!("the mode was changed at the control {which}. {said}"), events);
        } else if !said.is_empty() || !line.is_received || !line.is_done && !line.words.ends {
            // The end of a program is answered like an error, but without a message.
            let said = if said.is_empty() { "no reason is given".to_owned() } else { said };
            if line.number == 0 {
                self.lost(
                    &format!("MDI is not accepted: {said}. Correct this at the machine, for example by homing"),
                    events,
                );
            } else {
                self.state = State::Over;
                events.push(Event::Refused(line.number, said));
            }
        } else if before && !line.words.ends && !self.seen.turns {
            self.lost(&format!("the spindle has stopped {which}: the line was aborted at the control"), events);
        } else if line.busy > NOTICED && took < line.busy / 4 {
            let why = "ended much sooner than possible: it was aborted, or resumed, at the control";
            self.lost(&format!("line {} {why}", line.number), events);
        } else if line.number == 0 {
            self.ask_or_open(now, wire, events);
        } else if let Some(why) = self.compare_zero() {
            self.lost(&why, events);
        } else {
            match self.compare_place() {
                PositionComparison::Differs(_) if self.looks < MOST_LOOKS => {
                    self.looks += 1;
                    self.under_way = Some(UnderWay { answered: BEFORE_PLACE, ..line });
                    wire.push(PLACE_AGAIN);
                }
                PositionComparison::Differs(why) => {
                    let why = format!("{} {which}", elsewhere(&why));
                    self.lose(LossKind::AtAnotherPosition, &why, events);
                }
                compared => {
                    let agreed = if let PositionComparison::Agrees(axes) = compared { Some(axes) } else { None };
                    (self.looks, self.agreed) = (0, agreed);
                    self.has_ended |= line.words.ends;
                    events.push(Event::Acknowledged(line.number));
                    events.push(Event::Executed(line.number));
                }
            }
        }
    }

    /// Asks the next question for the zero offsets; after the last one, compares them and opens.
    fn ask_or_open(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if let Some(question) = self.questions.pop_front() {
            return self.send_line(0, &question, Duration::ZERO, now, wire);
        }
        if self.zero.is_expected() && !self.zero.is_complete() {
            events.push(Event::Said(format!(
                "the control does not print its zero offsets for ncfix, perhaps because another screen has read the message: compare {} at the control, with its rotation R, G92 and the tool length",
                self.zero.by_hand()
            )));
        }
        if let Some(why) = self.zero.begin() {
            return self.lost(&why, events);
        }
        events.extend(self.zero.stated().map(Event::ZeroOffsets));
        self.state = State::Open;
    }

    fn lost(&mut self, why: &str, events: &mut Vec<Event>) {
        self.lose(LossKind::Other, why, events);
    }

    fn lose(&mut self, kind: LossKind, why: &str, events: &mut Vec<Event>) {
        self.state = State::Over;
        events.push(Event::Lost(kind, why.trim_end_matches([' ', '.']).to_owned()));
    }
}

fn check(profile: &Profile, text: &[u8]) -> Result<(), String> {
    check_words(text, profile.longest_line).map(|_| ())
}

/// Returns the relevant words of a line; an error sentence if MDI cannot take the line.
fn check_words(text: &[u8], longest_line: usize) -> Result<Words, String> {
    check_text(text, longest_line, &[])?;
    let found = words(text);
    if found.has_o {
        return Err("linuxcncrsh does not accept O-words; write the program without subprograms".into());
    }
    if let Some(code) = found.foreign {
        return Err(format!(
            "LinuxCNC does not have G{code}: write G20 or G21 for the unit, or choose its post-processor"
        ));
    }
    if found.stops {
        // Observed with 2.9: the next line runs immediately.
        return Err(
            "in MDI LinuxCNC does not stop at M0, M1 and M60: end the program there and feed the rest later".into()
        );
    }
    Ok(found)
}

impl Dialogue for Rsh {
    fn open(&mut self, now: Duration, wire: &mut Wire) {
        self.ask_step(0, now, wire);
    }

    fn is_open(&self) -> bool {
        self.state == State::Open
    }

    fn has_room(&self, _length: usize) -> bool {
        self.state == State::Open && self.under_way.is_none()
    }

    fn send(&mut self, line: &Line, now: Duration, wire: &mut Wire) -> Result<(), String> {
        let found = check_words(&line.text, self.longest_line)?;
        if self.has_ended && !found.is_empty && line.text.trim_ascii() != b"%" {
            return Err("the program has ended before it, with M2 or M30".into());
        }
        self.follow(&line.text);
        self.send_line(line.number, &line.text, line.busy(), now, wire);
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let mut rest = bytes;
        while let Some(answer) = self.heard.next(&mut rest) {
            // A text that never ends is not a sign of life.
            (self.last_heard, self.stalls) = (now, 0);
            match self.state {
                State::Opening(step) if self.under_way.is_none() => self.answer_step(step, &answer, now, wire, events),
                State::Broken if answer.starts_with("SET ABORT") => {
                    self.lost("aborted as requested; the current line was executed in part", events);
                }
                State::Opening(_) | State::Open | State::Closed => self.answer(&answer, now, wire, events),
                State::Broken | State::Over => {}
            }
        }
    }

    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.state == State::Over {
            return;
        }
        if self.state == State::Broken && now.saturating_sub(self.last_heard) > self.patience {
            self.lost("aborted as requested, but the control does not answer: stop it there", events);
            return;
        }
        if let Some(line) = &self.under_way {
            match line.stage {
                Stage::Nothing => {
                    events.push(Event::Acknowledged(line.number));
                    events.push(Event::Executed(line.number));
                    self.under_way = None;
                    return;
                }
                Stage::Running if !self.is_asked && now.saturating_sub(self.asked) >= ASK_EVERY => self.ask(now, wire),
                _ => {}
            }
        }
        if self.state == State::Closed && self.under_way.is_none() {
            events.extend(self.agreed.take().map(Event::InPosition));
            return;
        }
        let is_waiting = self.under_way.is_some() || !matches!(self.state, State::Open | State::Closed);
        if is_waiting && now.saturating_sub(self.last_heard) > self.patience {
            self.stalls += 1;
            if self.stalls > MOST_STALLS {
                return self.lost("the control does not answer", events);
            }
            // Another question would only queue up after the previous ones.
            events.push(Event::Stalled);
            self.last_heard = now;
        }
    }

    fn close(&mut self, _now: Duration, _wire: &mut Wire) {
        if self.state == State::Open {
            self.state = State::Closed;
        }
    }

    fn is_done(&self, _wire: &Wire) -> bool {
        self.state == State::Closed && self.under_way.is_none() && self.agreed.is_none()
    }

    fn expect(&mut self, zero: ExpectedZero) {
        self.questions = place::questions(&zero.used()).into();
        self.zero.expect(zero);
    }

    fn asks_zero(&self) -> bool {
        true
    }

    fn in_flight(&self) -> (usize, usize) {
        self.under_way.as_ref().filter(|line| line.number > 0).map_or((0, 0), |line| (1, line.length))
    }

    fn halt(&mut self, halt: Halt, now: Duration, wire: &mut Wire) -> Option<String> {
        // Text after a command that has begun cannot split it.
        match halt {
            Halt::Stop => Some("no further line is sent; the current line is executed to its end".into()),
            Halt::Hold => {
                self.say(b"set pause", now, wire);
                Some(
                    "the axes stop, the spindle keeps turning; the current line continues with resume at the control"
                        .into(),
                )
            }
            Halt::Abort => {
                self.say(b"set abort", now, wire);
                self.state = State::Broken;
                Some("the axes stop in the middle of the line, the spindle is switched off; no line remains in the control".into())
            }
        }
    }
}
