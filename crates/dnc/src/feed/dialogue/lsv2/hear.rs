//! Answers of the control to each question, and the step after each.

use std::time::Duration;

use super::decode::{self, NO_FILE, ProgramState, SelectedProgram, TelegramRefusal};
use super::run::RunVerdict;
use super::telegram::Telegram;
use super::{BUFFERS, Event, Layer, LossKind, Lsv2, MOST_MESSAGES, SURPLUS, Step, Wire, impossible};

impl Lsv2 {
    pub(super) fn answer(&mut self, telegram: &Telegram, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if telegram.name.starts_with(b"M_") && self.messages < MOST_MESSAGES {
            // Messages need no answer, and are not answers.
            self.messages += 1;
            return;
        }
        if let Some(refusal) = TelegramRefusal::read(telegram) {
            return self.refuse(refusal, now, wire, events);
        }
        let is_known = if telegram.name == *b"T_OK" && telegram.data.is_empty() {
            self.hear_ok(now, wire, events)
        } else {
            self.hear_data(telegram, now, wire, events)
        };
        if is_known.is_none() {
            let size = telegram.data.len();
            let what = format!("{} with {size} bytes is not an answer to {}", telegram.shown(), self.doing());
            self.lost(&impossible(&what), events);
        }
    }

    /// Handles `T_OK`; `None` if the step expects another telegram.
    fn hear_ok(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) -> Option<()> {
        match self.step {
            Step::Inspect => self.ask(Step::Version, now, wire),
            Step::Buffer(size) => {
                self.telegram = size;
                self.ask(Step::AnswersEnd, now, wire);
            }
            Step::AnswersEnd => {
                self.answers_end = true;
                self.ask_rights(now, wire);
            }
            Step::Dnc => self.ask(Step::Status, now, wire),
            Step::File => self.ask(Step::Exists, now, wire),
            Step::Remove => self.ask(Step::Begin, now, wire),
            Step::Begin => self.ask(Step::Block, now, wire),
            Step::Block => self.hear_block(now, wire, events),
            Step::End => self.hear_end(now, wire),
            Step::Discard => self.discarded(None, now, wire, events),
            Step::Logout => self.step = Step::Closed,
            _ => return None,
        }
        Some(())
    }

    /// Handles a telegram with data; `None` if it is not the answer to the current step.
    fn hear_data(
        &mut self,
        telegram: &Telegram,
        now: Duration,
        wire: &mut Wire,
        events: &mut Vec<Event>,
    ) -> Option<()> {
        let data = |name: &[u8; 4]| (telegram.name == *name).then_some(&telegram.data[..]);
        match self.step {
            Step::Version => {
                events.push(Event::Said(format!("control {}", decode::version(data(b"S_VR")?))));
                self.ask_size(now, wire);
            }
            // Parameters of another length state no size: telegrams stay small.
            Step::Parameters => self.agree(decode::block_length(data(b"S_PR")?).unwrap_or_default(), now, wire),
            Step::Status => self.hear_state(ProgramState::read(data(b"S_RI")?)?, now, wire, events),
            Step::Mode => {
                let (mode, why) = decode::mode(data(b"S_RI")?)?;
                self.seen.mode = mode;
                match why {
                    Some(why) if !self.is_ready => {
                        self.lost(&format!("the control is in the mode {mode}: {why}"), events)
                    }
                    _ => self.ask(Step::Selected, now, wire),
                }
            }
            Step::Selected => self.hear_selected(SelectedProgram::read(data(b"S_RI")?)?, now, wire, events),
            Step::Position | Step::SecondPosition => {
                let position = decode::position(data(b"S_RI")?)?;
                let before = std::mem::replace(&mut self.seen.position, position);
                let moved = decode::has_moved(&before, &self.seen.position);
                self.hear_position(moved, now, wire, events);
            }
            Step::Exists => {
                data(b"S_FI")?;
                self.hear_exists(now, wire, events);
            }
            Step::Read => match data(b"S_FL") {
                Some(bytes) => self.hear_file(bytes, now, wire, events),
                None => {
                    data(b"T_FD").filter(|data| data.is_empty())?;
                    self.compare(now, wire, events);
                }
            },
            _ => return None,
        }
        Some(())
    }

