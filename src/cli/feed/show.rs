//! What a transfer shows: one line on a terminal, or JSON lines.

use std::collections::BTreeMap;
use std::io::{IsTerminal as _, Write as _};
use std::time::Duration;

use crate::cli::stop::Stop;
use crate::cli::{print, tell, voice};
use ncfix_base::geometry::{AXES, AXIS_COUNT};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_dnc::feed::Event;
use ncfix_report::feed::{Said, Status};
use ncfix_report::json;

/// Time between two lines for people, and between two for programs.
const REFRESH: Duration = Duration::from_millis(200);
const REFRESH_JSON: Duration = Duration::from_secs(1);

/// A control that pauses no longer than this does what controls with small buffers do all the time.
const LONG_PAUSE: Duration = Duration::from_secs(2);
/// Of what a control says so many characters are shown, and so many texts; the journal has them all.
const MOST_CHARACTERS: usize = 200;
const MOST_TEXTS: u32 = 100;

/// Shows.
pub(super) struct Show {
    is_json: bool,
    is_terminal: bool,
    shown: Option<Duration>,
    /// Whether a line stands on the terminal.
    is_drawn: bool,
    /// What is in doubt, so that it is said once.
    frozen: Option<String>,
    /// Since when the control pauses, and whether that was said.
    paused: Option<(Duration, bool)>,
    texts: u32,
}

impl Show {
    pub(super) fn new(is_json: bool) -> Show {
        Show {
            is_json,
            is_terminal: std::io::stderr().is_terminal() && !voice::is_quiet(),
            shown: None,
            is_drawn: false,
            frozen: None,
            paused: None,
            texts: 0,
        }
    }

    /// Whether it is time to show where it stands.
    pub(super) fn is_due(&self, now: Duration) -> bool {
        let refresh = if self.is_json { REFRESH_JSON } else { REFRESH };
        (self.is_json || self.is_terminal) && self.shown.is_none_or(|shown| now.saturating_sub(shown) >= refresh)
    }

    /// Shows where it stands.
    pub(super) fn status(&mut self, status: &Status, now: Duration) {
        self.shown = Some(now);
        if self.is_json {
            self.out(json::line(status));
        } else {
            self.draw(&status.line());
        }
    }

    /// Shows what it waits for.
    pub(super) fn waiting(&mut self, what: &str, now: Duration) {
        if !self.is_json && self.is_terminal && self.is_due(now) {
            self.shown = Some(now);
            self.draw(what);
        }
    }

    /// Shows what has happened on the link.
    pub(super) fn event(&mut self, event: &Event, now: Duration) {
        match event {
            Event::Said(text) => self.said(text, now),
            Event::Stalled => self.say("stalled", now, None, "nothing was heard for longer than a line takes".into()),
            Event::Paused(true) => self.paused = Some((now, false)),
            Event::Paused(false) => {
                if let Some((_, true)) = self.paused.take() {
                    self.say("paused", now, None, "the control goes on".into());
                }
            }
            Event::Holds(most, said) if self.is_json => {
                self.say(
                    "holds",
                    now,
                    None,
                    format!("the control may hold {most} blocks that it has taken and not carried out ({said})"),
                );
            }
            Event::Repeated(number) => self.say("repeated", now, Some(*number), format!("line {number} is sent again")),
            // The end says it.
            Event::Acknowledged(_)
            | Event::Checked(_)
            | Event::Left(_)
            | Event::Executed(_)
            | Event::Holds(..)
            | Event::Refused(..)
            | Event::Lost(_) => {}
        }
    }

    /// Time has passed.
    pub(super) fn tick(&mut self, now: Duration) {
        if let Some((since, is_said @ false)) = &mut self.paused
            && now.saturating_sub(*since) >= LONG_PAUSE
        {
            *is_said = true;
            self.say("paused", now, None, "the control pauses: somebody there holds it, or its buffer is full".into());
        }
    }

    fn said(&mut self, text: &str, now: Duration) {
        self.texts = self.texts.saturating_add(1);
        if self.texts > MOST_TEXTS {
            if self.texts == MOST_TEXTS + 1 {
                self.say("said", now, None, "the control says more than is shown here; the journal has it".into());
            }
            return;
        }
        let mut shown: String = text.chars().take(MOST_CHARACTERS).collect();
        if shown.len() < text.len() {
            shown.push('…');
        }
        self.say("said", now, None, format!("the control says: {shown}"));
    }

    /// Sensors are in doubt.
    pub(super) fn frozen(&mut self, why: &str, now: Duration) {
        if self.frozen.as_deref() != Some(why) {
            self.frozen = Some(why.to_owned());
            self.say("sensors", now, None, format!("sensors are in doubt, the correction is frozen: {why}"));
        }
    }

    /// They are good again.
    pub(super) fn thawed(&mut self, now: Duration) {
        if self.frozen.take().is_some() {
            self.say("sensors", now, None, "the sensors are good again".into());
        }
    }

    /// Says something.
    pub(super) fn say(&mut self, event: &'static str, now: Duration, line: Option<u64>, message: String) {
        if self.is_json {
            let said = Said { schema: 1, event, time_s: now.as_secs_f64(), line, message };
            self.out(json::line(&said));
        } else {
            self.clear();
            tell(&format!("{message}\n"));
        }
    }

    /// Shows how it ended.
    ///
    /// # Errors
    /// Where standard output cannot be written.
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

/// Axes with a shift, or for which one is asked.
pub(super) fn axes(values: &[f64; AXIS_COUNT], others: &[f64; AXIS_COUNT]) -> BTreeMap<String, f64> {
    let mut out = BTreeMap::new();
    for axis in AXES {
        let (value, other) = (values[axis.slot()], others[axis.slot()]);
        if value != 0.0 || other != 0.0 {
            let (unit, shown) =
                if axis.is_rotary() { ("urad", urad_from_rad(value)) } else { ("um", um_from_mm(value)) };
            out.insert(format!("{axis}_{unit}"), (shown * 100.0).round() / 100.0);
        }
    }
    out
}
