//! Transfers: a corrected program is sent to a control line by line, with a correction for the current temperatures.
//!
//! The program is executed twice. The first time ([`survey`]) nothing is sent: all diagnostics are reported, every
//! line is checked against the link, and the forecast is made. The second time one thread executes and corrects
//! ([`source`]), another one reads the temperatures ([`thermal`]), and the calling thread adds the thermal correction, sends
//! and listens ([`drive`]).

mod book;
mod drive;
mod first_answers;
mod job;
mod link;
mod live_lines;
mod meter;
mod options;
mod resume;
mod shown_faults;
mod shown_texts;
mod source;
mod start_state;
mod survey;
mod thermal;

use std::path::Path;
use std::time::Duration;

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::Options;
use crate::program::Program;
use crate::run::Watch;
use ncfix_dnc::feed::{Event, Port};
use ncfix_dnc::sense::Panel;
use ncfix_report::feed::{Before, FeedEvent, Status};

pub(crate) use book::{check as check_journal, next_step};
pub(crate) use drive::{Begin, Lane, NotBegun, run as send};
pub use job::Transfer;
pub use link::ControlLink;
pub use options::FeedOptions;
pub(crate) use resume::{Broken, began_with, check_same, plan, read as read_broken};
pub(crate) use shown_faults::ShownFaults;
pub(crate) use shown_texts::ShownTexts;

/// Advice for a transfer without all temperatures of the error model.
pub(crate) const TEMPERATURES_HELP: &str = "give --sensors with a file of these sensors, which are read while the job runs; or --state with their temperatures";

/// The reason why a transfer has ended.
///
/// ```
/// use ncfix::prelude::*;
///
/// fn advice(end: FeedEnd) -> &'static str {
///     match end {
///         FeedEnd::Done => "the part is made",
///         FeedEnd::Control => "look at the control",
///         _ => "read the journal",
///     }
/// }
/// assert_eq!(advice(FeedEnd::Control), "look at the control");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FeedEnd {
    /// All lines were executed, or at least answered.
    Done,
    /// A line could not be generated.
    Fault,
    /// The link is lost.
    Link,
    /// The control has refused a line, or no longer answers.
    Control,
    /// The sensors remain faulty.
    Sensors,
    /// The user has stopped it.
    Stopped,
}

/// The result of a transfer.
///
/// ```
/// use ncfix::prelude::*;
///
/// fn is_whole(sent: &Sent) -> bool {
///     sent.end == FeedEnd::Done && sent.status.acknowledged == sent.status.lines
/// }
/// # let _ = is_whole;
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Sent {
    /// Counts, and the text for the user.
    pub status: Status,
    /// The reason why it has ended.
    pub end: FeedEnd,
    /// True if `ncfix resume` can continue the job. It cannot if the link sends the program as one file.
    pub may_be_resumed: bool,
}

/// The observer of a transfer. Times count from its start.
///
/// ```
/// use ncfix::prelude::*;
///
/// /// Stops the transfer after a minute.
/// struct Minute(std::time::Duration);
///
/// impl FeedView for Minute {
///     fn tick(&mut self, now: std::time::Duration) {
///         self.0 = now;
///     }
///
///     fn is_stopped(&mut self) -> bool {
///         self.0.as_secs() >= 60
///     }
/// }
///
/// let mut view = Minute(std::time::Duration::ZERO);
/// view.tick(std::time::Duration::from_secs(61));
/// assert!(view.is_stopped());
/// ```
pub trait FeedView {
    /// True if a status is due now.
    fn is_due(&self, _now: Duration) -> bool {
        false
    }

    /// Receives the current status.
    fn status(&mut self, _status: &Status, _now: Duration) {}

    /// Called while the transfer waits before the first line.
    fn waiting(&mut self, _what: &str, _now: Duration) {}

    /// Called for each event on the link.
    fn event(&mut self, _event: &Event, _now: Duration) {}

    /// Called as time passes.
    fn tick(&mut self, _now: Duration) {}

    /// Sensors are in doubt, and the correction is frozen.
    fn frozen(&mut self, _why: &str, _now: Duration) {}

    /// The sensors are valid again.
    fn thawed(&mut self, _now: Duration) {}

    /// Called for an event that the user should see at once, with the link line that it is about.
    fn say(&mut self, _event: FeedEvent, _now: Duration, _line: Option<u64>, _message: String) {}

    /// True if a stop was requested since the last call: the first request stops sending, so that the control runs out of blocks; the second one
    /// holds the axes if the link has a command for it.
    fn is_stopped(&mut self) -> bool {
        false
    }
}

/// An observer that does nothing.
struct Nobody;

impl FeedView for Nobody {}

impl Program {
    /// The program as it will be sent over a link.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let link = ControlLink::named("siemens-v24")?;
    /// let transfer = program.feed(&machine, link, &Options::default(), FeedOptions::default())?;
    /// assert!(transfer.forecast()?.lines > 2);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the program cannot be parsed or is refused.
    pub fn feed(
        &self,
        machine: &Machine,
        link: ControlLink,
        options: &Options,
        feed: FeedOptions,
    ) -> Result<Transfer, Error> {
        let mut found = Diagnostics::default();
        self.was_corrected_before(&mut found);
        let transfer = if found.has_errors() {
            None
        } else {
            let link = (link, String::new());
            Transfer::new(self.clone(), machine.clone(), link, (options, feed), &mut found)?
        };
        transfer.filter(|_| !found.has_errors()).ok_or_else(|| Error::found(found))
    }
}

