//! Telegrams of LSV/2 over a serial line, in the frames of DIN 66019.
//!
//! ```text
//! sender    ENQ         DLE STX telegram DLE ETX BCC         EOT
//! receiver       DLE 0                                DLE 1
//! ```
//!
//! The telegram is its name and its data, without a length. `DLE` within it is sent twice. The check character `BCC` is the exclusive or of the bytes of the
//! telegram and `ETX`. `NAK` asks for the block again. Both sides send in this way; the answer of the control is a transmission of its own.
//!
//! Sources: the three times are those of the technical manuals of the TNC 426/430 and iTNC 530 (`LSV2TIME0` to `LSV2TIME2`). The frames and the check
//! character are written from memory of the standard. No control was at hand to confirm them.

use std::time::Duration;

use super::super::Wire;
use super::telegram::Telegram;

const STX: u8 = 0x02;
const ETX: u8 = 0x03;
const EOT: u8 = 0x04;
const ENQ: u8 = 0x05;
const DLE: u8 = 0x10;
const NAK: u8 = 0x15;
/// Second byte of `DLE 0` (ready for a block) and of `DLE 1` (the block is good).
const READY: u8 = b'0';
const GOOD: u8 = b'1';

/// Longest block, bytes of the telegram.
const MOST_BYTES: usize = 16_384;
/// Maximum time from `STX` to `ETX`, for the answer to `ENQ` or to a block, and from an answer to the next byte.
const BLOCK: Duration = Duration::from_secs(3);
const ANSWER: Duration = Duration::from_secs(3);
const NEXT: Duration = Duration::from_secs(1);

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    #[default]
    Idle,
    /// `ENQ` was sent.
    Asked,
    /// A block was sent.
    Sent,
    /// `DLE 0` or `NAK` was sent: a block must begin.
    Expecting,
    /// Within a block.
    Receiving,
    /// The next byte is the check character.
    Checking,
    /// `DLE 1` was sent: `EOT` must follow.
    Ending,
}

/// One end of the line.
#[derive(Debug)]
pub(super) struct SerialFrames {
    state: State,
    /// Time when the state began.
    since: Duration,
    /// Telegrams that have not been sent completely, oldest first.
    waiting: Vec<Telegram>,
    /// Maximum number of repeats, and repeats so far.
    most_repeats: u32,
    repeats: u32,
    /// True if the last byte was a `DLE` that begins a pair.
    is_escaped: bool,
    block: Vec<u8>,
}

impl SerialFrames {
    pub(super) fn new(most_repeats: u32) -> SerialFrames {
        SerialFrames {
            state: State::Idle,
            since: Duration::ZERO,
            waiting: Vec::new(),
            most_repeats,
            repeats: 0,
            is_escaped: false,
            block: Vec::new(),
        }
    }

    pub(super) fn send(&mut self, telegram: Telegram, now: Duration, wire: &mut Wire) {
        self.waiting.push(telegram);
        self.begin(now, wire);
    }

    /// Begins the next transmission if the line is free.
    fn begin(&mut self, now: Duration, wire: &mut Wire) {
        if self.state == State::Idle && !self.waiting.is_empty() {
            self.repeats = 0;
            wire.push(&[ENQ]);
            self.enter(State::Asked, now);
        }
    }

    fn enter(&mut self, state: State, now: Duration) {
        (self.state, self.since, self.is_escaped) = (state, now, false);
    }

    /// Counts a repeat.
    fn repeat(&mut self, what: &str) -> Result<(), String> {
        self.repeats += 1;
        if self.repeats > self.most_repeats { Err(format!("{what} {} times", self.repeats)) } else { Ok(()) }
    }

    fn push_block(&mut self, now: Duration, wire: &mut Wire) {
        if let Some(telegram) = self.waiting.first() {
            wire.push(&framed(telegram));
        }
        self.enter(State::Sent, now);
    }

    /// Takes a received byte. Returns a telegram if it is complete.
    ///
    /// # Errors
    /// The byte is impossible in this state. The error is a sentence.
    pub(super) fn hear(&mut self, byte: u8, now: Duration, wire: &mut Wire) -> Result<Option<Telegram>, String> {
        let is_pair = std::mem::take(&mut self.is_escaped);
        match (self.state, byte) {
            (State::Receiving, _) => return self.receive(byte, is_pair, now),
            (State::Checking, _) => return self.check(byte, now, wire),
            (State::Asked | State::Sent | State::Expecting, DLE) if !is_pair => self.is_escaped = true,
            (State::Asked, READY) if is_pair => self.push_block(now, wire),
            (State::Asked, NAK) if !is_pair => {
                self.repeat("the control has refused to receive")?;
                wire.push(&[ENQ]);
                self.since = now;
            }
            (State::Sent, GOOD) if is_pair => {
                wire.push(&[EOT]);
                self.waiting.remove(0);
                self.enter(State::Idle, now);
                self.begin(now, wire);
            }
            (State::Sent, NAK) if !is_pair => {
                self.repeat("the control has refused the same block")?;
                self.push_block(now, wire);
            }
            (State::Idle, ENQ) => {
                self.repeats = 0;
                wire.push(&[DLE, READY]);
                self.enter(State::Expecting, now);
            }
            (State::Expecting, STX) if is_pair => {
                self.block.clear();
                self.enter(State::Receiving, now);
            }
            (State::Ending, EOT) => {
                self.enter(State::Idle, now);
                let telegram = Telegram::of(&std::mem::take(&mut self.block))?;
                self.begin(now, wire);
                return Ok(Some(telegram));
            }
            _ => return Err(format!("the byte {byte:#04x} is not valid {}", self.place())),
        }
        Ok(None)
    }