    /// Handles a refusal of the current step.
    fn refuse(&mut self, refusal: TelegramRefusal, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let why = refusal.words();
        match self.step {
            // Without them the transfer is slower, or the end of the file is not answered.
            Step::Parameters | Step::Buffer(_) => self.ask(Step::AnswersEnd, now, wire),
            Step::AnswersEnd => self.ask_rights(now, wire),
            Step::Version => self.ask_size(now, wire),
            Step::Position | Step::SecondPosition => {
                self.has_position = false;
                self.seen.position.clear();
                events.push(Event::Said(format!("no positions: {why}")));
                let selected = std::mem::take(&mut self.seen.selected);
                self.hear_selected(selected, now, wire, events);
            }
            // No program is selected.
            Step::Selected => self.hear_selected(SelectedProgram::default(), now, wire, events),
            Step::Exists if refusal.number == NO_FILE => self.ask(Step::Taking, now, wire),
            Step::Dnc => {
                let help = "its state cannot be asked. The control needs the option for DNC (18), and external access must be on. With watch = false in [file] of your own link file ncfix only transfers the file";
                self.lost(&format!("the control refuses the login DNC: {why}; {help}"), events);
            }
            Step::Block | Step::End => {
                self.discard(format!("the control refuses {}: {why}", self.doing()), now, wire);
            }
            Step::Read if !self.is_ready => {
                self.discard(format!("the file cannot be read back: {why}"), now, wire);
            }
            Step::Discard => self.discarded(Some(why), now, wire, events),
            Step::Logout => self.step = Step::Closed,
            Step::Taking | Step::Standing | Step::Resting | Step::Closed | Step::Over => {
                let what = format!("the control refuses something that it was not asked ({why})");
                self.lost(&impossible(&what), events);
            }
            _ => self.lost(&format!("the control refuses {}: {why}", self.doing()), events),
        }
    }

    /// Agrees on the size of telegrams.
    fn agree(&mut self, most: usize, now: Duration, wire: &mut Wire) {
        let most = most.min(self.most_telegram);
        match BUFFERS.iter().find(|(size, _)| *size <= most) {
            Some((size, _)) => self.ask(Step::Buffer(*size), now, wire),
            None => self.ask(Step::AnswersEnd, now, wire),
        }
    }

    fn ask_rights(&mut self, now: Duration, wire: &mut Wire) {
        self.ask(if self.options.watches { Step::Dnc } else { Step::File }, now, wire);
    }

    /// Asks for the size of telegrams. Over a serial line they stay small.
    fn ask_size(&mut self, now: Duration, wire: &mut Wire) {
        let next = if matches!(self.layer, Layer::Tcp(_)) { Step::Parameters } else { Step::AnswersEnd };
        self.ask(next, now, wire);
    }

    fn hear_state(&mut self, state: ProgramState, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.seen.state = Some(state);
        if self.is_ready || state.is_at_rest() {
            self.ask(Step::Mode, now, wire);
        } else {
            let help = "let it end, or cancel it there";
            self.lost(&format!("the control is not idle ({}): {help}", state.words()), events);
        }
    }

    fn hear_selected(&mut self, selected: SelectedProgram, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.seen.selected = selected;
        match (self.has_position, self.is_ready) {
            (true, _) => self.ask(Step::Position, now, wire),
            (false, true) => self.judge(now, wire, events),
            (false, false) => self.ask(Step::File, now, wire),
        }
    }

    fn hear_position(&mut self, moved: bool, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        if self.is_ready {
            self.judge(now, wire, events);
        } else if self.step == Step::Position {
            self.ask(Step::Standing, now, wire);
        } else if moved {
            self.lost("the axes move although no program runs: wait until they stand still", events);
        } else {
            self.ask(Step::File, now, wire);
        }
    }

