//! Tape links: what the bytes of the control mean, state by state.
//!
//! What a control can say that is as it must be; anything else ends the job, its state is unknown:
//!
//! | state | byte | meaning |
//! | --- | --- | --- |
//! | waiting for the first XON | XON | it reads: the program begins |
//! | | any other but SYN and NAK | disturbance: nothing was sent yet |
//! | bytes leave | XOFF | its buffer is nearly full |
//! | | XON at once behind another, or when nothing has left for 4 s | the same once more; it waits for data |
//! | | any other XON | impossible: it asks for what it gets |
//! | held | XON | it has room |
//! | | XOFF | the same once more |
//! | any | NUL, DC2, DC4 | nothing |
//! | | SYN, NAK | it was reset; it stands in an alarm |
//!
//! A control that is reset without a word while it holds the flow, and started again, looks like one that has room: nothing on such a link shows it.

use std::time::Duration;

use super::{Event, State, Tape, Wire};
use crate::feed::dialogue::answers::impossible;

const NUL: u8 = 0x00;
const DC2: u8 = 0x12;
const DC4: u8 = 0x14;
const NAK: u8 = 0x15;
const SYN: u8 = 0x16;
/// Bytes that let go on come again so soon by disturbance, and after so long where the control gets nothing (Haas: 5 s).
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
        events.push(Event::Lost(why.to_owned()));
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
                // Haas repeats it while nothing comes: that is harmless. One that gets what it wants does not ask.
                let what = "the control asks for data although it gets them, it was reset or started anew";
                self.lost(&impossible(what), wire, events);
            }
            self.asked = now;
        } else {
            match byte {
                NUL | DC2 | DC4 => {}
                SYN => self.lost("the control was reset (SYN)", wire, events),
                NAK => self.lost("the control stands in an alarm (NAK)", wire, events),
                // It may have been an XOFF, or said that it was reset.
                _ if self.flow.xoff.is_some() && self.state != State::Waiting => {
                    let what = format!("a byte means nothing on this link ({byte:#04x})");
                    self.lost(&impossible(&what), wire, events);
                }
                _ => {}
            }
        }
    }
}