    fn receive(&mut self, byte: u8, is_pair: bool, now: Duration) -> Result<Option<Telegram>, String> {
        match byte {
            ETX if is_pair => self.enter(State::Checking, now),
            DLE if !is_pair => self.is_escaped = true,
            _ if is_pair && byte != DLE => {
                return Err(format!("DLE is followed by {byte:#04x} within a block"));
            }
            _ if self.block.len() >= MOST_BYTES => {
                return Err(format!("a block has more than {MOST_BYTES} bytes"));
            }
            _ => self.block.push(byte),
        }
        Ok(None)
    }

    fn check(&mut self, byte: u8, now: Duration, wire: &mut Wire) -> Result<Option<Telegram>, String> {
        if byte == check_character(&self.block) {
            wire.push(&[DLE, GOOD]);
            self.enter(State::Ending, now);
        } else {
            self.repeat("the check character of the same block was wrong")?;
            wire.push(&[NAK]);
            self.enter(State::Expecting, now);
        }
        Ok(None)
    }

    /// Describes the state for people.
    fn place(&self) -> &'static str {
        match self.state {
            State::Idle => "between two transmissions",
            State::Asked => "after ENQ",
            State::Sent => "after a block",
            State::Expecting => "before a block",
            State::Receiving | State::Checking => "within a block",
            State::Ending => "after a good block",
        }
    }

    /// Handles the passing of time.
    ///
    /// # Errors
    /// The control does not answer. A block without an answer is not sent again, because the control may have taken it. The error is a sentence.
    pub(super) fn tick(&mut self, now: Duration, wire: &mut Wire) -> Result<(), String> {
        // Before the last byte has left, no answer can come.
        if !wire.is_empty() && self.state != State::Receiving {
            self.since = now;
            return Ok(());
        }
        let most = match self.state {
            State::Idle => return Ok(()),
            State::Asked | State::Sent => ANSWER,
            State::Receiving | State::Checking => BLOCK,
            State::Expecting | State::Ending => NEXT,
        };
        if now.saturating_sub(self.since) <= most {
            return Ok(());
        }
        if self.state == State::Asked {
            self.repeat("the control has not answered ENQ")?;
            wire.push(&[ENQ]);
            self.since = now;
            return Ok(());
        }
        Err(format!("nothing came {} for {} s", self.place(), most.as_secs()))
    }
}

/// Returns the check character of a telegram.
fn check_character(block: &[u8]) -> u8 {
    block.iter().fold(ETX, |sum, byte| sum ^ byte)
}

/// Returns the block of a telegram: frame, doubled `DLE`, check character.
fn framed(telegram: &Telegram) -> Vec<u8> {
    let plain = [&telegram.name[..], &telegram.data].concat();
    let mut bytes = vec![DLE, STX];
    for &byte in &plain {
        bytes.push(byte);
        if byte == DLE {
            bytes.push(DLE);
        }
    }
    bytes.extend([DLE, ETX, check_character(&plain)]);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_by_hand() {
        // T 54, _ 5F, O 4F, K 4B, 10, ETX 03: 54^5F = 0B, ^4F = 44, ^4B = 0F, ^10 = 1F, ^03 = 1C.
        let block = framed(&Telegram::new(*b"T_OK", vec![DLE]));
        assert_eq!(block, [&[DLE, STX][..], b"T_OK", &[DLE, DLE, DLE, ETX, 0x1C]].concat());
    }

    #[test]
    fn a_block_without_an_answer_is_not_sent_again() {
        let (mut wire, mut line) = (Wire::default(), SerialFrames::new(3));
        let at = Duration::from_secs;
        line.send(Telegram::new(*b"A_LO", Vec::new()), at(0), &mut wire);
        for byte in [DLE, READY] {
            assert_eq!(line.hear(byte, at(0), &mut wire), Ok(None));
        }
        let count = wire.waiting();
        wire.clear();
        assert_eq!(line.tick(at(3), &mut wire), Ok(()));
        assert!(line.tick(at(4), &mut wire).unwrap_err().contains("after a block"));
        assert!(count > 8 && wire.is_empty());
    }
}
