//! Dialogues between a sender and a control, as state machines without input, output or a clock.
//!
//! To add one, write its file and register it in [`PROTOCOLS`]; profiles refer to it by its name. From another crate, write a static [`Protocol`], pass it to
//! `ncfix::Registry::with_protocol`, and read the profile with `ncfix::ControlLink::from_file_with`.

mod answers;
mod barrier;
mod block;
mod depth;
mod grbl;
mod greeting;
mod linuxcncrsh;
mod lsv2;
mod marlin;
mod mdi;
mod position;
mod tape;
mod zero;
mod zeros;

use std::time::Duration;

use ncfix_base::register::{Register, Registered};

use super::rewriter::LineRewriter;
use super::{Line, Profile, Wire};

pub use zero::{ExpectedZero, ZERO_LETTERS, ZeroValues};

/// Event of a dialogue, caused by received bytes or by elapsed time.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The control has taken this line, and all before it.
    Acknowledged(u64),
    /// Evidence other than the count of answers shows that the control has taken this line and all before it: the buffer state, or the line number in its
    /// answer. A single surplus answer proves nothing.
    Checked(u64),
    /// The control reports that it has executed this line and all before it.
    Executed(u64),
    /// The control states its zero offsets at the start of the job, as they are written to the journal.
    ZeroOffsets(String),
    /// The control stands still, and reports the position that the lines sent command, for these axes.
    InPosition(String),
    /// The control states the maximum number of blocks that are taken and not executed: the number, and its words.
    Holds(u64, String),
    /// The last byte of this line, and of all before it, went out over a link without answers. It is not known whether the control has executed the line.
    Left(u64),
    /// The control asks to pause (`true`) or to resume.
    Paused(bool),
    /// The control reports something about itself that people should read.
    Said(String),
    /// No answer has come for longer than a block can take; the control was asked for its status.
    Stalled,
    /// A line was sent again, with the same bytes.
    Repeated(u64),
    /// The control has refused this line, with its answer. Later lines that it has may still run.
    Refused(u64, String),
    /// The control reports its state and its position. This is information for people, and no evidence of executed lines.
    Reported(String),
    /// The job is lost: the control was reset, is in alarm, or does not answer as it must. Nothing more may be sent. With the kind of loss and its reason.
    Lost(LossKind, String),
}

/// Kind of a loss. It decides the exit status, and what is known about the lines that were sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LossKind {
    /// The link has failed: the control cannot be reached any more.
    LinkGone,
    /// The control stands still at another position than the lines sent command.
    AtAnotherPosition,
    /// Any other loss, such as a reset, an alarm or a missing answer.
    Other,
}

/// Stop command of a person. Each leaves the control in a different state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// Axes stop now; lines stay in the control and continue when a person resumes them.
    Hold,
    /// No further line is sent; the lines in the control are executed.
    Stop,
    /// Lines in the control are discarded.
    Abort,
}

/// Dialogue with one control.
pub trait Dialogue: Send {
    /// Sends the opening before the first line.
    fn open(&mut self, now: Duration, wire: &mut Wire);

    /// True if the control is ready for lines.
    fn is_open(&self) -> bool;

    /// True if a line of this length, bytes, may be frozen and sent: the window in lines and bytes.
    fn has_room(&self, length: usize) -> bool;

    /// Sends a line.
    ///
    /// # Errors
    /// Its bytes have another meaning on this link. Nothing was sent. The error is a sentence.
    fn send(&mut self, line: &Line, now: Duration, wire: &mut Wire) -> Result<(), String>;

    /// Handles received bytes.
    fn hear(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>);

    /// Handles the passing of time.
    fn tick(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>);

    /// Sends the end after the last line.
    fn close(&mut self, now: Duration, wire: &mut Wire);

    /// True if everything sent is acknowledged, or has left on a link without answers, and the end was sent.
    fn is_done(&self, wire: &Wire) -> bool;

    /// Returns the lines and bytes that are not acknowledged yet. On a link without answers: those that are not transmitted yet.
    fn in_flight(&self) -> (usize, usize);

    /// Handles the end of the lines before the end of the program. [`Dialogue::close`] follows. A link that sends a file must not send a part of it.
    fn cut(&mut self) {}

    /// False if the control cannot have executed any line yet, because it gets the program as a file and does not have it.
    fn may_have_run(&self) -> bool {
        true
    }

    /// Describes what the control has of a file, for a link that sends one.
    fn remains(&self) -> Option<String> {
        None
    }

    /// Notes the zero offsets for which the program was corrected, before [`Dialogue::open`]. A dialogue that can ask the control for them compares them.
    fn expect(&mut self, _zero: ExpectedZero) {}

    /// True if the control is asked for its zero offsets. If not, a person must compare them.
    fn asks_zero(&self) -> bool {
        false
    }

    /// Describes what the control must do before the first line, if a person has to start it there.
    fn waits_for(&self) -> Option<&'static str> {
        None
    }

    /// Holds the axes after the job is lost, if the control may still start lines that it has. Returns a sentence about it; `None` if it cannot start any, or
    /// this dialogue has no such command.
    fn leave(&mut self, _wire: &mut Wire) -> Option<String> {
        None
    }

    /// Carries out a stop command. Returns its effect on the lines in the control as a sentence; `None` if this dialogue has no such command.
    fn halt(&mut self, halt: Halt, now: Duration, wire: &mut Wire) -> Option<String>;
}

/// Protocol: creates the dialogues of one kind of control.
#[derive(Clone, Copy, Debug)]
pub struct Protocol {
    /// Name in profiles.
    pub name: &'static str,
    /// Description for people.
    pub title: &'static str,
    /// True if the control is asked before the first line whether it is idle. It gets no line unless it says so.
    pub asks_idle: bool,
    /// True if it sends the program as one file, which a person starts at the control. No line is executed before the last one was sent.
    pub sends_file: bool,
    /// True if its answer means that the line is in a planner. The planner depth then limits the lines that may not be executed.
    pub has_planner: bool,
    /// Blocks beyond the planner places that may not be executed either: those that still move, and those that wait before the planner.
    pub beyond: u64,
    /// Creates the converter of its lines; `None` if the control reads the lines as they are.
    pub rewrite: Option<fn() -> Box<dyn LineRewriter>>,
    /// Checks that a line can be sent over it. The error is a sentence.
    pub check: fn(&Profile, &[u8]) -> Result<(), String>,
    /// Creates a dialogue. The error is a sentence, if the profile does not fit it.
    pub create: fn(&Profile) -> Result<Box<dyn Dialogue>, String>,
}

impl PartialEq for Protocol {
    /// Two protocols are equal if their names are: names are unique in a registry.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// Protocols that a profile may name. [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
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

/// Built-in protocols.
pub const PROTOCOLS: &[Protocol] = &[
    block::PROTOCOL,
    grbl::PROTOCOL,
    linuxcncrsh::PROTOCOL,
    lsv2::TCP,
    lsv2::SERIAL,
    marlin::PROTOCOL,
    tape::PROTOCOL,
];

/// Checks that a text can be sent over a link: not too long, only printable characters, and none with another meaning on the link.
fn check_text(text: &[u8], longest: usize, refused: &[u8]) -> Result<(), String> {
    if text.len() > longest {
        return Err(format!(
            "it has {} characters, the control accepts {longest}; omit blanks, block numbers and comments",
            text.len()
        ));
    }
    match text.iter().find(|byte| !(b' '..=b'~').contains(*byte) || refused.contains(*byte)) {
        Some(byte) => Err(format!("the byte {byte:#04x} has another meaning on this link; remove it from the program")),
        None => Ok(()),
    }
}
