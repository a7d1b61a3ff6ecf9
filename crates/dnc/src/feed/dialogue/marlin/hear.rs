//! Marlin: meaning of its answers, state by state.
//!
//! Answers of a correct control; any other answer ends the job, because the state of the control is then unknown:
//!
//! | state | answer | meaning |
//! | --- | --- | --- |
//! | opening | a greeting | it starts: the line count is set again |
//! | | any demand, while the count is set | it still has another count |
//! | | `ok` before the text of the mark | for lines of an earlier job |
//! | line n under way | `ok`, `ok Nn …` | it was taken, not necessarily executed |
//! | | `Resend: n` | it arrived damaged: it is sent again |
//! | | `Resend: n+1` | it was taken and a copy refused: possible if there was a copy, or if the fault names n |
//! | none under way | `Resend: next` | a copy was refused: possible if there was one |
//! | any | `Error:…, Last Line: m` | m is the line before the demanded one |
//! | | `ok` after a fault or a demand | it takes no line |
//! | | `wait` | its queue is empty: not a sign of activity |
//! | | `…busy: …` | it works on a line, or waits for a person |
//! | | `//action:pause`, `//action:resume` | no line is sent in between |
//! | | temperatures, positions, capabilities, memory cards, notices | shown; the list is in [`super::texts`] |
//! | opening | any other text | shown: nothing has been sent yet |
//! | asked with `M114` | a position | compared with that of the lines sent |
//! | asked with `M114 D` | `Logical:`, `Raw:` and further positions | the zero offset in force |
//! | closing | the text of the mark, `ok` | all moves are done |
//! | any but opening | a greeting | it was reset |
//! | | any other `Error`, `!!`, an end switch, an axis that is not homed | it has stopped, or omits moves |
//! | | any other text | it may mean that a line was not executed: its state is unknown |
//!
//! A demand for a line before these means that the control has lost its count. A demand for a line after them was disturbed.

use std::sync::LazyLock;
use std::time::Duration;

use ncfix_base::pattern::{Regex, RegexSet, pattern, patterns};

use super::texts::{MarlinText, meaning};
use super::{BEYOND, Event, FIRST_NUMBER, Marlin, NO_OK, QUIET, START, State, What, Wire, mark};
use crate::feed::dialogue::answers::{impossible, is_greeting, shown};
use crate::feed::dialogue::position::number as value_of;

/// Answers in upper or lower case, addressed by their position in this list.
static ANSWERS: LazyLock<RegexSet> = LazyLock::new(|| {
    patterns([
        // `ok`, `ok N5 P15 B3`
        "^(?-i:ok(?: |$))",
        // `Resend: 5`, `rs N5`
        "^(?:resend|rs )",
        // `Error:Line Number is not Last Line Number+1, Last Line: 5`: the line is demanded again.
        "^error:.*(?:checksum|line number|expected line|last line)",
        "^echo:unknown command",
        // `echo:busy: processing`, `echo:busy: paused for user`
        "busy:",
        "paused",
    ])
});
const OK: usize = 0;
const DEMAND: usize = 1;
const FAULT: usize = 2;
const UNKNOWN: usize = 3;
const BUSY: usize = 4;
const PAUSED: usize = 5;

/// Returns the number at the beginning of a text, after blanks and its label: `: 5`, `N5`, ` n.5`.
fn number(text: &str) -> Option<u64> {
    static NUMBER: LazyLock<Option<Regex>> = LazyLock::new(|| pattern("(?-i)^[: N.]*([+]?[0-9]+)(?:[ ,]|$)").ok());
    let digits = NUMBER.as_ref()?.captures(text.as_bytes())?.get(1)?;
    text.get(digits.range())?.parse().ok()
}

/// Reads `X:1.00 Y:2.00 Z:3.00 E:0.00 Count X:80 Y:160 Z:1200`: axis letters with their positions and digits; `None` if it is another text.
fn position(text: &str) -> Option<Vec<(u8, f64, usize)>> {
    let stated = text.split(" Count").next().filter(|stated| stated.starts_with("X:"))?;
    let axis = |word: &str| {
        let (letter, value) = word.split_once(':')?;
        let &[letter] = letter.as_bytes() else { return None };
        let (value, digits) = value_of(value)?;
        Some((letter, value, digits))
    };
    stated.split_ascii_whitespace().map(axis).collect()
}

impl Marlin {
    fn is_under_way(&self, what: What) -> bool {
        self.under_way.as_ref().is_some_and(|sent| sent.what == what)
    }

    pub(super) fn answer(&mut self, text: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let low = text.to_ascii_lowercase();
        let found = ANSWERS.matches(text.as_bytes());
        let is = |answer| found.matched(answer);
        if low != "wait" {
            self.last_heard = now;
        }
        if is_greeting(text) {
            if self.state == State::Opening {
                // It is still identifying itself: the count is set afterwards.
                self.prepare();
                self.again = Some((FIRST_NUMBER, now + START));
            } else {
                self.lost("the control was reset", events);
            }
        } else if self
            .under_way
            .as_ref()
            .is_some_and(|sent| sent.what == What::Mark && text.contains(&mark(sent.number)))
        {
            self.is_marked = true;
        } else if is(OK) {
            self.hold(false, events);
            self.acknowledge(text, now, wire, events);
        } else if is(DEMAND) {
            self.expect_ok(now);
            let rest = low.strip_prefix("resend").or_else(|| low.strip_prefix("rs ")).unwrap_or_default();
            // An unreadable demand is handled by the timeout.
            if let Some(number) = number(&rest.to_ascii_uppercase()) {
                self.demand(number, now, events);
            }
        } else if is(FAULT) {
            self.expect_ok(now);
            if let Some(last) = low.rsplit_once("last line").and_then(|(_, last)| number(last)) {
                self.name(last, events);
            }
        } else if is(UNKNOWN) && (self.is_under_way(What::Where) || self.is_under_way(What::Zero)) {
            // Firmware without this question: its position is not compared.
        } else if is(UNKNOWN) && self.under_way.is_some() && self.state != State::Opening {
            // It would skip a zero offset or a tool length and continue.
            match self.under_way.as_ref().map(|sent| sent.what) {
                Some(What::Line(line)) => {
                    self.state = State::Over;
                    events.push(Event::Refused(line, shown(text)));
                }
                _ => self
                    .lost(&format!("the control does not accept the commands that end a job: {}", shown(text)), events),
            }
        } else if is(BUSY) {
            self.hold(is(PAUSED), events);
        } else if self.is_under_way(What::Where)
            && let Some(reported) = position(text)
        {
            self.reported = reported;
        } else if self.is_under_way(What::Zero) && self.hear_detail(text) {
            // Compared when the answer is complete.
        } else {
            self.text(text, events);
        }
    }

