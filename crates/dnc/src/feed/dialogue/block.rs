//! Heidenhain blockwise transfer (FE1, EXT): each block has a check character and is answered by ACK or NAK.
//!
//! The header is `SOH H name E ETB BCC DC1`, a block is `STX text ETB BCC`, the end is `ETX` or `EOT`. The check character is the exclusive or of all
//! characters from SOH or STX to ETB (TNC 360, user's manual, data transfer). A block that is answered by NAK is sent again, three times at most. Blocks have
//! no numbers. A block without an answer must not be sent again, as the control might carry it out twice.
//!
//! Answers of a correct control; any other answer ends the job, because the state of the control is then unknown:
//!
//! | state | answer | meaning |
//! | --- | --- | --- |
//! | the whole block has left | `ACK` | the block is stored, not necessarily executed |
//! | | `NAK` | its check character is wrong: it is sent again, up to the limit |
//! | | `DC1` | permission to continue: no effect |
//! | the block is still leaving, or none is under way | `ACK`, `NAK` | impossible: an answer came twice, or too late |
//! | any | `EOT`, `CAN` | the control has aborted the transfer |
//!
//! A false answer caused by interference just before the true one cannot be distinguished from it. The true one then arrives while the next block leaves, and
//! ends the job.

use std::time::Duration;

use super::answers::impossible;
use super::{Dialogue, Event, Halt, Line, LossKind, Profile, Protocol, Wire, check_text};

/// Entry of this dialogue; profiles select it by its name.
pub(super) const PROTOCOL: Protocol = Protocol {
    name: "block",
    title: "blocks with a check character, ACK and NAK (Heidenhain FE1)",
    asks_idle: false,
    sends_file: false,
    has_planner: false,
    beyond: 0,
    rewrite: None,
    check: |profile, text| check_text(text, profile.longest_line, &[]),
    create: |profile| Ok(Box::new(Block::new(profile))),
};

const SOH: u8 = 0x01;
const STX: u8 = 0x02;
const ETX: u8 = 0x03;
const EOT: u8 = 0x04;
const ACK: u8 = 0x06;
const DC1: u8 = 0x11;
const NAK: u8 = 0x15;
const CAN: u8 = 0x18;
const ETB: u8 = 0x17;
/// First printable character: check characters below this are control characters.
const FIRST_PRINTED: u8 = b' ';

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// The header is under way.
    Opening,
    Open,
    /// The last block was sent.
    Closing,
    Closed,
    Over,
}

struct Block {
    state: State,
    /// Name of the program in the header.
    program: Vec<u8>,
    avoids_controls: bool,
    longest_line: usize,
    patience: Duration,
    most_repeats: u32,
    /// Block under way (number, 0 for the header; bytes; duration of the block before it).
    under_way: Option<(u64, Vec<u8>, Duration)>,
    repeats: u32,
    since: Duration,
}

impl Block {
    fn new(profile: &Profile) -> Block {
        Block {
            state: State::Opening,
            program: profile.frame.start.clone(),
            avoids_controls: profile.avoids_controls,
            longest_line: profile.longest_line,
            patience: profile.answer_within,
            most_repeats: profile.most_repeats,
            under_way: None,
            repeats: 0,
            since: Duration::ZERO,
        }
    }

    /// Adds the frame and the check character to a block.
    fn frame(&self, begin: u8, text: &[u8]) -> Vec<u8> {
        let mut bytes = vec![begin];
        bytes.extend_from_slice(text);
        let sum = |bytes: &[u8]| bytes.iter().fold(ETB, |sum, byte| sum ^ byte);
        if self.avoids_controls && sum(&bytes) < FIRST_PRINTED {
            // An additional blank makes the check character printable.
            bytes.push(b' ');
        }
        let check = sum(&bytes);
        bytes.extend_from_slice(&[ETB, check]);
        bytes
    }

    fn push(&mut self, now: Duration, wire: &mut Wire) {
        if let Some((_, bytes, _)) = &self.under_way {
            wire.push(bytes);
            self.since = now;
        }
    }

    fn lost(&mut self, why: &str, events: &mut Vec<Event>) {
        self.state = State::Over;
        events.push(Event::Lost(LossKind::Other, why.to_owned()));
    }
}

/// True if some of the sent bytes have not left, as far as the operating system reports it.
fn is_leaving(wire: &Wire) -> bool {
    !wire.is_empty() || wire.left() < wire.sent()
}

impl Dialogue for Block {
    fn open(&mut self, now: Duration, wire: &mut Wire) {
        let mut text = b"H".to_vec();
        text.extend_from_slice(&self.program);
        text.push(b'E');
        let mut bytes = self.frame(SOH, &text);
        bytes.push(DC1);
        self.under_way = Some((0, bytes, Duration::ZERO));
        self.push(now, wire);
    }

