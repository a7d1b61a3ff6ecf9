//! Tape links: meaning of the bytes from the control, state by state.
//!
//! Bytes of a correct control; any other byte ends the job, because the state of the control is then unknown:
//!
//! | state | byte | meaning |
//! | --- | --- | --- |
//! | waiting for the first XON | XON | it reads: the program begins |
//! | | any other but SYN and NAK | interference: nothing has been sent yet |
//! | bytes leave | XOFF | its buffer is nearly full |
//! | | XON immediately after another, or when nothing has left for 4 s | a repetition; it waits for data |
//! | | any other XON | impossible: it asks for data while it gets them |
//! | held | XON | it has room |
//! | | XOFF | a repetition |
//! | any | NUL, DC2, DC4 | no effect |
//! | | SYN, NAK | it was reset; it is in alarm |
//!
//! A control that is silently reset and restarted while it holds the flow looks like one that has room. Nothing on such a link reveals this.

use std::time::Duration;

use super::{Event, State, Tape, Wire};
use crate::feed::dialogue::LossKind;
use crate::feed::dialogue::answers::impossible;

const NUL: u8 = 0x00;
const DC2: u8 = 0x12;
const DC4: u8 = 0x14;
const NAK: u8 = 0x15;
const SYN: u8 = 0x16;
/// Time within which interference may repeat an XON, and time after which a control without data repeats it (Haas: 5 s).
const AT_ONCE: Duration = Duration::from_millis(500);
const HUNGRY: Duration = Duration::from_secs(4);

impl Tape {
    fn hold(&mut self, is_held: bool, events: &mut Vec<Event>) {
        if self.is_held != is_held {
            self.is_held = is_held;
            events.push(Event::Paused(is_held));
        }
    }

    pub(super) fn lost(&mut self, why: &str, wire: &mut Wire, events: &mut Vec<Event>) {
        self.state = State::Over;
        self.out.clear();
        wire.clear();
        events.push(Event::Lost(LossKind::Other, why.to_owned()));
    }

    pub(super) fn hear_byte(&mut self, byte: u8, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let is = |known: Option<u8>| known.is_some_and(|known| known & self.mask == byte);
        if is(self.flow.xoff) {
            self.hold(true, events);
        } else if is(self.flow.xon) {
            self.moved = now;
            let is_fed = now.saturating_sub(self.fed) < HUNGRY && now.saturating_sub(self.asked) > AT_ONCE;
            if self.state == State::Waiting {
                self.begin();
            } else if self.is_held {
                self.hold(false, events);
            } else if is_fed {
                // Haas repeats it while no data come: that is harmless. A control that receives data does not ask.
                let what = "the control requests data although it receives them; it was reset or restarted";
                self.lost(&impossible(what), wire, events);
            }
            self.asked = now;
        } else {
            match byte {
                NUL | DC2 | DC4 => {}
                SYN => self.lost("the control was reset (SYN)", wire, events),
                NAK => self.lost("the control is in alarm (NAK)", wire, events),
                // It may have been an XOFF, or the notice of a reset.
                _ if self.flow.xoff.is_some() && self.state != State::Waiting => {
                    let what = format!("a byte has no meaning on this link ({byte:#04x})");
                    self.lost(&impossible(&what), wire, events);
                }
                _ => {}
            }
        }
    }
}