    /// Handles an unsolicited text.
    fn text(&mut self, text: &str, events: &mut Vec<Event>) {
        match meaning(text) {
            MarlinText::Harmless if text.is_empty() || text.eq_ignore_ascii_case("wait") => {}
            MarlinText::Harmless => events.push(Event::Said(text.to_owned())),
            MarlinText::Pause(is_paused) => {
                self.is_paused = is_paused;
                self.say_held(events);
            }
            MarlinText::Ends(why) => self.lost(&format!("{why}: {}", shown(text)), events),
            // Nothing has been sent yet; the control prints many settings at startup.
            MarlinText::Unknown if self.state == State::Opening => events.push(Event::Said(text.to_owned())),
            MarlinText::Unknown => {
                let what = format!(
                    "the control sent an unknown text, '{}', which may mean that a line was not executed",
                    shown(text)
                );
                self.lost(&impossible(&what), events);
            }
        }
    }

    /// A fault or a demand has come: an `ok` after it takes no line.
    fn expect_ok(&mut self, now: Duration) {
        let number = self.under_way.as_ref().map_or(self.next, |sent| sent.number);
        self.is_closing = true;
        self.again.get_or_insert((number, now + self.patience));
    }

    /// Notes whether the control waits for a person, as the line under way shows.
    fn hold(&mut self, is_waiting: bool, events: &mut Vec<Event>) {
        self.is_waiting = is_waiting;
        self.say_held(events);
    }

    fn say_held(&mut self, events: &mut Vec<Event>) {
        let is_held = self.is_waiting || self.is_paused;
        if std::mem::replace(&mut self.is_held, is_held) != is_held {
            events.push(Event::Paused(is_held));
        }
    }

    fn acknowledge(&mut self, text: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if std::mem::take(&mut self.is_closing) {
            // It takes no line. The demanded line is sent after a silence.
            self.again = self.again.map(|(number, _)| (number, now + QUIET));
            return;
        }
        let Some(sent) = &self.under_way else {
            let what = "the control has answered more lines than were sent";
            return self.lost(&impossible(what), events);
        };
        let number = sent.number;
        let named =
            text.split(' ').find_map(|word| word.strip_prefix('N')).and_then(|number| number.parse::<u64>().ok());
        if named.is_some_and(|named| named != sent.number) && self.state != State::Opening {
            let what = format!("the control has answered '{}' while N{} is in progress", shown(text), sent.number);
            return self.lost(&impossible(&what), events);
        }
        // All moves are done, so the planner is empty (ADVANCED_OK).
        if self.state == State::Opening && named == Some(sent.number) && sent.what != What::Count {
            let places = text.split(' ').find_map(|word| word.strip_prefix('P'));
            self.depth.hear(places, BEYOND, text);
        }
        // Before the text of a mark they belong to earlier lines.
        if sent.what != What::Mark || self.is_marked {
            self.take(named == Some(number), now, wire, events);
        }
    }

    /// Handles the last taken line that a fault names.
    fn name(&mut self, last: u64, events: &mut Vec<Event>) {
        let is_known = match &self.under_way {
            Some(sent) => sent.what == What::Count || last == sent.number || last + 1 == sent.number,
            None => last + 1 == self.next,
        };
        if is_known {
            self.named = Some(last);
        } else {
            let what = format!("the control reports N{last} as its last accepted line, {}", self.standing());
            self.lost(&impossible(&what), events);
        }
    }

    /// Handles a demand for a line.
    fn demand(&mut self, number: u64, now: Duration, events: &mut Vec<Event>) {
        // The fault before it must name the same line.
        let named = self.named.map(|last| last + 1);
        let agrees = named.is_none_or(|named| named == number);
        let is_possible = agrees
            && match &self.under_way {
                Some(sent) if sent.what == What::Count => true,
                Some(sent) => {
                    number == sent.number || number == sent.number + 1 && (sent.copies > 1 || named == Some(number))
                }
                None => number == self.next && (self.last_copies > 1 || named == Some(number)),
            };
        if !is_possible {
            let what = format!("the control asks for N{number}, {}", self.standing());
            return self.lost(&impossible(&what), events);
        }
        let number = match &self.under_way {
            Some(sent) if sent.what == What::Count => sent.number,
            _ => number,
        };
        self.again = Some((number, now + NO_OK));
    }

    fn standing(&self) -> String {
        let next = self.next;
        match &self.under_way {
            Some(sent) => format!("while N{} is in progress: it has lost count", sent.number),
            None => format!("while N{next} is next: it has lost count"),
        }
    }
}