    fn hear_exists(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.exists = true;
        if self.options.replaces {
            self.ask(Step::Taking, now, wire);
            return;
        }
        let why = format!(
            "the file {} exists on the control: delete it there, give another path with --to, or set replace = true in [file] of your own link file",
            self.path
        );
        self.lost(&why, events);
    }

    /// Handles the answer to a block.
    fn hear_block(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.answered = self.sent;
        let count = self.ends.partition_point(|end| *end <= self.answered) as u64;
        if count > self.acknowledged {
            self.acknowledged = count;
            events.push(Event::Acknowledged(count));
        }
        if self.sent < self.file.len() && !self.is_stopped {
            self.ask(Step::Block, now, wire);
            return;
        }
        self.ask(Step::End, now, wire);
        if !self.answers_end {
            self.hear_end(now, wire);
        }
    }

    fn hear_end(&mut self, now: Duration, wire: &mut Wire) {
        if self.sent < self.file.len() {
            self.discard(String::new(), now, wire);
        } else {
            self.ask(Step::Read, now, wire);
        }
    }

    /// Handles a block of the file that is read back.
    fn hear_file(&mut self, bytes: &[u8], now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.read_back.take(bytes, &self.file);
        if self.read_back.count() > self.file.len() + SURPLUS || bytes.is_empty() {
            return self.lost("the file that is read back does not end", events);
        }
        self.send_telegram(*b"T_OK", Vec::new(), now, wire);
    }

    /// Compares the file that was read back.
    fn compare(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        let difference = self.read_back.finish(&self.file);
        match (difference, self.is_ready) {
            (Some(difference), false) => {
                let why = format!("the file on the control differs from the program: {difference}");
                self.discard(why, now, wire);
            }
            (Some(difference), true) => {
                let why = format!(
                    "the program has finished, but its file on the control was changed: {difference}. It is not certain that the corrected lines were executed"
                );
                self.lost(&why, events);
            }
            (None, false) => {
                self.is_ready = true;
                events.push(Event::Checked(self.acknowledged));
                let what =
                    format!("the control has the program as {}, and it was read back without a difference", self.path);
                if !self.options.watches || self.is_stopped {
                    events.push(Event::Said(what));
                    self.ask(Step::Logout, now, wire);
                    return;
                }
                events.push(Event::Said(format!("{what}: select it there and start it; ncfix starts nothing")));
                self.run.wait(now);
                self.ask(Step::Resting, now, wire);
            }
            (None, true) => {
                events.push(Event::Executed(self.acknowledged));
                self.ask(Step::Logout, now, wire);
            }
        }
    }

    /// Ends the job after the file was deleted, or could not be deleted.
    fn discarded(&mut self, refusal: Option<String>, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        self.has_begun = refusal.is_some();
        let of_file = match refusal {
            None => format!("the incomplete or wrong file {} was deleted", self.path),
            Some(why) => {
                format!("the incomplete or wrong file {} could not be deleted ({why}): delete it there", self.path)
            }
        };
        let why = self.why.take().unwrap_or_default();
        if why.is_empty() {
            events.push(Event::Said(of_file));
            self.ask(Step::Logout, now, wire);
        } else {
            self.step = Step::Over;
            events.push(Event::Lost(LossKind::Other, format!("{why}; {of_file}")));
        }
    }

    /// Evaluates what the control reports of the run.
    fn judge(&mut self, now: Duration, wire: &mut Wire, events: &mut Vec<Event>) {
        events.push(Event::Reported(self.seen.words()));
        match self.run.look(&self.seen, &self.path, now) {
            RunVerdict::Continues(None) => self.ask(Step::Resting, now, wire),
            RunVerdict::Continues(Some(said)) => {
                events.push(Event::Said(said));
                self.ask(Step::Resting, now, wire);
            }
            RunVerdict::Ended => self.ask(Step::Read, now, wire),
            RunVerdict::Lost(why) => self.lost(&why, events),
        }
    }
}
