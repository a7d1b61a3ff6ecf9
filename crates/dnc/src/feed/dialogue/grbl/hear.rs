//! Grbl: meaning of its answers, state by state.
//!
//! Answers of a correct control; any other answer ends the job, because the state of the control is then unknown:
//!
//! | state | answer | meaning |
//! | --- | --- | --- |
//! | greeting, looking | a greeting; a report | it responds; unless it is idle the job ends |
//! | asking | `ok`, `error:N` | for lines of an earlier job, or for the question; the line of `$I` |
//! | zeroing | `[G54:…]`, `[G92:…]`, `[TLO:…]`, `[GC:…]`, two of `ok`, `error:N` | zero offsets and codes in force: the lines of `$#` and `$G` |
//! | lines under way | `ok` | the oldest was taken, not necessarily executed |
//! | | `error:N` | the oldest was refused: the axes are held, the other answers are awaited |
//! | any | a report that fits the count | buffer state; one more line may be in its parser |
//! | | `[MSG:…]`, `[PRB:…]`, `[GC:…]`, `[echo:…]` | shown |
//! | none under way | `ok`, `error:N` | impossible: an answer came twice |
//! | any but greeting | a greeting, `>…:ok` (startup lines), `ALARM:N` | it was reset, or is in alarm: its lines are lost |

use std::sync::LazyLock;
use std::time::Duration;

use ncfix_base::pattern::{RegexSet, patterns};

use super::counts::CountVerdict;
use super::place::StandstillVerdict;
use super::status::{GrblReport, GrblState};
use super::{ASK_EVERY, Event, Grbl, HOLD, MARGIN, NO_LINE, RUN_UP, STEPPED, State, Wire};
use crate::feed::dialogue::LossKind;
use crate::feed::dialogue::answers::{impossible, is_greeting, shown};
use crate::feed::dialogue::depth::not_idle;
use crate::feed::dialogue::position::elsewhere;

/// Answers other than `ok` and those with a code, addressed by their position in this list.
static ANSWERS: LazyLock<RegexSet> = LazyLock::new(|| {
    patterns([
        // `>G54G20:ok`: the control carries out its startup lines.
        "^>.*:",
        // `[MSG:'$H'|'$X' to unlock]`, `[MSG:Reset to continue]`
        "(?-i)to unlock|Reset to continue",
        // `[MSG:Caution: Unlocked]`, `[PRB:…]`, `[GC:…]`, `[echo:…]`: unsolicited notices.
        r"(?-i)^\[(?:MSG|PRB|GC|echo):",
    ])
});
const STARTING: usize = 0;
const LOCKED: usize = 1;
const NOTICE: usize = 2;

impl Grbl {
    pub(super) fn answer(&mut self, text: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let is_info = self.state == State::Asking && text.starts_with('[');
        self.has_told |= is_info;
        let found = ANSWERS.matches(text.as_bytes());
        let is = |answer| found.matched(answer);
        if is_greeting(text) && !is_info {
            match self.state {
                State::Greeting => self.ask_for_buffers(wire),
                _ => self.lost("the control was reset", events),
            }
        } else if let Some(status) = GrblReport::read(text) {
            self.report((&status, text), now, wire, events);
        } else if let Some(options) = text.strip_prefix("[OPT:").and_then(|text| text.strip_suffix(']'))
            && is_info
        {
            self.depth.hear(options.split(',').nth(1), STEPPED, text);
            let numbers: Vec<usize> = options.split(',').skip(1).filter_map(|number| number.parse().ok()).collect();
            if let Some(&bytes) = numbers.get(1) {
                self.counts.has(bytes);
                self.window.1 = self.window.1.min(bytes.saturating_sub(MARGIN)).max(1);
            }
        } else if let Some(axes) = text.strip_prefix("[AXS:").and_then(|text| text.strip_suffix(']'))
            && is_info
        {
            self.place.has_axes(axes);
            self.zero.has_axes(axes);
        } else if self.state == State::Zeroing && text.starts_with('[') {
            self.zero.hear(text);
        } else if text == "ok" {
            self.acknowledge(now, wire, events);
        } else if let Some(code) = text.strip_prefix("error:") {
            self.refuse(code, now, wire, events);
        } else if let Some(code) = text.strip_prefix("ALARM:") {
            self.lost(&format!("the control is in alarm {}", shown(code)), events);
        } else if is(STARTING) && self.state != State::Greeting {
            self.lost("the control was reset: it executes its start-up lines", events);
        } else if is(LOCKED) {
            self.lost("the control is in alarm, or was reset", events);
        } else if is_info || is(NOTICE) {
            events.push(Event::Said(text.to_owned()));
        } else if !text.is_empty() && self.state != State::Greeting {
            // It may have been a refusal.
            let what = format!("an answer cannot be read, '{}', and may have been a refusal", shown(text));
            self.lost(&impossible(&what), events);
        }
    }

