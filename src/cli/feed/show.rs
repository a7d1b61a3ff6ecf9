//! Display of a transfer: one line on a terminal, or JSON lines.

use std::io::{IsTerminal as _, Write as _};
use std::time::Duration;

use super::keys::Keys;
use crate::cli::stop::Stop;
use crate::cli::{print, tell, verbosity};
use crate::feed::{FeedView, ShownFaults, ShownTexts};
use ncfix_dnc::feed::Event;
use ncfix_report::feed::{FeedEvent, Said, Status};
use ncfix_report::json;

/// Time between two updates of the terminal, and between two JSON lines.
const REFRESH: Duration = Duration::from_millis(200);
const REFRESH_JSON: Duration = Duration::from_secs(1);

/// Shorter pauses are normal for controls with small buffers.
const LONG_PAUSE: Duration = Duration::from_secs(2);

/// Display of a transfer.
pub(super) struct Show {
    is_json: bool,
    is_terminal: bool,
    shown: Option<Duration>,
    /// True if a line is on the terminal.
    is_drawn: bool,
    faults: ShownFaults,
    /// Start of a pause of the control; true if it was reported.
    paused: Option<(Duration, bool)>,
    texts: ShownTexts,
    keys: Keys,
}

impl Show {
    /// An empty display.
    ///
    /// # Errors
    /// If Ctrl-C cannot be caught.
    pub(super) fn new(is_json: bool) -> Result<Show, Stop> {
        Ok(Show {
            is_json,
            is_terminal: std::io::stderr().is_terminal() && !verbosity::is_quiet(),
            shown: None,
            is_drawn: false,
            faults: ShownFaults::default(),
            paused: None,
            texts: ShownTexts::default(),
            keys: Keys::new()?,
        })
    }

    fn said(&mut self, text: &str, now: Duration) {
        if let Some(message) = self.texts.next(text) {
            self.say(FeedEvent::Said, now, None, message);
        }
    }

    /// Shows the end of the transfer.
    ///
    /// # Errors
    /// If standard output cannot be written.
    pub(super) fn end(&mut self, status: &Status) -> Result<(), Stop> {
        self.clear();
        if self.is_json {
            return print(&json::line(status).map_err(Stop::Usage)?);
        }
        tell(&status.table());
        Ok(())
    }

    /// A reader that went away does not end a transfer.
    fn out(&self, line: Result<String, String>) {
        if let Ok(line) = line {
            let _ = print(&line);
        }
    }

    fn draw(&mut self, line: &str) {
        self.is_drawn = true;
        let _ = write!(std::io::stderr(), "\r{line}\u{1b}[K");
    }

    fn clear(&mut self) {
        if std::mem::take(&mut self.is_drawn) {
            let _ = write!(std::io::stderr(), "\r\u{1b}[K");
        }
    }
}

impl FeedView for Show {
    fn is_due(&self, now: Duration) -> bool {
        let refresh = if self.is_json { REFRESH_JSON } else { REFRESH };
        (self.is_json || self.is_terminal) && self.shown.is_none_or(|shown| now.saturating_sub(shown) >= refresh)
    }

    fn status(&mut self, status: &Status, now: Duration) {
        self.shown = Some(now);
        if self.is_json {
            self.out(json::line(status));
        } else {
            self.draw(&status.line());
        }
    }

    fn waiting(&mut self, what: &str, now: Duration) {
        if !self.is_json && self.is_terminal && self.is_due(now) {
            self.shown = Some(now);
            self.draw(what);
        }
    }

    fn event(&mut self, event: &Event, now: Duration) {
        match event {
            Event::Said(text) => self.said(text, now),
            Event::Stalled => {
                self.say(FeedEvent::Stalled, now, None, "no answer for longer than a line should take".into())
            }
            Event::Paused(true) => self.paused = Some((now, false)),
            Event::Paused(false) => {
                if let Some((_, true)) = self.paused.take() {
                    self.say(FeedEvent::Paused, now, None, "the control continues".into());
                }
            }
            Event::Holds(most, said) if self.is_json => {
                self.say(
                    FeedEvent::Holds,
                    now,
                    None,
                    format!("the control may hold {most} blocks that it has accepted but not executed ({said})"),
                );
            }
            Event::Repeated(number) => {
                self.say(FeedEvent::Repeated, now, Some(*number), format!("sending line {number} again"))
            }
            // Counts and reports are in the status, and ends are reported at the end.
            _ => {}
        }
    }

    fn tick(&mut self, now: Duration) {
        if let Some((since, is_said @ false)) = &mut self.paused
            && now.saturating_sub(*since) >= LONG_PAUSE
        {
            *is_said = true;
            self.say(
                FeedEvent::Paused,
                now,
                None,
                "the control pauses: it is on hold, or its buffer is full; after M0, press cycle start".into(),
            );
        }
    }

    fn frozen(&mut self, why: &str, now: Duration) {
        if let Some(message) = self.faults.frozen(why) {
            self.say(FeedEvent::Sensors, now, None, message);
        }
    }

    fn thawed(&mut self, now: Duration) {
        if let Some(message) = self.faults.thawed() {
            self.say(FeedEvent::Sensors, now, None, message);
        }
    }

    fn say(&mut self, event: FeedEvent, now: Duration, line: Option<u64>, message: String) {
        if self.is_json {
            let said = Said { schema: 1, event, time_s: now.as_secs_f64(), line, message };
            self.out(json::line(&said));
        } else {
            self.clear();
            tell(&format!("{message}\n"));
        }
    }

    fn is_stopped(&mut self) -> bool {
        self.keys.pressed()
    }
}
