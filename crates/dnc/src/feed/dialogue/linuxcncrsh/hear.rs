//! LinuxCNC: meaning of the answers of linuxcncrsh, state by state.
//!
//! Answers of a correct control; any other answer ends the job, because the state of the control is then unknown:
//!
//! | state | answer | meaning |
//! | --- | --- | --- |
//! | greeting | the answer to the question of the step (see `greeting`); anything before `set echo off` | the next question, or the reason of the refusal |
//! | none under way | `error: …`, `warning: …` | kept for the line |
//! | line sent | `SET MDI ACK`, `SET MDI NAK` | it was received; it was not received, and nothing of it moves |
//! | running, asked | `PROGRAM_STATUS RUNNING`, `PAUSED`, `IDLE` | it runs; a person holds it; it has ended |
//! | checking | `SET WAIT ACK` or `NAK`, `ENABLE`, `MACHINE`, `MODE`, `SPINDLE`, `ABS_CMD_POS`, `REL_CMD_POS`, `ERROR` in this order | executed or not, state unchanged or not, position |
//! | showing | `OPERATOR_DISPLAY …` | the printed zero offsets, or a message of another program |
//! | aborting | `SET ABORT …` | it has stopped; everything before it is skipped |

use std::time::Duration;

use super::place::numbers;
use super::{CHECKS, Event, MOST_MESSAGES, Rsh, Stage, Wire};
use crate::feed::dialogue::answers::{impossible, shown};

impl Rsh {
    /// Handles an answer while lines are sent. Each question has one answer, and answers come in order; anything else is impossible.
    pub(super) fn answer(&mut self, answer: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if answer.is_empty() {
            return;
        }
        if answer.starts_with("error:") || answer.starts_with("warning:") {
            self.messages.push(answer.to_owned());
            return;
        }
        // A person asked for it.
        if answer.starts_with("SET PAUSE ") {
            return;
        }
        let Some(line) = &mut self.under_way else { return self.is_none(answer, events) };
        match (line.stage, answer) {
            (Stage::Sent, "SET MDI ACK") => {
                line.stage = Stage::Running;
                self.ask(now, wire);
            }
            // It was not received: nothing of it moves.
            (Stage::Sent, "SET MDI NAK") => {
                line.is_received = false;
                line.stage = Stage::Checking;
                wire.push(CHECKS);
            }
            (Stage::Running, "PROGRAM_STATUS IDLE") if self.is_asked => {
                line.stage = Stage::Checking;
                wire.push(CHECKS);
                self.pause(false, events);
            }
            (Stage::Running, "PROGRAM_STATUS RUNNING" | "PROGRAM_STATUS PAUSED") if self.is_asked => {
                self.is_asked = false;
                self.pause(answer.ends_with("PAUSED"), events);
            }
            (Stage::Checking, _) => self.check(answer, now, wire, events),
            (Stage::Showing, _) => self.show(answer, now, wire, events),
            _ => self.is_none(answer, events),
        }
    }

    /// Handles an answer to one of [`CHECKS`].
    fn check(&mut self, answer: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let Some(line) = &mut self.under_way else { return };
        let said = |begin: &str| answer.strip_prefix(begin);
        let seen = &mut self.seen;
        let is_next = match line.answered {
            0 => said("SET WAIT")
                .map(|end| line.is_done = end.ends_with("ACK"))
                .filter(|()| answer.ends_with("ACK") || answer.ends_with("NAK")),
            1 => said("ENABLE ").map(|state| seen.is_ours = state == "ON"),
            2 => said("MACHINE ").map(|state| seen.is_on = state == "ON"),
            3 => said("MODE ").map(|mode| seen.is_mdi = mode == "MDI"),
            4 => said("SPINDLE").map(|state| seen.turns = !state.ends_with("OFF")),
            5 => said("ABS_CMD_POS ").and_then(numbers).map(|all| self.place.absolute = all),
            6 => said("REL_CMD_POS ").and_then(numbers).map(|all| self.place.relative = all),
            _ => said("ERROR ").map(|_| ()),
        };
        if is_next.is_none() {
            return self.is_none(answer, events);
        }
        line.answered += 1;
        if answer == "ERROR OK" {
            if line.number == 0 && line.is_asking {
                line.stage = Stage::Showing;
                return wire.push(b"get operator_display\r\n");
            }
            self.conclude(now, wire, events);
        } else if let Some(message) = answer.strip_prefix("ERROR ") {
            self.messages.push(message.to_owned());
            if self.messages.len() >= MOST_MESSAGES {
                self.conclude(now, wire, events);
            } else {
                wire.push(b"get error\r\n");
            }
        }
    }

    /// Handles an answer to the question for printed parameters. Messages of others may come first.
    fn show(&mut self, answer: &str, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let Some(message) = answer.strip_prefix("OPERATOR_DISPLAY ") else { return self.is_none(answer, events) };
        if message != "OK" && !self.printed(message) {
            events.push(Event::Said(answer.to_owned()));
            self.others += 1;
            if self.others < MOST_MESSAGES {
                return wire.push(b"get operator_display\r\n");
            }
        }
        self.conclude(now, wire, events);
    }

    pub(super) fn is_none(&mut self, answer: &str, events: &mut Vec<Event>) {
        let what = format!("'{}' is not an answer to the query", shown(answer));
        self.lost(&impossible(&what), events);
    }
}