    fn ask_for_buffers(&mut self, wire: &mut Wire) {
        self.state = State::Asking;
        wire.push(b"$I\n");
    }

    /// Asks for the zero offsets if they are to be compared.
    fn ask_for_zeros(&mut self, now: Duration, wire: &mut Wire) {
        (self.state, self.asked) = (State::Looking, 0);
        if self.zero.is_expected() {
            (self.state, self.moved) = (State::Zeroing, now);
            wire.push(b"$#\n$G\n");
        }
    }

    fn zeros_answered(&mut self) {
        if self.zero.answered() {
            (self.state, self.asked) = (State::Looking, 0);
        }
    }

    fn acknowledge(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.state == State::Asking {
            self.has_answered = true;
            if self.has_told {
                self.ask_for_zeros(now, wire);
            }
        } else if self.state == State::Zeroing {
            self.zeros_answered();
        } else if let Some((number, length, _)) = self.in_flight.pop_front() {
            self.bytes -= length;
            self.moved = now;
            self.counts.answered(length);
            if number == NO_LINE {
                (self.is_drained, self.idle) = (true, 0);
            } else {
                self.acknowledged = number;
                if !self.tells_buffers {
                    self.confirm(events);
                }
            }
        } else if matches!(self.state, State::Open | State::Closed) {
            self.lost(&impossible("the control has answered more lines than were sent"), events);
        } else if self.state == State::Refusing {
            self.surplus += 1;
        }
    }

    /// Reports the acknowledged lines once a report fits them. After a reset, answers to later lines would otherwise be counted for the lost ones.
    pub(super) fn confirm(&mut self, events: &mut Vec<Event>) {
        if self.confirmed < self.acknowledged {
            self.confirmed = self.acknowledged;
            events.push(Event::Acknowledged(self.acknowledged));
        }
    }

    /// Reports the lines that were certainly taken; a duplicate answer does not count.
    fn check(&mut self, status: &GrblReport<'_>, events: &mut Vec<Event>) {
        let taken = self.counts.taken(status).min(self.acknowledged);
        if taken > self.checked {
            self.checked = taken;
            events.push(Event::Checked(taken));
        }
    }

    fn refuse(&mut self, code: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.state == State::Asking {
            self.has_answered = true;
        } else if self.state == State::Zeroing {
            self.zeros_answered();
        } else if let Some((number, length, _)) = self.in_flight.pop_front() {
            self.bytes -= length;
            self.counts.answered(length);
            if self.state != State::Refusing {
                wire.push_urgent(HOLD);
                self.state = State::Refusing;
                self.refusal = (number, format!("error:{}", shown(code)));
                self.refused_at = now;
            }
        } else if matches!(self.state, State::Open | State::Closed) {
            wire.push_urgent(HOLD);
            let what = format!(
                "the control has refused a line with error:{}, and answered more lines than were sent",
                shown(code)
            );
            self.lost(&impossible(&what), events);
        }
    }

    /// Reports the refused line. It is certain if all sent lines were taken and have one answer each.
    pub(super) fn refused(&mut self, is_taken: bool, events: &mut Vec<Event>) {
        let (number, said) = std::mem::take(&mut self.refusal);
        let what =
            "the axes are in hold; cycle start (~) would execute the lines after it, a reset (Ctrl-X) discards them";
        if is_taken && self.surplus == 0 && self.in_flight.is_empty() && number != NO_LINE {
            self.state = State::Over;
            // The lines after it were answered, too; the refused line was not executed.
            self.acknowledged = self.acknowledged.min(number.saturating_sub(1));
            self.confirm(events);
            events.push(Event::Refused(number, format!("{said}; {what}")));
        } else {
            // An answer that came twice, or none, shifts the count to either side.
            let first = number.saturating_sub(self.surplus.max(1)).max(1);
            let lines = if first < number { format!("{first}, {number}") } else { format!("{number}") };
            self.lost(&format!("the control has refused line {lines} or a later one with {said} (the answers do not show which); {what}"), events);
        }
    }

