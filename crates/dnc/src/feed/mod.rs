//! Sends a program to a control line by line: links, dialogues, window, dosing, journal.
//!
//! ```text
//! Supply ─▶ Line (frozen) ─▶ Dialogue ─▶ Wire ─▶ Port
//!             │                 ▲ what is heard    │
//!             └──▶ Journal ◀────┴──────────────────┘
//! ```
//!
//! A [`Line`] is frozen when the [`Sender`] takes it from the [`Supply`]: its bytes and its correction never change again, so that what is sent
//! twice is the same. A [`Dialogue`] is a pure machine: bytes that are heard and the time go in, bytes that are to be sent and [`Event`]s come out;
//! it never touches a port or a clock. How many lines are frozen is decided by its window, never by queues of the system.
//!
//! [`Sender::step`] does what can be done at one instant without waiting. Tests give it a simulated control and a simulated clock; a program gives
//! it a port and waits in between.

pub mod dialogue;
mod dosing;
mod forecast;
mod journal;
mod line;
pub mod port;
mod profile;
mod sender;
mod shown;
mod watch;
mod wire;

pub use dialogue::{Dialogue, Event, Halt, PROTOCOLS, Protocol, Protocols};
pub use dosing::{Dose, Limits, LineDosing};
pub use forecast::{Forecast, Forecaster, Link, Stretch};
pub use journal::{Frozen, HeadKey, Journal, JournalEnd, Store, Told, read as read_journal};
pub use line::{Line, crc32};
pub use profile::{Bound, Flow, Framing, LinkFile, Links, PROFILES, Parity, Profile, Serial, Window};
pub use sender::{Ended, GONE, Port, Progress, Record, Sender, Supplied, Supply};
pub use shown::{Shown, shown};
pub use watch::Patience;
pub use wire::Wire;