impl Transfer {
    /// Runs the program without sending anything. Reports errors of the program, lines that the link cannot send, and a link that is too slow for the
    /// motion.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let transfer = program.feed(&machine, ControlLink::named("siemens-v24")?, &Options::default(), FeedOptions::default())?;
    /// let forecast = transfer.forecast()?;
    /// assert!(forecast.lines >= 3);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the program must not be sent.
    pub fn forecast(&self) -> Result<Before, Error> {
        self.forecast_with(false)
    }

    /// The forecast; `has_sensors` if sensors will be read.
    fn forecast_with(&self, has_sensors: bool) -> Result<Before, Error> {
        let mut found = Diagnostics::default();
        let before = self.survey(("", has_sensors), None, &mut found)?;
        self.dialogue()?;
        match before.filter(|_| !found.has_errors()) {
            Some(before) => Ok(Before { diagnostics: found.json(), ..before }),
            None => Err(Error::found(found)),
        }
    }

    /// Sends the program over a port, reads the sensors at the same time, and writes a journal. The journal file must not exist, or must be that of a
    /// finished job. Returns when the transfer has ended, with or without success.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// # use std::io::Read as _;
    /// /// A control with a tape reader: it sends XON once and accepts every byte.
    /// struct Tape(std::io::Cursor<[u8; 1]>);
    ///
    /// impl Port for Tape {
    ///     fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
    ///         self.0.read(into)
    ///     }
    ///
    ///     fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
    ///         Ok(bytes.len())
    ///     }
    /// }
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut how = FeedOptions::default();
    /// (how.machine_stands_still, how.allow_starvation) = (true, true);
    /// let transfer = program.feed(&machine, ControlLink::named("siemens-v24")?, &Options::default(), how)?;
    /// let journal = std::env::temp_dir().join(format!("ncfix_send_{}.journal", std::process::id()));
    /// let sent = transfer.send(Box::new(Tape(std::io::Cursor::new([17]))), None, &journal)?;
    /// std::fs::remove_file(&journal)?;
    /// assert_eq!(sent.end, FeedEnd::Done);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the transfer does not begin, because there are errors, the journal cannot be written, or sensors are missing or do not start.
    pub fn send(self, port: Box<dyn Port>, sensors: Option<Panel>, journal: impl AsRef<Path>) -> Result<Sent, Error> {
        self.send_seen(port, sensors, journal, &mut Nobody)
    }

    /// Sends the program with an observer.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// # use std::io::Read as _;
    /// /// A control with a tape reader: it sends XON once and accepts every byte.
    /// struct Tape(std::io::Cursor<[u8; 1]>);
    ///
    /// impl Port for Tape {
    ///     fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
    ///         self.0.read(into)
    ///     }
    ///
    ///     fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
    ///         Ok(bytes.len())
    ///     }
    /// }
    ///
    /// /// Counts what happens on the link.
    /// struct Count(usize);
    ///
    /// impl FeedView for Count {
    ///     fn is_due(&self, _now: std::time::Duration) -> bool {
    ///         true
    ///     }
    ///
    ///     fn status(&mut self, _status: &FeedStatus, _now: std::time::Duration) {
    ///         self.0 += 1;
    ///     }
    /// }
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut how = FeedOptions::default();
    /// (how.machine_stands_still, how.allow_starvation) = (true, true);
    /// let transfer = program.feed(&machine, ControlLink::named("siemens-v24")?, &Options::default(), how)?;
    /// let journal = std::env::temp_dir().join(format!("ncfix_seen_{}.journal", std::process::id()));
    /// let mut count = Count(0);
    /// let sent = transfer.send_seen(Box::new(Tape(std::io::Cursor::new([17]))), None, &journal, &mut count)?;
    /// std::fs::remove_file(&journal)?;
    /// assert!(sent.end == FeedEnd::Done && count.0 > 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Transfer::send`].
    pub fn send_seen(
        self,
        port: Box<dyn Port>,
        sensors: Option<Panel>,
        journal: impl AsRef<Path>,
        view: &mut dyn FeedView,
    ) -> Result<Sent, Error> {
        let (before, journal) = (self.forecast_with(sensors.is_some())?, journal.as_ref());
        let mut found = Diagnostics::default();
        check_journal(journal, &mut found)?;
        found.extend(self.unasked(), &[]);
        if let Some(panel) = &sensors {
            let names: Vec<&str> = panel.channels().map(|channel| channel.name.as_str()).collect();
            found.extend(self.missing(&names), &[]);
        }
        if found.has_errors() {
            return Err(Error::found(found));
        }
        let lane = Lane { port, characters_per_s: f64::INFINITY, panel: sensors, journal };
        let begin = Begin { input: self.program.name().to_owned(), ..Begin::default() };
        send(self, lane, &before, &begin, view).map_err(|refused| match refused {
            NotBegun::Error(error) => error,
            NotBegun::Ended(_, why) => Error::usage(why),
        })
    }

    /// Runs the program without sending anything; `None` if there are errors.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn survey(
        &self,
        (port, has_sensors): (&str, bool),
        watch: Option<fn() -> Box<dyn Watch>>,
        found: &mut Diagnostics,
    ) -> Result<Option<Before>, Error> {
        survey::run(self, (port, has_sensors), watch, found)
    }
}