    fn report(
        &mut self,
        (status, text): (&GrblReport<'_>, &str),
        now: Duration,
        wire: &mut Wire,
        events: &mut Vec<Event>,
    ) {
        let is_asked = std::mem::take(&mut self.asked) > 0;
        self.counts.see(status);
        self.place.see(status);
        self.tells_buffers |= status.free_bytes.is_some();
        if status.word == GrblState::Idle && self.in_flight.is_empty() {
            let blocks = status.free_blocks.map(|blocks| blocks.to_string());
            self.depth.hear(blocks.as_deref(), STEPPED, text);
        }
        if matches!(self.state, State::Greeting | State::Asking | State::Zeroing | State::Looking) {
            // Before the first line the control must be idle.
            let state = text.trim_start_matches('<').split(['|', '>']).next().unwrap_or_default();
            match not_idle(state) {
                // Answers to questions of an earlier job may still be in the port, so the same must be said to a later question.
                Some(why) => {
                    let since = *self.busy_since.get_or_insert(now);
                    if now.saturating_sub(since) >= ASK_EVERY {
                        self.lost(&why, events);
                    }
                    return;
                }
                None if self.state == State::Greeting => return self.ask_for_buffers(wire),
                None if self.state == State::Looking => return self.begin(events),
                None => {}
            }
        }
        let why = match status.word {
            GrblState::Alarm => "the control is in alarm",
            GrblState::Sleep => "the control is asleep: its axes have no power, and it must be reset",
            GrblState::Check => "the control is in its check mode ($C): it accepts lines but moves nothing",
            GrblState::ByHand => "the axes are being jogged or homed at the control",
            GrblState::Odd => {
                return self
                    .lost(&impossible(&format!("the control reports an unknown state, {}", shown(text))), events);
            }
            GrblState::Idle | GrblState::Run | GrblState::Held => "",
        };
        if !why.is_empty() {
            return self.lost(why, events);
        }
        let is_held = status.word == GrblState::Held;
        if std::mem::replace(&mut self.is_held, is_held) != is_held && self.state != State::Refusing {
            self.moved = now;
            events.push(Event::Paused(is_held));
        }
        if let Some(why) = self.zero.see(status.offset)
            && self.state != State::Refusing
        {
            return self.lost(&why, events);
        }
        let is_empty = self.counts.is_empty(status);
        let rests = status.word == GrblState::Idle && is_empty != Some(false) && self.counts.has_no_block(status);
        self.rests_since = rests.then(|| self.rests_since.unwrap_or(now));
        if self.state == State::Refusing {
            // While the axes are held, lines may wait for the planner without an answer.
            let is_taken = is_empty == Some(true);
            if self.in_flight.is_empty() || is_taken {
                self.refused(is_taken, events);
            }
            return;
        }
        let is_idle = status.word == GrblState::Idle && is_empty != Some(false) && wire.waiting() == 0;
        // An unsolicited report may be older.
        self.idle = if is_idle { self.idle + u32::from(is_asked) } else { 0 };
        if self.state == State::Zeroing {
            return;
        }
        if self.state == State::Asking {
            // It has nothing more to answer, so the last answer was that to the question.
            if self.idle >= 2 && self.has_answered {
                self.begin(events);
            }
            return;
        }
        let longest = self.longest();
        match self.counts.judge(status, is_asked, longest, wire.waiting()) {
            CountVerdict::Surplus => {
                let what = "the control holds more lines than were unanswered; an answer came twice";
                return self.lost(&impossible(what), events);
            }
            CountVerdict::Missing => {
                let what = "answers are missing for lines that the control no longer has, as after a reset";
                return self.lost(&impossible(what), events);
            }
            // The answer to the dwell after the last line may be counted for that line.
            CountVerdict::Fits if is_asked && !self.has_barrier => {
                self.confirm(events);
                self.check(status, events);
            }
            CountVerdict::Fits | CountVerdict::Doubt | CountVerdict::Silent => {}
        }
        // Two reports: the first may be older than the last bytes.
        if self.idle >= 2 && self.is_drained && self.in_flight.is_empty() && self.sure < self.acknowledged {
            let agreed = match self.place.look(status) {
                StandstillVerdict::Again => return,
                StandstillVerdict::Differs(why) => {
                    // Every line was answered, and the dwell after it.
                    self.confirm(events);
                    return self.lose(LossKind::AtAnotherPosition, &elsewhere(&why), events);
                }
                StandstillVerdict::Done(agreed) => agreed,
            };
            self.confirm(events);
            self.sure = self.acknowledged;
            events.push(Event::Executed(self.acknowledged));
            events.extend(agreed.map(Event::InPosition));
            if self.state == State::Open {
                (self.is_due, self.has_barrier, self.is_drained) = (false, false, false);
                self.barrier.is_over();
            }
        }
        // The control reports idle during a dwell, and while its spindle runs up. If it stays idle for longer and has nothing to read, an answer is missing,
        // which may have been a refusal.
        let patience = if self.tells_buffers { self.patience } else { self.patience.max(RUN_UP) };
        if let Some(since) = self.rests_since
            && let (Some((_, _, busy)), Some((last, _, _))) = (self.in_flight.front(), self.in_flight.back())
            && now.saturating_sub(since.max(self.moved)) > patience + *busy
        {
            // The answer to the dwell may have been counted for the last line.
            let (first, last) =
                if *last == NO_LINE { (self.confirmed, self.acknowledged) } else { (self.acknowledged, *last) };
            let lines = if first + 1 < last {
                format!("one of the lines {} to {last}", first + 1)
            } else {
                format!("line {last}")
            };
            let what = format!(
                "an answer was lost: the control is idle, has nothing to read and sends no more answers, but {lines} may have been refused"
            );
            self.lost(&impossible(&what), events);
        }
    }
}
