//! Dialogues: what a sender and a control say to each other, as pure machines.
//!
//! To add one, write its file and register it in [`PROTOCOLS`]; profiles name it. From another crate, write a static [`Protocol`], give it to
//! [`Protocols::with`](ncfix_base::register::Register::with) and read the profile with [`Profile::read_with`].

mod answers;
mod barrier;
mod block;
mod depth;
mod grbl;
mod greeting;
mod linuxcncrsh;
mod marlin;
mod mdi;
mod tape;

use std::time::Duration;

use ncfix_base::register::{Register, Registered};

use super::{Line, Profile, Wire};

/// What a dialogue has made of what it heard, or of the time that passed.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The control has taken this line, and all before it.
    Acknowledged(u64),
    /// Something other than the count of answers says that the control has taken this line, and all before it: what its buffer holds, or the number of
    /// the line in its answer. One answer too many proves nothing.
    Checked(u64),
    /// The control has carried out this line, and all before it, as far as it says so.
    Executed(u64),
    /// The control states that so many blocks, at most, are taken and not carried out: how many, and its words.
    Holds(u64, String),
    /// The last byte of this line, and of all before it, has gone over a link without answers: nobody knows whether the control has carried it out.
    Left(u64),
    /// The control asks to pause, or to go on.
    Paused(bool),
    /// The control says something of itself that people should read.
    Said(String),
    /// Nothing has come for longer than a block can take: where the control is has been asked.
    Stalled,
    /// A line was sent again, with the same bytes.
    Repeated(u64),
    /// The control has refused this line: what it says. Lines behind it that it has may still run.
    Refused(u64, String),
    /// The job is lost: the control was reset, stands in an alarm, or does not answer as it must. Nothing more may be sent.
    Lost(String),
}

/// What a person asks for. Each leaves something else in the control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// Axes stop now; lines stay in the control and go on when a person lets them.
    Hold,
    /// No further line is sent; what the control has runs out.
    Stop,
    /// Lines that the control has are thrown away.
    Abort,
}

/// One dialogue with one control.
pub trait Dialogue: Send {
    /// What is said before the first line.
    fn open(&mut self, now: Duration, wire: &mut Wire);

    /// Whether the control is ready for lines.
    fn is_open(&self) -> bool;

    /// Whether a line of so many bytes may be frozen and sent: the window in lines and bytes.
    fn has_room(&self, length: usize) -> bool;

    /// Sends a line.
    ///
    /// # Errors
    /// A sentence where its bytes would be taken for something else on this link; nothing was sent then.
    fn send(&mut self, line: &Line, now: Duration, wire: &mut Wire) -> Result<(), String>;

    /// Hears bytes.
    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>);

    /// Time has passed.
    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>);

    /// What is said behind the last line.
    fn close(&mut self, now: Duration, wire: &mut Wire);

    /// Whether all that was sent is acknowledged, or has left where nothing is, and the end was said.
    fn is_done(&self, wire: &Wire) -> bool;

    /// Lines and bytes that were sent and not acknowledged; where nothing is, that have not left.
    fn in_flight(&self) -> (usize, usize);

    /// What a person asked for. Returns what this does to what the control has, as a sentence; `None` where this dialogue has no word for it.
    fn halt(&mut self, halt: Halt, now: Duration, wire: &mut Wire) -> Option<String>;
}

/// A kind of dialogue.
#[derive(Clone, Copy, Debug)]
pub struct Protocol {
    /// What profiles call it.
    pub name: &'static str,
    /// What it is.
    pub title: &'static str,
    /// Whether the control is asked, before the first line, if it stands still: it gets no line unless it says so.
    pub asks_idle: bool,
    /// Whether its answer to a line means that the line lies in a planner, so that a depth says how many may not be carried out.
    pub has_planner: bool,
    /// Blocks beyond the places of the planner that may not be carried out either: what still moves, and what waits before it.
    pub beyond: u64,
    /// Whether a line can go over it; a sentence where not.
    pub check: fn(&Profile, &[u8]) -> Result<(), String>,
    /// Begins one; a sentence where the profile does not fit it.
    pub create: fn(&Profile) -> Result<Box<dyn Dialogue>, String>,
}

impl PartialEq for Protocol {
    /// A name is that of one protocol of a register.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// The kinds of dialogues that a profile may name: [`Register::default`](ncfix_base::register::Register::default) are those that are built in.
pub type Protocols = Register<&'static Protocol>;

impl Registered for &'static Protocol {
    const KIND: &'static str = "protocol";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        PROTOCOLS.iter().map(Box::new).collect()
    }
}

/// Those that are built in.
pub const PROTOCOLS: &[Protocol] =
    &[block::PROTOCOL, grbl::PROTOCOL, linuxcncrsh::PROTOCOL, marlin::PROTOCOL, tape::PROTOCOL];

/// Whether a text can go over a link: not too long, printed characters only, and none that means something else there.
fn check_text(text: &[u8], longest: usize, refused: &[u8]) -> Result<(), String> {
    if text.len() > longest {
        return Err(format!(
            "it has {} characters, the control takes {longest}; leave out blanks, numbers of blocks and comments",
            text.len()
        ));
    }
    match text.iter().find(|byte| !(b' '..=b'~').contains(*byte) || refused.contains(*byte)) {
        Some(byte) => {
            Err(format!("the byte {byte:#04x} means something else on this link; take it out of the program"))
        }
        None => Ok(()),
    }
}
