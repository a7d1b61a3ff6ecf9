//! Sends a program to a control line by line: links, dialogues, window, rate limit, journal.
//!
//! ```text
//! Supply ─▶ Line (frozen) ─▶ Dialogue ─▶ Wire ─▶ Port
//!             │                 ▲ received bytes   │
//!             └──▶ Journal ◀────┴──────────────────┘
//! ```
//!
//! A [`Line`] is frozen when the [`Sender`] takes it from the [`Supply`]. Its bytes and its correction never change again, so a repeated line is identical. A
//! [`Dialogue`] is a state machine: received bytes and the time go in, bytes to be sent and [`Event`]s come out. It never touches a port or a clock. Its
//! window decides how many lines are frozen, never a queue of the operating system.
//!
//! [`Sender::step`] does what is possible at one instant without waiting. Tests give it a simulated control and a simulated clock. A program gives it a port
//! and waits between steps.

pub mod dialogue;
mod dosing;
mod forecast;
mod journal;
mod line;
pub mod port;
mod profile;
mod rewriter;
mod sender;
mod shown;
mod watch;
mod wire;

pub use dialogue::{
    Dialogue, Event, ExpectedZero, Halt, LossKind, PROTOCOLS, Protocol, Protocols, ZERO_LETTERS, ZeroValues,
};
pub use dosing::{Dose, DosingLimits, LineDosing};
pub use forecast::{Forecast, Forecaster, LinkRate, Stretch};
pub use journal::{Frozen, HeadKey, Journal, JournalContents, JournalEnd, Store, read as read_journal};
pub use line::{Line, crc32};
pub use profile::{Bound, FileOptions, Flow, Framing, LinkFile, Links, PROFILES, Parity, Profile, Serial, Window};
pub use rewriter::LineRewriter;
pub use sender::{Ended, Port, Record, Sender, Supplied, Supply, TransferProgress};
pub use shown::{ThermalHistory, shown};
pub use watch::Patience;
pub use wire::Wire;