    fn is_open(&self) -> bool {
        self.state == State::Open
    }

    fn has_room(&self, _length: usize) -> bool {
        self.state == State::Open && self.under_way.is_none()
    }

    fn send(&mut self, line: &Line, now: Duration, wire: &mut Wire) -> Result<(), String> {
        check_text(&line.text, self.longest_line, &[])?;
        let bytes = self.frame(STX, &line.text);
        self.under_way = Some((line.number, bytes, line.busy()));
        self.push(now, wire);
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        for &byte in bytes {
            if matches!(self.state, State::Over | State::Closed) {
                return;
            }
            match byte {
                ACK => match self.under_way.take() {
                    Some(_) if is_leaving(wire) => {
                        self.lost(
                            &impossible("the control has answered a block before it was sent completely"),
                            events,
                        );
                    }
                    Some((0, _, _)) => (self.state, self.repeats) = (State::Open, 0),
                    Some((number, _, _)) => {
                        self.repeats = 0;
                        events.push(Event::Acknowledged(number));
                    }
                    None => self.lost(&impossible("the control has answered more blocks than were sent"), events),
                },
                NAK if self.under_way.is_none() || is_leaving(wire) => {
                    let what = "the control has refused data that was not sent, was reset, or is in alarm";
                    self.lost(&impossible(what), events);
                }
                NAK => {
                    self.repeats += 1;
                    let number = self.under_way.as_ref().map_or(0, |(number, _, _)| *number);
                    if self.repeats > self.most_repeats {
                        let why = format!("the control has refused the same block {} times", self.repeats);
                        self.state = State::Over;
                        events.push(if number > 0 {
                            Event::Refused(number, why)
                        } else {
                            Event::Lost(LossKind::Other, why)
                        });
                    } else {
                        events.push(Event::Repeated(number));
                        self.push(now, wire);
                    }
                }
                EOT | CAN => self.lost("the control has aborted the transfer", events),
                DC1 => {}
                _ => {
                    let what = format!(
                        "an answer is neither ACK nor NAK ({byte:#04x}); it is not known whether the block was accepted"
                    );
                    self.lost(&impossible(&what), events);
                }
            }
        }
    }

    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if !wire.is_empty() {
            self.since = now;
        }
        let busy = self.under_way.as_ref().map(|(_, _, busy)| *busy);
        if let Some(busy) = busy
            && self.state != State::Over
            && now.saturating_sub(self.since) > self.patience + busy
        {
            self.lost("the control does not answer: it is not known whether the block was accepted", events);
        }
        if self.state == State::Closing && self.under_way.is_none() {
            wire.push(&[ETX, EOT]);
            self.state = State::Closed;
        }
    }

    fn close(&mut self, _now: Duration, _wire: &mut Wire) {
        if self.state == State::Open {
            self.state = State::Closing;
        }
    }

    fn is_done(&self, wire: &Wire) -> bool {
        self.state == State::Closed && wire.is_empty()
    }

    fn in_flight(&self) -> (usize, usize) {
        self.under_way.as_ref().map_or((0, 0), |(_, bytes, _)| (1, bytes.len()))
    }

    fn halt(&mut self, halt: Halt, _now: Duration, wire: &mut Wire) -> Option<String> {
        match halt {
            Halt::Stop => Some("no further block is sent; the control executes those that it has".into()),
            Halt::Hold => None,
            Halt::Abort => {
                wire.clear();
                wire.push_urgent(&[EOT]);
                self.state = State::Over;
                Some("the transfer is aborted; the control executes the blocks that it has".into())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::PROFILES;
    use ncfix_base::source::{FileId, Source};

    fn block(avoids_controls: bool) -> Block {
        let (_, text) = PROFILES.iter().find(|(name, _)| *name == "heidenhain-fe1").unwrap();
        let source = Source::new(FileId(0), "x", text.as_bytes().to_vec()).unwrap();
        let profile = Profile { avoids_controls, ..Profile::read(&source).unwrap() };
        Block::new(&profile)
    }

    #[test]
    fn the_check_character_of_the_manual() {
        // TNC 360, user's manual, p. 8-18: SOH H 1 5 E ETB gives 1F; an additional blank makes it 3F.
        assert_eq!(block(false).frame(SOH, b"H15E"), [&[SOH][..], b"H15E", &[ETB, 0x1F]].concat());
        assert_eq!(block(true).frame(SOH, b"H15E"), [&[SOH][..], b"H15E ", &[ETB, 0x3F]].concat());
    }
}
